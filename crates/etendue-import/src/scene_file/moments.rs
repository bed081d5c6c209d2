//! A scene file that is read once, with its models, and shown at many moments.

use super::load::{Cache, Key, LoadOptions};
use super::{Placed, SceneFile, SceneFileError};
use crate::import::Imported;
use crate::limits::Limits;
use crate::model::{Model, ModelFile};
use crate::{AnimationChoice, ImportError};
use std::cell::RefCell;
use std::path::PathBuf;

/// A scene file and the bytes of its models, which a [`MovingScene`] borrows from.
///
/// ```no_run
/// use etendue_import::scene_file::{LoadOptions, SceneFile};
/// let file = SceneFile::read("room.toml".as_ref(), &Default::default())?;
/// let models = file.with_models(&LoadOptions::default())?;
/// let scene = models.open();
/// let frames: Result<Vec<_>, _> = (0..24).map(|n| scene.at(Some(f64::from(n) / 24.0))).collect();
/// # let _ = frames?;
/// # Ok::<(), etendue_import::scene_file::SceneFileError>(())
/// ```
pub struct SceneModels<'b> {
    scene: SceneFile,
    options: LoadOptions<'b>,
    files: Vec<Named<'b>>,
}

/// The bytes of a model, and what chose them.
struct Named<'b> {
    file: PathBuf,
    builtin: Option<String>,
    animation: AnimationChoice,
    bytes: ModelFile<'b>,
}

impl Named<'_> {
    fn is(&self, placed: &Placed) -> bool {
        (&self.file, &self.builtin, &self.animation) == (&placed.file, &placed.builtin, &placed.animation)
    }
}

impl SceneFile {
    /// Reads the files of the models. The time of `options` does not matter.
    ///
    /// # Errors
    /// A model that cannot be read, with the line that names it.
    pub fn with_models<'b>(self, options: &LoadOptions<'b>) -> Result<SceneModels<'b>, SceneFileError> {
        let mut files: Vec<Named<'b>> = Vec::new();
        for placed in &self.models {
            if files.iter().any(|f| f.is(placed)) {
                continue;
            }
            let import = self.import_options(placed, None, options, options.import.limits.clone());
            let bytes = match self.builtin(placed, options)? {
                Some((name, bytes)) => ModelFile::from_bytes(bytes, name, &import),
                None => ModelFile::read(&placed.file, &import).map_err(|e| self.of_model(placed, e))?,
            };
            files.push(Named {
                file: placed.file.clone(),
                builtin: placed.builtin.clone(),
                animation: placed.animation.clone(),
                bytes,
            });
        }
        Ok(SceneModels { scene: self, options: options.clone(), files })
    }
}

impl SceneModels<'_> {
    /// The scene, ready to be shown.
    pub fn open(&self) -> MovingScene<'_> {
        MovingScene { models: self, opened: RefCell::default(), cache: RefCell::new(Cache::kept()) }
    }
}

/// A model that has been looked into.
struct Opened<'m> {
    /// Which of the files.
    file: usize,
    /// The moment that the scene file asks for, if the scene is shown at rest.
    at: Option<u32>,
    model: Model<'m>,
}

/// A scene file that can be shown at any moment. No file is read twice, and moments share what did not change, as those of a
/// [`Model`] do.
pub struct MovingScene<'m> {
    models: &'m SceneModels<'m>,
    opened: RefCell<Vec<Opened<'m>>>,
    cache: RefCell<Cache>,
}

impl<'m> MovingScene<'m> {
    /// The scene with all models `seconds` into their animations; `None` shows each at the time that the file says, or at rest. The
    /// same as [`SceneFile::load`] at that time.
    ///
    /// # Errors
    /// Those of [`SceneFile::load`].
    pub fn at(&self, seconds: Option<f64>) -> Result<Imported, SceneFileError> {
        let SceneModels { scene, options, .. } = self.models;
        let mut options = options.clone();
        options.import.at = seconds.map(|t| t as f32);
        let mut opened = self.opened.borrow_mut();
        let mut model = |placed: &Placed, key: &Key<'_>, limits: Limits| -> Result<Imported, ImportError> {
            let own = if seconds.is_none() { key.at() } else { None };
            let known = opened
                .iter()
                .position(|o| o.at == own.map(f32::to_bits) && self.models.files[o.file].is(placed));
            let number = match known {
                Some(n) => n,
                None => {
                    // All were read.
                    let file = self.models.files.iter().position(|f| f.is(placed)).unwrap_or_default();
                    let model = self.models.files[file].bytes.open_within(&limits)?;
                    opened.push(Opened { file, at: own.map(f32::to_bits), model });
                    opened.len() - 1
                }
            };
            opened[number].model.at(seconds.or(own.map(f64::from)))
        };
        scene.compose(&options, &mut self.cache.borrow_mut(), &mut model)
    }

    /// CRC-32 of all bytes that say how the scene moves: its file, its models and the buffers beside them.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn digest(&self) -> Result<u32, SceneFileError> {
        if self.opened.borrow().is_empty() {
            self.at(None)?;
        }
        let mut h = crc32fast::Hasher::new();
        h.update(self.models.scene.text.text.as_bytes());
        let opened = self.opened.borrow();
        for n in 0..self.models.files.len() {
            if let Some(o) = opened.iter().find(|o| o.file == n) {
                h.update(&o.model.digest().to_le_bytes());
            }
        }
        Ok(h.finalize())
    }
}
