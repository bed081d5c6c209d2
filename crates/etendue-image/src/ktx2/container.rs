//! The file: header, index of levels, descriptor, key-value data (KTX 2.0, section 3).

use super::F;
use super::descriptor::Model;
use crate::ImageError;

/// The first bytes (3.1).
pub(super) const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// How levels are packed once more (3.9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scheme {
    None,
    BasisLz,
    Zstandard,
    Zlib,
}

/// A mip.
pub(super) struct Level<'a> {
    /// As in the file.
    pub bytes: &'a [u8],
    /// Where they stand.
    pub offset: u64,
    /// Size without supercompression, as the index says.
    pub size: u64,
}

/// Where parts stand, and what the header says beside.
pub(super) struct Places {
    pub type_size: u32,
    /// Whether the header gives a height, a depth, a number of layers and of mips at all.
    pub has_height: bool,
    pub has_depth: bool,
    pub has_layers: bool,
    pub has_levels: bool,
    /// Offset and length.
    pub descriptor: (u64, u64),
    pub values: (u64, u64),
    pub global: (u64, u64),
}

/// A file whose parts are known to be within it.
pub(super) struct Container<'a> {
    /// Vulkan's number of the format; 0 if it has none.
    pub format: u32,
    pub width: u32,
    pub height: u32,
    /// At least 1, as all that follow.
    pub depth: u32,
    pub layers: u32,
    pub faces: u32,
    pub levels: Vec<Level<'a>>,
    pub scheme: Scheme,
    pub descriptor: &'a [u8],
    values: &'a [u8],
    /// Global data of the supercompression.
    pub global: &'a [u8],
    pub places: Places,
}

fn word(b: &[u8], at: usize) -> u32 {
    let mut w = [0; 4];
    w.copy_from_slice(&b[at..at + 4]);
    u32::from_le_bytes(w)
}

fn long(b: &[u8], at: usize) -> u64 {
    u64::from(word(b, at)) | u64::from(word(b, at + 4)) << 32
}

/// The bytes of a part; an empty one may stand anywhere.
fn part<'a>(bytes: &'a [u8], offset: u64, length: u64, name: &str) -> Result<&'a [u8], ImageError> {
    if length == 0 {
        return Ok(&[]);
    }
    let end = offset.checked_add(length).filter(|&e| e <= bytes.len() as u64);
    let end = end.ok_or_else(|| {
        ImageError::damaged(F, format!("{name} ({length} bytes from byte {offset}) reaches beyond the file"))
    })?;
    Ok(&bytes[offset as usize..end as usize])
}

impl<'a> Container<'a> {
    pub fn read(bytes: &'a [u8]) -> Result<Self, ImageError> {
        let bad = |cause: &str| Err(ImageError::damaged(F, cause));
        let Some(header) = bytes.get(..80).filter(|h| h.starts_with(&IDENTIFIER)) else {
            return bad("the header is cut off or not that of KTX 2");
        };
        let [format, type_size, width, height, depth, layers, faces, levels, scheme] =
            std::array::from_fn(|i| word(header, 12 + 4 * i));
        if width == 0 {
            return bad("it has no width");
        }
        if height == 0 && depth > 0 {
            return bad("it has depth, but no height");
        }
        if !matches!(faces, 1 | 6) {
            return Err(ImageError::damaged(F, format!("{faces} faces")));
        }
        if faces == 6 && (width != height || depth > 0) {
            return bad("a cube whose faces are not square");
        }
        let (has_height, has_levels) = (height > 0, levels > 0);
        let (has_depth, has_layers) = (depth > 0, layers > 0);
        let (height, depth, layers) = (height.max(1), depth.max(1), layers.max(1));
        let most = 32 - width.max(height).max(depth).leading_zeros();
        if levels > most {
            return Err(ImageError::damaged(F, format!("{levels} mips of {width} × {height}")));
        }
        let scheme = match scheme {
            0 => Scheme::None,
            1 => Scheme::BasisLz,
            2 => Scheme::Zstandard,
            3 => Scheme::Zlib,
            n => return Err(ImageError::unsupported(F, format!("supercompression scheme {n}"))),
        };
        let levels = (0..levels.max(1) as usize).map(|i| {
            let index = bytes.get(80 + 24 * i..104 + 24 * i);
            let index = index.ok_or_else(|| ImageError::damaged(F, "the index of mips is cut off"))?;
            let offset = long(index, 0);
            let bytes = part(bytes, offset, long(index, 8), "a mip")?;
            Ok(Level { bytes, offset, size: long(index, 16) })
        });
        let levels = levels.collect::<Result<Vec<_>, ImageError>>()?;
        let pair = |at: usize| (u64::from(word(header, at)), u64::from(word(header, at + 4)));
        let near = |at: usize, name| part(bytes, pair(at).0, pair(at).1, name);
        let places = Places {
            type_size,
            has_height,
            has_depth,
            has_layers,
            has_levels,
            descriptor: pair(48),
            values: pair(56),
            global: (long(header, 64), long(header, 72)),
        };
        Ok(Self {
            format,
            width,
            height,
            depth,
            layers,
            faces,
            levels,
            scheme,
            descriptor: near(48, "the data format descriptor")?,
            values: near(56, "the key-value data")?,
            global: part(bytes, long(header, 64), long(header, 72), "the global data")?,
            places,
        })
    }

    /// A colour model goes with certain schemes only.
    pub fn check_scheme(&self, model: Model) -> Result<(), ImageError> {
        if (self.scheme == Scheme::BasisLz) != (model == Model::Etc1s) {
            return Err(ImageError::damaged(F, "BasisLZ without ETC1S, or ETC1S without BasisLZ"));
        }
        if matches!(model, Model::Etc1s | Model::Uastc) && (self.format != 0 || self.depth > 1) {
            return Err(ImageError::damaged(F, "a format or a depth with Basis Universal's data"));
        }
        Ok(())
    }

    /// Number of pictures of a mip.
    pub fn images_of(&self, mip: u32) -> u64 {
        let depth = self.depth.checked_shr(mip).unwrap_or(0).max(1);
        u64::from(self.layers).saturating_mul(self.faces.into()).saturating_mul(depth.into())
    }

    /// Number of all pictures.
    pub fn images(&self) -> u64 {
        (0..self.levels.len() as u32).map(|m| self.images_of(m)).fold(0, u64::saturating_add)
    }

    /// Whether the key-value data consist of entries (3.11).
    pub fn check_values(&self) -> Result<(), ImageError> {
        let (last, rest) = self.entries().last().map_or((true, self.values), |e| (!e.key.is_empty(), e.rest));
        // What is left after the last entry is no entry; an empty key is none either.
        if last && rest.is_empty() && self.entries().all(|e| !e.key.is_empty()) {
            return Ok(());
        }
        Err(ImageError::damaged(F, "the key-value data do not consist of keys and values"))
    }

    /// The keys and values, up to the first that is cut off.
    pub fn entries(&self) -> impl Iterator<Item = Entry<'a>> {
        let mut rest = self.values;
        std::iter::from_fn(move || {
            let (length, more) = rest.split_first_chunk::<4>()?;
            let length = u32::from_le_bytes(*length) as usize;
            let entry = more.get(..length)?;
            let end = entry.iter().position(|&b| b == 0)?;
            // The padding of the last entry may be left out.
            let padded = length.next_multiple_of(4).min(more.len());
            let padding = &more[length..padded];
            rest = &more[padded..];
            Some(Entry { key: &entry[..end], value: &entry[end + 1..], padding, rest })
        })
    }

    /// Whether the last entry is padded as the others are.
    pub fn values_end_whole(&self) -> bool {
        self.values.len().is_multiple_of(4)
    }

    /// The value of a key; the first, if a damaged file has several (3.11).
    pub fn value(&self, key: &str) -> Option<&'a [u8]> {
        self.entries().find(|e| e.key == key.as_bytes()).map(|e| e.value)
    }
}

/// A key with its value.
pub(super) struct Entry<'a> {
    pub key: &'a [u8],
    pub value: &'a [u8],
    /// What stands between it and the next.
    pub padding: &'a [u8],
    /// What follows.
    rest: &'a [u8],
}
