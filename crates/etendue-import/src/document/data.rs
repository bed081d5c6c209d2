//! `buffers`, `bufferViews`, `accessors`.

use crate::error::Fault;
use crate::extensions;
use crate::json::{Object, Reader};
use crate::meshopt::{self, Filter, Mode};
use serde_json::Value;

/// A block of bytes: in the GLB, in a data URI or in a file.
pub(crate) struct Buffer<'v> {
    pub uri: Option<&'v str>,
    pub byte_length: u64,
}

impl<'v> Buffer<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        Ok(Self {
            uri: r.opt(o, "uri", Reader::string)?,
            byte_length: r.req(o, "byteLength", Reader::count)?,
        })
    }
}

/// A range of a buffer.
pub(crate) struct BufferView {
    pub buffer: u32,
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    /// The compressed form of its content (`KHR_meshopt_compression`); the range above is then that of a fallback.
    pub compressed: Option<Box<Compressed>>,
}

/// A range of a buffer that decodes to the content of a view.
pub(crate) struct Compressed {
    pub buffer: u32,
    pub byte_offset: u64,
    pub byte_length: u64,
    pub layout: meshopt::Layout,
    /// The extension that says so.
    pub extension: &'static str,
}

impl Compressed {
    fn read<'v>(r: &mut Reader<'v>, o: &'v Object, extension: &'static str) -> Result<Self, Fault> {
        let mode = |r: &mut Reader<'v>, v| match r.string(v)? {
            "ATTRIBUTES" => Ok(Mode::Attributes),
            "TRIANGLES" => Ok(Mode::Triangles),
            "INDICES" => Ok(Mode::Indices),
            s => Err(r.fault(format!("`{s}` is no mode (ATTRIBUTES, TRIANGLES, INDICES are)"))),
        };
        let filter = |r: &mut Reader<'v>, v| match r.string(v)? {
            "NONE" => Ok(Filter::None),
            "OCTAHEDRAL" => Ok(Filter::Octahedral),
            "QUATERNION" => Ok(Filter::Quaternion),
            "EXPONENTIAL" => Ok(Filter::Exponential),
            "COLOR" => Ok(Filter::Color),
            s => {
                let known = "NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL, COLOR";
                Err(r.fault(format!("`{s}` is no filter ({known} are)")))
            }
        };
        Ok(Self {
            buffer: r.req(o, "buffer", Reader::index)?,
            byte_offset: r.opt(o, "byteOffset", Reader::count)?.unwrap_or(0),
            byte_length: r.req(o, "byteLength", Reader::count)?,
            layout: meshopt::Layout {
                mode: r.req(o, "mode", mode)?,
                filter: r.opt(o, "filter", filter)?.unwrap_or_default(),
                count: r.req(o, "count", Reader::count)?,
                stride: r.req(o, "byteStride", Reader::count)?,
            },
            extension,
        })
    }
}

impl BufferView {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        let byte_stride = r.opt(o, "byteStride", |r, v| match r.count(v)? {
            n @ 4..=252 => Ok(n),
            n => Err(r.fault(format!("a stride of 4 to 252 bytes is needed, not {n}"))),
        })?;
        let mut compressed = None;
        for name in [extensions::KHR_MESHOPT, extensions::EXT_MESHOPT] {
            if compressed.is_none() {
                compressed = r.extension(o, name, |r, o| Compressed::read(r, o, name).map(Box::new))?;
            }
        }
        r.other_extensions(o, &extensions::ON_BUFFER_VIEW);
        Ok(Self {
            buffer: r.req(o, "buffer", Reader::index)?,
            byte_offset: r.opt(o, "byteOffset", Reader::count)?.unwrap_or(0),
            byte_length: r.req(o, "byteLength", Reader::count)?,
            byte_stride,
            compressed,
        })
    }
}

/// Type of one component of an accessor's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// Bytes.
    pub fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Its number in the file.
    pub fn code(self) -> u64 {
        match self {
            Self::I8 => 5120,
            Self::U8 => 5121,
            Self::I16 => 5122,
            Self::U16 => 5123,
            Self::U32 => 5125,
            Self::F32 => 5126,
        }
    }

    /// The number that as many `bytes` as it has say, not normalised.
    pub fn value(self, bytes: &[u8]) -> f64 {
        let mut four = [0; 4];
        let n = bytes.len().min(4);
        four[..n].copy_from_slice(&bytes[..n]);
        let bits = u32::from_le_bytes(four);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::U32 => f64::from(bits),
            Self::F32 => f64::from(f32::from_bits(bits)),
        }
    }

    /// The type, or `None` and a warning for one that is not known: something that nobody uses may have it.
    fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Option<Self>, Fault> {
        Ok(Some(match r.count(v)? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            n => {
                r.warn(format!("{n} is no component type (5120-5123, 5125, 5126 are): of no use"));
                return Ok(None);
            }
        }))
    }
}

/// How many components an element has, and how they are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shape {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
    /// A type that is not known, of elements or of their components; nothing accepts it.
    Unknown,
}

impl Shape {
    /// Name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "SCALAR",
            Self::Vec2 => "VEC2",
            Self::Vec3 => "VEC3",
            Self::Vec4 => "VEC4",
            Self::Mat2 => "MAT2",
            Self::Mat3 => "MAT3",
            Self::Mat4 => "MAT4",
            Self::Unknown => "a type that is not known",
        }
    }

    /// Components per element.
    pub fn components(self) -> u64 {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 | Self::Mat2 => 4,
            Self::Mat3 => 9,
            Self::Mat4 => 16,
            Self::Unknown => 0,
        }
    }

    /// Bytes of one element of `component`s. A matrix column starts at a multiple of four bytes (glTF 2.0, 3.6.2.4).
    pub fn size(self, component: Component) -> u64 {
        let c = component.size();
        match self {
            Self::Mat2 => 2 * (2 * c).next_multiple_of(4),
            Self::Mat3 => 3 * (3 * c).next_multiple_of(4),
            _ => self.components() * c,
        }
    }

    fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        Ok(match r.string(v)? {
            "SCALAR" => Self::Scalar,
            "VEC2" => Self::Vec2,
            "VEC3" => Self::Vec3,
            "VEC4" => Self::Vec4,
            "MAT2" => Self::Mat2,
            "MAT3" => Self::Mat3,
            "MAT4" => Self::Mat4,
            s => {
                r.warn(format!("`{s}` is no accessor type: of no use"));
                Self::Unknown
            }
        })
    }
}

/// Elements that differ from the accessor's own.
#[derive(Clone)]
pub(crate) struct Sparse {
    pub count: u64,
    pub indices_view: u32,
    pub indices_offset: u64,
    pub indices_component: Component,
    pub values_view: u32,
    pub values_offset: u64,
}

impl Sparse {
    fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        let count = r.req(o, "count", Reader::count)?;
        let (indices_view, indices_offset, indices_component) = r.req(o, "indices", |r, v| {
            let o = r.object(v)?;
            let component = r.req(o, "componentType", |r, v| match Component::read(r, v)? {
                Some(c @ (Component::U8 | Component::U16 | Component::U32)) => Ok(c),
                _ => Err(r.fault("sparse indices are unsigned integers (5121, 5123, 5125)")),
            })?;
            Ok((
                r.req(o, "bufferView", Reader::index)?,
                r.opt(o, "byteOffset", Reader::count)?.unwrap_or(0),
                component,
            ))
        })?;
        let (values_view, values_offset) = r.req(o, "values", |r, v| {
            let o = r.object(v)?;
            Ok((r.req(o, "bufferView", Reader::index)?, r.opt(o, "byteOffset", Reader::count)?.unwrap_or(0)))
        })?;
        Ok(Self { count, indices_view, indices_offset, indices_component, values_view, values_offset })
    }
}

/// A typed array in a buffer view. `min` and `max` are hints that nothing here relies on; they are not read.
#[derive(Clone)]
pub(crate) struct Accessor {
    pub buffer_view: Option<u32>,
    pub byte_offset: u64,
    pub component: Component,
    pub normalized: bool,
    pub count: u64,
    pub shape: Shape,
    pub sparse: Option<Box<Sparse>>,
    /// Where its elements are, if they were decoded from a compressed primitive: they stand without gaps.
    pub decoded: Option<u32>,
    /// The file's accessor that it stands for, if it is none itself.
    pub origin: Option<u32>,
}

impl Accessor {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &extensions::ON_ACCESSOR);
        let component = r.req(o, "componentType", Component::read)?;
        let shape = r.req(o, "type", Shape::read)?;
        Ok(Self {
            buffer_view: r.opt(o, "bufferView", Reader::index)?,
            byte_offset: r.opt(o, "byteOffset", Reader::count)?.unwrap_or(0),
            component: component.unwrap_or(Component::U8),
            normalized: r.opt(o, "normalized", Reader::boolean)?.unwrap_or(false),
            count: r.req(o, "count", Reader::count)?,
            shape: if component.is_some() { shape } else { Shape::Unknown },
            sparse: r.opt(o, "sparse", |r, v| Sparse::read(r, v).map(Box::new))?,
            decoded: None,
            origin: None,
        })
    }
}
