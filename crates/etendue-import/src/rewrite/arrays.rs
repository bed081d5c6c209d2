//! Accessors that get other elements, and what becomes of the bytes that they had.

use super::refs;
use super::tree::Tree;
use super::views::{Purpose, Views};
use crate::document::{Component, Document};
use std::collections::BTreeSet;

/// Elements for an accessor.
pub(super) struct Elements {
    /// One after another; those of vertices start at multiples of four bytes.
    pub bytes: Vec<u8>,
    pub component: Component,
    /// Components of an element; 0 for matrices, whose columns have gaps.
    pub components: usize,
    pub count: usize,
    pub purpose: Purpose,
}

impl Elements {
    /// Indices, in `component`s or in the smallest type above that holds them: its largest number is no vertex (glTF 2.0,
    /// 3.7.2.1).
    pub fn indices(list: &[u32], component: Component) -> Self {
        let most = list.iter().copied().max().unwrap_or(0);
        let component = match component {
            Component::U8 if most < 0xff => Component::U8,
            Component::U8 | Component::U16 if most < 0xffff => Component::U16,
            _ => Component::U32,
        };
        let size = component.size() as usize;
        let bytes = list.iter().flat_map(|i| i.to_le_bytes().into_iter().take(size)).collect();
        Self { bytes, component, components: 1, count: list.len(), purpose: Purpose::Indices }
    }

    /// Smallest and largest value of each component; `None` if there are none, or some are no numbers.
    fn bounds(&self) -> Option<[Tree<'static>; 2]> {
        if self.components == 0 || self.count == 0 {
            return None;
        }
        let size = self.component.size() as usize;
        let stride = match self.purpose {
            Purpose::Vertices { stride, .. } => stride,
            _ => size * self.components,
        };
        let mut bounds = vec![(f64::INFINITY, f64::NEG_INFINITY); self.components];
        for element in self.bytes.chunks(stride) {
            for (b, c) in bounds.iter_mut().zip(element.chunks(size)) {
                let v = self.component.value(c);
                if !v.is_finite() {
                    return None;
                }
                *b = (b.0.min(v), b.1.max(v));
            }
        }
        let text = |v: f64| match self.component {
            Component::F32 => serde_json::Value::from(v).to_string(),
            _ => format!("{v:.0}"),
        };
        let list =
            |values: Vec<f64>| Tree::Array(values.into_iter().map(|v| Tree::Leaf(text(v).into())).collect());
        Some([list(bounds.iter().map(|b| b.0).collect()), list(bounds.iter().map(|b| b.1).collect())])
    }
}

/// A document whose arrays are exchanged.
pub(super) struct Arrays<'a, 't> {
    pub tree: Tree<'t>,
    pub views: Views<'a, 't>,
    /// Per accessor: how often it is referred to.
    users: Vec<u32>,
    /// Views from which accessors were taken away.
    left: BTreeSet<u32>,
    /// Whether unknown extensions may refer to anything.
    strangers: bool,
}

impl<'a, 't> Arrays<'a, 't> {
    pub fn new(mut tree: Tree<'t>, views: Views<'a, 't>, doc: &Document<'_>) -> Self {
        let strangers = refs::has_unknown(&tree);
        let mut users = vec![u32::from(strangers); tree.list("accessors").len().max(doc.accessors.len())];
        refs::each_accessor(&mut tree, &mut |a| {
            if let Some(n) = a.index().and_then(|a| users.get_mut(a as usize)) {
                *n = n.saturating_add(1);
            }
        });
        users.truncate(tree.list("accessors").len());
        Self { tree, views, users, left: BTreeSet::new(), strangers }
    }

    /// Gives `elements` to those who refer to `accessor` in `refs` places: to itself, if there are no others, or if it had nothing
    /// so far; else to a new accessor that is like it. Returns its number, which is for the caller to put there.
    pub fn replace(&mut self, accessor: u32, refs: u32, elements: Elements) -> u32 {
        let n = accessor as usize;
        let Some(old) = self.tree.list("accessors").get(n) else { return accessor };
        let empty = old.get("bufferView").is_none() && old.get("sparse").is_none();
        let own = empty || self.users[n] <= refs;
        let mut json = old.clone();
        if own {
            let parts = [
                &["bufferView"][..],
                &["sparse", "indices", "bufferView"],
                &["sparse", "values", "bufferView"],
            ];
            self.left.extend(parts.iter().filter_map(|p| old.within(p)?.index()));
        } else {
            self.users[n] -= refs;
        }
        json.remove("byteOffset");
        json.remove("sparse");
        json.set("componentType", Tree::number(elements.component.code()));
        self.describe(&mut json, elements);
        if own {
            self.tree.list_mut("accessors")[n] = json;
            accessor
        } else {
            self.push(json, refs)
        }
    }

    /// Adds an accessor of the type that `shape` names, for `refs` places; returns its number.
    pub fn add(&mut self, shape: &str, refs: u32, elements: Elements) -> u32 {
        let mut json = Tree::object([
            ("bufferView", Tree::number(0)),
            ("componentType", Tree::number(elements.component.code())),
            ("count", Tree::number(0)),
            ("type", Tree::string(shape)),
        ]);
        self.describe(&mut json, elements);
        self.push(json, refs)
    }

    fn push(&mut self, json: Tree<'t>, refs: u32) -> u32 {
        self.users.push(refs.saturating_add(self.strangers.into()));
        self.tree.push("accessors", json)
    }

    fn describe(&mut self, json: &mut Tree<'t>, elements: Elements) {
        json.set("count", Tree::number(elements.count as u64));
        if json.get("min").is_some() || json.get("max").is_some() {
            match elements.bounds() {
                Some([min, max]) => {
                    json.set("min", min);
                    json.set("max", max);
                }
                None => {
                    json.remove("min");
                    json.remove("max");
                }
            }
        }
        json.set("bufferView", Tree::number(self.views.add(elements.bytes, elements.purpose).into()));
    }

    /// Drops the bytes that were left and that nothing refers to any more.
    pub fn tidy(&mut self, doc: &Document<'_>) {
        if self.strangers {
            return;
        }
        for view in std::mem::take(&mut self.left) {
            let mut whole = false;
            refs::each_other_view(&mut self.tree, &mut |v| whole |= v.index() == Some(view));
            if !whole {
                self.cut(view, doc);
            }
        }
    }

    /// Leaves of a view what accessors show of it.
    fn cut(&mut self, view: u32, doc: &Document<'_>) {
        let mut spans: Vec<(u64, u64)> = Vec::new();
        for (i, a) in self.tree.list("accessors").iter().enumerate() {
            if a.get("bufferView").and_then(Tree::index) != Some(view) {
                continue;
            }
            // An accessor that still shows an old view is the file's own.
            let Some(known) = doc.accessors.get(i) else { return };
            let size = known.shape.size(known.component);
            let stride = self.views.stride(view).map_or(size, u64::from);
            let length = known.count.saturating_sub(1).saturating_mul(stride).saturating_add(size);
            spans.push((known.byte_offset, known.byte_offset.saturating_add(length)));
        }
        if spans.is_empty() {
            self.views.free(view);
            return;
        }
        spans.sort_unstable();
        let have = self.views.content(view);
        let mut content = Vec::new();
        // Where spans begin that do not touch the one before, and by how much they move.
        let mut moves: Vec<(u64, u64)> = Vec::new();
        let mut end = 0;
        for (from, to) in spans {
            // A gap is left where closing it would move nothing, as bytes keep their alignment.
            let at = content.len().next_multiple_of(4) as u64 + from % 4;
            let before = moves.last().map(|m| m.1);
            if before.is_none_or(|by| from > end && from - end > at - content.len() as u64 && from - at >= by)
            {
                content.resize(at as usize, 0);
                moves.push((from, from - at));
                end = from;
            }
            let Some(more) = have.get(end as usize..to.max(end) as usize) else { return };
            content.extend_from_slice(more);
            end = end.max(to);
        }
        if content.len() == have.len() {
            return;
        }
        self.views.replace(view, content);
        for a in self.tree.list_mut("accessors") {
            if a.get("bufferView").and_then(Tree::index) == Some(view) {
                let from = u64::from(a.get("byteOffset").and_then(Tree::index).unwrap_or(0));
                let by = moves.iter().rev().find(|m| m.0 <= from).map_or(0, |m| m.1);
                if by > 0 {
                    a.set("byteOffset", Tree::number(from - by));
                }
            }
        }
    }
}
