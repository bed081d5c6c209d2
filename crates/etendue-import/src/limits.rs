//! How much an import may take: bounds on what a file can make the program read and allocate.

use crate::error::Fault;
use crate::scene_file::nearest;

/// Declares the limits: a field, its documentation and its default, once for the struct and for those who set them by name.
macro_rules! limits {
    ($( $(#[doc = $about:literal])+ $field:ident : $kind:ty = $default:expr; )*) => {
        /// Bounds on one import. The defaults let every sane asset through and stop a hostile one early.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub struct Limits {
            $( $(#[doc = $about])+ pub $field: $kind, )*
            /// Whether files outside the model's own folder may be read: absolute paths and such that climb with `..`.
            pub outside_folder: bool,
        }

        impl Default for Limits {
            fn default() -> Self {
                Self { $( $field: $default, )* outside_folder: false }
            }
        }

        impl Limits {
            /// Name and explanation of every limit that is a number.
            pub const NAMES: &'static [(&'static str, &'static str)] =
                &[$( (stringify!($field), concat!($($about),+)), )*];

            /// The limit `name`; `None` if there is none.
            pub fn get(&self, name: &str) -> Option<u64> {
                match name {
                    $( stringify!($field) => Some(self.$field.into()), )*
                    _ => None,
                }
            }

            /// Sets the limit `name`.
            ///
            /// # Errors
            /// A sentence if there is no such limit, or it cannot be that large.
            pub fn set(&mut self, name: &str, value: u64) -> Result<(), String> {
                match name {
                    $( stringify!($field) => {
                        self.$field = value
                            .try_into()
                            .map_err(|_| format!("{name} can be {} at most", <$kind>::MAX))?;
                        Ok(())
                    } )*
                    _ => {
                        let names: Vec<_> = Self::NAMES.iter().map(|(n, _)| *n).collect();
                        Err(match nearest(name, names.iter().copied()) {
                            Some(n) => format!("there is no limit {name:?}; did you mean {n}?"),
                            None => format!("there is no limit {name:?}; there are {}", names.join(", ")),
                        })
                    }
                }
            }
        }
    };
}

limits! {
    /// Most memory that files, decoded pictures and geometry may take together, bytes.
    memory_bytes: u64 = 32 << 30;
    /// Largest file that is read (the model itself or one that it refers to), bytes.
    file_bytes: u64 = 8 << 30;
    /// Largest JSON part, or text of a scene file, bytes. A parsed document takes up to some twenty times its text.
    json_bytes: u64 = 256 << 20;
    /// Objects and arrays of the JSON within one another; 127 at most, which is where its parser ends.
    json_depth: u32 = 120;
    /// Longest side of a picture, pixels.
    image_dimension: u32 = 1 << 16;
    /// Largest picture, pixels.
    image_pixels: u64 = 1 << 28;
    /// All decoded pictures together, bytes.
    image_bytes: u64 = 8 << 30;
    /// Vertices of the scene's meshes together, before unwelding for tangents.
    vertices: u64 = 1 << 29;
    /// Accessors in the file.
    accessors: u64 = 1 << 24;
    /// Nodes in the file, or models in a scene file.
    nodes: u64 = 1 << 22;
    /// Nodes above one another.
    node_depth: u32 = 1 << 16;
    /// Placed meshes in the scene.
    instances: u64 = 1 << 24;
    /// Decoded geometry and instances together, bytes.
    geometry_bytes: u64 = 32 << 30;
    /// Decoded geometry and instances may take at most this many times the bytes read (and 256 MiB in any case): a
    /// small file that refers to the same data over and over cannot fill the memory.
    geometry_expansion: u32 = 64;
}

impl Limits {
    /// The same with at most `bytes` of memory, and all of them for whatever needs them: what one file, the pictures or the
    /// geometry may take for themselves is no less.
    #[must_use]
    pub fn with_memory(mut self, bytes: u64) -> Self {
        self.memory_bytes = bytes;
        self.file_bytes = self.file_bytes.max(bytes);
        self.image_bytes = self.image_bytes.max(bytes);
        self.geometry_bytes = self.geometry_bytes.max(bytes);
        self
    }

    /// What pictures may take beside `used` bytes of files and geometry, and the limit that says so.
    pub(crate) fn for_images(&self, used: u64) -> (u64, &'static str) {
        let left = self.memory_bytes.saturating_sub(used);
        if left < self.image_bytes { (left, "memory_bytes") } else { (self.image_bytes, "image_bytes") }
    }

    /// The largest file that may be read, and the limit that says so.
    pub(crate) fn for_file(&self) -> (u64, &'static str) {
        if self.memory_bytes < self.file_bytes {
            (self.memory_bytes, "memory_bytes")
        } else {
            (self.file_bytes, "file_bytes")
        }
    }
}

/// Geometry smaller than this is let through however small the file is.
const FREE_GEOMETRY: u64 = 256 << 20;

/// What is left of the bounds on decoded geometry while an import runs.
///
/// Charged while the import is planned, before anything is allocated, by one thread: so the outcome does not depend on
/// the order in which threads build meshes.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    vertices: u64,
    instances: u64,
    bytes: u64,
    /// Bytes of the file and those beside it.
    input: u64,
    limits: Limits,
    /// What may be booked, and the limit that says so.
    allowed: (u64, &'static str),
}

impl Budget {
    /// A budget for a file of which `input` bytes were read.
    pub fn new(limits: &Limits, input: u64) -> Self {
        let proportional =
            FREE_GEOMETRY.saturating_add(input.saturating_mul(limits.geometry_expansion.into()));
        let bounds = [
            (limits.memory_bytes.saturating_sub(input), "memory_bytes"),
            (limits.geometry_bytes, "geometry_bytes"),
            (proportional, "geometry_expansion"),
        ];
        let allowed = bounds.into_iter().min_by_key(|b| b.0).unwrap_or(bounds[0]);
        Self { vertices: 0, instances: 0, bytes: 0, input, limits: limits.clone(), allowed }
    }

    /// Takes away what others use of the memory.
    pub fn beside(&mut self, bytes: u64) {
        let left = self.limits.memory_bytes.saturating_sub(self.input).saturating_sub(bytes);
        if left < self.allowed.0 {
            self.allowed = (left, "memory_bytes");
        }
    }

    /// What is booked, bytes.
    pub fn booked(&self) -> u64 {
        self.bytes
    }

    /// Books `vertices` that take `bytes` in all.
    pub fn vertices(&mut self, vertices: u64, bytes: u64, pointer: impl Fn() -> String) -> Result<(), Fault> {
        self.vertices = self.vertices.saturating_add(vertices);
        if self.vertices > self.limits.vertices {
            return Err(Fault::TooLarge {
                pointer: pointer(),
                what: format!("more than {} vertices", self.limits.vertices),
                limit: "vertices",
            });
        }
        self.bytes(bytes, pointer)
    }

    /// Books `count` instances that take `bytes` in all.
    pub fn instances(&mut self, count: u64, bytes: u64, pointer: impl Fn() -> String) -> Result<(), Fault> {
        self.instances = self.instances.saturating_add(count);
        if self.instances > self.limits.instances {
            return Err(Fault::TooLarge {
                pointer: pointer(),
                what: format!("more than {} instances", self.limits.instances),
                limit: "instances",
            });
        }
        self.bytes(bytes, pointer)
    }

    /// Books `bytes` of decoded data.
    pub fn bytes(&mut self, bytes: u64, pointer: impl Fn() -> String) -> Result<(), Fault> {
        self.bytes = self.bytes.saturating_add(bytes);
        let (allowed, limit) = self.allowed;
        if self.bytes > allowed {
            let what = format!("decodes to more than {}", shown(allowed));
            return Err(Fault::TooLarge { pointer: pointer(), what, limit });
        }
        Ok(())
    }
}

/// A number of bytes for people.
pub(crate) fn shown(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} bytes"),
        1024..0x10_0000 => format!("{} KiB", bytes >> 10),
        _ => format!("{} MiB", bytes >> 20),
    }
}
