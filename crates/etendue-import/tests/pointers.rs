//! Animations of what JSON pointers lead to, and nodes that are not shown.
mod common;
use common::*;
use etendue_import::{ImportOptions, Imported, ModelFile, import};
use etendue_scene::{LightKind, Projection};
use glam::{Quat, Vec2, Vec3};
use serde_json::{Value, json};
use std::path::Path;

/// Adds a channel that moves what `pointer` leads to from the first of the values at 0 s to the second at 2 s.
fn channel(m: &mut Model, pointer: &str, shape: &str, values: &[f32]) {
    let input = m.floats(&[0.0, 2.0], "SCALAR");
    let output = m.floats(values, shape);
    add_channel(m, pointer, json!({"input": input, "output": output}));
}

fn add_channel(m: &mut Model, pointer: &str, sampler: Value) {
    if m.json["animations"].is_null() {
        m.json["animations"] = json!([{"channels": [], "samplers": []}]);
    }
    let a = &mut m.json["animations"][0];
    let n = a["samplers"].as_array().unwrap().len();
    a["samplers"].as_array_mut().unwrap().push(sampler);
    let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
    a["channels"].as_array_mut().unwrap().push(json!({"sampler": n, "target": target}));
}

fn at(m: &Model, seconds: f32) -> Imported {
    m.import_with(&ImportOptions { at: Some(seconds), ..ImportOptions::default() })
        .unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn materials_change() {
    let mut m = with(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 0]}}}
        },
        "emissiveFactor": [1, 1, 1],
        "normalTexture": {"index": 1},
        "extensions": {
            "KHR_materials_emissive_strength": {},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0}
        }
    }));
    channel(
        &mut m,
        "/materials/0/pbrMetallicRoughness/baseColorFactor",
        "VEC4",
        &[0., 0., 0., 1., 1., 0.5, 0., 0.],
    );
    channel(&mut m, "/materials/0/pbrMetallicRoughness/roughnessFactor", "SCALAR", &[0.0, 1.0]);
    let transform =
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset";
    channel(&mut m, transform, "VEC2", &[0., 0., 4., 8.]);
    let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
    channel(&mut m, strength, "SCALAR", &[2., 6.]);
    channel(&mut m, "/materials/0/normalTexture/scale", "SCALAR", &[1., 3.]);
    let coat = "/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor";
    channel(&mut m, coat, "SCALAR", &[0., 1.]);
    let i = at(&m, 0.5);
    assert_eq!(i.warnings, []);
    let x = &i.scene.materials[0];
    assert!(x.base_color.abs_diff_eq(Vec3::new(0.25, 0.125, 0.0), 1e-6) && (x.alpha - 0.75).abs() < 1e-6);
    assert_eq!((x.roughness, x.emissive, x.normal_texture.unwrap().scale), (0.25, Vec3::splat(3.0), 1.5));
    assert_eq!(x.base_color_texture.unwrap().transform.translation, Vec2::new(1.0, 2.0));
    assert_eq!(x.extensions.as_ref().unwrap().clearcoat.unwrap().factor, 0.25);
    assert!(at(&m, 0.0).scene.materials[0].extensions.is_none(), "a coat of nothing");
    assert_eq!(m.import().scene.materials[0].roughness, 1.0, "at rest");
}

#[test]
fn lights_cameras_and_nodes_change() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}});
    m.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    m.node(json!({"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    channel(&mut m, "/extensions/KHR_lights_punctual/lights/0/intensity", "SCALAR", &[1., 3.]);
    channel(&mut m, "/extensions/KHR_lights_punctual/lights/0/color", "VEC3", &[1., 0., 0., 0., 1., 0.]);
    channel(&mut m, "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", "SCALAR", &[0.5, 1.5]);
    channel(&mut m, "/cameras/0/perspective/yfov", "SCALAR", &[0.5, 1.5]);
    channel(&mut m, "/cameras/0/perspective/znear", "SCALAR", &[0.5, 1.5]);
    channel(&mut m, "/nodes/0/translation", "VEC3", &[0., 0., 0., 2., 0., 0.]);
    let (q, r) = (Quat::from_rotation_x(0.0), -Quat::from_rotation_x(1.0));
    channel(&mut m, "/nodes/1/rotation", "VEC4", &[q.to_array(), r.to_array()].concat());
    let i = at(&m, 1.0);
    assert_eq!(i.warnings, []);
    let l = &i.scene.lights[0];
    assert_eq!(l.intensity, Vec3::new(1.0, 1.0, 0.0));
    assert!(matches!(l.kind, LightKind::Spot { outer, .. } if (outer - 1.0).abs() < 1e-6));
    assert_eq!(i.scene.cameras[0].projection, Projection::Perspective { yfov: 1.0 });
    assert_eq!(i.scene.instances[0].transform.translation.x, 1.0);
    let (sin, cos) = 0.5f32.sin_cos();
    assert!(l.direction.abs_diff_eq(Vec3::new(0.0, sin, -cos), 1e-6), "the short way round: {}", l.direction);
}

#[test]
fn weights_change_one_by_one_or_all_of_a_mesh() {
    let mut m = Model::new();
    m.triangle(json!({}));
    let d = m.floats(&[1., 0., 0.].repeat(3), "VEC3");
    m.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": d}, {"POSITION": d}]);
    m.json["meshes"][0]["weights"] = json!([0.0, 0.25]);
    m.node(json!({"mesh": 0, "weights": [0, 0]}));
    let x = |m: &Model, k: usize| {
        let s = at(m, 1.0).scene;
        s.meshes[s.instances[k].mesh as usize].positions[0].x
    };
    let mut one = Model { json: m.json.clone(), bytes: m.bytes.clone() };
    channel(&mut one, "/meshes/0/weights/0", "SCALAR", &[0., 1.]);
    channel(&mut one, "/nodes/1/weights/1", "SCALAR", &[0., 4.]);
    assert_eq!((x(&one, 0), x(&one, 1)), (0.75, 2.0));
    channel(&mut m, "/meshes/0/weights", "SCALAR", &[0., 0., 1., 2.]);
    assert_eq!((x(&m, 0), x(&m, 1)), (1.5, 0.0), "a node's own weights go first");
}

#[test]
fn what_is_hidden_is_hidden_with_all_below_it() {
    let mut m = Model::new();
    m.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    m.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    let mesh = m.triangle(json!({}));
    m.node(json!({"mesh": mesh, "name": "parent", "children": [2]}));
    let hidden = |v| json!({"KHR_node_visibility": {"visible": v}, "KHR_lights_punctual": {"light": 0}});
    m.push("nodes", json!({"mesh": mesh, "camera": 0, "extensions": hidden(true)}));
    let counts = |i: &Imported| (i.scene.instances.len(), i.scene.lights.len(), i.scene.cameras.len());
    assert_eq!(counts(&m.import()), (3, 1, 1));
    m.json["nodes"][1]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    let i = m.import();
    assert_eq!((counts(&i), &i.warnings[..]), ((1, 0, 1), &[][..]), "a camera is not seen in any case");
    let input = m.floats(&[0.0, 1.0, 2.0], "SCALAR");
    let output = m.accessor(&[0u8, 1, 0], U8, "SCALAR", 3);
    let sampler = json!({"input": input, "output": output, "interpolation": "STEP"});
    add_channel(&mut m, "/nodes/1/extensions/KHR_node_visibility/visible", sampler);
    assert_eq!([0.5, 1.0, 1.9, 2.0].map(|t| counts(&at(&m, t)).0), [1, 3, 3, 1]);
}

#[test]
fn what_is_not_known_is_named() {
    let mut m = with(json!({}));
    for pointer in [
        "/materials/0/normalTexture/offset",
        "/materials/9/alphaCutoff",
        "/materials/0/occlusionTexture/strength",
        "nonsense",
    ] {
        channel(&mut m, pointer, "SCALAR", &[0., 1.]);
    }
    channel(&mut m, "/materials/0/alphaCutoff", "SCALAR", &[f32::NAN, 1.]);
    let i = at(&m, 1.0);
    for text in [
        "channels/0: animates `/materials/0/normalTexture/offset`, which is no property that is known; ignored",
        "channels/1: animates `/materials/9/alphaCutoff`, which is not in the file; ignored",
        "/materials/0/occlusionTexture/strength: is animated, but it belongs to an object that is not there",
        "channels/3: animates `nonsense`",
        "channels/4: the animation gives values that are not finite",
    ] {
        assert!(warned(&i, text), "{text}: {:?}", i.warnings);
    }
    assert_eq!(i.warnings.len(), 5);
    channel(&mut m, "/materials/0/emissiveFactor", "SCALAR", &[0., 1.]);
    let e =
        m.import_with(&ImportOptions { at: Some(0.0), ..ImportOptions::default() }).unwrap_err().to_string();
    assert!(e.contains("needs VEC3"), "{e}");
}

/// Blender's file in which everything is animated: all pointers but one lead somewhere, and things change.
#[test]
fn everything_at_once() {
    let path = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets/models/bio-24_animation_pointer/24_animation_pointer.gltf"
    ));
    if !path.exists() {
        return println!("skipped: no {}", path.display());
    }
    let i = import(path, &ImportOptions { at: Some(4.0), ..ImportOptions::default() }).unwrap();
    let about: Vec<_> = i.warnings.iter().filter(|w| w.message.contains("animat")).collect();
    assert_eq!(about.len(), 1, "{about:?}");
    assert!(about[0].message.contains("`/materials/5/normalTexture/offset`"));
    let file = ModelFile::read(path, &ImportOptions::default()).unwrap();
    let model = file.open().unwrap();
    assert_eq!(model.duration().unwrap().map(|d| *d.end() as f32), Some(10.016_666));
    let [a, b] = [1.0, 6.0].map(|t| model.at(Some(t)).unwrap().scene);
    let named = |s: &etendue_scene::Scene, n: &str| format!("{:?}", s.materials.iter().find(|m| m.name == n));
    let changed = a.materials.iter().filter(|m| named(&a, &m.name) != named(&b, &m.name)).count();
    assert!(changed >= 8, "{changed} materials change");
    assert_ne!(format!("{:?}", a.lights), format!("{:?}", b.lights));
    assert_ne!(format!("{:?}", a.cameras), format!("{:?}", b.cameras));
}
