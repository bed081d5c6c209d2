//! Faces into meshes.

use super::parse::{Corner, Group, NONE, Obj};
use crate::assemble::Assembly;
use crate::error::Fault;
use crate::limits::Budget;
use crate::polygon::{Cutter, newell};
use crate::strokes;
use crate::warning::Warnings;
use etendue_color::srgb_decode;
use etendue_scene::{Instance, Mesh};
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Builds a mesh per group; `materials` are the scene's numbers of [`Obj::materials`].
pub(super) fn build_all(
    obj: &Obj,
    materials: &[Option<u32>],
    budget: &mut Budget,
    out: &mut Assembly,
    warnings: &mut Warnings,
) -> Result<(), Fault> {
    for g in &obj.groups {
        let corners = g.corners.len() as u64;
        // A vertex of its own for each corner at worst, with tangents and the tables that make them.
        budget.instances(1, (size_of::<Instance>() + size_of::<Mesh>() + 2 * g.name.len()) as u64, || {
            g.name.clone()
        })?;
        budget.vertices(corners, 400 * corners, || g.name.clone())?;
        let balls = g.strokes.iter().filter(|[a, b]| a == b).count() as u64;
        let colors = if obj.colors.is_empty() { 0 } else { 16 };
        let (vertices, bytes) = strokes::estimate(balls, g.strokes.len() as u64 - balls, 12 + colors);
        // Beside these the mesh that they are made of.
        let before = g.strokes.len() as u64 * (12 + 2 * (12 + colors));
        budget.vertices(vertices, bytes.saturating_add(before), || g.name.clone())?;
    }
    let smooth = smooth_normals(obj);
    let mut cutter = Cutter::default();
    for g in &obj.groups {
        let material = g.material.and_then(|m| materials[m as usize]);
        if !g.faces.is_empty() {
            out.add(mesh(obj, g, &smooth, &mut cutter), material);
        }
        if !g.strokes.is_empty() {
            out.add_strokes(strokes(obj, g), material);
        }
    }
    if cutter.gave_up {
        warnings.add("", "polygons with very many concave corners; the largest of them are cut into fans");
    }
    Ok(())
}

/// Positions of a face's corners.
fn outline(obj: &Obj, corners: &[Corner], out: &mut Vec<DVec3>) {
    out.clear();
    out.extend(corners.iter().map(|c| obj.positions[c.position as usize].as_dvec3()));
}

/// The normals of smoothing groups: per position and group, the faces' normals weighted by sin α / (|a| |b|), where a and b are
/// the edges that meet at the corner and α is their angle (Max 1999, "Weights for computing vertex normals from facet normals"):
/// exact on spheres, and no trigonometry.
fn smooth_normals(obj: &Obj) -> HashMap<(u32, u32), DVec3> {
    let mut sums: HashMap<(u32, u32), DVec3> = HashMap::new();
    let mut points = Vec::new();
    for g in &obj.groups {
        let mut first = 0;
        for f in &g.faces {
            let corners = &g.corners[first..first + f.corners as usize];
            first += f.corners as usize;
            if f.smoothing == 0 || corners.iter().all(|c| c.normal != NONE) {
                continue;
            }
            outline(obj, corners, &mut points);
            let normal = newell(&points).normalize_or_zero();
            let n = points.len();
            for (i, c) in corners.iter().enumerate() {
                let a = points[(i + 1) % n] - points[i];
                let b = points[(i + n - 1) % n] - points[i];
                let weight = a.cross(b).length() / (a.length_squared() * b.length_squared());
                if weight.is_finite() {
                    *sums.entry((c.position, f.smoothing)).or_default() += normal * weight;
                }
            }
        }
    }
    sums
}

/// What tells the vertices of a mesh apart.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Normal {
    /// A normal of the file.
    Own(u32),
    /// That of a smoothing group.
    Smooth(u32),
    /// That of a face, by its number in the group.
    Face(u32),
    /// None: the mesh has no normals.
    Absent,
}

fn mesh(obj: &Obj, g: &Group, smooth: &HashMap<(u32, u32), DVec3>, cutter: &mut Cutter) -> Mesh {
    let has_uvs = g.corners.iter().any(|c| c.uv != NONE);
    let has_normals = g.corners.iter().any(|c| c.normal != NONE) || g.faces.iter().any(|f| f.smoothing != 0);
    let mut out = Mesh { name: g.name.clone(), ..Mesh::default() };
    let mut uvs = Vec::new();
    let mut known: HashMap<(u32, u32, Normal), u32> = HashMap::new();
    let (mut points, mut triangles, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    let mut first = 0;
    for (k, f) in g.faces.iter().enumerate() {
        let corners = &g.corners[first..first + f.corners as usize];
        first += f.corners as usize;
        outline(obj, corners, &mut points);
        let face_normal = newell(&points).normalize_or_zero().as_vec3();
        numbers.clear();
        for c in corners {
            let normal = match (has_normals, c.normal, f.smoothing) {
                (false, ..) => Normal::Absent,
                (true, NONE, 0) => Normal::Face(k as u32),
                (true, NONE, s) => Normal::Smooth(s),
                (true, n, _) => Normal::Own(n),
            };
            let next = out.positions.len() as u32;
            let number = *known.entry((c.position, c.uv, normal)).or_insert(next);
            numbers.push(number);
            if number != next {
                continue;
            }
            out.positions.push(obj.positions[c.position as usize]);
            out.colors.extend(obj.colors.get(c.position as usize).map(|c| linear(*c)));
            if has_uvs {
                let uv = obj.uvs.get(c.uv as usize).copied().unwrap_or(Vec2::Y);
                // OBJ counts from the bottom.
                uvs.push(Vec2::new(uv.x, 1.0 - uv.y));
            }
            match normal {
                Normal::Absent => {}
                Normal::Own(n) => out.normals.push(obj.normals[n as usize]),
                Normal::Face(_) => out.normals.push(or_up(face_normal)),
                Normal::Smooth(s) => {
                    let sum = smooth.get(&(c.position, s)).copied().unwrap_or_default();
                    out.normals.push(or_up(sum.normalize_or_zero().as_vec3()));
                }
            }
        }
        triangles.clear();
        cutter.cut(&points, &mut triangles);
        out.indices.extend(triangles.iter().map(|t| t.map(|i| numbers[i as usize])));
    }
    if has_uvs {
        out.uvs.push(uvs);
    }
    out
}

/// The lines and points of a group, each once.
fn strokes(obj: &Obj, g: &Group) -> Mesh {
    let mut all = g.strokes.clone();
    all.sort_unstable();
    all.dedup();
    let mut out = Mesh { name: g.name.clone(), ..Mesh::default() };
    for ends in all {
        let first = out.positions.len() as u32;
        let count = if ends[0] == ends[1] { 1 } else { 2 };
        for &v in &ends[..count] {
            out.positions.push(obj.positions[v as usize]);
            out.colors.extend(obj.colors.get(v as usize).map(|c| linear(*c)));
        }
        let last = first + count as u32 - 1;
        out.indices.push([first, last, last]);
    }
    out
}

/// A vertex's colour, linear.
fn linear(color: Vec3) -> Vec4 {
    let [r, g, b] = color.to_array().map(srgb_decode);
    Vec4::new(r, g, b, 1.0)
}

/// A direction for faces without area, which are never hit.
fn or_up(n: Vec3) -> Vec3 {
    if n == Vec3::ZERO { Vec3::Y } else { n }
}
