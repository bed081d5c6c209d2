//! Cases of the Khronos glTF Asset Generator beside the sample pictures that come with them.
//!
//! ```text
//! cargo run --release -p etendue --example asset_generator -- FOLDER [--out sheet.png]
//! ```
//!
//! `FOLDER` holds the generator's folders, each with a `Manifest.json` that names models, cameras and pictures. Each model is
//! drawn at the beginning of its animation by its own camera, which looks at the origin with the 0.8 radians of the program
//! that made the samples; its frame is left-handed, so that what the manifest calls x is −x in glTF's. The sky of the samples
//! is not part of the suite, so colours cannot be compared; what can is where
//! things are: **outline** is the share of our edges (of the shape, between its faces, in its texture) that have an edge of
//! the sample within two of 400 pixels; **mirrored** is the same for our picture turned left to right, to tell what the measure
//! is worth (a symmetric shape says nothing there). A case without a picture is judged by whether it has to load: a file
//! that demands a later version of glTF or an extension that nobody knows must not. Ends with 1 unless all cases agree.
#![forbid(unsafe_code)]

use clap::Parser;
use etendue::builtin;
use etendue::image::{DecodeLimits, Development, Image, decode, develop};
use etendue::import::{ImportOptions, Imported, import};
use etendue::lab::draw::{Anchor, Drawing, GREY, INK, Item, Rgb};
use etendue::realtime::{Choices, Lighting, Twin, TwinSettings};
use etendue::render::World;
use etendue::scene::Camera;
use glam::Vec3;
use serde::Deserialize;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Vertical field of view of the samples, radians: a plane of one metre at 1.3 m fills 730 of their 800 pixels.
const FIELD_OF_VIEW: f32 = 0.8;
/// Width and height at which pictures are compared.
const SIZE: u32 = 400;
/// Width and height of a picture on the sheet.
const THUMB: u32 = 160;
/// Share of our edges that the sample must have: where a grey plane stands before a wall as grey, it shows none.
const ENOUGH: f64 = 0.9;

/// Renders the cases of the glTF Asset Generator beside their sample pictures.
#[derive(Parser)]
struct Args {
    /// Folder of the generator's folders.
    folder: PathBuf,
    /// Samples per pixel.
    #[arg(long, default_value_t = 8)]
    spp: u32,
    /// Writes all pictures beside the samples as one PNG.
    #[arg(long)]
    out: Option<PathBuf>,
}

#[derive(Deserialize)]
struct Manifest {
    models: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Case {
    file_name: String,
    sample_image_name: Option<String>,
    camera: Eye,
}

#[derive(Deserialize)]
struct Eye {
    translation: [f32; 3],
}

/// Three channels of display values in 0..1 and, for ours, how much of a pixel is covered.
struct Picture {
    rgb: Vec<[f32; 3]>,
    alpha: Vec<f32>,
}

impl Picture {
    /// From a picture of eight or sixteen bits and any size, averaged or repeated to [`SIZE`].
    fn of(image: &Image) -> Self {
        let (mut rgb, mut alpha) = (Vec::new(), Vec::new());
        let span = |i: u32, n: u32| {
            let from = u64::from(i) * u64::from(n) / u64::from(SIZE);
            let to = (u64::from(i + 1) * u64::from(n) / u64::from(SIZE)).max(from + 1);
            from as u32..to.min(u64::from(n)) as u32
        };
        for y in 0..SIZE {
            for x in 0..SIZE {
                let (mut sum, mut count) = ([0.0; 4], 0.0);
                for v in span(y, image.height) {
                    for u in span(x, image.width) {
                        (0..image.channels.min(4)).for_each(|c| sum[c as usize] += image.sample(u, v, c));
                        count += 1.0;
                    }
                }
                let mean = sum.map(|s| s / count);
                rgb.push([mean[0], mean[1], mean[2]]);
                alpha.push(if image.channels == 4 { mean[3] } else { 1.0 });
            }
        }
        Self { rgb, alpha }
    }

    fn mirrored(&self) -> Self {
        let at = |i: usize| i / SIZE as usize * SIZE as usize + (SIZE as usize - 1 - i % SIZE as usize);
        Self {
            rgb: (0..self.rgb.len()).map(|i| self.rgb[at(i)]).collect(),
            alpha: (0..self.rgb.len()).map(|i| self.alpha[at(i)]).collect(),
        }
    }

    /// Pixels where a channel, or what is covered, differs from the next pixel's by more than `least`.
    fn edges(&self, least: f32) -> Vec<bool> {
        let n = SIZE as usize;
        let differs = |i: usize, j: usize| {
            let (a, b) = (self.rgb[i], self.rgb[j]);
            let inside = self.alpha[i].min(self.alpha[j]) > 0.5;
            let color = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
            (inside && color > least) || (self.alpha[i] - self.alpha[j]).abs() > 0.5
        };
        (0..n * n)
            .map(|i| (i % n + 1 < n && differs(i, i + 1)) || (i / n + 1 < n && differs(i, i + n)))
            .collect()
    }
}

/// Share of the edges of `ours` that `sample` has within two pixels; `None` if ours has none.
fn outline(ours: &Picture, sample: &Picture) -> Option<f64> {
    let (a, b) = (ours.edges(0.06), sample.edges(0.02));
    let n = SIZE as i64;
    let near = |i: usize| {
        let (x, y) = (i as i64 % n, i as i64 / n);
        (-2..=2).any(|dy| {
            (-2..=2).any(|dx| {
                let (u, v) = (x + dx, y + dy);
                (0..n).contains(&u) && (0..n).contains(&v) && b[(v * n + u) as usize]
            })
        })
    };
    let all = a.iter().filter(|e| **e).count();
    let found = (0..a.len()).filter(|i| a[*i] && near(*i)).count();
    (all > 0).then(|| found as f64 / all as f64)
}

/// Our picture of a model by real-time shading, on nothing.
fn render(model: &Imported, [x, y, z]: [f32; 3], samples: u32) -> Result<Picture, Box<dyn Error>> {
    let mut scene = model.scene.clone();
    scene.environment = builtin::studio(0.0, 0.4)?;
    let world = World::new(scene)?;
    let camera = Camera::look_at(Vec3::new(-x, y, z), Vec3::ZERO, Vec3::Y, FIELD_OF_VIEW);
    let choices = Choices::default();
    let lighting = Lighting::new(world.scene(), &choices).map_err(|e| format!("the sky: {e}"))?;
    let settings =
        TwinSettings { width: SIZE, height: SIZE, samples, sky_visible: false, ..TwinSettings::default() };
    let frame = Twin::new(&world, &camera, &lighting, choices, settings).render(&Default::default());
    Ok(Picture::of(&develop(&frame.picture(true), &Development::default())))
}

fn is_animated(path: &Path) -> Result<bool, Box<dyn Error>> {
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path)?)?;
    Ok(json["animations"].is_array())
}

/// True if the file says that a program like this must not show it.
fn is_to_be_refused(path: &Path) -> Result<bool, Box<dyn Error>> {
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path)?)?;
    let later = json["asset"]["minVersion"].as_str().is_some_and(|v| v != "2.0");
    let required = json["extensionsRequired"].as_array().is_some_and(|list| {
        list.iter().filter_map(|e| e.as_str()).any(|e| etendue::import::support(e).is_none())
    });
    Ok(later || required)
}

/// What became of a case.
struct Outcome {
    name: String,
    ours: Option<Picture>,
    sample: Option<Picture>,
    verdict: String,
    agrees: bool,
}

fn case(folder: &Path, case: &Case, spp: u32) -> Result<Outcome, Box<dyn Error>> {
    let path = folder.join(&case.file_name);
    let refuse = is_to_be_refused(&path)?;
    let sample = match &case.sample_image_name {
        None => None,
        Some(name) => {
            let file = folder.join(name);
            let image =
                decode(&std::fs::read(&file)?, &DecodeLimits::default()).map_err(|e| e.in_file(&file))?;
            Some(Picture::of(&image))
        }
    };
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    // The samples were taken at the first moment.
    let at = is_animated(&path)?.then_some(0.0);
    let model = match import(&path, &ImportOptions { at, ..ImportOptions::default() }) {
        Ok(model) => model,
        Err(e) => {
            let verdict = if refuse { "refused, as it must be".into() } else { format!("REFUSED: {e}") };
            return Ok(Outcome { name, ours: None, sample, verdict, agrees: refuse });
        }
    };
    let warnings: Vec<String> = model.warnings.iter().map(|w| w.message.clone()).collect();
    let ours = render(&model, case.camera.translation, spp)?;
    let (verdict, agrees) = match (&sample, refuse) {
        (_, true) => ("LOADS, which it must not".into(), false),
        (None, _) => ("loads, as it must".into(), true),
        (Some(_), _) if model.scene.instances.is_empty() => {
            (format!("shows nothing: {}", warnings.join("; ")), !warnings.is_empty())
        }
        (Some(sample), _) => {
            let found = outline(&ours, sample).unwrap_or(0.0);
            let mirrored = outline(&ours.mirrored(), sample).unwrap_or(0.0);
            let text = format!("outline {:.1} %, mirrored {:.1} %", found * 100.0, mirrored * 100.0);
            let verdict = if found >= ENOUGH { text } else { format!("{text}: DIFFERS") };
            (verdict, found >= ENOUGH)
        }
    };
    Ok(Outcome { name, ours: Some(ours), sample, verdict, agrees })
}

fn thumb(d: &mut Drawing, at: [f32; 2], picture: &Picture) {
    let byte = |v: f32, a: f32| ((v * a + 0.75 * (1.0 - a)).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let pixels = (0..THUMB * THUMB)
        .map(|i| {
            let (x, y) = (i % THUMB * SIZE / THUMB, i / THUMB * SIZE / THUMB);
            let k = (y * SIZE + x) as usize;
            let color: Rgb = picture.rgb[k].map(|v| byte(v, picture.alpha[k]));
            Some(color)
        })
        .collect();
    let (size, cells) = ([THUMB as f32; 2], [THUMB as usize; 2]);
    d.items.push(Item::Picture { at, size, cells, pixels });
}

/// Ours and the sample, pair by pair.
fn sheet(outcomes: &[Outcome]) -> Drawing {
    const COLUMNS: u32 = 5;
    let (w, h) = (2 * THUMB + 16, THUMB + 50);
    let rows = (outcomes.len() as u32).div_ceil(COLUMNS);
    let mut d = Drawing::new(COLUMNS * w + 16, rows * h + 16);
    for (i, o) in (0u32..).zip(outcomes) {
        let at = [(16 + i % COLUMNS * w) as f32, (16 + i / COLUMNS * h) as f32];
        if let Some(p) = &o.ours {
            thumb(&mut d, at, p);
        }
        if let Some(p) = &o.sample {
            thumb(&mut d, [at[0] + THUMB as f32 + 2.0, at[1]], p);
        }
        d.text([at[0], at[1] + THUMB as f32 + 10.0], o.name.clone(), INK, Anchor::Start);
        let verdict: String = o.verdict.chars().take(40).collect();
        d.text([at[0], at[1] + THUMB as f32 + 29.0], verdict, GREY, Anchor::Start);
    }
    d
}

fn run(args: &Args) -> Result<bool, Box<dyn Error>> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(&args.folder)?
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.join("Manifest.json").is_file())
        .collect();
    folders.sort();
    if folders.is_empty() {
        return Err(format!("{}: no folder with a Manifest.json", args.folder.display()).into());
    }
    let mut outcomes = Vec::new();
    for folder in &folders {
        let manifest: Manifest = serde_json::from_slice(&std::fs::read(folder.join("Manifest.json"))?)?;
        for c in &manifest.models {
            let o = case(folder, c, args.spp)?;
            println!("{:<32}{}", o.name, o.verdict);
            outcomes.push(o);
        }
    }
    let agree = outcomes.iter().filter(|o| o.agrees).count();
    println!("{} cases, {agree} agree", outcomes.len());
    if let Some(out) = &args.out {
        std::fs::write(out, sheet(&outcomes).to_png()?)?;
    }
    Ok(agree == outcomes.len())
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
