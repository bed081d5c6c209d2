//! Triangle meshes while they are being made: positions, normals, texture and paint coordinates.

use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};

/// A triangle mesh under construction. Counter-clockwise triangles face outward.
#[derive(Clone, Default)]
pub struct Mesh {
    /// Positions, metres.
    pub pos: Vec<Vec3>,
    /// Unit shading normals.
    pub nrm: Vec<Vec3>,
    /// Texture coordinates, 0..1 in the material's picture once placed (see [`Mesh::place_uv`]).
    pub uv: Vec<Vec2>,
    /// What the painter needs to know about the place: along and across the part, metres, and a tag.
    pub aux: Vec<Vec3>,
    /// Three indices per triangle.
    pub idx: Vec<u32>,
}

impl Mesh {
    /// Adds a vertex and returns its index.
    pub fn push(&mut self, pos: Vec3, nrm: Vec3, uv: Vec2, aux: Vec3) -> u32 {
        self.pos.push(pos);
        self.nrm.push(nrm);
        self.uv.push(uv);
        self.aux.push(aux);
        self.pos.len() as u32 - 1
    }

    /// Adds a triangle unless it has no area.
    pub fn tri(&mut self, a: u32, b: u32, c: u32) {
        let [p, q, r] = [a, b, c].map(|i| self.pos[i as usize]);
        if (q - p).cross(r - p).length_squared() > 1e-18 {
            self.idx.extend([a, b, c]);
        }
    }

    /// Connects a `nu` × `nv` block of vertices (u fastest) that begins at `first` into triangles.
    pub fn connect(&mut self, first: u32, nu: u32, nv: u32) {
        for j in 0..nv - 1 {
            for i in 0..nu - 1 {
                let a = first + j * nu + i;
                let (b, c, d) = (a + 1, a + nu + 1, a + nu);
                // Split along the shorter diagonal: fewer slivers on twisted quads.
                let p = |k: u32| self.pos[k as usize];
                if p(a).distance_squared(p(c)) <= p(b).distance_squared(p(d)) {
                    self.tri(a, b, c);
                    self.tri(a, c, d);
                } else {
                    self.tri(a, b, d);
                    self.tri(b, c, d);
                }
            }
        }
    }

    /// Moves positions by `m` and normals by its inverse transpose; a mirroring `m` flips the triangles so that they
    /// still face outward.
    pub fn transform(mut self, m: Mat4) -> Self {
        let n = Mat3::from_mat4(m).inverse().transpose();
        self.pos.iter_mut().for_each(|p| *p = m.transform_point3(*p));
        self.nrm.iter_mut().for_each(|v| *v = (n * *v).normalize());
        if m.determinant() < 0.0 {
            self.idx.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Unit tangents (along u) and the handedness of the bitangent (against v: up in the picture) for every vertex, as glTF
    /// has them: bitangent = cross(normal, tangent) × w. Triangles count in proportion to their area.
    pub fn tangents(&self) -> Vec<Vec4> {
        let mut sum = vec![(Vec3::ZERO, 0.0f32); self.pos.len()];
        for t in self.idx.chunks_exact(3) {
            let i = [0, 1, 2].map(|k| t[k] as usize);
            let (e1, e2) = (self.uv[i[1]] - self.uv[i[0]], self.uv[i[2]] - self.uv[i[0]]);
            let (p1, p2) = (self.pos[i[1]] - self.pos[i[0]], self.pos[i[2]] - self.pos[i[0]]);
            let det = e1.perp_dot(e2);
            let along = (p1 * e2.y - p2 * e1.y) * det.signum();
            let area = p1.cross(p2).length();
            for k in i {
                sum[k].0 += along.normalize_or_zero() * area;
                // v grows downward: a chart that is upright seen from outside runs clockwise in texture coordinates.
                sum[k].1 -= det.signum() * area;
            }
        }
        sum.iter()
            .zip(&self.nrm)
            .map(|((t, w), n)| {
                let t = (*t - *n * n.dot(*t)).normalize_or(n.any_orthonormal_vector());
                t.extend(if *w < 0.0 { -1.0 } else { 1.0 })
            })
            .collect()
    }

    /// Adds all of `other`.
    pub fn append(&mut self, other: &Self) {
        let base = self.pos.len() as u32;
        self.pos.extend(&other.pos);
        self.nrm.extend(&other.nrm);
        self.uv.extend(&other.uv);
        self.aux.extend(&other.aux);
        self.idx.extend(other.idx.iter().map(|i| i + base));
    }

    /// Maps texture coordinates 0..1 into a rectangle of an atlas.
    pub fn place_uv(mut self, rect: Rect) -> Self {
        self.uv.iter_mut().for_each(|t| *t = rect.at(*t));
        self
    }
}

/// A rectangle in texture coordinates.
#[derive(Clone, Copy)]
pub struct Rect {
    /// Left top corner.
    pub min: Vec2,
    /// Right bottom corner.
    pub max: Vec2,
}

impl Rect {
    /// The rectangle at pixel `x`, `y`, `w` × `h` pixels large, of a picture `size` pixels large.
    pub fn px(x: f32, y: f32, w: f32, h: f32, size: [f32; 2]) -> Self {
        let s = Vec2::from(size);
        Self { min: Vec2::new(x, y) / s, max: Vec2::new(x + w, y + h) / s }
    }

    /// The place at relative coordinates `t`.
    pub fn at(&self, t: Vec2) -> Vec2 {
        self.min + (self.max - self.min) * t
    }
}

/// A point of an outline: where, which way is out, and how far along the outline.
#[derive(Clone, Copy, Debug)]
pub struct ProfilePoint {
    /// Position, metres.
    pub p: Vec2,
    /// Unit normal, to the right of the direction of travel.
    pub n: Vec2,
    /// Length of the outline up to here, metres.
    pub len: f32,
}

/// An outline through `corners` (position, fillet radius) whose corners are rounded by arcs of `steps` segments, so that
/// every edge that is swept or turned from it has a bevel to catch the light. Radii too large for their edges are reduced.
pub fn outline(corners: &[(f32, f32, f32)], steps: u32) -> Vec<ProfilePoint> {
    let at = |i: usize| Vec2::new(corners[i].0, corners[i].1);
    let right = |d: Vec2| Vec2::new(d.y, -d.x);
    let mut out: Vec<ProfilePoint> = Vec::new();
    let mut add = |p: Vec2, n: Vec2| {
        let len = out.last().map_or(0.0, |q| q.len + q.p.distance(p));
        out.push(ProfilePoint { p, n, len });
    };
    let last = corners.len() - 1;
    for i in 0..=last {
        let p = at(i);
        if i == 0 || i == last {
            let d = if i == 0 { at(1) - p } else { p - at(i - 1) };
            add(p, right(d.normalize()));
            continue;
        }
        let (d0, d1) = ((p - at(i - 1)).normalize(), (at(i + 1) - p).normalize());
        let (n0, n1) = (right(d0), right(d1));
        let turn = d0.perp_dot(d1).atan2(d0.dot(d1));
        let half_tan = (turn.abs() * 0.5).tan().max(1e-4);
        let room = p.distance(at(i - 1)).min(at(i + 1).distance(p)) * 0.499;
        let radius = corners[i].2.min(room / half_tan);
        let centre = p - d0 * radius * half_tan - n0 * radius * turn.signum();
        // The centre lies left of the travel for a left turn, right of it for a right turn.
        for k in 0..=steps {
            let t = k as f32 / steps as f32;
            let n = (n0 * (1.0 - t) + n1 * t).normalize_or(n0);
            add(centre + n * radius * turn.signum(), n);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square, counter-clockwise with the outside to the right of the travel: its corners become quarter circles.
    #[test]
    fn corners_become_arcs_that_touch_their_edges() {
        let r = 0.25;
        let o = outline(&[(1.0, 0.0, 0.0), (1.0, 1.0, r), (0.0, 1.0, r), (0.0, 0.0, 0.0)], 8);
        let centre = Vec2::new(1.0 - r, 1.0 - r);
        let arc: Vec<_> = o.iter().filter(|q| q.p.x >= centre.x && q.p.y >= centre.y).collect();
        assert_eq!(arc.len(), 9);
        for q in arc {
            assert!((q.p.distance(centre) - r).abs() < 1e-6);
            assert!((q.n - (q.p - centre) / r).length() < 1e-5, "the normal points away from the centre");
        }
        // A notch turns the other way: the normal points to the centre.
        let o = outline(&[(1.0, 0.0, 0.0), (0.0, 0.0, r), (0.0, 1.0, 0.0)], 4);
        let centre = Vec2::new(r, r);
        for q in &o[1..o.len() - 1] {
            assert!((q.n + (q.p - centre) / r).length() < 1e-5);
        }
    }

    #[test]
    fn an_upright_chart_has_handedness_one() {
        let mut m = Mesh::default();
        // Seen from +Z: u to the right (+X), v down (−Y).
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            m.push(Vec3::new(x, y, 0.0), Vec3::Z, Vec2::new(x, 1.0 - y), Vec3::ZERO);
        }
        m.tri(0, 1, 2);
        m.tri(0, 2, 3);
        for t in m.tangents() {
            assert_eq!(t, Vec4::new(1.0, 0.0, 0.0, 1.0));
        }
        let mirrored = m.transform(Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
        for t in mirrored.tangents() {
            assert_eq!(t, Vec4::new(-1.0, 0.0, 0.0, -1.0));
        }
    }
}
