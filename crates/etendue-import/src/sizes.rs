//! Where the bytes of a glTF file go.

use crate::document::Document;
use crate::extensions;
use serde::Serialize;

/// Bytes of a model by what they are for. Bytes that serve two purposes count for the first of them here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Sizes {
    /// The JSON text.
    pub json: u64,
    /// Vertices, indices, morph targets, instances.
    pub geometry: u64,
    /// Pictures, inside the file and beside it, as far as they are used.
    pub images: u64,
    /// Keyframes and skins.
    pub animation: u64,
    /// Data that something refers to which is not known here.
    pub other: u64,
    /// Buffer views that nothing refers to, and bytes of buffers that no view shows.
    pub unused: u64,
}

/// What a view is for; the first one counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Use {
    Geometry,
    Image,
    Animation,
    Other,
}

/// What each buffer view of the document is for; `None` if nothing refers to it.
pub(crate) fn uses(doc: &Document<'_>) -> Vec<Option<Use>> {
    let mut accessors: Vec<Option<Use>> = vec![None; doc.accessors.len()];
    let mut mark = |a: u32, what: Use| {
        if let Some(slot) = accessors.get_mut(a as usize) {
            *slot = Some(slot.map_or(what, |known| known.min(what)));
        }
    };
    for p in doc.meshes.iter().flat_map(|m| &m.primitives) {
        p.attributes.iter().for_each(|&(_, a)| mark(a, Use::Geometry));
        p.indices.into_iter().for_each(|a| mark(a, Use::Geometry));
        let targets = p.targets.iter().flat_map(|t| [t.position, t.normal, t.tangent]);
        targets.flatten().for_each(|a| mark(a, Use::Geometry));
    }
    for (_, a) in doc.nodes.iter().filter_map(|n| n.instancing.as_ref()).flatten() {
        mark(*a, Use::Geometry);
    }
    doc.skins.iter().filter_map(|s| s.inverse_bind_matrices).for_each(|a| mark(a, Use::Animation));
    for k in doc.animations.iter().flat_map(|a| &a.samplers) {
        mark(k.input, Use::Animation);
        mark(k.output, Use::Animation);
    }
    let mut views = vec![None; doc.buffer_views.len()];
    let mut see = |v: Option<u32>, what: Use| {
        if let Some(slot) = v.and_then(|v| views.get_mut(v as usize)) {
            let slot: &mut Option<Use> = slot;
            *slot = Some(slot.map_or(what, |known| known.min(what)));
        }
    };
    for (a, what) in doc.accessors.iter().zip(&accessors) {
        let what = what.unwrap_or(Use::Other);
        see(a.buffer_view, what);
        if let Some(s) = &a.sparse {
            see(Some(s.indices_view), what);
            see(Some(s.values_view), what);
        }
    }
    doc.images.iter().for_each(|i| see(i.buffer_view, Use::Image));
    if doc.extensions_used.contains(&extensions::DRACO) {
        // Its views are referred to from within the extension, and by nothing else.
        views.iter_mut().for_each(|v| *v = v.or(Some(Use::Geometry)));
    }
    views
}

impl Sizes {
    /// Those of a document whose JSON has `json` bytes; the pictures beside it are added by who reads them.
    pub(crate) fn of(doc: &Document<'_>, json: u64) -> Self {
        let mut out = Self { json, ..Self::default() };
        // Per buffer. One that no view shows may be a fallback without data.
        let mut shown = vec![0u64; doc.buffers.len()];
        for (v, what) in doc.buffer_views.iter().zip(uses(doc)) {
            let (buffer, n) = match &v.compressed {
                Some(c) => (c.buffer, c.byte_length),
                None => (v.buffer, v.byte_length),
            };
            if let Some(sum) = shown.get_mut(buffer as usize) {
                *sum = sum.saturating_add(n);
            }
            let sum = match what {
                Some(Use::Geometry) => &mut out.geometry,
                Some(Use::Image) => &mut out.images,
                Some(Use::Animation) => &mut out.animation,
                Some(Use::Other) => &mut out.other,
                None => &mut out.unused,
            };
            *sum = sum.saturating_add(n);
        }
        for (b, &n) in doc.buffers.iter().zip(&shown).filter(|(_, n)| **n > 0) {
            out.unused = out.unused.saturating_add(b.byte_length.saturating_sub(n));
        }
        out
    }
}
