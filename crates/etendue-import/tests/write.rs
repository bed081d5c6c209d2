//! A written scene is read again as the same scene.
use etendue_image::{Image, Pixels};
use etendue_import::{ExportOptions, Form, ImportOptions, Imported, export, import, import_bytes};
use etendue_scene::{
    Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene, TextureRef, Variant,
};
use glam::{Affine2, Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

fn kept() -> ImportOptions {
    ImportOptions { image_files: true, ..ImportOptions::default() }
}

fn again(scene: &Scene, files: &Imported, form: Form) -> Imported {
    let options = ExportOptions { form, ..ExportOptions::default() };
    let file = export(scene, &files.image_files, &options).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(file.notes, Vec::<String>::new());
    import_bytes(&file.bytes, "written", &kept()).unwrap_or_else(|e| panic!("{e}"))
}

fn roundtrip(scene: &Scene) -> Scene {
    let nothing = import_bytes(b"{\"asset\":{\"version\":\"2.0\"}}", "empty", &kept()).unwrap();
    again(scene, &nothing, Form::Binary).scene
}

/// What a texture shows, whatever its number is.
fn content(s: &Scene, t: &TextureRef) -> String {
    let texture = s.textures[t.texture as usize];
    let i = &s.images[texture.image as usize];
    let mut h = DefaultHasher::new();
    match &i.pixels {
        Pixels::U8(p) => p.hash(&mut h),
        Pixels::U16(p) => p.hash(&mut h),
        Pixels::F32(p) => format!("{p:?}").hash(&mut h),
    }
    let size = (i.width, i.height, i.channels);
    format!("{size:?} {:x} {:?} {} {:.4?}", h.finish(), texture.sampler, t.uv_set, t.transform)
}

/// A text in which equal numbers look equal.
fn text(v: &impl std::fmt::Debug) -> String {
    format!("{v:.4?}").replace("-0.0000", "0.0000")
}

/// A material with the content of its textures instead of their numbers.
fn material(s: &Scene, m: Option<u32>) -> String {
    let Some(m) = m else { return "default".into() };
    let m = &s.materials[m as usize];
    let mut out = String::new();
    for part in text(m).split("texture: ") {
        out += part.trim_start_matches(|c: char| c.is_ascii_digit());
        out.push('|');
    }
    m.textures().for_each(|t| out += &content(s, t).replace("-0.0000", "0.0000"));
    out
}

fn near(a: &[f32], b: &[f32], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}");
    let size = a.iter().fold(1e-6f32, |m, v| m.max(v.abs()));
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() <= 2e-6 * size, "{what}: {x} {y}");
    }
}

fn same(a: &Scene, b: &Scene, what: &str) {
    assert_eq!(a.instances.len(), b.instances.len(), "{what}");
    let mut compared = std::collections::HashSet::new();
    for (k, (i, j)) in a.instances.iter().zip(&b.instances).enumerate() {
        let what = format!("{what}, instance {k} ({})", i.name);
        assert_eq!(i.name, j.name, "{what}");
        near(&i.transform.to_cols_array(), &j.transform.to_cols_array(), &what);
        assert_eq!(material(a, i.material), material(b, j.material), "{what}");
        if !compared.insert((i.mesh, j.mesh)) {
            continue;
        }
        let (m, n) = (&a.meshes[i.mesh as usize], &b.meshes[j.mesh as usize]);
        assert_eq!((&m.name, &m.indices, &m.positions), (&n.name, &n.indices, &n.positions), "{what}");
        assert_eq!((&m.uvs, &m.colors), (&n.uvs, &n.colors), "{what}");
        let flat = |v: &[Vec3]| v.iter().flat_map(|v| v.to_array()).collect::<Vec<_>>();
        near(&flat(&m.normals), &flat(&n.normals), &what);
        let flat = |m: &Mesh| m.tangents.iter().flat_map(|v| v.to_array()).collect::<Vec<_>>();
        near(&flat(m), &flat(n), &what);
    }
    assert_eq!(text(&a.lights), text(&b.lights), "{what}");
    assert_eq!(text(&a.cameras), text(&b.cameras), "{what}");
    let variants = |s: &Scene| -> Vec<(String, Vec<(u32, String)>)> {
        let list = |v: &Variant| {
            let mut l: Vec<_> = v.materials.iter().map(|&[i, m]| (i, material(s, Some(m)))).collect();
            l.sort();
            (v.name.clone(), l)
        };
        s.variants.iter().map(list).collect()
    };
    assert_eq!(variants(a), variants(b), "{what}");
}

/// Models whose pictures are few, and that have between them all extensions, lights, cameras, variants and instances.
const MODELS: &[&str] = &[
    "AlphaBlendModeTest/AlphaBlendModeTest.glb",
    "AnisotropyStrengthTest/AnisotropyStrengthTest.glb",
    "AttenuationTest/AttenuationTest.glb",
    "BoxTextured/BoxTextured.glb",
    "Cameras",
    "ClearCoatTest/ClearCoatTest.glb",
    "EmissiveStrengthTest/EmissiveStrengthTest.glb",
    "Fox/Fox.glb",
    "IridescenceSuzanne/IridescenceSuzanne.glb",
    "MultiUVTest/MultiUVTest.glb",
    "NormalTangentTest/NormalTangentTest.glb",
    "OrientationTest/OrientationTest.glb",
    "SheenChair",
    "SimpleInstancing/SimpleInstancing.glb",
    "SpecularTest/SpecularTest.glb",
    "TextureSettingsTest/TextureSettingsTest.glb",
    "TextureTransformTest",
    "TransmissionTest/TransmissionTest.glb",
    "UnlitTest/UnlitTest.glb",
    "VertexColorTest/VertexColorTest.glb",
    "assimp-BoxSpecGloss",
    "khr-lights",
    "nanogl-CesiumBoxWebp",
    "pc-dispersion-test",
    "sharpgltf-GrassFieldInstanced",
];

#[test]
fn models_of_other_programs() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/models"));
    if !root.exists() {
        println!("skipped: {} is absent", root.display());
        return;
    }
    let mut seen = 0;
    for name in MODELS {
        let mut path = root.join(name);
        if path.is_dir() {
            let files = std::fs::read_dir(&path).unwrap().flatten().map(|e| e.path());
            let model = |p: &std::path::PathBuf| {
                matches!(p.extension().and_then(|e| e.to_str()), Some("gltf" | "glb"))
            };
            path = files.filter(model).min().unwrap_or(path);
        }
        let Ok(model) = import(&path, &kept()) else {
            println!("skipped: {}", path.display());
            continue;
        };
        let small = model.info.bytes + model.info.external_bytes < 1 << 19;
        for form in [Form::Binary, Form::Text].into_iter().take(1 + usize::from(small)) {
            let back = again(&model.scene, &model, form);
            same(&model.scene, &back.scene, name);
            assert_eq!(back.warnings, [], "{name}");
        }
        seen += 1;
    }
    assert!(seen > MODELS.len() / 2, "{seen} of {} models were found", MODELS.len());
}

fn triangle() -> Mesh {
    Mesh {
        name: "m".into(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        uvs: vec![vec![Vec2::ZERO, Vec2::X, Vec2::Y]],
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    }
}

fn instance(name: &str, transform: Affine3A) -> Instance {
    Instance { name: name.into(), mesh: 0, material: Some(0), transform }
}

#[test]
fn crowds_are_instanced_and_others_stand_alone() {
    let at = |k: usize| {
        Affine3A::from_translation(Vec3::new(k as f32, 0.1, 0.0)) * Affine3A::from_rotation_y(k as f32)
    };
    let mut instances: Vec<_> = (0..20).map(|k| instance("grass", at(k))).collect();
    instances.extend((0..20).map(|k| instance(&format!("tree {k}"), at(k))));
    let shear = Mat3A::from_cols(Vec3A::X, Vec3A::new(0.5, 1.0, 0.0), Vec3A::new(0.0, 0.0, -2.0));
    instances.push(instance("sheared", Affine3A { matrix3: shear, translation: Vec3A::ONE }));
    let scene = Scene {
        meshes: vec![triangle().into()],
        instances,
        materials: vec![Material::default()],
        ..Scene::default()
    };
    same(&scene, &roundtrip(&scene), "crowd");
    let file = export(&scene, &[], &ExportOptions { form: Form::Text, ..ExportOptions::default() }).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&file.bytes).unwrap();
    assert_eq!(json["extensionsRequired"], serde_json::json!(["EXT_mesh_gpu_instancing"]));
    // A crowd, twenty trees, and what is sheared in two.
    assert_eq!(json["nodes"].as_array().unwrap().len(), 1 + 20 + 2);
    assert_eq!(json["accessors"].as_array().unwrap().len(), 3 + 2, "geometry is stored once");
}

#[test]
fn lights_cameras_variants_and_odd_values() {
    let light = |name: &str, kind, intensity| Light {
        name: name.into(),
        kind,
        intensity,
        position: Vec3::new(1.0, -2.0, 3.0),
        direction: Vec3::new(0.6, 0.0, 0.8),
        range: (kind == LightKind::Point).then_some(7.0),
    };
    let mut spot = light("spot", LightKind::Spot { inner: 0.2, outer: 0.7 }, Vec3::new(0.5, 40.0, 2.0));
    spot.direction = Vec3::Z;
    let mut parallel = Camera::look_at(Vec3::new(3.0, 2.0, 1.0), Vec3::ZERO, Vec3::Y, 0.7);
    parallel.name = "plan".into();
    parallel.aspect = Some(2.0);
    parallel.projection = Projection::Orthographic { ymag: 1.5 };
    let mut a =
        Material { name: "a".into(), emissive: Vec3::new(0.0, 3.0, 12.0), ior: 0.0, ..Material::default() };
    a.specular_color = Vec3::new(2.0, 1.0, 0.5);
    let b = Material {
        name: "b".into(),
        alpha: 0.25,
        alpha_mode: etendue_scene::AlphaMode::Mask(0.75),
        ..Material::default()
    };
    let mut turned = instance("turned", Affine3A::from_scale(Vec3::new(1.0, -2.0, 0.0)));
    turned.material = None;
    let scene = Scene {
        meshes: vec![triangle().into()],
        instances: vec![instance("one", Affine3A::IDENTITY), turned],
        materials: vec![a, b],
        lights: vec![spot, light("point", LightKind::Point, Vec3::ONE)],
        cameras: vec![Camera::look_at(Vec3::ONE, Vec3::ZERO, Vec3::Y, 0.9), parallel],
        variants: vec![
            Variant { name: "x".into(), materials: vec![[0, 1], [1, 0]] },
            Variant { name: "y".into(), materials: vec![[1, 0]] },
        ],
        ..Scene::default()
    };
    same(&scene, &roundtrip(&scene), "odd");
    let empty = Scene::default();
    same(&empty, &roundtrip(&empty), "empty");
}

#[test]
fn pictures_keep_their_files_or_become_png() {
    let grey16 = Image { width: 2, height: 1, channels: 1, pixels: Pixels::U16(vec![1, 40_000]) };
    let rgba = Image { width: 1, height: 2, channels: 4, pixels: Pixels::U8((0..8).collect()) };
    let transform = Affine2::from_scale_angle_translation(Vec2::new(2.0, 3.0), 0.0, Vec2::new(0.25, -1.0));
    let turn = Affine2 {
        matrix2: glam::Mat2::from_cols(Vec2::new(0.6, -0.8) * -2.0, Vec2::new(0.8, 0.6) * 3.0),
        translation: Vec2::X,
    };
    let texture = |texture, transform| Some(TextureRef { texture, uv_set: 0, transform });
    let scene = Scene {
        meshes: vec![triangle().into()],
        instances: vec![instance("one", Affine3A::IDENTITY)],
        materials: vec![Material {
            base_color_texture: texture(0, transform),
            occlusion_texture: texture(1, turn),
            emissive_texture: texture(0, Affine2::from_scale(Vec2::new(-1.0, -1.0))),
            ..Material::default()
        }],
        textures: (0..2)
            .map(|image| etendue_scene::Texture { image, sampler: etendue_scene::Sampler::default() })
            .collect(),
        images: vec![grey16.into(), rgba.into()],
        ..Scene::default()
    };
    same(&scene, &roundtrip(&scene), "pictures");
}
