//! Why an import failed: which file, which place in it, what is wrong, what to do.

use std::path::{Path, PathBuf};

/// Why a file could not be turned into a scene.
///
/// Every variant names the file; `pointer` is a JSON pointer (RFC 6901) into the glTF document, empty for its root, or for
/// other formats the place in words.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The model itself could not be read.
    #[error("cannot read {file}: {source}")]
    Read {
        /// The model.
        file: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file that the model refers to is not there or cannot be read.
    #[error(
        "{file}: {pointer}: the {what} `{uri}` was not found: looked for {} ({reason})",
        looked_for.display()
    )]
    Missing {
        /// The model.
        file: String,
        /// The reference.
        pointer: String,
        /// What is missing: "buffer" or "image".
        what: &'static str,
        /// The reference as it stands in the file.
        uri: Box<str>,
        /// Where it was looked for.
        looked_for: Box<Path>,
        /// What the operating system said, or why the place may not be read.
        reason: Box<str>,
    },
    /// The bytes are no format that is known, or a damaged file of one.
    #[error("{file}: byte {offset}: {message}")]
    Container {
        /// The model.
        file: String,
        /// Where in the file.
        offset: u64,
        /// What is wrong there.
        message: String,
    },
    /// A line of a text file (OBJ, PLY, STL) does not parse or contradicts others.
    #[error("{file}: line {line}: {message}")]
    Line {
        /// The model.
        file: String,
        /// From 1.
        line: u64,
        /// What is wrong there.
        message: String,
    },
    /// The JSON text does not parse.
    #[error("{file}: line {line}, column {column} of the JSON: {message}")]
    Json {
        /// The model.
        file: String,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// The document parses but contradicts itself, its data or the specification.
    #[error("{file}: {}: {message}", if pointer.is_empty() { "document" } else { pointer })]
    Invalid {
        /// The model.
        file: String,
        /// The faulty part.
        pointer: String,
        /// What is wrong with it.
        message: String,
    },
    /// A picture does not decode.
    #[error("{file}: {pointer}: the image {image} cannot be decoded: {message}")]
    Image {
        /// The model.
        file: String,
        /// The image.
        pointer: String,
        /// Its address or name.
        image: String,
        /// What the decoder said.
        message: String,
    },
    /// The file cannot be shown without something that is not supported.
    #[error("{file}: {pointer}: requires {what}, which is not supported yet{hint}")]
    Unsupported {
        /// The model.
        file: String,
        /// Where it is asked for.
        pointer: String,
        /// Extensions or version, by name.
        what: String,
        /// A way out, starting with "; ", or nothing.
        hint: String,
    },
    /// One of the [`crate::Limits`] is exceeded.
    #[error("{file}: {}: {what}; raise the limit `{limit}` if the file is to be trusted", if pointer.is_empty() { "document" } else { pointer })]
    TooLarge {
        /// The model.
        file: String,
        /// What is too large.
        pointer: String,
        /// By how much.
        what: String,
        /// The field of [`crate::Limits`].
        limit: &'static str,
    },
    /// The animation that the options ask for is not in the file.
    #[error("{file}: no animation {wanted}; the file has {available}")]
    NoSuchAnimation {
        /// The model.
        file: String,
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
}

/// An [`ImportError`] that does not know its file's name yet.
#[derive(Debug)]
pub(crate) enum Fault {
    Missing { pointer: String, what: &'static str, uri: String, looked_for: PathBuf, reason: String },
    Container { offset: u64, message: String },
    Line { line: u64, message: String },
    Json { line: usize, column: usize, message: String },
    Invalid { pointer: String, message: String },
    Image { pointer: String, image: String, message: String },
    Unsupported { pointer: String, what: String, hint: String },
    TooLarge { pointer: String, what: String, limit: &'static str },
    NoSuchAnimation { wanted: String, available: String },
}

impl Fault {
    pub fn invalid(pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { pointer: pointer.into(), message: message.into() }
    }

    /// Something wrong in a line of text.
    pub fn line(line: u64, message: impl Into<String>) -> Self {
        Self::Line { line, message: message.into() }
    }

    /// Something wrong at a byte of the file.
    pub fn byte(offset: u64, message: impl Into<String>) -> Self {
        Self::Container { offset, message: message.into() }
    }

    /// The place in the document, as far as there is one.
    pub fn pointer(&self) -> &str {
        match self {
            Self::Missing { pointer, .. }
            | Self::Invalid { pointer, .. }
            | Self::Image { pointer, .. }
            | Self::Unsupported { pointer, .. }
            | Self::TooLarge { pointer, .. } => pointer,
            Self::Container { .. } | Self::Line { .. } | Self::Json { .. } | Self::NoSuchAnimation { .. } => {
                ""
            }
        }
    }

    /// What is wrong, without the place; used where a fault is harmless and becomes a warning.
    pub fn message(&self) -> String {
        match self {
            Self::Missing { uri, .. } => format!("`{uri}` was not found"),
            Self::Container { message, .. }
            | Self::Line { message, .. }
            | Self::Json { message, .. }
            | Self::Invalid { message, .. }
            | Self::Image { message, .. } => message.clone(),
            Self::Unsupported { what, .. } => format!("requires {what}, which is not supported yet"),
            Self::TooLarge { what, .. } => what.clone(),
            Self::NoSuchAnimation { wanted, .. } => format!("no animation {wanted}"),
        }
    }

    /// The error for users: this fault in `file`.
    pub fn in_file(self, file: &str) -> ImportError {
        let file = file.to_owned();
        match self {
            Self::Missing { pointer, what, uri, looked_for, reason } => ImportError::Missing {
                file,
                pointer,
                what,
                uri: uri.into(),
                looked_for: looked_for.into(),
                reason: reason.into(),
            },
            Self::Container { offset, message } => ImportError::Container { file, offset, message },
            Self::Line { line, message } => ImportError::Line { file, line, message },
            Self::Json { line, column, message } => ImportError::Json { file, line, column, message },
            Self::Invalid { pointer, message } => ImportError::Invalid { file, pointer, message },
            Self::Image { pointer, image, message } => ImportError::Image { file, pointer, image, message },
            Self::Unsupported { pointer, what, hint } => {
                ImportError::Unsupported { file, pointer, what, hint }
            }
            Self::TooLarge { pointer, what, limit } => ImportError::TooLarge { file, pointer, what, limit },
            Self::NoSuchAnimation { wanted, available } => {
                ImportError::NoSuchAnimation { file, wanted, available }
            }
        }
    }
}
