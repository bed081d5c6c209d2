//! Compressed primitives become plain ones: each attribute gets an accessor of its own, over what was decoded.

use super::{DracoError, DracoLimits, decode};
use crate::buffers::Buffers;
use crate::document::{Accessor, Component, Document, Mode, Primitive, Shape, get};
use crate::error::Fault;
use crate::extensions;
use crate::limits::Budget;
use crate::warning::Warnings;
use rayon::prelude::*;

/// A primitive to decode.
struct Job<'a> {
    /// Numbers of the mesh and of the primitive in it.
    place: (usize, usize),
    pointer: String,
    bytes: &'a [u8],
    limits: DracoLimits,
    attributes: Vec<Wanted>,
}

/// An attribute that is wanted of the data.
struct Wanted {
    /// Its number among the primitive's attributes.
    slot: usize,
    /// The accessor that describes it.
    accessor: u32,
    component: Component,
    components: usize,
    normalized: bool,
    /// Which attribute of the data it is.
    id: u32,
}

/// What came out of a primitive's data.
struct Content {
    points: u64,
    indices: Vec<u8>,
    /// As the job's.
    attributes: Vec<Vec<u8>>,
}

/// Decodes all compressed primitives that are triangles, in parallel, after their size is booked, and makes their accessors
/// refer to the result. One that cannot be decoded keeps its uncompressed fallback, if the file has one.
pub(crate) fn expand(
    doc: &mut Document<'_>,
    buffers: &mut Buffers<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<(), Fault> {
    let mut jobs = Vec::new();
    for (m, mesh) in doc.meshes.iter().enumerate() {
        for (n, p) in mesh.primitives.iter().enumerate() {
            jobs.extend(job(doc, buffers, (m, n), p, budget)?);
        }
    }
    let decoded: Vec<_> = jobs
        .into_par_iter()
        .map(|j| {
            let content = j.run();
            (j.place, j.pointer, j.attributes, content)
        })
        .collect();
    for ((m, n), pointer, attributes, content) in decoded {
        match content {
            Ok(c) => {
                let mut number = |bytes: Vec<u8>| {
                    buffers.decoded_attributes.push(bytes);
                    (buffers.decoded_attributes.len() - 1) as u32
                };
                let corners = c.indices.len() as u64 / 4;
                let p = &mut doc.meshes[m].primitives[n];
                let announced = p.indices.and_then(|i| doc.accessors.get(i as usize)).map(|a| a.count);
                if p.mode == Mode::Triangles && announced.is_some_and(|n| n != corners) {
                    warnings.add(
                        &pointer,
                        "the accessor of the indices has not as many as the Draco data; those are used",
                    );
                }
                doc.accessors.push(Accessor {
                    buffer_view: None,
                    byte_offset: 0,
                    component: Component::U32,
                    normalized: false,
                    count: corners,
                    shape: Shape::Scalar,
                    sparse: None,
                    decoded: Some(number(c.indices)),
                    origin: p.indices,
                });
                p.indices = Some((doc.accessors.len() - 1) as u32);
                // Strips are decoded to a list.
                p.mode = Mode::Triangles;
                for (wanted, bytes) in attributes.into_iter().zip(c.attributes) {
                    let mut a = doc.accessors[wanted.accessor as usize].clone();
                    if a.count != c.points {
                        warnings.add(
                            &pointer,
                            "an accessor has not as many elements as the Draco data; those are used",
                        );
                    }
                    (a.buffer_view, a.byte_offset, a.count) = (None, 0, c.points);
                    (a.decoded, a.origin) = (Some(number(bytes)), Some(wanted.accessor));
                    doc.accessors.push(a);
                    p.attributes[wanted.slot].1 = (doc.accessors.len() - 1) as u32;
                }
            }
            Err(e) => {
                if !has_fallback(doc, buffers, &doc.meshes[m].primitives[n]) {
                    return Err(Fault::invalid(pointer, e.to_string()));
                }
                warnings.add(pointer, format!("{e}; the uncompressed data are used"));
            }
        }
    }
    Ok(())
}

/// What is to be done for primitive `p`; nothing, if it is not compressed or not shown.
fn job<'a>(
    doc: &Document<'_>,
    buffers: &'a Buffers<'_>,
    place: (usize, usize),
    p: &Primitive<'_>,
    budget: &mut Budget,
) -> Result<Option<Job<'a>>, Fault> {
    let Some(d) = p.draco.as_ref().filter(|_| matches!(p.mode, Mode::Triangles | Mode::Strip)) else {
        return Ok(None);
    };
    let pointer = format!("/meshes/{}/primitives/{}/extensions/{}", place.0, place.1, extensions::DRACO);
    let bytes = buffers.view(doc, d.buffer_view, || format!("{pointer}/bufferView"))?;
    let mut attributes = Vec::with_capacity(d.attributes.len());
    let (mut points, mut values) = (0u64, 0u64);
    for &(name, id) in &d.attributes {
        let Some(slot) = p.attributes.iter().position(|(n, _)| *n == name) else { continue };
        let accessor = p.attributes[slot].1;
        let a = get(&doc.accessors, accessor, "accessor", || format!("{pointer}/attributes/{name}"))?;
        let components = a.shape.components();
        if matches!(a.shape, Shape::Mat2 | Shape::Mat3 | Shape::Mat4 | Shape::Unknown) {
            return Err(Fault::invalid(
                format!("{pointer}/attributes/{name}"),
                format!("the compressed data cannot be {}", a.shape.name()),
            ));
        }
        points = points.max(a.count);
        values = values.saturating_add(a.count.saturating_mul(components));
        attributes.push(Wanted {
            slot,
            accessor,
            component: a.component,
            components: components as usize,
            normalized: a.normalized,
            id,
        });
    }
    let indices = p.indices.map(|i| get(&doc.accessors, i, "accessor", || format!("{pointer}/indices")));
    let corners = indices.transpose()?.map_or(points, |i| i.count);
    // Values of four bytes, copied once, and connectivity: some twelve numbers for each corner and point while it is decoded.
    let working = corners.saturating_add(points).saturating_mul(48);
    budget.bytes(values.saturating_mul(8).saturating_add(working), || pointer.clone())?;
    // Room for files whose accessors announce somewhat less than there is: that is warned of.
    let limits = DracoLimits {
        triangles: corners.saturating_add(1024),
        bytes: values.saturating_mul(16).saturating_add(1 << 20),
    };
    Ok(Some(Job { place, pointer, bytes, limits, attributes }))
}

impl Job<'_> {
    fn run(&self) -> Result<Content, DracoError> {
        let mesh = decode(self.bytes, &self.limits)?;
        let attributes =
            self.attributes.iter().map(|w| mesh.values(w.id, w.component, w.components, w.normalized));
        Ok(Content {
            points: mesh.points() as u64,
            indices: mesh.triangles().flatten().flat_map(u32::to_le_bytes).collect(),
            attributes: attributes.collect::<Result<_, _>>()?,
        })
    }
}

/// Whether the file has the positions without compression as well.
fn has_fallback(doc: &Document<'_>, buffers: &Buffers<'_>, p: &Primitive<'_>) -> bool {
    !doc.extensions_required.contains(&extensions::DRACO)
        && p.attribute("POSITION")
            .and_then(|a| doc.accessors.get(a as usize)?.buffer_view)
            .is_some_and(|v| buffers.view(doc, v, String::new).is_ok_and(|b| !b.is_empty()))
}
