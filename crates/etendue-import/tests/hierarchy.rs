//! Where things stand: transforms, scenes, instancing, cameras, lights.
mod common;
use common::*;
use etendue_scene::{LightKind, Projection};
use glam::{Affine3A, Quat, Vec3, Vec3A};
use serde_json::json;

fn close(a: Affine3A, b: Affine3A) {
    assert!(a.abs_diff_eq(b, 1e-5), "{a:?}\n{b:?}");
}

#[test]
fn transforms_are_chained() {
    let mut m = Model::new();
    m.triangle(json!({}));
    // A mirrored, uneven parent over a turned child over a matrix.
    m.push("nodes", json!({"matrix": [2,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1], "mesh": 0}));
    let h = std::f32::consts::FRAC_1_SQRT_2;
    m.push("nodes", json!({"rotation": [0, h, 0, h], "children": [1]}));
    m.node(json!({"translation": [1, 2, 3], "scale": [-1, 2, 3], "children": [2]}));
    let s = m.import().scene;
    let expected = Affine3A::from_scale_rotation_translation(
        Vec3::new(-1., 2., 3.),
        Quat::IDENTITY,
        Vec3::new(1., 2., 3.),
    ) * Affine3A::from_quat(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2))
        * Affine3A::from_scale_rotation_translation(
            Vec3::new(2., 1., 1.),
            Quat::IDENTITY,
            Vec3::new(5., 6., 7.),
        );
    close(s.instances[1].transform, expected);
    assert!(s.instances[1].transform.matrix3.determinant() < 0.0, "mirrored");
    assert_eq!(s.meshes.len(), 1);
}

#[test]
fn only_the_default_scene_is_shown() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.push("nodes", json!({"mesh": 0, "name": "hidden"}));
    m.push("scenes", json!({"nodes": [1]}));
    assert_eq!(m.import().scene.instances.len(), 1);
    m.json["scene"] = json!(1);
    assert_eq!(m.import().scene.instances[0].name, "hidden");
    m.json.as_object_mut().unwrap().remove("scene");
    assert_ne!(m.import().scene.instances[0].name, "hidden", "the first scene when none is named");
    m.json.as_object_mut().unwrap().remove("scenes");
    let i = m.import();
    assert_eq!(i.scene.instances.len(), 2, "all when there is no scene");
    assert!(warned(&i, "no scene"));
}

#[test]
fn files_with_nothing_to_see_load() {
    assert!(Model::new().import().scene.instances.is_empty());
    let mut m = Model::new();
    m.json["scenes"] = json!([{}]);
    m.json["scene"] = json!(0);
    assert!(m.import().scene.instances.is_empty());
}

#[test]
fn broken_hierarchies_are_errors() {
    let error = |nodes: serde_json::Value| {
        let mut m = Model::new();
        m.json["nodes"] = nodes;
        m.error()
    };
    let e = error(json!([{"children": [1]}, {"children": [2]}, {"children": [1]}]));
    assert!(e.contains("/nodes/2/children/0: node 1 is already a child of node 0"), "{e}");
    let e = error(json!([{}, {"children": [2]}, {"children": [1]}]));
    assert!(e.contains("/nodes/1: the node is on a cycle"), "{e}");
    let e = error(json!([{"children": [0]}]));
    assert!(e.contains("/nodes/0: the node is on a cycle"), "{e}");
    let e = error(json!([{"children": [7]}]));
    assert!(e.contains("/nodes/0/children/0: node 7 does not exist; the file has 1"), "{e}");
}

#[test]
fn depth_takes_no_stack() {
    let n = 50_000;
    let mut m = Model::new();
    m.triangle(json!({}));
    let chain: Vec<_> =
        (1..=n)
            .map(|i| {
                if i < n {
                    json!({"children": [i + 1], "translation": [1, 0, 0]})
                } else {
                    json!({"mesh": 0})
                }
            })
            .collect();
    m.json["nodes"].as_array_mut().unwrap().extend(chain);
    m.json["scenes"][0]["nodes"] = json!([1]);
    let s = m.import().scene;
    assert_eq!(s.instances[0].transform.translation, Vec3A::new((n - 1) as f32, 0.0, 0.0));
}

#[test]
fn transforms_that_overflow_are_left_out() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.json["nodes"][0]["scale"] = json!([1e300, 1, 1]);
    let i = m.import();
    assert!(i.scene.instances.is_empty());
    assert!(warned(&i, "/nodes/0: the transform is not finite"), "{:?}", i.warnings);
}

#[test]
fn odd_quaternions_are_normalised() {
    let mut m = Model::new();
    m.triangle(json!({}));
    m.json["nodes"][0]["rotation"] = json!([0, 0, 2, 0]);
    m.node(json!({"mesh": 0, "rotation": [0, 0, 0, 0]}));
    let i = m.import();
    close(i.scene.instances[0].transform, Affine3A::from_rotation_z(std::f32::consts::PI));
    close(i.scene.instances[1].transform, Affine3A::IDENTITY);
    assert!(warned(&i, "/nodes/0/rotation: the quaternion is not of unit length"));
}

#[test]
fn instancing_places_one_mesh_many_times() {
    let mut m = Model::new();
    m.triangle(json!({}));
    let t = m.floats(&[1., 0., 0., 0., 2., 0.], "VEC3");
    let r = m.accessor(&[0i16, 0, 0, 32767, 0, 0, 32767, 0], I16, "VEC4", 2);
    m.json["accessors"][r as usize]["normalized"] = json!(true);
    m.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    m.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": t, "ROTATION": r, "_ID": t}}});
    let s = m.import().scene;
    assert_eq!((s.meshes.len(), s.instances.len()), (1, 2));
    close(s.instances[0].transform, Affine3A::from_translation(Vec3::new(11., 0., 0.)));
    close(
        s.instances[1].transform,
        Affine3A::from_translation(Vec3::new(10., 2., 0.)) * Affine3A::from_rotation_z(std::f32::consts::PI),
    );
    let short = m.floats(&[1., 0., 0.], "VEC3");
    m.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(short);
    assert!(m.error().contains("the instancing attributes differ in length"), "{}", m.error());
}

#[test]
fn cameras_stand_without_scale() {
    let mut m = Model::new();
    m.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1}}),
    );
    m.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {"xmag": 4, "ymag": 2, "zfar": 9, "znear": 0}}),
    );
    m.node(json!({"camera": 1, "name": "above"}));
    m.node(json!({"camera": 0, "translation": [1, 2, 3], "scale": [2, 3, 4]}));
    let c = m.import().scene.cameras;
    assert_eq!(c[0].projection, Projection::Perspective { yfov: 0.7 }, "in the order of the file's cameras");
    assert_eq!(c[0].aspect, Some(1.5));
    close(c[0].transform, Affine3A::from_translation(Vec3::new(1., 2., 3.)));
    assert_eq!((c[1].projection, c[1].aspect), (Projection::Orthographic { ymag: 2.0 }, Some(2.0)));
    assert_eq!(c[1].name, "above");
    // Mirrored frames stay right-handed.
    m.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let c = m.import().scene.cameras;
    assert!((c[0].transform.matrix3.determinant() - 1.0).abs() < 1e-6);
    // Cameras that cannot take a picture are named.
    m.json["nodes"][1]["scale"] = json!([1, 1, 0]);
    m.json["cameras"][1]["orthographic"]["ymag"] = json!(0);
    let i = m.import();
    assert!(i.scene.cameras.is_empty() && i.warnings.len() == 2, "{:?}", i.warnings);
}

#[test]
fn lights_of_all_kinds() {
    let mut m = Model::new();
    m.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 4, "range": 3},
        {"type": "point", "range": 7, "name": "bulb"},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}},
        {"type": "spot"},
        {"type": "spot", "spot": {"innerConeAngle": 2, "outerConeAngle": 1}, "color": [-1, 1, 1]},
        {"type": "laser"}
    ]}});
    let h = std::f32::consts::FRAC_1_SQRT_2;
    for light in 0..6 {
        m.node(json!({
            "translation": [0, 5, 0],
            "rotation": [-h, 0, 0, h],
            "scale": [2, 2, 2],
            "extensions": {"KHR_lights_punctual": {"light": light}}
        }));
    }
    let i = m.import();
    let l = &i.scene.lights;
    assert_eq!(l.len(), 5);
    assert_eq!(
        (l[0].kind, l[0].intensity, l[0].range),
        (LightKind::Directional, Vec3::new(4., 2., 0.), None)
    );
    assert!(
        (l[0].direction - Vec3::NEG_Y).length() < 1e-6,
        "shines along −Z, turned down: {}",
        l[0].direction
    );
    assert_eq!((l[1].kind, l[1].position, l[1].range), (LightKind::Point, Vec3::new(0., 5., 0.), Some(7.0)));
    assert_eq!(l[1].name, "bulb");
    assert_eq!(l[2].kind, LightKind::Spot { inner: 0.1, outer: 0.5 });
    // The inner angle's default, 0, and the outer one's, π/4.
    assert_eq!(l[3].kind, LightKind::Spot { inner: 0.0, outer: std::f32::consts::FRAC_PI_4 });
    let LightKind::Spot { inner, outer } = l[4].kind else { panic!() };
    assert!(inner < outer && outer == 1.0 && l[4].intensity == Vec3::new(0., 1., 1.));
    for text in
        ["lights/4: cone angles", "lights/4: negative intensity", "lights/5: a light of an unknown type"]
    {
        assert!(warned(&i, text), "{text}: {:?}", i.warnings);
    }
}
