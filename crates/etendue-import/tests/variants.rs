//! Variants: names, mappings, the materials and the geometry that only they need.
mod common;
use common::*;
use etendue_scene::Variant;
use serde_json::{Value, json};

/// Two nodes that show one mesh of two triangles with materials 0 and none, three materials, and the named variants.
fn with_variants(names: &[&str], mappings: Value) -> Model {
    let mut m = with(json!({"name": "own"}));
    m.push("materials", json!({"name": "red"}));
    m.push("materials", json!({"name": "blue"}));
    let mut second = m.json["meshes"][0]["primitives"][0].clone();
    second.as_object_mut().unwrap().remove("material");
    second["extensions"] = json!({"KHR_materials_variants": {"mappings": mappings}});
    m.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    m.node(json!({"mesh": 0, "name": "again"}));
    let list: Vec<Value> = names.iter().map(|n| json!({"name": n})).collect();
    m.json["extensions"] = json!({"KHR_materials_variants": {"variants": list}});
    m
}

fn variant(name: &str, materials: &[[u32; 2]]) -> Variant {
    Variant { name: name.into(), materials: materials.to_vec() }
}

#[test]
fn variants_give_instances_other_materials() {
    let m = with_variants(
        &["beach", "midnight", "plain"],
        json!([{"material": 2, "variants": [0]}, {"material": 1, "variants": [1], "extras": 3}]),
    );
    let mut i = m.import();
    assert!(i.warnings.is_empty(), "{:?}", i.warnings);
    let names: Vec<&str> = i.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["own", "blue", "red"]);
    // Instances 1 and 3 are the second triangle's.
    assert_eq!(
        i.scene.variants,
        [variant("beach", &[[1, 1], [3, 1]]), variant("midnight", &[[1, 2], [3, 2]]), variant("plain", &[])]
    );
    assert_eq!(i.info.variants, ["beach", "midnight", "plain"]);
    let materials = |s: &etendue_scene::Scene| -> Vec<_> { s.instances.iter().map(|i| i.material).collect() };
    assert_eq!(materials(&i.scene), [Some(0), None, Some(0), None]);
    i.scene.select_variant("midnight").unwrap();
    assert_eq!(materials(&i.scene), [Some(0), Some(2), Some(0), Some(2)]);
    assert!(i.scene.select_variant("noon").unwrap_err().contains("\"beach\", \"midnight\", \"plain\""));
}

#[test]
fn instances_that_are_dropped_do_not_shift_the_others() {
    let mut m = with_variants(&["red"], json!([{"material": 1, "variants": [0]}]));
    // One corner makes no triangle: the first primitive is nothing to see.
    let indices = m.accessor(&[0u8], U8, "SCALAR", 1);
    m.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let s = m.import().scene;
    assert_eq!((s.meshes.len(), s.instances.len()), (1, 2));
    assert_eq!(s.variants, [variant("red", &[[0, 1], [1, 1]])]);
}

#[test]
fn what_is_wrong_with_a_variant_leaves_the_picture_alone() {
    let outcome = |names: &[&str], mappings: Value| {
        let i = with_variants(names, mappings).import();
        assert_eq!(i.scene.instances.len(), 4);
        (i.scene.variants.clone(), i.warnings.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let at = "/meshes/0/primitives/1/extensions/KHR_materials_variants/mappings";
    let nothing = vec![variant("a", &[])];
    for (mappings, warning) in [
        (
            json!([{"material": 9, "variants": [0]}]),
            "/0/material: refers to a material that does not exist; ignored",
        ),
        (
            json!([{"material": 1, "variants": []}, {"material": 1, "variants": [7]}]),
            "/1/variants: refers to a variant that does not exist; ignored",
        ),
        (json!([{"material": 1}]), "/0: `variants` is missing; ignored"),
        (
            json!([{"material": -1, "variants": [0]}]),
            "/0/material: a whole number from 0 up is needed, not -1; ignored",
        ),
        (
            json!([{"material": 1, "variants": ["a"]}]),
            "/0/variants/0: a whole number from 0 up is needed, not a string; ignored",
        ),
        (json!("red"), ": an array is needed, not a string; ignored"),
    ] {
        let (variants, warnings) = outcome(&["a"], mappings);
        assert_eq!(variants, nothing);
        assert!(warnings.len() == 1 && warnings[0].starts_with(&format!("{at}{warning}")), "{warnings:?}");
    }
    let twice = json!([{"material": 1, "variants": [0, 0]}, {"material": 2, "variants": [0]}]);
    let (variants, warnings) = outcome(&["a"], twice);
    assert_eq!(variants, [variant("a", &[[1, 1], [3, 1]])]);
    assert!(warnings.len() == 1 && warnings[0].contains("mapped more than once; its first"), "{warnings:?}");

    let mut m = with_variants(&[], json!([]));
    m.json["extensions"]["KHR_materials_variants"]["variants"] = json!([{"name": "a"}, {}]);
    let i = m.import();
    assert_eq!(i.scene.variants, [variant("a", &[]), variant("", &[])]);
    assert!(warned(&i, "/extensions/KHR_materials_variants/variants/1: `name` is missing; ignored"));
    // One mapping that is broken leaves the others.
    let (variants, _) = outcome(&["a"], json!([{"material": "x"}, {"material": 2, "variants": [0]}]));
    assert_eq!(variants, [variant("a", &[[1, 1], [3, 1]])]);
}

#[test]
fn a_mesh_has_what_the_materials_of_its_variants_need() {
    let mut m = with_variants(&["a"], json!([{"material": 1, "variants": [0]}]));
    let plain = m.import().scene;
    assert!(plain.meshes.iter().all(|m| m.tangents.is_empty() && m.uvs.len() == 1));
    m.json["materials"][1]["emissiveTexture"] = json!({"index": 0, "texCoord": 1});
    m.json["materials"][1]["normalTexture"] = json!({"index": 0});
    let s = m.import().scene;
    // The first triangle has no variants and stays as it is.
    let mesh = |instance: usize| &s.meshes[s.instances[instance].mesh as usize];
    assert!(mesh(0).tangents.is_empty() && mesh(0).uvs.len() == 1);
    assert!(mesh(1).tangents.len() == 3 && mesh(1).uvs.len() == 2);
    assert_eq!(s.images.len(), 1);
}

#[test]
fn variants_that_need_different_tangents() {
    let mut m = with_variants(&["a", "b"], json!([{"material": 1, "variants": [0]}]));
    let mappings = json!([{"material": 1, "variants": [0]}, {"material": 2, "variants": [1]}]);
    let p = &mut m.json["meshes"][0]["primitives"][1];
    p["extensions"]["KHR_materials_variants"]["mappings"] = mappings;
    m.json["materials"][1]["normalTexture"] = json!({"index": 0});
    m.json["materials"][2]["normalTexture"] = json!({"index": 0, "texCoord": 1});
    let i = m.import();
    assert!(i.warnings.len() == 1 && warned(&i, "/meshes/0/primitives/1: materials of different variants"));
    m.json["materials"][2]["normalTexture"]["texCoord"] = json!(0);
    assert!(m.import().warnings.is_empty());
}

/// Tangents are made for a coat's normal texture and for anisotropy, along the texture coordinates of the first of
/// normal texture, coat's normal texture and anisotropy texture that is there.
#[test]
fn tangents_for_coats_and_anisotropy() {
    let tangent = |material: Value| {
        let mut m = with(material);
        // Set 1 is set 0 with u and v exchanged: along it the tangent is the y axis.
        let swapped = m.floats(&[0., 0., 0., 1., 1., 0.], "VEC2");
        m.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(swapped);
        let i = m.import();
        assert!(i.warnings.is_empty(), "{:?}", i.warnings);
        i.scene.meshes[0].tangents.first().map(|t| t.truncate().round().to_array())
    };
    let (x, y) = (Some([1., 0., 0.]), Some([0., 1., 0.]));
    let coat = |normal: Value, factor: f32| json!({"KHR_materials_clearcoat": {"clearcoatFactor": factor, "clearcoatNormalTexture": normal}});
    let on = |set: u32| json!({"index": 0, "texCoord": set});
    assert_eq!(tangent(json!({"extensions": coat(on(0), 1.0)})), x);
    assert_eq!(tangent(json!({"extensions": coat(on(1), 1.0)})), y);
    assert_eq!(tangent(json!({"extensions": coat(on(1), 0.0)})), None);
    assert_eq!(tangent(json!({"normalTexture": on(0), "extensions": coat(on(1), 1.0)})), x);
    assert_eq!(tangent(json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}})), None);
    let brushed = |more: Value| {
        let mut e = json!({"anisotropyStrength": 1});
        e.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({"extensions": {"KHR_materials_anisotropy": e}})
    };
    assert_eq!(tangent(brushed(json!({}))), x);
    assert_eq!(tangent(brushed(json!({"anisotropyTexture": on(1)}))), y);
    assert_eq!(tangent(brushed(json!({"anisotropyStrength": 0}))), None);
    let mut both = brushed(json!({"anisotropyTexture": on(0)}));
    both["normalTexture"] = on(1);
    assert_eq!(tangent(both), y);

    let mut m = with(brushed(json!({})));
    let attributes = m.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    attributes.retain(|k, _| k == "POSITION");
    let i = m.import();
    assert!(warned(&i, "/meshes/0/primitives/0: its material needs tangents"), "{:?}", i.warnings);
}
