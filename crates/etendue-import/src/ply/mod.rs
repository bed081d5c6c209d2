//! PLY (the Stanford triangle format): text, and binary in both byte orders.
//!
//! Of the element `vertex`: `x y z`, normals `nx ny nz`, texture coordinates under any of their usual names, colours `red green
//! blue alpha` (integers are sRGB, floats are linear). Of the element `face`: a list `vertex_indices` or `vertex_index` of any
//! number of corners, and `texcoord`, a list of coordinates per corner (MeshLab), with the picture from a comment
//! `TextureFile NAME`. Triangle strips (`tristrips`). Other elements and properties are passed over, with a warning where
//! they would be seen.
//!
//! Vertices without any faces are a cloud of points, shown as balls.
//!
//! Without normals faces are flat: the format has no other word on it. It knows neither units nor which way is up: one
//! unit is taken as a metre, +Y as up; surfaces are seen from both sides.

mod faces;
mod header;
mod values;
mod vertices;

use crate::assemble::{Assembly, Facts, plain};
use crate::error::Fault;
use crate::import::{ImportOptions, Imported};
use crate::limits::Budget;
use crate::obj::library;
use crate::source::Source;
use crate::strokes;
use crate::texture::Decoded;
use crate::warning::Warnings;
use etendue_scene::{Sampler, TextureRef};
use glam::Vec3;
use header::{Encoding, Header};
use std::path::Path;
use std::sync::Arc;
use values::Values;

pub(crate) fn read(
    bytes: &[u8],
    name: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, Fault> {
    let mut warnings = Warnings::default();
    let header = Header::read(bytes, &mut warnings)?;
    let mut budget = Budget::new(&options.limits, bytes.len() as u64);
    let mut values = Values::new(&bytes[header.bytes..], header.bytes as u64, header.lines, header.encoding);
    let mut points = None;
    let mut soup = faces::Faces::default();
    for e in &header.elements {
        values.check_room(e)?;
        match &e.name[..] {
            "vertex" if points.is_none() => {
                points = Some(vertices::read(e, &mut values, &mut budget, &mut warnings)?);
            }
            "face" => soup.read(e, &mut values, &mut budget, &mut warnings)?,
            "tristrips" => soup.read_strips(e, &mut values, &mut budget)?,
            other => {
                if matches!(other, "edge" | "vertex") && e.count > 0 {
                    warnings.add(format!("element {other}"), format!("a list of {other} elements; left out"));
                }
                values.skip(e)?;
            }
        }
    }
    values.end(&mut warnings);
    let Some(points) = points else {
        return Err(Fault::line(header.lines, "there is no element `vertex`: not a shape"));
    };
    let (uvs, colors) = (!points.uvs.is_empty() || soup.has_uvs(), !points.colors.is_empty());
    let count = points.positions.len();
    // Without faces it is a cloud of points.
    let cloud = soup.is_empty();
    let mesh = if cloud {
        let (vertices, bytes) = strokes::estimate(count as u64, 0, points.bytes_each());
        budget.vertices(vertices, bytes.saturating_add(12 * count as u64), || "element vertex".into())?;
        points.cloud()
    } else {
        soup.mesh(points, &mut budget, &mut warnings)?
    };
    let mut out = Assembly::default();
    let mut external = 0;
    let picture = header.texture.as_deref().filter(|_| uvs);
    let source = Source {
        folder,
        limits: &options.limits,
        keep_files: options.image_files,
        used: bytes.len() as u64 + budget.booked(),
    };
    let texture = picture.and_then(|name| self::picture(name, &source, &mut warnings));
    let mut material = plain();
    if let Some(d) = texture {
        external = d.encoded_bytes;
        out.images.push(d);
        let texture = out.texture(0, Sampler::default());
        material.base_color_texture = Some(TextureRef::new(texture));
    }
    if colors || material.base_color_texture.is_some() {
        material.base_color = Vec3::ONE;
    }
    if cloud {
        material.unlit = mesh.normals.is_empty();
        out.materials.push(material);
        out.add_strokes(mesh, Some(0));
    } else {
        out.materials.push(material);
        out.add(mesh, Some(0));
    }
    let format = match header.encoding {
        Encoding::Text => "PLY (text)",
        Encoding::Little => "PLY (binary, little-endian)",
        Encoding::Big => "PLY (binary, big-endian)",
    };
    let facts = Facts { file: name, format, bytes: bytes.len() as u64, external, comment: header.comment };
    out.finish(facts, options.image_files, warnings)
}

/// The picture that a comment names.
fn picture(name: &str, source: &Source<'_>, warnings: &mut Warnings) -> Option<Decoded> {
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let made = library::read(source, &[name.as_bytes(), last.as_bytes()], "picture").and_then(|bytes| {
        let (left, _) = source.limits.for_images(source.used);
        let image = source
            .decode(&bytes, left)
            .map_err(|e| format!("the picture `{name}` cannot be decoded: {e}"))?;
        Ok(source.decoded(Arc::new(image), bytes))
    });
    made.map_err(|why| warnings.add("comment TextureFile", format!("{why}; shown without"))).ok()
}
