//! What can go wrong between a file and a picture.

use std::io;
use std::path::PathBuf;

/// Why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The operating system refused to read or write; the message names the file.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The first bytes belong to no format that is read here.
    #[error("not a picture: the first bytes ({start}) are those of none of {known}")]
    UnknownFormat {
        /// The first bytes, in hexadecimal.
        start: String,
        /// The formats that would have been read.
        known: &'static str,
    },
    /// The bytes are not what their format asks for.
    #[error("damaged {format} data: {cause}")]
    Damaged {
        /// Name of the format.
        format: &'static str,
        /// What is wrong, and where if known.
        cause: String,
    },
    /// A valid file uses a feature that is not read here.
    #[error("{format} with {feature} is not supported")]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// The feature.
        feature: String,
    },
    /// The header claims more than the limits, or than the bytes present can hold.
    #[error("{format} picture of {width} × {height} pixels refused: {cause}")]
    TooLarge {
        /// Name of the format.
        format: &'static str,
        /// Claimed width in pixels.
        width: u64,
        /// Claimed height in pixels.
        height: u64,
        /// Which limit it breaks.
        cause: String,
    },
    /// The file name's extension belongs to no format that is written here.
    #[error("{path}: cannot tell the picture format from the extension; known are {known}")]
    UnknownExtension {
        /// The path as given.
        path: PathBuf,
        /// The extensions that would have been understood.
        known: &'static str,
    },
    /// The picture cannot be stored in the format, or its parts do not fit together.
    #[error("cannot write {format}: {cause}")]
    Unwritable {
        /// Name of the format.
        format: &'static str,
        /// What does not fit.
        cause: String,
    },
    /// The same, with the file it happened to.
    #[error("{path}: {source}")]
    InFile {
        /// The file.
        path: PathBuf,
        /// What happened.
        source: Box<ImageError>,
    },
}

impl ImageError {
    pub(crate) fn damaged(format: &'static str, cause: impl std::fmt::Display) -> Self {
        Self::Damaged { format, cause: cause.to_string() }
    }

    pub(crate) fn unsupported(format: &'static str, feature: impl Into<String>) -> Self {
        Self::Unsupported { format, feature: feature.into() }
    }

    pub(crate) fn unwritable(format: &'static str, cause: impl std::fmt::Display) -> Self {
        Self::Unwritable { format, cause: cause.to_string() }
    }

    /// Names the file in which the error happened.
    pub fn in_file(self, path: impl Into<PathBuf>) -> Self {
        match self {
            Self::InFile { .. } | Self::UnknownExtension { .. } => self,
            source => Self::InFile { path: path.into(), source: Box::new(source) },
        }
    }
}
