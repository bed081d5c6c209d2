//! The buffer views of the new file: those of the old one under their numbers, and new ones, packed into one buffer.

use super::refs;
use super::tree::Tree;
use crate::buffers::Buffers;
use crate::document::Document;
use crate::error::Fault;
use crate::extensions as ext;
use std::borrow::Cow;

/// What a view is for, as the file says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Elements of vertices: bytes from one to the next, and of one.
    Vertices {
        stride: usize,
        size: usize,
    },
    Indices,
    File,
}

struct View<'a, 't> {
    content: Cow<'a, [u8]>,
    json: Tree<'t>,
}

/// Views by number. A number whose view nobody needs is free for the next one that is added.
pub(super) struct Views<'a, 't> {
    slots: Vec<Option<View<'a, 't>>>,
}

impl<'a, 't> Views<'a, 't> {
    /// The views of the document, decompressed. Takes their descriptions out of `tree`.
    pub fn take(
        tree: &mut Tree<'t>,
        doc: &Document<'_>,
        buffers: &'a Buffers<'_>,
        notes: &mut Vec<String>,
    ) -> Result<Self, Fault> {
        let mut slots = Vec::with_capacity(doc.buffer_views.len());
        for (i, json) in tree.list_mut("bufferViews").iter_mut().enumerate() {
            let content = buffers.view(doc, i as u32, || format!("/bufferViews/{i}"))?;
            for name in [ext::KHR_MESHOPT, ext::EXT_MESHOPT] {
                json.remove_extension(name);
            }
            forget_other_places(json, i, notes);
            let json = std::mem::replace(json, Tree::Array(Vec::new()));
            slots.push(Some(View { content: content.into(), json }));
        }
        Ok(Self { slots })
    }

    /// Adds a view; returns its number.
    pub fn add(&mut self, content: Vec<u8>, purpose: Purpose) -> u32 {
        let mut json = Tree::object([
            ("buffer", Tree::number(0)),
            ("byteOffset", Tree::number(0)),
            ("byteLength", Tree::number(content.len() as u64)),
        ]);
        match purpose {
            Purpose::Vertices { stride, size } => {
                if stride != size {
                    json.set("byteStride", Tree::number(stride as u64));
                }
                json.set("target", Tree::number(34962));
            }
            Purpose::Indices => json.set("target", Tree::number(34963)),
            Purpose::File => {}
        }
        let view = Some(View { content: content.into(), json });
        match self.slots.iter().position(Option::is_none) {
            Some(free) => {
                self.slots[free] = view;
                free as u32
            }
            None => {
                self.slots.push(view);
                (self.slots.len() - 1) as u32
            }
        }
    }

    /// Gives up a view that nothing refers to.
    pub fn free(&mut self, number: u32) {
        if let Some(slot) = self.slots.get_mut(number as usize) {
            *slot = None;
        }
    }

    /// The bytes of a view.
    pub fn content(&self, number: u32) -> &[u8] {
        self.slots.get(number as usize).and_then(Option::as_ref).map_or(&[], |v| &v.content)
    }

    /// Bytes between the elements of a view, if it says so.
    pub fn stride(&self, number: u32) -> Option<u32> {
        self.slots.get(number as usize)?.as_ref()?.json.get("byteStride")?.index()
    }

    /// Puts other bytes into a view.
    pub fn replace(&mut self, number: u32, content: Vec<u8>) {
        if let Some(Some(v)) = self.slots.get_mut(number as usize) {
            v.json.set("byteLength", Tree::number(content.len() as u64));
            v.content = content.into();
        }
    }

    /// Leaves no number free: the last views move there, and what refers to them in `tree` follows.
    fn close_up(&mut self, tree: &mut Tree<'t>) {
        let mut moved = std::collections::HashMap::new();
        for i in 0.. {
            while matches!(self.slots.last(), Some(None)) {
                self.slots.pop();
            }
            if i >= self.slots.len() {
                break;
            }
            if self.slots[i].is_none() {
                moved.insert((self.slots.len() - 1) as u32, i as u64);
                self.slots.swap_remove(i);
            }
        }
        if !moved.is_empty() {
            refs::each_view(tree, &mut |v| {
                if let Some(to) = v.index().and_then(|n| moved.get(&n)) {
                    *v = Tree::number(*to);
                }
            });
        }
    }

    /// Writes descriptions of the views and of their one buffer into `tree`; returns what is in it, piece by piece: each begins
    /// at a multiple of four bytes.
    pub fn pack(mut self, tree: &mut Tree<'t>, notes: &mut Vec<String>) -> Pieces<'a> {
        self.close_up(tree);
        let mut pieces = Pieces { list: Vec::with_capacity(self.slots.len()), length: 0 };
        let mut list = Vec::with_capacity(self.slots.len());
        for View { content, mut json } in self.slots.into_iter().flatten() {
            pieces.length = pieces.length.next_multiple_of(4);
            json.set("buffer", Tree::number(0));
            if pieces.length > 0 || json.get("byteOffset").is_some() {
                json.set("byteOffset", Tree::number(pieces.length));
            }
            pieces.length += content.len() as u64;
            pieces.list.push(content);
            list.push(json);
        }
        let old = tree.get("buffers").map(|b| b.items().to_vec()).unwrap_or_default();
        if list.is_empty() {
            tree.remove("bufferViews");
            tree.remove("buffers");
            return pieces;
        }
        tree.set("bufferViews", Tree::Array(list));
        let said =
            |b: &Tree<'_>| b.entries().iter().any(|(k, _)| matches!(&k[..], "\"name\"" | "\"extras\""));
        if old.iter().skip(1).any(said) {
            notes.push("names and extras of buffers other than the first: there is one buffer now".into());
        }
        let mut buffer = old.into_iter().next().unwrap_or(Tree::Object(Vec::new()));
        buffer.remove("uri");
        for name in [ext::KHR_MESHOPT, ext::EXT_MESHOPT] {
            buffer.remove_extension(name);
        }
        buffer.set("byteLength", Tree::number(pieces.length));
        tree.set("buffers", Tree::Array(vec![buffer]));
        pieces
    }
}

/// Takes off a view what unknown extensions say of other buffers that hold the same in another form: those are not there any more.
fn forget_other_places(json: &mut Tree<'_>, number: usize, notes: &mut Vec<String>) {
    let other = |(k, v): &(Cow<'_, str>, Tree<'_>)| v.get("buffer").map(|_| super::tree::name(k));
    let found: Vec<String> =
        json.get("extensions").map(|e| e.entries().iter().filter_map(other).collect()).unwrap_or_default();
    for name in found {
        json.remove_extension(&name);
        notes.push(format!(
            "/bufferViews/{number}: what {name} says of another buffer, whose content is not known"
        ));
    }
}

/// The content of a buffer.
pub(super) struct Pieces<'a> {
    pub list: Vec<Cow<'a, [u8]>>,
    /// Bytes, with what stands between the pieces.
    pub length: u64,
}
