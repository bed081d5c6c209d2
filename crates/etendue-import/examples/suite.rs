//! Imports every model under some folders and prints what became of each:
//! `cargo run --release -p etendue-import --example suite -- DIR...`
//!
//! `--at SECONDS` poses the models, `--repeat N` gives the shortest of N times, `--quiet` prints the summary alone.
//!
//! Beside a file there may be `<file>.report.json` of the Khronos glTF validator; its number of errors is shown, and
//! counted in the summary: a valid file that is refused deserves a look, and so does a broken one that is shown.

use etendue_import::{ImportOptions, import};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() {
    let mut files = Vec::new();
    let mut options = ImportOptions::default();
    let (mut quiet, mut repeat) = (false, 1u32);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--at" => options.at = args.next().and_then(|s| s.parse().ok()),
            "--quiet" => quiet = true,
            "--repeat" => repeat = args.next().and_then(|s| s.parse().ok()).unwrap_or(1),
            path => collect(Path::new(path), &mut files),
        }
    }
    files.sort();
    let mut summary: BTreeMap<(&str, &str), u32> = BTreeMap::new();
    for file in &files {
        let load = || {
            let start = Instant::now();
            let result = import(file, &options);
            (result, start.elapsed().as_secs_f64() * 1e3)
        };
        let (result, mut ms) = load();
        for _ in 1..repeat {
            ms = ms.min(load().1);
        }
        let errors = validator_errors(file);
        let expected = match errors {
            None => "no report",
            Some(0) => "valid",
            Some(_) => "validator errors",
        };
        let got = match &result {
            Err(_) => "refused",
            Ok(i) if !i.warnings.is_empty() => "shown with warnings",
            Ok(_) => "shown",
        };
        *summary.entry((expected, got)).or_default() += 1;
        if quiet {
            continue;
        }
        println!(
            "{} [{expected}{}] {got} {ms:.1} ms",
            file.display(),
            errors.map_or(String::new(), |n| format!(": {n}"))
        );
        match result {
            Err(e) => println!("    error: {e}"),
            Ok(i) => {
                let c = &i.info.counts;
                println!(
                    "    {} triangles in the file, {} shown; {} meshes, {} instances, {} materials, {} images of {} KiB, \
                     {} lights, {} cameras",
                    c.triangles,
                    c.shown_triangles,
                    i.scene.meshes.len(),
                    c.instances,
                    i.scene.materials.len(),
                    i.scene.images.len(),
                    c.image_bytes >> 10,
                    i.scene.lights.len(),
                    i.scene.cameras.len()
                );
                for w in &i.warnings {
                    println!("    warning: {w}");
                }
            }
        }
    }
    println!("{} files", files.len());
    for ((expected, got), n) in summary {
        println!("{n:5}  {expected:17} {got}");
    }
}

fn collect(path: &Path, out: &mut Vec<PathBuf>) {
    if path.is_dir() {
        let Ok(entries) = std::fs::read_dir(path) else { return };
        for e in entries.flatten() {
            collect(&e.path(), out);
        }
    } else if matches!(path.extension().and_then(|e| e.to_str()), Some("gltf" | "glb")) {
        out.push(path.to_owned());
    }
}

fn validator_errors(file: &Path) -> Option<u64> {
    let mut report = file.as_os_str().to_owned();
    report.push(".report.json");
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(report).ok()?).ok()?;
    json["issues"]["numErrors"].as_u64()
}
