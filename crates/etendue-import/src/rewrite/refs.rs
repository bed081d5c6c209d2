//! What refers to what in a document: numbers of accessors and buffer views, wherever the specification and the known extensions
//! have them; and what of others cannot be followed.

use super::tree::{Tree, name};
use crate::document::Document;
use crate::error::Fault;
use crate::extensions as ext;
use std::collections::BTreeSet;

/// Visits every number of an accessor.
pub(super) fn each_accessor<'t>(tree: &mut Tree<'t>, see: &mut dyn FnMut(&mut Tree<'t>)) {
    for p in tree.list_mut("meshes").iter_mut().flat_map(|m| m.list_mut("primitives")) {
        if let Some(a) = p.get_mut("attributes") {
            a.entries_mut().iter_mut().for_each(|(_, v)| see(v));
        }
        p.get_mut("indices").into_iter().for_each(&mut *see);
        p.list_mut("targets").iter_mut().flat_map(Tree::entries_mut).for_each(|(_, v)| see(v));
    }
    for s in tree.list_mut("skins") {
        s.get_mut("inverseBindMatrices").into_iter().for_each(&mut *see);
    }
    for s in tree.list_mut("animations").iter_mut().flat_map(|a| a.list_mut("samplers")) {
        s.get_mut("input").into_iter().for_each(&mut *see);
        s.get_mut("output").into_iter().for_each(&mut *see);
    }
    for n in tree.list_mut("nodes") {
        if let Some(a) = n.within_mut(&["extensions", ext::GPU_INSTANCING, "attributes"]) {
            a.entries_mut().iter_mut().for_each(|(_, v)| see(v));
        }
    }
}

/// Visits every number of a buffer view.
pub(super) fn each_view<'t>(tree: &mut Tree<'t>, see: &mut dyn FnMut(&mut Tree<'t>)) {
    for a in tree.list_mut("accessors") {
        a.get_mut("bufferView").into_iter().for_each(&mut *see);
    }
    each_other_view(tree, see);
}

/// Visits every number of a buffer view that does not say where the elements of an accessor begin.
pub(super) fn each_other_view<'t>(tree: &mut Tree<'t>, see: &mut dyn FnMut(&mut Tree<'t>)) {
    for a in tree.list_mut("accessors") {
        for part in ["indices", "values"] {
            a.within_mut(&["sparse", part, "bufferView"]).into_iter().for_each(&mut *see);
        }
    }
    for i in tree.list_mut("images") {
        i.get_mut("bufferView").into_iter().for_each(&mut *see);
    }
    for p in tree.list_mut("meshes").iter_mut().flat_map(|m| m.list_mut("primitives")) {
        p.within_mut(&["extensions", ext::DRACO, "bufferView"]).into_iter().for_each(&mut *see);
    }
    if let Some(e) = tree.within_mut(&["extensions", ext::LIGHTS_IES]) {
        for l in e.list_mut("lights") {
            l.get_mut("bufferView").into_iter().for_each(&mut *see);
        }
    }
}

/// An error for numbers of accessors and views that are not there: those that are added would take them.
pub(super) fn check(tree: &mut Tree<'_>, doc: &Document<'_>) -> Result<(), Fault> {
    let mut wrong = None;
    let mut see = |v: &Tree<'_>, what: &'static str, count: usize| {
        if v.index().is_some_and(|i| i as usize >= count) {
            wrong = v.index().map(|i| (what, i, count));
        }
    };
    each_accessor(tree, &mut |v| see(v, "accessor", doc.accessors.len()));
    each_view(tree, &mut |v| see(v, "buffer view", doc.buffer_views.len()));
    let Some((what, i, count)) = wrong else { return Ok(()) };
    let message =
        format!("something refers to {what} {i}, but the file has {count}: `etendue check` says where");
    Err(Fault::invalid("", message))
}

/// The names of all extensions that are used somewhere in `tree`.
pub(super) fn extensions(tree: &Tree<'_>) -> BTreeSet<String> {
    let mut out = BTreeSet::new();
    each_extension(tree, &mut |name, _| {
        out.insert(name.to_owned());
    });
    out
}

fn each_extension(tree: &Tree<'_>, see: &mut dyn FnMut(&str, &Tree<'_>)) {
    for (key, value) in tree.entries() {
        if &key[..] == "\"extensions\"" {
            value.entries().iter().for_each(|(n, v)| see(&name(n), v));
        }
        each_extension(value, see);
    }
    tree.items().iter().for_each(|v| each_extension(v, see));
}

/// Whether an extension that is not known here stands on the object `tree` or on something within it.
pub(super) fn has_unknown(tree: &Tree<'_>) -> bool {
    extensions(tree).iter().any(|n| !ext::is_understood(n))
}

/// Unknown extensions that refer to files or, by a number that is not followed, to buffers.
pub(super) fn unfollowed(tree: &Tree<'_>) -> Vec<String> {
    let (mut files, mut buffers) = (BTreeSet::new(), BTreeSet::new());
    each_extension(tree, &mut |name, content| {
        if ext::is_understood(name) {
            return;
        }
        each_entry(content, &mut |key, value| match key {
            "\"uri\"" if value.text().is_some_and(|u| !u.starts_with("data:")) => {
                files.insert(name.to_owned());
            }
            "\"buffer\"" if value.index().is_some() => {
                buffers.insert(name.to_owned());
            }
            _ => {}
        });
    });
    let files =
        files.iter().map(|n| format!("{n} is not known: the files that it names stay beside the model"));
    let buffers = buffers
        .iter()
        .map(|n| format!("{n} is not known: what it says of buffers is as it was, and may be wrong"));
    files.chain(buffers).collect()
}

fn each_entry(tree: &Tree<'_>, see: &mut dyn FnMut(&str, &Tree<'_>)) {
    for (key, value) in tree.entries() {
        see(key, value);
        each_entry(value, see);
    }
    tree.items().iter().for_each(|v| each_entry(v, see));
}
