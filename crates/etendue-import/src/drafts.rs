//! Material extensions that are drafts: ranges, defaults, and which of them say anything.
//!
//! They may still change. What is read is what the drafts said on 2026-11-22:
//!
//! | extension | pull request at KhronosGroup/glTF | revision |
//! |---|---|---|
//! | `KHR_materials_coat` | 2534 | ac989f7a |
//! | `KHR_materials_diffuse_roughness` | 2481 | 95c4f0db |
//! | `KHR_materials_fuzz` | 2538 | b714616c |
//! | `KHR_materials_volume_scatter` | 2453 | 4608553d |
//!
//! Where they contradict themselves: a coat that covers a part of the surface absorbs and darkens in that part (by `coatFactor` 0
//! nothing, as the text says and its formula does not); `fuzzRoughnessFactor` is 0.5 by default, as the text says and the schema
//! does not. `coatIor` 0 is allowed and not explained; it is taken as infinite, as `KHR_materials_ior` has it. What shines below a
//! coat crosses it once and not twice: it is multiplied by the square root of the coat's colour, at the length of its path.
//!
//! Of `KHR_materials_volume_scatter` the newer name `multiscatterColorFactor` is read, and the older `multiscatterColor` and
//! `scatterAlbedo`. The single-scattering albedo is that of its successor's text (`KHR_materials_scatter`, pull request 2579, revision
//! 0addbb0a), which is Kulla and Conty's whole formula; the older one leaves out the anisotropy, so that a deep body would have
//! another colour than the file says. `multiscatterColorTexture` would make one volume many and is not read, with a warning.
//! `KHR_materials_scatter` itself is not known.

use crate::document::drafts;
use crate::error::Fault;
use crate::extensions as ext;
use crate::material::{LARGEST, Parts, UNIT};
use crate::surface;
use etendue_scene::{Clearcoat, DiffuseRoughness, Extensions, Fuzz, VolumeScatter};
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
    // Without an inside nothing is scattered in it.
    if let Some(e) = d.volume_scatter.filter(|_| out.volume.is_some()) {
        at(p, ext::VOLUME_SCATTER);
        out.volume_scatter = volume_scatter(&e, p);
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

fn volume_scatter(e: &drafts::VolumeScatter, p: &mut Parts<'_, '_>) -> Option<VolumeScatter> {
    let color = p.vec3(e.color, Vec3::ZERO, UNIT, "multiscatterColorFactor");
    if color == Vec3::ZERO {
        return None;
    }
    if e.color_texture.is_some() {
        let place = format!("{}/multiscatterColorTexture", p.pointer);
        p.warnings.add(place, "a volume that differs from place to place is not supported; ignored");
    }
    Some(VolumeScatter { color, anisotropy: p.scalar(e.anisotropy, 0.0, (-1.0, 1.0), "scatterAnisotropy") })
}
