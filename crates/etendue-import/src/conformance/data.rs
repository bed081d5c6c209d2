//! Buffers, views and accessors: places, strides, and whether the data are as announced.

use super::{Case, list};
use crate::accessor::Elements;
use crate::document::{Component, Shape};
use serde_json::Value;

/// All shapes that can be read.
const SHAPES: [Shape; 7] =
    [Shape::Scalar, Shape::Vec2, Shape::Vec3, Shape::Vec4, Shape::Mat2, Shape::Mat3, Shape::Mat4];

/// Smallest and largest value of each component, and whether all are finite.
struct Range {
    low: Vec<f64>,
    high: Vec<f64>,
    finite: bool,
}

impl Case<'_> {
    pub(super) fn buffers(&mut self) {
        let doc = self.accessors.doc;
        for (i, b) in doc.buffers.iter().enumerate() {
            let at = format!("/buffers/{i}");
            if b.byte_length == 0 {
                self.out.add(format!("{at}/byteLength"), "a buffer of no bytes");
            }
            // Those that a view shows have been loaded, or the file would have been refused.
            if doc.buffer_views.iter().any(|v| v.buffer as usize == i) {
                continue;
            }
            let have = match b.uri {
                // Nothing is fetched from elsewhere.
                Some(uri) if uri.contains("://") => continue,
                Some(uri) => match self.source.read(uri, "buffer", &at) {
                    Ok(bytes) => bytes.len() as u64,
                    Err(e) => {
                        self.out.add(format!("{at}/uri"), e.message());
                        continue;
                    }
                },
                None => match self.parts.binary {
                    Some(bytes) if i == 0 => bytes.len() as u64,
                    None if i == 0 && self.parts.is_glb => {
                        self.out.add(at, "means the binary chunk, which the file does not have");
                        continue;
                    }
                    // A place for bytes that come in another way.
                    _ => continue,
                },
            };
            if have < b.byte_length {
                self.out.add(format!("{at}/byteLength"), "more bytes are announced than there are");
            }
        }
        for (i, v) in doc.buffer_views.iter().enumerate() {
            let Some(buffer) = doc.buffers.get(v.buffer as usize) else { continue };
            if v.byte_offset.saturating_add(v.byte_length) > buffer.byte_length && v.compressed.is_none() {
                self.out.add(format!("/bufferViews/{i}"), "the view reaches beyond its buffer");
            }
            if v.byte_length == 0 {
                self.out.add(format!("/bufferViews/{i}/byteLength"), "a view of no bytes");
            }
            if v.byte_stride.is_some_and(|s| s % 4 != 0) {
                self.out.add(format!("/bufferViews/{i}/byteStride"), "a stride that is no multiple of 4");
            }
        }
    }

    pub(super) fn accessors(&mut self) {
        for (i, json) in list(self.root, "accessors").iter().enumerate() {
            // What was decoded from a compressed primitive has no place of its own.
            if self.accessors.doc.accessors.get(i).is_some_and(|a| a.decoded.is_none()) {
                self.placement(i);
                self.values(i, json);
            }
        }
    }

    /// glTF 2.0, 3.6.2.4: alignment and strides.
    fn placement(&mut self, i: usize) {
        let doc = self.accessors.doc;
        let (a, out) = (&doc.accessors[i], &mut self.out);
        let at = |what: &str| format!("/accessors/{i}{what}");
        let component = a.component.size();
        if a.count == 0 {
            out.add(at("/count"), "an accessor of no elements");
        }
        match a.buffer_view.and_then(|v| doc.buffer_views.get(v as usize)) {
            Some(v) => {
                if a.byte_offset % component != 0
                    || v.byte_offset.wrapping_add(a.byte_offset) % component != 0
                {
                    out.add(at("/byteOffset"), "elements that are not aligned to their components");
                }
                let narrow = matches!(a.shape, Shape::Mat2 | Shape::Mat3 | Shape::Mat4) && component < 4;
                if narrow && a.byte_offset % 4 != 0 {
                    out.add(at("/byteOffset"), "matrices that are not aligned to 4 bytes");
                }
                if v.byte_stride.is_some_and(|s| s < a.shape.size(a.component)) {
                    out.add(at(""), "the view's stride is shorter than an element");
                }
            }
            None if a.buffer_view.is_none()
                && list(self.root, "accessors")[i].get("byteOffset").is_some() =>
            {
                out.add(at("/byteOffset"), "an offset into no buffer view");
            }
            None => {}
        }
        let Some(s) = &a.sparse else { return };
        if s.count > a.count || s.count == 0 {
            out.add(at("/sparse/count"), "replaces no element, or more than there are");
        }
        for (view, name) in [(s.indices_view, "indices"), (s.values_view, "values")] {
            if doc.buffer_views.get(view as usize).is_some_and(|v| v.byte_stride.is_some()) {
                out.add(at(&format!("/sparse/{name}/bufferView")), "a view with a stride for sparse data");
            }
        }
    }

    /// What is announced of the values, beside the values.
    fn values(&mut self, i: usize, json: &Value) {
        let (doc, parts) = (self.accessors.doc, self.parts);
        let accessor = &doc.accessors[i];
        let buffer = accessor.buffer_view.and_then(|v| doc.buffer_views.get(v as usize));
        let buffer = buffer.and_then(|v| doc.buffers.get(v.buffer as usize));
        // The reader has said so; and a buffer may be a place for bytes that come in another way.
        if accessor.shape == Shape::Unknown
            || buffer.is_some_and(|b| b.uri.is_none() && parts.binary.is_none())
        {
            return;
        }
        let elements = match self.accessors.open(i as u32, "", &SHAPES, || format!("/accessors/{i}")) {
            Ok(e) => e,
            Err(e) => {
                self.out.add(format!("/accessors/{i}"), e.message());
                return;
            }
        };
        // A long list of nothing takes no bytes in the file and should take none here.
        if elements.is_plain_zero() {
            return;
        }
        let range = match elements.shape() {
            Shape::Scalar => range::<1>(&elements),
            Shape::Vec2 => range::<2>(&elements),
            Shape::Vec3 => range::<3>(&elements),
            Shape::Vec4 | Shape::Mat2 => range::<4>(&elements),
            Shape::Mat3 => range::<9>(&elements),
            Shape::Mat4 => range::<16>(&elements),
            Shape::Unknown => return,
        };
        if !range.finite {
            self.out.add(format!("/accessors/{i}"), "values that are infinite or no numbers");
        }
        for (key, real) in [("min", &range.low), ("max", &range.high)] {
            let Some(said) = json.get(key).and_then(Value::as_array) else { continue };
            let at = format!("/accessors/{i}/{key}");
            if said.len() != real.len() {
                self.out.add(at, format!("{} numbers for elements of {}", said.len(), real.len()));
                continue;
            }
            let single = elements.component() == Component::F32;
            let differs = |(said, real): (&Value, &f64)| {
                // A number in the text stands for the nearest one of single precision.
                said.as_f64().is_some_and(|s| if single { s as f32 != *real as f32 } else { s != *real })
            };
            if range.finite && elements.len() > 0 && said.iter().zip(real).any(differs) {
                self.out.add(at, format!("is not the {key} of the values"));
            }
        }
    }
}

/// The range of the stored values, not normalised.
fn range<const N: usize>(e: &Elements<'_>) -> Range {
    let (mut low, mut high, mut finite) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N], true);
    let mut add = |v: [f64; N]| {
        for c in 0..N {
            finite &= v[c].is_finite();
            (low[c], high[c]) = (low[c].min(v[c]), high[c].max(v[c]));
        }
    };
    // Indices of 32 bits have more digits than a float.
    match e.integers::<N>(None) {
        Some(all) => all.into_iter().for_each(|v| add(v.map(f64::from))),
        None => e.stored_floats::<N>(None).into_iter().for_each(|v| add(v.map(f64::from))),
    }
    Range { low: low.to_vec(), high: high.to_vec(), finite }
}
