//! Outlines moved along curves: rims, gaskets, straps, hoses.

use crate::shape::{Mesh, ProfilePoint};
use glam::{Vec2, Vec3};

/// A place on a curve, with the directions in which an outline's coordinates run.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The curve's point, metres.
    pub p: Vec3,
    /// The outline's first axis, unit. With the curve's direction T and `up`, side = T × up.
    pub side: Vec3,
    /// The outline's second axis, unit.
    pub up: Vec3,
    /// Length of the curve up to here, metres.
    pub len: f32,
}

/// Frames along `points` (position and surface normal). A closed curve repeats its first point at the end.
pub fn frames_on_surface(points: &[(Vec3, Vec3)], closed: bool) -> Vec<Frame> {
    let n = points.len();
    let mut len = 0.0;
    (0..n)
        .map(|i| {
            let (p, up) = points[i];
            let before = if i > 0 {
                i - 1
            } else if closed {
                n - 2
            } else {
                0
            };
            let after = if i + 1 < n {
                i + 1
            } else if closed {
                1
            } else {
                i
            };
            if i > 0 {
                len += p.distance(points[i - 1].0);
            }
            let along = (points[after].0 - points[before].0).normalize();
            let side = along.cross(up).normalize();
            Frame { p, side, up: side.cross(along).normalize(), len }
        })
        .collect()
}

/// Frames along a free curve that turn as little as possible (double reflection: Wang, Jüttler, Zheng, Liu 2008).
pub fn frames_in_space(points: &[Vec3], up: Vec3) -> Vec<Frame> {
    let n = points.len();
    let tangent = |i: usize| (points[(i + 1).min(n - 1)] - points[i.saturating_sub(1)]).normalize();
    let mut r = (up - tangent(0) * up.dot(tangent(0))).normalize();
    let mut len = 0.0;
    (0..n)
        .map(|i| {
            if i > 0 {
                let v1 = points[i] - points[i - 1];
                len += v1.length();
                let reflect = |x: Vec3, v: Vec3| x - v * (2.0 * x.dot(v) / v.length_squared());
                let (rl, tl) = (reflect(r, v1), reflect(tangent(i - 1), v1));
                let v2 = tangent(i) - tl;
                r = if v2.length_squared() > 1e-12 { reflect(rl, v2) } else { rl };
            }
            Frame { p: points[i], side: tangent(i).cross(r).normalize(), up: r, len }
        })
        .collect()
}

/// Sweeps an outline along frames. `scale` scales the outline at a frame (index, relative length 0..1). Texture
/// coordinates: u along the curve, v across the outline, both 0..1; paint coordinates: the same in metres.
/// Normals are the outline's, tilted by nothing: scale should change slowly.
pub fn sweep(frames: &[Frame], outline: &[ProfilePoint], scale: impl Fn(usize, f32) -> Vec2) -> Mesh {
    let mut m = Mesh::default();
    let total = frames.last().map_or(1.0, |f| f.len);
    let width = outline.last().map_or(1.0, |q| q.len);
    for q in outline {
        for (i, f) in frames.iter().enumerate() {
            let s = scale(i, f.len / total);
            let p = f.p + f.side * (q.p.x * s.x) + f.up * (q.p.y * s.y);
            // Normals scale by the inverse of what positions scale by.
            let n = (f.side * (q.n.x * s.y) + f.up * (q.n.y * s.x)).normalize_or(f.up);
            m.push(p, n, Vec2::new(f.len / total, q.len / width), Vec3::new(f.len, q.len, 0.0));
        }
    }
    m.connect(0, frames.len() as u32, outline.len() as u32);
    m
}
