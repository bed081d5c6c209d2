//! Factors, textures and their transforms.
mod common;
use common::*;
use etendue_import::{ImportError, ImportOptions, Limits, import};
use etendue_scene::{AlphaMode, Filter, Material, Wrap};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};

fn material(json: Value) -> Material {
    with(json).import().scene.materials[0].clone()
}

#[test]
fn defaults_are_gltfs() {
    assert_eq!(material(json!({})), Material::default());
    assert_eq!(material(json!({"pbrMetallicRoughness": {}})), Material::default());
}

#[test]
fn every_factor_arrives() {
    let m = material(json!({
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
            "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1, "texCoord": 1}
        },
        "normalTexture": {"index": 0, "scale": -2},
        "occlusionTexture": {"index": 0, "strength": 0.7},
        "emissiveTexture": {"index": 0},
        "emissiveFactor": [1, 0.5, 0],
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_specular": {
                "specularFactor": 0.8, "specularColorFactor": [2, 1, 0],
                "specularTexture": {"index": 0}, "specularColorTexture": {"index": 1}
            },
            "KHR_materials_unlit": {}
        }
    }));
    assert_eq!((m.name.as_str(), m.base_color, m.alpha), ("paint", Vec3::new(0.1, 0.2, 0.3), 0.4));
    assert_eq!((m.metallic, m.roughness, m.occlusion_strength), (0.5, 0.6, 0.7));
    assert_eq!((m.emissive, m.alpha_mode), (Vec3::new(8., 4., 0.), AlphaMode::Mask(0.25)));
    assert!(m.double_sided && m.unlit);
    assert_eq!((m.ior, m.specular, m.specular_color), (1.33, 0.8, Vec3::new(2., 1., 0.)));
    assert_eq!(m.textures().count(), 7);
    assert_eq!(m.metallic_roughness_texture.unwrap().uv_set, 1);
    assert_eq!(m.normal_texture.unwrap().scale, -2.0);
    assert_eq!(material(json!({"alphaMode": "BLEND"})).alpha_mode, AlphaMode::Blend);
    assert_eq!(material(json!({"extensions": {"KHR_materials_ior": {"ior": 0}}})).ior, 0.0);
}

#[test]
fn factors_outside_their_range_are_clamped_with_a_warning() {
    let i = with(json!({
        "pbrMetallicRoughness": {"metallicFactor": 2, "roughnessFactor": -1, "baseColorFactor": [3, 0, 0, 1e300]},
        "emissiveFactor": [1, 1, 1],
        "alphaMode": "SOLID",
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 1e300},
            "KHR_materials_ior": {"ior": 0.5},
            "KHR_materials_specular": {"specularColorFactor": [-1, 1, 1]}
        }
    }))
    .import();
    let m = &i.scene.materials[0];
    assert_eq!((m.metallic, m.roughness, m.base_color, m.alpha, m.ior), (1.0, 0.0, Vec3::X, 1.0, 1.0));
    assert_eq!(m.specular_color, Vec3::new(0., 1., 1.));
    assert!(m.emissive.is_finite());
    for text in [
        "metallicFactor",
        "roughnessFactor",
        "baseColorFactor",
        "emissiveStrength",
        "ior",
        "specularColor",
        "alpha mode",
    ] {
        assert!(
            i.warnings.iter().any(|w| w.pointer.starts_with("/materials/0") && w.message.contains(text)),
            "{text}"
        );
    }
}

#[test]
fn a_factor_of_the_wrong_type_is_ignored_and_named() {
    let i = with(json!({"pbrMetallicRoughness": {"roughnessFactor": "high", "baseColorFactor": [1, 2]}}))
        .import();
    assert_eq!(i.scene.materials[0], Material::default());
    assert!(warned(
        &i,
        "/materials/0/pbrMetallicRoughness/roughnessFactor: a number is needed, not a string; ignored"
    ));
    assert!(warned(
        &i,
        "/materials/0/pbrMetallicRoughness/baseColorFactor: 4 numbers are needed, not 2; ignored"
    ));
}

#[test]
fn unsupported_extensions_are_named_once_and_counted() {
    let mut m = with(json!({"extensions": {"EXT_what": {}, "KHR_xmp": {}}}));
    m.push("materials", json!({"extensions": {"EXT_what": {}}}));
    m.json["extensionsUsed"] = json!(["KHR_xmp", "KHR_materials_ior", "EXT_what"]);
    let i = m.import();
    let lines: Vec<String> = i.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        lines,
        ["/materials/0/extensions/EXT_what: EXT_what is not supported yet; ignored (and 1 more)"]
    );
    let e = &i.info.extensions;
    use etendue_import::Support;
    assert_eq!(
        e.iter().map(|e| (e.name.as_str(), e.support)).collect::<Vec<_>>(),
        [("KHR_xmp", Some(Support::Ignored)), ("KHR_materials_ior", Some(Support::Full)), ("EXT_what", None)]
    );
}

#[test]
fn required_extensions() {
    let mut m = with(json!({}));
    for name in ["MSFT_texture_dds", "FAKE_thing"] {
        m.json["extensionsRequired"] = json!([name]);
        assert!(
            m.error().contains(&format!("/extensionsRequired: requires {name}, which is not supported yet"))
        );
    }
    // What says nothing of the picture may be required.
    m.json["extensionsRequired"] = json!([
        "KHR_materials_ior",
        "KHR_xmp_json_ld",
        "KHR_xmp",
        "KHR_interactivity",
        "EXT_structural_metadata"
    ]);
    m.json["materials"][0]["extensions"] = json!({"KHR_physics_rigid_bodies": {"joint": 7}});
    assert_eq!(m.import().warnings.len(), 0);
}

#[test]
fn textures_share_images_and_carry_samplers() {
    let m = with(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
        "emissiveTexture": {"index": 0}
    }));
    let s = m.import().scene;
    assert_eq!((s.images.len(), s.textures.len()), (1, 2));
    assert_eq!((s.images[0].width, s.images[0].height, s.images[0].channels), (2, 1, 3));
    let t = s.textures[1].sampler;
    assert_eq!((t.wrap_u, t.wrap_v, t.filter), (Wrap::Clamp, Wrap::Mirror, Filter::Nearest));
    let red = s.textures[0].sample_srgb(&s.images[0], Vec2::new(0.25, 0.5));
    assert_eq!(red.to_array(), [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn images_that_no_used_material_needs_are_not_read() {
    let mut m = with(json!({}));
    m.json["images"][0]["uri"] = json!("nowhere.png");
    m.push("materials", json!({"emissiveTexture": {"index": 0}}));
    assert!(m.import().scene.images.is_empty());
    m.json["materials"][0] = json!({"occlusionTexture": {"index": 0}});
    let options = ImportOptions { occlusion: false, ..ImportOptions::default() };
    assert!(m.import_with(&options).unwrap().scene.images.is_empty());
    assert!(m.error().contains("`nowhere.png` was not found"));
}

#[test]
fn texture_transform() {
    let reference = |t: Value| {
        material(json!({"emissiveTexture": {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": t}}}))
            .emissive_texture
            .unwrap()
    };
    let t = reference(json!({"offset": [0.5, 0.25], "scale": [2, 3], "texCoord": 1}));
    assert_eq!(t.uv_set, 1);
    assert_eq!(t.transform.transform_point2(Vec2::new(1.0, 1.0)), Vec2::new(2.5, 3.25));
    // A quarter turn counter-clockwise in a frame whose v points down: u = 1 goes to v = −1.
    let t = reference(json!({"rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 1]}));
    assert!((t.transform.transform_point2(Vec2::X) - Vec2::new(0.0, -2.0)).length() < 1e-6);
    assert!((t.transform.transform_point2(Vec2::Y) - Vec2::new(1.0, 0.0)).length() < 1e-6);
}

#[test]
fn uv_sets_by_number() {
    let mut m = with(json!({"emissiveTexture": {"index": 0, "texCoord": 2}}));
    let uv = m.floats(&[0.5; 6], "VEC2");
    m.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_2"] = json!(uv);
    let s = m.import().scene;
    assert_eq!(s.meshes[0].uvs.len(), 3);
    assert_eq!(s.meshes[0].uvs[2], [Vec2::splat(0.5); 3]);
    m.json["materials"][0]["emissiveTexture"]["texCoord"] = json!(4_000_000_000u32);
    let i = m.import();
    assert_eq!(i.scene.meshes[0].uvs.len(), 1);
    assert!(warned(&i, "set 4000000000 that its mesh does not have"), "{:?}", i.warnings);
}

#[test]
fn webp_extension_and_other_sources() {
    let mut m = with(json!({"emissiveTexture": {"index": 0}}));
    m.push("images", json!({"uri": data_uri(&png())}));
    m.json["images"][0]["uri"] = json!("fallback.png");
    m.json["textures"][0] = json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}});
    assert_eq!(m.import().scene.images.len(), 1);
    m.json["textures"][0] = json!({"extensions": {"MSFT_texture_dds": {"source": 1}}});
    let i = m.import();
    assert!(i.scene.materials[0].emissive_texture.is_none());
    assert!(warned(&i, "MSFT_texture_dds is not supported yet; ignored") && warned(&i, "shown without it"));
}

#[test]
fn broken_and_missing_images_say_which() {
    let mut m = with(json!({"emissiveTexture": {"index": 0}}));
    m.json["images"][0] = json!({"uri": data_uri(&png()[..40]), "name": "sky"});
    assert!(m.error().contains("/images/0: the image data:"), "{}", m.error());
    m.json["images"][0] = json!({"uri": data_uri(b"DDS |")});
    assert!(
        m.error().contains("/images/0: requires DDS textures, which is not supported yet"),
        "{}",
        m.error()
    );
    m.json["images"][0] = json!({});
    assert!(m.error().contains("/images/0: has neither `uri` nor `bufferView`"), "{}", m.error());
    m.json["textures"][0]["source"] = json!(9);
    assert!(m.error().contains("/textures/0/source: image 9 does not exist"), "{}", m.error());
    m.json["materials"][0]["emissiveTexture"]["index"] = json!(9);
    assert!(
        m.error().contains("/materials/0/emissiveTexture/index: texture 9 does not exist"),
        "{}",
        m.error()
    );
}

#[test]
fn files_beside_the_model() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("my model");
    std::fs::create_dir_all(folder.join("tex ture")).unwrap();
    let mut m = with(json!({"emissiveTexture": {"index": 0}}));
    std::fs::write(folder.join("d ä.bin"), &m.bytes).unwrap();
    std::fs::write(folder.join("tex ture/a%20b.png"), png()).unwrap();
    std::fs::write(dir.path().join("outside.png"), png()).unwrap();
    m.json["buffers"] = json!([{"byteLength": m.bytes.len(), "uri": "d%20%C3%A4.bin"}]);
    // Against the specification: not encoded, and with a backslash.
    m.json["images"][0]["uri"] = json!("tex ture\\a%20b.png");
    let path = folder.join("m.gltf");
    let load = |m: &Model, options: &ImportOptions| {
        std::fs::write(&path, m.json.to_string()).unwrap();
        import(&path, options)
    };
    let i = load(&m, &ImportOptions::default()).unwrap();
    assert_eq!((i.scene.images.len(), i.info.external_bytes), (1, m.bytes.len() as u64));

    m.json["images"][0]["uri"] = json!("gone.png");
    let e = load(&m, &ImportOptions::default()).unwrap_err();
    assert!(
        matches!(&e, ImportError::Missing { pointer, looked_for, what: "image", .. }
        if pointer == "/images/0/uri" && **looked_for == folder.join("gone.png")),
        "{e}"
    );

    m.json["images"][0]["uri"] = json!("../outside.png");
    let e = load(&m, &ImportOptions::default()).unwrap_err().to_string();
    assert!(e.contains("outside the model's folder"), "{e}");
    let limits = Limits { outside_folder: true, ..Limits::default() };
    assert!(load(&m, &ImportOptions { limits, ..ImportOptions::default() }).is_ok());

    m.json["images"][0]["uri"] = json!("https://example.com/a.png");
    let e = load(&m, &ImportOptions::default()).unwrap_err().to_string();
    assert!(e.contains("`https:` addresses are not read"), "{e}");
    m.json["images"][0]["uri"] = json!("tex%20ture");
    let e = load(&m, &ImportOptions::default()).unwrap_err().to_string();
    assert!(e.contains("not a regular file"), "{e}");
    assert!(matches!(
        import(&folder.join("none.glb"), &ImportOptions::default()),
        Err(ImportError::Read { .. })
    ));
}
