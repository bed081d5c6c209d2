//! Files to [`Scene`](etendue_scene::Scene) and back: glTF 2.0 in its two forms, `.gltf` and `.glb`; OBJ, PLY and STL; and scene
//! files ([`scene_file`]), which put several models into one scene.
//!
//! ```no_run
//! use etendue_import::{ImportOptions, import};
//! let model = import("helmet.glb".as_ref(), &ImportOptions::default())?;
//! for w in &model.warnings {
//!     eprintln!("{w}");
//! }
//! println!("{} triangles", model.scene.triangle_count());
//! # Ok::<(), etendue_import::ImportError>(())
//! ```
//!
//! # How a file becomes a scene
//!
//! 1. `glb` splits the container, `json` and `document` read the JSON into typed values; faults carry a JSON pointer.
//! 2. `nodes` checks that the hierarchy is a forest; `buffers` loads the bytes and decodes compressed views
//!    ([`meshopt`]); [`draco`] decodes compressed primitives; `accessor` opens typed arrays in them, each checked to lie within its buffer before anything is read.
//! 3. `animation` evaluates the pose (`keyframes`; `pointer` and `changed` for values that are not a node's place); `plan` walks the visible nodes and notes which meshes have to be built, in which
//!    state of morphing and skinning, for which materials (the own one and those of variants: `material`, `surface`), and
//!    where they stand. Equal meshes are built once. Here
//!    everything is booked against the [`Limits`].
//! 4. `geometry` builds the meshes (`topology`, `skin`, `strokes`, `clean`, `tangents`) while `texture` decodes the images, on all
//!    cores.
//!
//! `door` chooses the reader: `obj` (with its materials), `ply` and `stl` stand beside glTF. Their meshes and materials are put
//! together by `assemble`; `polygon` cuts faces into triangles. `conformance` looks for what is against the specification though no
//! picture depends on it. `ies` reads how lamps shine, `sky` the surroundings that a glTF file brings along. [`mod@write`] makes glTF
//! of a scene; `rewrite` makes one file of a glTF file with everything that is in it, also what no scene has.
//!
//! # What never happens
//!
//! No input makes this crate panic, recurse without bound or allocate out of proportion to the bytes it was given. No
//! number that is not finite reaches the scene. Nothing in the file is left out silently: what is not supported is
//! named by a [`Warning`] or an [`ImportError`].
#![forbid(unsafe_code)]

mod accessor;
mod animation;
mod assemble;
mod buffers;
mod changed;
mod clean;
mod conformance;
mod document;
mod door;
pub mod draco;
mod drafts;
mod error;
mod extensions;
mod geometry;
mod glb;
mod gltf;
mod ies;
mod import;
mod info;
mod json;
mod keyframes;
mod limits;
mod material;
pub mod meshopt;
mod model;
mod nodes;
mod obj;
mod place;
mod plan;
mod ply;
mod pointer;
mod polygon;
mod progress;
mod rewrite;
pub mod scene_file;
mod sizes;
mod skin;
mod sky;
mod source;
mod stl;
mod strokes;
mod surface;
mod tangents;
mod text;
mod texture;
mod topology;
mod unusual;
mod uri;
mod warning;
pub mod write;

pub use animation::AnimationChoice;
pub use error::ImportError;
pub use extensions::{Support, support};
pub use ies::{IesError, IesFile, parse_ies, read_ies, write_ies};
pub use import::{ImageFile, ImportOptions, Imported, import, import_bytes};
pub use info::{
    AnimationInfo, CameraInfo, Counts, ExtensionInfo, ImageInfo, Info, LightInfo, MaterialInfo, MeshInfo,
    PrimitiveInfo,
};
pub use limits::Limits;
pub use model::{Model, ModelFile};
pub use progress::ImportProgress;
pub use rewrite::{Changes, RewriteError, Rewritten};
pub use sizes::Sizes;
pub use warning::Warning;
pub use write::{ExportError, ExportOptions, Exported, Form, export};
