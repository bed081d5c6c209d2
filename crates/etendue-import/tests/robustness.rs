//! Files that lie, repeat themselves, or are cut: an error that says where, in bounded time and memory.
mod common;
use common::*;
use etendue_import::{ImportError, ImportOptions, Limits, import_bytes};
use serde_json::json;
use std::time::{Duration, Instant};

fn limited(change: impl Fn(&mut Limits)) -> ImportOptions {
    let mut o = ImportOptions::default();
    change(&mut o.limits);
    o
}

fn too_large(m: &Model, o: &ImportOptions) -> &'static str {
    match m.import_with(o) {
        Err(ImportError::TooLarge { limit, .. }) => limit,
        Err(e) => panic!("{e}"),
        Ok(_) => panic!("was imported"),
    }
}

#[test]
fn counts_without_data_do_not_allocate() {
    // A sparse accessor without a view may claim any number of zeros.
    let mut m = Model::new();
    let p = m.push("accessors", json!({"componentType": F32, "count": 400_000_000, "type": "VEC3"}));
    let mesh = m.mesh(json!({"attributes": {"POSITION": p}}));
    m.node(json!({"mesh": mesh}));
    assert_eq!(too_large(&m, &ImportOptions::default()), "geometry_expansion");
    m.json["accessors"][0]["count"] = json!(4_000_000_000u32);
    assert_eq!(too_large(&m, &ImportOptions::default()), "vertices");
}

#[test]
fn the_same_data_over_and_over_do_not_fill_the_memory() {
    // 400 index lists over one array of 100 000 vertices: each would decode to megabytes.
    let mut m = Model::new();
    let p = m.floats(&vec![0.5; 300_000], "VEC3");
    let list: Vec<u32> = (0..99_999).collect();
    let first = m.accessor(&list[..], U32, "SCALAR", list.len());
    let primitives: Vec<_> = (0..400)
        .map(|n| {
            let a = m.json["accessors"][first as usize].clone();
            let i = m.push("accessors", a);
            m.json["accessors"][i as usize]["count"] = json!(99_999 - 3 * n);
            json!({"attributes": {"POSITION": p}, "indices": i})
        })
        .collect();
    m.push("meshes", json!({"primitives": primitives}));
    m.node(json!({"mesh": 0}));
    let o = limited(|l| l.geometry_bytes = 100 << 20);
    assert_eq!(too_large(&m, &o), "geometry_bytes");
    let o = limited(|l| l.vertices = 1_000_000);
    assert_eq!(too_large(&m, &o), "vertices");
    assert_eq!(too_large(&m, &ImportOptions::default()), "geometry_expansion");
    m.json["meshes"][0]["primitives"].as_array_mut().unwrap().truncate(50);
    assert!(m.import().scene.meshes.len() == 50, "some sharing is usual");
}

#[test]
fn instances_and_nodes_are_bounded() {
    let mut m = Model::new();
    m.triangle(json!({}));
    for _ in 0..9 {
        m.node(json!({"mesh": 0}));
    }
    assert_eq!(too_large(&m, &limited(|l| l.instances = 9)), "instances");
    assert_eq!(too_large(&m, &limited(|l| l.nodes = 9)), "nodes");
    assert_eq!(too_large(&m, &limited(|l| l.json_bytes = 9)), "json_bytes");
    m.json["nodes"] = json!([{"children": [1]}, {"children": [2]}, {}]);
    m.json["scenes"][0]["nodes"] = json!([0]);
    assert_eq!(too_large(&m, &limited(|l| l.node_depth = 2)), "node_depth");
    assert!(m.import_with(&limited(|l| l.node_depth = 3)).is_ok());
}

#[test]
fn pictures_are_bounded() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.push("images", json!({"uri": data_uri(&png())}));
    m.push("textures", json!({"source": 0}));
    m.push("materials", json!({"emissiveTexture": {"index": 0}}));
    m.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    assert!(m.import_with(&limited(|l| l.image_pixels = 2)).is_ok());
    assert_eq!(too_large(&m, &limited(|l| l.image_pixels = 1)), "image_pixels");
    assert_eq!(too_large(&m, &limited(|l| l.image_bytes = 5)), "image_bytes");
    assert_eq!(too_large(&m, &limited(|l| l.image_dimension = 1)), "image_dimension");
}

/// File, geometry and pictures count against one limit: each of them alone stays within it.
#[test]
fn memory_is_bounded_over_all_parts() {
    let mut m = with(json!({"emissiveTexture": {"index": 0}}));
    let least = |m: &Model| {
        let fits = |n: u64| m.import_with(&limited(|l| l.memory_bytes = n)).is_ok();
        let (mut no, mut yes) = (0, 1 << 20);
        assert!(fits(yes));
        while yes - no > 1 {
            let middle = (no + yes) / 2;
            if fits(middle) { yes = middle } else { no = middle }
        }
        assert_eq!(too_large(m, &limited(|l| l.memory_bytes = no)), "memory_bytes");
        yes
    };
    let (all, file) = (least(&m), m.glb().len() as u64);
    m.json["materials"] = json!([{}]);
    let without_picture = least(&m) - m.glb().len() as u64;
    let picture = all - file - without_picture;
    assert!((6..64).contains(&picture), "two pixels: {picture}");
    assert!(without_picture > 3 * 12, "a triangle");
}

#[test]
fn accessors_and_depth_are_bounded() {
    let mut m = Model::new();
    m.triangle(json!({}));
    assert!(m.import_with(&limited(|l| l.accessors = 1)).is_ok());
    assert_eq!(too_large(&m, &limited(|l| l.accessors = 0)), "accessors");
    m.json["asset"]["extras"] = json!([[[[["]"]]]]]);
    assert!(m.import_with(&limited(|l| l.json_depth = 7)).is_ok());
    assert_eq!(too_large(&m, &limited(|l| l.json_depth = 6)), "json_depth");
    // Brackets in text are text.
    m.json["asset"]["extras"] = json!("[[[[[[[[\\\"[[[[");
    assert!(m.import_with(&limited(|l| l.json_depth = 6)).is_ok());
}

/// Every limit by its name, as errors and users have it.
#[test]
fn limits_have_names() {
    let mut l = Limits::default();
    for (name, about) in Limits::NAMES {
        assert!(!about.trim().is_empty());
        let before = l.get(name).unwrap();
        l.set(name, 7).unwrap();
        assert!(before != 7 && l.get(name) == Some(7), "{name}");
    }
    assert!(l.set("json_dept", 1).is_err_and(|e| e.contains("json_depth")));
    assert!(l.set("node_depth", 1 << 40).is_err());
}

#[test]
fn instancing_counts_are_bounded() {
    let mut m = Model::new();
    m.triangle(json!({}));
    let t = m.push("accessors", json!({"componentType": F32, "count": 3_000_000_000u32, "type": "VEC3"}));
    m.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": t}}});
    assert_eq!(too_large(&m, &ImportOptions::default()), "geometry_expansion");
}

/// A disk of `n` triangles around one vertex, with a normal map.
fn fan(n: u32) -> Model {
    let mut m = Model::new();
    let mut p = vec![0.0f32, 0.0, 0.0];
    for i in 0..n {
        let a = i as f32 / n as f32 * std::f32::consts::TAU;
        p.extend([a.cos(), a.sin(), 0.0]);
    }
    let uv: Vec<f32> = p.chunks(3).flat_map(|p| [p[0], p[1]]).collect();
    let normals = [0.0f32, 0.0, 1.0].repeat(p.len() / 3);
    let indices: Vec<u32> = (0..n).flat_map(|i| [0, i + 1, (i + 1) % n + 1]).collect();
    let attributes = json!({
        "POSITION": m.floats(&p, "VEC3"), "NORMAL": m.floats(&normals, "VEC3"), "TEXCOORD_0": m.floats(&uv, "VEC2")
    });
    let i = m.accessor(&indices[..], U32, "SCALAR", indices.len());
    m.push("images", json!({"uri": data_uri(&png())}));
    m.push("textures", json!({"source": 0}));
    m.push("materials", json!({"normalTexture": {"index": 0}}));
    let mesh = m.mesh(json!({"attributes": attributes, "indices": i, "material": 0}));
    m.node(json!({"mesh": mesh}));
    m
}

#[test]
fn a_point_with_very_many_triangles_does_not_hang_the_tangents() {
    let start = Instant::now();
    for n in [1000, 200_000] {
        let s = fan(n).import().scene;
        for t in &s.meshes[0].tangents {
            assert!((t.truncate() - glam::Vec3::X).length() < 1e-3 && t.w == -1.0, "{n}: {t}");
        }
    }
    // The quadratic algorithm takes minutes (and the recursive one the stack).
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[test]
fn degenerate_triangles_do_not_hang_the_tangents() {
    let mut m = fan(500);
    // Another 300 000 triangles without area among 100 000 proper ones.
    let mut indices: Vec<u32> = (0..300_000u32).flat_map(|i| [i % 500, i % 500, (i + 1) % 500]).collect();
    indices.extend((0..100_000u32).flat_map(|i| [1 + i % 400, 2 + i % 400, 3 + i % 400]));
    let i = m.accessor(&indices[..], U32, "SCALAR", indices.len());
    m.json["meshes"][0]["primitives"][0]["indices"] = json!(i);
    let start = Instant::now();
    let s = m.import().scene;
    assert_eq!(s.meshes[0].indices.len(), 400_000);
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[test]
fn work_does_not_multiply() {
    let start = Instant::now();
    // A thousand primitives that look up three vertices each in one sparse accessor of a million.
    let mut m = Model::new();
    let n = 1_000_000;
    let list: Vec<u32> = (0..n).collect();
    let indices = m.view(&list[..].bytes());
    let values = m.view(&vec![0u8; 12 * n as usize]);
    let p = m.push(
        "accessors",
        json!({"componentType": F32, "count": n, "type": "VEC3", "sparse": {
            "count": n,
            "indices": {"bufferView": indices, "componentType": U32},
            "values": {"bufferView": values}
        }}),
    );
    let three: Vec<u32> = (0..5000).collect();
    let v = m.view(&three[..].bytes());
    let primitives: Vec<_> = (0..1000)
        .map(|k| {
            let view = json!({"bufferView": v, "byteOffset": 12 * k, "componentType": U32, "count": 3, "type": "SCALAR"});
            let i = m.push("accessors", view);
            json!({"attributes": {"POSITION": p}, "indices": i})
        })
        .collect();
    m.push("meshes", json!({"primitives": primitives}));
    m.node(json!({"mesh": 0}));
    assert_eq!(m.import().scene.meshes.len(), 1000);

    // Points over and over: nothing to see, and yet work.
    let mut m = Model::new();
    let points = vec![json!({"attributes": {}, "mode": 0}); 2000];
    m.push("meshes", json!({"primitives": points}));
    m.json["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
    assert_eq!(too_large(&m, &limited(|l| l.instances = 100_000)), "instances");

    // One long name in many places.
    let mut m = Model::new();
    m.triangle(json!({}));
    m.json["meshes"][0]["name"] = json!("x".repeat(1 << 20));
    m.json["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
    m.json["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    assert_eq!(too_large(&m, &ImportOptions::default()), "geometry_expansion");

    // Many variants in many places, also where nothing stands.
    let little = limited(|l| l.geometry_bytes = 1 << 24);
    let mut m = Model::new();
    m.triangle(json!({}));
    let all: Vec<u32> = (0..10_000).collect();
    m.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": vec![json!({"name": ""}); all.len()]}});
    m.push("materials", json!({}));
    m.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_materials_variants": {"mappings": [{"material": 0, "variants": all}]}});
    m.json["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
    m.json["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    assert_eq!(too_large(&m, &little), "geometry_bytes");
    let none = m.floats(&[], "VEC3");
    let nowhere = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": none}}});
    m.json["nodes"] = json!(vec![json!({"mesh": 0, "extensions": nowhere}); 2000]);
    assert_eq!(too_large(&m, &little), "geometry_bytes");
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[test]
fn deeply_nested_json_is_an_error() {
    let mut text = br#"{"asset":{"version":"2.0"},"extras":"#.to_vec();
    text.extend(b"[".repeat(1_000_000));
    let e = import_bytes(&text, "deep.gltf", &ImportOptions::default()).unwrap_err();
    assert!(matches!(e, ImportError::TooLarge { limit: "json_depth", .. }), "{e}");
    // The parser has a bound of its own, whatever is asked for.
    let e = import_bytes(&text, "deep.gltf", &limited(|l| l.json_depth = u32::MAX)).unwrap_err();
    assert!(matches!(e, ImportError::Json { .. }), "{e}");
}

#[test]
fn faults_name_file_and_place() {
    let cases: [(&[u8], &str); 9] = [
        (b"", "x.gltf: byte 0: the file is empty"),
        (b"hello", "x.gltf: byte 0: neither GLB"),
        (b"{", "x.gltf: line 1, column 1 of the JSON: EOF"),
        (b"{\"asset\":{}}", "x.gltf: /asset: `version` is missing"),
        (b"{\"asset\":3}", "x.gltf: /asset: an object is needed, not a number"),
        (b"{}", "x.gltf: document: `asset` is missing"),
        (b"{\"asset\":{\"version\":\"1.0\"}}", "x.gltf: /asset/version: requires glTF 1.0, which is not supported"),
        (b"{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":-1}]}", "x.gltf: /nodes/0/mesh: a whole number"),
        (b"{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{\"a/b\":\"\"}}]}]}",
            "/meshes/0/primitives/0/attributes/a~1b: a whole number from 0 up is needed, not a string"),
    ];
    for (bytes, expected) in cases {
        let e = import_bytes(bytes, "x.gltf", &ImportOptions::default()).unwrap_err().to_string();
        assert!(e.contains(expected), "{expected} not in: {e}");
    }
}

#[test]
fn every_cut_and_every_flipped_byte_is_survived() {
    // A file with a bit of everything.
    let mut m = fan(5);
    m.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    m.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": 3, "componentType": U32},
        "values": {"bufferView": 0}
    });
    m.push("skins", json!({"joints": [0]}));
    let input = m.floats(&[0.0, 1.0], "SCALAR");
    m.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
            "samplers": [{"input": input, "output": 0}]
        }),
    );
    let glb = m.glb();
    let o = ImportOptions { at: Some(0.5), ..ImportOptions::default() };
    import_bytes(&glb, "whole.glb", &o).unwrap();
    for cut in 0..glb.len() {
        let _ = import_bytes(&glb[..cut], "cut.glb", &o);
    }
    let mut survived = 0;
    for i in 0..glb.len() {
        for flip in [1u8, 0x80, 0x10] {
            let mut b = glb.clone();
            b[i] ^= flip;
            if let Ok(i) = import_bytes(&b, "flipped.glb", &o) {
                i.scene.validate().unwrap();
                survived += 1;
            }
        }
    }
    assert!(survived > 800, "most flips in the data still give a scene: {survived}");
}
