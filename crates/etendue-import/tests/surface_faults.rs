//! The material extensions: what is out of range, of the wrong type, or contradicts itself.
mod common;
use common::surfaces::*;
use common::*;
use etendue_scene::Material;
use glam::Vec3;
use serde_json::{Value, json};

#[test]
fn extensions_that_exclude_each_other() {
    let coat = json!({"clearcoatFactor": 1, "clearcoatTexture": {"index": 99}});
    let i = with(json!({"extensions": {
        "KHR_materials_clearcoat": coat, "KHR_materials_pbrSpecularGlossiness": {}
    }}))
    .import();
    let e = i.scene.materials[0].extensions.as_ref().unwrap();
    assert!(e.clearcoat.is_none() && e.specular_glossiness.is_some());
    assert!(warned(&i, "beside KHR_materials_pbrSpecularGlossiness, which excludes them; ignored"));
    let i = with(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]},
        "extensions": {
            "KHR_materials_clearcoat": coat, "KHR_materials_unlit": {}, "KHR_materials_pbrSpecularGlossiness": {}
        }
    }))
    .import();
    let m = &i.scene.materials[0];
    assert!(m.extensions.is_none() && m.unlit && m.base_color == Vec3::X);
    assert!(warned(&i, "beside KHR_materials_unlit, which excludes them; ignored"));
}

/// Every factor: extension, key, a value below its range and one above, what they are clamped to.
#[test]
fn factors_outside_their_range_are_clamped_with_a_warning() {
    let rows: [(&str, &str, f64, f64, Option<f64>); 21] = [
        ("anisotropy", "anisotropyStrength", 0.0, 1.0, Some(1.0)),
        ("clearcoat", "clearcoatFactor", 0.0, 1.0, Some(1.0)),
        ("clearcoat", "clearcoatRoughnessFactor", 0.0, 1.0, None),
        ("diffuse_transmission", "diffuseTransmissionFactor", 0.0, 1.0, Some(1.0)),
        ("diffuse_transmission", "diffuseTransmissionColorFactor", 0.0, 1.0, None),
        ("dispersion", "dispersion", 0.0, 1e18, Some(1.0)),
        ("iridescence", "iridescenceFactor", 0.0, 1.0, Some(1.0)),
        ("iridescence", "iridescenceIor", 1.0, 1e18, None),
        ("iridescence", "iridescenceThicknessMinimum", 0.0, 1e18, None),
        ("iridescence", "iridescenceThicknessMaximum", 0.0, 1e18, None),
        ("sheen", "sheenColorFactor", 0.0, 1.0, Some(1.0)),
        ("sheen", "sheenRoughnessFactor", 0.0, 1.0, None),
        ("pbrSpecularGlossiness", "diffuseFactor", 0.0, 1.0, None),
        ("pbrSpecularGlossiness", "specularFactor", 0.0, 1.0, None),
        ("pbrSpecularGlossiness", "glossinessFactor", 0.0, 1.0, None),
        ("transmission", "transmissionFactor", 0.0, 1.0, Some(1.0)),
        ("volume", "thicknessFactor", 0.0, 1e18, Some(1.0)),
        ("volume", "attenuationColor", 0.0, 1.0, None),
        ("clearcoat", "clearcoatNormalTexture", -1e18, 1e18, None),
        ("anisotropy", "anisotropyRotation", f64::NEG_INFINITY, f64::INFINITY, None),
        ("volume", "attenuationDistance", 1e-18, f64::INFINITY, None),
    ];
    let switches: Vec<(&str, &str, f64)> =
        rows.iter().filter_map(|&(e, k, _, _, on)| Some((e, k, on?))).collect();
    for (name, key, min, max, _) in rows {
        for value in [-3e18, 3e18] {
            // A material whose extensions do something, so that the others of their factors matter.
            let mut m = json!({"extensions": {}});
            let gloss = name == "pbrSpecularGlossiness";
            for (e, k, on) in switches.iter().filter(|_| !gloss) {
                let on = if k.contains("Color") { json!([on, on, on]) } else { json!(on) };
                m["extensions"][format!("KHR_materials_{e}")] = json!({*k: on});
            }
            let slot = &mut m["extensions"][format!("KHR_materials_{name}")];
            if !slot.is_object() {
                *slot = json!({});
            }
            slot[key] = match key {
                "diffuseFactor" => json!(vec![value; 4]),
                "specularFactor" => json!(vec![value; 3]),
                "clearcoatNormalTexture" => json!({"index": 0, "scale": value}),
                _ if key.contains("Color") => json!(vec![value; 3]),
                _ => json!(value),
            };
            let i = with(m).import();
            let made = &i.scene.materials[0];
            assert!(made.is_finite(), "{key}");
            let bound = if value < 0.0 { min } else { max };
            if bound.is_infinite() {
                assert!(i.warnings.is_empty(), "{key}: {:?}", i.warnings);
                continue;
            }
            let place = format!("/materials/0/extensions/KHR_materials_{name}: {key}");
            assert!(warned(&i, &place), "{key} {value}: {:?}", i.warnings);
            let Some(got) = value_of(made, key) else {
                // Clamped to where the extension does nothing.
                assert!(value < 0.0, "{key}");
                continue;
            };
            let bound = if key == "attenuationDistance" { f64::INFINITY } else { bound };
            assert_eq!(got, bound as f32, "{key} {value}");
        }
    }
}

/// What became of the factor `key`; `None` if its extension was left out.
fn value_of(m: &Material, key: &str) -> Option<f32> {
    let e = m.extensions.as_deref()?;
    Some(match key {
        "anisotropyStrength" => e.anisotropy?.strength,
        "clearcoatFactor" => e.clearcoat?.factor,
        "clearcoatRoughnessFactor" => e.clearcoat?.roughness,
        "clearcoatNormalTexture" => e.clearcoat?.normal_texture?.scale,
        "diffuseTransmissionFactor" => e.diffuse_transmission?.factor,
        "diffuseTransmissionColorFactor" => e.diffuse_transmission?.color.y,
        "dispersion" => e.dispersion,
        "iridescenceFactor" => e.iridescence?.factor,
        "iridescenceIor" => e.iridescence?.ior,
        "iridescenceThicknessMinimum" => e.iridescence?.thickness[0],
        "iridescenceThicknessMaximum" => e.iridescence?.thickness[1],
        "sheenColorFactor" => e.sheen?.color.z,
        "sheenRoughnessFactor" => e.sheen?.roughness,
        "diffuseFactor" => m.alpha,
        "specularFactor" => e.specular_glossiness?.specular.x,
        "glossinessFactor" => e.specular_glossiness?.glossiness,
        "transmissionFactor" => e.transmission?.factor,
        "thicknessFactor" => e.volume?.thickness,
        "attenuationColor" => e.volume?.attenuation_color.x,
        "attenuationDistance" => e.volume?.attenuation_distance,
        other => panic!("{other}"),
    })
}

/// Every key of every extension, with a value of the wrong type: factors are left out with a warning that names them,
/// broken texture references and references to nothing are faults that name them.
#[test]
fn wrong_types_and_references_to_nothing() {
    let mut all: Vec<(&str, Value)> = samples().into_iter().map(|(n, e, _)| (n, e)).collect();
    all.push(("dispersion", json!({"dispersion": 1})));
    all.push((
        "pbrSpecularGlossiness",
        json!({
            "diffuseFactor": [1, 1, 1, 1], "diffuseTexture": {"index": 0}, "specularFactor": [1, 1, 1],
            "glossinessFactor": 1, "specularGlossinessTexture": {"index": 0}
        }),
    ));
    all.push((
        "volume",
        json!({"thicknessFactor": 1, "thicknessTexture": {"index": 0}, "attenuationDistance": 1,
            "attenuationColor": [1, 1, 1]}),
    ));
    let mut keys = 0;
    for (name, extension) in &all {
        for key in extension.as_object().unwrap().keys() {
            keys += 1;
            let place = format!("/materials/0/extensions/KHR_materials_{name}/{key}");
            // Volumes and dispersion are looked at only where light gets in.
            let mut m = json!({"extensions": {}});
            if *name != "pbrSpecularGlossiness" {
                m["extensions"]["KHR_materials_transmission"] = json!({"transmissionFactor": 1});
            }
            m["extensions"][format!("KHR_materials_{name}")] = extension.clone();
            let mut broken = |value: Value| {
                m["extensions"][format!("KHR_materials_{name}")][key] = value;
                with(m.clone())
            };
            if key.ends_with("Texture") {
                let e = broken(json!("a.png")).error();
                assert!(e.contains(&format!("{place}: an object is needed, not a string")), "{e}");
                let e = broken(json!({"index": 99})).error();
                assert!(e.contains(&format!("{place}/index: texture 99 does not exist")), "{e}");
            } else {
                let i = broken(json!("a lot")).import();
                assert!(warned(&i, &format!("{place}: ")) && warned(&i, "needed, not a string; ignored"));
                assert_eq!(i.warnings.len(), 1, "{:?}", i.warnings);
            }
        }
        let e = with(extended(name, json!(3))).error();
        assert!(e.contains("an object is needed, not a number"), "{e}");
    }
    assert_eq!(keys, 34);
}
