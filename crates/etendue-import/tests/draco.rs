//! Draco: the reference encoder's streams give back what it was given, cut and bent ones are errors, models are the plain ones.
//!
//! `data/draco_*.drc` were written by the reference encoder (draco3d 1.5.9, npm): a patch of 7 by 6 vertices on a wave, under
//! both methods and at several speeds, which choose the predictions.
mod common;
use common::*;
use etendue_import::draco::{DracoError, DracoLimits, decode};
use etendue_import::{ImportError, ImportOptions, Support, support};
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

const WIDTH: usize = 7;
const HEIGHT: usize = 6;
const LIMITS: DracoLimits = DracoLimits { triangles: 10_000, bytes: 1 << 20 };

/// Name, and bits of positions.
const STREAMS: [(&str, u32); 8] = [
    ("edgebreaker_0", 11),
    ("edgebreaker_3", 14),
    ("edgebreaker_5", 11),
    ("edgebreaker_8", 11),
    ("edgebreaker_10", 11),
    ("sequential_3", 11),
    ("sequential_10", 11),
    ("sequential_floats", 23),
];

fn data(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");
    std::fs::read(Path::new(folder).join(format!("draco_{name}.drc"))).unwrap()
}

/// Position, normal, texture coordinates and colour of vertex (x, y), one after another.
fn vertex(x: usize, y: usize) -> [f32; 12] {
    let (u, v) = (x as f32, y as f32);
    let slope = (u + 0.5 * v).cos();
    let n = glam::Vec3::new(-0.6 * slope, 1.0, -0.375 * slope).normalize();
    let turn = if x > 3 { -1.0 } else { 1.0 };
    let byte = |v: usize| (v & 255) as f32 / 255.0;
    [
        0.5 * u,
        0.3 * (u + 0.5 * v).sin(),
        0.4 * v,
        n.x,
        n.y,
        n.z,
        turn * u / (WIDTH - 1) as f32,
        v / (HEIGHT - 1) as f32,
        byte(40 * x),
        byte(50 * y),
        byte(8 * x * y),
        1.0,
    ]
}

fn triangles() -> Vec<[[f32; 12]; 3]> {
    let mut out = Vec::new();
    for y in 0..HEIGHT - 1 {
        for x in 0..WIDTH - 1 {
            let v = |dx, dy| vertex(x + dx, y + dy);
            out.push([v(0, 0), v(0, 1), v(1, 0)]);
            out.push([v(1, 0), v(0, 1), v(1, 1)]);
        }
    }
    out
}

/// Each of `a` is one of `b`, corner by corner, within `bounds` per kind of number.
fn compare(name: &str, a: &[[[f32; 12]; 3]], b: &[[[f32; 12]; 3]], bounds: [f32; 4]) {
    assert_eq!(a.len(), b.len(), "{name}");
    let bound = |k: usize| bounds[[0, 0, 0, 1, 1, 1, 2, 2, 3, 3, 3, 3][k]];
    let mut taken = vec![false; b.len()];
    for t in a {
        let near = |u: &[[f32; 12]; 3], turn: usize| {
            (0..3).all(|c| (0..12).all(|k| (t[c][k] - u[(c + turn) % 3][k]).abs() <= bound(k)))
        };
        let found = (0..b.len()).find(|&i| !taken[i] && (0..3).any(|turn| near(&b[i], turn)));
        taken[found.unwrap_or_else(|| panic!("{name}: nothing like {t:?}"))] = true;
    }
}

/// Half a step of `bits` over the largest extent; normals of 8 bits, texture coordinates of 10, colours exact.
fn bounds(bits: u32) -> [f32; 4] {
    if bits == 23 {
        return [1e-6; 4];
    }
    [0.5 * 3.0 / ((1u32 << bits) - 1) as f32 * 1.01, 0.02, 0.5 * 1.7 / 1023.0 * 1.01, 1e-6]
}

#[test]
fn streams_give_back_what_was_encoded() {
    for (name, bits) in STREAMS {
        let m = decode(&data(name), &LIMITS).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut ids: Vec<u32> = m.attributes().collect();
        ids.sort_unstable();
        assert_eq!(ids, [0, 1, 2, 3]);
        let values: Vec<(Vec<f32>, usize)> = ids.iter().map(|&i| m.floats(i).unwrap()).collect();
        let point = |p: u32| {
            let mut all = values.iter().enumerate().flat_map(|(i, (v, n))| {
                // Bytes that the encoder was not told to be normalised.
                let scale = if i == 3 { 1.0 / 255.0 } else { 1.0 };
                v[p as usize * n..(p as usize + 1) * n].iter().map(move |v| v * scale)
            });
            std::array::from_fn(|_| all.next().unwrap())
        };
        let got: Vec<_> = m.triangles().map(|t| t.map(point)).collect();
        compare(name, &got, &triangles(), bounds(bits));
    }
}

/// A primitive over stream `name`.
fn model(name: &str) -> Model {
    let mut m = Model::new();
    let stream = data(name);
    let view = m.view(&stream);
    let points = decode(&stream, &LIMITS).unwrap().points();
    let mut attributes = json!({});
    for (semantic, component, shape) in [
        ("POSITION", F32, "VEC3"),
        ("NORMAL", F32, "VEC3"),
        ("TEXCOORD_0", F32, "VEC2"),
        ("COLOR_0", U8, "VEC4"),
    ] {
        let a = json!({"componentType": component, "count": points, "type": shape, "normalized": component == U8});
        attributes[semantic] = json!(m.push("accessors", a));
    }
    let count = 3 * triangles().len();
    let indices = m.push("accessors", json!({"componentType": U16, "count": count, "type": "SCALAR"}));
    let ids = json!({"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3});
    let mesh = m.mesh(json!({"attributes": attributes, "indices": indices, "extensions": {
        "KHR_draco_mesh_compression": {"bufferView": view, "attributes": ids}}}));
    m.node(json!({"mesh": mesh}));
    m.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    m
}

#[test]
fn primitives_are_decompressed() {
    assert_eq!(support("KHR_draco_mesh_compression"), Some(Support::Full));
    for (name, bits) in STREAMS {
        let i = model(name).import();
        assert!(i.warnings.is_empty(), "{name}: {:?}", i.warnings);
        let m = &i.scene.meshes[0];
        let corner = |k: u32| {
            let k = k as usize;
            let (p, n, t, c) = (m.positions[k], m.normals[k], m.uvs[0][k], m.colors[k]);
            [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y, c.x, c.y, c.z, c.w]
        };
        let got: Vec<_> = m.indices.iter().map(|t| t.map(corner)).collect();
        compare(name, &got, &triangles(), bounds(bits));
        assert_eq!(i.info.counts.triangles, triangles().len() as u64);
    }
}

#[test]
fn faults_say_where_and_fallbacks_are_used() {
    let at = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let with = |change: &dyn Fn(&mut Value)| {
        let mut m = model("edgebreaker_5");
        change(&mut m.json);
        m
    };
    let extension = |j: &mut Value, key: &str, v: Value| {
        j["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"][key] = v;
    };
    let e = with(&|j| extension(j, "bufferView", json!(7))).error();
    assert!(e.contains(&format!("{at}/bufferView: buffer view 7 does not exist")), "{e}");
    let e = with(&|j| extension(j, "attributes", json!({"POSITION": 9}))).error();
    assert!(e.contains(&format!("{at}: damaged Draco data: there is no attribute 9")), "{e}");
    let e = with(&|j| extension(j, "attributes", json!({"POSITION": 2}))).error();
    assert!(e.contains("attribute 2 has 2 components, its accessor 3"), "{e}");
    let e = with(&|j| j["bufferViews"][0]["byteLength"] = json!(300)).error();
    assert!(e.contains(&format!("{at}: damaged Draco data")), "{e}");
    // Other counts than announced.
    let i = with(&|j| j["accessors"][0]["count"] = json!(3)).import();
    assert!(warned(&i, "an accessor has not as many elements as the Draco data"), "{:?}", i.warnings);
    assert_eq!(i.scene.meshes[0].indices.len(), triangles().len());
    let i = with(&|j| j["accessors"][4]["count"] = json!(3)).import();
    assert!(warned(&i, "the accessor of the indices has not as many"), "{:?}", i.warnings);
    // Damaged data beside a plain form.
    let mut m = model("edgebreaker_5");
    m.json["bufferViews"][0]["byteLength"] = json!(300);
    let plain = m.floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.], "VEC3");
    m.json["extensionsRequired"] = json!([]);
    let p = &mut m.json["meshes"][0]["primitives"][0];
    p["attributes"] = json!({"POSITION": plain});
    p.as_object_mut().unwrap().remove("indices");
    let i = m.import();
    assert!(warned(&i, "the uncompressed data are used"), "{:?}", i.warnings);
    assert_eq!(i.scene.meshes[0].indices.len(), 1);
}

#[test]
fn what_is_decoded_is_bounded() {
    let stream = data("edgebreaker_5");
    let small = DracoLimits { triangles: 10, ..LIMITS };
    assert!(matches!(decode(&stream, &small), Err(DracoError::TooLarge(_))));
    let small = DracoLimits { bytes: 100, ..LIMITS };
    assert!(matches!(decode(&stream, &small), Err(DracoError::TooLarge(_))));
    // Announcing much is booked.
    let mut m = model("edgebreaker_5");
    m.json["accessors"][0]["count"] = json!(100_000_000);
    let e = m.import_with(&ImportOptions::default()).err();
    assert!(matches!(e, Some(ImportError::TooLarge { limit: "geometry_expansion", .. })), "{e:?}");
}

/// Every stream cut anywhere and with every bit turned over: a mesh that holds together, or an error, soon.
#[test]
fn cut_and_bent_streams() {
    let start = Instant::now();
    let (mut good, mut bad, mut slowest) = (0, 0, Duration::ZERO);
    let mut one = |bytes: &[u8]| {
        let start = Instant::now();
        match decode(bytes, &LIMITS) {
            Ok(m) => {
                let points = m.points() as u32;
                assert!(m.triangles().flatten().all(|p| p < points));
                for id in m.attributes() {
                    if let Ok((values, n)) = m.floats(id) {
                        assert_eq!(values.len(), n * m.points());
                    }
                }
                good += 1;
            }
            Err(_) => bad += 1,
        }
        slowest = slowest.max(start.elapsed());
    };
    for (name, _) in STREAMS {
        let stream = data(name);
        for n in 0..stream.len() {
            one(&stream[..n]);
        }
        for bit in 0..8 * stream.len() {
            let mut bent = stream.clone();
            bent[bit / 8] ^= 1 << (bit % 8);
            one(&bent);
        }
    }
    println!("{good} meshes, {bad} errors, slowest {slowest:?}");
    assert!(bad > 1000 && start.elapsed() < Duration::from_secs(60));
}
