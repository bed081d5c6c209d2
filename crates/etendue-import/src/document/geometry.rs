//! `meshes`.

use super::{Mapping, name, variants};
use crate::error::Fault;
use crate::extensions;
use crate::json::Reader;
use serde_json::Value;

/// How a primitive's vertices are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Mode {
    Points,
    Lines,
    LineLoop,
    LineStrip,
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    /// Whether it makes points or lines, which have no surface.
    pub fn is_stroke(self) -> bool {
        matches!(self, Self::Points | Self::Lines | Self::LineLoop | Self::LineStrip)
    }

    fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        Ok(match r.count(v)? {
            0 => Self::Points,
            1 => Self::Lines,
            2 => Self::LineLoop,
            3 => Self::LineStrip,
            4 => Self::Triangles,
            5 => Self::Strip,
            6 => Self::Fan,
            n => return Err(r.fault(format!("{n} is no primitive mode (0 to 6 are)"))),
        })
    }
}

/// Semantic names with the accessors that hold them.
pub(crate) type Attributes<'v> = Vec<(&'v str, u32)>;

/// What a morph target moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Target {
    pub position: Option<u32>,
    pub normal: Option<u32>,
    pub tangent: Option<u32>,
}

/// Geometry of one material.
pub(crate) struct Primitive<'v> {
    pub mode: Mode,
    pub attributes: Attributes<'v>,
    pub indices: Option<u32>,
    pub material: Option<u32>,
    pub targets: Vec<Target>,
    /// Other materials, by variant (`KHR_materials_variants`).
    pub mappings: Vec<Mapping>,
    /// Its compressed form (`KHR_draco_mesh_compression`).
    pub draco: Option<Draco<'v>>,
}

/// Where a primitive's compressed data are, and which of their attributes are which.
pub(crate) struct Draco<'v> {
    pub buffer_view: u32,
    pub attributes: Attributes<'v>,
}

impl<'v> Primitive<'v> {
    fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &extensions::ON_PRIMITIVE);
        Ok(Self {
            mode: r.opt(o, "mode", Mode::read)?.unwrap_or(Mode::Triangles),
            attributes: known_first(r.req(o, "attributes", |r, v| r.entries(v, Reader::index))?),
            indices: r.opt(o, "indices", Reader::index)?,
            material: r.opt(o, "material", Reader::index)?,
            targets: r.list(o, "targets", |r, v| {
                let o = r.object(v)?;
                for k in o.keys().filter(|k| !matches!(k.as_str(), "POSITION" | "NORMAL" | "TANGENT")) {
                    // Targets may also move texture coordinates and colours (glTF 2.0, 3.7.2.2).
                    let kind = k.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
                    r.warn(format!("morphing of {kind} is not supported yet; ignored"));
                }
                Ok(Target {
                    position: r.opt(o, "POSITION", Reader::index)?,
                    normal: r.opt(o, "NORMAL", Reader::index)?,
                    tangent: r.opt(o, "TANGENT", Reader::index)?,
                })
            })?,
            mappings: variants::mappings(r, o)?,
            draco: r.extension(o, extensions::DRACO, |r, o| {
                Ok(Draco {
                    buffer_view: r.req(o, "bufferView", Reader::index)?,
                    attributes: r.req(o, "attributes", |r, v| r.entries(v, Reader::index))?,
                })
            })?,
        })
    }

    /// The accessor with the semantic `name`.
    pub fn attribute(&self, name: &str) -> Option<u32> {
        self.attributes.iter().find(|(n, _)| *n == name).map(|&(_, a)| a)
    }
}

/// More attributes than any exporter writes.
const MAX_ATTRIBUTES: usize = 128;

/// Puts the attributes that have a meaning here first, and leaves out the rest of absurdly many: they are searched by
/// name wherever the primitive is shown.
fn known_first(mut attributes: Attributes<'_>) -> Attributes<'_> {
    let known = ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"];
    // Short numbers only: `TEXCOORD_4000000000` is legal and useless.
    let is_known = |n: &str| known.iter().any(|k| n.strip_prefix(k).is_some_and(|rest| rest.len() <= 2));
    attributes.sort_by_key(|(n, _)| !is_known(n));
    attributes.truncate(MAX_ATTRIBUTES);
    attributes
}

/// A group of primitives that are placed together.
pub(crate) struct Mesh<'v> {
    pub name: &'v str,
    pub primitives: Vec<Primitive<'v>>,
    pub weights: Vec<f64>,
}

impl<'v> Mesh<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &[]);
        Ok(Self {
            name: name(r, o),
            primitives: r.req(o, "primitives", |r, v| r.array(v, Primitive::read))?,
            weights: r.list(o, "weights", Reader::number)?,
        })
    }
}
