//! Points and lines as things that can be seen: balls and tubes.
//!
//! glTF 2.0 (3.9.7, not normative) would have them one pixel wide. Here a scene is rendered at any size and from anywhere, and
//! what is in it has a place and a size: they are [`THICKNESS`] of the mesh's diagonal thick, about a pixel of a picture that shows
//! the mesh at 500 pixels. Without normals they are shown unlit, as the specification has it; with normals they are lit as the
//! thin round things that they are.

use etendue_scene::Mesh;
use glam::{Vec3, Vec4};

/// Thickness as a part of the diagonal of the mesh's bounds.
const THICKNESS: f32 = 1.0 / 500.0;

/// Corners around a tube.
const SIDES: usize = 6;

/// Vertices and triangles of a tube with its two pointed ends; a ball has fewer.
pub(crate) const VERTICES: u64 = 2 * SIDES as u64 + 2;
pub(crate) const TRIANGLES: u64 = 4 * SIDES as u64;

/// Vertices, and bytes of a mesh, that balls and tubes take at `per_vertex` bytes of attributes.
pub(crate) fn estimate(balls: u64, tubes: u64, per_vertex: u64) -> (u64, u64) {
    let sum = |ball: u64, tube: u64| balls.saturating_mul(ball).saturating_add(tubes.saturating_mul(tube));
    let vertices = sum(SIDES as u64 + 2, VERTICES);
    let triangles = sum(2 * SIDES as u64, TRIANGLES);
    (vertices, vertices.saturating_mul(per_vertex).saturating_add(triangles.saturating_mul(12)))
}

/// Puts a tube in place of each triangle `[a, b, b]` of `m`, a ball in place of each `[a, a, a]`. Attributes of a vertex go to all
/// vertices around it; normals become those of the tubes, tangents are left out.
pub(crate) fn thicken(m: &mut Mesh) {
    let seen = m.indices.as_flattened().iter().map(|&i| m.positions[i as usize]).filter(|p| p.is_finite());
    let (low, high) =
        seen.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let diagonal = (high - low).length();
    // A single point has no size to go by.
    let diagonal = if diagonal.is_finite() && diagonal > 0.0 { diagonal } else { 1.0 };
    let radius = 0.5 * THICKNESS * diagonal;

    let lit = !m.normals.is_empty();
    let mut out = Mesh { name: std::mem::take(&mut m.name), ..Mesh::default() };
    out.uvs = vec![Vec::new(); m.uvs.len()];
    for &[a, b, _] in &m.indices {
        let (from, to) = (m.positions[a as usize], m.positions[b as usize]);
        let along = if a == b { Vec3::ZERO } else { (to - from).normalize_or_zero() };
        let first = out.positions.len() as u32;
        let mut put = |vertex: u32, place: Vec3, away: Vec3| {
            out.positions.push(place);
            if lit {
                out.normals.push(away);
            }
            if let Some(c) = m.colors.get(vertex as usize) {
                out.colors.push(*c);
            }
            for (to, set) in out.uvs.iter_mut().zip(&m.uvs) {
                to.extend(set.get(vertex as usize));
            }
        };
        // A ball is a tube of no length, with its ends as far out as its sides.
        let axis = if along == Vec3::ZERO { Vec3::Y } else { along };
        let (x, y) = axis.any_orthonormal_pair();
        let ring: [Vec3; SIDES] = std::array::from_fn(|i| {
            let (s, c) = (std::f32::consts::TAU * i as f32 / SIDES as f32).sin_cos();
            x * c + y * s
        });
        put(a, from - axis * radius, -axis);
        ring.iter().for_each(|&d| put(a, from + d * radius, d));
        let s = SIDES as u32;
        let next = |i: u32| (i + 1) % s;
        let end = if along == Vec3::ZERO {
            first + 1
        } else {
            ring.iter().for_each(|&d| put(b, to + d * radius, d));
            for i in 0..s {
                let (p, q) = (first + 1 + i, first + 1 + next(i));
                out.indices.extend([[p, q, p + s], [q, q + s, p + s]]);
            }
            first + 1 + s
        };
        put(b, to + axis * radius, axis);
        let tip = end + s;
        for i in 0..s {
            out.indices.push([first, first + 1 + next(i), first + 1 + i]);
            out.indices.push([tip, end + i, end + next(i)]);
        }
    }
    if out.colors.len() != out.positions.len() {
        out.colors = Vec::<Vec4>::new();
    }
    *m = out;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(indices: Vec<[u32; 3]>, normals: bool) -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::new(3.0, 0.0, 0.0), Vec3::new(3.0, 4.0, 0.0)];
        let normals = if normals { vec![Vec3::Z; 3] } else { Vec::new() };
        let colors = vec![Vec4::ONE, Vec4::X, Vec4::W];
        let mut m = Mesh { positions, normals, colors, indices, ..Mesh::default() };
        thicken(&mut m);
        m
    }

    /// Volume by the divergence theorem: positive only if all triangles face outwards.
    fn volume(m: &Mesh) -> f32 {
        let p = |i: u32| m.positions[i as usize];
        m.indices.iter().map(|&[a, b, c]| p(a).dot(p(b).cross(p(c))) / 6.0).sum()
    }

    #[test]
    fn tubes_are_closed_and_of_their_length_and_thickness() {
        let m = stroke(vec![[0, 1, 1], [1, 2, 2]], false);
        assert_eq!((m.positions.len() as u64, m.indices.len() as u64), (2 * VERTICES, 2 * TRIANGLES));
        let radius = 5.0 * THICKNESS / 2.0;
        let section = 0.5 * SIDES as f32 * (std::f32::consts::TAU / SIDES as f32).sin() * radius * radius;
        // Two lines, and the four pyramids at their ends.
        let expected = section * (3.0 + 4.0) + 4.0 * section * radius / 3.0;
        assert!((volume(&m) / expected - 1.0).abs() < 1e-3, "{} {expected}", volume(&m));
        // Each edge is there once in each direction.
        let mut edges: Vec<[u32; 2]> =
            m.indices.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|w| w[0] != w[1]));
        assert!(edges.iter().all(|e| edges.binary_search(&[e[1], e[0]]).is_ok()));
        assert!(m.normals.is_empty() && m.colors.len() == m.positions.len());
    }

    #[test]
    fn points_are_balls_with_normals_outwards() {
        let m = stroke(vec![[2, 2, 2]], true);
        assert_eq!(m.positions.len() as u64, VERTICES - SIDES as u64);
        let away = |i: usize| (m.positions[i] - Vec3::new(3.0, 4.0, 0.0)).normalize().dot(m.normals[i]);
        assert!((0..m.positions.len()).all(|i| away(i) > 0.999));
        assert!(volume(&m) > 0.0 && m.colors.iter().all(|c| *c == Vec4::W));
    }
}
