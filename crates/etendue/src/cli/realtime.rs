//! `etendue render --integrator realtime`: the picture that an engine would draw.

use super::args::{DevelopArgs, RenderArgs};
use super::output::{available_memory, count, expose, peak_memory, unwritten};
use super::progress::{Progress, clock, spinner};
use super::{CliError, load, say, target};
use crate::bxdf::model::Model;
use crate::image::{Development, Metadata, PictureFormat, WriteOptions, write_layers_exr, write_picture};
use crate::realtime::passes::{Pass, PassSet};
use crate::realtime::{Choices, Frame, Lighting, Preset, Twin, TwinSettings};
use crate::render::{Counters, World};
use crate::scene::{Camera, Scene, Substitute};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Samples per pixel unless `--spp` says otherwise.
const DEFAULT_SAMPLES: u32 = 16;

/// Options that are about tracing paths, and why they mean nothing here.
const OF_PATHS: [(&str, &str); 13] = [
    ("noise", "the picture has no noise that more samples would take away"),
    ("time", "it is done when it is done"),
    ("samples", "there are no films to add; --spp sets the samples per pixel"),
    ("bounces", "light is never scattered twice"),
    ("clamp_indirect", "there are no paths"),
    ("compensation", "it is one of the choices: --choice compensation=NAME"),
    ("light_only", "it never sees more than the lights and the sky"),
    ("film", "there is no film"),
    ("checkpoint", "there is no film"),
    ("resume", "there is no film"),
    ("shutter", "it draws one moment"),
    ("moments", "it draws one moment"),
    ("watch", "the picture is drawn once"),
];

pub(crate) fn run(args: RenderArgs) -> Result<(), CliError> {
    let started = Instant::now();
    let mut artist = Artist::new(args)?;
    let args = artist.args.clone();
    let output = target::output_path(&args);
    artist.check_output(&output)?;
    load::start_threads(&args)?;
    let (scene, warnings) = load::scene(&args)?;
    let (camera, size) = load::camera(&args, &scene)?;
    let triangles = scene.triangle_count();
    let loaded = started.elapsed();
    let world = World::new(scene)?;
    let what = Subject { world: &world, camera: &camera, size, triangles, warnings };
    artist.draw(&what, &output, "", &[], started, loaded)
}

/// What is drawn.
pub(crate) struct Subject<'a> {
    pub world: &'a World,
    pub camera: &'a Camera,
    pub size: (u32, u32),
    pub triangles: u64,
    pub warnings: Vec<String>,
}

/// Draws pictures under one sky with one set of choices.
pub(crate) struct Artist {
    args: RenderArgs,
    choices: Choices,
    passes: PassSet,
    /// Of the first picture; only its lights change.
    lighting: Option<Lighting>,
}

impl Artist {
    pub fn new(mut args: RenderArgs) -> Result<Self, CliError> {
        refuse(&args)?;
        let (choices, preset) = choices(&args)?;
        if let (Some(curve), false) = (preset.tone_curve(), args.says("curve")) {
            args.develop.curve = curve;
        }
        let passes = PassSet::parse(&args.passes).map_err(CliError::Usage)?;
        Ok(Self { args, choices, passes, lighting: None })
    }

    /// All that the arguments say of how pictures are drawn.
    pub fn style(&self) -> String {
        format!("{} {:?} {:?}", self.choices, self.args.spp, self.args.develop)
    }

    /// The files of passes beside the picture; none if they are its layers.
    fn files(&self, output: &Path) -> Result<Vec<(Pass, PathBuf)>, CliError> {
        let layered = target::format(output)? == PictureFormat::Exr;
        Ok(if layered { Vec::new() } else { self.passes.iter().map(|p| (p, beside(output, p))).collect() })
    }

    /// Finds out whether the picture can be written.
    pub fn check_output(&self, output: &Path) -> Result<(), CliError> {
        let files = self.files(output)?;
        target::check_writable(output)?;
        files.iter().try_for_each(|(_, path)| target::check_writable(path))
    }

    /// Draws and writes a picture, and reports. `notes` go into its metadata.
    pub fn draw(
        &mut self,
        what: &Subject<'_>,
        output: &Path,
        label: &str,
        notes: &[(&'static str, String)],
        started: Instant,
        loaded: Duration,
    ) -> Result<(), CliError> {
        let (args, passes) = (&self.args, self.passes);
        let (width, height) = what.size;
        only_gltf(what.world.scene())?;
        check_size(width, height, passes)?;
        let built = started.elapsed();
        let visible = !args.quiet && !args.json;
        let lighting = match self.lighting.take() {
            Some(known) => known.with_lights_of(what.world.scene()),
            None => {
                let baking = spinner("integrating the sky", visible);
                let made = Lighting::new(what.world.scene(), &self.choices);
                baking.finish_and_clear();
                made.map_err(|e| CliError::Other(format!("the sky: {e}")))?
            }
        };
        let baked = started.elapsed();

        let settings = TwinSettings {
            width,
            height,
            samples: args.spp.unwrap_or(DEFAULT_SAMPLES),
            filter: args.filter,
            seed: args.seed,
            sky_visible: !args.transparent,
            passes,
        };
        let samples = settings.samples;
        let counters = Arc::new(Counters::default());
        let pixels = u64::from(width) * u64::from(height);
        let progress = Progress::new(counters.clone(), pixels, u64::from(samples), 0, None, visible);
        progress.label(label);
        let frame = Twin::new(what.world, what.camera, &lighting, self.choices, settings).render(&counters);
        progress.finish();
        let drawn = started.elapsed();

        let mut metadata = metadata(args, &self.choices, samples);
        notes.iter().for_each(|(k, v)| metadata.set(*k, v.clone()));
        let files = self.files(output)?;
        write(output, &files, &frame, args, &metadata)?;
        let times = Times { loaded, built, baked, drawn, written: started.elapsed() };
        let facts = Facts {
            output,
            files: &files,
            frame: &frame,
            samples,
            triangles: what.triangles,
            warnings: &what.warnings,
        };
        report(args, &self.choices, &facts, &counters, &times);
        self.lighting = Some(lighting);
        Ok(())
    }
}

/// An error for each option that would be ignored.
fn refuse(args: &RenderArgs) -> Result<(), CliError> {
    match OF_PATHS.iter().find(|(id, _)| args.given.contains(*id)) {
        Some((id, why)) => Err(CliError::Usage(format!(
            "--{} does not apply to --integrator realtime: {why}",
            id.replace('_', "-")
        ))),
        None => Ok(()),
    }
}

/// What `--preset` and then each `--choice` say.
pub(crate) fn choices(args: &RenderArgs) -> Result<(Choices, Preset), CliError> {
    let preset = match &args.preset {
        Some(name) => name
            .parse::<Preset>()
            .map_err(|e| CliError::Usage(format!("there is no preset {name:?}: {e}")))?,
        None => Preset::Exact,
    };
    let mut choices = preset.choices();
    for text in &args.choice {
        choices.apply(text).map_err(|e| CliError::Usage(format!("--choice {text}: {e}")))?;
    }
    Ok((choices, preset))
}

/// An error if a surface is of a model that the shading does not know.
pub(crate) fn only_gltf(scene: &Scene) -> Result<(), CliError> {
    let other = scene.materials.iter().find_map(|m| match &m.substitute {
        Some(Substitute::Model(model)) => match **model {
            Model::Gltf(_) | Model::MetalRough(_) => None,
            ref other => Some(other.name()),
        },
        Some(Substitute::Measured(_)) => Some("measured"),
        None => None,
    });
    other.map_or(Ok(()), |name| {
        Err(CliError::Usage(format!(
            "--material: real-time shading knows the models gltf and metal-rough, and not {name}; leave it out, or use --integrator path"
        )))
    })
}

fn check_size(width: u32, height: u32, passes: PassSet) -> Result<(), CliError> {
    target::check_pixels((width, height))?;
    let channels: u64 = passes.iter().map(|p| p.channels().len() as u64).sum();
    // The passes while they are recorded and once more while they are written; the picture twice as well.
    let needed = u64::from(width) * u64::from(height) * (channels * 8 + 48);
    match available_memory() {
        Some(free) if needed > free => Err(CliError::Other(format!(
            "a picture of {width} × {height} needs {:.1} GB of memory and {:.1} GB are free; choose a smaller --size or fewer --passes",
            needed as f64 / 1e9,
            free as f64 / 1e9
        ))),
        _ => Ok(()),
    }
}

/// The file of a pass beside the picture: `rt.png` and `rt.normal.png`.
fn beside(output: &Path, pass: Pass) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}.{pass}.{extension}"))
}

fn metadata(args: &RenderArgs, choices: &Choices, samples: u32) -> Metadata {
    let mut m = Metadata::default();
    let command: Vec<String> =
        std::env::args_os().map(|a| super::error::shell_word(&a.to_string_lossy())).collect();
    m.set("Software", concat!("etendue ", env!("CARGO_PKG_VERSION")));
    m.set("Command", command.join(" "));
    m.set("Integrator", "realtime");
    m.set("Choices", choices.to_string());
    m.set("Samples", samples.to_string());
    m.set("Seed", args.seed.to_string());
    m
}

/// Writes the picture, and the passes as its layers or beside it.
fn write(
    output: &Path,
    files: &[(Pass, PathBuf)],
    frame: &Frame,
    args: &RenderArgs,
    metadata: &Metadata,
) -> Result<(), CliError> {
    let develop: &DevelopArgs = &args.develop;
    let development = develop.development();
    if target::format(output)? == PictureFormat::Exr && !frame.passes.is_empty() {
        let half = develop.bits != Some(32);
        let layers = frame.layers(args.transparent, &development);
        return write_layers_exr(output, &layers, (frame.width, frame.height), metadata, half)
            .map_err(|e| unwritten(output, e));
    }
    let hdr = matches!(target::format(output)?, PictureFormat::Exr | PictureFormat::Hdr);
    let mut picture = frame.picture(args.transparent);
    if hdr {
        expose(&mut picture, develop.exposure);
    }
    let options = develop.write_options(metadata.clone());
    write_picture(output, &picture, &options).map_err(|e| unwritten(output, e))?;
    for (pass, path) in files {
        write_pass(path, *pass, frame, &development, &options, hdr)?;
    }
    Ok(())
}

fn write_pass(
    path: &Path,
    pass: Pass,
    frame: &Frame,
    development: &Development,
    options: &WriteOptions,
    hdr: bool,
) -> Result<(), CliError> {
    let mut options = options.clone();
    options.metadata.set("Pass", format!("{pass}: {}", pass.about()));
    let picture = if hdr {
        frame.pass_picture(pass, development)
    } else {
        frame.display(pass, development).map(|(picture, note)| {
            if let Some(note) = note {
                options.metadata.set("Pass range", note);
            }
            picture
        })
    };
    let Some(picture) = picture else { return Ok(()) };
    write_picture(path, &picture, &options).map_err(|e| unwritten(path, e))
}

/// How long after the beginning each part was done.
struct Times {
    loaded: Duration,
    built: Duration,
    baked: Duration,
    drawn: Duration,
    written: Duration,
}

/// What the report tells.
struct Facts<'a> {
    output: &'a Path,
    files: &'a [(Pass, PathBuf)],
    frame: &'a Frame,
    samples: u32,
    triangles: u64,
    warnings: &'a [String],
}

/// Prints the report: two lines for people, or one of JSON.
fn report(args: &RenderArgs, choices: &Choices, f: &Facts, counters: &Counters, t: &Times) {
    let seconds = |a: Duration, b: Duration| (b - a).as_secs_f64();
    let load = t.loaded.as_secs_f64();
    let (build, bake) = (seconds(t.loaded, t.built), seconds(t.built, t.baked));
    let (draw, write) = (seconds(t.baked, t.drawn), seconds(t.drawn, t.written));
    let total = t.written.as_secs_f64();
    let rays_per_second = counters.rays() as f64 / draw.max(1e-9);
    let (width, height) = (f.frame.width, f.frame.height);
    if args.json {
        let mut mean = [0.0f64; 3];
        for p in f.frame.beauty() {
            (0..3).for_each(|c| mean[c] += f64::from(p[c]) / f.frame.pixels() as f64);
        }
        let report = serde_json::json!({
            "version": env!("CARGO_PKG_VERSION"),
            "integrator": "realtime",
            "choices": choices.to_string(),
            "output": f.output.to_string_lossy(),
            "passes": f.files.iter().map(|(_, path)| path.to_string_lossy()).collect::<Vec<_>>(),
            "width": width,
            "height": height,
            "samples": f.samples,
            "seed": args.seed,
            "seconds": {
                "load": load, "build": build, "bake": bake, "draw": draw, "write": write, "total": total
            },
            "triangles": f.triangles,
            "threads": rayon::current_num_threads(),
            "rays": {
                "closest": counters.closest_rays.load(Ordering::Relaxed),
                "any": counters.any_rays.load(Ordering::Relaxed),
            },
            "rays_per_second": rays_per_second,
            "mean": mean,
            "rejected_samples": f.frame.rejected,
            "peak_memory_bytes": peak_memory(),
            "warnings": f.warnings,
        });
        say(&report.to_string());
        return;
    }
    if args.quiet {
        return;
    }
    let passes = match f.files.len() {
        0 => String::new(),
        1 => format!(", and {}", f.files[0].1.display()),
        n => format!(", and {n} passes beside it, as in {}", f.files[0].1.display()),
    };
    let mut text = format!(
        "{}: {width} × {height}, real-time shading, {} samples{passes}\n{}: load {}, build {}, sky {}, draw {}, write {}; {}rays/s",
        f.output.display(),
        f.samples,
        clock(total),
        clock(load),
        clock(build),
        clock(bake),
        clock(draw),
        clock(write),
        count(rays_per_second),
    );
    if f.frame.rejected > 0 {
        text += &format!(
            "\n{} samples were not numbers and count as black: please report this",
            f.frame.rejected
        );
    }
    say(&text);
}
