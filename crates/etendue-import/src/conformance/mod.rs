//! What in a glTF file is against its specification, whether or not a picture depends on it.
//!
//! The reader is lenient where no picture suffers: it does not look at what nothing uses, at an accessor's `min` and `max`, or
//! at lists that are empty. People who write exporters want to know all the same. `info` and `check` ask for it; it takes a
//! pass over all data.

mod data;
mod images;
mod structure;
mod unused;

use crate::accessor::Accessors;
use crate::buffers::Buffers;
use crate::document::{Document, Node};
use crate::error::Fault;
use crate::glb::Container;
use crate::source::Source;
use crate::warning::{Warning, Warnings};
use serde_json::Value;
use std::collections::HashSet;

/// What the breaches of one document are looked for in.
struct Case<'a> {
    root: &'a Value,
    accessors: Accessors<'a>,
    parts: &'a Container<'a>,
    source: &'a Source<'a>,
    out: Warnings,
}

/// All breaches that are known here; those that the reader warned of already may be among them under other words.
pub(crate) fn breaches<'v>(
    root: &'v Value,
    doc: &mut Document<'v>,
    buffers: &Buffers<'_>,
    parts: &Container<'_>,
    source: &Source<'_>,
) -> Vec<Warning> {
    // Meshes that no node shows are shown for once.
    let nodes = doc.nodes.len();
    let shown: HashSet<u32> = doc.nodes.iter().filter_map(|n| n.mesh).collect();
    let alone = (0..doc.meshes.len() as u32).filter(|m| !shown.contains(m));
    doc.nodes.extend(alone.map(Node::of_mesh));
    let accessors = Accessors { doc, buffers };
    let mut case = Case { root, accessors, parts, source, out: Warnings::default() };
    case.structure();
    case.buffers();
    case.accessors();
    case.images();
    case.unused(nodes as u32);
    let out = case.out.into_vec();
    doc.nodes.truncate(nodes);
    out
}

impl Case<'_> {
    /// What the reader would refuse.
    fn fault(&mut self, e: Fault) {
        let at = e.pointer().to_owned();
        self.out.add(at, e.message());
    }
}

/// The entries of the list `name` of the document.
fn list<'v>(root: &'v Value, name: &str) -> &'v [Value] {
    root.get(name).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}
