//! The material extensions of `etendue_scene::Extensions`: ranges, defaults, and which of them say anything.
//!
//! An extension whose factors make it do nothing is left out, and its textures are not loaded: exporters write neutral
//! ones for every material.

use crate::document::{self, Surface};
use crate::drafts;
use crate::error::Fault;
use crate::extensions as ext;
use crate::material::{Base, LARGEST, POSITIVE, Parts, UNIT};
use etendue_scene::{
    Anisotropy, Clearcoat, DiffuseTransmission, Extensions, Iridescence, Sheen, SpecularGlossiness,
    Transmission, Volume,
};
use glam::Vec3;
use std::f64::consts::TAU;

/// What the extensions make of a material.
#[derive(Default)]
pub(crate) struct Converted {
    /// Stands in for `pbrMetallicRoughness`.
    pub base: Option<Base>,
    /// `None` if no extension does anything.
    pub extensions: Option<Box<Extensions>>,
}

/// The extensions of material `m`, to whose JSON `p` points; `p` points elsewhere afterwards. `thickness` says whether
/// thickness textures are loaded.
pub(crate) fn convert(
    m: &document::Material<'_>,
    thickness: bool,
    p: &mut Parts<'_, '_>,
) -> Result<Converted, Fault> {
    let Some(s) = m.surface.as_deref() else { return Ok(Converted::default()) };
    let material = p.pointer.clone();
    if m.unlit {
        p.warnings.add(
            format!("{material}/extensions"),
            "extensions of lit surfaces stand beside KHR_materials_unlit, which excludes them; ignored",
        );
        return Ok(Converted::default());
    }
    let at = |p: &mut Parts<'_, '_>, name: &str| p.pointer = format!("{material}/extensions/{name}");
    if let Some(e) = s.specular_glossiness {
        if s.excluded_by_specular_glossiness() {
            p.warnings.add(
                format!("{material}/extensions"),
                "other extensions stand beside KHR_materials_pbrSpecularGlossiness, which excludes them; ignored",
            );
        }
        at(p, ext::SPECULAR_GLOSSINESS);
        let (base, gloss) = specular_glossiness(&e, p)?;
        let extensions = Extensions { specular_glossiness: Some(gloss), ..Extensions::default() };
        return Ok(Converted { base: Some(base), extensions: Some(Box::new(extensions)) });
    }

    let mut out = Extensions::default();
    if let Some(e) = s.anisotropy {
        at(p, ext::ANISOTROPY);
        out.anisotropy = anisotropy(&e, "anisotropy", p)?;
    }
    if let Some(e) = s.clearcoat.filter(|_| s.drafts.coat.is_none()) {
        at(p, ext::CLEARCOAT);
        out.clearcoat = clearcoat(&e, p)?;
    }
    if let Some(e) = s.diffuse_transmission {
        at(p, ext::DIFFUSE_TRANSMISSION);
        out.diffuse_transmission = diffuse_transmission(&e, p)?;
    }
    if let Some(e) = s.iridescence {
        at(p, ext::IRIDESCENCE);
        out.iridescence = iridescence(&e, p)?;
    }
    if let Some(e) = s.sheen.filter(|_| s.drafts.fuzz.is_none()) {
        at(p, ext::SHEEN);
        out.sheen = sheen(&e, p)?;
    }
    if let Some(e) = s.transmission {
        at(p, ext::TRANSMISSION);
        out.transmission = transmission(&e, p)?;
    }
    // Without a way in there is no light inside.
    let lets_light_in = out.transmission.is_some() || out.diffuse_transmission.is_some();
    if let Some(e) = s.volume {
        at(p, ext::VOLUME);
        let volume = volume(&e, thickness && lets_light_in, p)?;
        out.volume = volume.filter(|_| lets_light_in);
    }
    if let Some(e) = s.dispersion {
        at(p, ext::DISPERSION);
        let dispersion = p.scalar(Some(e), 0.0, POSITIVE, "dispersion");
        // Only what is refracted into a volume is spread: a thin sheet does not bend light.
        if out.volume.is_some() && out.transmission.is_some() {
            out.dispersion = dispersion;
        }
    }
    p.pointer = material;
    drafts::convert(&s.drafts, &mut out, p)?;
    let extensions = (out != Extensions::default()).then(|| Box::new(out));
    Ok(Converted { base: None, extensions })
}

/// The anisotropy of the lobe whose properties begin with `name`.
pub(crate) fn anisotropy(
    e: &document::surface::Anisotropy,
    name: &str,
    p: &mut Parts<'_, '_>,
) -> Result<Option<Anisotropy>, Fault> {
    let strength = p.scalar(e.strength, 0.0, UNIT, &format!("{name}Strength"));
    if strength == 0.0 {
        return Ok(None);
    }
    let rotation = e.rotation.unwrap_or(0.0);
    // In double precision: of many turns single precision would keep little of the angle.
    let rotation = if rotation.abs() <= TAU { rotation } else { rotation % TAU };
    let texture = p.texture(e.texture, &format!("{name}Texture"))?;
    Ok(Some(Anisotropy { strength, rotation: rotation as f32, texture }))
}

fn clearcoat(e: &document::surface::Clearcoat, p: &mut Parts<'_, '_>) -> Result<Option<Clearcoat>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "clearcoatFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    Ok(Some(Clearcoat {
        factor,
        texture: p.texture(e.texture, "clearcoatTexture")?,
        roughness: p.scalar(e.roughness, 0.0, UNIT, "clearcoatRoughnessFactor"),
        roughness_texture: p.texture(e.roughness_texture, "clearcoatRoughnessTexture")?,
        normal_texture: p.normal_texture(e.normal_texture, e.normal_scale, "clearcoatNormalTexture")?,
        ..Clearcoat::default()
    }))
}

fn diffuse_transmission(
    e: &document::surface::DiffuseTransmission,
    p: &mut Parts<'_, '_>,
) -> Result<Option<DiffuseTransmission>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "diffuseTransmissionFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    Ok(Some(DiffuseTransmission {
        factor,
        texture: p.texture(e.texture, "diffuseTransmissionTexture")?,
        color: p.vec3(e.color, Vec3::ONE, UNIT, "diffuseTransmissionColorFactor"),
        color_texture: p.texture(e.color_texture, "diffuseTransmissionColorTexture")?,
    }))
}

fn iridescence(
    e: &document::surface::Iridescence,
    p: &mut Parts<'_, '_>,
) -> Result<Option<Iridescence>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "iridescenceFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    let [thin, thick] = Iridescence::default().thickness;
    Ok(Some(Iridescence {
        factor,
        texture: p.texture(e.texture, "iridescenceTexture")?,
        ior: p.scalar(e.ior, Iridescence::default().ior, (1.0, LARGEST), "iridescenceIor"),
        // The minimum may be the larger one: a texture is then read the other way round.
        thickness: [
            p.scalar(e.thickness_minimum, thin, POSITIVE, "iridescenceThicknessMinimum"),
            p.scalar(e.thickness_maximum, thick, POSITIVE, "iridescenceThicknessMaximum"),
        ],
        thickness_texture: p.texture(e.thickness_texture, "iridescenceThicknessTexture")?,
    }))
}

fn sheen(e: &document::surface::Sheen, p: &mut Parts<'_, '_>) -> Result<Option<Sheen>, Fault> {
    let color = p.vec3(e.color, Vec3::ZERO, UNIT, "sheenColorFactor");
    if color == Vec3::ZERO {
        return Ok(None);
    }
    Ok(Some(Sheen {
        color,
        color_texture: p.texture(e.color_texture, "sheenColorTexture")?,
        roughness: p.scalar(e.roughness, 0.0, UNIT, "sheenRoughnessFactor"),
        roughness_texture: p.texture(e.roughness_texture, "sheenRoughnessTexture")?,
    }))
}

fn specular_glossiness(
    e: &document::surface::SpecularGlossiness,
    p: &mut Parts<'_, '_>,
) -> Result<(Base, SpecularGlossiness), Fault> {
    let [r, g, b, a] = e.diffuse.unwrap_or([1.0; 4]);
    let gloss = SpecularGlossiness {
        specular: p.vec3(e.specular, Vec3::ONE, UNIT, "specularFactor"),
        glossiness: p.scalar(e.glossiness, 1.0, UNIT, "glossinessFactor"),
        texture: p.texture(e.texture, "specularGlossinessTexture")?,
    };
    let base = Base {
        color: p.vec3(Some([r, g, b]), Vec3::ONE, UNIT, "diffuseFactor"),
        alpha: p.scalar(Some(a), 1.0, UNIT, "diffuseFactor"),
        color_texture: p.texture(e.diffuse_texture, "diffuseTexture")?,
        metallic: 0.0,
        roughness: 1.0 - gloss.glossiness,
        metallic_roughness_texture: None,
    };
    Ok((base, gloss))
}

fn transmission(
    e: &document::surface::Transmission,
    p: &mut Parts<'_, '_>,
) -> Result<Option<Transmission>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "transmissionFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    Ok(Some(Transmission { factor, texture: p.texture(e.texture, "transmissionTexture")? }))
}

fn volume(
    e: &document::surface::Volume,
    texture: bool,
    p: &mut Parts<'_, '_>,
) -> Result<Option<Volume>, Fault> {
    let thickness = p.scalar(e.thickness, 0.0, POSITIVE, "thicknessFactor");
    if thickness == 0.0 {
        return Ok(None);
    }
    let attenuation_distance = match e.attenuation_distance {
        Some(d) if d <= 0.0 => {
            // Older exporters write 0 for a clear volume.
            p.warnings.add(&p.pointer, "attenuationDistance is not above 0; taken as infinite");
            f32::INFINITY
        }
        Some(d) => (d as f32).max(1.0 / LARGEST),
        None => f32::INFINITY,
    };
    Ok(Some(Volume {
        thickness,
        thickness_texture: if texture { p.texture(e.thickness_texture, "thicknessTexture")? } else { None },
        attenuation_distance,
        attenuation_color: p.vec3(e.attenuation_color, Vec3::ONE, UNIT, "attenuationColor"),
    }))
}

impl Surface {
    /// Whether there are extensions that must not stand beside `KHR_materials_pbrSpecularGlossiness`.
    fn excluded_by_specular_glossiness(&self) -> bool {
        self.anisotropy.is_some()
            || self.clearcoat.is_some()
            || self.diffuse_transmission.is_some()
            || self.dispersion.is_some()
            || self.iridescence.is_some()
            || self.sheen.is_some()
            || self.transmission.is_some()
            || self.volume.is_some()
            || !self.drafts.is_empty()
    }
}
