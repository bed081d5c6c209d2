//! How much an import may take: bounds on what a file can make the program read and allocate.

use crate::error::Fault;

/// Bounds on one import. The defaults let every sane asset through and stop a hostile one early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest file that is read (the model itself or one that it refers to), bytes.
    pub file_bytes: u64,
    /// Largest JSON part, bytes. A parsed document takes up to some twenty times its text.
    pub json_bytes: u64,
    /// Largest picture, pixels.
    pub image_pixels: u64,
    /// All decoded pictures together, bytes.
    pub image_bytes: u64,
    /// Vertices of the scene's meshes together, before unwelding for tangents.
    pub vertices: u64,
    /// Nodes in the file.
    pub nodes: u64,
    /// Nodes above one another.
    pub node_depth: u32,
    /// Placed meshes in the scene.
    pub instances: u64,
    /// Decoded geometry and instances together, bytes.
    pub geometry_bytes: u64,
    /// Decoded geometry and instances may take at most this many times the bytes read (and 256 MiB in any case): a
    /// small file that refers to the same data over and over cannot fill the memory.
    pub geometry_expansion: u32,
    /// Whether files outside the model's own folder may be read: absolute paths and such that climb with `..`.
    pub outside_folder: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 8 << 30,
            json_bytes: 256 << 20,
            image_pixels: 1 << 28,
            image_bytes: 8 << 30,
            vertices: 1 << 29,
            nodes: 1 << 22,
            node_depth: 1 << 16,
            instances: 1 << 24,
            geometry_bytes: 32 << 30,
            geometry_expansion: 64,
            outside_folder: false,
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
    limits: Limits,
    allowed_bytes: u64,
}

impl Budget {
    /// A budget for a file of which `input` bytes were read.
    pub fn new(limits: &Limits, input: u64) -> Self {
        let proportional =
            FREE_GEOMETRY.saturating_add(input.saturating_mul(limits.geometry_expansion.into()));
        Self {
            vertices: 0,
            instances: 0,
            bytes: 0,
            limits: limits.clone(),
            allowed_bytes: limits.geometry_bytes.min(proportional),
        }
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
        if self.bytes > self.allowed_bytes {
            return Err(Fault::TooLarge {
                pointer: pointer(),
                what: format!("decodes to more than {} MiB", self.allowed_bytes >> 20),
                limit: if self.allowed_bytes == self.limits.geometry_bytes {
                    "geometry_bytes"
                } else {
                    "geometry_expansion"
                },
            });
        }
        Ok(())
    }
}
