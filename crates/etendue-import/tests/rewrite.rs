//! glTF into glTF: what has to stay, what has to change, and what must not be lost on the way.
mod common;
use common::scenes::{Tangents, assert_same};
use common::*;
use etendue_import::{Changes, Form, ImportOptions, ModelFile, Rewritten};
use serde_json::{Value, json};

fn rewrite(bytes: &[u8], form: Form) -> Rewritten {
    let options = ImportOptions::default();
    let file = ModelFile::from_bytes(bytes, "test.glb", &options);
    file.rewrite(form).unwrap_or_else(|e| panic!("{e}")).unwrap()
}

/// JSON and buffer of a GLB.
fn parts(glb: &[u8]) -> (Value, Vec<u8>) {
    let n = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&glb[20..20 + n]).unwrap();
    (json, glb.get(28 + n..).unwrap_or_default().to_vec())
}

fn number(v: &Value) -> usize {
    v.as_u64().unwrap_or(0) as usize
}

/// The bytes of view `n`.
fn view((json, bin): &(Value, Vec<u8>), n: usize) -> Vec<u8> {
    let v = &json["bufferViews"][n];
    let from = number(&v["byteOffset"]);
    bin[from..from + number(&v["byteLength"])].to_vec()
}

/// Shows the same at rest and while it moves; writes the same again, in both forms; has one buffer without gaps that four bytes
/// do not explain. Returns the result.
fn check(model: &Model, tangents: Tangents) -> (Rewritten, (Value, Vec<u8>)) {
    let glb = model.glb();
    let again = rewrite(&glb, Form::Binary);
    assert!(rewrite(&again.bytes, Form::Binary).bytes == again.bytes, "no fixed point");
    let text = rewrite(&glb, Form::Text).bytes;
    assert!(rewrite(&text, Form::Text).bytes == text, "no fixed point as text");
    assert!(rewrite(&text, Form::Binary).bytes == again.bytes, "text and binary differ");
    for at in [None, Some(0.3), Some(0.9)] {
        let options = ImportOptions { at, ..ImportOptions::default() };
        let import = |bytes| etendue_import::import_bytes(bytes, "test.glb", &options).unwrap();
        let (a, b) = (import(&glb), import(&again.bytes));
        assert_same(&a.scene, &b.scene, tangents, &format!("at {at:?}"));
    }
    let both = parts(&again.bytes);
    let mut end = 0;
    for v in both.0["bufferViews"].as_array().into_iter().flatten() {
        assert_eq!(number(&v["byteOffset"]), end, "views begin at the next multiple of four");
        end = (end + number(&v["byteLength"])).next_multiple_of(4);
    }
    assert_eq!(both.0["buffers"].as_array().map_or(0, Vec::len), usize::from(end > 0));
    (again, both)
}

/// Two triangles with a common edge, whose texture coordinates are mirrored at it; on a node with a skin, morphing, under others;
/// with everything that moves.
fn moving() -> Model {
    let mut m = Model::new();
    let p = m.floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., -1., 0.5, 0.25], "VEC3");
    m.json["accessors"][p as usize]["min"] = json!([-1, 0, 0]);
    m.json["accessors"][p as usize]["max"] = json!([1, 1, 0.25]);
    let n = m.floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3");
    let uv = m.floats(&[0., 0., 1., 0., 0., 1., 1., 0.5], "VEC2");
    let color = m.accessor(&[255u8, 0, 9, 0, 1, 2, 3, 4, 5, 6, 7, 8, 100, 200, 50, 25], U8, "VEC4", 4);
    m.json["accessors"][color as usize]["normalized"] = json!(true);
    let joints = m.accessor(&[0u8, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0], U8, "VEC4", 4);
    let weights = m.floats(&[0.5, 0.5, 0., 0., 1., 0., 0., 0., 0.25, 0.75, 0., 0., 1., 0., 0., 0.], "VEC4");
    // Three bytes per element, four apart.
    let custom = m.view(&[1u8, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 10, 11, 12, 0]);
    m.json["bufferViews"][custom as usize]["byteStride"] = json!(4);
    let custom =
        m.push("accessors", json!({"bufferView": custom, "componentType": U8, "count": 4, "type": "VEC3"}));
    let up = m.floats(&[0., 0., 1., 0., 0., 2., 0., 0., 3., 0., 0., 4.], "VEC3");
    let (at, values) = (m.view(&[1u8, 3]), m.view(&[0.5f32, 0., 0., 0., 0.25, 0.].bytes()));
    let sparse = m.push(
        "accessors",
        json!({"componentType": F32, "count": 4, "type": "VEC3", "sparse": {
        "count": 2, "indices": {"bufferView": at, "componentType": U8}, "values": {"bufferView": values}}}),
    );
    let indices = m.accessor(&[0u16, 1, 2, 0, 2, 3], U16, "SCALAR", 6);
    let attributes = json!({"POSITION": p, "NORMAL": n, "TEXCOORD_0": uv, "COLOR_0": color, "JOINTS_0": joints,
        "WEIGHTS_0": weights, "_PART": custom});
    let mesh = m.mesh(json!({
        "attributes": attributes, "indices": indices, "material": 0, "extras": {"why": ["not", 1.5]},
        "targets": [{"POSITION": up}, {"POSITION": sparse}],
        "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1, 0]}]}}
    }));
    m.json["meshes"][0]["weights"] = json!([0.0, 0.5]);
    m.json["meshes"][0]["extras"] = json!({"targetNames": ["up", "out"]});
    m.push("images", json!({"uri": data_uri(&png()), "name": "picture"}));
    m.push("textures", json!({"source": 0}));
    m.push("materials", json!({"name": "bumpy", "normalTexture": {"index": 0}, "doubleSided": true}));
    m.push("materials", json!({"name": "plain"}));
    let bind: Vec<f32> =
        (0..2).flat_map(|k| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., k as f32, 0., 0., 1.]).collect();
    let bind = m.floats(&bind, "MAT4");
    m.push("skins", json!({"joints": [2, 3], "inverseBindMatrices": bind, "skeleton": 2, "name": "bones"}));
    m.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}));
    m.node(json!({"name": "root", "children": [1, 2], "scale": [2, 2, 2]}));
    m.push("nodes", json!({"mesh": mesh, "skin": 0, "name": "skinned", "weights": [0.25, 0]}));
    m.push("nodes", json!({"children": [3], "translation": [0, 1, 0], "name": "hip"}));
    m.push("nodes", json!({"camera": 0, "rotation": [0, 0, 0.6, 0.8], "extras": 7}));
    let time = m.floats(&[0., 0.5, 1.], "SCALAR");
    m.json["accessors"][time as usize]["min"] = json!([0]);
    m.json["accessors"][time as usize]["max"] = json!([1]);
    let move_ = m.floats(&[0., 0., 0., 1., 0., 0., 1., 2., 0.], "VEC3");
    let morph = m.floats(&[0., 1., 0.5, 0.5, 1., 0.], "SCALAR");
    let color = m.floats(&[1., 0., 0., 1., 0., 1., 0., 1., 0., 0., 1., 0.5], "VEC4");
    let pointer =
        |p: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": p}}});
    m.push(
        "animations",
        json!({"name": "go",
        "samplers": [
            {"input": time, "output": move_},
            {"input": time, "output": morph, "interpolation": "STEP"},
            {"input": time, "output": color}],
        "channels": [
            {"sampler": 0, "target": {"node": 3, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "weights"}},
            {"sampler": 2, "target": pointer("/materials/0/pbrMetallicRoughness/baseColorFactor")}]}),
    );
    m.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "a"}, {"name": "b", "extras": {}}]}});
    m.json["extensionsUsed"] = json!(["KHR_materials_variants", "KHR_animation_pointer"]);
    m.json["asset"]["extras"] = json!({"note": "kept"});
    m
}

/// The JSON without what a rewriting may change.
fn rest(mut json: Value) -> Value {
    for key in ["buffers", "bufferViews", "accessors", "images"] {
        json.as_object_mut().unwrap().remove(key);
    }
    for p in json["meshes"].as_array_mut().into_iter().flatten() {
        for p in p["primitives"].as_array_mut().into_iter().flatten() {
            p.as_object_mut().unwrap().remove("indices");
            p["attributes"].as_object_mut().unwrap().remove("TANGENT");
        }
    }
    json
}

#[test]
fn what_moves_still_moves() {
    let m = moving();
    let (again, (json, bin)) = check(&m, Tangents::Any);
    assert_eq!(rest(parts(&m.glb()).0), rest(json.clone()));
    let expected = Changes { embedded: 1, tangents: 1, split_vertices: 2, ..Changes::default() };
    assert_eq!((again.changes, again.notes), (expected, vec![]));
    // The two vertices of the edge are there twice, with all that they have.
    let source = parts(&m.glb());
    let array = |doc: &(Value, Vec<u8>), a: usize, size: usize| -> Vec<Vec<u8>> {
        let a = &doc.0["accessors"][a];
        let v = number(&a["bufferView"]);
        let stride = doc.0["bufferViews"][v]["byteStride"].as_u64().unwrap_or(size as u64) as usize;
        view(doc, v).chunks(stride).map(|c| c[..size].to_vec()).collect()
    };
    let both = (json, bin);
    let p = &both.0["meshes"][0]["primitives"][0];
    for (name, size) in [("POSITION", 12), ("COLOR_0", 4), ("JOINTS_0", 4), ("WEIGHTS_0", 16), ("_PART", 3)] {
        let (old, new) = (
            number(&source.0["meshes"][0]["primitives"][0]["attributes"][name]),
            number(&p["attributes"][name]),
        );
        let (old, new) = (array(&source, old, size), array(&both, new, size));
        assert_eq!((&new[..4], &new[4..]), (&old[..], &[old[0].clone(), old[2].clone()][..]), "{name}");
    }
    let second = array(&both, number(&p["targets"][1]["POSITION"]), 12);
    assert_eq!(second[1], [0.5f32, 0., 0.].bytes());
    assert_eq!(second[4], second[0]);
    let indices = array(&both, number(&p["indices"]), 2).concat();
    assert_eq!(indices, [0u16, 1, 2, 4, 5, 3].bytes());
    // Nothing is left of what was replaced: 4 vertices became 6, of 12 + 12 + 8 + 4 + 4 + 16 + 3 bytes and two targets.
    let shown: usize =
        (0..both.0["bufferViews"].as_array().unwrap().len()).map(|v| view(&both, v).len()).sum();
    let vertices = 6 * (12 + 12 + 8 + 4 + 4 + 16 + 4 + 12 + 12 + 16);
    assert_eq!(shown, vertices + 12 + 2 * 64 + (3 + 9 + 6 + 12) * 4 + png().len());
}

#[test]
fn what_is_not_known_keeps_its_numbers() {
    let mut m = moving();
    let unknown = m.view(b"something else");
    m.json["extensionsUsed"].as_array_mut().unwrap().push(json!("ACME_thing"));
    m.json["nodes"][0]["extensions"] =
        json!({"ACME_thing": {"bufferView": unknown, "accessor": 0, "deep": [{"at": 1}]}});
    let (again, both) = check(&m, Tangents::Any);
    assert_eq!(rest(m.json.clone())["nodes"], both.0["nodes"]);
    assert_eq!(view(&both, unknown as usize), b"something else");
    // What it may refer to is as it was; the primitive has arrays of its own.
    let (old, new) = (&m.json["accessors"], &both.0["accessors"]);
    let before = old.as_array().unwrap().len();
    assert_eq!(&old.as_array().unwrap()[..], &new.as_array().unwrap()[..before]);
    assert_eq!(again.changes.split_vertices, 2);
    // An extension that may count on the vertices themselves keeps them from being split.
    m.json["meshes"][0]["primitives"][0]["extensions"]["ACME_thing"] = json!({"of": 4});
    let (again, both) = check(&m, Tangents::Any);
    assert_eq!(again.changes.tangents, 0);
    assert!(again.notes[0].starts_with("/meshes/0/primitives/0: no tangents"), "{:?}", again.notes);
    assert_eq!(both.0["meshes"], m.json["meshes"]);
}

#[test]
fn text_stays_as_it_is_written() {
    let text = r#"{ "scene":0, "extras" : {"z":1.50, "a":-0.0, "big":1e400000, "u":"\u00e9"},
        "asset":{"version":"2.0"}, "nodes":[{"translation":[1.10, 2E0, 0.30000001192092896]}], "scenes":[{"nodes":[0]}]}"#;
    let text = text.replace("1e400000", "123456789012345678901234567890");
    let again = rewrite(text.as_bytes(), Form::Text).bytes;
    let expected = r#"{"scene":0,"extras":{"z":1.50,"a":-0.0,"big":123456789012345678901234567890,"u":"\u00e9"},"asset":{"version":"2.0"},"nodes":[{"translation":[1.10,2E0,0.30000001192092896]}],"scenes":[{"nodes":[0]}]}"#;
    assert_eq!(String::from_utf8(again).unwrap(), expected);
}

#[test]
fn primitives_that_share_vertices_still_do() {
    let mut m = moving();
    // The same vertices in a strip, without indices, in another mesh, and as points; and positions alone elsewhere.
    let p = m.json["meshes"][0]["primitives"][0].clone();
    let with = |mode: u32, material: u32, indices: Option<u32>| {
        let mut p = p.clone();
        p["mode"] = json!(mode);
        p["material"] = json!(material);
        p.as_object_mut().unwrap().remove("indices");
        if let Some(i) = indices {
            p["indices"] = json!(i);
        }
        p
    };
    let list = m.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    list.extend([with(5, 0, None), with(4, 1, None), with(0, 1, None), p.clone()]);
    let own = m.mesh(json!({"attributes": {"POSITION": p["attributes"]["POSITION"]}}));
    m.node(json!({"mesh": own}));
    let (again, both) = check(&m, Tangents::Any);
    assert_eq!(again.changes.tangents, 3);
    let primitives = &both.0["meshes"][0]["primitives"];
    let attributes = |k: usize, name: &str| number(&primitives[k]["attributes"][name]);
    assert!((1..5).all(|k| attributes(k, "POSITION") == attributes(0, "POSITION")));
    assert!(attributes(0, "TANGENT") > 0 && primitives[2]["attributes"]["TANGENT"].is_null());
    assert_eq!(primitives[4]["indices"], primitives[0]["indices"]);
    // Four points and one triangle, though there are more vertices now.
    let count = |k: usize| both.0["accessors"][number(&primitives[k]["indices"])]["count"].clone();
    assert_eq!((count(2), count(3)), (json!(4), json!(4)));
    assert_ne!(both.0["meshes"][1]["primitives"][0]["attributes"]["POSITION"], attributes(0, "POSITION"));
    assert_eq!(both.0["accessors"][0]["count"], 4, "positions of others are not touched");
}

#[test]
fn views_that_several_share_lose_only_what_nobody_shows() {
    let mut m = moving();
    // All floats of the vertices, and something that is not theirs between them, in one view.
    let (mut bytes, mut parts_of) = (Vec::new(), Vec::new());
    let source = (m.json.clone(), m.bytes.clone());
    let keep = [7.0f32, 8.0, 9.0];
    for a in [0usize, 1, 2] {
        parts_of.push((a, bytes.len()));
        bytes.extend(view(&source, number(&source.0["accessors"][a]["bufferView"])));
        if a == 1 {
            parts_of.push((usize::MAX, bytes.len()));
            bytes.extend(keep.bytes());
        }
    }
    let shared = m.view(&bytes);
    for (a, offset) in parts_of {
        if a == usize::MAX {
            let a = m.push("accessors", json!({"bufferView": shared, "byteOffset": offset, "componentType": F32, "count": 1, "type": "VEC3"}));
            m.node(json!({"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": a}}}}));
        } else {
            m.json["accessors"][a]["bufferView"] = json!(shared);
            m.json["accessors"][a]["byteOffset"] = json!(offset);
        }
    }
    m.json["extensionsUsed"].as_array_mut().unwrap().push(json!("EXT_mesh_gpu_instancing"));
    let (_, both) = check(&m, Tangents::Any);
    let a = number(&both.0["nodes"][4]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"]);
    let a = &both.0["accessors"][a];
    assert_eq!(view(&both, number(&a["bufferView"])), keep.bytes());
    assert_eq!(number(&a["byteOffset"]), 0);
}

#[test]
fn files_beside_the_model_move_into_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let mut m = moving();
    let ies = b"IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 50\n";
    write("a.png", &png());
    write("b c.png", &png());
    write("lamp.ies", ies);
    write("all.bin", &m.bytes);
    m.json["buffers"] = json!([{"uri": "all.bin", "byteLength": m.bytes.len(), "name": "main"}]);
    m.json["images"] = json!([{"uri": "a.png"}, {"uri": "b%20c.png", "mimeType": "image/jpeg"},
        {"uri": "a.png"}, {"uri": "gone.png", "name": "unused"}]);
    m.json["extensions"]["EXT_lights_ies"] = json!({"lights": [{"uri": "lamp.ies"}]});
    m.json["nodes"][3]["extensions"] = json!({"EXT_lights_ies": {"light": 0}});
    write("m.gltf", &serde_json::to_vec(&m.json).unwrap());
    let options = ImportOptions::default();
    let file = ModelFile::read(&folder.path().join("m.gltf"), &options).unwrap();
    let again = file.rewrite(Form::Binary).unwrap().unwrap();
    assert_eq!(again.changes.embedded, 4);
    assert_eq!(again.notes.len(), 1);
    assert!(again.notes[0].contains("/images/3") && again.notes[0].contains("gone.png"), "{:?}", again.notes);
    let both = parts(&again.bytes);
    let images = &both.0["images"];
    let views: Vec<_> = (0..3).map(|i| number(&images[i]["bufferView"])).collect();
    assert_eq!(views, [views[0]; 3], "the same bytes once");
    assert_eq!(view(&both, views[0]), png());
    assert_eq!((&images[1]["mimeType"], &images[1]["uri"]), (&json!("image/png"), &Value::Null));
    assert_eq!(images[3], m.json["images"][3]);
    let lamp = &both.0["extensions"]["EXT_lights_ies"]["lights"][0];
    assert_eq!(view(&both, number(&lamp["bufferView"])), ies);
    assert_eq!(lamp["mimeType"], "application/x-ies-lm-63");
    assert_eq!(both.0["buffers"][0]["name"], "main");
    let alone = etendue_import::import_bytes(&again.bytes, "again", &options).unwrap();
    assert_same(&file.open().unwrap().at(None).unwrap().scene, &alone.scene, Tangents::Any, "alone");
    assert_eq!(alone.scene.lights.len(), 1);
}

#[test]
fn what_is_not_there_cannot_be_kept() {
    let options = ImportOptions::default();
    let refused = |m: &Model, options: &ImportOptions| {
        let glb = m.glb();
        let again = ModelFile::from_bytes(&glb, "test.glb", options).rewrite(Form::Binary);
        again.err().map(|e| e.to_string()).unwrap_or_default()
    };
    let mut m = moving();
    let unused = m.view(&[1, 2, 3, 4]);
    m.json["bufferViews"][unused as usize]["byteLength"] = json!(1 << 20);
    assert!(refused(&m, &options).contains(&format!("/bufferViews/{unused}: 1048576 bytes")));
    let mut m = moving();
    m.json["meshes"][0]["primitives"][0]["indices"] = json!(99);
    assert_eq!(refused(&m, &options), m.error());
    // What nothing shows may not come to be by what is added.
    let mut m = moving();
    m.push("images", json!({"bufferView": 99, "mimeType": "image/png"}));
    assert!(refused(&m, &options).contains("buffer view 99"), "{}", refused(&m, &options));
    let mut tight = options.clone();
    tight.limits.vertices = 3;
    assert!(refused(&moving(), &tight).contains("`vertices`"), "{}", refused(&moving(), &tight));
    // No glTF at all is not this function's business.
    let ply = b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n";
    assert!(ModelFile::from_bytes(ply, "m.ply", &options).rewrite(Form::Binary).unwrap().is_none());
}

#[test]
fn textures_say_what_their_pictures_need() {
    let mut m = moving();
    // As small as WebP gets: nothing decodes it here, as no material has it.
    m.push("images", json!({"uri": data_uri(b"RIFF\x04\0\0\0WEBP")}));
    m.push("textures", json!({"sampler": 0, "source": 1}));
    m.push("textures", json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}));
    m.push("samplers", json!({}));
    let (again, both) = check(&m, Tangents::Any);
    assert_eq!(again.changes.mended_textures, 1);
    assert_eq!(both.0["textures"][0], m.json["textures"][0]);
    assert_eq!(
        both.0["textures"][1],
        json!({"sampler": 0, "extensions": {"EXT_texture_webp": {"source": 1}}})
    );
    assert_eq!(both.0["textures"][2], m.json["textures"][2]);
    assert_eq!(both.0["extensionsRequired"], json!(["EXT_texture_webp"]));
    assert_eq!(both.0["images"][1]["mimeType"], "image/webp");
}

#[test]
fn what_nothing_shows_is_bounded_too() {
    // An accessor without data may claim any number of zeros, and a broken list of indices tells nothing about it.
    let mut m = moving();
    let huge = m.push("accessors", json!({"componentType": F32, "count": 4_000_000_000u32, "type": "VEC3"}));
    let uv = m.push("accessors", json!({"componentType": F32, "count": 4_000_000_000u32, "type": "VEC2"}));
    m.mesh(json!({"attributes": {"POSITION": huge, "NORMAL": huge, "TEXCOORD_0": uv}, "material": 0, "indices": uv}));
    let glb = m.glb();
    let options = ImportOptions::default();
    let again = ModelFile::from_bytes(&glb, "test.glb", &options).rewrite(Form::Binary);
    let why = again.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(why.contains("/meshes/1/primitives/0") && why.contains("`vertices`"), "{why}");
}

#[test]
fn every_cut_and_every_flipped_byte_is_survived() {
    let glb = moving().glb();
    let options = ImportOptions::default();
    let run = |bytes: &[u8]| {
        let Ok(Some(again)) = ModelFile::from_bytes(bytes, "test.glb", &options).rewrite(Form::Binary) else {
            return false;
        };
        let twice = rewrite(&again.bytes, Form::Binary);
        assert!(twice.bytes == again.bytes, "no fixed point");
        true
    };
    (0..glb.len()).step_by(7).for_each(|cut| assert!(!run(&glb[..cut])));
    let mut written = 0;
    for i in 0..glb.len() {
        let mut b = glb.clone();
        b[i] ^= [1, 0x80, 0x10][i % 3];
        written += u32::from(run(&b));
    }
    assert!(written > 800, "most flips leave a file that can be written: {written} of {}", glb.len());
}
