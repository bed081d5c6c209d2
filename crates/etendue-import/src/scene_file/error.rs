//! Why a scene file is no scene: where in it, what is wrong, what was probably meant.

use crate::ImportError;
use std::ops::Range;
use std::sync::Arc;

/// Why a scene file could not be read, or what it names could not be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneFileError {
    /// The file itself could not be read.
    #[error("cannot read {file}: {source}")]
    Read {
        /// The scene file.
        file: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is larger than the limits allow.
    #[error("{file}: {what}; the limit is `{limit}`")]
    TooLarge {
        /// The scene file.
        file: String,
        /// By how much.
        what: String,
        /// The field of [`crate::Limits`].
        limit: &'static str,
    },
    /// Something in it is wrong.
    #[error("{0}")]
    Wrong(Box<Mistake>),
    /// A model that it names does not load.
    #[error("{file}: line {line}: {source}")]
    Model {
        /// The scene file.
        file: String,
        /// Where it names the model, from 1.
        line: usize,
        /// Why not.
        source: Box<ImportError>,
    },
}

/// A mistake in a scene file and its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The scene file.
    pub file: String,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// What was probably meant, or a way out.
    pub help: Option<String>,
    /// Which bytes of the text are meant.
    pub span: Range<usize>,
    /// The file's text.
    pub text: Arc<str>,
}

impl std::fmt::Display for Mistake {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: line {}, column {}: {}", self.file, self.line, self.column, self.message)
    }
}

/// A text with its name: what mistakes are found in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Text {
    pub file: String,
    pub text: Arc<str>,
}

impl Text {
    /// Line and column of a byte, both from 1.
    pub fn place(&self, at: usize) -> (usize, usize) {
        let mut at = at.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        let before = &self.text[..at];
        let line = before.matches('\n').count() + 1;
        (line, before.rsplit('\n').next().unwrap_or_default().chars().count() + 1)
    }

    /// A mistake at `span`.
    pub fn wrong(
        &self,
        span: &Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> SceneFileError {
        let (line, column) = self.place(span.start);
        SceneFileError::Wrong(Box::new(Mistake {
            file: self.file.clone(),
            line,
            column,
            message: message.into(),
            help,
            span: span.clone(),
            text: self.text.clone(),
        }))
    }
}
