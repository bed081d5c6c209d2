//! glTF into glTF, with everything that is in the file: nodes and their hierarchy, animations, skins, morph targets, cameras,
//! variants, names, extras and extensions, known and unknown. Only the layout of the data changes:
//!
//! - All buffers become one, all pictures and profiles of lamps are views of it, byte by byte what they were (`files`, `views`).
//! - Compressed data are decompressed (`compressed`); quantised data stay what they are.
//! - Primitives whose materials need tangents get them (`tangents`).
//!
//! The JSON is changed where it says where data are, and nowhere else (`tree`): arrays of the document keep their order, so that
//! numbers and JSON pointers stay right, also those in extensions that nobody here knows; new entries come last (`arrays`). Only
//! views may move, and only if all that may refer to them is known (`refs`). The same file gives the same bytes, and a file that
//! was written this way is written again as it is.

mod arrays;
mod compressed;
mod files;
mod refs;
mod tangents;
mod textures;
mod tree;
mod views;

use crate::error::{Fault, ImportError};
use crate::glb;
use crate::gltf::Gltf;
use crate::info::Info;
use crate::source::Source;
use crate::uri;
use crate::warning::{Warning, Warnings};
use crate::write::Form;
use arrays::Arrays;
use etendue_image::DecodeLimits;
use serde::Serialize;
use tree::Tree;
use views::{Pieces, Views};

/// A file that was written again.
#[derive(Clone, Debug)]
pub struct Rewritten {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was changed.
    pub changes: Changes,
    /// What could not be kept, or not be done; each once.
    pub notes: Vec<String>,
    /// What the file contains.
    pub info: Info,
    /// What an import of it would have to ignore or mend: it is kept as it was.
    pub warnings: Vec<Warning>,
}

/// What changed in a file that was written again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Changes {
    /// References to files and data URIs (pictures, profiles of lamps) that refer to the buffer now.
    pub embedded: u64,
    /// Textures that name the extension now which their picture, WebP or Basis Universal, needs.
    pub mended_textures: u64,
    /// Buffer views that were compressed (`EXT_meshopt_compression`, `KHR_meshopt_compression`).
    pub decompressed_views: u64,
    /// Primitives that were compressed (`KHR_draco_mesh_compression`).
    pub decompressed_primitives: u64,
    /// Extensions that are not used any more.
    pub dropped_extensions: Vec<&'static str>,
    /// Primitives that got tangents.
    pub tangents: u64,
    /// Vertices that were added for them.
    pub split_vertices: u64,
}

/// Why a file was not written again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// It cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// GLB counts its bytes in 32 bits.
    #[error("{0} bytes are more than glTF can hold in one file (4 GiB)")]
    TooLarge(u64),
}

/// Why a rewriting ended.
pub(crate) enum Stopped {
    Fault(Fault),
    /// So many bytes.
    TooLarge(u64),
}

impl From<Fault> for Stopped {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// Writes the glTF file `bytes`, of which `gltf` was read, again.
pub(crate) fn rewrite(gltf: &Gltf<'_>, bytes: &[u8], form: Form) -> Result<Rewritten, Stopped> {
    // Whoever gets the result should be able to load it.
    let shown = gltf.at(None)?;
    let (info, warnings) = (shown.info, shown.warnings);
    drop(shown.scene);
    gltf.forget_images();

    let json = glb::split(bytes, &mut Warnings::default())?.json;
    let json = std::str::from_utf8(json).ok().and_then(|t| Tree::read(t.trim_start_matches('\u{feff}')));
    let Some(mut tree) = json else { return Err(Fault::invalid("", "the JSON is not UTF-8").into()) };
    refs::check(&mut tree, &gltf.doc)?;
    let mut notes = refs::unfollowed(&tree);
    let mut changes = Changes {
        decompressed_views: gltf.doc.buffer_views.iter().filter(|v| v.compressed.is_some()).count() as u64,
        ..Changes::default()
    };
    let mut views = Views::take(&mut tree, &gltf.doc, &gltf.buffers, &mut notes)?;
    let used = gltf.bytes + gltf.buffers.external + gltf.budget.booked();
    let source = Source { folder: gltf.folder, limits: &gltf.limits, used, keep_files: false };
    changes.embedded = files::embed(&mut tree, &source, &mut views, &mut notes)?;
    let limits = DecodeLimits { max_pixels: gltf.limits.image_pixels, max_bytes: gltf.limits.image_bytes };
    changes.mended_textures = textures::mend(&mut tree, &views, &limits);
    let mut arrays = Arrays::new(tree, views, &gltf.doc);
    changes.decompressed_primitives = compressed::expand(&mut arrays, gltf.accessors())?;
    let mut budget = gltf.budget.clone();
    let added = tangents::add(&mut arrays, gltf.accessors(), gltf.occlusion, &mut budget, &mut notes)?;
    (changes.tangents, changes.split_vertices) = (added.primitives, added.vertices);
    arrays.tidy(&gltf.doc);
    let Arrays { mut tree, views, .. } = arrays;
    let pieces = views.pack(&mut tree, &mut notes);
    changes.dropped_extensions = compressed::forget(&mut tree);
    notes.dedup();
    let bytes = match form {
        Form::Binary => binary(&tree, &pieces),
        Form::Text => text(tree, &pieces),
    };
    let bytes = bytes.map_err(Stopped::TooLarge)?;
    Ok(Rewritten { bytes, changes, notes, info, warnings })
}

fn binary(tree: &Tree<'_>, pieces: &Pieces<'_>) -> Result<Vec<u8>, u64> {
    let mut json = Vec::new();
    tree.write(&mut json);
    // Also views without bytes, which are not allowed, have to be somewhere.
    let length = Some(pieces.length).filter(|_| !pieces.list.is_empty());
    glb::join(&json, pieces.list.iter().map(|p| &p[..]), length)
}

fn text(mut tree: Tree<'_>, pieces: &Pieces<'_>) -> Result<Vec<u8>, u64> {
    u32::try_from(pieces.length).map_err(|_| pieces.length)?;
    let mut bytes = Vec::with_capacity(pieces.length as usize);
    for p in &pieces.list {
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes.extend_from_slice(p);
    }
    if let Some(buffer) = tree.list_mut("buffers").first_mut() {
        buffer.set("uri", Tree::string(&uri::of(&bytes)));
    }
    drop(bytes);
    let mut out = Vec::new();
    tree.write(&mut out);
    Ok(out)
}
