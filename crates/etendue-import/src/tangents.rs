//! Tangents by MikkTSpace, where a normal map or anisotropy needs them and the file has none (glTF 2.0, 3.7.2.1).

use crate::clean::face_normal;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use etendue_scene::Mesh;
use glam::{Affine2, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// More triangles around one point than any real model has. MikkTSpace's work grows with the square of this number, and
/// its recursion with the number itself; triangles beyond it get the tangent of their own texture coordinates.
const MAX_VALENCE: u32 = 1024;

/// Gives `mesh` tangents along UV set `set` as transformed by `transform`. Vertices whose corners get different
/// tangents are split. A mesh without normals gets the triangles' own first, a vertex of its own per corner.
pub(crate) fn generate(mesh: &mut Mesh, set: usize, transform: &Affine2) {
    if mesh.normals.is_empty() {
        flatten(mesh);
    }
    let tangents = of_corners(mesh, set, transform);
    split(mesh, &tangents);
}

/// The tangents of all corners of a mesh with normals along UV set `set` as transformed by `transform`.
pub(crate) fn of_corners(mesh: &Mesh, set: usize, transform: &Affine2) -> Vec<Vec4> {
    let faces = tame(mesh);
    let mut corners = Corners { mesh, set, transform, faces, tangents: vec![None; 3 * mesh.indices.len()] };
    // The error type has no values.
    let _: Result<(), _> = generate_tangents(&mut corners);
    corners.fill_up()
}

/// The triangles that MikkTSpace handles well: with three distinct points (its search for neighbours of the others takes
/// quadratic time), none of them with too many triangles around it.
fn tame(m: &Mesh) -> Vec<u32> {
    let mut point_of = Vec::with_capacity(m.positions.len());
    let mut points: HashMap<[u32; 3], u32> = HashMap::with_capacity(m.positions.len());
    for p in &m.positions {
        let next = points.len() as u32;
        // Adding 0 makes −0 the same point as 0.
        point_of.push(*points.entry((*p + 0.0).to_array().map(f32::to_bits)).or_insert(next));
    }
    let mut valence = vec![0u32; points.len()];
    let distinct = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| point_of[i as usize]);
        (a != b && b != c && c != a).then_some([a, b, c])
    };
    for p in m.indices.iter().filter_map(distinct).flatten() {
        valence[p as usize] += 1;
    }
    (0..m.indices.len() as u32)
        .filter(|&t| {
            distinct(&m.indices[t as usize])
                .is_some_and(|p| p.iter().all(|&p| valence[p as usize] <= MAX_VALENCE))
        })
        .collect()
}

/// One vertex per corner, with the normal of its triangle.
fn flatten(m: &mut Mesh) {
    let corners: Vec<u32> = m.indices.as_flattened().to_vec();
    m.normals = m.indices.iter().flat_map(|&t| [face_normal(m, t); 3]).collect();
    for n in m.normals.iter_mut().filter(|n| **n == Vec3::ZERO) {
        // A triangle without area is never hit.
        *n = Vec3::Z;
    }
    m.positions = corners.iter().map(|&i| m.positions[i as usize]).collect();
    for uv in &mut m.uvs {
        *uv = corners.iter().map(|&i| uv[i as usize]).collect();
    }
    if !m.colors.is_empty() {
        m.colors = corners.iter().map(|&i| m.colors[i as usize]).collect();
    }
    m.indices = (0..m.indices.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
}

/// Gives vertices their corners' tangents; corners that disagree get a copy of the vertex.
pub(crate) struct Splitter {
    /// Of the vertices and of the copies after them. A vertex without a tangent yet holds NaN, which equals nothing.
    pub tangents: Vec<Vec4>,
    /// The vertices that the copies are of.
    pub copied: Vec<u32>,
    copies: HashMap<(u32, [u32; 4]), u32>,
}

impl Splitter {
    /// For so many vertices.
    pub fn new(vertices: usize) -> Self {
        Self { tangents: vec![Vec4::NAN; vertices], copied: Vec::new(), copies: HashMap::new() }
    }

    /// The vertex, `vertex` or a copy of it, that a corner with `tangent` has.
    pub fn corner(&mut self, vertex: u32, tangent: Vec4) -> u32 {
        let known = &mut self.tangents[vertex as usize];
        if known.is_nan() {
            *known = tangent;
            return vertex;
        }
        if *known == tangent {
            return vertex;
        }
        *self.copies.entry((vertex, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
            self.tangents.push(tangent);
            self.copied.push(vertex);
            (self.tangents.len() - 1) as u32
        })
    }
}

/// Gives each vertex its corners' tangent.
fn split(m: &mut Mesh, tangents: &[Vec4]) {
    let mut splitter = Splitter::new(m.positions.len());
    for (i, &tangent) in m.indices.as_flattened_mut().iter_mut().zip(tangents) {
        *i = splitter.corner(*i, tangent);
    }
    for &v in &splitter.copied {
        let v = v as usize;
        m.positions.push(m.positions[v]);
        m.normals.push(m.normals[v]);
        m.uvs.iter_mut().for_each(|uv| uv.push(uv[v]));
        if !m.colors.is_empty() {
            m.colors.push(m.colors[v]);
        }
    }
    m.tangents = splitter.tangents;
    // Vertices that no triangle uses.
    for (t, n) in m.tangents.iter_mut().zip(&m.normals).filter(|(t, _)| t.is_nan()) {
        *t = n.any_orthonormal_vector().extend(1.0);
    }
}

/// A mesh as MikkTSpace sees it.
struct Corners<'a> {
    mesh: &'a Mesh,
    set: usize,
    transform: &'a Affine2,
    /// The triangles to handle.
    faces: Vec<u32>,
    /// For every corner of the mesh.
    tangents: Vec<Option<Vec4>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, vert: usize) -> usize {
        self.mesh.indices[self.faces[face] as usize][vert] as usize
    }

    fn uv(&self, vertex: u32) -> Vec2 {
        let uv = self.transform.transform_point2(self.mesh.uvs[self.set][vertex as usize]);
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }

    /// The tangents of all corners: those without one get that of their triangle's own texture coordinates.
    fn fill_up(self) -> Vec<Vec4> {
        let own = |corner: usize| {
            let t = self.mesh.indices[corner / 3];
            let n = self.mesh.normals[t[corner % 3] as usize];
            let [p0, p1, p2] = t.map(|i| self.mesh.positions[i as usize].as_dvec3());
            let [t0, t1, t2] = t.map(|i| self.uv(i).as_dvec2());
            let (d1, d2) = (t1 - t0, t2 - t0);
            let area = d1.perp_dot(d2);
            let along_u = ((p1 - p0) * d2.y - (p2 - p0) * d1.y) * area.signum();
            let along_u = along_u.as_vec3();
            let tangent = (along_u - n * n.dot(along_u)).try_normalize();
            let sign = if area > 0.0 { -1.0 } else { 1.0 };
            tangent.unwrap_or_else(|| n.any_orthonormal_vector()).extend(sign)
        };
        self.tangents.iter().enumerate().map(|(c, t)| t.unwrap_or_else(|| own(c))).collect()
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, vert)].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, vert)].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.uv(self.vertex(face, vert) as u32).to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, vert: usize) {
        let Some(t) = tangent else { return };
        let [x, y, z, sign] = t.tangent_encoded();
        let Some(t) = Vec3::new(x, y, z).try_normalize() else { return };
        // MikkTSpace's bitangent runs along +v. In glTF v points down the picture and a normal map's green axis up it,
        // so the bitangent runs along −v.
        self.tangents[3 * self.faces[face] as usize + vert] = Some(t.extend(-sign));
    }
}
