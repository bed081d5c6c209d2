//! The element `vertex`.

use super::header::{Element, Type};
use super::values::Values;
use crate::error::Fault;
use crate::limits::Budget;
use crate::warning::Warnings;
use etendue_color::srgb_decode;
use etendue_scene::Mesh;
use glam::{Vec2, Vec3, Vec4};

/// Vertices as the file has them; each list is empty or as long as `positions`.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub colors: Vec<Vec4>,
}

impl Vertices {
    /// Bytes of one vertex.
    pub fn bytes_each(&self) -> u64 {
        let part = |empty: bool, bytes| if empty { 0 } else { bytes };
        12 + part(self.normals.is_empty(), 12)
            + part(self.uvs.is_empty(), 8)
            + part(self.colors.is_empty(), 16)
    }

    /// Each of them as a point.
    pub fn cloud(self) -> Mesh {
        Mesh {
            indices: (0..self.positions.len() as u32).map(|i| [i; 3]).collect(),
            positions: self.positions,
            normals: self.normals,
            uvs: if self.uvs.is_empty() { Vec::new() } else { vec![self.uvs] },
            colors: self.colors,
            ..Mesh::default()
        }
    }
}

/// What a number of a vertex is: one of x y z, nx ny nz, u v, r g b a.
fn slot(name: &str) -> Option<usize> {
    Some(match name {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" | "normal_x" => 3,
        "ny" | "normal_y" => 4,
        "nz" | "normal_z" => 5,
        "u" | "s" | "texture_u" | "texture_s" | "s0" | "u0" => 6,
        "v" | "t" | "texture_v" | "texture_t" | "t0" | "v0" => 7,
        "red" | "r" | "diffuse_red" => 8,
        "green" | "g" | "diffuse_green" => 9,
        "blue" | "b" | "diffuse_blue" => 10,
        "alpha" | "a" | "diffuse_alpha" => 11,
        _ => return None,
    })
}

/// Linear light of a colour's number: integers are sRGB as pictures are, floats are taken as linear.
pub(super) fn linear(v: f64, t: Type, alpha: bool) -> f32 {
    match t.largest() {
        Some(largest) if alpha => (v / largest) as f32,
        Some(largest) => srgb_decode((v / largest) as f32),
        None => v as f32,
    }
}

pub(super) fn read(
    e: &Element,
    values: &mut Values<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Vertices, Fault> {
    let mut found = [false; 12];
    let slots: Vec<Option<usize>> = e
        .properties
        .iter()
        .map(|p| {
            let k = slot(&p.name).filter(|&k| p.list.is_none() && !found[k])?;
            found[k] = true;
            Some(k)
        })
        .collect();
    if !found[..3].iter().all(|&f| f) {
        return Err(values.fault("the vertices have no x, y and z"));
    }
    let all = |r: std::ops::Range<usize>| found[r].iter().all(|&f| f);
    let (normals, uvs, colors) = (all(3..6), all(6..8), all(8..11));
    // As the file has them, and again as the mesh has them.
    let size = 12 + if normals { 12 } else { 0 } + if uvs { 8 } else { 0 } + if colors { 16 } else { 0 };
    budget.vertices(e.count, e.count.saturating_mul(2 * size), || "element vertex".into())?;
    let mut out = Vertices::default();
    let mut list = Vec::new();
    for _ in 0..e.count {
        let mut v = [0.0f32; 12];
        v[11] = 1.0;
        for (p, k) in e.properties.iter().zip(&slots) {
            values.property(p, &mut list)?;
            if let (Some(k), [value]) = (*k, &list[..]) {
                v[k] = if k >= 8 { linear(*value, p.kind, k == 11) } else { *value as f32 };
            }
        }
        out.positions.push(Vec3::from_slice(&v));
        if normals {
            out.normals.push(Vec3::from_slice(&v[3..]));
        }
        if uvs {
            // Counted from the bottom.
            out.uvs.push(Vec2::new(v[6], 1.0 - v[7]));
        }
        if colors {
            out.colors.push(Vec4::from_slice(&v[8..]));
        }
    }
    if e.properties.iter().any(|p| matches!(&p.name[..], "f_dc_0" | "scale_0" | "rot_0")) {
        warnings.add("element vertex", "these are Gaussian splats, which are not supported");
    }
    Ok(out)
}
