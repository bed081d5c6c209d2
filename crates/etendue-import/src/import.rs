//! The way from a file to a scene, step by step.

use crate::accessor::Accessors;
use crate::animation::{AnimationChoice, Pose};
use crate::buffers::Buffers;
use crate::document::Document;
use crate::draco;
use crate::error::{Fault, ImportError};
use crate::geometry::Job;
use crate::info::Info;
use crate::json::{self, Reader};
use crate::limits::{Budget, Limits};
use crate::nodes::{self, Hierarchy};
use crate::plan::Plan;
use crate::sizes::Sizes;
use crate::source::{ReadError, Source, read_file};
use crate::texture;
use crate::warning::{Warning, Warnings};
use crate::{door, glb, skin, unusual};
use etendue_scene::{Mesh, Scene};
use glam::{Affine3A, DAffine3};
use rayon::prelude::*;
use std::collections::HashMap;
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
    /// Bounds on memory.
    pub limits: Limits,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            at: None,
            animation: AnimationChoice::First,
            occlusion: true,
            image_files: false,
            limits: Limits::default(),
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
    let bytes = read_file(path, options.limits.file_bytes).map_err(|e| match e {
        ReadError::Io(source) => ImportError::Read { file: name.clone(), source },
        ReadError::TooLarge(n) => {
            let what = format!("{n} bytes");
            Fault::TooLarge { pointer: String::new(), what, limit: "file_bytes" }.in_file(&name)
        }
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    door::read(&bytes, &name, Some(folder), options).map_err(|e| e.in_file(&name))
}

/// Reads a model that needs no other files from memory. `name` stands for it in messages, and its extension tells formats
/// apart whose content does not.
///
/// # Errors
/// See [`ImportError`].
pub fn import_bytes(bytes: &[u8], name: &str, options: &ImportOptions) -> Result<Imported, ImportError> {
    door::read(bytes, name, None, options).map_err(|e| e.in_file(name))
}

/// Reads glTF or GLB.
pub(crate) fn gltf(
    bytes: &[u8],
    name: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, Fault> {
    let limits = &options.limits;
    let mut warnings = Warnings::default();
    let parts = glb::split(bytes, &mut warnings)?;
    if parts.json.len() as u64 > limits.json_bytes {
        let what = format!("{} bytes of JSON", parts.json.len());
        return Err(Fault::TooLarge { pointer: String::new(), what, limit: "json_bytes" });
    }
    let tree = json::parse(parts.json, &mut warnings)?;
    let mut reader = Reader::new(warnings);
    let mut doc = Document::read(&mut reader, &tree, limits)?;
    let mut warnings = reader.warnings;
    let hierarchy = Hierarchy::new(&doc, limits)?;
    let visible = hierarchy.visible(&doc, &mut warnings)?;
    let source = Source { folder, limits, keep_files: options.image_files };
    let mut buffers = Buffers::load(&doc, parts.binary, &source, &mut warnings)?;
    let mut budget = Budget::new(limits, bytes.len() as u64 + buffers.external);
    buffers.decompress(&doc, &mut budget)?;
    draco::expand(&mut doc, &mut buffers, &mut budget, &mut warnings)?;
    let accessors = Accessors { doc: &doc, buffers: &buffers };

    let pose = match options.at {
        Some(seconds) => Pose::at(seconds, &options.animation, accessors, &mut warnings)?,
        None => Pose::default(),
    };
    let locals: Vec<DAffine3> = (0..doc.nodes.len() as u32)
        .map(|i| nodes::local(&pose.local(&doc, i), || format!("/nodes/{i}"), &mut warnings))
        .collect();
    let globals = hierarchy.globals(&locals);

    let mut plan = Plan::new(accessors, &pose, &globals, options.occlusion, budget, warnings);
    for &i in &visible {
        plan.node(i)?;
    }
    let joints = joint_matrices(&mut plan, &globals, accessors)?;
    let Plan { jobs, instances, materials, variants, textures, lights, mut cameras, mut warnings, .. } = plan;

    let (meshes, images) = rayon::join(
        || build_all(&jobs, &joints, accessors),
        || texture::decode_all(&doc, &textures.images, &buffers, &source),
    );
    // In the order of the file, whichever thread was first.
    let mut built = Vec::with_capacity(meshes.len());
    for m in meshes {
        let (mesh, w) = m?;
        warnings.extend(w);
        built.push(mesh);
    }
    let images = images.into_iter().collect::<Result<Vec<_>, _>>()?;
    cameras.sort_by_key(|&(number, _)| number);

    let mut scene = Scene {
        meshes: built,
        instances,
        materials,
        textures: textures.textures,
        images: images.iter().map(|d| d.image.clone()).collect(),
        lights,
        cameras: cameras.into_iter().map(|(_, c)| c).collect(),
        variants,
        ..Scene::default()
    };
    drop_empty_meshes(&mut scene);
    scene.validate().map_err(|e| Fault::invalid("", e.0))?;
    texture::check_encoding(&scene, &textures.images, &images, &mut warnings);
    let mut info = Info::of_document(&doc);
    info.file = name.to_owned();
    info.format = if parts.is_glb { "GLB" } else { "glTF" };
    info.bytes = bytes.len() as u64;
    info.sizes = Sizes::of(&doc, parts.json.len() as u64);
    info.unusual = unusual::of_document(&doc);
    info.add_scene(&scene, visible.len(), &textures.images, &images, &buffers);
    let image_files = image_files(&images, options.image_files);
    Ok(Imported { scene, warnings: warnings.into_vec(), info, image_files })
}

/// The joints of every skin that a planned mesh hangs on.
fn joint_matrices(
    plan: &mut Plan<'_>,
    globals: &[DAffine3],
    accessors: Accessors<'_>,
) -> Result<HashMap<u32, Vec<Affine3A>>, Fault> {
    let mut joints = HashMap::new();
    for job in &plan.jobs {
        if let Some(key) = &job.key.skin
            && !joints.contains_key(&key.skin)
        {
            joints.insert(key.skin, skin::joint_matrices(key.skin, globals, accessors, &mut plan.warnings)?);
        }
    }
    Ok(joints)
}

fn build_all(
    jobs: &[Job],
    joints: &HashMap<u32, Vec<Affine3A>>,
    accessors: Accessors<'_>,
) -> Vec<Result<(Mesh, Warnings), Fault>> {
    jobs.par_iter()
        .map(|job| {
            let mut warnings = Warnings::default();
            let joints = job.key.skin.as_ref().and_then(|s| joints.get(&s.skin)).map(Vec::as_slice);
            let mesh = job.build(accessors, joints, &mut warnings)?;
            Ok((mesh, warnings))
        })
        .collect()
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
