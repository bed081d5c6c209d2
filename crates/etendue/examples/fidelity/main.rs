//! How near our pictures are to those of other renderers, by scenes of the Khronos glTF Render Fidelity suite.
//!
//! ```text
//! cargo run --release -p etendue --example fidelity -- ASSETS [--spp N] [--scene NAME] [--out DIR]
//! ```
//!
//! `ASSETS` holds `models/`, `env/fidelity/` and `reference/khronos-render-fidelity/` (`scenarios.json`, and per scene one
//! picture of each renderer). Each scene is rendered with its own camera and sky at the size of those pictures, by tracing
//! paths and by real-time shading, developed as they were (the ACES curve as three.js has it) and compared with each of
//! them: root of the mean squared difference of display values in 0..1, less the noise of our paths, transparent pictures on
//! grey 0.5. The verdict asks
//! whether our mean distance to the path tracers among them is at most the largest distance between two of them (where fewer
//! than two traced paths, all renderers are taken), and the same of our real-time picture and the renderers that shade in
//! real time. Ends with 1 if one scene's is not and there is no reason on record.
//!
//! The pictures of `AnisotropyDiscTest` are square and show more than the camera in `scenarios.json` sees: they are of an
//! earlier camera, which was found by laying ours over them.
//!
//! An orbit's radius of 0 is taken as it stands: the camera is at the target. The one scene that has it
//! (`MetalRoughSpheresNoTextures`, whose target lies 1 cm in front of spheres of 0.7 mm) is framed so in all its pictures.
#![forbid(unsafe_code)]

mod draw;
mod judge;
mod suite;

use clap::Parser;
use etendue::bxdf::multiscatter::Compensation;
use etendue::image::{WriteOptions, write_picture};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use suite::Scenario;

/// Compares pictures of the Khronos glTF Render Fidelity scenes with those of other renderers.
#[derive(Parser)]
struct Args {
    /// Folder of models, skies and reference pictures.
    assets: PathBuf,
    /// Samples per pixel of traced paths.
    #[arg(long, default_value_t = 256)]
    spp: u32,
    /// Only this scene; may be given more than once [default: all whose model is there].
    #[arg(long)]
    scene: Vec<String>,
    /// What is done about light that meets several microfacets: `kulla-conty`, `turquin` (scales the lobe, as Cycles does) or `none`
    /// (as glTF's formulas and several of the others).
    #[arg(long, default_value = "kulla-conty")]
    compensation: String,
    /// Writes our pictures, and each beside the others with the differences below them.
    #[arg(long)]
    out: Option<PathBuf>,
}

fn run(args: &Args) -> Result<bool, Box<dyn Error>> {
    let reference = args.assets.join("reference/khronos-render-fidelity");
    let list = reference.join("scenarios.json");
    let text = std::fs::read_to_string(&list).map_err(|e| format!("{}: {e}", list.display()))?;
    let mut scenarios: BTreeMap<String, Scenario> = serde_json::from_str(&text)?;
    if let Some(s) = scenarios.get_mut("AnisotropyDiscTest") {
        (s.target, s.orbit.radius) = ([-0.5, 1.0, 0.0], 8.0);
    }
    if let Some(dir) = &args.out {
        std::fs::create_dir_all(dir)?;
    }
    let names: Vec<&String> =
        if args.scene.is_empty() { scenarios.keys().collect() } else { args.scene.iter().collect() };
    let compensation = match args.compensation.as_str() {
        "kulla-conty" => Compensation::KullaConty,
        "turquin" => Compensation::Turquin,
        "none" => Compensation::None,
        other => return Err(format!("{other} is no way of compensation").into()),
    };
    let mut judgements = Vec::new();
    for name in names {
        let scenario = scenarios.get(name).ok_or_else(|| format!("there is no scene {name}"))?;
        if args.scene.is_empty() && scenario.model(&args.assets).is_err() {
            println!("{name}: left out, its model is not there");
            continue;
        }
        let (goldens, odd) = suite::goldens(&reference.join(name))?;
        let first = goldens.first().ok_or_else(|| format!("{name}: there are no reference pictures"))?;
        let size = (first.picture.width, first.picture.height);
        println!("{name}, {} × {}, {} samples", size.0, size.1, args.spp);
        odd.iter().for_each(|n| println!("  {n}: left out, its picture has another shape"));
        let started = Instant::now();
        let ours = draw::render(scenario, &args.assets, size, args.spp, compensation)?;
        println!("  rendered in {:.1} s", started.elapsed().as_secs_f64());
        judgements.push(judge::judge(name, &ours, &goldens)?);
        if let Some(dir) = &args.out {
            let options = WriteOptions::default();
            let write = |ending: &str, picture| {
                write_picture(&dir.join(format!("{name}{ending}.png")), &picture, &options)
            };
            write("", draw::eight_bits(&ours.path))?;
            write("-realtime", draw::eight_bits(&ours.realtime))?;
            write("-beside", draw::side_by_side(&ours, &goldens))?;
        }
    }
    judge::table(&judgements);
    Ok(judgements.iter().all(judge::Judgement::is_good))
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}
