//! Material extensions that are drafts, as the file says them. The revisions that were read stand in [`crate::drafts`].

use super::TextureInfo;
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::{Object, Reader};

/// `KHR_materials_diffuse_roughness`.
#[derive(Clone, Copy, Default)]
pub(crate) struct DiffuseRoughness {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
}

/// All of them.
#[derive(Clone, Copy, Default)]
pub(crate) struct Drafts {
    pub diffuse_roughness: Option<DiffuseRoughness>,
}

impl Drafts {
    /// Reads those of the material `o`.
    pub fn read<'v>(r: &mut Reader<'v>, o: &'v Object) -> Result<Self, Fault> {
        let number = Reader::number;
        Ok(Self {
            diffuse_roughness: r.extension(o, ext::DIFFUSE_ROUGHNESS, |r, o| {
                Ok(DiffuseRoughness {
                    factor: r.soft(o, "diffuseRoughnessFactor", number),
                    texture: r.opt(o, "diffuseRoughnessTexture", TextureInfo::read)?,
                })
            })?,
        })
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.diffuse_roughness.is_none()
    }

    /// The numbers that the file gives, by the names of `etendue info`.
    pub fn factors(&self) -> impl Iterator<Item = (&'static str, Vec<f64>)> + use<> {
        let one = |v: Option<f64>| v.map(|v| vec![v]);
        let rough = self.diffuse_roughness.unwrap_or_default();
        [("diffuseRoughness", one(rough.factor))].into_iter().filter_map(|(k, v)| Some((k, v?)))
    }

    /// The textures that the file gives, by the names of `etendue info`.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, TextureInfo)> + use<> {
        let rough = self.diffuse_roughness.unwrap_or_default();
        [("diffuseRoughness", rough.texture)].into_iter().filter_map(|(k, t)| Some((k, t?)))
    }
}
