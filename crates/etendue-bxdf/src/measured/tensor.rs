//! The container that measured scattering functions come in: named arrays in one file.
//!
//! ```text
//! "tensor_file\0", version (2 × u8: 1, 0), number of fields (u32)
//! per field: length of its name (u16), name, dimensions (u16), type (u8), offset of the data (u64), shape (u64 each)
//! ```
//!
//! All little-endian. The layout is that of the material database of EPFL's Realistic Graphics Lab (Dupuy, Jakob 2018).

use super::MeasuredError;

/// What every file begins with.
const MAGIC: &[u8] = b"tensor_file\0";
/// More dimensions than any array has.
const MAX_DIMENSIONS: usize = 16;

/// Codes of the element types that are read.
pub(super) const U8: u8 = 1;
pub(super) const U16: u8 = 3;
pub(super) const F32: u8 = 10;

/// One array: its bytes lie within the file and are as many as its shape says.
#[derive(Clone, Debug)]
pub(super) struct Field<'a> {
    pub name: &'a str,
    pub kind: u8,
    pub shape: Vec<usize>,
    pub bytes: &'a [u8],
}

/// All arrays of a file.
pub(super) struct TensorFile<'a> {
    fields: Vec<Field<'a>>,
}

/// Reads on through the file.
struct Cursor<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], MeasuredError> {
        let end = self.at.checked_add(n).filter(|&e| e <= self.all.len()).ok_or(MeasuredError::Truncated)?;
        let part = &self.all[self.at..end];
        self.at = end;
        Ok(part)
    }

    /// A little-endian integer of `n` ≤ 8 bytes.
    fn integer(&mut self, n: usize) -> Result<u64, MeasuredError> {
        Ok(self.take(n)?.iter().rev().fold(0, |v, &b| v << 8 | b as u64))
    }
}

/// Bytes per element.
fn size_of(kind: u8) -> Option<usize> {
    Some(match kind {
        1 | 2 => 1,
        3 | 4 | 9 => 2,
        5 | 6 | 10 => 4,
        7 | 8 | 11 => 8,
        _ => return None,
    })
}

impl<'a> TensorFile<'a> {
    /// Reads the directory. Nothing is allocated that the file's own length does not bound.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, MeasuredError> {
        let mut cursor = Cursor { all: bytes, at: 0 };
        if cursor.take(MAGIC.len()).ok() != Some(MAGIC) {
            return Err(MeasuredError::NotATensorFile);
        }
        let (major, minor) = (cursor.integer(1)? as u8, cursor.integer(1)? as u8);
        if (major, minor) != (1, 0) {
            return Err(MeasuredError::Version { major, minor });
        }
        let count = cursor.integer(4)?;
        let mut fields = Vec::new();
        for _ in 0..count {
            let length = cursor.integer(2)? as usize;
            let name = core::str::from_utf8(cursor.take(length)?).map_err(|_| MeasuredError::Name)?;
            let dimensions = cursor.integer(2)? as usize;
            let kind = cursor.integer(1)? as u8;
            let offset = cursor.integer(8)?;
            let wrong = |expected: &'static str| MeasuredError::Field { name: name.into(), expected };
            if dimensions > MAX_DIMENSIONS {
                return Err(wrong("at most 16 dimensions"));
            }
            let size = size_of(kind).ok_or(wrong("a number type"))?;
            let mut shape = Vec::with_capacity(dimensions);
            let mut length = Some(size);
            for _ in 0..dimensions {
                let n = usize::try_from(cursor.integer(8)?).map_err(|_| MeasuredError::Truncated)?;
                length = length.and_then(|l| l.checked_mul(n));
                shape.push(n);
            }
            let start = usize::try_from(offset).ok();
            let end = start.zip(length).and_then(|(s, l)| s.checked_add(l));
            let bytes = start.zip(end).and_then(|(s, e)| bytes.get(s..e)).ok_or(MeasuredError::Truncated)?;
            fields.push(Field { name, kind, shape, bytes });
        }
        Ok(Self { fields })
    }

    /// The array of that name, if there is one.
    pub fn get(&self, name: &str) -> Option<&Field<'a>> {
        self.fields.iter().find(|f| f.name == name)
    }

    /// The array of that name, of so many dimensions and of that type.
    pub fn expect(
        &self,
        name: &'static str,
        dimensions: usize,
        kind: u8,
    ) -> Result<&Field<'a>, MeasuredError> {
        let field = self.get(name).ok_or(MeasuredError::Missing { name })?;
        if field.kind != kind {
            return Err(field.wrong("another element type"));
        }
        if field.shape.len() != dimensions {
            return Err(field.wrong("another number of dimensions"));
        }
        Ok(field)
    }
}

impl Field<'_> {
    /// The error that this array is not as it should be.
    pub fn wrong(&self, expected: &'static str) -> MeasuredError {
        MeasuredError::Field { name: self.name.into(), expected }
    }

    /// Its numbers, which must be finite.
    pub fn floats(&self) -> Result<Vec<f32>, MeasuredError> {
        let (words, _) = self.bytes.as_chunks::<4>();
        let values: Vec<f32> = words.iter().map(|&w| f32::from_le_bytes(w)).collect();
        if values.iter().all(|v| v.is_finite()) { Ok(values) } else { Err(self.wrong("finite numbers")) }
    }

    /// Its numbers, finite, not empty and increasing: the places that a table is given at.
    pub fn places(&self) -> Result<Vec<f32>, MeasuredError> {
        let values = self.floats()?;
        if values.is_empty() || !values.windows(2).all(|w| w[0] < w[1]) {
            return Err(self.wrong("increasing numbers"));
        }
        Ok(values)
    }
}
