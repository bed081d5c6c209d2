//! What is allowed in a glTF file but seldom meant.

use crate::document::Document;
use crate::sizes::uses;
use crate::warning::{Warning, Warnings};

/// Larger than any screen shows of one picture.
const LARGE: u32 = 8192;

/// Marks what the numbers `refers` refer to, and warns of the others.
fn unreferred(out: &mut Warnings, list: &str, what: &str, count: usize, refers: impl Iterator<Item = u32>) {
    let mut used = vec![false; count];
    for i in refers {
        if let Some(u) = used.get_mut(i as usize) {
            *u = true;
        }
    }
    for i in (0..count).filter(|&i| !used[i]) {
        out.add(format!("/{list}/{i}"), format!("nothing refers to this {what}"));
    }
}

/// Things of `doc` that are worth a look though nothing is wrong with them.
pub(crate) fn of_document(doc: &Document<'_>) -> Vec<Warning> {
    let mut out = Warnings::default();
    unreferred(&mut out, "meshes", "mesh", doc.meshes.len(), doc.nodes.iter().filter_map(|n| n.mesh));
    let primitives = || doc.meshes.iter().flat_map(|m| &m.primitives);
    let variants = primitives().flat_map(|p| &p.mappings).map(|m| m.material);
    let materials = primitives().filter_map(|p| p.material).chain(variants);
    unreferred(&mut out, "materials", "material", doc.materials.len(), materials);
    unreferred(&mut out, "cameras", "camera", doc.cameras.len(), doc.nodes.iter().filter_map(|n| n.camera));
    unreferred(&mut out, "skins", "skin", doc.skins.len(), doc.nodes.iter().filter_map(|n| n.skin));
    for (i, _) in uses(doc).iter().enumerate().filter(|(_, u)| u.is_none()) {
        out.add(format!("/bufferViews/{i}"), "nothing refers to this buffer view");
    }
    for (i, m) in doc.meshes.iter().enumerate() {
        for (k, p) in m.primitives.iter().enumerate() {
            let at = || format!("/meshes/{i}/primitives/{k}");
            let count =
                p.attribute("POSITION").and_then(|a| doc.accessors.get(a as usize)).map_or(0, |a| a.count);
            if p.mode.is_stroke() {
                out.add(at(), "points or lines: shown as balls and tubes of 1/500 of the mesh's size");
                continue;
            }
            if p.indices.is_none() && count > 3 {
                out.add(at(), "no indices: vertices cannot be shared");
            }
            if p.attribute("NORMAL").is_none() {
                out.add(at(), "no normals: shown flat");
            }
        }
    }
    out.into_vec()
}

/// The same of pictures: their numbers in the file, width and height.
pub(crate) fn of_images(images: impl Iterator<Item = (usize, u32, u32)>) -> Vec<Warning> {
    let mut out = Warnings::default();
    for (i, w, h) in images {
        if w.max(h) > LARGE {
            out.add(
                format!("/images/{i}"),
                format!("a picture of more than {LARGE} pixels in width or height"),
            );
        }
    }
    out.into_vec()
}
