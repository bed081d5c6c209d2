//! `nodes`, `cameras`, and the lights of `KHR_lights_punctual`.

use super::geometry::Attributes;
use super::{IesLight, name};
use crate::error::Fault;
use crate::extensions as ext;
use crate::json::Reader;
use serde_json::Value;

/// A node's place in its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Local {
    /// Translation, rotation quaternion (x, y, z, w), scale.
    Trs([f64; 3], [f64; 4], [f64; 3]),
    /// Column by column.
    Matrix([f64; 16]),
}

impl Local {
    pub const IDENTITY: Self = Self::Trs([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0; 3]);
}

/// A place in the hierarchy, and what stands there.
pub(crate) struct Node<'v> {
    pub name: &'v str,
    pub children: Vec<u32>,
    pub mesh: Option<u32>,
    pub skin: Option<u32>,
    pub camera: Option<u32>,
    pub light: Option<u32>,
    /// `EXT_lights_ies`.
    pub ies: Option<IesLight>,
    /// Overrides the mesh's morph weights.
    pub weights: Option<Vec<f64>>,
    /// `None` is the identity.
    pub local: Option<Box<Local>>,
    /// `KHR_node_visibility`: whether it is shown, with all below it.
    pub visible: bool,
    /// `EXT_mesh_gpu_instancing`.
    pub instancing: Option<Attributes<'v>>,
}

impl<'v> Node<'v> {
    /// One that is nothing but a place for a mesh.
    pub fn of_mesh(mesh: u32) -> Self {
        Self {
            name: "",
            children: Vec::new(),
            mesh: Some(mesh),
            skin: None,
            camera: None,
            light: None,
            ies: None,
            weights: None,
            local: None,
            visible: true,
            instancing: None,
        }
    }

    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &ext::ON_NODE);
        let matrix = r.opt(o, "matrix", Reader::numbers)?;
        let t = r.opt(o, "translation", Reader::numbers)?;
        let q = r.opt(o, "rotation", Reader::numbers)?;
        let s = r.opt(o, "scale", Reader::numbers)?;
        let trs = t.is_some() || q.is_some() || s.is_some();
        let local = match matrix {
            Some(m) => {
                if trs {
                    r.warn("has both a matrix and translation, rotation or scale; the matrix is used");
                }
                Some(Box::new(Local::Matrix(m)))
            }
            None if trs => Some(Box::new(Local::Trs(
                t.unwrap_or_default(),
                q.unwrap_or([0.0, 0.0, 0.0, 1.0]),
                s.unwrap_or([1.0; 3]),
            ))),
            None => None,
        };
        Ok(Self {
            name: name(r, o),
            children: r.list(o, "children", Reader::index)?,
            mesh: r.opt(o, "mesh", Reader::index)?,
            skin: r.opt(o, "skin", Reader::index)?,
            camera: r.opt(o, "camera", Reader::index)?,
            light: r.extension(o, ext::LIGHTS_PUNCTUAL, |r, o| r.req(o, "light", Reader::index))?,
            ies: r.extension(o, ext::LIGHTS_IES, IesLight::read)?,
            weights: r.opt(o, "weights", |r, v| r.array(v, Reader::number))?,
            local,
            visible: r
                .extension(o, ext::NODE_VISIBILITY, |r, o| Ok(r.soft(o, "visible", Reader::boolean)))?
                .flatten()
                .unwrap_or(true),
            instancing: r.extension(o, ext::GPU_INSTANCING, |r, o| {
                r.req(o, "attributes", |r, v| r.entries(v, Reader::index))
            })?,
        })
    }
}

/// How a camera maps space to the picture.
#[derive(Clone, Copy)]
pub(crate) enum Projection {
    Perspective { yfov: f64, aspect: Option<f64> },
    Orthographic { xmag: f64, ymag: f64 },
}

/// A camera, without a place.
pub(crate) struct Camera<'v> {
    pub name: &'v str,
    pub projection: Projection,
}

impl<'v> Camera<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &[]);
        let projection = match r.req(o, "type", Reader::string)? {
            "perspective" => r.req(o, "perspective", |r, v| {
                let o = r.object(v)?;
                Ok(Projection::Perspective {
                    yfov: r.req(o, "yfov", Reader::number)?,
                    aspect: r.soft(o, "aspectRatio", Reader::number),
                })
            })?,
            "orthographic" => r.req(o, "orthographic", |r, v| {
                let o = r.object(v)?;
                Ok(Projection::Orthographic {
                    xmag: r.req(o, "xmag", Reader::number)?,
                    ymag: r.req(o, "ymag", Reader::number)?,
                })
            })?,
            other => return Err(r.fault(format!("`{other}` is no camera type"))),
        };
        Ok(Self { name: name(r, o), projection })
    }
}

/// Shape of a punctual light.
#[derive(Clone, Copy)]
pub(crate) enum LightShape {
    /// A type that is not known; named by a warning.
    Unknown,
    Directional,
    Point,
    Spot {
        inner: f64,
        outer: f64,
    },
}

/// A light of `KHR_lights_punctual`, without a place.
pub(crate) struct Light<'v> {
    pub name: &'v str,
    pub shape: LightShape,
    pub color: [f64; 3],
    pub intensity: f64,
    pub range: Option<f64>,
}

impl<'v> Light<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &[]);
        let shape = match r.req(o, "type", Reader::string)? {
            "directional" => LightShape::Directional,
            "point" => LightShape::Point,
            "spot" => {
                let angles = r.opt(o, "spot", |r, v| {
                    let o = r.object(v)?;
                    Ok((
                        r.soft(o, "innerConeAngle", Reader::number),
                        r.soft(o, "outerConeAngle", Reader::number),
                    ))
                })?;
                let (inner, outer) = angles.unwrap_or_default();
                LightShape::Spot {
                    inner: inner.unwrap_or(0.0),
                    outer: outer.unwrap_or(std::f64::consts::FRAC_PI_4),
                }
            }
            // A later version of the extension may add types; the rest of the file stays good.
            _ => {
                r.warn("a light of an unknown type; left out");
                LightShape::Unknown
            }
        };
        Ok(Self {
            name: name(r, o),
            shape,
            color: r.soft(o, "color", Reader::numbers).unwrap_or([1.0; 3]),
            intensity: r.soft(o, "intensity", Reader::number).unwrap_or(1.0),
            range: r.soft(o, "range", Reader::number),
        })
    }
}
