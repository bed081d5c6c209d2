//! `etendue compare`: how far a picture is from its reference, two files or a model's real-time picture and its path-traced one.

use super::compare_args::{CompareArgs, Task};
use super::error::shell_word;
use super::output::read_whole;
use super::progress::clock;
use super::{CliError, load, note_line, realtime, say, scene_file, target};
use crate::image::{DecodeLimits, Development, Image, decode_picture, write_atomic};
use crate::lab::compare::{Against, CompareError, Job, ModelError, PictureReport, model_report};
use crate::realtime::Choices;
use crate::render::{PassSet, PathOptions, Settings, World};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(args: &CompareArgs) -> Result<(), CliError> {
    match args.task().map_err(CliError::Usage)? {
        Task::Pictures(reference, picture) => pictures(args, reference, picture),
        Task::Model(path) => model(args, path),
    }
}

fn pictures(args: &CompareArgs, reference: &Path, picture: &Path) -> Result<(), CliError> {
    let read = |path: &Path| -> Result<(String, Image), CliError> {
        let image =
            decode_picture(&read_whole(path)?, &DecodeLimits::default()).map_err(|e| e.in_file(path))?;
        Ok((path.display().to_string(), image))
    };
    let mut report = PictureReport::new(read(reference)?, read(picture)?, args.ppd)?;
    report.max_flip = limit(args);
    report.development = development(args);
    report.command = command();
    let text = report.comparison.figures.to_text();
    finish(args, &report.to_json(), &text, || report.to_html())?;
    judge(args, report.comparison.figures.flip.mean)
}

fn model(args: &CompareArgs, path: Option<&Path>) -> Result<(), CliError> {
    let started = Instant::now();
    let render = scene_file::under(args.as_render(path))?;
    let (choices, preset) = realtime::choices(&render)?;
    let ablate = if args.model.quick { Some(Vec::new()) } else { wanted(&args.model.ablations)? };
    load::start_threads(&render)?;
    let (scene, _) = load::scene(&render)?;
    realtime::only_gltf(&scene)?;
    let (camera, (width, height)) = load::camera(&render, &scene)?;
    // Two films with their parts are the most that is in memory at a time; pictures of the report are small beside them.
    target::check_size((width, height), PassSet::parts())?;
    if let Some(folder) = &args.output {
        make_folder(folder)?;
        target::check_writable(&folder.join("index.html"))?;
    }
    let world = World::new(scene)?;
    let path_options = PathOptions { bounces: render.bounces, ..PathOptions::default() };
    let job = Job {
        world: &world,
        camera,
        settings: Settings { width, height, seed: render.seed, path: path_options, ..Settings::default() },
        choices,
        samples: args.model.samples,
        twin_samples: args.model.realtime_samples,
        ablation_samples: args.model.ablation_samples,
        presets: !args.model.quick,
        ablate: &|key| ablate.as_ref().is_none_or(|keys| keys.iter().any(|k| k == key)),
        development: Development {
            exposure_ev: render.develop.exposure,
            curve: render.develop.curve,
            ..Development::default()
        },
        pixels_per_degree: args.ppd,
    };
    let visible = !args.quiet && !args.json;
    let bar = ProgressBar::with_draw_target(
        Some(1000),
        if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() },
    );
    if let Ok(style) = ProgressStyle::with_template("{percent:>3}%  {msg}  {wide_bar}") {
        bar.set_style(style.progress_chars("━╸ "));
    }
    let progress = |what: &str, share: f64| {
        bar.set_message(what.to_string());
        bar.set_position((share * 1000.0) as u64);
    };
    let mut report = model_report(&job, &progress)?;
    bar.finish_and_clear();
    let name = path.and_then(Path::file_name).map_or("the built-in helmet".into(), |n| n.to_string_lossy());
    let varied = choices.difference(&preset.choices());
    let comma = if varied.is_empty() { "" } else { ", " };
    report.title = format!("{name}, {}{comma}{varied}", preset.name());
    report.command = command();
    let against = if args.model.light_only { Against::LightOnly } else { Against::Whole };
    report.max_flip = limit(args).map(|l| (l, against));
    finish(args, &report.to_json(), &report.to_text(), || report.to_html())?;
    if !args.quiet {
        note_line(&format!("in {}", clock(started.elapsed().as_secs_f64())));
    }
    judge(args, report.side(against).flip.mean)
}

/// The keys to be changed in turn; `None` for all.
fn wanted(list: &str) -> Result<Option<Vec<String>>, CliError> {
    match list {
        "all" => Ok(None),
        list => {
            let keys: Vec<String> = list.split(',').map(|k| k.trim().to_string()).collect();
            let known: Vec<&str> = Choices::KEYS.iter().map(|k| k.name).collect();
            match keys.iter().find(|k| !known.contains(&k.as_str())) {
                Some(k) => Err(CliError::Usage(format!(
                    "--ablations: there is no choice {k:?}; there are {} and all",
                    known.join(", ")
                ))),
                None => Ok(Some(keys)),
            }
        }
    }
}

/// Writes the folder, prints the figures.
fn finish(
    args: &CompareArgs,
    json: &Value,
    text: &str,
    page: impl FnOnce() -> String,
) -> Result<(), CliError> {
    let json = format!("{json:#}\n");
    if let Some(folder) = &args.output {
        make_folder(folder)?;
        // The page last: who finds it finds all.
        write(&folder.join("report.json"), json.as_bytes())?;
        write(&folder.join("index.html"), page().as_bytes())?;
    }
    if args.json {
        say(json.trim_end());
    } else if !args.quiet {
        say(text.trim_end());
    }
    if let (Some(folder), false) = (&args.output, args.quiet) {
        note_line(&folder.join("index.html").display().to_string());
    }
    Ok(())
}

/// What `--max-flip` makes of a mean.
fn judge(args: &CompareArgs, flip: f64) -> Result<(), CliError> {
    match limit(args) {
        Some(limit) if flip > limit => {
            let report: Option<PathBuf> = args.output.as_ref().map(|f| f.join("index.html"));
            Err(CliError::Differs { flip, limit, report })
        }
        _ => Ok(()),
    }
}

/// From its text: a float's digits beyond those that were written would be noise in the report.
fn limit(args: &CompareArgs) -> Option<f64> {
    args.max_flip.and_then(|x| x.to_string().parse().ok())
}

fn development(args: &CompareArgs) -> Development {
    Development { exposure_ev: args.exposure, curve: args.curve, ..Development::default() }
}

/// The command line as it could be typed again.
fn command() -> String {
    let mut words: Vec<String> = std::env::args_os().map(|a| shell_word(&a.to_string_lossy())).collect();
    // The program by its name: where it lies is nobody's business.
    if let Some(first) = words.first_mut() {
        *first = "etendue".into();
    }
    words.join(" ")
}

fn make_folder(path: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(path).map_err(|source| CliError::Write { path: path.into(), source })
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    write_atomic::<std::io::Error>(path, |w| w.write_all(bytes))
        .map_err(|source| CliError::Write { path: path.into(), source })
}

impl From<CompareError> for CliError {
    fn from(e: CompareError) -> Self {
        match e {
            CompareError::Image(e) => e.into(),
            e => Self::Incomparable(e),
        }
    }
}

impl From<ModelError> for CliError {
    fn from(e: ModelError) -> Self {
        match e {
            ModelError::Image(e) => e.into(),
            ModelError::Sky(e) => Self::Other(format!("the sky: {e}")),
        }
    }
}
