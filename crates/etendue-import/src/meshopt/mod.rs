//! Decoders of meshopt's bitstreams: `KHR_meshopt_compression` and its predecessor `EXT_meshopt_compression`.
//!
//! Written from appendices A (bitstream) and B (filters) of the extension's text (Khronos, "KHR_meshopt_compression"),
//! which the sections named here refer to. A stream is decoded in one pass; its length is known beforehand and nothing is
//! allocated that the bytes present could not fill: an index takes at least a byte (a triangle, in triangle mode), and 1024
//! bytes of attributes take at least one.

mod attributes;
mod filter;
mod indices;
mod triangles;

/// How the elements are coded (section "Compression modes and filters").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Elements of any kind, byte by byte as differences to the element before (A, mode 0; versions 0 and 1).
    Attributes,
    /// Indices of a list of triangles (A, mode 1).
    Triangles,
    /// Other indices (A, mode 2).
    Indices,
}

/// What is done to decoded attributes (appendix B).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Nothing.
    #[default]
    None,
    /// Unit vectors from octahedral coordinates: strides of 4 (8-bit components) and 8 (16-bit).
    Octahedral,
    /// Unit quaternions from their three smaller components: a stride of 8.
    Quaternion,
    /// 32-bit floats from an exponent and a mantissa.
    Exponential,
    /// Colours from luma and two chromas: strides of 4 and 8.
    Color,
}

/// What a stream holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// How it is coded.
    pub mode: Mode,
    /// What follows.
    pub filter: Filter,
    /// Number of elements.
    pub count: u64,
    /// Bytes of a decoded element: 4 to 256 and divisible by 4 for attributes, 2 or 4 for indices.
    pub stride: u64,
}

/// Why a stream was not decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshoptError {
    /// Mode, filter, count and stride do not go together.
    #[error("{0}")]
    Layout(&'static str),
    /// The bytes are not a stream of the layout.
    #[error("damaged meshopt data: {0}")]
    Damaged(&'static str),
}

use MeshoptError::{Damaged, Layout as Wrong};

impl Layout {
    /// Checks the rules of section "JSON schema updates"; the sizes then fit the machine.
    fn check(&self) -> Result<(usize, usize), MeshoptError> {
        let attributes = self.mode == Mode::Attributes;
        if attributes && !(self.stride.is_multiple_of(4) && (4..=256).contains(&self.stride)) {
            return Err(Wrong("compressed attributes need a stride of 4 to 256 bytes, divisible by 4"));
        }
        if !attributes && !matches!(self.stride, 2 | 4) {
            return Err(Wrong("compressed indices need a stride of 2 or 4 bytes"));
        }
        if self.mode == Mode::Triangles && !self.count.is_multiple_of(3) {
            return Err(Wrong("the number of indices in triangle mode is not divisible by 3"));
        }
        if !attributes && self.filter != Filter::None {
            return Err(Wrong("indices have no filter"));
        }
        let fits = match self.filter {
            Filter::None | Filter::Exponential => true,
            Filter::Octahedral | Filter::Color => matches!(self.stride, 4 | 8),
            Filter::Quaternion => self.stride == 8,
        };
        if !fits {
            return Err(Wrong("the filter does not go with the stride"));
        }
        let bytes = self.count.checked_mul(self.stride).and_then(|n| isize::try_from(n).ok());
        if bytes.is_none() {
            return Err(Wrong("the elements do not fit into memory"));
        }
        Ok((self.count as usize, self.stride as usize))
    }
}

/// Decodes a whole stream: `count` elements of `stride` bytes, one after another.
///
/// # Errors
/// [`MeshoptError`]; a stream has to end where its elements do.
pub fn decode(bytes: &[u8], layout: &Layout) -> Result<Vec<u8>, MeshoptError> {
    let (count, stride) = layout.check()?;
    let mut out = match layout.mode {
        Mode::Attributes => attributes::decode(bytes, count, stride)?,
        Mode::Triangles => triangles::decode(bytes, count, stride)?,
        Mode::Indices => indices::decode(bytes, count, stride)?,
    };
    filter::apply(layout.filter, &mut out, stride);
    Ok(out)
}

/// What is left of a stream's data.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    #[inline(always)]
    fn take(&mut self, n: usize) -> Result<&'a [u8], MeshoptError> {
        let (head, rest) = self.0.split_at_checked(n).ok_or(Damaged("it ends too early"))?;
        self.0 = rest;
        Ok(head)
    }

    #[inline(always)]
    fn byte(&mut self) -> Result<u8, MeshoptError> {
        let (&b, rest) = self.0.split_first().ok_or(Damaged("it ends too early"))?;
        self.0 = rest;
        Ok(b)
    }

    /// A number in groups of seven bits, the lowest first (LEB128), in one to five bytes.
    #[inline(always)]
    fn varint(&mut self) -> Result<u32, MeshoptError> {
        let mut value = 0;
        for shift in [0, 7, 14, 21, 28] {
            let b = self.byte()?;
            value |= u32::from(b & 127) << shift;
            if b < 128 {
                return Ok(value);
            }
        }
        Err(Damaged("a number of more than five bytes"))
    }

    /// Everything has to be used up at the end.
    fn finish(&self) -> Result<(), MeshoptError> {
        if self.0.is_empty() { Ok(()) } else { Err(Damaged("data are left over")) }
    }
}

/// Splits a stream into its first byte, its data and the last `tail` bytes.
fn parts(bytes: &[u8], tail: usize) -> Result<(u8, Input<'_>, &[u8]), MeshoptError> {
    let (&header, rest) = bytes.split_first().ok_or(Damaged("it is empty"))?;
    let at = rest.len().checked_sub(tail).ok_or(Damaged("it is shorter than its fixed parts"))?;
    let (data, tail) = rest.split_at(at);
    Ok((header, Input(data), tail))
}

/// Appends an index of `stride` bytes.
#[inline(always)]
fn push(out: &mut Vec<u8>, index: u32, stride: usize) {
    out.extend_from_slice(&index.to_le_bytes()[..stride]);
}

/// Undoes the folding of signs into the lowest bit.
#[inline(always)]
fn unzigzag(v: u32) -> u32 {
    v >> 1 ^ (v & 1).wrapping_neg()
}
