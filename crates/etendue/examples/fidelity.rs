//! How near our pictures are to those of other renderers, by scenes of the Khronos glTF Render Fidelity suite.
//!
//! ```text
//! cargo run --release -p etendue --example fidelity -- ASSETS [--spp N] [--scene NAME] [--out DIR]
//! ```
//!
//! `ASSETS` holds `models/`, `env/fidelity/` and `reference/khronos-render-fidelity/` (`scenarios.json`, and per scene one
//! picture of each renderer). Each scene is rendered with its own camera and sky at the size of those pictures, developed
//! as they were (the ACES curve as three.js has it) and compared with each of them: root of the mean squared difference of
//! display values in 0..1, transparent pictures on grey 0.5. The verdict asks whether our mean distance to the path tracers
//! among them is at most the largest distance between two of them; where fewer than two traced paths, all renderers are
//! taken. Ends with 1 if one scene's is not.
//!
//! The pictures of `AnisotropyDiscTest` are square and show more than the camera in `scenarios.json` sees: they are of an
//! earlier camera, which was found by laying ours over them.
//!
//! An orbit's radius of 0 is taken as it stands: the camera is at the target. The one scene that has it
//! (`MetalRoughSpheresNoTextures`, whose target lies 1 cm in front of spheres of 0.7 mm) is framed so in all its pictures.
#![forbid(unsafe_code)]

use clap::Parser;
use etendue::color::ToneCurve;
use etendue::image::{
    DecodeLimits, Depth, Development, Image, Pixels, WriteOptions, decode, develop, read_environment, rmse,
    write_picture,
};
use etendue::import::{ImportOptions, import};
use etendue::render::{Filter, PathOptions, Renderer, Settings, World};
use etendue::scene::{Camera, Environment};
use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Scenes of what the renderer claims: glTF's core material, then each extension's own.
const SCENES: [&str; 20] = [
    "DamagedHelmet",
    "MetalRoughSpheresNoTextures",
    "NormalTangentTest",
    "AlphaBlendModeTest",
    "TextureSettingsTest",
    "VertexColorTest",
    "LightsPunctualLamp",
    "EmissiveStrengthTest",
    "FlightHelmet",
    "ClearCoatTest",
    "SheenChair",
    "TransmissionTest",
    "AttenuationTest",
    "IridescenceLamp",
    "IridescenceSuzanne",
    "AnisotropyStrengthTest",
    "AnisotropyDiscTest",
    "SpecularTest",
    "GlassHurricaneCandleHolder",
    "MaterialsVariantsShoe",
];

/// Glass in front of glass takes more than the default.
const BOUNCES: u32 = 16;

/// Renderers of the suite that trace paths.
const PATH_TRACERS: [&str; 5] = ["blender-cycles", "three-gpu-pathtracer", "stellar", "vray", "dspbr-pt"];

/// Compares pictures of the Khronos glTF Render Fidelity scenes with those of other renderers.
#[derive(Parser)]
struct Args {
    /// Folder of models, skies and reference pictures.
    assets: PathBuf,
    /// Samples per pixel.
    #[arg(long, default_value_t = 256)]
    spp: u32,
    /// Only this scene (any of the suite's); may be given more than once.
    #[arg(long)]
    scene: Vec<String>,
    /// Writes our pictures, and each beside the others with the differences below them.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// A scene of `scenarios.json`.
#[derive(Deserialize)]
struct Scenario {
    target: [f32; 3],
    orbit: Orbit,
    lighting: String,
    render_skybox: bool,
    vertical_fov_deg: f32,
    model_dir: String,
}

/// Where the camera is: degrees, metres.
#[derive(Deserialize)]
struct Orbit {
    radius: f32,
    theta_deg: f32,
    phi_deg: f32,
}

impl Scenario {
    fn camera(&self) -> Camera {
        let (theta, phi) = (self.orbit.theta_deg.to_radians(), self.orbit.phi_deg.to_radians());
        let away = Vec3::new(phi.sin() * theta.sin(), phi.cos(), phi.sin() * theta.cos());
        let eye = Vec3::from(self.target) + away * self.orbit.radius;
        Camera::look_at(eye, eye - away, Vec3::Y, self.vertical_fov_deg.to_radians())
    }

    fn model(&self, assets: &Path) -> Result<PathBuf, Box<dyn Error>> {
        // The folders are named from the parent of the assets.
        let name =
            Path::new(&self.model_dir).file_name().ok_or("scenarios.json: a scene without a folder")?;
        let folder = assets.join("models").join(name);
        files(&folder, |n| n.ends_with(".glb") || n.ends_with(".gltf"))?
            .into_iter()
            .next()
            .ok_or_else(|| format!("{}: there is no glTF file in it", folder.display()).into())
    }

    fn sky(&self, assets: &Path) -> Result<PathBuf, Box<dyn Error>> {
        let folder = assets.join("env/fidelity");
        // One of the skies comes from another source and carries that in its name.
        files(&folder, |n| n.starts_with(&self.lighting) && n.ends_with(".hdr"))?
            .into_iter()
            .min_by_key(|p| p.as_os_str().len())
            .ok_or_else(|| format!("{}: there is no sky {} in it", folder.display(), self.lighting).into())
    }
}

/// Files of `folder` whose names `wanted` likes, sorted.
fn files(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut out: Vec<PathBuf> = entries
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.file_name().and_then(|n| n.to_str()).is_some_and(&wanted))
        .collect();
    out.sort();
    Ok(out)
}

/// A picture of one renderer, on grey, three channels of display values.
struct Golden {
    name: String,
    path_traced: bool,
    picture: Image,
}

/// The reference pictures of a scene that have the size of most of them, and the names of the rest.
fn goldens(folder: &Path) -> Result<(Vec<Golden>, Vec<String>), Box<dyn Error>> {
    const ENDING: &str = "-golden.thumb.webp";
    let mut all = Vec::new();
    for path in files(folder, |n| n.ends_with(ENDING))? {
        let bytes = std::fs::read(&path)?;
        let picture = decode(&bytes, &DecodeLimits::default()).map_err(|e| e.in_file(&path))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().replace(ENDING, "");
        let path_traced = PATH_TRACERS.contains(&name.as_str());
        all.push(Golden { name, path_traced, picture: on_grey(&picture) });
    }
    let size = |g: &Golden| (g.picture.width, g.picture.height);
    let mut count = BTreeMap::new();
    all.iter().for_each(|g| *count.entry(size(g)).or_insert(0) += 1);
    let usual = count.into_iter().max_by_key(|c| c.1).map(|c| c.0);
    let (same, odd): (Vec<_>, Vec<_>) = all.into_iter().partition(|g| Some(size(g)) == usual);
    Ok((same, odd.into_iter().map(|g| g.name).collect()))
}

/// Three channels of a developed picture with straight alpha, over display grey 0.5.
fn on_grey(image: &Image) -> Image {
    let channels = image.channels;
    let mut out = Vec::with_capacity(image.width as usize * image.height as usize * 3);
    for y in 0..image.height {
        for x in 0..image.width {
            let alpha = if channels.is_multiple_of(2) { image.sample(x, y, channels - 1) } else { 1.0 };
            for c in 0..3 {
                let v = image.sample(x, y, if channels < 3 { 0 } else { c });
                out.push(v * alpha + 0.5 * (1.0 - alpha));
            }
        }
    }
    Image { width: image.width, height: image.height, channels: 3, pixels: Pixels::F32(out) }
}

/// Our picture of a scene.
fn render(scenario: &Scenario, assets: &Path, size: (u32, u32), spp: u32) -> Result<Image, Box<dyn Error>> {
    let model = scenario.model(assets)?;
    let imported = import(&model, &ImportOptions::default())?;
    imported.warnings.iter().for_each(|w| println!("  warning: {w}"));
    let mut scene = imported.scene;
    let sky = read_environment(&scenario.sky(assets)?)?;
    scene.environment = Environment::LatLong { image: Arc::new(sky.image), rotation: 0.0, intensity: 1.0 };
    let world = World::new(scene)?;
    let settings = Settings {
        width: size.0,
        height: size.1,
        // The others were rendered at twice the size and averaged.
        filter: Filter::Box,
        path: PathOptions { sky_visible: scenario.render_skybox, bounces: BOUNCES, ..PathOptions::default() },
        ..Settings::default()
    };
    let renderer = Renderer::new(&world, scenario.camera(), settings);
    let mut film = renderer.film();
    renderer.render(&mut film, 0, spp, &Default::default());
    if film.rejected > 0 {
        println!("  {} samples were not numbers", film.rejected);
    }
    let development = Development {
        // three.js divides by 0.6 before the curve.
        exposure_ev: (1.0f32 / 0.6).log2(),
        curve: ToneCurve::AcesFitted,
        depth: Depth::Sixteen,
        ..Development::default()
    };
    Ok(on_grey(&develop(&film.picture(!scenario.render_skybox), &development)))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Prints a scene's table; true if our distance to the path tracers is within theirs to each other.
fn report(ours: &Image, goldens: &[Golden]) -> Result<bool, Box<dyn Error>> {
    let mut traced: Vec<_> = goldens.iter().filter(|g| g.path_traced).collect();
    let mut peers = "path tracers";
    if traced.len() < 2 {
        (traced, peers) = (goldens.iter().collect(), "all renderers");
    }
    let mut largest = 0.0f64;
    let mut pairs = Vec::new();
    // Mean distance of each path tracer to the others.
    let mut order = Vec::new();
    for a in &traced {
        let mut others = Vec::new();
        for b in traced.iter().filter(|b| b.name != a.name) {
            others.push(rmse(&a.picture, &b.picture)?);
        }
        largest = others.iter().copied().fold(largest, f64::max);
        order.push((mean(&others), a.name.as_str()));
        pairs.extend(others);
    }
    let mut distances = Vec::new();
    println!("  {:<24}{:>8}{:>24}", "renderer", "ours", format!("mean to {peers}"));
    for g in goldens {
        let d = rmse(&g.picture, ours)?;
        let theirs = order.iter().find(|o| o.1 == g.name).map(|o| format!("{:>24.4}", o.0));
        println!("  {:<24}{d:>8.4}{}", g.name, theirs.unwrap_or_default());
        if traced.iter().any(|t| t.name == g.name) {
            distances.push(d);
        }
    }
    if pairs.is_empty() {
        println!("  fewer than two renderers: no verdict");
        return Ok(true);
    }
    let our_mean = mean(&distances);
    order.push((our_mean, "ours"));
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let within = our_mean <= largest;
    let names: Vec<_> = order.iter().map(|o| format!("{} {:.4}", o.1, o.0)).collect();
    println!("  {peers} among themselves: mean {:.4}, largest {largest:.4}", mean(&pairs));
    println!("  order, by mean distance to {peers}: {}", names.join(", "));
    println!("  verdict: {} ({our_mean:.4} of {largest:.4})", if within { "within" } else { "BEYOND" });
    Ok(within)
}

/// Ours and the path tracers' in one row; below each of them, what ours has more or less, four times, about grey.
fn side_by_side(ours: &Image, goldens: &[Golden]) -> Image {
    let shown: Vec<_> = goldens.iter().filter(|g| g.path_traced || g.name == "model-viewer").collect();
    let (w, h) = (ours.width, ours.height);
    let width = w * (shown.len() as u32 + 1);
    let mut out = Vec::with_capacity(width as usize * h as usize * 6);
    for y in 0..2 * h {
        for x in 0..width {
            let other = (x / w).checked_sub(1).map(|k| &shown[k as usize].picture);
            for c in 0..3 {
                let v = match (other, y < h) {
                    (None, true) => ours.sample(x, y, c),
                    (Some(o), true) => o.sample(x % w, y, c),
                    (None, false) => 0.5,
                    (Some(o), false) => {
                        0.5 + 4.0 * (ours.sample(x % w, y - h, c) - o.sample(x % w, y - h, c))
                    }
                };
                out.push((v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            }
        }
    }
    Image { width, height: 2 * h, channels: 3, pixels: Pixels::U8(out) }
}

fn run(args: &Args) -> Result<bool, Box<dyn Error>> {
    let reference = args.assets.join("reference/khronos-render-fidelity");
    let list = reference.join("scenarios.json");
    let text = std::fs::read_to_string(&list).map_err(|e| format!("{}: {e}", list.display()))?;
    let mut scenarios: BTreeMap<String, Scenario> = serde_json::from_str(&text)?;
    if let Some(dir) = &args.out {
        std::fs::create_dir_all(dir)?;
    }
    let names: Vec<&str> = match args.scene.is_empty() {
        true => SCENES.to_vec(),
        false => args.scene.iter().map(String::as_str).collect(),
    };
    let mut beyond = Vec::new();
    if let Some(s) = scenarios.get_mut("AnisotropyDiscTest") {
        (s.target, s.orbit.radius) = ([-0.5, 1.0, 0.0], 8.0);
    }
    for name in names {
        let scenario = scenarios.get(name).ok_or_else(|| format!("there is no scene {name}"))?;
        let (goldens, odd) = goldens(&reference.join(name))?;
        let first = goldens.first().ok_or_else(|| format!("{name}: there are no reference pictures"))?;
        let size = (first.picture.width, first.picture.height);
        println!("{name}, {} × {}, {} samples", size.0, size.1, args.spp);
        odd.iter().for_each(|n| println!("  {n}: left out, its picture has another shape"));
        let started = Instant::now();
        let ours = render(scenario, &args.assets, size, args.spp)?;
        println!("  rendered in {:.1} s", started.elapsed().as_secs_f64());
        if !report(&ours, &goldens)? {
            beyond.push(name);
        }
        if let Some(dir) = &args.out {
            let Pixels::F32(p) = &ours.pixels else { unreachable!("made by on_grey") };
            let bytes = p.iter().map(|v| (v * 255.0 + 0.5) as u8).collect();
            let eight = Image { pixels: Pixels::U8(bytes), ..ours.clone() };
            let options = WriteOptions::default();
            write_picture(&dir.join(format!("{name}.png")), &eight, &options)?;
            write_picture(&dir.join(format!("{name}-beside.png")), &side_by_side(&ours, &goldens), &options)?;
        }
    }
    if !beyond.is_empty() {
        println!("beyond the path tracers' own spread: {}", beyond.join(", "));
    }
    Ok(beyond.is_empty())
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
