//! Pictures and profiles of lamps that lie beside the model, or in it as text, become views of its buffer. Their bytes stay what
//! they are.

use super::tree::Tree;
use super::views::{Purpose, Views};
use crate::error::Fault;
use crate::extensions as ext;
use crate::limits::shown;
use crate::source::Source;
use crate::texture::format_of;
use crate::uri;
use std::collections::HashMap;

/// What IES profiles are said to be (`EXT_lights_ies`).
const IES: &str = "application/x-ies-lm-63";

/// Takes files into the views.
pub(super) struct Files<'s, 'o, 'a, 't> {
    source: &'s Source<'s>,
    views: &'o mut Views<'a, 't>,
    notes: &'o mut Vec<String>,
    /// The views of files by length and checksum: the same bytes are stored once.
    known: HashMap<(usize, u32), Vec<u32>>,
    by_uri: HashMap<String, u32>,
    /// Bytes read.
    read: u64,
    /// How many were taken in.
    pub embedded: u64,
}

/// Takes in all files that `tree` refers to; returns how many references there were.
pub(super) fn embed<'t>(
    tree: &mut Tree<'t>,
    source: &Source<'_>,
    views: &mut Views<'_, 't>,
    notes: &mut Vec<String>,
) -> Result<u64, Fault> {
    let mut files =
        Files { source, views, notes, known: HashMap::new(), by_uri: HashMap::new(), read: 0, embedded: 0 };
    for (i, image) in tree.list_mut("images").iter_mut().enumerate() {
        files.take(image, &format!("/images/{i}"), "image", mime)?;
    }
    if let Some(e) = tree.within_mut(&["extensions", ext::LIGHTS_IES]) {
        for (i, l) in e.list_mut("lights").iter_mut().enumerate() {
            let pointer = format!("/extensions/{}/lights/{i}", ext::LIGHTS_IES);
            files.take(l, &pointer, "light profile", |_| Some(IES))?;
        }
    }
    Ok(files.embedded)
}

impl Files<'_, '_, '_, '_> {
    /// Makes `json` refer to a view instead of a URI, with the type that its content has.
    fn take(
        &mut self,
        json: &mut Tree<'_>,
        pointer: &str,
        what: &'static str,
        kind: impl Fn(&[u8]) -> Option<&'static str>,
    ) -> Result<(), Fault> {
        let Some(uri) = json.get("uri").and_then(Tree::text) else {
            if let Some(view) = json.get("bufferView").and_then(Tree::index) {
                say(json, kind(self.views.content(view)));
            }
            return Ok(());
        };
        let view = match self.by_uri.get(&uri) {
            Some(&known) => known,
            None => {
                let bytes = match self.source.read(&uri, what, pointer) {
                    Ok(bytes) => bytes,
                    // Nothing that is shown needs it, or the import had failed.
                    Err(e @ (Fault::Missing { .. } | Fault::Invalid { .. })) => {
                        let shown = uri::shorten(&uri);
                        self.notes.push(format!("{pointer}: {}; its address, {shown}, is kept", e.message()));
                        return Ok(());
                    }
                    Err(e) => return Err(e),
                };
                self.book(bytes.len() as u64, pointer)?;
                if kind(&bytes).or_else(|| of_uri(&uri)).is_none() && json.get("mimeType").is_none() {
                    let shown = uri::shorten(&uri);
                    self.notes
                        .push(format!("{pointer}: no format that is known; its address, {shown}, is kept"));
                    return Ok(());
                }
                let view = self.store(bytes);
                self.by_uri.insert(uri.clone(), view);
                view
            }
        };
        json.remove("uri");
        json.set("bufferView", Tree::number(view.into()));
        if json.get("mimeType").is_none() {
            say(json, of_uri(&uri));
        }
        say(json, kind(self.views.content(view)));
        self.embedded += 1;
        Ok(())
    }

    /// Files may take what the model leaves of the memory.
    fn book(&mut self, bytes: u64, pointer: &str) -> Result<(), Fault> {
        self.read = self.read.saturating_add(bytes);
        let allowed = self.source.limits.memory_bytes.saturating_sub(self.source.used);
        if self.read > allowed {
            let what = format!("the files that it refers to have more than {}", shown(allowed));
            return Err(Fault::TooLarge { pointer: pointer.to_owned(), what, limit: "memory_bytes" });
        }
        Ok(())
    }

    /// The view with these bytes.
    fn store(&mut self, bytes: Vec<u8>) -> u32 {
        let like = self.known.entry((bytes.len(), crc32fast::hash(&bytes))).or_default();
        if let Some(&same) = like.iter().find(|&&v| self.views.content(v) == bytes) {
            return same;
        }
        let view = self.views.add(bytes, Purpose::File);
        like.push(view);
        view
    }
}

/// Says of what type the content is, if that is known and not said already.
fn say(json: &mut Tree<'_>, mime: Option<&str>) {
    if let Some(mime) = mime
        && json.get("mimeType").and_then(Tree::text).as_deref() != Some(mime)
    {
        json.set("mimeType", Tree::string(mime));
    }
}

/// The media type of a picture by its first bytes.
fn mime(bytes: &[u8]) -> Option<&'static str> {
    Some(match format_of(bytes) {
        "PNG" => "image/png",
        "JPEG" => "image/jpeg",
        "WebP" => "image/webp",
        "KTX2" => "image/ktx2",
        "DDS" => "image/vnd-ms.dds",
        "BMP" => "image/bmp",
        _ => return None,
    })
}

/// The media type that a data URI states.
fn of_uri(uri: &str) -> Option<&str> {
    let head =
        uri.get(..5).filter(|s| s.eq_ignore_ascii_case("data:")).and_then(|_| uri[5..].split_once(','))?.0;
    head.split(';').next().filter(|m| m.contains('/'))
}
