//! Material extensions that are drafts, as the file says them. The revisions that were read stand in [`crate::drafts`].

use super::TextureInfo;
use super::material::with_factor;
use super::surface::Anisotropy;
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::{Object, Reader};

/// `KHR_materials_coat`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Coat {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub roughness: Option<f64>,
    pub roughness_texture: Option<TextureInfo>,
    pub normal_texture: Option<TextureInfo>,
    pub normal_scale: Option<f64>,
    pub ior: Option<f64>,
    pub color: Option<[f64; 3]>,
    pub color_texture: Option<TextureInfo>,
    pub darkening: Option<f64>,
    pub anisotropy: Anisotropy,
}

/// `KHR_materials_diffuse_roughness`.
#[derive(Clone, Copy, Default)]
pub(crate) struct DiffuseRoughness {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
}

/// `KHR_materials_fuzz`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Fuzz {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub color: Option<[f64; 3]>,
    pub color_texture: Option<TextureInfo>,
    pub roughness: Option<f64>,
    pub roughness_texture: Option<TextureInfo>,
}

/// `KHR_materials_scatter`, or `KHR_materials_volume_scatter`, which says less.
#[derive(Clone, Copy, Default)]
pub(crate) struct Scatter {
    pub strength: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub color: Option<[f64; 3]>,
    pub color_texture: Option<TextureInfo>,
    pub anisotropy: Option<f64>,
}

/// All of them.
#[derive(Clone, Copy, Default)]
pub(crate) struct Drafts {
    pub coat: Option<Coat>,
    pub diffuse_roughness: Option<DiffuseRoughness>,
    pub fuzz: Option<Fuzz>,
    pub scatter: Option<Scatter>,
    pub volume_scatter: Option<Scatter>,
}

impl Drafts {
    /// Reads those of the material `o`.
    pub fn read<'v>(r: &mut Reader<'v>, o: &'v Object) -> Result<Self, Fault> {
        let number = Reader::number;
        Ok(Self {
            coat: r.extension(o, ext::COAT, |r, o| {
                let (normal_texture, normal_scale) = with_factor(r, o, "coatNormalTexture", "scale")?;
                Ok(Coat {
                    factor: r.soft(o, "coatFactor", number),
                    texture: r.opt(o, "coatTexture", TextureInfo::read)?,
                    roughness: r.soft(o, "coatRoughnessFactor", number),
                    roughness_texture: r.opt(o, "coatRoughnessTexture", TextureInfo::read)?,
                    normal_texture,
                    normal_scale,
                    ior: r.soft(o, "coatIor", number),
                    color: r.soft(o, "coatColorFactor", Reader::numbers),
                    color_texture: r.opt(o, "coatColorTexture", TextureInfo::read)?,
                    darkening: r.soft(o, "coatDarkeningFactor", number),
                    anisotropy: Anisotropy {
                        strength: r.soft(o, "coatAnisotropyStrength", number),
                        rotation: r.soft(o, "coatAnisotropyRotation", number),
                        texture: r.opt(o, "coatAnisotropyTexture", TextureInfo::read)?,
                    },
                })
            })?,
            scatter: r.extension(o, ext::SCATTER, |r, o| {
                Ok(Scatter {
                    strength: r.soft(o, "scatterStrengthFactor", number),
                    texture: r.opt(o, "scatterStrengthTexture", TextureInfo::read)?,
                    color: r.soft(o, "multiscatterColorFactor", Reader::numbers),
                    color_texture: r.opt(o, "multiscatterColorTexture", TextureInfo::read)?,
                    anisotropy: r.soft(o, "scatterAnisotropy", number),
                })
            })?,
            volume_scatter: r.extension(o, ext::VOLUME_SCATTER, |r, o| {
                // The newest name first; the others are those of older revisions.
                let mut color = None;
                for name in ["multiscatterColorFactor", "multiscatterColor", "scatterAlbedo"] {
                    if color.is_none() {
                        color = r.soft(o, name, Reader::numbers);
                    }
                }
                Ok(Scatter {
                    strength: None,
                    texture: None,
                    color,
                    color_texture: r.opt(o, "multiscatterColorTexture", TextureInfo::read)?,
                    anisotropy: r.soft(o, "scatterAnisotropy", number),
                })
            })?,
            fuzz: r.extension(o, ext::FUZZ, |r, o| {
                Ok(Fuzz {
                    factor: r.soft(o, "fuzzFactor", number),
                    texture: r.opt(o, "fuzzTexture", TextureInfo::read)?,
                    color: r.soft(o, "fuzzColorFactor", Reader::numbers),
                    color_texture: r.opt(o, "fuzzColorTexture", TextureInfo::read)?,
                    roughness: r.soft(o, "fuzzRoughnessFactor", number),
                    roughness_texture: r.opt(o, "fuzzRoughnessTexture", TextureInfo::read)?,
                })
            })?,
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
        self.coat.is_none()
            && self.diffuse_roughness.is_none()
            && self.fuzz.is_none()
            && self.scatter.is_none()
            && self.volume_scatter.is_none()
    }

    /// The numbers that the file gives, by the names of `etendue info`.
    pub fn factors(&self) -> impl Iterator<Item = (&'static str, Vec<f64>)> + use<> {
        let one = |v: Option<f64>| v.map(|v| vec![v]);
        let rough = self.diffuse_roughness.unwrap_or_default();
        let (coat, fuzz) = (self.coat.unwrap_or_default(), self.fuzz.unwrap_or_default());
        let scatter = self.scatter.or(self.volume_scatter).unwrap_or_default();
        [
            ("coat", one(coat.factor)),
            ("coatRoughness", one(coat.roughness)),
            ("coatNormalScale", one(coat.normal_scale)),
            ("coatIor", one(coat.ior)),
            ("coatColor", coat.color.map(Vec::from)),
            ("coatDarkening", one(coat.darkening)),
            ("coatAnisotropy", one(coat.anisotropy.strength)),
            ("coatAnisotropyRotation", one(coat.anisotropy.rotation)),
            ("diffuseRoughness", one(rough.factor)),
            ("fuzz", one(fuzz.factor)),
            ("fuzzColor", fuzz.color.map(Vec::from)),
            ("fuzzRoughness", one(fuzz.roughness)),
            ("scatterStrength", one(scatter.strength)),
            ("multiscatterColor", scatter.color.map(Vec::from)),
            ("scatterAnisotropy", one(scatter.anisotropy)),
        ]
        .into_iter()
        .filter_map(|(k, v)| Some((k, v?)))
    }

    /// The textures that the file gives, by the names of `etendue info`.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, TextureInfo)> + use<> {
        let rough = self.diffuse_roughness.unwrap_or_default();
        let (coat, fuzz) = (self.coat.unwrap_or_default(), self.fuzz.unwrap_or_default());
        let scatter = self.scatter.or(self.volume_scatter).unwrap_or_default();
        [
            ("coat", coat.texture),
            ("coatRoughness", coat.roughness_texture),
            ("coatNormal", coat.normal_texture),
            ("coatColor", coat.color_texture),
            ("coatAnisotropy", coat.anisotropy.texture),
            ("diffuseRoughness", rough.texture),
            ("fuzz", fuzz.texture),
            ("fuzzColor", fuzz.color_texture),
            ("fuzzRoughness", fuzz.roughness_texture),
            ("scatterStrength", scatter.texture),
            ("multiscatterColor", scatter.color_texture),
        ]
        .into_iter()
        .filter_map(|(k, t)| Some((k, t?)))
    }
}
