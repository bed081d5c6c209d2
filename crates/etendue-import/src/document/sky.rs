//! `EXT_lights_image_based`: surroundings at the root.

use crate::error::Fault;
use crate::json::Reader;
use serde_json::Value;

/// Surroundings, as a cube of pictures. The coefficients of irradiance and the rougher pictures are not read: light
/// transport, and whatever shades in real time, makes its own from the sharpest one.
pub(crate) struct ImageLight {
    /// Quaternion (x, y, z, w).
    pub rotation: [f64; 4],
    pub intensity: f64,
    /// Images of the faces of the largest mip: +X, −X, +Y, −Y, +Z, −Z.
    pub faces: [u32; 6],
}

impl ImageLight {
    pub fn read<'v>(r: &mut Reader<'v>, v: &'v Value) -> Result<Self, Fault> {
        let o = r.object(v)?;
        r.other_extensions(o, &[]);
        let mips = r.req(o, "specularImages", |r, v| r.array(v, |r, v| r.array(v, Reader::index)))?;
        let faces = mips.first().and_then(|m| <[u32; 6]>::try_from(m.as_slice()).ok());
        let Some(faces) = faces else { return Err(r.fault("`specularImages` has not six faces")) };
        Ok(Self {
            rotation: r.soft(o, "rotation", Reader::numbers).unwrap_or([0.0, 0.0, 0.0, 1.0]),
            intensity: r.soft(o, "intensity", Reader::number).unwrap_or(1.0),
            faces,
        })
    }
}
