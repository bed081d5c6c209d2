//! Typed arrays out of raw bytes: strides, component types, normalisation, sparse replacement.

use crate::buffers::Buffers;
use crate::document::{Accessor, Component, Document, Shape, Sparse, get};
use crate::error::Fault;
use std::cmp::Ordering;

/// Opens accessors of a document whose buffers are loaded.
#[derive(Clone, Copy)]
pub(crate) struct Accessors<'a> {
    pub doc: &'a Document<'a>,
    pub buffers: &'a Buffers<'a>,
}

/// An accessor whose every element is known to lie within its buffer.
pub(crate) struct Elements<'a> {
    index: u32,
    accessor: &'a Accessor,
    /// Bytes from the first element on, and the distance between elements; `None`: all zero.
    base: Option<(&'a [u8], usize)>,
    overlay: Option<Overlay<'a>>,
}

/// The sparse part: element `k` of `values` replaces the element that index `k` names.
///
/// It stays in its bytes: many primitives may look up a few vertices each in one long list.
struct Overlay<'a> {
    /// Strictly increasing, all below the accessor's count.
    indices: &'a [u8],
    /// Bytes per index.
    width: usize,
    values: &'a [u8],
}

impl Overlay<'_> {
    fn len(&self) -> usize {
        self.indices.len() / self.width
    }

    /// Index `k`.
    fn index(&self, k: usize) -> u32 {
        let b = &self.indices[k * self.width..(k + 1) * self.width];
        b.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b))
    }

    /// Where `i` is among the indices.
    fn find(&self, i: u32) -> Option<usize> {
        let (mut lo, mut hi) = (0, self.len());
        while lo < hi {
            let mid = lo + (hi - lo) / 2;
            match self.index(mid).cmp(&i) {
                Ordering::Less => lo = mid + 1,
                Ordering::Equal => return Some(mid),
                Ordering::Greater => hi = mid,
            }
        }
        None
    }

    /// Checks order and range of the indices for an accessor of `count` elements.
    fn check(&self, count: u64, pointer: impl Fn() -> String) -> Result<(), Fault> {
        if (1..self.len()).any(|k| self.index(k - 1) >= self.index(k)) {
            return Err(Fault::invalid(
                format!("{}/indices", pointer()),
                "the indices do not strictly increase",
            ));
        }
        match self.len().checked_sub(1).map(|k| self.index(k)) {
            Some(last) if u64::from(last) >= count => Err(Fault::invalid(
                format!("{}/indices", pointer()),
                format!("index {last} is beyond the accessor's {count} elements"),
            )),
            _ => Ok(()),
        }
    }
}

/// A component as it is stored.
trait Stored<const S: usize>: Copy {
    fn read(bytes: [u8; S]) -> Self;
}
macro_rules! stored {
    ($($t:ty, $s:literal);*) => { $(impl Stored<$s> for $t {
        #[inline(always)]
        fn read(bytes: [u8; $s]) -> Self { <$t>::from_le_bytes(bytes) }
    })* };
}
stored!(i8, 1; u8, 1; i16, 2; u16, 2; u32, 4; f32, 4);

impl<'a> Accessors<'a> {
    /// Opens accessor `index`, to which `from` refers as its `what`. It must have one of the `shapes`.
    pub fn open(
        &self,
        index: u32,
        what: &str,
        shapes: &[Shape],
        from: impl Fn() -> String,
    ) -> Result<Elements<'a>, Fault> {
        let accessor = get(&self.doc.accessors, index, "accessor", &from)?;
        if !shapes.contains(&accessor.shape) {
            let names: Vec<&str> = shapes.iter().map(|s| s.name()).collect();
            return Err(Fault::invalid(
                from(),
                format!(
                    "{what} needs {}, accessor {index} has {}",
                    names.join(" or "),
                    accessor.shape.name()
                ),
            ));
        }
        let shown = accessor.origin.unwrap_or(index);
        let pointer = || format!("/accessors/{shown}");
        // Vertices are counted in 32 bits everywhere after this.
        if accessor.count > u32::MAX.into() {
            return Err(Fault::invalid(
                format!("{}/count", pointer()),
                format!("{} elements are more than the data can hold", accessor.count),
            ));
        }
        let size = accessor.shape.size(accessor.component);
        let base = match (accessor.decoded, accessor.buffer_view) {
            // As many elements as the accessor says, by construction.
            (Some(n), _) => Some((&self.buffers.decoded_attributes[n as usize][..], size as usize)),
            (None, None) => None,
            (None, Some(v)) => {
                let bytes = self.buffers.view(self.doc, v, || format!("{}/bufferView", pointer()))?;
                let stride = self.doc.buffer_views[v as usize].byte_stride.unwrap_or(size);
                if stride < size {
                    return Err(Fault::invalid(
                        format!("/bufferViews/{v}/byteStride"),
                        format!("a stride of {stride} bytes for elements of {size} (accessor {shown})"),
                    ));
                }
                let bytes = span(bytes, accessor.byte_offset, accessor.count, stride, size).ok_or_else(|| {
                    Fault::invalid(
                        pointer(),
                        format!(
                            "{} elements of {size} bytes, {stride} apart, from byte {} reach beyond buffer view \
                             {v} of {} bytes",
                            accessor.count,
                            accessor.byte_offset,
                            bytes.len()
                        ),
                    )
                })?;
                Some((bytes, stride as usize))
            }
        };
        let overlay = match &accessor.sparse {
            Some(s) => {
                let pointer = || format!("/accessors/{shown}/sparse");
                let overlay = self.overlay(s, size, pointer)?;
                self.buffers.once(index, || overlay.check(accessor.count, pointer))?;
                Some(overlay)
            }
            None => None,
        };
        Ok(Elements { index: shown, accessor, base, overlay })
    }

    fn overlay(&self, s: &Sparse, size: u64, pointer: impl Fn() -> String) -> Result<Overlay<'a>, Fault> {
        let part = |view: u32, offset: u64, size: u64, name: &str| {
            let bytes = self.buffers.view(self.doc, view, || format!("{}/{name}/bufferView", pointer()))?;
            span(bytes, offset, s.count, size, size).ok_or_else(|| {
                Fault::invalid(
                    format!("{}/{name}", pointer()),
                    format!(
                        "{} entries of {size} bytes from byte {offset} reach beyond buffer view {view} of {} bytes",
                        s.count,
                        bytes.len()
                    ),
                )
            })
        };
        let width = s.indices_component.size();
        let indices = part(s.indices_view, s.indices_offset, width, "indices")?;
        let values = part(s.values_view, s.values_offset, size, "values")?;
        Ok(Overlay { indices, width: width as usize, values })
    }
}

/// The bytes of `count` elements of `size`, `stride` apart, from `offset` on; `None` if they are not all there.
fn span(bytes: &[u8], offset: u64, count: u64, stride: u64, size: u64) -> Option<&[u8]> {
    if count == 0 {
        return Some(&[]);
    }
    let length = (count - 1).checked_mul(stride)?.checked_add(size)?;
    let end = offset.checked_add(length)?;
    bytes.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?)
}

impl Elements<'_> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.accessor.count as usize
    }

    /// Type of the components.
    pub fn component(&self) -> Component {
        self.accessor.component
    }

    /// Components per element.
    pub fn shape(&self) -> Shape {
        self.accessor.shape
    }

    /// Whether integers stand for 0..1 or −1..1.
    pub fn normalized(&self) -> bool {
        self.accessor.normalized
    }

    /// JSON pointer to the accessor.
    pub fn pointer(&self) -> String {
        format!("/accessors/{}", self.index)
    }

    /// The elements as floats; integers are normalised if the accessor says so (glTF 2.0, 3.6.2.2). With `pick`, only
    /// those elements, in that order; every one must be below [`Elements::len`].
    pub fn floats<const N: usize>(&self, pick: Option<&[u32]>) -> Vec<[f32; N]> {
        self.floats_as(pick, self.accessor.normalized)
    }

    /// [`Elements::floats`] with integers normalised, whatever the accessor says: for colours and weights, which have
    /// no other meaning.
    pub fn unit_floats<const N: usize>(&self, pick: Option<&[u32]>) -> Vec<[f32; N]> {
        self.floats_as(pick, true)
    }

    fn floats_as<const N: usize>(&self, pick: Option<&[u32]>, normalized: bool) -> Vec<[f32; N]> {
        match (self.accessor.component, normalized) {
            (Component::F32, _) => self.gather(pick, |c: f32| c),
            (Component::U32, _) => self.gather(pick, |c: u32| c as f32),
            (Component::I8, false) => self.gather(pick, |c: i8| c.into()),
            (Component::U8, false) => self.gather(pick, |c: u8| c.into()),
            (Component::I16, false) => self.gather(pick, |c: i16| c.into()),
            (Component::U16, false) => self.gather(pick, |c: u16| c.into()),
            (Component::I8, true) => self.gather(pick, |c: i8| (f32::from(c) / 127.0).max(-1.0)),
            (Component::U8, true) => self.gather(pick, |c: u8| f32::from(c) / 255.0),
            (Component::I16, true) => self.gather(pick, |c: i16| (f32::from(c) / 32767.0).max(-1.0)),
            (Component::U16, true) => self.gather(pick, |c: u16| f32::from(c) / 65535.0),
        }
    }

    /// Whether no byte of the file stands behind the elements: all are zero.
    pub fn is_plain_zero(&self) -> bool {
        self.base.is_none() && self.overlay.is_none()
    }

    /// [`Elements::floats`] as they are stored, whether or not they are normalised.
    pub fn stored_floats<const N: usize>(&self, pick: Option<&[u32]>) -> Vec<[f32; N]> {
        self.floats_as(pick, false)
    }

    /// The elements as whole numbers; `None` unless they are stored as unsigned integers.
    pub fn integers<const N: usize>(&self, pick: Option<&[u32]>) -> Option<Vec<[u32; N]>> {
        Some(match self.accessor.component {
            Component::U8 => self.gather(pick, |c: u8| c.into()),
            Component::U16 => self.gather(pick, |c: u16| c.into()),
            Component::U32 => self.gather(pick, |c: u32| c),
            Component::I8 | Component::I16 | Component::F32 => return None,
        })
    }

    /// The elements as they are stored, `stride` bytes apart, which is at least their size. With `pick`, only those elements.
    pub fn raw(&self, pick: Option<&[u32]>, stride: usize) -> Vec<u8> {
        let size = self.accessor.shape.size(self.accessor.component) as usize;
        let count = pick.map_or(self.len(), <[u32]>::len);
        let mut out = vec![0; count * stride];
        for (k, slot) in out.chunks_exact_mut(stride.max(1)).enumerate() {
            let i = pick.map_or(k, |p| p[k] as usize);
            if let Some((bytes, apart)) = self.base {
                slot[..size].copy_from_slice(&bytes[i * apart..i * apart + size]);
            }
            if let (Some(o), Some(_)) = (&self.overlay, pick)
                && let Some(n) = o.find(i as u32)
            {
                slot[..size].copy_from_slice(&o.values[n * size..(n + 1) * size]);
            }
        }
        if let (Some(o), None) = (&self.overlay, pick) {
            for n in 0..o.len() {
                let at = o.index(n) as usize * stride;
                out[at..at + size].copy_from_slice(&o.values[n * size..(n + 1) * size]);
            }
        }
        out
    }

    fn gather<C, T, const S: usize, const N: usize>(
        &self,
        pick: Option<&[u32]>,
        convert: impl Fn(C) -> T,
    ) -> Vec<[T; N]>
    where
        C: Stored<S>,
        T: Copy + Default,
    {
        debug_assert_eq!(self.accessor.shape.components(), N as u64);
        debug_assert_eq!(self.accessor.component.size(), S as u64);
        // Only matrices have gaps between their columns.
        let gap = match self.accessor.shape {
            Shape::Mat2 => Some((2, (2 * S).next_multiple_of(4))),
            Shape::Mat3 => Some((3, (3 * S).next_multiple_of(4))),
            _ => None,
        };
        let element = |bytes: &[u8]| -> [T; N] {
            std::array::from_fn(|i| {
                let at = match gap {
                    None => i * S,
                    Some((rows, column)) => i / rows * column + i % rows * S,
                };
                let mut c = [0; S];
                c.copy_from_slice(&bytes[at..at + S]);
                convert(C::read(c))
            })
        };
        let size = self.accessor.shape.size(self.accessor.component) as usize;
        let mut out: Vec<[T; N]> = match (self.base, pick) {
            (None, _) => vec![[T::default(); N]; pick.map_or(self.len(), <[u32]>::len)],
            (Some((bytes, stride)), Some(pick)) => pick
                .iter()
                .map(|&i| {
                    let at = i as usize * stride;
                    element(&bytes[at..at + size])
                })
                .collect(),
            (Some((bytes, stride)), None) if stride == size => {
                bytes.chunks_exact(size).map(element).collect()
            }
            // The last element may end before a whole stride does.
            (Some((bytes, stride)), None) => {
                bytes.chunks(stride).take(self.len()).map(|b| element(&b[..size])).collect()
            }
        };
        if let Some(o) = &self.overlay {
            let value = |k: usize| element(&o.values[k * size..(k + 1) * size]);
            match pick {
                None => {
                    for k in 0..o.len() {
                        out[o.index(k) as usize] = value(k);
                    }
                }
                Some(pick) => {
                    for (slot, &i) in out.iter_mut().zip(pick) {
                        if let Some(k) = o.find(i) {
                            *slot = value(k);
                        }
                    }
                }
            }
        }
        out
    }
}
