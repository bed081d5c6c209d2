//! Outlines turned around an axis: pods, bolts, connectors.

use crate::shape::{Mesh, ProfilePoint};
use glam::{Vec2, Vec3};

/// Turns an outline (radius, height) around +Z in `segments` steps. Texture coordinates are the unrolled disc: distance from
/// the centre is the outline's length from its end, so that the face seen from +Z lies in the picture undistorted near the
/// axis. Paint coordinates: distance from the centre along the outline (metres), angle (radians).
pub fn lathe(outline: &[ProfilePoint], segments: u32) -> Mesh {
    let mut m = Mesh::default();
    let total = outline.last().map_or(1.0, |q| q.len);
    for q in outline {
        for i in 0..=segments {
            let a = std::f32::consts::TAU * (i % segments) as f32 / segments as f32;
            let (s, c) = a.sin_cos();
            let r = (total - q.len) / total;
            let uv = Vec2::new(0.5 + 0.5 * r * c, 0.5 - 0.5 * r * s);
            let angle = std::f32::consts::TAU * i as f32 / segments as f32;
            m.push(
                Vec3::new(q.p.x * c, q.p.x * s, q.p.y),
                Vec3::new(q.n.x * c, q.n.x * s, q.n.y),
                uv,
                Vec3::new(total - q.len, angle, 0.0),
            );
        }
    }
    m.connect(0, segments + 1, outline.len() as u32);
    m
}
