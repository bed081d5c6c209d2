//! Every model and every malformed file of the shared assets: a scene or a clear error.
//!
//! Skips with a message where the assets are not there. `cargo test -p etendue-import --release --test suite -- --nocapture`
//! prints the tables.
mod common;
use etendue_import::{AnimationChoice, ImportError, ImportOptions, import, import_bytes};
use etendue_scene::Extensions;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// `sub` in the asset folder, if it is there.
fn assets(sub: &str) -> Option<PathBuf> {
    let p = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets")).join(sub);
    if p.is_dir() {
        return Some(p);
    }
    println!("skipped: no assets at {}", p.display());
    None
}

fn models(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let mut stack = vec![folder.to_owned()];
    while let Some(dir) = stack.pop() {
        for e in std::fs::read_dir(dir).unwrap().flatten() {
            let p = e.path();
            if p.is_dir() {
                stack.push(p);
            } else if matches!(p.extension().and_then(|e| e.to_str()), Some("gltf" | "glb")) {
                out.push(p);
            }
        }
    }
    out.sort();
    out
}

/// Without these, or with data that only they can hold, a file may be refused.
const REFUSED: [&str; 3] = ["FAKE_materials_quantumRendering", "glTF 2.1", "DDS textures"];

#[test]
fn every_model_loads_or_names_what_it_requires() {
    let Some(folder) = assets("models") else { return };
    let files = models(&folder);
    let (mut shown, mut refused) = (0, 0);
    for file in &files {
        match import(file, &ImportOptions::default()) {
            Ok(_) => shown += 1,
            Err(ImportError::Unsupported { what, .. }) if REFUSED.iter().any(|r| what.contains(r)) => {
                refused += 1
            }
            Err(e) => panic!("{e}"),
        }
        // Any moment of all animations together.
        let o = ImportOptions { at: Some(0.7), animation: AnimationChoice::All, ..ImportOptions::default() };
        if let Err(e) = import(file, &o) {
            assert!(matches!(e, ImportError::Unsupported { .. }), "{e}");
        }
    }
    println!("{} models: {shown} shown, {refused} refused for what they require", files.len());
    assert!(shown >= 127, "{shown} of {}", files.len());
}

/// Per extension: the key that switches it on, and whether the material has it.
type Switch = (&'static str, &'static str, fn(&Extensions) -> bool);
const SWITCHES: [Switch; 7] = [
    ("anisotropy", "anisotropyStrength", |e| e.anisotropy.is_some()),
    ("clearcoat", "clearcoatFactor", |e| e.clearcoat.is_some()),
    ("diffuse_transmission", "diffuseTransmissionFactor", |e| e.diffuse_transmission.is_some()),
    ("iridescence", "iridescenceFactor", |e| e.iridescence.is_some()),
    ("sheen", "sheenColorFactor", |e| e.sheen.is_some()),
    ("transmission", "transmissionFactor", |e| e.transmission.is_some()),
    ("volume", "thicknessFactor", |e| e.volume.is_some()),
];

/// The document of a glTF or GLB file.
fn document(file: &Path) -> Value {
    let bytes = std::fs::read(file).unwrap();
    let json = match bytes.strip_prefix(b"glTF") {
        Some(rest) => {
            let length = u32::from_le_bytes(rest[8..12].try_into().unwrap()) as usize;
            &rest[16..16 + length]
        }
        None => &bytes[..],
    };
    serde_json::from_slice(json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json)).unwrap()
}

/// The extensions that material `d` of a file switches on.
fn switched_on(d: &Value) -> Vec<&'static str> {
    let extension = |name: &str| &d["extensions"][format!("KHR_materials_{name}")];
    let on = |v: &Value| v.as_f64().is_some_and(|v| v > 0.0);
    if extension("unlit").is_object() {
        return Vec::new();
    }
    if extension("pbrSpecularGlossiness").is_object() {
        return vec!["pbrSpecularGlossiness"];
    }
    let mut out: Vec<&str> = SWITCHES
        .iter()
        .filter(|(name, key, _)| {
            let value = &extension(name)[key];
            on(value) || value.as_array().is_some_and(|v| v.iter().any(on))
        })
        .map(|s| s.0)
        .collect();
    let lets_light_in = out.iter().any(|n| n.ends_with("transmission"));
    out.retain(|n| *n != "volume" || lets_light_in);
    let refracts = out.contains(&"transmission") && out.contains(&"volume");
    out.extend((refracts && on(&extension("dispersion")["dispersion"])).then_some("dispersion"));
    out
}

/// A material has an extension if and only if the file switches it on, and no warning says that one is not supported.
#[test]
fn material_extensions_arrive() {
    let Some(folder) = assets("models") else { return };
    let (mut compared, mut present) = (0, 0);
    for file in models(&folder) {
        let Ok(i) = import(&file, &ImportOptions::default()) else { continue };
        let doc = document(&file);
        let root = doc["extensions"]["KHR_materials_variants"]["variants"].as_array();
        assert_eq!(i.scene.variants.len(), root.map_or(0, Vec::len), "{}", file.display());
        let described: Vec<&Value> = doc["materials"].as_array().into_iter().flatten().collect();
        let mut found: BTreeMap<&str, u32> = BTreeMap::new();
        for m in &i.scene.materials {
            let e = m.extensions.as_deref().cloned().unwrap_or_default();
            // The scene has only the materials that are used: they are told by their names, where there are some.
            let named_alike = described.iter().filter(|d| d["name"].as_str().unwrap_or("") == m.name);
            let candidates: Vec<Vec<&str>> = named_alike.map(|d| switched_on(d)).collect();
            let mut has: Vec<&str> = SWITCHES.iter().filter(|(_, _, has)| has(&e)).map(|s| s.0).collect();
            has.extend(e.specular_glossiness.is_some().then_some("pbrSpecularGlossiness"));
            has.extend((e.dispersion > 0.0).then_some("dispersion"));
            // Points and lines without normals have unlit copies, also of the default material.
            if m.unlit && has.is_empty() {
                continue;
            }
            assert!(candidates.contains(&has), "{}: {}: {has:?} {candidates:?}", file.display(), m.name);
            compared += 1;
            present += has.len();
            has.iter().for_each(|&name| *found.entry(name).or_default() += 1);
        }
        if !i.scene.variants.is_empty() {
            found.insert("variants", i.scene.variants.len() as u32);
        }
        let about: Vec<String> = i
            .warnings
            .iter()
            .map(ToString::to_string)
            .filter(|w| w.contains("KHR_materials") || w.contains("tangents"))
            .collect();
        if !found.is_empty() || !about.is_empty() {
            println!("{}: {found:?} {about:?}", file.file_name().unwrap().to_string_lossy());
        }
        assert!(!about.iter().any(|w| w.contains("not supported")), "{}: {about:?}", file.display());
    }
    println!("{compared} materials with {present} extensions");
    assert!(present > 150, "{present}");
}

/// Triangle counts in the assets' manifest come from another program.
#[test]
fn triangle_counts_agree_with_the_manifest() {
    let Some(folder) = assets("models") else { return };
    let manifest = std::fs::read_to_string(folder.join("../MANIFEST.md")).unwrap();
    let mut compared = 0;
    for line in manifest.lines() {
        let Some(name) = line.strip_prefix("| models/").and_then(|l| l.split(" |").next()) else { continue };
        let Some(count) = line.split("tris=").nth(1).and_then(|s| s.split(' ').next()?.parse::<u64>().ok())
        else {
            continue;
        };
        // The other program counts indexed triangles only, and indices of lines as triangles.
        if count == 0 || name == "gdx-lines" {
            continue;
        }
        for file in models(&folder.join(name)) {
            if let Ok(i) = import(&file, &ImportOptions::default()) {
                let c = i.info.counts;
                assert!(c.triangles == count || c.shown_triangles == count, "{name}: {count} against {c:?}");
                compared += 1;
            }
        }
    }
    println!("{compared} models agree");
    assert!(compared > 70);
}

/// The document with a node for every mesh, so that all of them are built: many of the files show nothing.
fn with_everything_shown(text: &[u8]) -> Option<Vec<u8>> {
    let mut doc: Value = serde_json::from_slice(text).ok()?;
    let meshes = doc.get("meshes")?.as_array()?.len();
    let nodes = doc.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
    let mut list = doc.get("nodes").and_then(Value::as_array).cloned().unwrap_or_default();
    list.extend((0..meshes).map(|m| json!({"mesh": m})));
    doc["nodes"] = json!(list);
    doc["scenes"] = json!([{"nodes": (nodes..nodes + meshes).collect::<Vec<_>>()}]);
    doc["scene"] = json!(0);
    serde_json::to_vec(&doc).ok()
}

#[test]
fn malformed_files_end_in_a_scene_or_a_clear_error() {
    let Some(folder) = assets("malformed") else { return };
    let mut table: BTreeMap<(&str, &str, &str), u32> = BTreeMap::new();
    let mut slowest = (Duration::ZERO, PathBuf::new());
    let copies = tempfile::tempdir().unwrap();
    for group in std::fs::read_dir(folder).unwrap().flatten() {
        if !group.file_name().to_string_lossy().starts_with("gltf-") {
            continue;
        }
        for file in models(&group.path()) {
            let bytes = std::fs::read(&file).unwrap();
            for at in [None, Some(0.5)] {
                let o = ImportOptions { at, animation: AnimationChoice::All, ..ImportOptions::default() };
                let start = Instant::now();
                let result = import(&file, &o);
                let took = start.elapsed();
                if took > slowest.0 {
                    slowest = (took, file.clone());
                }
                if let Err(e) = &result {
                    let text = e.to_string();
                    assert!(
                        text.contains(&*file.file_name().unwrap().to_string_lossy()),
                        "names the file: {text}"
                    );
                }
                if at.is_none() {
                    *table.entry(("as it is", expected(&file), outcome(&result))).or_default() += 1;
                }
            }
            // Beside its buffers and images, so that they are found.
            if let Some(all) = with_everything_shown(&bytes) {
                let result = import_in(&all, file.parent().unwrap(), copies.path());
                *table.entry(("all meshes shown", expected(&file), outcome(&result))).or_default() += 1;
            }
        }
    }
    for ((how, expected, got), n) in &table {
        println!("{how:17} {expected:17} {got:20} {n:5}");
    }
    println!("slowest: {:?} {}", slowest.0, slowest.1.display());
    assert!(slowest.0 < Duration::from_secs(5));
    let refused_though_valid = table.get(&("as it is", "valid", "refused")).copied().unwrap_or(0);
    // Three use what only a later version defines or miss data on purpose.
    assert!(refused_though_valid <= 3, "{refused_though_valid}");
}

/// Imports `text` as if it stood in `folder`, which cannot be written to: its other files are copied.
fn import_in(text: &[u8], folder: &Path, work: &Path) -> Result<etendue_import::Imported, ImportError> {
    for e in std::fs::read_dir(folder).unwrap().flatten() {
        let to = work.join(e.file_name());
        if e.path().is_file() && !to.exists() {
            // Read and written, not copied: permissions stay behind.
            std::fs::write(&to, std::fs::read(e.path()).unwrap()).unwrap();
        }
    }
    let model = work.join("all-shown.gltf");
    std::fs::write(&model, text).unwrap();
    let result = import(&model, &ImportOptions::default());
    // From memory as well: then the files beside it are missing.
    let _ = import_bytes(text, "memory", &ImportOptions::default());
    for e in std::fs::read_dir(work).unwrap().flatten() {
        std::fs::remove_file(e.path()).unwrap();
    }
    result
}

fn outcome<T>(r: &Result<T, ImportError>) -> &'static str
where
    T: std::borrow::Borrow<etendue_import::Imported>,
{
    match r {
        Err(_) => "refused",
        Ok(i) if i.borrow().warnings.is_empty() => "shown",
        Ok(_) => "shown with warnings",
    }
}

/// What the Khronos validator said, where its report lies beside the file.
fn expected(file: &Path) -> &'static str {
    let mut report = file.as_os_str().to_owned();
    report.push(".report.json");
    let Ok(text) = std::fs::read(report) else { return "no report" };
    let json: Value = serde_json::from_slice(&text).unwrap();
    if json["issues"]["numErrors"] == 0 { "valid" } else { "validator errors" }
}

/// Where a file brings tangents, those generated without them must be nearly the same: both are MikkTSpace's.
#[test]
fn generated_tangents_agree_with_those_in_files() {
    let Some(folder) = assets("models/FlightHelmet-512") else { return };
    let file = folder.join("FlightHelmet.gltf");
    let mut doc: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    let given = import(&file, &ImportOptions::default()).unwrap().scene;
    assert!(given.meshes.iter().all(|m| !m.tangents.is_empty()));
    for p in
        doc["meshes"].as_array_mut().unwrap().iter_mut().flat_map(|m| m["primitives"].as_array_mut().unwrap())
    {
        p["attributes"].as_object_mut().unwrap().remove("TANGENT");
    }
    let work = tempfile::tempdir().unwrap();
    let made = import_in(&serde_json::to_vec(&doc).unwrap(), &folder, work.path()).unwrap().scene;
    let (mut n, mut signs, mut near) = (0, 0, 0);
    for (a, b) in given.meshes.iter().zip(&made.meshes) {
        assert_eq!(a.indices.len(), b.indices.len());
        for (s, t) in a.indices.iter().zip(&b.indices) {
            for k in 0..3 {
                let (x, y) = (a.tangents[s[k] as usize], b.tangents[t[k] as usize]);
                n += 1;
                signs += u32::from(x.w == y.w);
                near += u32::from(x.truncate().dot(y.truncate()) > 0.98);
            }
        }
    }
    println!("{n} corners: {signs} with the file's sign, {near} within 11° of the file's tangent");
    assert!(
        f64::from(signs) > 0.99 * f64::from(n) && f64::from(near) > 0.95 * f64::from(n),
        "{n} {signs} {near}"
    );
}
