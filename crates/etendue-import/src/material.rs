//! Materials: the file's factors brought into their ranges, its texture references resolved.

use crate::document::{self, TextureInfo};
use crate::error::Fault;
use crate::surface;
use crate::texture::Textures;
use crate::warning::Warnings;

use etendue_scene::{AlphaMode, Material, NormalTexture, TextureRef};
use glam::{Affine2, Mat2, Vec2, Vec3};

/// Reads one material: numbers are clamped with a warning, textures are looked up.
pub(crate) struct Parts<'a, 'd> {
    /// JSON pointer to the object that is read.
    pub pointer: String,
    pub textures: &'a mut Textures<'d>,
    pub warnings: &'a mut Warnings,
}

impl Parts<'_, '_> {
    /// `value`, or else `default`, brought between `min` and `max`.
    pub fn scalar(&mut self, value: Option<f64>, default: f32, (min, max): (f32, f32), what: &str) -> f32 {
        let Some(v) = value else { return default };
        let v = v as f32;
        let c = v.clamp(min, max);
        if c != v {
            let range =
                if max == f32::MAX { format!("below {min}") } else { format!("outside {min}..{max}") };
            self.warnings.add(&self.pointer, format!("{what} {range}; clamped"));
        }
        c
    }

    /// As [`Self::scalar`], for each component.
    pub fn vec3(&mut self, value: Option<[f64; 3]>, default: Vec3, range: (f32, f32), what: &str) -> Vec3 {
        let Some(v) = value else { return default };
        Vec3::from_array(v.map(|c| self.scalar(Some(c), 0.0, range, what)))
    }

    /// The texture at `key`; `None`, with a warning, if it has no image that can be read.
    pub fn texture(&mut self, info: Option<TextureInfo>, key: &str) -> Result<Option<TextureRef>, Fault> {
        let Some(info) = info else { return Ok(None) };
        let at = || format!("{}/{key}", self.pointer);
        let found = self.textures.get(info.index, || format!("{}/index", at()), self.warnings)?;
        Ok(found.map(|texture| TextureRef {
            texture,
            uv_set: info.tex_coord,
            transform: uv_transform(&info, at, self.warnings),
        }))
    }

    /// The normal texture at `key`.
    pub fn normal_texture(
        &mut self,
        info: Option<TextureInfo>,
        scale: Option<f64>,
        key: &str,
    ) -> Result<Option<NormalTexture>, Fault> {
        let texture = self.texture(info, key)?;
        Ok(texture.map(|texture| NormalTexture {
            texture,
            scale: self.scalar(scale, 1.0, (-LARGEST, LARGEST), &format!("{key} scale")),
        }))
    }
}

/// The range of a part of something.
pub(crate) const UNIT: (f32, f32) = (0.0, 1.0);
/// Products of two such factors stay finite.
pub(crate) const LARGEST: f32 = 1e18;
/// The range of an amount.
pub(crate) const POSITIVE: (f32, f32) = (0.0, LARGEST);

/// Material `index` of the file. `occlusion` is [`crate::ImportOptions::occlusion`].
pub(crate) fn convert(
    index: u32,
    m: &document::Material<'_>,
    textures: &mut Textures<'_>,
    occlusion: bool,
    warnings: &mut Warnings,
) -> Result<Material, Fault> {
    let pointer = format!("/materials/{index}");
    let mut p = Parts { pointer: pointer.clone(), textures, warnings };
    let surface = surface::convert(m, occlusion, &mut p)?;
    p.pointer.clone_from(&pointer);
    let base = match surface.base {
        Some(base) => base,
        None => {
            p.pointer.push_str("/pbrMetallicRoughness");
            let [r, g, b, a] = m.base_color.unwrap_or([1.0; 4]);
            let base = Base {
                color: p.vec3(Some([r, g, b]), Vec3::ONE, UNIT, "baseColorFactor"),
                alpha: p.scalar(Some(a), 1.0, UNIT, "baseColorFactor"),
                color_texture: p.texture(m.base_color_texture, "baseColorTexture")?,
                metallic: p.scalar(m.metallic, 1.0, UNIT, "metallicFactor"),
                roughness: p.scalar(m.roughness, 1.0, UNIT, "roughnessFactor"),
                metallic_roughness_texture: p
                    .texture(m.metallic_roughness_texture, "metallicRoughnessTexture")?,
            };
            p.pointer.clone_from(&pointer);
            base
        }
    };
    let normal_texture = p.normal_texture(m.normal_texture, m.normal_scale, "normalTexture")?;
    let occlusion_texture =
        if occlusion { p.texture(m.occlusion_texture, "occlusionTexture")? } else { None };
    let emissive_texture = p.texture(m.emissive_texture, "emissiveTexture")?;
    let specular = m.specular.unwrap_or_default();
    let key = "extensions/KHR_materials_specular";
    let specular_texture = p.texture(specular.texture, &format!("{key}/specularTexture"))?;
    let specular_color_texture = p.texture(specular.color_texture, &format!("{key}/specularColorTexture"))?;

    let emissive = p.vec3(m.emissive, Vec3::ZERO, UNIT, "emissiveFactor");
    let strength = p.scalar(m.emissive_strength, 1.0, POSITIVE, "emissiveStrength");
    let cutoff = p.scalar(m.alpha_cutoff, 0.5, (0.0, f32::MAX), "alphaCutoff");
    // 0 stands for an infinite index; between 0 and 1 nothing is defined (KHR_materials_ior).
    let ior = match m.ior {
        Some(0.0) => 0.0,
        ior => p.scalar(ior, 1.5, (1.0, f32::MAX), "ior"),
    };
    let out = Material {
        name: m.name.to_owned(),
        base_color: base.color,
        alpha: base.alpha,
        base_color_texture: base.color_texture,
        metallic: base.metallic,
        roughness: base.roughness,
        metallic_roughness_texture: base.metallic_roughness_texture,
        normal_texture,
        occlusion_texture,
        occlusion_strength: p.scalar(m.occlusion_strength, 1.0, UNIT, "occlusionTexture strength"),
        emissive: emissive * strength,
        emissive_texture,
        alpha_mode: match m.alpha_mode {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask(cutoff),
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => {
                p.warnings.add(format!("{pointer}/alphaMode"), "unknown alpha mode; taken as OPAQUE");
                AlphaMode::Opaque
            }
        },
        double_sided: m.double_sided,
        unlit: m.unlit,
        ior,
        specular: p.scalar(specular.factor, 1.0, UNIT, "specularFactor"),
        specular_texture,
        specular_color: p.vec3(specular.color, Vec3::ONE, POSITIVE, "specularColorFactor"),
        specular_color_texture,
        compensation: Default::default(),
        extensions: surface.extensions,
        substitute: None,
    };
    Ok(out)
}

/// What `pbrMetallicRoughness` says, or the workflow that stands in for it.
pub(crate) struct Base {
    pub color: Vec3,
    pub alpha: f32,
    pub color_texture: Option<TextureRef>,
    pub metallic: f32,
    pub roughness: f32,
    pub metallic_roughness_texture: Option<TextureRef>,
}

/// `KHR_texture_transform` as one matrix: scale, then rotation, then offset. The rotation is counter-clockwise as seen
/// on the picture, whose v axis points down.
pub(crate) fn uv_transform(
    t: &TextureInfo,
    pointer: impl Fn() -> String,
    warnings: &mut Warnings,
) -> Affine2 {
    let (s, c) = (t.rotation.sin() as f32, t.rotation.cos() as f32);
    let [x, y] = t.scale.map(|v| v as f32);
    let m = Affine2 {
        matrix2: Mat2::from_cols(Vec2::new(c, -s) * x, Vec2::new(s, c) * y),
        translation: Vec2::from_array(t.offset.map(|v| v as f32)),
    };
    if m.is_finite() {
        m
    } else {
        warnings.add(pointer(), "the texture transform is not finite; ignored");
        Affine2::IDENTITY
    }
}
