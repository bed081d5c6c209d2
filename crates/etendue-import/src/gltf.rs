//! The way from a glTF file to a scene, step by step: what is the same at all moments, then a moment.

use crate::accessor::Accessors;
use crate::animation::{AnimationChoice, Pose};
use crate::buffers::Buffers;
use crate::changed::Changed;
use crate::document::Document;
use crate::draco;
use crate::error::Fault;
use crate::geometry::{Job, MeshKey};
use crate::import::{ImportOptions, Imported, drop_empty_meshes, image_files};
use crate::info::Info;
use crate::json::{self, Reader};
use crate::limits::{Budget, Limits};
use crate::nodes::{self, Hierarchy};
use crate::plan::Plan;
use crate::progress::ImportProgress;
use crate::sizes::Sizes;
use crate::source::Source;
use crate::texture::{self, Decoded};
use crate::warning::{Warning, Warnings};
use crate::{animation, conformance, glb, ies, skin, sky, unusual};
use etendue_scene::{Environment, Mesh, Scene};
use glam::{Affine3A, DAffine3};
use rayon::prelude::*;
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// The JSON of a file, parsed.
pub(crate) struct Text {
    tree: Value,
    bytes: u64,
    warnings: Warnings,
}

impl Text {
    /// Splits the container and parses its JSON.
    pub fn read(bytes: &[u8], options: &ImportOptions) -> Result<Self, Fault> {
        let mut warnings = Warnings::default();
        let parts = glb::split(bytes, &mut warnings)?;
        let length = parts.json.len() as u64;
        if length > options.limits.json_bytes {
            let what = format!("{length} bytes of JSON");
            return Err(Fault::TooLarge { pointer: String::new(), what, limit: "json_bytes" });
        }
        json::check_depth(parts.json, options.limits.json_depth)?;
        let tree = json::parse(parts.json, &mut warnings)?;
        Ok(Self { tree, bytes: length, warnings })
    }
}

/// A glTF file that can be shown at any moment.
pub(crate) struct Gltf<'f> {
    name: &'f str,
    pub folder: Option<&'f Path>,
    text: &'f Text,
    pub doc: Document<'f>,
    is_glb: bool,
    pub bytes: u64,
    hierarchy: Hierarchy,
    /// Nodes of the scene.
    shown: Vec<u32>,
    pub buffers: Buffers<'f>,
    pub budget: Budget,
    /// Those of all moments.
    warnings: Warnings,
    animation: AnimationChoice,
    pub occlusion: bool,
    keep_files: bool,
    /// What is against the specification, if that was asked for.
    breaches: Vec<Warning>,
    pub limits: Limits,
    progress: Option<Arc<ImportProgress>>,
    /// Profiles of lamps.
    lamps: ies::Loaded,
    sky: Option<sky::Sky>,
    /// By number in the file.
    images: Mutex<HashMap<u32, Decoded>>,
    /// Meshes of the last moment, if they are kept.
    meshes: Option<Mutex<HashMap<MeshKey, Kept>>>,
}

/// A mesh, and where the joints of its skin were.
#[derive(Clone)]
struct Kept {
    mesh: Arc<Mesh>,
    joints: Vec<Affine3A>,
}

/// The joints that the job's mesh hangs on.
fn joints_of<'j>(job: &Job, joints: &'j HashMap<u32, Vec<Affine3A>>) -> Option<&'j [Affine3A]> {
    job.key.skin.as_ref().and_then(|s| joints.get(&s.skin)).map(Vec::as_slice)
}

/// Reads glTF or GLB.
pub(crate) fn read(
    bytes: &[u8],
    name: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, Fault> {
    let text = Text::read(bytes, options)?;
    Gltf::open(&text, bytes, name, folder, options)?.at(options.at.map(f64::from))
}

impl<'f> Gltf<'f> {
    /// Reads the document and loads its buffers.
    pub fn open(
        text: &'f Text,
        bytes: &'f [u8],
        name: &'f str,
        folder: Option<&'f Path>,
        options: &ImportOptions,
    ) -> Result<Self, Fault> {
        let limits = &options.limits;
        // Its warnings are those of `text`.
        let parts = glb::split(bytes, &mut Warnings::default())?;
        let mut reader = Reader::new(text.warnings.clone(), options.drafts);
        let mut doc = Document::read(&mut reader, &text.tree, limits)?;
        let mut warnings = reader.warnings;
        let hierarchy = Hierarchy::new(&doc, limits)?;
        let shown = hierarchy.shown(&doc, &mut warnings)?;
        let used = bytes.len() as u64;
        let source = Source { folder, limits, used, keep_files: options.image_files };
        let mut buffers = Buffers::load(&doc, parts.binary, &source, &mut warnings)?;
        let mut budget = Budget::new(limits, bytes.len() as u64 + buffers.external);
        buffers.decompress(&doc, &mut budget)?;
        draco::expand(&mut doc, &mut buffers, &mut budget, &mut warnings)?;
        let lamps = ies::load(&doc, &buffers, &source, &mut warnings);
        let sky = sky::load(&doc, &buffers, &source, &mut warnings)?;
        let breaches = match options.conformance {
            true => conformance::breaches(&text.tree, &mut doc, &buffers, &parts, &source),
            false => Vec::new(),
        };
        Ok(Self {
            breaches,
            lamps,
            sky,
            name,
            folder,
            text,
            doc,
            is_glb: parts.is_glb,
            bytes: bytes.len() as u64,
            hierarchy,
            shown,
            buffers,
            budget,
            warnings,
            animation: options.animation.clone(),
            occlusion: options.occlusion,
            keep_files: options.image_files,
            limits: options.limits.clone(),
            progress: options.progress.clone(),
            images: Mutex::default(),
            meshes: None,
        })
    }

    /// Keeps meshes that do not change from moment to moment, so that they are built once.
    pub fn keep_meshes(&mut self) {
        self.meshes = Some(Mutex::default());
    }

    /// Gives the decoded pictures up.
    pub fn forget_images(&self) {
        self.images.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    pub fn accessors(&self) -> Accessors<'_> {
        Accessors { doc: &self.doc, buffers: &self.buffers }
    }

    /// First and last keyframe of the chosen animation, seconds.
    pub fn duration(&self) -> Result<Option<RangeInclusive<f64>>, Fault> {
        animation::duration(&self.animation, self.accessors())
    }

    /// `crc`, continued over the buffers that lie beside the file.
    pub fn buffers_digest(&self, crc: u32) -> u32 {
        self.buffers.digest(crc)
    }

    /// The scene `seconds` into the animation, or at rest.
    pub fn at(&self, seconds: Option<f64>) -> Result<Imported, Fault> {
        let (doc, accessors) = (&self.doc, self.accessors());
        let mut warnings = self.warnings.clone();
        let pose = match seconds {
            Some(seconds) => Pose::at(seconds, &self.animation, accessors, &mut warnings)?,
            None => Pose::default(),
        };
        let locals: Vec<DAffine3> = (0..doc.nodes.len() as u32)
            .map(|i| nodes::local(&pose.local(doc, i), || format!("/nodes/{i}"), &mut warnings))
            .collect();
        let globals = self.hierarchy.globals(&locals);

        let objects = pose.changes.objects(&self.text.tree, &mut warnings);
        let changed = Changed::read(&objects, doc.drafts)?;
        let hidden = self.hierarchy.hidden(|i| pose.visible(doc, i));
        let budget = self.budget.clone();
        let mut plan = Plan::new(accessors, &pose, &changed, &globals, self.occlusion, budget, warnings);
        plan.ies = self.lamps.clone();
        for &i in &self.shown {
            plan.node(i, hidden[i as usize])?;
        }
        let joints = joint_matrices(&mut plan, &globals, accessors)?;
        let used = self.bytes + self.buffers.external + plan.budget.booked();
        let source = Source { folder: self.folder, limits: &self.limits, used, keep_files: self.keep_files };
        let Plan {
            jobs, instances, materials, variants, textures, lights, mut cameras, mut warnings, ..
        } = plan;

        if let Some(p) = &self.progress {
            p.expect(jobs.len() + textures.images.len());
        }
        let known = match &self.meshes {
            Some(m) => m.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            None => HashMap::new(),
        };
        let (meshes, images) = rayon::join(
            || self.build_all(&jobs, &joints, &known),
            || self.decode_all(&textures.images, &source),
        );
        // In the order of the file, whichever thread was first.
        let mut built = Vec::with_capacity(meshes.len());
        for m in meshes {
            let (mesh, w) = m?;
            warnings.extend(w);
            built.push(mesh);
        }
        self.remember(&jobs, &joints, &built);
        let images = images?;
        cameras.sort_by_key(|&(number, _)| number);

        let shown = |s: &sky::Sky| {
            let changed = changed.skies.get(&s.number);
            changed.or(doc.image_lights.get(s.number as usize)).map(|light| s.at(light))
        };
        let environment: Environment = self.sky.as_ref().and_then(shown).unwrap_or_default();
        let mut scene = Scene {
            meshes: built,
            instances,
            materials,
            textures: textures.textures,
            images: images.iter().map(|d| d.image.clone()).collect(),
            lights,
            profiles: self.lamps.profiles.clone(),
            environment,
            cameras: cameras.into_iter().map(|(_, c)| c).collect(),
            variants,
        };
        drop_empty_meshes(&mut scene);
        let sound: HashSet<*const Mesh> = known.values().map(|k| Arc::as_ptr(&k.mesh)).collect();
        scene.validate_but(|m| sound.contains(&Arc::as_ptr(m))).map_err(|e| Fault::invalid("", e.0))?;
        texture::check_encoding(&scene, &textures.images, &images, &mut warnings);
        let mut info = Info::of_document(doc);
        info.file = self.name.to_owned();
        info.format = if self.is_glb { "GLB" } else { "glTF" };
        info.bytes = self.bytes;
        info.sizes = Sizes::of(doc, self.text.bytes);
        info.unusual = unusual::of_document(doc);
        info.breaches = self.breaches.clone();
        info.add_scene(&scene, self.shown.len(), &textures.images, &images, &self.buffers);
        let image_files = image_files(&images, self.keep_files);
        Ok(Imported { scene, warnings: warnings.into_vec(), info, image_files })
    }

    /// One more mesh or picture is ready.
    fn step(&self) {
        if let Some(p) = &self.progress {
            p.step();
        }
    }

    /// The pictures `which`, decoded now or at an earlier moment.
    fn decode_all(&self, which: &[u32], source: &Source<'_>) -> Result<Vec<Decoded>, Fault> {
        let mut known = self.images.lock().unwrap_or_else(PoisonError::into_inner);
        let missing: Vec<u32> = which.iter().copied().filter(|i| !known.contains_key(i)).collect();
        let already = known.values().map(|d| d.image.bytes() as u64).sum();
        (missing.len()..which.len()).for_each(|_| self.step());
        let decoded =
            texture::decode_all(&self.doc, &missing, &self.buffers, source, already, &|| self.step());
        for (i, d) in missing.into_iter().zip(decoded) {
            known.insert(i, d?);
        }
        Ok(which.iter().filter_map(|i| known.get(i).cloned()).collect())
    }

    fn build_all(
        &self,
        jobs: &[Job],
        joints: &HashMap<u32, Vec<Affine3A>>,
        known: &HashMap<MeshKey, Kept>,
    ) -> Vec<Result<(Arc<Mesh>, Warnings), Fault>> {
        jobs.par_iter()
            .map(|job| {
                let mut warnings = Warnings::default();
                let joints = joints_of(job, joints);
                if let Some(k) = known.get(&job.key).filter(|k| k.joints == joints.unwrap_or_default()) {
                    self.step();
                    let same = k.mesh.name == job.name;
                    let named = || Arc::new(Mesh { name: job.name.clone(), ..(*k.mesh).clone() });
                    return Ok((if same { k.mesh.clone() } else { named() }, warnings));
                }
                let mesh = job.build(self.accessors(), joints, &mut warnings)?;
                self.step();
                Ok((Arc::new(mesh), warnings))
            })
            .collect()
    }

    /// Keeps what the next moment may need again, and nothing else.
    fn remember(&self, jobs: &[Job], joints: &HashMap<u32, Vec<Affine3A>>, meshes: &[Arc<Mesh>]) {
        let Some(kept) = &self.meshes else { return };
        let now = jobs.iter().zip(meshes).map(|(job, mesh)| {
            let joints = joints_of(job, joints).unwrap_or_default().to_vec();
            (job.key.clone(), Kept { mesh: mesh.clone(), joints })
        });
        *kept.lock().unwrap_or_else(PoisonError::into_inner) = now.collect();
    }
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
