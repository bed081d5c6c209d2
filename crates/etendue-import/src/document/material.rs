//! `materials`, `textures`, `images`, `samplers`.

use super::{Surface, name};
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::{Object, Reader};
use serde_json::Value;

/// A material's use of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TextureInfo {
    pub index: u32,
    /// UV set; `KHR_texture_transform` may have overridden it.
    pub tex_coord: u32,
    /// `KHR_texture_transform`.
    pub offset: [f64; 2],
    /// Radians, counter-clockwise.
    pub rotation: f64,
    pub scale: [f64; 2],
}

impl TextureInfo {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        let mut t = Self {
            index: r.req(o, "index", Reader::index)?,
            tex_coord: r.opt(o, "texCoord", Reader::index)?.unwrap_or(0),
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
        };
        r.extension(o, ext::TEXTURE_TRANSFORM, |r, o| {
            t.offset = r.soft(o, "offset", Reader::numbers).unwrap_or(t.offset);
            t.rotation = r.soft(o, "rotation", Reader::number).unwrap_or(t.rotation);
            t.scale = r.soft(o, "scale", Reader::numbers).unwrap_or(t.scale);
            t.tex_coord = r.opt(o, "texCoord", Reader::index)?.unwrap_or(t.tex_coord);
            Ok(())
        })?;
        r.other_extensions(o, &[ext::TEXTURE_TRANSFORM]);
        Ok(t)
    }
}

/// `KHR_materials_specular`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SpecularExt {
    pub factor: Option<f64>,
    pub texture: Option<TextureInfo>,
    pub color: Option<[f64; 3]>,
    pub color_texture: Option<TextureInfo>,
}

/// A surface, as the file says it: nothing clamped, nothing defaulted.
#[derive(Default)]
pub(crate) struct Material<'v> {
    pub name: &'v str,
    pub base_color: Option<[f64; 4]>,
    pub base_color_texture: Option<TextureInfo>,
    pub metallic: Option<f64>,
    pub roughness: Option<f64>,
    pub metallic_roughness_texture: Option<TextureInfo>,
    pub normal_texture: Option<TextureInfo>,
    pub normal_scale: Option<f64>,
    pub occlusion_texture: Option<TextureInfo>,
    pub occlusion_strength: Option<f64>,
    pub emissive: Option<[f64; 3]>,
    pub emissive_texture: Option<TextureInfo>,
    pub emissive_strength: Option<f64>,
    pub alpha_mode: Option<&'v str>,
    pub alpha_cutoff: Option<f64>,
    pub double_sided: bool,
    pub unlit: bool,
    pub ior: Option<f64>,
    pub specular: Option<SpecularExt>,
    /// What other extensions say of the surface.
    pub surface: Option<Box<Surface>>,
}

impl<'v> Material<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &ext::ON_MATERIAL);
        let mut m = Self { name: name(r, o), ..Self::default() };
        r.opt(o, "pbrMetallicRoughness", |r, v| {
            let o = r.object(v)?;
            m.base_color = r.soft(o, "baseColorFactor", Reader::numbers);
            m.base_color_texture = r.opt(o, "baseColorTexture", TextureInfo::read)?;
            m.metallic = r.soft(o, "metallicFactor", Reader::number);
            m.roughness = r.soft(o, "roughnessFactor", Reader::number);
            m.metallic_roughness_texture = r.opt(o, "metallicRoughnessTexture", TextureInfo::read)?;
            Ok(())
        })?;
        (m.normal_texture, m.normal_scale) = with_factor(r, o, "normalTexture", "scale")?;
        (m.occlusion_texture, m.occlusion_strength) = with_factor(r, o, "occlusionTexture", "strength")?;
        m.emissive = r.soft(o, "emissiveFactor", Reader::numbers);
        m.emissive_texture = r.opt(o, "emissiveTexture", TextureInfo::read)?;
        m.alpha_mode = r.soft(o, "alphaMode", Reader::string);
        m.alpha_cutoff = r.soft(o, "alphaCutoff", Reader::number);
        m.double_sided = r.soft(o, "doubleSided", Reader::boolean).unwrap_or(false);
        m.unlit = r.extension(o, ext::UNLIT, |_, _| Ok(()))?.is_some();
        m.emissive_strength = r
            .extension(o, ext::EMISSIVE_STRENGTH, |r, o| Ok(r.soft(o, "emissiveStrength", Reader::number)))?
            .flatten();
        m.ior = r.extension(o, ext::IOR, |r, o| Ok(r.soft(o, "ior", Reader::number)))?.flatten();
        m.specular = r.extension(o, ext::SPECULAR, |r, o| {
            Ok(SpecularExt {
                factor: r.soft(o, "specularFactor", Reader::number),
                texture: r.opt(o, "specularTexture", TextureInfo::read)?,
                color: r.soft(o, "specularColorFactor", Reader::numbers),
                color_texture: r.opt(o, "specularColorTexture", TextureInfo::read)?,
            })
        })?;
        m.surface = Surface::read(r, o)?;
        Ok(m)
    }
}

/// A texture that carries a number beside it.
pub(super) fn with_factor<'v>(
    r: &mut Reader<'v>,
    o: &'v Object,
    key: &'static str,
    factor: &'static str,
) -> Result<(Option<TextureInfo>, Option<f64>), Fault> {
    let both = r.opt(o, key, |r, v| {
        let t = TextureInfo::read(r, v)?;
        let o = r.object(v)?;
        Ok((t, r.soft(o, factor, Reader::number)))
    })?;
    Ok(both.map_or((None, None), |(t, f)| (Some(t), f)))
}

/// An image with its sampler.
pub(crate) struct Texture {
    pub sampler: Option<u32>,
    /// The image to use: that of `EXT_texture_webp` or `KHR_texture_basisu` if there is one.
    pub source: Option<u32>,
    /// Whether an unsupported extension holds another image of it.
    pub other_source: bool,
}

impl Texture {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        let webp = r.extension(o, ext::TEXTURE_WEBP, |r, o| r.opt(o, "source", Reader::index))?;
        let basisu = r.extension(o, ext::TEXTURE_BASISU, |r, o| r.opt(o, "source", Reader::index))?;
        r.other_extensions(o, &[ext::TEXTURE_BASISU, ext::TEXTURE_WEBP]);
        let plain = r.opt(o, "source", Reader::index)?;
        Ok(Self {
            sampler: r.opt(o, "sampler", Reader::index)?,
            source: webp.flatten().or(basisu.flatten()).or(plain),
            other_source: matches!(o.get("extensions"), Some(Value::Object(e)) if !e.is_empty()),
        })
    }
}

/// Where a picture's bytes are.
pub(crate) struct Image<'v> {
    pub name: &'v str,
    pub uri: Option<&'v str>,
    /// The format is told by the bytes themselves; `mimeType` is not read.
    pub buffer_view: Option<u32>,
}

impl<'v> Image<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        Ok(Self {
            name: name(r, o),
            uri: r.opt(o, "uri", Reader::string)?,
            buffer_view: r.opt(o, "bufferView", Reader::index)?,
        })
    }
}

/// Filter and wrap modes as GL constants, unchecked.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sampler {
    pub mag_filter: Option<u64>,
    pub wrap_s: Option<u64>,
    pub wrap_t: Option<u64>,
}

impl Sampler {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        // minFilter is not read: the renderer integrates over the pixel and keeps no mips.
        Ok(Self {
            mag_filter: r.soft(o, "magFilter", Reader::count),
            wrap_s: r.soft(o, "wrapS", Reader::count),
            wrap_t: r.soft(o, "wrapT", Reader::count),
        })
    }
}
