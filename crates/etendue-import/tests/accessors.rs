//! Typed arrays: component types, normalisation, strides, sparse values, and what happens when they do not fit.
mod common;
use common::*;
use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

/// One position of a triangle as given; the other two are fixed.
fn corner(data: &(impl Bytes + ?Sized), component: u32, normalized: bool) -> Vec3 {
    let mut m = Model::new();
    let a = m.accessor(data, component, "VEC3", 3);
    m.json["accessors"][a as usize]["normalized"] = json!(normalized);
    let mesh = m.mesh(json!({"attributes": {"POSITION": a}}));
    m.node(json!({"mesh": mesh}));
    m.import().scene.meshes[0].positions[0]
}

#[test]
fn component_types_of_positions() {
    assert_eq!(
        corner(&[1.5f32, -2.0, 3e5, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0], F32, false),
        Vec3::new(1.5, -2.0, 3e5)
    );
    assert_eq!(corner(&[1i8, -2, 127, 0, 0, 0, 1, 1, 1], I8, false), Vec3::new(1.0, -2.0, 127.0));
    assert_eq!(corner(&[1u8, 2, 255, 0, 0, 0, 1, 1, 1], U8, false), Vec3::new(1.0, 2.0, 255.0));
    assert_eq!(corner(&[1i16, -2, 32767, 0, 0, 0, 1, 1, 1], I16, false), Vec3::new(1.0, -2.0, 32767.0));
    assert_eq!(corner(&[1u16, 2, 65535, 0, 0, 0, 1, 1, 1], U16, false), Vec3::new(1.0, 2.0, 65535.0));
}

#[test]
fn normalised_integers() {
    // glTF 2.0, 3.6.2.2: the smallest signed value is brought up to −1.
    assert_eq!(corner(&[-128i8, -127, 127, 0, 0, 0, 1, 1, 1], I8, true), Vec3::new(-1.0, -1.0, 1.0));
    assert_eq!(corner(&[-32768i16, 0, 32767, 0, 0, 0, 1, 1, 1], I16, true), Vec3::new(-1.0, 0.0, 1.0));
    assert_eq!(corner(&[0u8, 51, 255, 0, 0, 0, 1, 1, 1], U8, true), Vec3::new(0.0, 0.2, 1.0));
    assert_eq!(corner(&[0u16, 13107, 65535, 0, 0, 0, 1, 1, 1], U16, true), Vec3::new(0.0, 0.2, 1.0));
}

#[test]
fn index_types() {
    for (component, bytes) in
        [(U8, [2u8, 1, 0].bytes()), (U16, [2u16, 1, 0].bytes()), (U32, [2u32, 1, 0].bytes())]
    {
        let mut m = Model::new();
        let i = m.accessor(&bytes[..], component, "SCALAR", 3);
        let mesh = m.triangle(json!({}));
        m.json["meshes"][mesh as usize]["primitives"][0]["indices"] = json!(i);
        assert_eq!(m.import().scene.meshes[0].indices, [[2, 1, 0]]);
    }
    let mut m = Model::new();
    let i = m.floats(&[0.0, 1.0, 2.0], "SCALAR");
    let mesh = m.triangle(json!({}));
    m.json["meshes"][mesh as usize]["primitives"][0]["indices"] = json!(i);
    assert!(
        m.error().contains("/meshes/0/primitives/0/indices: indices are unsigned integers"),
        "{}",
        m.error()
    );
}

#[test]
fn interleaved_attributes() {
    let mut m = Model::new();
    // Position and texture coordinates, 20 bytes a vertex; the last vertex ends where the buffer ends.
    let v = m.view(
        &[[0.0f32, 0.0, 0.0, 0.1, 0.2], [1.0, 0.0, 0.0, 0.3, 0.4], [0.0, 1.0, 0.0, 0.5, 0.6]].concat()[..]
            .bytes(),
    );
    m.json["bufferViews"][v as usize]["byteStride"] = json!(20);
    let p = m.push("accessors", json!({"bufferView": v, "componentType": F32, "count": 3, "type": "VEC3"}));
    let uv = m.push(
        "accessors",
        json!({"bufferView": v, "byteOffset": 12, "componentType": F32, "count": 3, "type": "VEC2"}),
    );
    let mesh = m.mesh(json!({"attributes": {"POSITION": p, "TEXCOORD_0": uv}}));
    m.node(json!({"mesh": mesh}));
    let s = m.import().scene;
    assert_eq!(s.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(s.meshes[0].uvs, [[Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4), Vec2::new(0.5, 0.6)]]);
}

/// A triangle whose vertex 1 is replaced, over its own data or over nothing.
fn sparse(with_view: bool) -> Model {
    let mut m = Model::new();
    m.triangle(json!({}));
    let indices = m.view(&[1u16].bytes());
    let values = m.view(&[7.0f32, 8.0, 9.0].bytes());
    m.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": indices, "componentType": U16},
        "values": {"bufferView": values}
    });
    if !with_view {
        m.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    }
    m
}

#[test]
fn sparse_values_with_and_without_a_view() {
    let p = |m: Model| m.import().scene.meshes[0].positions.clone();
    assert_eq!(p(sparse(true)), [Vec3::ZERO, Vec3::new(7.0, 8.0, 9.0), Vec3::Y]);
    assert_eq!(p(sparse(false)), [Vec3::ZERO, Vec3::new(7.0, 8.0, 9.0), Vec3::ZERO]);
}

#[test]
fn sparse_values_of_picked_vertices() {
    // Only vertices 1, 3 and 4 of five are used: the replacement of 3 has to find its new place.
    let mut m = Model::new();
    let p = m.floats(&[0.0; 15], "VEC3");
    let indices = m.view(&[0u32, 3, 4].bytes());
    let values = m.view(&[9.0f32, 9.0, 9.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].bytes());
    m.json["accessors"][p as usize]["sparse"] = json!({
        "count": 3,
        "indices": {"bufferView": indices, "componentType": U32},
        "values": {"bufferView": values}
    });
    let i = m.accessor(&[4u16, 3, 1], U16, "SCALAR", 3);
    let mesh = m.mesh(json!({"attributes": {"POSITION": p}, "indices": i}));
    m.node(json!({"mesh": mesh}));
    let s = m.import().scene;
    assert_eq!(s.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(s.meshes[0].indices, [[2, 1, 0]]);
}

#[test]
fn sparse_faults_are_named() {
    let mut m = sparse(true);
    m.bytes[36] = 3;
    assert!(m.error().contains("/accessors/0/sparse/indices: index 3 is beyond"), "{}", m.error());
    let mut m = sparse(true);
    m.json["accessors"][0]["sparse"]["count"] = json!(2);
    assert!(m.error().contains("/accessors/0/sparse/indices: 2 entries"), "{}", m.error());
    let mut m = sparse(true);
    let twice = m.view(&[1u16, 1].bytes());
    let values = m.view(&[0f32; 6].bytes());
    m.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": twice, "componentType": U16},
        "values": {"bufferView": values}
    });
    assert!(m.error().contains("do not strictly increase"), "{}", m.error());
}

#[test]
fn vertex_colours() {
    let color = |data: &[u8], component: u32, shape: &str| {
        let mut m = Model::new();
        let c = m.accessor(data, component, shape, 3);
        m.json["accessors"][c as usize]["normalized"] = json!(component != F32);
        m.triangle(json!({"COLOR_0": c}));
        m.import().scene.meshes[0].colors[0]
    };
    assert_eq!(color(&[255u8, 51, 0, 0, 0, 0, 0, 0, 0], U8, "VEC3"), Vec4::new(1.0, 0.2, 0.0, 1.0));
    assert_eq!(color(&[255u8, 51, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0], U8, "VEC4"), Vec4::new(1.0, 0.2, 0.0, 0.2));
    assert_eq!(
        color(&[65535u16, 13107, 0, 0, 0, 0, 0, 0, 0].bytes(), U16, "VEC3"),
        Vec4::new(1.0, 0.2, 0.0, 1.0)
    );
    assert_eq!(color(&[0.5f32; 12].bytes(), F32, "VEC4"), Vec4::splat(0.5));
}

#[test]
fn data_that_are_not_there() {
    type Change = fn(&mut Model);
    let broken = |change: Change| {
        let mut m = Model::new();
        m.triangle(json!({}));
        change(&mut m);
        m.error()
    };
    let checks: [(Change, &str); 8] = [
        (|m| m.json["accessors"][0]["count"] = json!(4), "/accessors/0: 4 elements of 12 bytes"),
        (|m| m.json["accessors"][0]["count"] = json!(u64::MAX), "/accessors/0/count"),
        (|m| m.json["accessors"][0]["byteOffset"] = json!(u64::MAX), "/accessors/0: 3 elements"),
        (|m| m.json["bufferViews"][0]["byteLength"] = json!(37), "/bufferViews/0: 37 bytes from byte 0"),
        (|m| m.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX), "/bufferViews/0: 36 bytes"),
        (|m| m.json["bufferViews"][0]["byteStride"] = json!(4), "a stride of 4 bytes for elements of 12"),
        (
            |m| m.json["buffers"] = json!([{"byteLength": 1000}]),
            "/buffers/0/byteLength: 1000 bytes announced",
        ),
        (
            |m| m.json["accessors"][0]["bufferView"] = json!(5),
            "/accessors/0/bufferView: buffer view 5 does not exist",
        ),
    ];
    for (change, expected) in checks {
        let e = broken(change);
        assert!(e.contains(expected), "{expected} not in: {e}");
    }
}

#[test]
fn types_that_are_not_known_harm_only_what_uses_them() {
    for (key, value) in [("type", json!("VEC5")), ("componentType", json!(5124))] {
        let mut m = Model::new();
        let other = m.floats(&[0.0; 12], "VEC4");
        m.json["accessors"][other as usize][key] = value;
        let mesh = m.triangle(json!({}));
        let model = m.import();
        assert_eq!(model.scene.triangle_count(), 1);
        let place = format!("/accessors/{other}/{key}");
        assert!(model.warnings.iter().any(|w| w.pointer == place), "{:?}", model.warnings);
        m.json["meshes"][mesh as usize]["primitives"][0]["attributes"]["COLOR_0"] = json!(other);
        assert!(m.error().contains("has a type that is not known"), "{}", m.error());
    }
}
