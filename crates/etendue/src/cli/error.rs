//! What goes wrong on the command line, and the way out.

use crate::image::ImageError;
use crate::import::ImportError;
use crate::render::{FilmError, MergeError};
use std::path::PathBuf;

/// An error as the user sees it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum CliError {
    /// The arguments contradict each other or the scene.
    #[error("{0}")]
    #[diagnostic(help("`etendue help` lists the commands, `etendue help render` the options"))]
    Usage(String),
    /// The model does not load.
    #[error(transparent)]
    #[diagnostic(help("`etendue info FILE` tells what the file holds"))]
    Import(#[from] Box<ImportError>),
    /// An environment or picture does not load or cannot be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file is not there or cannot be read.
    #[error("cannot read {path}: {source}", path = path.display())]
    #[diagnostic(help("looked for it at {}", absolute(path)))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A film file is damaged or something else.
    #[error("{path}: {source}", path = path.display())]
    #[diagnostic(help("film files are written by `etendue render --film FILE`"))]
    Film {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FilmError,
    },
    /// Films that do not add.
    #[error("cannot add {path}: {source}", path = path.display())]
    #[diagnostic(help(
        "films add if they were rendered from the same scene, camera and settings, with disjoint --samples"
    ))]
    Merge {
        /// The second film.
        path: PathBuf,
        /// Why not.
        source: MergeError,
    },
    /// The user stopped the run; what was done is kept.
    #[error("interrupted after {done}; {} and {} are written", picture.display(), film.display())]
    #[diagnostic(help("go on with: etendue render --resume {}", film.display()))]
    Interrupted {
        /// How far it got.
        done: String,
        /// The picture so far.
        picture: PathBuf,
        /// The film so far.
        film: PathBuf,
    },
    /// The scene contradicts itself: a defect of the importer.
    #[error("the scene is inconsistent: {0}")]
    Scene(#[from] crate::scene::InvalidScene),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

fn absolute(path: &std::path::Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()).display().to_string()
}

impl CliError {
    /// 2 for wrong usage, 1 for anything else.
    pub fn exit_code(&self) -> u8 {
        if matches!(self, Self::Usage(_)) { 2 } else { 1 }
    }
}

impl From<ImportError> for CliError {
    fn from(e: ImportError) -> Self {
        Self::Import(Box::new(e))
    }
}
