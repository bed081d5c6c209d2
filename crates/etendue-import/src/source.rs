//! Where the bytes come from that a model refers to: itself, or files beside it.

use crate::error::Fault;
use crate::limits::Limits;
use crate::texture::{Decoded, format_of};
use crate::uri;
use etendue_image::{DecodeLimits, Image, decode};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The surroundings of a model.
pub(crate) struct Source<'a> {
    /// The model's folder; `None` if it came from memory and has no surroundings.
    pub folder: Option<&'a Path>,
    pub limits: &'a Limits,
    /// Bytes that files and geometry take already.
    pub used: u64,
    /// Whether pictures keep the bytes that they were decoded from.
    pub keep_files: bool,
}

impl Source<'_> {
    /// Decodes a picture of which no more than `left` bytes may come.
    ///
    /// # Errors
    /// A sentence.
    pub fn decode(&self, bytes: &[u8], left: u64) -> Result<Image, String> {
        let limits = DecodeLimits { max_pixels: self.limits.image_pixels, max_bytes: left };
        let image = decode(bytes, &limits).map_err(|e| e.to_string())?;
        self.dimensions(&image).map(|()| image)
    }

    /// An error for a picture that is longer than the limits allow.
    pub fn dimensions(&self, image: &Image) -> Result<(), String> {
        let longest = image.width.max(image.height);
        if longest > self.limits.image_dimension {
            return Err(format!(
                "{} × {} pixels are more than the limit `image_dimension`, {}, allows",
                image.width, image.height, self.limits.image_dimension
            ));
        }
        Ok(())
    }

    /// A picture that was decoded from `bytes`.
    pub fn decoded(&self, image: Arc<Image>, bytes: Vec<u8>) -> Decoded {
        Decoded {
            image,
            encoded_bytes: bytes.len() as u64,
            format: format_of(&bytes),
            mips: 1,
            srgb: None,
            file: self.keep_files.then(|| Arc::new(bytes)),
        }
    }

    /// The bytes that `uri` refers to. `what` ("buffer", "image") and `pointer` are for messages.
    pub fn read(&self, uri: &str, what: &'static str, pointer: &str) -> Result<Vec<u8>, Fault> {
        if let Some(data) = uri::data(uri) {
            return data.map_err(|e| Fault::invalid(format!("{pointer}/uri"), e));
        }
        let missing = |looked_for: PathBuf, reason: String| Fault::Missing {
            pointer: format!("{pointer}/uri"),
            what,
            uri: uri::shorten(uri),
            looked_for,
            reason,
        };
        let Some(folder) = self.folder else {
            return Err(missing(uri.into(), "a model from memory has no files beside it".into()));
        };
        let path = uri::resolve(uri, folder, self.limits.outside_folder).map_err(|(p, e)| missing(p, e))?;
        let candidates = [Some(path.clone()), self.as_written(uri, folder)];
        for p in candidates.into_iter().flatten() {
            let (limit, name) = self.limits.for_file();
            match read_file(&p, limit) {
                Ok(bytes) => return Ok(bytes),
                Err(ReadError::TooLarge(n)) => {
                    return Err(Fault::TooLarge {
                        pointer: format!("{pointer}/uri"),
                        what: format!("{} has {n} bytes", p.display()),
                        limit: name,
                    });
                }
                Err(ReadError::Io(e)) if e.kind() == io::ErrorKind::NotFound => {}
                Err(ReadError::Io(e)) => return Err(missing(p, e.to_string())),
            }
        }
        Err(missing(path, "no such file".into()))
    }

    /// The file as some exporters mean it, against the specification: `%20` as part of the name, or `\` for `/`.
    fn as_written(&self, uri: &str, folder: &Path) -> Option<PathBuf> {
        let literal = uri.replace('%', "%25").replace('\\', "/");
        uri::resolve(&literal, folder, self.limits.outside_folder).ok()
    }
}

/// Why a file was not read.
pub(crate) enum ReadError {
    Io(io::Error),
    TooLarge(u64),
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Io(e) => e.fmt(f),
            Self::TooLarge(n) => {
                write!(f, "{n} bytes are more than the limits `file_bytes` and `memory_bytes` allow")
            }
        }
    }
}

/// Reads a whole file of at most `limit` bytes. Folders and devices are refused.
pub(crate) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
    // Opening a pipe would block, so its kind is asked first.
    let meta = std::fs::metadata(path).map_err(ReadError::Io)?;
    if !meta.is_file() {
        return Err(ReadError::Io(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file")));
    }
    if meta.len() > limit {
        return Err(ReadError::TooLarge(meta.len()));
    }
    let mut file = File::open(path).map_err(ReadError::Io)?;
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    // The file may grow while it is read.
    (&mut file).take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(ReadError::Io)?;
    if bytes.len() as u64 > limit { Err(ReadError::TooLarge(bytes.len() as u64)) } else { Ok(bytes) }
}
