//! The material extensions: every field, its default, its range, and what happens to what makes no sense.
mod common;
use common::surfaces::*;
use common::*;
use etendue_import::ImportOptions;
use etendue_scene::*;
use glam::{Affine2, Vec2, Vec3};
use serde_json::{Value, json};

/// The material's extensions, read without a warning.
fn clean(material: Value) -> Option<Extensions> {
    let i = with(material).import();
    assert!(i.warnings.is_empty(), "{:?}", i.warnings);
    i.scene.materials[0].extensions.as_deref().cloned()
}

fn read(name: &str, extension: Value) -> Extensions {
    clean(extended(name, extension)).expect("does something")
}

/// What [`texture`] becomes.
fn arrived() -> Option<TextureRef> {
    let transform = Affine2::from_scale_angle_translation(Vec2::new(2., 4.), 0.0, Vec2::new(0.5, 0.25));
    Some(TextureRef { texture: 0, uv_set: 1, transform })
}

#[test]
fn every_field_arrives() {
    let all: Vec<Extensions> = samples().into_iter().map(|(name, e, _)| read(name, e)).collect();
    let (texture, none) = (arrived(), Extensions::default());
    let anisotropy = Anisotropy { strength: 0.6, rotation: 1.5, texture };
    assert_eq!(all[0], Extensions { anisotropy: Some(anisotropy), ..none.clone() });
    let plain = TextureRef { transform: Affine2::IDENTITY, ..texture.unwrap() };
    let clearcoat = Clearcoat {
        factor: 0.5,
        texture,
        roughness: 0.25,
        roughness_texture: texture,
        normal_texture: Some(NormalTexture { texture: plain, scale: -3.0 }),
        ..Clearcoat::default()
    };
    assert_eq!(all[1], Extensions { clearcoat: Some(clearcoat), ..none.clone() });
    let color = Vec3::new(0.1, 0.2, 0.3);
    let diffuse = DiffuseTransmission { factor: 0.5, texture, color, color_texture: texture };
    assert_eq!(all[2], Extensions { diffuse_transmission: Some(diffuse), ..none.clone() });
    let thickness = [200.0, 150.0];
    let film = Iridescence { factor: 0.5, texture, ior: 1.5, thickness, thickness_texture: texture };
    assert_eq!(all[3], Extensions { iridescence: Some(film), ..none.clone() });
    let sheen = Sheen { color, color_texture: texture, roughness: 0.5, roughness_texture: texture };
    assert_eq!(all[4], Extensions { sheen: Some(sheen), ..none.clone() });
    let transmission = Transmission { factor: 0.75, texture };
    assert_eq!(all[5], Extensions { transmission: Some(transmission), ..none });
}

#[test]
fn what_the_file_does_not_say_is_the_specifications_default() {
    let e = read("anisotropy", json!({"anisotropyStrength": 1}));
    assert_eq!(e.anisotropy, Some(Anisotropy { strength: 1.0, rotation: 0.0, texture: None }));
    let e = read("clearcoat", json!({"clearcoatFactor": 1}));
    assert_eq!(e.clearcoat, Some(Clearcoat { factor: 1.0, ..Clearcoat::default() }));
    let e = read("diffuse_transmission", json!({"diffuseTransmissionFactor": 1})).diffuse_transmission;
    assert_eq!(e.map(|d| (d.factor, d.color)), Some((1.0, Vec3::ONE)));
    let e = read("iridescence", json!({"iridescenceFactor": 1})).iridescence;
    assert_eq!(e.map(|i| (i.ior, i.thickness)), Some((1.3, [100.0, 400.0])));
    let e = read("sheen", json!({"sheenColorFactor": [0, 0, 1]}));
    assert_eq!(e.sheen, Some(Sheen { color: Vec3::Z, ..Sheen::default() }));
    let glass = json!({"extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 2}
    }});
    let e = clean(glass).unwrap();
    assert_eq!(e.volume, Some(Volume { thickness: 2.0, ..Volume::default() }));
    assert_eq!((e.volume.unwrap().attenuation_distance, e.dispersion), (f32::INFINITY, 0.0));
}

#[test]
fn what_does_nothing_is_left_out_with_its_textures() {
    for (name, _, neutral) in samples() {
        for nothing in [neutral, json!({})] {
            let mut m = with(extended(name, nothing));
            m.json["images"][0]["uri"] = json!("nowhere.png");
            let i = m.import();
            assert_eq!(i.scene.materials[0], Material::default(), "{name}");
            assert!(i.scene.images.is_empty() && i.warnings.is_empty(), "{name}: {:?}", i.warnings);
            assert!(i.scene.meshes[0].tangents.is_empty(), "{name}");
        }
    }
    // Nothing gets in, or there is nothing inside, or nothing is refracted.
    let volume = json!({"thicknessFactor": 1, "attenuationColor": [0, 0, 0], "attenuationDistance": 1});
    let thin = json!({"thicknessFactor": 0, "attenuationColor": [0, 0, 0], "attenuationDistance": 1});
    let (glass, leaf) = (json!({"transmissionFactor": 1}), json!({"diffuseTransmissionFactor": 1}));
    let spread = json!({"dispersion": 1});
    assert_eq!(clean(extended("volume", volume.clone())), None);
    assert_eq!(clean(extended("dispersion", spread.clone())), None);
    let e = clean(json!({"extensions": {
        "KHR_materials_transmission": glass, "KHR_materials_volume": thin, "KHR_materials_dispersion": spread
    }}));
    assert!(e.is_some_and(|e| e.volume.is_none() && e.dispersion == 0.0 && e.transmission.is_some()));
    let e = clean(json!({"extensions": {
        "KHR_materials_diffuse_transmission": leaf, "KHR_materials_volume": volume,
        "KHR_materials_dispersion": spread
    }}));
    assert!(e.is_some_and(|e| e.volume.is_some() && e.dispersion == 0.0));
}

#[test]
fn volumes() {
    let with_volume = |volume: Value| {
        json!({"extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume,
            "KHR_materials_dispersion": {"dispersion": 0.36}
        }})
    };
    let jade = json!({
        "thicknessFactor": 0.5, "thicknessTexture": texture(), "attenuationDistance": 0.006,
        "attenuationColor": [0.1, 0.2, 0.3]
    });
    let expected = Volume {
        thickness: 0.5,
        thickness_texture: arrived(),
        attenuation_distance: 0.006,
        attenuation_color: Vec3::new(0.1, 0.2, 0.3),
    };
    let e = clean(with_volume(jade.clone())).unwrap();
    assert_eq!((e.volume, e.dispersion), (Some(expected), 0.36));
    let options = ImportOptions { occlusion: false, ..ImportOptions::default() };
    let s = with(with_volume(jade)).import_with(&options).unwrap().scene;
    let e = s.materials[0].extensions.clone().unwrap();
    assert_eq!(e.volume, Some(Volume { thickness_texture: None, ..expected }));
    assert!(s.images.is_empty());
    for (distance, warns) in [(0.0, true), (-1.0, true), (1e300, false)] {
        let i = with(with_volume(json!({"thicknessFactor": 1, "attenuationDistance": distance}))).import();
        let volume = i.scene.materials[0].extensions.as_ref().unwrap().volume.unwrap();
        assert_eq!((volume.attenuation_distance, i.warnings.len()), (f32::INFINITY, usize::from(warns)));
        let at = "/materials/0/extensions/KHR_materials_volume: attenuationDistance is not above 0";
        assert_eq!(warned(&i, at), warns);
    }
    let e = clean(with_volume(json!({"thicknessFactor": 1, "attenuationDistance": 1e-300}))).unwrap();
    assert_eq!(e.volume.unwrap().attenuation_distance, 1e-18);
}

#[test]
fn specular_glossiness_stands_in_for_metal_and_roughness() {
    let mut m = with(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 7},
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "diffuseTexture": {"index": 2},
            "specularFactor": [0.5, 0.6, 0.7], "glossinessFactor": 0.75, "specularGlossinessTexture": texture()
        }}
    }));
    m.push("images", json!({"uri": data_uri(&png())}));
    m.push("textures", json!({"source": 1}));
    // The other workflow is a fallback that is not needed.
    m.json["textures"][0] = json!({"source": 9});
    let i = m.import();
    assert!(i.warnings.is_empty(), "{:?}", i.warnings);
    let m = &i.scene.materials[0];
    assert_eq!((m.base_color, m.alpha), (Vec3::new(0.1, 0.2, 0.3), 0.4));
    assert_eq!((m.metallic, m.roughness, m.metallic_roughness_texture), (0.0, 0.25, None));
    assert_eq!(m.base_color_texture.map(|t| t.texture), Some(1));
    let gloss =
        SpecularGlossiness { specular: Vec3::new(0.5, 0.6, 0.7), glossiness: 0.75, texture: arrived() };
    let expected = Extensions { specular_glossiness: Some(gloss), ..Extensions::default() };
    assert_eq!(m.extensions.as_deref(), Some(&expected));
    let i = with(extended("pbrSpecularGlossiness", json!({}))).import();
    let m = &i.scene.materials[0];
    assert_eq!((m.base_color, m.alpha, m.metallic, m.roughness), (Vec3::ONE, 1.0, 0.0, 0.0));
    let gloss = m.extensions.as_ref().and_then(|e| e.specular_glossiness);
    assert_eq!(gloss, Some(SpecularGlossiness::default()));
}

#[test]
fn many_turns_keep_their_angle() {
    let turned = |r: f64| {
        read("anisotropy", json!({"anisotropyStrength": 1, "anisotropyRotation": r}))
            .anisotropy
            .unwrap()
            .rotation
    };
    assert_eq!(turned(-1.25), -1.25);
    let many = turned(1e6 * std::f64::consts::TAU + 0.5);
    assert!((many - 0.5).abs() < 1e-6, "{many}");
    assert!(turned(1e300).abs() < 6.3);
}
