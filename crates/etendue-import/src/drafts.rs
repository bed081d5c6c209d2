//! Material extensions that are drafts: ranges, defaults, and which of them say anything.
//!
//! They may still change. What is read is what the drafts said on 2026-11-22:
//!
//! | extension | pull request at KhronosGroup/glTF | revision |
//! |---|---|---|
//! | `KHR_materials_coat` | 2534 | ac989f7a |
//! | `KHR_materials_diffuse_roughness` | 2481 | 95c4f0db |
//! | `KHR_materials_fuzz` | 2538 | b714616c |
//!
//! Where they contradict themselves: a coat that covers a part of the surface absorbs and darkens in that part (by `coatFactor` 0
//! nothing, as the text says and its formula does not); `fuzzRoughnessFactor` is 0.5 by default, as the text says and the schema
//! does not. `coatIor` 0 is allowed and not explained; it is taken as infinite, as `KHR_materials_ior` has it. What shines below a
//! coat crosses it once and not twice: it is multiplied by the square root of the coat's colour, at the length of its path.

use crate::document::drafts;
use crate::error::Fault;
use crate::extensions as ext;
use crate::material::{LARGEST, Parts, UNIT};
use crate::surface;
use etendue_scene::{Clearcoat, DiffuseRoughness, Extensions, Fuzz};
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
