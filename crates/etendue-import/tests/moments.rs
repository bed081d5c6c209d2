//! A model that is read once shows at each moment what an import of that moment shows.
mod common;
use common::*;
use etendue_import::{AnimationChoice, ImportOptions, ModelFile, import};
use etendue_scene::Scene;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

fn assert_same(a: &Scene, b: &Scene, what: &str) {
    assert_eq!(format!("{:?}", a.instances), format!("{:?}", b.instances), "{what}");
    assert_eq!(format!("{:?}", (&a.materials, &a.textures)), format!("{:?}", (&b.materials, &b.textures)));
    assert_eq!(format!("{:?}", (&a.cameras, &a.lights)), format!("{:?}", (&b.cameras, &b.lights)));
    assert_eq!(a.meshes.len(), b.meshes.len(), "{what}");
    for (m, n) in a.meshes.iter().zip(&b.meshes) {
        assert_eq!((&m.name, &m.positions, &m.indices), (&n.name, &n.positions, &n.indices), "{what}");
        assert_eq!(
            (&m.normals, &m.tangents, &m.uvs, &m.colors),
            (&n.normals, &n.tangents, &n.uvs, &n.colors)
        );
    }
}

#[test]
fn each_moment_is_an_import_of_its_own() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/models"));
    for (name, file) in [
        ("InterpolationTest", "InterpolationTest.glb"),
        ("AnimatedMorphCube", "AnimatedMorphCube.glb"),
        ("SimpleSkin", "SimpleSkin.gltf"),
        ("Fox", "Fox.glb"),
        ("BoxTextured", "BoxTextured.glb"),
    ] {
        let path = folder.join(name).join(file);
        if !path.exists() {
            println!("skipped: no {}", path.display());
            continue;
        }
        let options = ImportOptions { animation: AnimationChoice::All, ..ImportOptions::default() };
        let kept = ModelFile::read(&path, &options).unwrap();
        let model = kept.open().unwrap();
        let first = model.at(None).unwrap();
        for seconds in [None, Some(0.25f32), Some(1.5), None] {
            let now = model.at(seconds.map(f64::from)).unwrap();
            let alone = import(&path, &ImportOptions { at: seconds, ..options.clone() }).unwrap();
            assert_same(&now.scene, &alone.scene, &format!("{name} at {seconds:?}"));
            assert_eq!(now.warnings, alone.warnings, "{name}");
            assert!(now.scene.images.iter().zip(&first.scene.images).all(|(a, b)| Arc::ptr_eq(a, b)));
        }
    }
}

#[test]
fn durations_and_digests() {
    let mut m = Model::new();
    m.triangle(json!({}));
    let still = m.glb();
    let input = m.floats(&[0.5, 3.0], "SCALAR");
    let output = m.floats(&[0., 0., 0., 1., 0., 0.], "VEC3");
    m.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": input, "output": output}]
        }),
    );
    let moving = m.glb();
    let of = |bytes: &[u8], animation| {
        let file = ModelFile::from_bytes(
            bytes,
            "test.glb",
            &ImportOptions { animation, ..ImportOptions::default() },
        );
        let model = file.open().unwrap();
        (model.duration().map_err(|e| e.to_string()), model.digest())
    };
    let (a, b) = (of(&still, AnimationChoice::First), of(&moving, AnimationChoice::First));
    assert_eq!((a.0, b.0), (Ok(None), Ok(Some(0.5..=3.0))));
    assert_ne!(a.1, b.1);
    assert!(of(&moving, AnimationChoice::Index(1)).0.unwrap_err().contains("no animation 1"));
}
