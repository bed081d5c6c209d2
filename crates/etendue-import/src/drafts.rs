//! Material extensions that are drafts: ranges, defaults, and which of them say anything.
//!
//! They may still change. What is read is what the drafts said on 2026-11-22:
//!
//! | extension | pull request at KhronosGroup/glTF | revision |
//! |---|---|---|
//! | `KHR_materials_coat` | 2534 | ac989f7a |
//! | `KHR_materials_diffuse_roughness` | 2481 | 95c4f0db |
//! | `KHR_materials_fuzz` | 2538 | b714616c |
//! | `KHR_materials_scatter` | 2579 | 0addbb0a |
//! | `KHR_materials_volume_scatter` | 2453 | 4608553d |
//!
//! Where they contradict themselves: a coat that covers a part of the surface absorbs and darkens in that part (by `coatFactor` 0
//! nothing, as the text says and its formula does not); `fuzzRoughnessFactor` is 0.5 by default, as the text says and the schema
//! does not. `coatIor` 0 is allowed and not explained; it is taken as infinite, as `KHR_materials_ior` has it. What shines below a
//! coat crosses it once and not twice: it is multiplied by the square root of the coat's colour, at the length of its path.
//!
//! `KHR_materials_scatter` is the successor of `KHR_materials_volume_scatter` and goes before it. Of the older one the newer name
//! `multiscatterColorFactor` is read, and the older `multiscatterColor` and `scatterAlbedo`. The single-scattering albedo is that of
//! the successor's text, which is Kulla and Conty's whole formula; the older one leaves out the anisotropy, so that a deep body would
//! have another colour than the file says. A textured colour or strength makes of one volume many: what counts is the place where
//! light (followed from the camera) enters. The successor needs `KHR_materials_transmission` and excludes
//! `KHR_materials_diffuse_transmission`, beside which it is ignored; the older one goes with both.

use crate::document::drafts;
use crate::error::Fault;
use crate::extensions as ext;
use crate::material::{LARGEST, Parts, UNIT};
use crate::surface;
use etendue_scene::{Clearcoat, DiffuseRoughness, Extensions, Fuzz, Scatter};
use glam::Vec3;

/// Adds to `out` what the drafts of the material say to whose JSON `p` points; `p` points elsewhere afterwards.
pub(crate) fn convert(d: &drafts::Drafts, out: &mut Extensions, p: &mut Parts<'_, '_>) -> Result<(), Fault> {
    let material = p.pointer.clone();
    let at = |p: &mut Parts<'_, '_>, name: &str| p.pointer = format!("{material}/extensions/{name}");
    // A coat and fuzz stand in for a clearcoat and sheen, which are there for readers that do not know them.
    if let Some(e) = d.coat {
        at(p, ext::COAT);
        out.clearcoat = coat(&e, p)?;
    }
    if let Some(e) = d.fuzz {
        at(p, ext::FUZZ);
        out.fuzz = fuzz(&e, p)?;
    }
    // Nothing is scattered where no light gets.
    if let Some(e) = d.scatter {
        at(p, ext::SCATTER);
        let strength = p.scalar(e.strength, 0.0, UNIT, "scatterStrengthFactor");
        if strength > 0.0 && out.diffuse_transmission.is_some() {
            let place = p.pointer.clone();
            p.warnings
                .add(place, "stands beside KHR_materials_diffuse_transmission, which excludes it; ignored");
        } else if strength > 0.0 && out.transmission.is_some() {
            out.scatter = Some(scatter(&e, strength, Vec3::ONE, p)?);
        }
    } else if let Some(e) = d.volume_scatter.filter(|_| out.volume.is_some()) {
        at(p, ext::VOLUME_SCATTER);
        out.scatter = Some(scatter(&e, 1.0, Vec3::ZERO, p)?).filter(|s| s.color != Vec3::ZERO);
    }
    if let Some(e) = d.diffuse_roughness {
        at(p, ext::DIFFUSE_ROUGHNESS);
        out.diffuse_roughness = diffuse_roughness(&e, p)?;
    }
    Ok(())
}

fn diffuse_roughness(
    e: &drafts::DiffuseRoughness,
    p: &mut Parts<'_, '_>,
) -> Result<Option<DiffuseRoughness>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "diffuseRoughnessFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    Ok(Some(DiffuseRoughness { factor, texture: p.texture(e.texture, "diffuseRoughnessTexture")? }))
}

fn coat(e: &drafts::Coat, p: &mut Parts<'_, '_>) -> Result<Option<Clearcoat>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "coatFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    Ok(Some(Clearcoat {
        factor,
        texture: p.texture(e.texture, "coatTexture")?,
        roughness: p.scalar(e.roughness, 0.0, UNIT, "coatRoughnessFactor"),
        roughness_texture: p.texture(e.roughness_texture, "coatRoughnessTexture")?,
        normal_texture: p.normal_texture(e.normal_texture, e.normal_scale, "coatNormalTexture")?,
        ior: match e.ior {
            Some(0.0) => 0.0,
            ior => p.scalar(ior, 1.5, (1.0, LARGEST), "coatIor"),
        },
        color: p.vec3(e.color, Vec3::ONE, UNIT, "coatColorFactor"),
        color_texture: p.texture(e.color_texture, "coatColorTexture")?,
        darkening: p.scalar(e.darkening, 1.0, UNIT, "coatDarkeningFactor"),
        anisotropy: surface::anisotropy(&e.anisotropy, "coatAnisotropy", p)?.unwrap_or_default(),
    }))
}

fn fuzz(e: &drafts::Fuzz, p: &mut Parts<'_, '_>) -> Result<Option<Fuzz>, Fault> {
    let factor = p.scalar(e.factor, 0.0, UNIT, "fuzzFactor");
    if factor == 0.0 {
        return Ok(None);
    }
    Ok(Some(Fuzz {
        factor,
        texture: p.texture(e.texture, "fuzzTexture")?,
        color: p.vec3(e.color, Vec3::ONE, UNIT, "fuzzColorFactor"),
        color_texture: p.texture(e.color_texture, "fuzzColorTexture")?,
        roughness: p.scalar(e.roughness, 0.5, UNIT, "fuzzRoughnessFactor"),
        roughness_texture: p.texture(e.roughness_texture, "fuzzRoughnessTexture")?,
    }))
}

/// What scatters with a strength; `color` is the default.
fn scatter(e: &drafts::Scatter, strength: f32, color: Vec3, p: &mut Parts<'_, '_>) -> Result<Scatter, Fault> {
    let color = p.vec3(e.color, color, UNIT, "multiscatterColorFactor");
    // What is black whatever its textures say needs none.
    let used = color != Vec3::ZERO;
    Ok(Scatter {
        strength,
        texture: p.texture(e.texture, "scatterStrengthTexture")?,
        color,
        color_texture: p.texture(e.color_texture.filter(|_| used), "multiscatterColorTexture")?,
        anisotropy: p.scalar(e.anisotropy, 0.0, (-1.0, 1.0), "scatterAnisotropy"),
    })
}
