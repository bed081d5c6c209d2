//! Rays against the helmet's own triangles: how open a place is, and how sharp an edge it lies on.

use crate::noise::{hash, unit};
use crate::shape::Mesh;
use glam::{Vec2, Vec3};

/// A small bounding-volume hierarchy that answers "is anything within this distance".
pub struct Occluders {
    nodes: Vec<Node>,
    /// First corner and the two edges.
    triangles: Vec<[Vec3; 3]>,
}

struct Node {
    min: Vec3,
    max: Vec3,
    /// First triangle for a leaf, index of the right child otherwise (the left one follows its parent).
    start: u32,
    /// Triangles of a leaf, 0 for an inner node.
    count: u32,
}

impl Occluders {
    /// A hierarchy over meshes in world space, split at the median of the longest axis.
    pub fn new<'a>(meshes: impl Iterator<Item = &'a Mesh>) -> Self {
        let mut triangles: Vec<[Vec3; 3]> = meshes
            .flat_map(|m| m.idx.chunks_exact(3).map(|t| [0, 1, 2].map(|k| m.pos[t[k] as usize])))
            .collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        let n = triangles.len();
        build(&mut nodes, &mut triangles, 0, n);
        for t in &mut triangles {
            *t = [t[0], t[1] - t[0], t[2] - t[0]];
        }
        Self { nodes, triangles }
    }

    /// Whether a ray hits anything before `limit`.
    pub fn hits(&self, o: Vec3, d: Vec3, limit: f32) -> bool {
        let inv = d.recip();
        let mut stack = [0u32; 64];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let i = stack[top];
            let node = &self.nodes[i as usize];
            let (a, b) = ((node.min - o) * inv, (node.max - o) * inv);
            if a.min(b).max_element().max(0.0) > a.max(b).min_element().min(limit) {
                continue;
            }
            if node.count > 0 {
                let leaf = &self.triangles[node.start as usize..(node.start + node.count) as usize];
                if leaf.iter().any(|t| hits_triangle(t, o, d, limit)) {
                    return true;
                }
            } else {
                stack[top] = i + 1;
                stack[top + 1] = node.start;
                top += 2;
            }
        }
        false
    }

    /// The open part of the cosine-weighted hemisphere around `n` within `reach` metres, 0..1, from `rays` rays.
    pub fn openness(&self, p: Vec3, n: Vec3, reach: f32, rays: u32, salt: u32) -> f32 {
        let (t, b) = n.any_orthonormal_pair();
        let turn = unit(hash(salt));
        let shift = unit(hash(salt ^ 0x5bd1_e995));
        let open = (0..rays)
            .filter(|&i| {
                // A Fibonacci spiral, turned and shifted from place to place.
                let u = (i as f32 + shift) / rays as f32;
                let a = std::f32::consts::TAU * (i as f32 * 0.618_034 + turn);
                let (s, c) = a.sin_cos();
                let q = Vec2::new(c, s) * u.sqrt();
                let d = t * q.x + b * q.y + n * (1.0 - u).sqrt().max(1e-3);
                !self.hits(p, d, reach)
            })
            .count();
        open as f32 / rays as f32
    }
}

fn build(nodes: &mut Vec<Node>, all: &mut [[Vec3; 3]], start: usize, end: usize) {
    let part = &mut all[start..end];
    let (mut min, mut max) = (Vec3::MAX, Vec3::MIN);
    for p in part.iter().flatten() {
        (min, max) = (min.min(*p), max.max(*p));
    }
    let me = nodes.len();
    nodes.push(Node { min, max, start: start as u32, count: (end - start) as u32 });
    if part.len() <= 4 {
        return;
    }
    let axis = (max - min).max_position();
    let middle = part.len() / 2;
    let key = |t: &[Vec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
    part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    nodes[me].count = 0;
    build(nodes, all, start, start + middle);
    nodes[me].start = nodes.len() as u32;
    build(nodes, all, start + middle, end);
}

/// Möller and Trumbore (1997), both faces.
fn hits_triangle(t: &[Vec3; 3], o: Vec3, d: Vec3, limit: f32) -> bool {
    let p = d.cross(t[2]);
    let det = t[1].dot(p);
    if det.abs() < 1e-20 {
        return false;
    }
    let s = o - t[0];
    let u = s.dot(p) / det;
    let q = s.cross(t[1]);
    let v = d.dot(q) / det;
    let at = t[2].dot(q) / det;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 0.0 && at < limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lathe::lathe;
    use crate::shape::outline;

    #[test]
    fn the_hierarchy_agrees_with_every_triangle() {
        let o = outline(
            &[(1.0, -1.0, 0.0), (1.0, 0.5, 0.2), (0.4, 0.6, 0.1), (0.3, 0.1, 0.05), (0.0, 0.2, 0.0)],
            3,
        );
        let m = lathe(&o, 24);
        let world = Occluders::new([&m].into_iter());
        let mut hits = 0;
        for i in 0..2000u32 {
            let r = |k: u32| unit(hash(i * 8 + k)) * 2.0 - 1.0;
            let (p, d) = (Vec3::new(r(0), r(1), r(2)) * 1.5, Vec3::new(r(3), r(4), r(5)).normalize());
            let limit = 0.5 + r(6).abs();
            let all = world.triangles.iter().any(|t| hits_triangle(t, p, d, limit));
            assert_eq!(world.hits(p, d, limit), all, "ray {i}");
            hits += all as u32;
        }
        assert!(hits > 200, "only {hits} rays hit anything");
    }

    #[test]
    fn half_of_the_sky_is_open_beside_a_wall() {
        let mut m = crate::shape::Mesh::default();
        for (y, z) in [(-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3)] {
            m.push(Vec3::new(0.01, y, z), Vec3::NEG_X, Vec2::ZERO, Vec3::ZERO);
        }
        m.tri(0, 1, 2);
        m.tri(0, 2, 3);
        let world = Occluders::new([&m].into_iter());
        let open = world.openness(Vec3::ZERO, Vec3::Z, 1e4, 4096, 1);
        assert!((open - 0.5).abs() < 0.01, "{open}");
    }
}
