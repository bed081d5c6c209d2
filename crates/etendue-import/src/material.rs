//! Materials: the file's factors brought into their ranges, its texture references resolved.

use crate::document::{self, TextureInfo};
use crate::error::Fault;
use crate::texture::Textures;
use crate::warning::Warnings;
use etendue_scene::{AlphaMode, Material, NormalTexture, TextureRef};
use glam::{Affine2, Mat2, Vec2, Vec3};

/// Reads numbers of one material, clamping them with a warning.
struct Factors<'a> {
    pointer: String,
    warnings: &'a mut Warnings,
}

impl Factors<'_> {
    fn scalar(&mut self, value: Option<f64>, default: f32, (min, max): (f32, f32), what: &str) -> f32 {
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

    fn vec3(&mut self, value: Option<[f64; 3]>, default: Vec3, range: (f32, f32), what: &str) -> Vec3 {
        let Some(v) = value else { return default };
        Vec3::from_array(v.map(|c| self.scalar(Some(c), 0.0, range, what)))
    }
}

const UNIT: (f32, f32) = (0.0, 1.0);
/// Products of two such factors stay finite.
const LARGEST: f32 = 1e18;
const POSITIVE: (f32, f32) = (0.0, LARGEST);

/// Material `index` of the file.
pub(crate) fn convert(
    index: u32,
    m: &document::Material<'_>,
    textures: &mut Textures<'_>,
    occlusion: bool,
    warnings: &mut Warnings,
) -> Result<Material, Fault> {
    let pointer = format!("/materials/{index}");
    let mut texture =
        |info: &Option<TextureInfo>, key: &str, w: &mut Warnings| -> Result<Option<TextureRef>, Fault> {
            let Some(info) = info else { return Ok(None) };
            let at = || format!("{pointer}/{key}");
            Ok(textures.get(info.index, || format!("{}/index", at()), w)?.map(|texture| TextureRef {
                texture,
                uv_set: info.tex_coord,
                transform: uv_transform(info, at, w),
            }))
        };
    let pbr = "pbrMetallicRoughness";
    let base_color_texture = texture(&m.base_color_texture, &format!("{pbr}/baseColorTexture"), warnings)?;
    let metallic_roughness_texture =
        texture(&m.metallic_roughness_texture, &format!("{pbr}/metallicRoughnessTexture"), warnings)?;
    let normal_texture = texture(&m.normal_texture, "normalTexture", warnings)?;
    let occlusion_texture =
        if occlusion { texture(&m.occlusion_texture, "occlusionTexture", warnings)? } else { None };
    let emissive_texture = texture(&m.emissive_texture, "emissiveTexture", warnings)?;
    let specular = m.specular.unwrap_or_default();
    let key = "extensions/KHR_materials_specular";
    let specular_texture = texture(&specular.texture, &format!("{key}/specularTexture"), warnings)?;
    let specular_color_texture =
        texture(&specular.color_texture, &format!("{key}/specularColorTexture"), warnings)?;

    let mut f = Factors { pointer: pointer.clone(), warnings };
    let [r, g, b, a] = m.base_color.unwrap_or([1.0; 4]);
    let emissive = f.vec3(m.emissive, Vec3::ZERO, UNIT, "emissiveFactor");
    let strength = f.scalar(m.emissive_strength, 1.0, POSITIVE, "emissiveStrength");
    let cutoff = f.scalar(m.alpha_cutoff, 0.5, (0.0, f32::MAX), "alphaCutoff");
    // 0 stands for an infinite index; between 0 and 1 nothing is defined (KHR_materials_ior).
    let ior = match m.ior {
        Some(0.0) => 0.0,
        ior => f.scalar(ior, 1.5, (1.0, f32::MAX), "ior"),
    };
    let out = Material {
        name: m.name.to_owned(),
        base_color: f.vec3(Some([r, g, b]), Vec3::ONE, UNIT, "baseColorFactor"),
        alpha: f.scalar(Some(a), 1.0, UNIT, "baseColorFactor"),
        base_color_texture,
        metallic: f.scalar(m.metallic, 1.0, UNIT, "metallicFactor"),
        roughness: f.scalar(m.roughness, 1.0, UNIT, "roughnessFactor"),
        metallic_roughness_texture,
        normal_texture: normal_texture.map(|texture| NormalTexture {
            texture,
            scale: f.scalar(m.normal_scale, 1.0, (-LARGEST, LARGEST), "normalTexture scale"),
        }),
        occlusion_texture,
        occlusion_strength: f.scalar(m.occlusion_strength, 1.0, UNIT, "occlusionTexture strength"),
        emissive: emissive * strength,
        emissive_texture,
        alpha_mode: match m.alpha_mode {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask(cutoff),
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => {
                f.warnings.add(format!("{pointer}/alphaMode"), "unknown alpha mode; taken as OPAQUE");
                AlphaMode::Opaque
            }
        },
        double_sided: m.double_sided,
        unlit: m.unlit,
        ior,
        specular: f.scalar(specular.factor, 1.0, UNIT, "specularFactor"),
        specular_texture,
        specular_color: f.vec3(specular.color, Vec3::ONE, POSITIVE, "specularColorFactor"),
        specular_color_texture,
        extensions: None,
        model: None,
    };
    Ok(out)
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
