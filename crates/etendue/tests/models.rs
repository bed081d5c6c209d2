//! Every model, every malformed model and every sky of the shared assets through the renderer: a picture or a typed error.
//!
//! Skips with a message where the assets are not there. `cargo test -p etendue --release --test models -- --nocapture` prints
//! the tables.

use etendue::image::read_environment;
use etendue::import::{ImportError, ImportOptions, Imported, import};
use etendue::render::{PassSet, PathOptions, Renderer, Settings, World};
use etendue::scene::{Camera, Environment};
use etendue::{builtin, import::AnimationChoice};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
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

/// Files under `folder` with one of these extensions, sorted.
fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let mut stack = vec![folder.to_owned()];
    while let Some(dir) = stack.pop() {
        for e in std::fs::read_dir(dir).unwrap().flatten() {
            let p = e.path();
            if p.is_dir() {
                stack.push(p);
            } else if p.extension().and_then(|e| e.to_str()).is_some_and(|e| extensions.contains(&e)) {
                out.push(p);
            }
        }
    }
    out.sort();
    out
}

/// What became of a file.
struct Row {
    file: PathBuf,
    took: Duration,
    /// Mean radiance of the framed picture, or why there is none.
    result: Result<f64, ImportError>,
    triangles: u64,
    warnings: usize,
}

/// A picture of 8 × 8 pixels from each camera: the one that frames the model and those of the file.
fn pictures(imported: Imported, sky: &Environment) -> f64 {
    let mut scene = imported.scene;
    scene.environment = sky.clone();
    let mut cameras = vec![Camera::framing(&scene, 1.0, 0.6)];
    cameras.extend(scene.cameras.iter().take(3).cloned());
    let world = World::new(scene).expect("what was imported has been validated");
    let mut mean = 0.0;
    for (n, camera) in cameras.into_iter().enumerate() {
        let settings = Settings {
            width: 8,
            height: 8,
            path: PathOptions { bounces: 4, ..PathOptions::default() },
            passes: if n == 0 { PassSet::all() } else { PassSet::default() },
            ..Settings::default()
        };
        let renderer = Renderer::new(&world, camera, settings);
        let mut film = renderer.film();
        renderer.render(&mut film, 0, 1, &Default::default());
        assert_eq!(film.rejected, 0, "samples that are not numbers: {}", imported.info.file);
        let light = film.beauty();
        assert!(light.iter().flatten().all(|v| v.is_finite()), "{}", imported.info.file);
        if n > 0 {
            continue;
        }
        mean = light.iter().map(|p| f64::from(p[1])).sum::<f64>() / light.len() as f64;
    }
    mean
}

fn examine(file: &Path, options: &ImportOptions, sky: &Environment) -> Row {
    let start = Instant::now();
    let (mut triangles, mut warnings) = (0, 0);
    let result = import(file, options).map(|i| {
        (triangles, warnings) = (i.scene.triangle_count(), i.warnings.len());
        pictures(i, sky)
    });
    Row { file: file.to_path_buf(), took: start.elapsed(), result, triangles, warnings }
}

/// Prints the table and asserts what holds for every row.
fn judge(rows: &[Row], root: &Path) {
    for r in rows {
        let name = r.file.strip_prefix(root).unwrap_or(&r.file).display().to_string();
        let what = match &r.result {
            Ok(mean) => format!("{:>9} triangles  mean {mean:<9.4} {} warnings", r.triangles, r.warnings),
            Err(e) => e.to_string().replace(&*root.to_string_lossy(), ""),
        };
        println!("{:>6.2} s  {name:60} {what}", r.took.as_secs_f64());
        if let Err(e) = &r.result {
            let file_name = r.file.file_name().unwrap().to_string_lossy().into_owned();
            assert!(e.to_string().contains(&file_name), "names the file: {e}");
        }
        assert!(r.took < Duration::from_secs(10), "{name} took {:?}", r.took);
    }
    let shown = rows.iter().filter(|r| r.result.is_ok()).count();
    println!("{} files: {shown} pictures, {} errors", rows.len(), rows.len() - shown);
}

fn studio() -> Environment {
    builtin::studio(0.0, 1.0).unwrap()
}

#[test]
fn every_model_gives_a_picture_or_names_what_it_requires() {
    let Some(folder) = assets("models") else { return };
    let sky = studio();
    let rows: Vec<_> = files(&folder, &["gltf", "glb"])
        .par_iter()
        .map(|f| examine(f, &ImportOptions::default(), &sky))
        .collect();
    judge(&rows, &folder);
    for r in &rows {
        if let Err(e) = &r.result {
            assert!(matches!(e, ImportError::Unsupported { .. }), "{e}");
        }
        // Under a sky no picture is black.
        assert!(r.result.as_ref().is_ok_and(|m| *m > 0.0) || r.result.is_err(), "{}", r.file.display());
    }
    let shown = rows.iter().filter(|r| r.result.is_ok()).count();
    assert!(shown >= 127, "{shown} of {}", rows.len());
}

#[test]
fn malformed_models_end_in_a_picture_or_a_clear_error() {
    let Some(folder) = assets("malformed") else { return };
    let sky = studio();
    let mut groups: Vec<_> = std::fs::read_dir(&folder).unwrap().flatten().map(|e| e.path()).collect();
    groups.retain(|g| g.file_name().is_some_and(|n| n.to_string_lossy().starts_with("gltf-")));
    let all: Vec<_> = groups.iter().flat_map(|g| files(g, &["gltf", "glb"])).collect();
    assert!(all.len() > 300, "{}", all.len());
    let moved = ImportOptions { at: Some(0.5), animation: AnimationChoice::All, ..ImportOptions::default() };
    let rows: Vec<_> = all
        .par_iter()
        .map(|f| {
            // In motion as well, for its own faults.
            let _ = examine(f, &moved, &sky);
            examine(f, &ImportOptions::default(), &sky)
        })
        .collect();
    judge(&rows, &folder);
}

#[test]
fn every_sky_lights_the_helmet() {
    let Some(folder) = assets("env") else { return };
    let skies = files(&folder, &["hdr", "exr"]);
    assert!(skies.len() >= 15);
    let helmet = builtin::import_helmet(&ImportOptions::default()).unwrap();
    let rows: Vec<_> = skies
        .par_iter()
        .map(|f| {
            let start = Instant::now();
            let image = Arc::new(read_environment(f).unwrap_or_else(|e| panic!("{e}")).image);
            let sky = Environment::LatLong { image, rotation: 1.0, intensity: 2.0 };
            let mean = pictures(helmet.clone(), &sky);
            (f, start.elapsed(), mean)
        })
        .collect();
    for (f, took, mean) in &rows {
        println!("{:>6.2} s  {:50} mean {mean:.4}", took.as_secs_f64(), f.file_name().unwrap().display());
        assert!(*mean > 0.0 && mean.is_finite(), "{}", f.display());
        assert!(*took < Duration::from_secs(10), "{} took {took:?}", f.display());
    }
}
