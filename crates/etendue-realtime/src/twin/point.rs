//! A point of the renderer's as the shading model takes it.

use crate::inputs::{Inputs, Part};
use etendue_bxdf::sampling::Frame;
use etendue_render::ShadingPoint;
use glam::Vec3A;

/// The inputs of a point that is seen along `direction` (unit) by one of a pixel's samples.
#[inline(always)]
pub(super) fn inputs(p: &ShadingPoint, direction: Vec3A, part: Part) -> Inputs {
    let f = &p.frame;
    Inputs {
        position: p.position,
        view: -direction,
        geometric: p.geometric,
        tangent_frame: Frame { x: p.tangent, y: p.bitangent, z: p.smooth },
        frame: Frame { x: f.x_axis, y: f.y_axis, z: f.z_axis },
        surface: p.params,
        occlusion: p.occlusion,
        emission: p.emission,
        alpha: p.alpha,
        front: p.front,
        unlit: p.unlit,
        part,
    }
}
