//! What can be asked for, and what comes of it.

use crate::animation::AnimationChoice;
use crate::door;
use crate::error::{Fault, ImportError};
use crate::info::Info;
use crate::limits::Limits;
use crate::progress::ImportProgress;
use crate::source::{ReadError, read_file};
use crate::texture;
use crate::warning::Warning;
use etendue_scene::Scene;
use std::path::Path;
use std::sync::Arc;

/// What to import, and how much it may take.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Seconds into the animation; `None` is the model at rest.
    pub at: Option<f32>,
    /// Which animation `at` refers to.
    pub animation: AnimationChoice,
    /// Whether occlusion and thickness textures are loaded. Light transport computes both itself and can do without them.
    pub occlusion: bool,
    /// Whether [`Imported::image_files`] is filled: for those who write the pictures again.
    pub image_files: bool,
    /// Whether drafts of extensions are read ([`Support::Draft`](crate::Support::Draft)): they may still change, and then the
    /// picture does. Without it they are ignored with a warning, and a file that requires one is refused.
    pub drafts: bool,
    /// Whether [`Info::breaches`] is filled: for those who want to know all that is wrong with a glTF file. Takes a pass over all
    /// its data.
    pub conformance: bool,
    /// Bounds on memory.
    pub limits: Limits,
    /// Where the import tells how far it is, if somebody wants to know.
    pub progress: Option<Arc<ImportProgress>>,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            at: None,
            animation: AnimationChoice::First,
            occlusion: true,
            image_files: false,
            drafts: false,
            conformance: false,
            limits: Limits::default(),
            progress: None,
        }
    }
}

/// An imported model.
#[derive(Clone, Debug)]
pub struct Imported {
    /// What it shows. [`Scene::validate`] has passed.
    pub scene: Scene,
    /// What was ignored or mended, each kind once.
    pub warnings: Vec<Warning>,
    /// What the file contains.
    pub info: Info,
    /// The files that [`Scene::images`] were decoded from, in the same order, if the options ask for them; `None` for a
    /// picture that was made on the way. Empty otherwise.
    pub image_files: Vec<Option<ImageFile>>,
}

/// The bytes of a picture as it stood in the model or beside it.
#[derive(Clone, Debug)]
pub struct ImageFile {
    /// `PNG`, `JPEG`, `WebP` or another format by its name.
    pub format: &'static str,
    /// The file.
    pub bytes: Arc<Vec<u8>>,
}

/// The files of decoded images, if they were kept.
pub(crate) fn image_files(images: &[texture::Decoded], keep: bool) -> Vec<Option<ImageFile>> {
    if !keep {
        return Vec::new();
    }
    images.iter().map(|d| d.file.clone().map(|bytes| ImageFile { format: d.format, bytes })).collect()
}

/// Reads the model at `path`, and the files that it refers to: glTF, GLB, OBJ, PLY or STL, told apart by what it contains, or
/// by its extension where that does not tell.
///
/// # Errors
/// See [`ImportError`].
pub fn import(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let name = path.display().to_string();
    let bytes = read_model(path, options)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    door::read(&bytes, &name, Some(folder), options).map_err(|e| e.in_file(&name))
}

/// The bytes of the model at `path`.
pub(crate) fn read_model(path: &Path, options: &ImportOptions) -> Result<Vec<u8>, ImportError> {
    let name = path.display().to_string();
    let (most, limit) = options.limits.for_file();
    read_file(path, most).map_err(|e| match e {
        ReadError::Io(source) => ImportError::Read { file: name.clone(), source },
        ReadError::TooLarge(n) => {
            let what = format!("{n} bytes");
            Fault::TooLarge { pointer: String::new(), what, limit }.in_file(&name)
        }
    })
}

/// Reads a model that needs no other files from memory. `name` stands for it in messages, and its extension tells formats
/// apart whose content does not.
///
/// # Errors
/// See [`ImportError`].
pub fn import_bytes(bytes: &[u8], name: &str, options: &ImportOptions) -> Result<Imported, ImportError> {
    door::read(bytes, name, None, options).map_err(|e| e.in_file(name))
}

/// Removes meshes without triangles, and their instances; the variants follow.
pub(crate) fn drop_empty_meshes(scene: &mut Scene) {
    if scene.meshes.iter().all(|m| !m.indices.is_empty()) {
        return;
    }
    let mut number = Vec::with_capacity(scene.meshes.len());
    let mut next = 0;
    for m in &scene.meshes {
        number.push((!m.indices.is_empty()).then_some(next));
        next += u32::from(!m.indices.is_empty());
    }
    scene.meshes.retain(|m| !m.indices.is_empty());
    let mut place = Vec::with_capacity(scene.instances.len());
    let mut next = 0;
    scene.instances.retain_mut(|i| {
        let kept = number[i.mesh as usize];
        place.push(kept.is_some().then_some(next));
        next += u32::from(kept.is_some());
        i.mesh = kept.unwrap_or(i.mesh);
        kept.is_some()
    });
    for v in &mut scene.variants {
        v.materials.retain_mut(|[instance, _]| match place[*instance as usize] {
            Some(n) => {
                *instance = n;
                true
            }
            None => false,
        });
    }
}
