//! What is against the specification is found, and nothing else is.

use etendue_import::{ImportOptions, import, import_bytes};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn options() -> ImportOptions {
    ImportOptions { conformance: true, ..ImportOptions::default() }
}

/// Breaches of a document, as lines.
fn breaches(document: &Value) -> Vec<String> {
    let model = import_bytes(document.to_string().as_bytes(), "test.gltf", &options()).expect("a model");
    model.info.breaches.iter().map(|w| format!("{}: {}", w.pointer, w.message)).collect()
}

/// A triangle with a normal each, in a data URI.
fn triangle() -> Value {
    let mut bytes = Vec::new();
    for v in [
        [0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 1.0],
    ] {
        v.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    use base64::Engine;
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(&bytes)
    );
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "material": 0 }] }],
        "materials": [{ "name": "plain" }],
        "buffers": [{ "byteLength": 72, "uri": uri }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 36 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
        ],
    })
}

fn push(d: &mut Value, list: &str, entry: Value) {
    d[list].as_array_mut().expect("a list").push(entry);
}

#[test]
fn a_good_file_is_not_blamed() {
    assert_eq!(breaches(&triangle()), [] as [&str; 0]);
}

/// A change, and where and how it is to be blamed.
#[test]
fn each_breach_is_found_in_its_place() {
    type Change = fn(&mut Value);
    let cases: [(Change, &str, &str); 23] = [
        (|d| d["animations"] = json!([]), "/animations", "empty list"),
        (|d| d["accessors"][0]["max"] = json!([1, 0.5, 0]), "/accessors/0/max", "is not the max"),
        (|d| d["accessors"][0]["min"] = json!([1, 0]), "/accessors/0/min", "2 numbers for elements of 3"),
        (
            |d| d["accessors"][0].as_object_mut().map(|o| o.remove("min")).map_or((), drop),
            "POSITION",
            "need `min`",
        ),
        (|d| d["bufferViews"][1]["byteOffset"] = json!(35), "/accessors/1/byteOffset", "not aligned"),
        (
            |d| push(d, "bufferViews", json!({ "buffer": 0, "byteLength": 28, "byteStride": 14 })),
            "/bufferViews/2/byteStride",
            "multiple of 4",
        ),
        (|d| push(d, "buffers", json!({ "byteLength": 0 })), "/buffers/1/byteLength", "no bytes"),
        (
            |d| push(d, "buffers", json!({ "byteLength": 4, "uri": "gone.bin" })),
            "/buffers/1/uri",
            "not found",
        ),
        (|d| d["images"] = json!([{}]), "/images/0", "either `uri` or `bufferView`"),
        (|d| d["images"] = json!([{ "uri": "gone.png" }]), "/images/0", "not found"),
        (|d| d["images"] = json!([{ "uri": "data:image/png;base64,/9j/" }]), "/images/0", "is image/jpeg"),
        (|d| d["textures"] = json!([{ "sampler": 3 }]), "/textures/0/sampler", "number 3 of `samplers`"),
        (|d| push(d, "materials", json!({ "normalTexture": { "index": 7 } })), "normalTexture", "texture 7"),
        (
            |d| push(d, "meshes", json!({ "primitives": [{ "attributes": { "POSITION": 9 } }] })),
            "POSITION",
            "9",
        ),
        (|d| d["meshes"][0]["weights"] = json!([1]), "/meshes/0/weights", "morph targets"),
        (
            |d| d["extensionsUsed"] = json!(["KHR_materials_ior", "KHR_materials_ior"]),
            "/extensionsUsed/1",
            "twice",
        ),
        (
            |d| d["extensionsRequired"] = json!(["KHR_materials_ior"]),
            "/extensionsRequired/0",
            "`extensionsUsed`",
        ),
        (
            |d| d["materials"][0]["extensions"] = json!({ "KHR_materials_ior": { "ior": 1.4 } }),
            "/materials/0/extensions/KHR_materials_ior",
            "not named in `extensionsUsed`",
        ),
        (
            |d| {
                d["extensionsUsed"] = json!(["KHR_materials_anisotropy"]);
                d["materials"][0]["extensions"] =
                    json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.5 } });
            },
            "/meshes/0/primitives/0/material",
            "needs tangents",
        ),
        (
            |d| {
                d["extensionsUsed"] = json!(["KHR_materials_ior"]);
                d["samplers"] = json!([{ "extensions": { "KHR_materials_ior": {} } }]);
            },
            "/samplers/0/extensions/KHR_materials_ior",
            "no place",
        ),
        (
            |d| {
                d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
                d["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot" }] } });
            },
            "/extensions/KHR_lights_punctual/lights/0",
            "no `spot`",
        ),
        (
            |d| {
                d["cameras"] =
                    json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 2, "zfar": 1 } }])
            },
            "/cameras/0/perspective",
            "beyond `znear`",
        ),
        (
            |d| {
                push(
                    d,
                    "accessors",
                    json!({ "componentType": 5126, "count": 1, "type": "VEC3", "byteOffset": 4 }),
                )
            },
            "/accessors/2/byteOffset",
            "no buffer view",
        ),
    ];
    for (change, place, what) in cases {
        let mut d = triangle();
        change(&mut d);
        let found = breaches(&d);
        assert!(found.iter().any(|b| b.contains(place) && b.contains(what)), "{place}: {what}: {found:?}");
    }
}

/// The Khronos validator's own cases: no file that is good to it is blamed, and what is bad to it is refused or spoken of.
#[test]
fn agrees_with_the_khronos_validator() {
    let root = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets/malformed/gltf-khronos-validator"
    ));
    if !root.exists() {
        println!("skipped: {} is not there", root.display());
        return;
    }
    let (mut good, mut bad, mut wrong) = (0, 0, Vec::new());
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let mut entries: Vec<PathBuf> =
            std::fs::read_dir(&folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let report = PathBuf::from(format!("{}.report.json", path.display()));
            let Ok(report) = std::fs::read(&report) else { continue };
            let report: Value = serde_json::from_slice(&report).expect("a report");
            let count = |key: &str| report["issues"][key].as_u64().unwrap_or(0);
            let result = import(&path, &options());
            let name = path.strip_prefix(root).expect("below").display().to_string();
            if count("numErrors") > 0 {
                bad += 1;
                if let Ok(m) = &result
                    && m.warnings.is_empty()
                    && m.info.breaches.is_empty()
                {
                    wrong.push(format!("{name}: nothing is said"));
                }
            } else if count("numWarnings") == 0 {
                good += 1;
                for b in result.iter().flat_map(|m| &m.info.breaches) {
                    wrong.push(format!("{name}: blamed: {b}"));
                }
            }
        }
    }
    println!("{good} good files, {bad} bad ones");
    assert!(good > 40 && bad > 150);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
