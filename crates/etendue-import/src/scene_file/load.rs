//! From a scene file to a scene: loads each model once, places it, changes materials, adds lights.

use super::error::SceneFileError;
use super::merge::{Part, Union};
use super::nearest::nearest;
use super::overrides::{ALL, Override};
use super::place::Placed;
use super::{SceneFile, shorten};
use crate::geometry::TangentSpace;
use crate::import::{ImageFile, ImportOptions, Imported, import, import_bytes};
use crate::info::ImageInfo;
use crate::limits::Limits;
use crate::source::{Source, read_file};
use crate::texture::Decoded;
use crate::{ImportError, plan, tangents};
use etendue_scene::{MeasuredMaterial, Mesh, Sampler, Scene, Texture, TextureRef};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How what a scene file names is loaded.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions<'a> {
    /// As for one model; the limits hold for all of them together. A time goes before those of the file.
    pub import: ImportOptions,
    /// Names and bytes of models that need no file.
    pub builtins: &'a [(&'a str, &'a [u8])],
    /// A set of materials for all models that have it, before those of the file.
    pub variant: Option<&'a str>,
}

/// Pictures that overrides name, each once in the scene.
type Pictures = HashMap<PathBuf, u32>;

/// Imports a model within limits.
pub(super) type Import<'i> = dyn FnMut(&Placed, &Key<'_>, Limits) -> Result<Imported, ImportError> + 'i;

/// What the next moment may need again.
#[derive(Default)]
pub(super) struct Cache {
    /// There may be one.
    keep: bool,
    pictures: HashMap<PathBuf, Decoded>,
    measured: HashMap<PathBuf, MeasuredMaterial>,
    /// Meshes, along what they have tangents, and the same with them.
    tangents: Vec<(Arc<Mesh>, TangentSpace, Arc<Mesh>)>,
}

impl Cache {
    /// One that keeps things.
    pub fn kept() -> Self {
        Self { keep: true, ..Self::default() }
    }
}

impl SceneFile {
    /// Loads the models and puts the scene together. Its sky and its camera are the program's to choose: the scene has
    /// none but the cameras of its models.
    ///
    /// # Errors
    /// A model that does not load, with the line that names it; a material or variant that there is not.
    pub fn load(&self, options: &LoadOptions<'_>) -> Result<Imported, SceneFileError> {
        let mut model = |placed: &Placed, key: &Key<'_>, limits: Limits| {
            let import_options = self.import_options(placed, key.at(), options, limits);
            match &placed.builtin {
                None => import(&placed.file, &import_options),
                Some(name) => {
                    let bytes = options.builtins.iter().find(|(n, _)| n == name).map_or(&[][..], |(_, b)| *b);
                    import_bytes(bytes, name, &import_options)
                }
            }
        };
        self.compose(options, &mut Cache::default(), &mut model)
    }

    /// As [`Self::load`], with models from `import`.
    pub(super) fn compose(
        &self,
        options: &LoadOptions<'_>,
        cache: &mut Cache,
        import: &mut Import<'_>,
    ) -> Result<Imported, SceneFileError> {
        let mut all = Union::default();
        let mut parts: Vec<(Key<'_>, Part)> = Vec::new();
        let mut pictures = Pictures::new();
        let mut materials = Vec::new();
        for (placed, own) in self.models.iter().zip(&self.own_overrides) {
            let key = Key::of(placed, &options.import);
            let known = parts.iter().position(|(k, _)| *k == key);
            let number = match known {
                Some(n) => n,
                None => {
                    self.builtin(placed, options)?;
                    let limits = options.import.limits.left_by(&all.scene);
                    let model = import(placed, &key, limits).map_err(|e| self.of_model(placed, e))?;
                    parts.push((key, all.add(model, &placed.label())));
                    parts.len() - 1
                }
            };
            let part = &parts[number].1;
            let instances = (all.scene.instances.len() + part.instances()) as u64;
            // Each place has materials, lights and cameras of its own, too.
            let placed_things = instances + (all.scene.materials.len() + all.scene.lights.len()) as u64;
            if placed_things > options.import.limits.instances {
                let what = format!(
                    "line {}: more than {} instances",
                    self.text.place(placed.span.start).0,
                    options.import.limits.instances
                );
                return Err(SceneFileError::TooLarge {
                    file: self.text.file.clone(),
                    what,
                    limit: "instances",
                });
            }
            let variant = self.variant(placed, part, options.variant)?;
            let first = all.scene.instances.len();
            let spell_out = !(self.overrides.is_empty() && own.is_empty());
            materials.push(all.place(part, &placed.transform(), variant, &placed.label(), spell_out));
            if let Some(i) = all.scene.instances[first..].iter().find(|i| !i.transform.is_finite()) {
                let message =
                    format!("{:?} of this model would stand where no number reaches", shorten(&i.name));
                return Err(self.text.wrong(&placed.span, message, None));
            }
        }
        // From what is said of all materials of all models to what is said of one of one model.
        let everything = 0..all.scene.materials.len();
        for o in in_order(&self.overrides) {
            self.change(o, &mut all, everything.clone(), &mut pictures, options, cache)?;
        }
        for (own, materials) in self.own_overrides.iter().zip(materials) {
            for o in in_order(own) {
                self.change(o, &mut all, materials.clone(), &mut pictures, options, cache)?;
            }
        }
        all.scene.lights.extend(self.lights.iter().cloned());
        let fresh = add_tangents(&mut all.scene, cache);
        // The models' meshes were looked into when they were loaded.
        all.scene
            .validate_but(|m| !fresh.contains(&Arc::as_ptr(m)))
            .map_err(|e| self.text.wrong(&(0..0), format!("the scene is inconsistent: {e}"), None))?;
        let mut info = all.info;
        info.file.clone_from(&self.text.file);
        info.format = "scene file";
        info.bytes = self.text.text.len() as u64;
        info.counts.instances = all.scene.instances.len() as u64;
        info.counts.shown_triangles = all.scene.triangle_count();
        let image_files = if options.import.image_files { all.image_files } else { Vec::new() };
        Ok(Imported { scene: all.scene, warnings: all.warnings.into_vec(), info, image_files })
    }

    /// How a model is imported.
    pub(super) fn import_options(
        &self,
        placed: &Placed,
        at: Option<f32>,
        options: &LoadOptions<'_>,
        limits: Limits,
    ) -> ImportOptions {
        ImportOptions { at, animation: placed.animation.clone(), limits, ..options.import.clone() }
    }

    /// The built-in model that is placed, if it is one.
    pub(super) fn builtin<'b>(
        &self,
        placed: &Placed,
        options: &LoadOptions<'b>,
    ) -> Result<Option<(&'b str, &'b [u8])>, SceneFileError> {
        let Some(name) = &placed.builtin else { return Ok(None) };
        match options.builtins.iter().find(|(n, _)| n == name) {
            Some(found) => Ok(Some(*found)),
            None => Err(self.text.wrong(&placed.span, format!("there is no built-in model {name:?}"), None)),
        }
    }

    /// The error of a model, with its place.
    pub(super) fn of_model(&self, placed: &Placed, source: ImportError) -> SceneFileError {
        SceneFileError::Model {
            file: self.text.file.clone(),
            line: self.text.place(placed.span.start).0,
            source: Box::new(source),
        }
    }

    /// Which set of materials a place of a model has.
    fn variant<'a>(
        &'a self,
        placed: &'a Placed,
        part: &Part,
        wanted: Option<&'a str>,
    ) -> Result<Option<&'a str>, SceneFileError> {
        let names = part.variants();
        if let Some(w) = wanted.filter(|w| names.clone().any(|n| n == *w)) {
            return Ok(Some(w));
        }
        match placed.variant.as_deref() {
            Some(v) if !names.clone().any(|n| n == v) => {
                let help = listed(v, names.clone(), "the model has no variants");
                Err(self.text.wrong(&placed.span, format!("the model has no variant {v:?}"), Some(help)))
            }
            other => Ok(other),
        }
    }

    /// Applies an override to materials of these numbers.
    fn change(
        &self,
        o: &Override,
        all: &mut Union,
        materials: Range<usize>,
        pictures: &mut Pictures,
        options: &LoadOptions<'_>,
        cache: &mut Cache,
    ) -> Result<(), SceneFileError> {
        let named = |i: &usize| o.material == ALL || all.scene.materials[*i].name == o.material;
        let which: Vec<usize> = materials.clone().filter(named).collect();
        if which.is_empty() && o.material != ALL {
            let names =
                all.scene.materials[materials].iter().map(|m| m.name.as_str()).filter(|n| !n.is_empty());
            let help = listed(&o.material, names, "its materials have no names; \"*\" stands for all");
            let message = format!("there is no material {:?}", shorten(&o.material));
            return Err(self.text.wrong(&o.span, message, Some(help)));
        }
        let measured = match &o.measured {
            Some((path, _)) if cache.measured.contains_key(path) => cache.measured.get(path).cloned(),
            Some((path, span)) => {
                let fail = |e: String| self.text.wrong(span, format!("{}: {e}", path.display()), None);
                let bytes =
                    read_file(path, options.import.limits.for_file().0).map_err(|e| fail(e.to_string()))?;
                let read = MeasuredMaterial::from_bytes(&bytes).map_err(|e| fail(e.to_string()))?;
                cache.measured.insert(path.clone(), read.clone());
                Some(read)
            }
            None => None,
        };
        let mut loaded = Vec::with_capacity(o.textures.len());
        for (_, file, span) in &o.textures {
            loaded.push(match file {
                Some(path) => Some(self.texture(path, span, all, pictures, options, cache)?),
                None => None,
            });
        }
        for i in which {
            o.apply(&mut all.scene.materials[i], measured.as_ref(), &loaded);
        }
        Ok(())
    }

    /// The texture of a picture file, by UV set 0.
    fn texture(
        &self,
        path: &Path,
        span: &Range<usize>,
        all: &mut Union,
        pictures: &mut Pictures,
        options: &LoadOptions<'_>,
        cache: &mut Cache,
    ) -> Result<TextureRef, SceneFileError> {
        if let Some(&t) = pictures.get(path) {
            return Ok(TextureRef::new(t));
        }
        let decoded = match cache.pictures.get(path) {
            Some(known) => known.clone(),
            None => {
                let decoded = self.picture(path, span, &all.scene, options)?;
                if cache.keep {
                    cache.pictures.insert(path.to_path_buf(), decoded.clone());
                }
                decoded
            }
        };
        let mut info = ImageInfo { uri: Some(path.display().to_string()), ..ImageInfo::default() };
        info.set_decoded(&decoded);
        all.info.counts.images += 1;
        all.info.counts.textures += 1;
        all.info.counts.image_bytes += info.decoded_bytes;
        all.info.images.push(info);
        let format = decoded.format;
        all.image_files.push(decoded.file.map(|bytes| ImageFile { format, bytes }));
        let number = all.scene.textures.len() as u32;
        all.scene
            .textures
            .push(Texture { image: all.scene.images.len() as u32, sampler: Sampler::default() });
        all.scene.images.push(decoded.image);
        pictures.insert(path.to_path_buf(), number);
        Ok(TextureRef::new(number))
    }

    /// A picture, within what the scene has left of the limits.
    fn picture(
        &self,
        path: &Path,
        span: &Range<usize>,
        scene: &Scene,
        options: &LoadOptions<'_>,
    ) -> Result<Decoded, SceneFileError> {
        let fail = |e: String| self.text.wrong(span, format!("{}: {e}", path.display()), None);
        let limits = options.import.limits.left_by(scene);
        let bytes = read_file(path, limits.for_file().0).map_err(|e| fail(e.to_string()))?;
        let used = bytes.len() as u64;
        let source = Source { folder: None, limits: &limits, used, keep_files: options.import.image_files };
        let image = source.decode(&bytes, limits.for_images(used).0).map_err(fail)?;
        Ok(source.decoded(Arc::new(image), bytes))
    }
}

/// What makes two models the same.
#[derive(PartialEq)]
pub(super) struct Key<'a> {
    file: &'a Path,
    builtin: Option<&'a str>,
    at: Option<u32>,
    animation: &'a crate::AnimationChoice,
}

impl<'a> Key<'a> {
    fn of(placed: &'a Placed, options: &ImportOptions) -> Self {
        Self {
            file: &placed.file,
            builtin: placed.builtin.as_deref(),
            at: options.at.or(placed.at).map(f32::to_bits),
            animation: &placed.animation,
        }
    }

    /// Seconds into its animation.
    pub fn at(&self) -> Option<f32> {
        self.at.map(f32::from_bits)
    }
}

/// What is said of all materials first.
fn in_order(overrides: &[Override]) -> impl Iterator<Item = &Override> {
    let of_all = |o: &&Override| o.material == ALL;
    overrides.iter().filter(of_all).chain(overrides.iter().filter(move |o| !of_all(o)))
}

/// What was probably meant, or what there is.
fn listed<'n>(word: &str, names: impl Iterator<Item = &'n str> + Clone, none: &str) -> String {
    if let Some(n) = nearest(word, names.clone()) {
        return format!("did you mean {n:?}?");
    }
    let mut list: Vec<_> = names.collect();
    list.sort_unstable();
    list.dedup();
    if list.is_empty() {
        return none.to_owned();
    }
    let more = list.len().saturating_sub(40);
    let shown: Vec<_> = list.iter().take(40).map(|n| format!("{:?}", shorten(n))).collect();
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("there are {}{rest}", shown.join(", "))
}

/// Gives tangents to meshes whose materials need them since an override said so. Returns those that got new ones.
fn add_tangents(scene: &mut Scene, cache: &mut Cache) -> Vec<*const Mesh> {
    let (mut fresh, mut used) = (Vec::new(), Vec::new());
    for i in &scene.instances {
        let material = i.material.and_then(|m| scene.materials.get(m as usize));
        let mesh = &mut scene.meshes[i.mesh as usize];
        if let Some(space) = material.and_then(plan::tangent_space)
            && mesh.tangents.is_empty()
            && (space.uv_set as usize) < mesh.uvs.len()
        {
            if let Some(known) = cache.tangents.iter().find(|k| Arc::ptr_eq(&k.0, mesh) && k.1 == space) {
                *mesh = known.2.clone();
                used.push(known.clone());
                continue;
            }
            let without = cache.keep.then(|| mesh.clone());
            tangents::generate(Arc::make_mut(mesh), space.uv_set as usize, &space.transform());
            fresh.push(Arc::as_ptr(mesh));
            used.extend(without.map(|w| (w, space, mesh.clone())));
        }
    }
    cache.tangents = used;
    fresh
}

impl Limits {
    /// What a scene that is loaded leaves for others.
    fn left_by(&self, scene: &Scene) -> Self {
        let images: u64 = scene.images.iter().map(|i| i.bytes() as u64).sum();
        let vertices: u64 = scene.meshes.iter().map(|m| m.positions.len() as u64).sum();
        let geometry: u64 = scene.meshes.iter().map(|m| m.bytes()).sum();
        Self {
            memory_bytes: self.memory_bytes.saturating_sub(images).saturating_sub(geometry),
            image_bytes: self.image_bytes.saturating_sub(images),
            vertices: self.vertices.saturating_sub(vertices),
            instances: self.instances.saturating_sub(scene.instances.len() as u64),
            geometry_bytes: self.geometry_bytes.saturating_sub(geometry),
            ..self.clone()
        }
    }
}
