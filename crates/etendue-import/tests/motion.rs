//! Animations, morph targets and skins at a moment.
mod common;
use common::*;
use etendue_import::{AnimationChoice, ImportOptions};
use glam::{Affine3A, Quat, Vec3, Vec4};
use serde_json::json;

fn at(seconds: f32) -> ImportOptions {
    ImportOptions { at: Some(seconds), ..ImportOptions::default() }
}

/// A triangle whose node is moved along `path` by two keyframes at 1 s and 3 s.
fn animated(path: &str, interpolation: &str, values: &[f32]) -> Model {
    let mut m = Model::new();
    m.triangle(json!({}));
    let input = m.floats(&[1.0, 3.0], "SCALAR");
    let shape = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    let output = m.floats(values, shape);
    m.push(
        "animations",
        json!({
            "name": "go",
            "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
        }),
    );
    m
}

fn transform(m: &Model, seconds: f32) -> Affine3A {
    m.import_with(&at(seconds)).unwrap().scene.instances[0].transform
}

fn x(m: &Model, seconds: f32) -> f32 {
    transform(m, seconds).translation.x
}

#[test]
fn steps_and_lines_hold_at_the_ends() {
    let m = animated("translation", "STEP", &[10., 0., 0., 20., 0., 0.]);
    assert_eq!([0.0, 1.0, 2.9, 3.0, 99.0].map(|t| x(&m, t)), [10., 10., 10., 20., 20.]);
    let m = animated("translation", "LINEAR", &[10., 0., 0., 20., 0., 0.]);
    assert_eq!([-5.0, 1.0, 1.5, 2.0, 3.0, 99.0].map(|t| x(&m, t)), [10., 10., 12.5, 15., 20., 20.]);
    assert_eq!(x(&m, f32::NAN), 10.0);
    assert_eq!(m.import().scene.instances[0].transform, Affine3A::IDENTITY, "at rest without `at`");
}

#[test]
fn cubic_splines_by_their_formula() {
    // In-tangent, value, out-tangent per key; glTF 2.0, appendix C.5, with t = ¼ and 2 s between the keys.
    let zero = [0.0; 2];
    let key = |a: f32, v: f32, b: f32| [[a].as_slice(), &zero, &[v], &zero, &[b], &zero].concat();
    let m = animated("translation", "CUBICSPLINE", &[key(9., 10., 2.), key(-1., 20., 9.)].concat());
    let (t, td) = (0.25f32, 2.0f32);
    let (t2, t3) = (t * t, t * t * t);
    let expected =
        (2.0 * t3 - 3.0 * t2 + 1.0) * 10.0 + td * (t3 - 2.0 * t2 + t) * 2.0 + (-2.0 * t3 + 3.0 * t2) * 20.0
            - td * (t3 - t2);
    assert!((x(&m, 1.5) - expected).abs() < 1e-5);
    assert_eq!([0.0, 1.0, 3.0, 4.0].map(|s| x(&m, s)), [10., 10., 20., 20.]);
}

#[test]
fn rotations_go_the_short_way() {
    let q = Quat::from_rotation_y(0.2);
    let r = -Quat::from_rotation_y(1.0);
    let m = animated("rotation", "LINEAR", &[q.to_array(), r.to_array()].concat());
    let expected = Affine3A::from_rotation_y(0.6);
    assert!(transform(&m, 2.0).abs_diff_eq(expected, 1e-6));
}

#[test]
fn scales_and_the_rest_of_the_node_stay() {
    let mut m = animated("scale", "LINEAR", &[1., 1., 1., 3., 3., 3.]);
    m.json["nodes"][0]["translation"] = json!([7, 0, 0]);
    let expected =
        Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), Quat::IDENTITY, Vec3::new(7., 0., 0.));
    assert!(transform(&m, 2.0).abs_diff_eq(expected, 1e-6));
}

#[test]
fn choosing_animations() {
    let mut m = animated("translation", "LINEAR", &[1., 0., 0., 1., 0., 0.]);
    let output = m.floats(&[2., 0., 0., 2., 0., 0.], "VEC3");
    let mut second = m.json["animations"][0].clone();
    second["name"] = json!("other");
    second["samplers"][0]["output"] = json!(output);
    m.push("animations", second);
    let x = |animation: AnimationChoice| {
        let o = ImportOptions { animation, ..at(2.0) };
        m.import_with(&o).map(|i| i.scene.instances[0].transform.translation.x)
    };
    assert_eq!(x(AnimationChoice::First).unwrap(), 1.0);
    assert_eq!(x(AnimationChoice::Index(1)).unwrap(), 2.0);
    assert_eq!(x(AnimationChoice::Name("other".into())).unwrap(), 2.0);
    assert_eq!(x(AnimationChoice::All).unwrap(), 2.0);
    let e = x(AnimationChoice::Name("dance".into())).unwrap_err().to_string();
    assert!(e.contains("no animation `dance`; the file has 0 `go`, 1 `other`"), "{e}");
    assert!(x(AnimationChoice::Index(2)).is_err());
}

#[test]
fn broken_animations_are_named() {
    let m = animated("translation", "CUBICSPLINE", &[0.0; 15]);
    let e = m.import_with(&at(0.0)).unwrap_err().to_string();
    assert!(e.contains("/animations/0/channels/0/sampler: 5 values for 2 keyframes that need 6"), "{e}");
    let m = animated("translation", "LINEAR", &[f32::NAN; 6]);
    let i = m.import_with(&at(2.0)).unwrap();
    assert!(warned(&i, "values that are not finite; ignored"));
    assert_eq!(i.scene.instances[0].transform, Affine3A::IDENTITY);
    let mut m = animated("translation", "LINEAR", &[1.0; 6]);
    m.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    assert!(warned(&m.import_with(&at(2.0)).unwrap(), "placed by a matrix"));
    assert!(warned(&Model::new().import_with(&at(2.0)).unwrap(), "no animation; shown at rest"));
}

/// A triangle with normals and two morph targets: one moves vertex 0 along X and bends normals, the other moves all
/// along Z and is sparse.
fn morphing() -> Model {
    let mut m = Model::new();
    let n = m.floats(&[0., 0., 1.].repeat(3), "VEC3");
    m.triangle(json!({"NORMAL": n}));
    let dx = m.floats(&[1., 0., 0., 0., 0., 0., 0., 0., 0.], "VEC3");
    let dn = m.floats(&[1., 0., 0., 0., 0., 0., 0., 0., 0.], "VEC3");
    let indices = m.view(&[2u16].bytes());
    let values = m.view(&[0.0f32, 0.0, 5.0].bytes());
    let dz = m.push(
        "accessors",
        json!({"componentType": F32, "count": 3, "type": "VEC3", "sparse": {
            "count": 1,
            "indices": {"bufferView": indices, "componentType": U16},
            "values": {"bufferView": values}
        }}),
    );
    m.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": dx, "NORMAL": dn}, {"POSITION": dz}]);
    m
}

#[test]
fn morph_weights_of_mesh_node_and_animation() {
    let mut m = morphing();
    let p = |m: &Model, o: &ImportOptions| m.import_with(o).unwrap().scene.meshes[0].positions.clone();
    let rest = ImportOptions::default();
    assert_eq!(p(&m, &rest)[0], Vec3::ZERO, "no weights are zero");
    m.json["meshes"][0]["weights"] = json!([1, 0]);
    let mesh = m.import().scene.meshes.remove(0);
    assert_eq!(mesh.positions, [Vec3::X, Vec3::X, Vec3::Y]);
    assert!((mesh.normals[0] - Vec3::new(1., 0., 1.).normalize()).length() < 1e-6);
    m.json["nodes"][0]["weights"] = json!([0, 0.5]);
    assert_eq!(p(&m, &rest), [Vec3::ZERO, Vec3::X, Vec3::new(0., 1., 2.5)]);
    // Two weights per keyframe.
    let input = m.floats(&[0.0, 1.0], "SCALAR");
    let output = m.floats(&[0., 0., 2., 4.], "SCALAR");
    m.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": input, "output": output}]
        }),
    );
    assert_eq!(p(&m, &at(0.5)), [Vec3::X, Vec3::X, Vec3::new(0., 1., 10.)]);
}

#[test]
fn equal_weights_share_a_mesh_and_others_do_not() {
    let mut m = morphing();
    m.node(json!({"mesh": 0, "weights": [1, 0]}));
    m.node(json!({"mesh": 0, "weights": [1, 0]}));
    m.node(json!({"mesh": 0, "weights": [0.5, 0]}));
    let s = m.import().scene;
    assert_eq!((s.meshes.len(), s.instances.len()), (3, 4));
}

/// A triangle on a skin of two joints; vertex 0 hangs on joint 0, vertex 1 on joint 1, vertex 2 half on each.
fn skinned() -> Model {
    let mut m = Model::new();
    let joints = m.accessor(&[0u8, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0], U8, "VEC4", 3);
    // Twice as large as they should be: they are to sum to one.
    let weights = m.floats(&[2., 0., 0., 0., 2., 0., 0., 0., 1., 1., 0., 0.], "VEC4");
    let n = m.floats(&[0., 0., 1.].repeat(3), "VEC3");
    m.triangle(json!({"JOINTS_0": joints, "WEIGHTS_0": weights, "NORMAL": n}));
    let mut ibm = vec![0.0; 32];
    for j in 0..2 {
        for k in 0..4 {
            ibm[16 * j + 5 * k] = 1.0;
        }
    }
    ibm[16 + 12] = -1.0;
    let ibm = m.floats(&ibm, "MAT4");
    let a = m.node(json!({"translation": [0, 0, 3]}));
    let b = m.node(json!({"translation": [1, 10, 0]}));
    m.push("skins", json!({"joints": [a, b], "inverseBindMatrices": ibm}));
    m.json["nodes"][0]["skin"] = json!(0);
    // Which a skin must ignore.
    m.json["nodes"][0]["translation"] = json!([100, 100, 100]);
    m
}

#[test]
fn joints_carry_vertices_and_the_node_does_not() {
    let s = skinned().import().scene;
    assert_eq!(s.instances[0].transform, Affine3A::IDENTITY);
    // Joint 0 moves by (0,0,3); joint 1 by (1,10,0) after (−1,0,0).
    assert_eq!(
        s.meshes[0].positions,
        [Vec3::new(0., 0., 3.), Vec3::new(1., 10., 0.), Vec3::new(0., 6., 1.5)]
    );
}

#[test]
fn joints_turn_normals_and_mirroring_turns_the_winding() {
    let mut m = skinned();
    let turned = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2).to_array();
    for joint in 1..=2 {
        m.json["nodes"][joint]["rotation"] = json!(turned);
        m.json["nodes"][joint]["scale"] = json!([1, 1, 4]);
    }
    let mesh = m.import().scene.meshes.remove(0);
    assert!(mesh.normals.iter().all(|n| (*n - Vec3::NEG_Y).length() < 1e-6), "{:?}", mesh.normals);
    assert_eq!(mesh.indices, [[0, 1, 2]]);
    for joint in 1..=2 {
        m.json["nodes"][joint]["scale"] = json!([-1, 1, 1]);
    }
    let mesh = m.import().scene.meshes.remove(0);
    assert_eq!(mesh.indices, [[0, 2, 1]]);
    assert!(mesh.normals.iter().all(|n| (*n - Vec3::NEG_Y).length() < 1e-6), "{:?}", mesh.normals);
}

#[test]
fn more_than_four_joints() {
    let mut m = skinned();
    let j1 = m.accessor(&[1u16, 0, 0, 0].repeat(3)[..], U16, "VEC4", 3);
    let w1 = m.floats(&[2., 0., 0., 0.].repeat(3), "VEC4");
    let a = &mut m.json["meshes"][0]["primitives"][0]["attributes"];
    a["JOINTS_1"] = json!(j1);
    a["WEIGHTS_1"] = json!(w1);
    let s = m.import().scene;
    // Half joint 0, half joint 1.
    assert_eq!(s.meshes[0].positions[0], Vec3::new(0.0, 5.0, 1.5));
}

#[test]
fn skins_that_do_not_fit() {
    let mut m = skinned();
    m.json["skins"][0]["joints"] = json!([1]);
    assert!(m.error().contains("vertex 1 hangs on joint 1; the skin has 1"), "{}", m.error());
    m.json["skins"][0]["joints"] = json!([1, 2, 2]);
    assert!(m.error().contains("/skins/0/inverseBindMatrices: 2 matrices for 3 joints"), "{}", m.error());
    m.json["skins"][0]["joints"] = json!([1, 9]);
    assert!(m.error().contains("/skins/0/joints/1: node 9 does not exist"), "{}", m.error());
    let mut m = skinned();
    m.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("JOINTS_0");
    let i = m.import();
    assert!(warned(&i, "has no joints and weights; placed by its node"));
    assert_eq!(i.scene.instances[0].transform.translation.x, 100.0);
}

#[test]
fn skinned_and_morphed_meshes_get_tangents_afterwards() {
    let mut m = skinned();
    let uv = m.floats(&[0., 1., 1., 1., 0., 0.], "VEC2");
    m.push("images", json!({"uri": data_uri(&png())}));
    m.push("textures", json!({"source": 0}));
    m.push("materials", json!({"normalTexture": {"index": 0}}));
    let p = &mut m.json["meshes"][0]["primitives"][0];
    p["attributes"]["TEXCOORD_0"] = json!(uv);
    p["material"] = json!(0);
    for joint in 1..=2 {
        m.json["nodes"][joint] =
            json!({"rotation": Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array()});
    }
    m.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    let mesh = m.import().scene.meshes.remove(0);
    for t in &mesh.tangents {
        assert!((t - Vec4::new(0., 1., 0., 1.)).length() < 1e-6, "{t}");
    }
}
