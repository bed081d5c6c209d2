//! `etendue render`: the main job.

use super::args::{Integrator, RenderArgs};
use super::error::shell_word;
use super::goal::Goal;
use super::output::{ARGUMENTS, NAMES, notes, read_film, write_film, write_film_picture};
use super::report::{Times, report};
use super::sequence::Clock;
use super::shot::Shot;
use super::stage::{self, Stage};
use super::work::{Job, listen_for_interrupts};
use super::{CliError, frames, lamp, load, realtime, resume, scene_file, target};
use crate::render::{
    Counters, Film, FilmInfo, PassSet, PathOptions, Renderer, Series, Settings, World, id_names,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub(crate) fn run(args: RenderArgs) -> Result<(), CliError> {
    // A film already has what the scene file said when it was begun.
    let mut args = if args.resume.is_some() { args } else { scene_file::under(args)? };
    if args.at.is_some() {
        // Said on the command line, it goes before a scene file's frames.
        args.motion.frames = None;
    }
    check_motion(&args)?;
    if args.integrator == Integrator::Realtime {
        return if args.motion.is_sequence() { frames::realtime(args) } else { realtime::run(args) };
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
    if args.motion.is_sequence() {
        return frames::run(args, resumed);
    }
    let output = target::output_path(&args);
    target::check_output(&args, &output)?;
    let explicit_film = args.film.clone().or_else(|| args.resume.clone());
    if let Some(film) = &explicit_film {
        target::check_writable(film)?;
    }
    load::start_threads(&args)?;
    listen_for_interrupts();

    let passes = args.path_passes()?;
    let order = |finished| Order {
        output,
        explicit_film,
        resumed,
        label: String::new(),
        notes: Vec::new(),
        finished,
    };
    if let Some(seconds) = args.motion.open_for() {
        let file = stage::file(&args)?;
        let stage = Stage::new(&file, &args)?;
        let clock = Clock::of(&args);
        let (moment, size) = stage.moment(&clock)?;
        target::check_size(size, passes)?;
        let loaded = started.elapsed();
        let mut series = Series::default();
        let shot = Shot::moving(&stage, clock, seconds, settings(&args, size, passes), &mut series)?;
        let names = id_names(&moment.scene);
        let facts = Facts { names, triangles: moment.scene.triangle_count(), warnings: stage.warnings() };
        let times = Times { started, loaded, built: loaded, rendered: loaded };
        return picture(&args, shot, &facts, order(None), times);
    }
    let (scene, warnings) = load::scene(&args)?;
    let (camera, size) = load::camera(&args, &scene)?;
    target::check_size(size, passes)?;
    let loaded = started.elapsed();
    let triangles = scene.triangle_count();
    let world = World::new(scene)?;
    let built = started.elapsed();
    let facts = Facts { names: id_names(world.scene()), triangles, warnings };
    let shot = Shot::Still(Box::new(Renderer::new(&world, camera, settings(&args, size, passes))), &world);
    picture(&args, shot, &facts, order(None), Times { started, loaded, built, rendered: built })
}

/// What is known of the scene apart from its picture.
pub(crate) struct Facts {
    pub names: [Vec<String>; 2],
    pub triangles: u64,
    pub warnings: Vec<String>,
}

/// Where a picture goes, and what it goes on from.
pub(crate) struct Order {
    pub output: PathBuf,
    /// Where the user wants the film.
    pub explicit_film: Option<PathBuf>,
    /// A film of the picture, and where it is.
    pub resumed: Option<(PathBuf, Film, FilmInfo)>,
    /// Which picture of several.
    pub label: String,
    /// Notes of its film and entries of its metadata.
    pub notes: Vec<(&'static str, String)>,
    /// An entry of the metadata for pictures that are not interrupted.
    pub finished: Option<(&'static str, String)>,
}

/// Renders one picture, writes it and reports.
pub(crate) fn picture(
    args: &RenderArgs,
    shot: Shot<'_>,
    facts: &Facts,
    order: Order,
    mut times: Times,
) -> Result<(), CliError> {
    let mut info = film_info(args, &order.output, &shot, &facts.names);
    info.notes.extend(order.notes.into_iter().map(|(k, v)| (k.to_owned(), v)));
    // A film that nobody asked for goes when the picture is done, also where an earlier run left it.
    let mut left = None;
    let mut film = match order.resumed {
        Some((path, film, old)) => {
            resume::check(&path, &film, &old, args, &shot)?;
            // The command that makes the picture is the one that began it.
            if let Some(command) = old.notes.get(COMMAND) {
                info.notes.insert(COMMAND.into(), command.clone());
            }
            if order.explicit_film.is_none() {
                left = Some(path);
            }
            film
        }
        None => shot.film(),
    };
    let goal = Goal::new(args, &film);
    let known = order.explicit_film.clone().or_else(|| left.clone());
    let mut job = Job {
        info,
        film_path: known.unwrap_or_else(|| target::unnamed_film(&order.output)),
        explicit_film: order.explicit_film,
        checkpointed: left.is_some(),
        counters: Arc::new(Counters::default()),
        shot,
        label: order.label,
        output: order.output,
        args: args.clone(),
    };
    let finished = job.sample(&mut film, &goal)?;
    times.rendered = times.started.elapsed();

    if let (true, Some((k, v))) = (finished, order.finished) {
        job.info.notes.insert(k.into(), v);
    }
    let keep_film = job.explicit_film.is_some() || !finished;
    let film_written = if keep_film { write_film(&job.film_path, &film, &job.info) } else { Ok(()) };
    let written = write_film_picture(&job.output, &film, &job.info, &job.args.develop, job.args.transparent);
    if let Err(e) = written {
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
    report(&job, &film, facts.triangles, &facts.warnings, &times, finished);
    if finished { Ok(()) } else { Err(job.interrupted(&film, &goal)) }
}

/// An error for options about time that would be ignored or mean nothing.
fn check_motion(args: &RenderArgs) -> Result<(), CliError> {
    let usage = |text: &str| Err(CliError::Usage(text.into()));
    let m = &args.motion;
    let moves = m.is_sequence() || args.at.is_some() || args.resume.is_some();
    if args.given.contains("fps") && !m.is_sequence() && m.open_for().is_none() {
        return usage("--fps says when frames are: add --frames A..B or --turntable N");
    }
    if m.open_for().is_some() && !moves {
        return usage("nothing moves at rest: --shutter needs --at SECONDS, --frames A..B or --turntable N");
    }
    if args.given.contains("moments") && m.open_for().is_none() && args.resume.is_none() {
        return usage("--moments says how finely motion is blurred: add --shutter 180deg");
    }
    if m.animation.is_some() && args.at.is_none() && m.frames.is_none() && args.resume.is_none() {
        return usage("the model is shown at rest: --animation needs --at SECONDS or --frames A..B");
    }
    if m.overwrite && !m.is_sequence() && args.resume.is_none() {
        return usage("--overwrite is about --frames and --turntable; a single picture is always written");
    }
    Ok(())
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
pub(crate) fn settings(args: &RenderArgs, (width, height): (u32, u32), passes: PassSet) -> Settings {
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

fn film_info(args: &RenderArgs, output: &Path, shot: &Shot, names: &[Vec<String>; 2]) -> FilmInfo {
    let absolute = |p: &Path| std::path::absolute(p).unwrap_or_else(|_| p.to_path_buf());
    let mut stored = args.clone();
    stored.model = stored.model.as_deref().map(absolute);
    stored.output = Some(absolute(output));
    stored.sky.env = stored
        .sky
        .env
        .map(|e| if Path::new(&e).is_file() { absolute(Path::new(&e)).display().to_string() } else { e });
    stored.sky.light.iter_mut().for_each(|l| *l = lamp::absolute(l));
    let command: Vec<String> = std::env::args_os().map(|a| shell_word(&a.to_string_lossy())).collect();
    let mut entries = notes([
        (ARGUMENTS, serde_json::to_string(&stored).unwrap_or_default()),
        (COMMAND, command.join(" ")),
        ("Seed", args.seed.to_string()),
        ("Version", env!("CARGO_PKG_VERSION").into()),
    ]);
    if !args.passes.is_empty() {
        entries.insert(NAMES.into(), serde_json::to_string(names).unwrap_or_default());
    }
    FilmInfo { picture: shot.picture_id(), notes: entries }
}
