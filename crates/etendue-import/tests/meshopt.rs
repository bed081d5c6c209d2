//! meshopt's streams: against the reference's decoder, cut and bent, and through whole models.
//!
//! `data/meshopt.json` holds streams that the reference encoder wrote (meshoptimizer 1.3, npm) with what its decoder
//! makes of them.
mod common;
use base64::Engine as _;
use common::*;
use etendue_import::meshopt::{Filter, Layout, MeshoptError, Mode, decode};
use etendue_import::{ImportError, ImportOptions};
use serde_json::{Value, json};
use std::time::Instant;

struct Case {
    name: String,
    json: Value,
    layout: Layout,
    stream: Vec<u8>,
    decoded: Vec<u8>,
}

fn cases() -> Vec<Case> {
    let list: Vec<Value> = serde_json::from_str(include_str!("data/meshopt.json")).unwrap();
    let bytes = |v: &Value| base64::engine::general_purpose::STANDARD.decode(v.as_str().unwrap()).unwrap();
    list.into_iter()
        .map(|json| Case {
            name: format!("{} stride {}", json["name"], json["stride"]),
            layout: Layout {
                mode: match json["mode"].as_str().unwrap() {
                    "ATTRIBUTES" => Mode::Attributes,
                    "TRIANGLES" => Mode::Triangles,
                    _ => Mode::Indices,
                },
                filter: match json["filter"].as_str().unwrap() {
                    "OCTAHEDRAL" => Filter::Octahedral,
                    "QUATERNION" => Filter::Quaternion,
                    "EXPONENTIAL" => Filter::Exponential,
                    "COLOR" => Filter::Color,
                    _ => Filter::None,
                },
                count: json["count"].as_u64().unwrap(),
                stride: json["stride"].as_u64().unwrap(),
            },
            stream: bytes(&json["stream"]),
            decoded: bytes(&json["decoded"]),
            json,
        })
        .collect()
}

/// Largest difference of two decoded arrays, in units of the filter's integers (appendix B allows one).
fn largest_step(filter: Filter, stride: u64, a: &[u8], b: &[u8]) -> i32 {
    let step = |a: i32, b: i32| (a - b).abs();
    let word = |b: &[u8]| i32::from(i16::from_le_bytes([b[0], b[1]]));
    match (filter, stride) {
        // These have to be exact.
        (Filter::None | Filter::Exponential, _) => i32::from(a != b) * i32::MAX,
        (Filter::Octahedral, 4) => {
            a.iter().zip(b).map(|(a, b)| step((*a as i8).into(), (*b as i8).into())).max().unwrap()
        }
        (Filter::Color, 4) => a.iter().zip(b).map(|(a, b)| step((*a).into(), (*b).into())).max().unwrap(),
        (Filter::Color, _) => {
            let word = |b| word(b) & 0xffff;
            a.chunks(2).zip(b.chunks(2)).map(|(a, b)| step(word(a), word(b))).max().unwrap()
        }
        _ => a.chunks(2).zip(b.chunks(2)).map(|(a, b)| step(word(a), word(b))).max().unwrap(),
    }
}

#[test]
fn streams_decode_as_the_reference_does() {
    let mut largest = 0;
    for c in cases() {
        let out = decode(&c.stream, &c.layout).unwrap_or_else(|e| panic!("{}: {e}", c.name));
        let step = largest_step(c.layout.filter, c.layout.stride, &out, &c.decoded);
        assert!(out.len() == c.decoded.len() && step <= 1, "{}: off by {step}", c.name);
        largest = largest.max(step);
    }
    println!("largest difference after a filter: {largest} of its steps");
}

/// A stream that ends early or late is refused, one with a changed bit gives as many bytes or an error.
#[test]
fn cut_and_bent_streams_are_errors_or_the_right_size() {
    let mut refused = 0;
    for c in cases() {
        for n in 0..c.stream.len() {
            assert!(decode(&c.stream[..n], &c.layout).is_err(), "{} cut to {n}", c.name);
        }
        let longer = [&c.stream[..], &[0]].concat();
        assert!(decode(&longer, &c.layout).is_err(), "{} with a byte more", c.name);
        for bit in 0..8 * c.stream.len() {
            let mut bent = c.stream.clone();
            bent[bit / 8] ^= 1 << (bit % 8);
            match decode(&bent, &c.layout) {
                Ok(out) => assert_eq!(out.len(), c.decoded.len()),
                Err(MeshoptError::Damaged(_)) => refused += 1,
                Err(e) => panic!("{}: {e}", c.name),
            }
        }
        // A few more elements of nothing but zeros may take no space in a version 0 block; many do.
        let more = Layout { count: c.layout.count + 3 * 4096, ..c.layout };
        assert!(decode(&c.stream, &more).is_err(), "{} with more elements", c.name);
    }
    assert!(refused > 1000);
}

#[test]
fn claims_do_not_allocate() {
    let start = Instant::now();
    for (mode, stride, first) in [
        (Mode::Attributes, 256, 0xa1),
        (Mode::Attributes, 4, 0xa0),
        (Mode::Triangles, 4, 0xe1),
        (Mode::Indices, 2, 0xd1),
    ] {
        for count in [3_000_000_000, 3 << 50, u64::MAX / 3 * 3] {
            let mut bytes = vec![0; 1000];
            bytes[0] = first;
            let layout = Layout { mode, filter: Filter::None, count, stride };
            assert!(decode(&bytes, &layout).is_err());
        }
    }
    assert!(start.elapsed().as_secs() < 5);
}

/// The layouts that the extension forbids.
#[test]
fn layouts_are_checked() {
    let ok = Layout { mode: Mode::Attributes, filter: Filter::None, count: 0, stride: 4 };
    for wrong in [
        Layout { stride: 0, ..ok },
        Layout { stride: 6, ..ok },
        Layout { stride: 260, ..ok },
        Layout { stride: 12, filter: Filter::Octahedral, ..ok },
        Layout { stride: 4, filter: Filter::Quaternion, ..ok },
        Layout { stride: 12, filter: Filter::Color, ..ok },
        Layout { mode: Mode::Indices, stride: 1, ..ok },
        Layout { mode: Mode::Indices, filter: Filter::Exponential, ..ok },
        Layout { mode: Mode::Triangles, count: 4, ..ok },
    ] {
        assert!(matches!(decode(&[0; 64], &wrong), Err(MeshoptError::Layout(_))), "{wrong:?}");
    }
}

/// A triangle whose positions are compressed under the extension `name`, the fallback without data.
fn compressed(name: &str) -> Model {
    let c = cases().into_iter().find(|c| c.layout.filter == Filter::Exponential).unwrap();
    let mut m = Model::new();
    let view = m.view(&c.stream);
    let mut compressed = json!({"buffer": 0, "byteOffset": m.json["bufferViews"][view as usize]["byteOffset"],
        "byteLength": c.stream.len()});
    for key in ["mode", "filter", "count"] {
        compressed[key] = c.json[key].clone();
    }
    compressed["byteStride"] = c.json["stride"].clone();
    m.json["bufferViews"][view as usize] =
        json!({"buffer": 1, "byteLength": c.decoded.len(), "extensions": {name: compressed}});
    let p = m.push(
        "accessors",
        json!({"bufferView": view, "componentType": F32, "count": c.json["count"], "type": "VEC3"}),
    );
    let mesh = m.mesh(json!({"attributes": {"POSITION": p}}));
    m.node(json!({"mesh": mesh}));
    m.json["buffers"] = json!([{"byteLength": m.bytes.len()}, {"byteLength": c.decoded.len()}]);
    m.json["extensionsRequired"] = json!([name]);
    m
}

#[test]
fn views_are_decompressed_under_both_names() {
    let want: Vec<f32> = cases()
        .into_iter()
        .find(|c| c.layout.filter == Filter::Exponential)
        .map(|c| c.decoded.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect())
        .unwrap();
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let i = compressed(name).import();
        let got: Vec<f32> = i.scene.meshes[0].positions.iter().flat_map(|p| p.to_array()).collect();
        // Twenty points make six triangles; the last two points are not used.
        assert_eq!(got, want[..got.len()]);
        assert!(i.warnings.is_empty() || got.len() < want.len(), "{:?}", i.warnings);
    }
}

#[test]
fn faults_say_where() {
    let name = "KHR_meshopt_compression";
    let base = compressed(name);
    let at = |m: &mut Model, key: &str, v: Value| {
        m.json["bufferViews"][0]["extensions"][name][key] = v;
        m.error()
    };
    for (key, value, message) in [
        ("mode", json!("STRIPS"), "`STRIPS` is no mode"),
        ("filter", json!("SEPIA"), "`SEPIA` is no filter"),
        ("filter", json!("OCTAHEDRAL"), "the filter does not go with the stride"),
        ("count", json!(19), "decodes to 228 bytes, but its view has 240"),
        ("buffer", json!(7), "buffer 7 does not exist"),
        ("buffer", json!(1), "/buffers/1: has no `uri`"),
        ("byteOffset", json!(1 << 20), "reach beyond buffer 0"),
        ("byteLength", json!(30), "damaged meshopt data"),
    ] {
        let e = at(&mut Model { json: base.json.clone(), bytes: base.bytes.clone() }, key, value);
        assert!(e.contains(message), "{key}: {e}");
        assert!(e.contains("/bufferViews/0/extensions/KHR_meshopt_compression") || key == "buffer", "{e}");
    }
}

/// What is decoded counts against the limits before it is.
#[test]
fn decoded_views_are_booked() {
    let mut m = compressed("KHR_meshopt_compression");
    let view = m.json["bufferViews"][0].clone();
    for _ in 0..100 {
        m.push("bufferViews", view.clone());
    }
    let mut o = ImportOptions::default();
    o.limits.geometry_bytes = 20_000;
    assert!(matches!(m.import_with(&o), Err(ImportError::TooLarge { limit: "geometry_bytes", .. })));
}
