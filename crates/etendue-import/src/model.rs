//! A model that is read once and shown at many moments.

use crate::door::{self, Kind};
use crate::error::{Fault, ImportError};
use crate::gltf::{Gltf, Text};
use crate::import::{ImportOptions, Imported, read_model};
use crate::limits::Limits;
use crate::rewrite::{self, RewriteError, Rewritten, Stopped};
use crate::write::Form;
use std::borrow::Cow;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The bytes of a model, read but not yet looked into, which a [`Model`] borrows from.
///
/// ```no_run
/// use etendue_import::{ImportOptions, ModelFile};
/// let options = ImportOptions::default();
/// let file = ModelFile::read("walk.glb".as_ref(), &options)?;
/// let model = file.open()?;
/// let frames: Result<Vec<_>, _> = (0..24).map(|n| model.at(Some(f64::from(n) / 24.0))).collect();
/// # let _ = frames?;
/// # Ok::<(), etendue_import::ImportError>(())
/// ```
pub struct ModelFile<'b> {
    name: String,
    folder: Option<PathBuf>,
    bytes: Cow<'b, [u8]>,
    options: ImportOptions,
    text: OnceLock<Text>,
}

impl ModelFile<'static> {
    /// Reads the file at `path`. [`ImportOptions::at`] does not matter.
    ///
    /// # Errors
    /// [`ImportError::Read`], and what exceeds [`crate::Limits::file_bytes`].
    pub fn read(path: &Path, options: &ImportOptions) -> Result<Self, ImportError> {
        let bytes = read_model(path, options)?;
        Ok(Self {
            name: path.display().to_string(),
            folder: Some(path.parent().unwrap_or(Path::new("")).to_owned()),
            bytes: bytes.into(),
            options: options.clone(),
            text: Default::default(),
        })
    }
}

impl<'b> ModelFile<'b> {
    /// A model in memory that needs no other files; see [`crate::import_bytes`].
    pub fn from_bytes(bytes: &'b [u8], name: &str, options: &ImportOptions) -> Self {
        let (name, options) = (name.to_owned(), options.clone());
        Self { name, folder: None, bytes: bytes.into(), options, text: Default::default() }
    }

    /// Looks into the file: of a glTF everything is read and decoded that is the same at all moments, of other formats
    /// everything.
    ///
    /// # Errors
    /// See [`ImportError`].
    pub fn open(&self) -> Result<Model<'_>, ImportError> {
        self.look(&self.options).map_err(|e| e.in_file(&self.name))
    }

    /// As [`Self::open`], within other limits.
    pub(crate) fn open_within(&self, limits: &Limits) -> Result<Model<'_>, ImportError> {
        let options = ImportOptions { limits: limits.clone(), ..self.options.clone() };
        self.look(&options).map_err(|e| e.in_file(&self.name))
    }

    /// The file as one glTF file with everything that it holds; `None` if it is no glTF.
    ///
    /// ```no_run
    /// use etendue_import::{Form, ImportOptions, ModelFile};
    /// let file = ModelFile::read("walk.gltf".as_ref(), &ImportOptions::default())?;
    /// if let Some(again) = file.rewrite(Form::Binary)? {
    ///     std::fs::write("walk.glb", again.bytes)?;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Whatever an import of the model at rest ends with; data that are not there; and a result that is too large.
    pub fn rewrite(&self, form: Form) -> Result<Option<Rewritten>, RewriteError> {
        let again = || {
            if door::kind(&self.bytes, &self.name)? != Kind::Gltf {
                return Ok(None);
            }
            rewrite::rewrite(&self.gltf(&self.options)?, &self.bytes, form).map(Some)
        };
        again().map_err(|e| match e {
            Stopped::Fault(f) => f.in_file(&self.name).into(),
            Stopped::TooLarge(n) => RewriteError::TooLarge(n),
        })
    }

    /// The document, read and decompressed.
    fn gltf(&self, options: &ImportOptions) -> Result<Gltf<'_>, Fault> {
        let text = match self.text.get() {
            Some(t) => t,
            None => {
                let read = Text::read(&self.bytes, options)?;
                self.text.get_or_init(|| read)
            }
        };
        Gltf::open(text, &self.bytes, &self.name, self.folder.as_deref(), options)
    }

    fn look(&self, options: &ImportOptions) -> Result<Model<'_>, Fault> {
        let folder = self.folder.as_deref();
        let content = match door::kind(&self.bytes, &self.name)? {
            Kind::Gltf => {
                let mut gltf = self.gltf(options)?;
                gltf.keep_meshes();
                Content::Moving(Box::new(gltf))
            }
            _ => Content::Still(Box::new(door::read(&self.bytes, &self.name, folder, options)?)),
        };
        let digest = crc32fast::hash(&self.bytes);
        Ok(Model { name: &self.name, content, digest })
    }
}

enum Content<'f> {
    Moving(Box<Gltf<'f>>),
    Still(Box<Imported>),
}

/// A model that can be shown at any moment of its animation. Pictures are decoded once. Meshes that are the same as at the
/// moment before are not built again: both scenes share them (the same `Arc`).
pub struct Model<'f> {
    name: &'f str,
    content: Content<'f>,
    digest: u32,
}

impl Model<'_> {
    /// The model `seconds` into its animation; `None` is at rest. The same as an import with [`ImportOptions::at`].
    ///
    /// # Errors
    /// See [`ImportError`].
    pub fn at(&self, seconds: Option<f64>) -> Result<Imported, ImportError> {
        match &self.content {
            Content::Moving(m) => m.at(seconds).map_err(|e| e.in_file(self.name)),
            Content::Still(m) => Ok((**m).clone()),
        }
    }

    /// From the first keyframe of the animation that the options chose to its last, seconds; `None` if there are none.
    ///
    /// # Errors
    /// See [`ImportError`].
    pub fn duration(&self) -> Result<Option<RangeInclusive<f64>>, ImportError> {
        match &self.content {
            Content::Moving(m) => m.duration().map_err(|e| e.in_file(self.name)),
            Content::Still(_) => Ok(None),
        }
    }

    /// CRC-32 of all bytes that say how the model moves: its file and the buffers beside it.
    pub fn digest(&self) -> u32 {
        match &self.content {
            Content::Moving(m) => m.buffers_digest(self.digest),
            Content::Still(_) => self.digest,
        }
    }
}
