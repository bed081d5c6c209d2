//! Primitives become meshes: modes, sharing, cleaning, tangents.
mod common;
use common::*;
use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

/// Five points in a row of unit steps, alternating between y = 0 and y = 1: a strip.
fn zigzag(m: &mut Model) -> u32 {
    let p: Vec<f32> = (0..5).flat_map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
    m.floats(&p, "VEC3")
}

fn mode(mode: u32) -> Vec<[u32; 3]> {
    let mut m = Model::new();
    let p = zigzag(&mut m);
    let mesh = m.mesh(json!({"attributes": {"POSITION": p}, "mode": mode}));
    m.node(json!({"mesh": mesh}));
    let i = m.import();
    i.scene.meshes.first().map(|m| m.indices.clone()).unwrap_or_default()
}

#[test]
fn strips_keep_their_winding() {
    // glTF 2.0, 3.7.2.1.
    assert_eq!(mode(5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    let s = mode(5);
    let p: Vec<Vec3> = (0..5).map(|i| Vec3::new(i as f32, (i % 2) as f32, 0.0)).collect();
    for t in s {
        let [a, b, c] = t.map(|i| p[i as usize]);
        assert!((b - a).cross(c - a).z < 0.0, "all face the same way");
    }
}

#[test]
fn fans_turn_around_their_first_vertex() {
    assert_eq!(mode(6), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
}

#[test]
fn a_list_leaves_out_what_makes_no_triangle() {
    assert_eq!(mode(4), [[0, 1, 2]]);
}

/// How many balls or tubes the modes of points and lines make of the zigzag's vertices, and how they are lit.
#[test]
fn points_and_lines_are_balls_and_tubes() {
    for (mode, strokes, triangles, name) in
        [(0, 5, 12, "points"), (1, 2, 24, "lines"), (2, 5, 24, "line loop"), (3, 4, 24, "line strip")]
    {
        let mut m = Model::new();
        let p = zigzag(&mut m);
        let mesh = m.mesh(json!({"attributes": {"POSITION": p}, "mode": mode}));
        m.node(json!({"mesh": mesh}));
        let i = m.import();
        assert_eq!(i.scene.meshes[0].indices.len(), strokes * triangles, "{name}");
        assert_eq!(i.info.meshes[0].primitives[0].mode, name);
        // Without normals they are shown as they are, without light.
        let material = i.scene.instances[0].material.expect("a material");
        assert!(i.scene.materials[material as usize].unlit);
        assert!(i.info.unusual.iter().any(|w| w.message.contains("balls and tubes")));
    }
    let mut m = Model::new();
    let (p, n) = (zigzag(&mut m), m.floats(&[0.0, 0.0, 1.0].repeat(5), "VEC3"));
    let mesh = m.mesh(json!({"attributes": {"POSITION": p, "NORMAL": n}, "mode": 3}));
    m.node(json!({"mesh": mesh}));
    let i = m.import();
    assert_eq!(i.scene.instances[0].material, None);
    assert_eq!(i.scene.meshes[0].normals.len(), i.scene.meshes[0].positions.len());
}

#[test]
fn equal_geometry_is_one_mesh() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.node(json!({"mesh": 0, "translation": [1, 2, 3]}));
    // Another primitive with the same data and another material.
    m.push("materials", json!({}));
    let mesh = m.mesh(json!({"attributes": {"POSITION": 0}, "material": 0}));
    m.node(json!({"mesh": mesh}));
    let s = m.import().scene;
    assert_eq!((s.meshes.len(), s.instances.len()), (1, 3));
    assert_eq!(s.instances.iter().map(|i| i.material).collect::<Vec<_>>(), [None, None, Some(0)]);
}

#[test]
fn unused_vertices_are_left_out() {
    let mut m = Model::new();
    let p: Vec<f32> = (0..300).map(|i| i as f32 * i as f32).collect();
    let p = m.floats(&p, "VEC3");
    let i = m.accessor(&[99u16, 7, 50], U16, "SCALAR", 3);
    let mesh = m.mesh(json!({"attributes": {"POSITION": p}, "indices": i}));
    m.node(json!({"mesh": mesh}));
    let s = m.import().scene;
    assert_eq!(s.meshes[0].positions.len(), 3);
    let [c, a, b] = s.meshes[0].indices[0].map(|i| s.meshes[0].positions[i as usize].x);
    assert_eq!((a, b, c), (21.0 * 21.0, 150.0 * 150.0, 297.0 * 297.0));
}

#[test]
fn an_index_beyond_the_vertices_is_an_error() {
    let mut m = Model::new();
    let i = m.accessor(&[0u16, 1, 3], U16, "SCALAR", 3);
    let mesh = m.triangle(json!({}));
    m.json["meshes"][mesh as usize]["primitives"][0]["indices"] = json!(i);
    assert!(m.error().contains("/accessors/0: entry 2 is vertex 3, but"), "{}", m.error());
}

#[test]
fn what_is_not_finite_never_gets_in() {
    let mut m = Model::new();
    let n = f32::NAN;
    let p = m.floats(
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, n, 0.0, 0.0, 1.0, f32::INFINITY, 0.0, 0.0, 0.0, 1.0],
        "VEC3",
    );
    let normals =
        m.floats(&[n, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3");
    let uv = m.floats(&[n, 0.0, 0.5, 0.5, 0.25, f32::NEG_INFINITY, 0., 0., 0., 0., 0., 0.], "VEC2");
    let c =
        m.floats(&[n, 0.0, 0.0, 2.0, -1.0, 0.5, 0.1, 0.2, 0.3, 0., 0., 0., 0., 0., 0., 0., 0., 0.], "VEC3");
    let mesh =
        m.mesh(json!({"attributes": {"POSITION": p, "NORMAL": normals, "TEXCOORD_0": uv, "COLOR_0": c}}));
    m.node(json!({"mesh": mesh}));
    let i = m.import();
    let mesh = &i.scene.meshes[0];
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(
        mesh.normals,
        [Vec3::Z, Vec3::Z, Vec3::Z],
        "two replaced by the face's, one made a unit vector"
    );
    assert_eq!(mesh.uvs[0], [Vec2::ZERO, Vec2::splat(0.5), Vec2::ZERO]);
    assert_eq!(mesh.colors, [Vec4::ONE, Vec4::new(1.0, 0.0, 0.5, 1.0), Vec4::new(0.1, 0.2, 0.3, 1.0)]);
    for text in [
        "1 triangles with positions that are not finite",
        "2 normals without a direction",
        "2 texture coordinates",
        "1 vertex colours that are not finite",
        "1 vertex colours outside",
    ] {
        assert!(warned(&i, text), "{text}: {:?}", i.warnings);
    }
}

#[test]
fn an_attribute_of_another_length_is_left_out() {
    let mut m = Model::new();
    let n = m.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0], "VEC3");
    m.triangle(json!({"NORMAL": n}));
    let i = m.import();
    assert!(i.scene.meshes[0].normals.is_empty());
    assert!(warned(&i, "/attributes/NORMAL: NORMAL has 2 entries for 3 positions"), "{:?}", i.warnings);
}

/// A quad of two triangles in the xy plane with texture coordinates by `uv`, and a material with a normal texture.
fn normal_mapped(uv: impl Fn(f32, f32) -> [f32; 2], normals: bool, texture: serde_json::Value) -> Model {
    let mut m = Model::new();
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let p: Vec<f32> = corners.iter().flat_map(|&[x, y]| [x, y, 0.0]).collect();
    let t: Vec<f32> = corners.iter().flat_map(|&[x, y]| uv(x, y)).collect();
    let mut attributes = json!({"POSITION": m.floats(&p, "VEC3"), "TEXCOORD_0": m.floats(&t, "VEC2")});
    if normals {
        attributes["NORMAL"] = json!(m.floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3"));
    }
    let i = m.accessor(&[0u8, 1, 2, 0, 2, 3], U8, "SCALAR", 6);
    m.push("images", json!({"uri": data_uri(&png())}));
    m.push("textures", json!({"source": 0}));
    m.push("materials", json!({"normalTexture": texture}));
    let mesh = m.mesh(json!({"attributes": attributes, "indices": i, "material": 0}));
    m.node(json!({"mesh": mesh}));
    m
}

/// The tangent at every corner, which must all agree.
fn tangent(m: &Model) -> Vec4 {
    let s = m.import().scene;
    let mesh = &s.meshes[0];
    assert_eq!(mesh.tangents.len(), mesh.positions.len());
    let first = mesh.tangents[0];
    assert!(mesh.tangents.iter().all(|t| (*t - first).length() < 1e-6), "{:?}", mesh.tangents);
    first
}

#[test]
fn generated_tangents_follow_u_and_the_picture_up() {
    let plain = json!({"index": 0});
    // v points down the picture: with v = 1 − y the picture stands upright, and its up is +Y = cross(Z, X) · 1.
    assert_eq!(
        tangent(&normal_mapped(|x, y| [x, 1.0 - y], true, plain.clone())),
        Vec4::new(1.0, 0.0, 0.0, 1.0)
    );
    // Upside down: up is −Y, so the sign turns over.
    assert_eq!(tangent(&normal_mapped(|x, y| [x, y], true, plain.clone())), Vec4::new(1.0, 0.0, 0.0, -1.0));
    // Mirrored and turned.
    assert_eq!(
        tangent(&normal_mapped(|x, y| [1.0 - x, 1.0 - y], true, plain.clone())),
        Vec4::new(-1.0, 0.0, 0.0, -1.0)
    );
    assert_eq!(tangent(&normal_mapped(|x, y| [y, x], true, plain)), Vec4::new(0.0, 1.0, 0.0, 1.0));
}

#[test]
fn generated_tangents_follow_the_texture_transform() {
    let turned = json!({"index": 0, "extensions": {"KHR_texture_transform": {"rotation": std::f32::consts::FRAC_PI_2}}});
    // Along +u of the picture after turning (u, v) by a quarter counter-clockwise: u' = v, v' = −u.
    let t = tangent(&normal_mapped(|x, y| [x, 1.0 - y], true, turned));
    assert!((t - Vec4::new(0.0, -1.0, 0.0, 1.0)).length() < 1e-6, "{t}");
}

#[test]
fn flat_faces_get_normals_and_tangents_when_a_normal_map_needs_them() {
    let m = normal_mapped(|x, y| [x, 1.0 - y], false, json!({"index": 0}));
    let s = m.import().scene;
    let mesh = &s.meshes[0];
    assert_eq!((mesh.positions.len(), mesh.normals.len()), (6, 6), "a vertex of its own per corner");
    assert!(mesh.normals.iter().all(|n| *n == Vec3::Z));
    assert_eq!(tangent(&m), Vec4::new(1.0, 0.0, 0.0, 1.0));
}

#[test]
fn without_a_normal_map_nothing_is_made_up() {
    let mut m = normal_mapped(|x, y| [x, y], false, json!({"index": 0}));
    m.json["materials"][0] = json!({});
    let s = m.import().scene;
    assert!(s.meshes[0].normals.is_empty() && s.meshes[0].tangents.is_empty());
    assert_eq!(s.meshes[0].positions.len(), 4);
}

#[test]
fn mirrored_halves_split_their_seam() {
    // Texture mirrored at x = 1: the vertices on the seam need two tangents.
    let mut m = normal_mapped(|x, y| [x, 1.0 - y], true, json!({"index": 0}));
    let p = m.floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0., 2., 0., 0., 2., 1., 0.], "VEC3");
    let t = m.floats(&[0., 1., 1., 1., 1., 0., 0., 0., 0., 1., 0., 0.], "VEC2");
    let n = m.floats(&[0., 0., 1.].repeat(6), "VEC3");
    let i = m.accessor(&[0u8, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2], U8, "SCALAR", 12);
    m.json["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": p, "TEXCOORD_0": t, "NORMAL": n}, "indices": i, "material": 0});
    let s = m.import().scene;
    let mesh = &s.meshes[0];
    assert_eq!(mesh.positions.len(), 8, "vertices 1 and 2 twice");
    for (n, t) in mesh.indices.iter().enumerate() {
        let expected = if n < 2 { Vec4::new(1., 0., 0., 1.) } else { Vec4::new(-1., 0., 0., -1.) };
        for i in t {
            assert_eq!(mesh.tangents[*i as usize], expected, "triangle {n}");
        }
    }
}

#[test]
fn tangents_of_the_file_are_kept_and_those_without_normals_are_not() {
    let mut m = normal_mapped(|x, y| [x, y], true, json!({"index": 0}));
    let t = m.floats(&[0.0, 3.0, 0.0, 0.5].repeat(4), "VEC4");
    m.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(t);
    assert_eq!(tangent(&m), Vec4::new(0.0, 1.0, 0.0, 1.0));
    m.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    assert_eq!(tangent(&m), Vec4::new(1.0, 0.0, 0.0, -1.0), "generated for the flat normals");
}

#[test]
fn progress_counts_what_is_ready() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.triangle(json!({}));
    let progress = std::sync::Arc::new(etendue_import::ImportProgress::default());
    let options = etendue_import::ImportOptions { progress: Some(progress.clone()), ..Default::default() };
    let model = m.import_with(&options).expect("two triangles");
    assert_eq!((progress.done(), progress.total()), (2, 2), "{} meshes", model.scene.meshes.len());
    // It goes on with the next model.
    m.import_with(&options).expect("two triangles");
    assert_eq!((progress.done(), progress.total()), (4, 4));
}
