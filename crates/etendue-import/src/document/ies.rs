//! `EXT_lights_ies`: profiles at the root, lamps on nodes.

use crate::error::Fault;
use crate::json::{Object, Reader};
use serde_json::Value;

/// Where a profile's file is.
pub(crate) struct IesProfile<'v> {
    pub uri: Option<&'v str>,
    pub buffer_view: Option<u32>,
}

impl<'v> IesProfile<'v> {
    pub fn read(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &[]);
        Ok(Self {
            uri: r.opt(o, "uri", Reader::string)?,
            buffer_view: r.opt(o, "bufferView", Reader::index)?,
        })
    }
}

/// A lamp on a node.
pub(crate) struct IesLight {
    /// Which profile.
    pub light: u32,
    pub multiplier: f64,
    pub color: [f64; 3],
}

impl IesLight {
    pub fn read<'v>(r: &mut Reader<'v>, o: &'v Object) -> Result<Self, Fault> {
        Ok(Self {
            light: r.req(o, "light", Reader::index)?,
            multiplier: r.soft(o, "multiplier", Reader::number).unwrap_or(1.0),
            color: r.soft(o, "color", Reader::numbers).unwrap_or([1.0; 3]),
        })
    }
}
