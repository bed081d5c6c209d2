//! Material extensions that are drafts: ranges, defaults, and which of them say anything.
//!
//! They may still change. What is read is what the drafts said on 2026-11-22:
//!
//! | extension | pull request at KhronosGroup/glTF | revision |
//! |---|---|---|
//! | `KHR_materials_diffuse_roughness` | 2481 | 95c4f0db |

use crate::document::drafts;
use crate::error::Fault;
use crate::extensions as ext;
use crate::material::{Parts, UNIT};
use etendue_scene::{DiffuseRoughness, Extensions};

/// Adds to `out` what the drafts of the material say to whose JSON `p` points; `p` points elsewhere afterwards.
pub(crate) fn convert(d: &drafts::Drafts, out: &mut Extensions, p: &mut Parts<'_, '_>) -> Result<(), Fault> {
    let material = p.pointer.clone();
    let at = |p: &mut Parts<'_, '_>, name: &str| p.pointer = format!("{material}/extensions/{name}");
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
