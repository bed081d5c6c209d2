//! Nothing but finite numbers and unit vectors leaves this place.

use crate::topology::compact;
use crate::warning::Warnings;
use etendue_scene::Mesh;
use glam::{Vec2, Vec3, Vec4};

/// Drops triangles with positions that are not finite, mends other attributes, and makes directions unit vectors.
pub(crate) fn mesh(m: &mut Mesh, pointer: &str, warnings: &mut Warnings) {
    drop_bad_triangles(m, pointer, warnings);
    normals(m, pointer, warnings);
    tangents(m, pointer, warnings);
    let mut odd_uvs = 0;
    for uv in m.uvs.iter_mut().flatten().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        odd_uvs += 1;
    }
    if odd_uvs > 0 {
        warnings.add(pointer, format!("{odd_uvs} texture coordinates that are not finite; set to 0"));
    }
    let (mut odd_colors, mut out_of_range) = (0, 0);
    for c in &mut m.colors {
        if !c.is_finite() {
            *c = Vec4::ONE;
            odd_colors += 1;
        } else if c.min_element() < 0.0 || c.max_element() > 1.0 {
            *c = c.clamp(Vec4::ZERO, Vec4::ONE);
            out_of_range += 1;
        }
    }
    if odd_colors > 0 {
        warnings.add(pointer, format!("{odd_colors} vertex colours that are not finite; set to white"));
    }
    if out_of_range > 0 {
        warnings.add(pointer, format!("{out_of_range} vertex colours outside 0..1; clamped"));
    }
}

fn drop_bad_triangles(m: &mut Mesh, pointer: &str, warnings: &mut Warnings) {
    if m.positions.iter().all(|p| p.is_finite()) {
        return;
    }
    let before = m.indices.len();
    let positions = &m.positions;
    m.indices.retain(|t| t.iter().all(|&i| positions[i as usize].is_finite()));
    let dropped = before - m.indices.len();
    warnings.add(pointer, format!("{dropped} triangles with positions that are not finite; left out"));
    if let Some(used) = compact(&mut m.indices, m.positions.len()) {
        keep_vertices(m, &used);
    }
}

/// Leaves the vertices `used`, in that order; the indices are the caller's.
pub(crate) fn keep_vertices(m: &mut Mesh, used: &[u32]) {
    pick(&mut m.positions, used);
    pick(&mut m.normals, used);
    pick(&mut m.tangents, used);
    pick(&mut m.colors, used);
    m.uvs.iter_mut().for_each(|uv| pick(uv, used));
}

fn pick<T: Copy>(list: &mut Vec<T>, which: &[u32]) {
    if !list.is_empty() {
        *list = which.iter().map(|&i| list[i as usize]).collect();
    }
}

/// Unit vector along `v`, also where its length over- or underflows.
fn unit(v: Vec3) -> Option<Vec3> {
    let largest = v.abs().max_element();
    (largest > 0.0 && v.is_finite()).then(|| (v / largest).normalize()).filter(|u| u.is_finite())
}

/// Unnormalised normal of a triangle, from positions scaled down so that it cannot overflow.
pub(crate) fn face_normal(m: &Mesh, t: [u32; 3]) -> Vec3 {
    let [a, b, c] = t.map(|i| m.positions[i as usize]);
    let (u, v) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    u.cross(v).normalize_or_zero().as_vec3()
}

/// Normals of unit length; where one has no direction, the mean of the faces around it serves.
fn normals(m: &mut Mesh, pointer: &str, warnings: &mut Warnings) {
    let mut bad = Vec::new();
    for (i, n) in m.normals.iter_mut().enumerate() {
        match unit(*n) {
            Some(u) => *n = u,
            None => bad.push(i as u32),
        }
    }
    if bad.is_empty() {
        return;
    }
    warnings.add(pointer, format!("{} normals without a direction; replaced by their faces'", bad.len()));
    let mut sums = vec![Vec3::ZERO; bad.len()];
    for t in &m.indices {
        for i in t {
            if let Ok(k) = bad.binary_search(i) {
                sums[k] += face_normal(m, *t);
            }
        }
    }
    for (&i, s) in bad.iter().zip(sums) {
        m.normals[i as usize] = unit(s).unwrap_or(Vec3::Z);
    }
}

/// Tangents of unit length with a sign of ±1.
fn tangents(m: &mut Mesh, pointer: &str, warnings: &mut Warnings) {
    let mut bad = 0;
    for (t, n) in m.tangents.iter_mut().zip(&m.normals) {
        let u = unit(t.truncate()).unwrap_or_else(|| {
            bad += 1;
            n.any_orthonormal_vector()
        });
        *t = u.extend(if t.w < 0.0 { -1.0 } else { 1.0 });
    }
    if bad > 0 {
        warnings.add(pointer, format!("{bad} tangents without a direction; replaced"));
    }
}
