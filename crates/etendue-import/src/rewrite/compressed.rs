//! Primitives of `KHR_draco_mesh_compression` become plain ones: their accessors get what the importer decoded.

use super::arrays::{Arrays, Elements};
use super::refs;
use super::tree::Tree;
use super::views::Purpose;
use crate::accessor::Accessors;
use crate::document::{Mode, Shape};
use crate::error::Fault;
use crate::extensions as ext;
use std::collections::{BTreeSet, HashMap};

/// All shapes of elements.
pub(super) const ANY: &[Shape] =
    &[Shape::Scalar, Shape::Vec2, Shape::Vec3, Shape::Vec4, Shape::Mat2, Shape::Mat3, Shape::Mat4];

/// Decoded data by where they came from: the compressed view, the attribute in it (`None`: the triangles), the accessor.
type Known = HashMap<(u32, Option<u32>, Option<u32>), u32>;

/// Writes the decoded data of all compressed primitives; returns how many there were.
pub(super) fn expand(out: &mut Arrays<'_, '_>, accessors: Accessors<'_>) -> Result<u64, Fault> {
    let doc = accessors.doc;
    let mut decoded = Vec::new();
    let mut views = BTreeSet::new();
    for (m, mesh) in out.tree.list_mut("meshes").iter_mut().enumerate() {
        for (n, json) in mesh.list_mut("primitives").iter_mut().enumerate() {
            let p = &doc.meshes[m].primitives[n];
            // Of other modes the importer, as the extension, knows nothing.
            let Some(d) = p.draco.as_ref().filter(|_| matches!(p.mode, Mode::Triangles | Mode::Strip)) else {
                continue;
            };
            json.remove_extension(ext::DRACO);
            views.insert(d.buffer_view);
            let list = p.indices.filter(|&i| doc.accessors[i as usize].decoded.is_some());
            // What could not be decoded keeps its uncompressed data.
            let Some(list) = list else { continue };
            // Strips are decoded to a list.
            if json.get("mode").and_then(Tree::index).is_some_and(|m| m != 4) {
                json.remove("mode");
            }
            decoded.push((m, n, d, list));
        }
    }
    refs::each_view(&mut out.tree, &mut |v| {
        if let Some(n) = v.index() {
            views.remove(&n);
        }
    });
    views.into_iter().for_each(|v| out.views.free(v));

    let mut known = Known::new();
    let count = decoded.len() as u64;
    for (m, n, d, list) in decoded {
        let p = &doc.meshes[m].primitives[n];
        let pointer = || format!("/meshes/{m}/primitives/{n}");
        let origin = doc.accessors[list as usize].origin;
        let key = (d.buffer_view, None, origin);
        let indices = match known.get(&key) {
            Some(&there) => there,
            None => {
                let e = accessors.open(list, "an index", &[Shape::Scalar], pointer)?;
                let list: Vec<u32> =
                    e.integers::<1>(None).unwrap_or_default().into_iter().flatten().collect();
                let component =
                    origin.and_then(|o| doc.accessors.get(o as usize)).map_or(e.component(), |a| a.component);
                let elements = Elements::indices(&list, component);
                let there = match origin {
                    Some(o) => out.replace(o, 1, elements),
                    None => out.add("SCALAR", 1, elements),
                };
                known.insert(key, there);
                there
            }
        };
        let mut attributes = Vec::new();
        for &(name, a) in &p.attributes {
            let described = &doc.accessors[a as usize];
            let (Some(_), Some(origin)) = (described.decoded, described.origin) else { continue };
            let id = d.attributes.iter().find(|(n, _)| *n == name).map(|&(_, id)| id);
            let key = (d.buffer_view, id, Some(origin));
            let there = match known.get(&key) {
                Some(&there) => there,
                None => {
                    let e = accessors.open(a, name, ANY, pointer)?;
                    let there = out.replace(origin, 1, vertices(&e, None));
                    known.insert(key, there);
                    there
                }
            };
            attributes.push((name, there));
        }
        let Some(json) = out.tree.list_mut("meshes")[m].list_mut("primitives").get_mut(n) else { continue };
        json.set("indices", Tree::number(indices.into()));
        for (name, there) in attributes {
            set_entry(json, "attributes", name, there);
        }
    }
    Ok(count)
}

/// The elements of an attribute, and after them those of `more` vertices again.
pub(super) fn vertices(e: &crate::accessor::Elements<'_>, more: Option<&[u32]>) -> Elements {
    let size = e.shape().size(e.component()) as usize;
    let stride = size.next_multiple_of(4);
    let mut bytes = e.raw(None, stride);
    if let Some(more) = more {
        bytes.extend(e.raw(Some(more), stride));
    }
    let matrix = matches!(e.shape(), Shape::Mat2 | Shape::Mat3 | Shape::Mat4);
    Elements {
        count: e.len() + more.map_or(0, <[u32]>::len),
        bytes,
        component: e.component(),
        components: if matrix { 0 } else { e.shape().components() as usize },
        purpose: Purpose::Vertices { stride, size },
    }
}

/// Sets the number at `name`, as it is decoded, of the object at `key`.
pub(super) fn set_entry(json: &mut Tree<'_>, key: &str, name: &str, number: u32) {
    if let Some(v) = json.get_mut(key).and_then(|a| a.get_mut(name)) {
        *v = Tree::number(number.into());
    }
}

/// Takes the names of compressions off the lists of extensions if nothing is compressed that way any more; returns them.
pub(super) fn forget(tree: &mut Tree<'_>) -> Vec<&'static str> {
    let used = refs::extensions(tree);
    let mut gone = Vec::new();
    for name in [ext::DRACO, ext::EXT_MESHOPT, ext::KHR_MESHOPT].into_iter().filter(|n| !used.contains(*n)) {
        for list in ["extensionsUsed", "extensionsRequired"] {
            let Some(Tree::Array(names)) = tree.get_mut(list) else { continue };
            let before = names.len();
            names.retain(|n| n.text().as_deref() != Some(name));
            if names.len() < before && !gone.contains(&name) {
                gone.push(name);
            }
            // Empty lists are not allowed.
            if names.is_empty() {
                tree.remove(list);
            }
        }
    }
    gone
}
