//! Drafts of material extensions: read if they are asked for, every field, its default and its range; named if they are not.
mod common;
use common::surfaces::*;
use common::*;
use etendue_import::{ExportOptions, ImportError, ImportOptions, Imported, Support, export, import_bytes};
use etendue_scene::*;
use glam::{Affine2, Vec2, Vec3};
use serde_json::{Value, json};

fn asked() -> ImportOptions {
    ImportOptions { drafts: true, image_files: true, ..ImportOptions::default() }
}

fn draft(material: Value) -> Imported {
    with(material).import_with(&asked()).unwrap_or_else(|e| panic!("{e}"))
}

fn read(name: &str, extension: Value) -> Extensions {
    let i = draft(extended(name, extension));
    assert!(i.warnings.is_empty(), "{:?}", i.warnings);
    i.scene.materials[0].extensions.as_deref().cloned().expect("does something")
}

/// What [`texture`] becomes.
fn arrived() -> Option<TextureRef> {
    let transform = Affine2::from_scale_angle_translation(Vec2::new(2., 4.), 0.0, Vec2::new(0.5, 0.25));
    Some(TextureRef { texture: 0, uv_set: 1, transform })
}

#[test]
fn every_field_arrives() {
    let all: Vec<Extensions> = drafts().into_iter().map(|(name, e, _)| read(name, e)).collect();
    let (texture, none) = (arrived(), Extensions::default());
    let rough = DiffuseRoughness { factor: 0.5, texture };
    assert_eq!(all[0], Extensions { diffuse_roughness: Some(rough), ..none.clone() });
    let color = Vec3::new(0.1, 0.2, 0.3);
    let fuzz = Fuzz {
        factor: 0.5,
        texture,
        color,
        color_texture: texture,
        roughness: 0.25,
        roughness_texture: texture,
    };
    assert_eq!(all[1], Extensions { fuzz: Some(fuzz), ..none.clone() });
    let plain = TextureRef { transform: Affine2::IDENTITY, ..texture.unwrap() };
    let coat = Clearcoat {
        factor: 0.5,
        texture,
        roughness: 0.25,
        roughness_texture: texture,
        normal_texture: Some(NormalTexture { texture: plain, scale: -3.0 }),
        ior: 1.75,
        color,
        color_texture: texture,
        darkening: 0.75,
        anisotropy: Anisotropy { strength: 0.6, rotation: 1.5, texture },
    };
    assert_eq!(all[2], Extensions { clearcoat: Some(coat), ..none });
}

#[test]
fn what_the_file_does_not_say_is_the_drafts_default() {
    let e = read("fuzz", json!({"fuzzFactor": 1}));
    assert_eq!(e.fuzz.map(|f| (f.color, f.roughness)), Some((Vec3::ONE, 0.5)));
    let e = read("coat", json!({"coatFactor": 1})).clearcoat.unwrap();
    assert_eq!(e, Clearcoat { factor: 1.0, darkening: 1.0, ..Clearcoat::default() });
    let e = read("coat", json!({"coatFactor": 1, "coatIor": 0})).clearcoat.unwrap();
    assert_eq!(e.ior, 0.0);
}

/// The older extensions are there for readers that do not know the newer ones, even where these do nothing.
#[test]
fn a_draft_goes_before_what_it_replaces() {
    let both = |coat: f32, fuzz: f32| {
        json!({"extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.25}, "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1]},
            "KHR_materials_coat": {"coatFactor": coat, "coatDarkeningFactor": 0}, "KHR_materials_fuzz": {"fuzzFactor": fuzz}
        }})
    };
    let e = draft(both(0.5, 0.75)).scene.materials[0].extensions.clone().unwrap();
    assert_eq!((e.clearcoat.unwrap().factor, e.sheen, e.fuzz.unwrap().factor), (0.5, None, 0.75));
    assert!(e.clearcoat.unwrap().is_plain());
    assert_eq!(draft(both(0.0, 0.0)).scene.materials[0].extensions, None);
    let e = with(both(0.5, 0.75)).import().scene.materials[0].extensions.clone().unwrap();
    assert_eq!((e.clearcoat.unwrap().factor, e.sheen.is_some(), e.fuzz), (0.25, true, None));
}

/// Values of drafts may be animated.
#[test]
fn drafts_are_animated() {
    let mut m =
        with(json!({"extensions": {"KHR_materials_fuzz": {}, "KHR_materials_coat": {"coatFactor": 1}}}));
    let input = m.floats(&[0.0, 2.0], "SCALAR");
    let output = m.floats(&[0., 1.], "SCALAR");
    let color = m.floats(&[1., 1., 1., 0., 1., 1.], "VEC3");
    let target = |p: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": format!("/materials/0/extensions/{p}")}}});
    m.json["animations"] = json!([{
        "samplers": [{"input": input, "output": output}, {"input": input, "output": color}],
        "channels": [
            {"sampler": 0, "target": target("KHR_materials_fuzz/fuzzFactor")},
            {"sampler": 1, "target": target("KHR_materials_coat/coatColorFactor")}
        ]
    }]);
    let i = m.import_with(&ImportOptions { at: Some(0.5), ..asked() }).unwrap();
    let e = i.scene.materials[0].extensions.clone().unwrap();
    assert_eq!((e.fuzz.unwrap().factor, e.clearcoat.unwrap().color), (0.25, Vec3::new(0.75, 1.0, 1.0)));
    let i = m.import_with(&ImportOptions { at: Some(0.5), ..ImportOptions::default() }).unwrap();
    assert_eq!(i.scene.materials[0].extensions, None);
}

#[test]
fn what_does_nothing_is_left_out_with_its_textures() {
    for (name, _, neutral) in drafts() {
        for nothing in [neutral, json!({})] {
            let mut m = with(extended(name, nothing));
            m.json["images"][0]["uri"] = json!("nowhere.png");
            let i = m.import_with(&asked()).unwrap();
            assert_eq!(i.scene.materials[0], Material::default(), "{name}");
            assert!(i.scene.images.is_empty() && i.warnings.is_empty(), "{name}: {:?}", i.warnings);
        }
    }
}

/// Without the switch the picture is the one without the extension; the warning says how to see it, `info` what it is.
#[test]
fn what_is_not_asked_for_is_named() {
    for (name, e, _) in drafts() {
        let full = format!("KHR_materials_{name}");
        let mut m = with(extended(name, e));
        m.json["extensionsUsed"] = json!([full]);
        let i = m.import();
        assert_eq!(i.scene.materials[0].extensions, None, "{name}");
        let said = format!("/materials/0/extensions/{full}: {full} is a draft; ignored without --drafts");
        assert!(warned(&i, &said), "{:?}", i.warnings);
        let info = &i.info.extensions[0];
        assert_eq!((info.support, info.draft), (Some(Support::Ignored), true), "{name}");
        let i = m.import_with(&asked()).unwrap();
        assert!(i.warnings.is_empty(), "{:?}", i.warnings);
        assert_eq!(i.info.extensions[0].support, Some(Support::Draft), "{name}");

        m.json["extensionsRequired"] = json!([full]);
        match m.import_with(&ImportOptions::default()) {
            Err(e @ ImportError::Unsupported { .. }) => {
                assert!(e.to_string().contains("--drafts") && e.to_string().contains(&full), "{e}");
            }
            other => panic!("{name}: {other:?}"),
        }
        assert!(m.import_with(&asked()).is_ok(), "{name}");
    }
    // In a place where it means nothing it is not read either way.
    let i =
        draft(json!({"normalTexture": {"index": 0, "extensions": {"KHR_materials_diffuse_roughness": {}}}}));
    assert!(
        warned(&i, "/materials/0/normalTexture/extensions/KHR_materials_diffuse_roughness"),
        "{:?}",
        i.warnings
    );
}

#[test]
fn what_is_out_of_range_is_brought_back() {
    let i = draft(extended("diffuse_roughness", json!({"diffuseRoughnessFactor": 7})));
    assert!(warned(
        &i,
        "/materials/0/extensions/KHR_materials_diffuse_roughness: diffuseRoughnessFactor outside 0..1"
    ));
    let e = i.scene.materials[0].extensions.clone().unwrap();
    assert_eq!(e.diffuse_roughness.map(|d| d.factor), Some(1.0));
}

/// A written surface is read again as the same.
#[test]
fn drafts_are_written() {
    for (name, e, _) in drafts() {
        let i = draft(extended(name, e));
        let file = export(&i.scene, &i.image_files, &ExportOptions::default()).unwrap();
        assert_eq!(file.notes, Vec::<String>::new());
        let back = import_bytes(&file.bytes, "written", &asked()).unwrap();
        assert!(back.warnings.is_empty(), "{name}: {:?}", back.warnings);
        assert_eq!(back.scene.materials[0].extensions, i.scene.materials[0].extensions, "{name}");
        assert!(back.info.extensions.iter().any(|e| e.name.ends_with(name)), "{name}");
    }
}

/// A body, or without `thickness` a sheet, with a draft of scattering.
fn milk(name: &str, thickness: f32, scatter: Value) -> Value {
    json!({"extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": thickness, "attenuationDistance": 0.5, "attenuationColor": [0.5, 0.5, 0.5]},
        format!("KHR_materials_{name}"): scatter
    }})
}

fn scatter_of(i: &Imported) -> Option<Scatter> {
    i.scene.materials[0].extensions.as_ref().and_then(|e| e.scatter)
}

/// What is written of it is read as the same.
fn written_again(i: &Imported) -> Imported {
    let file = export(&i.scene, &i.image_files, &ExportOptions::default()).unwrap();
    let back = import_bytes(&file.bytes, "written", &asked()).unwrap();
    assert_eq!(back.scene.materials[0].extensions, i.scene.materials[0].extensions);
    back
}

/// Newer and older names of the older draft; nothing without an inside.
#[test]
fn volumes_that_scatter() {
    let name = "volume_scatter";
    let color = Vec3::new(0.1, 0.2, 0.3);
    let expected = Scatter { strength: 1.0, color, anisotropy: -0.5, ..Scatter::default() };
    for key in ["multiscatterColorFactor", "multiscatterColor", "scatterAlbedo"] {
        let i = draft(milk(name, 1.0, json!({key: [0.1, 0.2, 0.3], "scatterAnisotropy": -0.5})));
        assert_eq!((scatter_of(&i), i.warnings.len()), (Some(expected), 0), "{key}");
    }
    let both = json!({"multiscatterColor": [1, 1, 1], "multiscatterColorFactor": [0.1, 0.2, 0.3]});
    let i = draft(milk(name, 1.0, both));
    assert_eq!(scatter_of(&i).map(|v| v.color), Some(color), "the newer name goes first");
    written_again(&i);
    assert_eq!(scatter_of(&draft(milk(name, 1.0, json!({})))), None);
    assert_eq!(scatter_of(&draft(milk(name, 0.0, json!({"multiscatterColorFactor": [1, 1, 1]})))), None);
    let alone = extended(name, json!({"multiscatterColorFactor": [1, 1, 1]}));
    assert_eq!(scatter_of(&draft(alone)), None);
    let textured = json!({"multiscatterColor": [1, 1, 1], "scatterAnisotropy": 3, "multiscatterColorTexture": texture()});
    let m = milk(name, 1.0, textured);
    let i = draft(m.clone());
    let s = scatter_of(&i).unwrap();
    assert_eq!((s.anisotropy, s.color_texture), (1.0, arrived()));
    let i = with(m).import();
    assert_eq!(scatter_of(&i), None);
    assert!(warned(
        &i,
        "/materials/0/extensions/KHR_materials_volume_scatter: KHR_materials_volume_scatter is a draft"
    ));
    // Beside diffuse transmission it is written by its older name, with the strength in the colour.
    let mut m = milk(name, 1.0, json!({"multiscatterColorFactor": [0.1, 0.2, 0.3]}));
    m["extensions"]["KHR_materials_diffuse_transmission"] = json!({"diffuseTransmissionFactor": 1});
    let mut i = draft(m);
    assert_eq!(scatter_of(&i).map(|s| s.color), Some(color));
    written_again(&i);
    i.scene.materials[0].extensions.as_mut().unwrap().scatter.as_mut().unwrap().strength = 0.5;
    let file = export(&i.scene, &[], &ExportOptions::default()).unwrap();
    let back = scatter_of(&import_bytes(&file.bytes, "written", &asked()).unwrap()).unwrap();
    assert_eq!((back.strength, back.color), (1.0, color * 0.5));
}

/// The newer draft: every field, in a body and in a sheet, its defaults, and what it does not go with.
#[test]
fn light_that_enters_is_scattered() {
    let name = "scatter";
    let all = json!({
        "scatterStrengthFactor": 0.5, "scatterStrengthTexture": texture(), "multiscatterColorFactor": [0.1, 0.2, 0.3],
        "multiscatterColorTexture": texture(), "scatterAnisotropy": -0.5
    });
    let color = Vec3::new(0.1, 0.2, 0.3);
    let (texture, none) = (arrived(), Scatter::default());
    let expected = Scatter { strength: 0.5, texture, color, color_texture: texture, anisotropy: -0.5 };
    for thickness in [0.0, 1.0] {
        let i = draft(milk(name, thickness, all.clone()));
        assert_eq!((scatter_of(&i), i.warnings.len()), (Some(expected), 0), "{:?}", i.warnings);
        let back = written_again(&i);
        assert!(back.info.extensions.iter().any(|e| e.name == "KHR_materials_scatter"));
        let i = draft(milk(name, thickness, json!({"scatterStrengthFactor": 1})));
        assert_eq!(scatter_of(&i), Some(Scatter { strength: 1.0, ..none }));
        // Of no strength by default.
        assert_eq!(
            scatter_of(&draft(milk(name, thickness, json!({"multiscatterColorFactor": color.to_array()})))),
            None
        );
        let i = with(milk(name, thickness, all.clone())).import();
        assert_eq!(scatter_of(&i), None);
        assert!(warned(
            &i,
            "/materials/0/extensions/KHR_materials_scatter: KHR_materials_scatter is a draft"
        ));
    }
    // Without a way in.
    assert_eq!(scatter_of(&draft(extended(name, all.clone()))), None);
    // It goes before the older one, also where it says that there is none.
    let mut m = milk(name, 1.0, all.clone());
    m["extensions"]["KHR_materials_volume_scatter"] = json!({"multiscatterColorFactor": [1, 1, 1]});
    assert_eq!(scatter_of(&draft(m.clone())), Some(expected));
    m["extensions"]["KHR_materials_scatter"] = json!({});
    assert_eq!(scatter_of(&draft(m)), None);
    // What excludes it.
    let mut m = milk(name, 1.0, all);
    m["extensions"]["KHR_materials_diffuse_transmission"] = json!({"diffuseTransmissionFactor": 0.5});
    let i = draft(m);
    assert_eq!(scatter_of(&i), None);
    assert!(warned(&i, "/materials/0/extensions/KHR_materials_scatter: stands beside"), "{:?}", i.warnings);
    let i = draft(milk(name, 1.0, json!({"scatterStrengthFactor": 7, "scatterAnisotropy": -2})));
    assert!(warned(&i, "/materials/0/extensions/KHR_materials_scatter: scatterStrengthFactor outside 0..1"));
    assert_eq!(scatter_of(&i), Some(Scatter { strength: 1.0, anisotropy: -1.0, ..none }));
}
