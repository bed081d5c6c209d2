//! STL, in its binary and its text form.
//!
//! Corners in exactly the same place become one vertex. Facets are flat, with the normal of their winding; the normal that
//! the file stores beside it is not used, as many programs leave it zero. STL knows neither units (mostly it means
//! millimetres) nor which way is up (mostly +Z): one unit is taken as a metre, +Y as up, and the surface is seen from both
//! sides.

use crate::assemble::{Assembly, Facts};
use crate::error::Fault;
use crate::import::{ImportOptions, Imported};
use crate::limits::Budget;
use crate::text::{Lines, number, shown, split_word, words};
use crate::warning::Warnings;
use etendue_scene::Mesh;
use glam::Vec3;
use std::collections::HashMap;

/// Bytes before the first triangle: 80 of comment and the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three corners, two bytes of attributes.
const TRIANGLE: usize = 50;

/// The number of triangles that a binary file announces.
fn announced(bytes: &[u8]) -> Option<u64> {
    let b = bytes.get(80..HEADER)?;
    Some(u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])))
}

/// True if the size of the file is what the binary form demands, whatever its first word is.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|n| n > 0 && HEADER as u64 + n * TRIANGLE as u64 == bytes.len() as u64)
}

pub(crate) fn read(bytes: &[u8], name: &str, options: &ImportOptions) -> Result<Imported, Fault> {
    let mut warnings = Warnings::default();
    let mut budget = Budget::new(&options.limits, bytes.len() as u64);
    let mut out = Assembly::default();
    // Some programs begin the comment of the binary form with the same word; no text has zero bytes.
    let start = &bytes[..bytes.len().min(1 << 10)];
    let text = !is_binary(bytes) && split_word(start).0 == b"solid" && !start.contains(&0);
    let comment = if text {
        read_text(bytes, &mut budget, &mut out)?;
        None
    } else {
        read_binary(bytes, &mut budget, &mut out, &mut warnings)?
    };
    let format = if text { "STL (text)" } else { "STL (binary)" };
    let facts = Facts { file: name, format, bytes: bytes.len() as u64, external: 0, comment };
    out.finish(facts, options.image_files, warnings)
}

/// A mesh under construction, whose corners are joined.
#[derive(Default)]
struct Solid {
    mesh: Mesh,
    known: HashMap<[u32; 3], u32>,
}

/// Memory of a triangle at worst: three vertices in mesh and table, and its indices.
const PER_TRIANGLE: u64 = 3 * (12 + 32) + 12;

impl Solid {
    fn triangle(&mut self, corners: [Vec3; 3]) {
        let indices = corners.map(|p| {
            let next = self.mesh.positions.len() as u32;
            // Adding 0 makes −0 the same place as 0.
            let n = *self.known.entry((p + 0.0).to_array().map(f32::to_bits)).or_insert(next);
            if n == next {
                self.mesh.positions.push(p);
            }
            n
        });
        self.mesh.indices.push(indices);
    }
}

fn read_binary(
    bytes: &[u8],
    budget: &mut Budget,
    out: &mut Assembly,
    warnings: &mut Warnings,
) -> Result<Option<String>, Fault> {
    let Some(n) = announced(bytes) else {
        let message = format!(
            "the file ends within the header of {HEADER} bytes of a binary STL, and a text one starts with `solid`"
        );
        return Err(Fault::byte(bytes.len() as u64, message));
    };
    let body = &bytes[HEADER..];
    let room = (body.len() / TRIANGLE) as u64;
    if n > room {
        let message = format!("{n} triangles announced, {room} present: the file is cut off, or no STL");
        return Err(Fault::byte(80, message));
    }
    let rest = body.len() as u64 - n * TRIANGLE as u64;
    if rest > 0 {
        warnings.add(
            format!("byte {}", bytes.len() as u64 - rest),
            format!("{rest} bytes after the last triangle; ignored"),
        );
    }
    budget.vertices(3 * n, n * PER_TRIANGLE, || "header".into())?;
    let mut solid = Solid::default();
    let mut attributes = 0u64;
    for t in body.chunks_exact(TRIANGLE).take(n as usize) {
        let float = |k: usize| f32::from_le_bytes([t[4 * k], t[4 * k + 1], t[4 * k + 2], t[4 * k + 3]]);
        solid.triangle([3, 6, 9].map(|k| Vec3::new(float(k), float(k + 1), float(k + 2))));
        attributes += u64::from(t[48] != 0 || t[49] != 0);
    }
    if attributes > 0 {
        let message = format!(
            "{attributes} triangles have attribute bytes, which some programs use for colours, each in its own way; ignored"
        );
        warnings.add(format!("byte {}", HEADER + 48), message);
    }
    out.add(solid.mesh, None);
    let comment = bytes[..80].split(|&b| b == 0).next().unwrap_or_default().trim_ascii();
    Ok((!comment.is_empty()).then(|| shown(comment)))
}

fn read_text(bytes: &[u8], budget: &mut Budget, out: &mut Assembly) -> Result<(), Fault> {
    let mut solid: Option<Solid> = None;
    let mut corners: Vec<Vec3> = Vec::new();
    let mut in_facet = false;
    let mut last = 0;
    for (line, text) in Lines::new(bytes) {
        last = line;
        let (key, rest) = split_word(&text);
        let key = key.to_ascii_lowercase();
        match &key[..] {
            b"" => {}
            b"solid" => {
                // Some programs leave out `endsolid`.
                end(&mut solid, out);
                let name = shown(rest);
                budget.instances(1, 512 + name.len() as u64, || format!("line {line}"))?;
                solid = Some(Solid { mesh: Mesh { name, ..Mesh::default() }, ..Solid::default() });
            }
            b"facet" => (in_facet, corners) = (true, Vec::new()),
            b"outer" | b"endloop" => {}
            b"vertex" if in_facet => {
                let mut v = [0.0f32; 3];
                let mut n = 0;
                for word in words(rest).take(3) {
                    v[n] = number(word)
                        .ok_or_else(|| Fault::line(line, format!("`{}` is not a number", shown(word))))?;
                    n += 1;
                }
                if n < 3 || corners.len() == 3 {
                    let what =
                        if n < 3 { "a vertex needs 3 numbers" } else { "a facet has 3 vertices, not more" };
                    return Err(Fault::line(line, what));
                }
                corners.push(Vec3::from_array(v));
            }
            b"endfacet" if in_facet => {
                in_facet = false;
                let (Some(solid), &[a, b, c]) = (&mut solid, &corners[..]) else {
                    return Err(Fault::line(line, format!("a facet has 3 vertices, not {}", corners.len())));
                };
                budget.vertices(3, PER_TRIANGLE, || format!("line {line}"))?;
                solid.triangle([a, b, c]);
            }
            b"endsolid" => end(&mut solid, out),
            other => {
                let message = format!(
                    "`{}` is not expected here; a facet is `facet normal`, `outer loop`, three times `vertex`, `endloop`, `endfacet`",
                    shown(other)
                );
                return Err(Fault::line(line, message));
            }
        }
    }
    if in_facet {
        return Err(Fault::line(last, "the file ends within a facet"));
    }
    end(&mut solid, out);
    Ok(())
}

fn end(solid: &mut Option<Solid>, out: &mut Assembly) {
    if let Some(s) = solid.take() {
        out.add(s.mesh, None);
    }
}
