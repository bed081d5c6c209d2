//! `etendue render`: the main job.

use super::args::{Integrator, RenderArgs};
use super::error::shell_word;
use super::goal::Goal;
use super::output::{ARGUMENTS, NAMES, notes, read_film, write_film, write_film_picture};
use super::report::{Times, report};
use super::work::{Job, listen_for_interrupts};
use super::{CliError, load, realtime, resume, scene_file, target};
use crate::render::{Counters, FilmInfo, PassSet, PathOptions, Renderer, Settings, World, id_names};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

pub(crate) fn run(args: RenderArgs) -> Result<(), CliError> {
    // A film already has what the scene file said when it was begun.
    let args = if args.resume.is_some() { args } else { scene_file::under(args)? };
    if args.integrator == Integrator::Realtime {
        return realtime::run(args);
    }
    only_realtime(&args)?;
    let started = Instant::now();
    let (args, resumed) = match args.resume.clone() {
        Some(path) => {
            let (film, info) = read_film(&path)?;
            (resume::overlay(args, &path, &info)?, Some((path, film, info)))
        }
        None => (args, None),
    };
    let output = target::output_path(&args);
    target::check_output(&args, &output)?;
    let explicit_film = args.film.clone().or_else(|| args.resume.clone());
    if let Some(film) = &explicit_film {
        target::check_writable(film)?;
    }
    load::start_threads(&args)?;
    listen_for_interrupts();

    let (scene, warnings) = load::scene(&args)?;
    let triangles = scene.triangle_count();
    let (camera, size) = load::camera(&args, &scene)?;
    let passes = args.path_passes()?;
    target::check_size(size, passes)?;
    let loaded = started.elapsed();
    let world = World::new(scene)?;
    let built = started.elapsed();
    let renderer = Renderer::new(&world, camera, settings(&args, size, passes));

    let mut info = film_info(&args, &renderer, &world);
    let mut film = match resumed {
        Some((path, film, old)) => {
            resume::check(&path, &film, &old, &args, &renderer)?;
            // The command that makes the picture is the one that began it.
            if let Some(command) = old.notes.get(COMMAND) {
                info.notes.insert(COMMAND.into(), command.clone());
            }
            film
        }
        None => renderer.film(),
    };
    let goal = Goal::new(&args, &film);
    let mut job = Job {
        info,
        film_path: explicit_film.clone().unwrap_or_else(|| target::unnamed_film(&output)),
        explicit_film,
        checkpointed: false,
        counters: Arc::new(Counters::default()),
        renderer,
        output,
        args,
    };
    let finished = job.sample(&mut film, &goal);
    let rendered = started.elapsed();

    let keep_film = job.explicit_film.is_some() || !finished;
    let film_written = if keep_film { write_film(&job.film_path, &film, &job.info) } else { Ok(()) };
    let picture = write_film_picture(&job.output, &film, &job.info, &job.args.develop, job.args.transparent);
    if let Err(e) = picture {
        // The samples are worth more than the picture.
        let kept = if keep_film { film_written } else { write_film(&job.film_path, &film, &job.info) };
        return Err(match kept {
            Ok(()) => CliError::Unwritten { cause: Box::new(e), film: job.film_path },
            Err(_) => e,
        });
    }
    film_written?;
    if job.checkpointed && !keep_film {
        let _ = std::fs::remove_file(&job.film_path);
    }
    report(&job, &film, &world, triangles, &warnings, &Times { started, loaded, built, rendered }, finished);
    if finished { Ok(()) } else { Err(job.interrupted(&film, &goal)) }
}

/// An error for options that are about real-time shading.
fn only_realtime(args: &RenderArgs) -> Result<(), CliError> {
    match ["preset", "choice"].iter().find(|id| args.given.contains(**id)) {
        Some(id) => Err(CliError::Usage(format!(
            "--{id} is about real-time shading: add --integrator realtime, or leave it out"
        ))),
        None => Ok(()),
    }
}

/// Rendering settings from arguments.
fn settings(args: &RenderArgs, (width, height): (u32, u32), passes: PassSet) -> Settings {
    Settings {
        width,
        height,
        filter: args.filter,
        seed: args.seed,
        path: PathOptions {
            bounces: args.bounces,
            clamp_indirect: args.clamp_indirect.unwrap_or(f32::INFINITY),
            sky_visible: !args.transparent,
            light_only: args.light_only,
            ..PathOptions::default()
        },
        passes,
    }
}

/// Note of a film and entry of a picture's metadata: the command that made it.
const COMMAND: &str = "Command";

fn film_info(args: &RenderArgs, renderer: &Renderer, world: &World) -> FilmInfo {
    let absolute = |p: &Path| std::path::absolute(p).unwrap_or_else(|_| p.to_path_buf());
    let mut stored = args.clone();
    stored.model = stored.model.as_deref().map(absolute);
    stored.output = Some(absolute(&target::output_path(args)));
    stored.sky.env = stored
        .sky
        .env
        .map(|e| if Path::new(&e).is_file() { absolute(Path::new(&e)).display().to_string() } else { e });
    let command: Vec<String> = std::env::args_os().map(|a| shell_word(&a.to_string_lossy())).collect();
    let mut entries = notes([
        (ARGUMENTS, serde_json::to_string(&stored).unwrap_or_default()),
        (COMMAND, command.join(" ")),
        ("Seed", args.seed.to_string()),
        ("Version", env!("CARGO_PKG_VERSION").into()),
    ]);
    if !args.passes.is_empty() {
        entries.insert(NAMES.into(), serde_json::to_string(&id_names(world.scene())).unwrap_or_default());
    }
    FilmInfo { picture: renderer.picture_id(), notes: entries }
}
