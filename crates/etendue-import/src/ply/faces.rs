//! The elements `face` and `tristrips`.

use super::header::Element;
use super::values::Values;
use super::vertices::{Vertices, linear};
use crate::error::Fault;
use crate::limits::Budget;
use crate::polygon::Cutter;
use crate::warning::Warnings;
use etendue_scene::Mesh;
use glam::{DVec3, Vec2, Vec4};
use std::collections::HashMap;

/// Faces, before they are triangles.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// Corners of each.
    lengths: Vec<u32>,
    /// Vertices of all corners.
    corners: Vec<u32>,
    /// Texture coordinates of all corners, or none.
    uvs: Vec<Vec2>,
    /// Colours per face, or none.
    colors: Vec<Vec4>,
    /// Triangles of strips.
    strips: Vec<[u32; 3]>,
}

impl Faces {
    /// True if there are no faces and no strips.
    pub fn is_empty(&self) -> bool {
        self.lengths.is_empty() && self.strips.is_empty()
    }

    pub fn has_uvs(&self) -> bool {
        !self.uvs.is_empty()
    }

    pub fn read(
        &mut self,
        e: &Element,
        values: &mut Values<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        let find = |names: &[&str], list: bool| {
            e.properties.iter().position(|p| names.contains(&&p.name[..]) && p.list.is_some() == list)
        };
        let Some(vertices) = find(&["vertex_indices", "vertex_index"], true) else {
            if e.count > 0 {
                let why = "the faces have no list `vertex_indices`; left out";
                warnings.add("element face", why);
            }
            return values.skip(e);
        };
        let wedges = find(&["texcoord", "texcoords"], true);
        let rgb = ["red", "green", "blue"].map(|n| find(&[n], false));
        let alpha = find(&["alpha"], false);
        if find(&["texnumber"], false).is_some() {
            warnings.add(
                "element face",
                "several pictures (`texnumber`) are not supported; all faces get the first one",
            );
        }
        let colored = rgb.iter().all(Option::is_some);
        let (mut list, mut uv) = (Vec::new(), Vec::new());
        for _ in 0..e.count {
            let before = self.corners.len();
            uv.clear();
            let mut color = Vec4::ONE;
            for (i, p) in e.properties.iter().enumerate() {
                values.property(p, &mut list)?;
                if i == vertices {
                    for &v in &list {
                        if !(v >= 0.0 && v.fract() == 0.0 && v < f64::from(u32::MAX)) {
                            return Err(values.fault(format!("face {} uses vertex {v}", self.lengths.len())));
                        }
                        self.corners.push(v as u32);
                    }
                } else if Some(i) == wedges {
                    std::mem::swap(&mut uv, &mut list);
                } else if let (Some(k), [v]) =
                    (rgb.iter().chain([&alpha]).position(|s| *s == Some(i)), &list[..])
                {
                    color[k] = linear(*v, p.kind, k == 3);
                }
            }
            let n = self.corners.len() - before;
            // A polygon of n corners in lists, as triangles, and with vertices of its own.
            budget.bytes(16 + 60 * n as u64, || "element face".into())?;
            if n < 3 {
                warnings.add("element face", "faces with less than three corners; left out");
                self.corners.truncate(before);
                continue;
            }
            self.lengths.push(n as u32);
            if wedges.is_some() {
                self.uvs.extend((0..n).map(|k| match uv.get(2 * k..2 * k + 2) {
                    Some(&[u, v]) => Vec2::new(u as f32, 1.0 - v as f32),
                    _ => Vec2::ZERO,
                }));
            }
            if colored {
                self.colors.push(color);
            }
        }
        Ok(())
    }

    /// Triangle strips: lists of vertices, −1 starts a new one.
    pub fn read_strips(
        &mut self,
        e: &Element,
        values: &mut Values<'_>,
        budget: &mut Budget,
    ) -> Result<(), Fault> {
        let mut list = Vec::new();
        for _ in 0..e.count {
            for p in &e.properties {
                values.property(p, &mut list)?;
                if p.list.is_none() {
                    continue;
                }
                budget.bytes(12 * list.len() as u64, || "element tristrips".into())?;
                for strip in list.split(|v| *v < 0.0) {
                    for (k, w) in strip.windows(3).enumerate() {
                        if w.iter().any(|v| !(v.fract() == 0.0 && *v < f64::from(u32::MAX))) {
                            return Err(values.fault(format!("a strip uses vertices {w:?}")));
                        }
                        // Every other triangle is turned over.
                        let t = [w[0], w[1 + k % 2], w[2 - k % 2]].map(|v| v as u32);
                        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                            self.strips.push(t);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The triangles over `points`.
    pub fn mesh(
        mut self,
        points: Vertices,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Mesh, Fault> {
        let n = points.positions.len();
        let all = self.corners.iter().chain(self.strips.as_flattened());
        if let Some(bad) = all.copied().find(|&v| v as usize >= n) {
            return Err(Fault::invalid(
                "element face",
                format!("a face uses vertex {bad}, but there are {n}"),
            ));
        }
        let mut cutter = Cutter::default();
        // Triangles, as numbers of corners, while corners still have something of their own.
        let (mut triangles, mut outline, mut cut) = (Vec::new(), Vec::<DVec3>::new(), Vec::new());
        let mut first = 0u32;
        for &len in &self.lengths {
            let corners = &self.corners[first as usize..(first + len) as usize];
            outline.clear();
            outline.extend(corners.iter().map(|&v| points.positions[v as usize].as_dvec3()));
            cut.clear();
            cutter.cut(&outline, &mut cut);
            triangles.extend(cut.iter().map(|t| t.map(|i| i + first)));
            first += len;
        }
        if cutter.gave_up {
            warnings.add(
                "element face",
                "polygons with very many concave corners; the largest of them are cut into fans",
            );
        }
        if !self.strips.is_empty() && (self.has_uvs() || !self.colors.is_empty()) {
            warnings.add(
                "element tristrips",
                "strips beside faces with texture coordinates or colours of their own; left out",
            );
            self.strips.clear();
        }
        let own_uvs = self.uvs.len() == self.corners.len() && !self.uvs.is_empty();
        let own_colors =
            self.colors.len() == self.lengths.len() && !self.colors.is_empty() && points.colors.is_empty();
        if !own_uvs && !own_colors {
            let mut indices: Vec<[u32; 3]> =
                triangles.iter().map(|t: &[u32; 3]| t.map(|c| self.corners[c as usize])).collect();
            indices.append(&mut self.strips);
            return Ok(with_used(points, indices));
        }
        // Corners that differ get vertices of their own.
        budget.bytes(self.corners.len() as u64 * 64, || "element face".into())?;
        let face_of: Vec<u32> = self
            .lengths
            .iter()
            .enumerate()
            .flat_map(|(f, &n)| std::iter::repeat_n(f as u32, n as usize))
            .collect();
        let mut out = Mesh::default();
        let mut uvs = Vec::new();
        let mut known: HashMap<(u32, [u32; 2], [u32; 4]), u32> = HashMap::new();
        for t in triangles {
            let numbers = t.map(|c| {
                let (c, v) = (c as usize, self.corners[c as usize]);
                let uv = if own_uvs { self.uvs[c] } else { Vec2::ZERO };
                let color = if own_colors { self.colors[face_of[c] as usize] } else { Vec4::ZERO };
                let key = (v, uv.to_array().map(f32::to_bits), color.to_array().map(f32::to_bits));
                let next = out.positions.len() as u32;
                let number = *known.entry(key).or_insert(next);
                if number == next {
                    let v = v as usize;
                    out.positions.push(points.positions[v]);
                    out.normals.extend(points.normals.get(v));
                    if own_uvs {
                        uvs.push(uv);
                    } else {
                        uvs.extend(points.uvs.get(v));
                    }
                    if own_colors {
                        out.colors.push(color);
                    } else {
                        out.colors.extend(points.colors.get(v));
                    }
                }
                number
            });
            out.indices.push(numbers);
        }
        if !uvs.is_empty() {
            out.uvs.push(uvs);
        }
        Ok(out)
    }
}

/// The mesh of the vertices that triangles use.
fn with_used(points: Vertices, mut indices: Vec<[u32; 3]>) -> Mesh {
    let mut out = Mesh {
        positions: points.positions,
        normals: points.normals,
        colors: points.colors,
        ..Mesh::default()
    };
    if !points.uvs.is_empty() {
        out.uvs.push(points.uvs);
    }
    if let Some(used) = crate::topology::compact(&mut indices, out.positions.len()) {
        crate::clean::keep_vertices(&mut out, &used);
    }
    out.indices = indices;
    out
}
