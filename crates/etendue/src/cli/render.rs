//! `etendue render`: the main job.

use super::args::{DevelopArgs, RenderArgs};
use super::load;
use super::output::{ARGUMENTS, NAMES, count, notes, peak_memory, read_film, write_film, write_film_picture};
use super::progress::{Progress, clock};
use super::{CliError, say};
use crate::image::PictureFormat;
use crate::render::{Counters, Film, FilmInfo, MergeError, PathOptions, Renderer, Settings, World, id_names};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Samples per pixel if nothing else says when to stop.
const DEFAULT_SAMPLES: u32 = 64;
/// Samples per pixel at which a run ends that waits for an error or a time.
const MOST_SAMPLES: u32 = 1 << 20;
/// A film is written at least this often.
const CHECKPOINT: Duration = Duration::from_secs(30);
/// `--watch` rewrites the picture this often at first, then ever more rarely.
const WATCH: Duration = Duration::from_secs(2);
/// Samples that an error estimate needs before it may end a run.
const LEAST_FOR_NOISE: u64 = 16;

/// Times that the user asked to stop.
static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

pub(crate) fn run(args: RenderArgs) -> Result<(), CliError> {
    let started = Instant::now();
    let (args, resumed) = match &args.resume {
        Some(path) => {
            let (film, info) = read_film(path)?;
            (overlay(args, &info)?, Some((film, info)))
        }
        None => (args, None),
    };
    let output = output_path(&args);
    check_output(&args, &output)?;
    if let Some(n) = args.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(n as usize)
            .build_global()
            .map_err(|e| CliError::Other(format!("cannot start {n} threads: {e}")))?;
    }
    // A second interrupt does not wait for anything.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTS.fetch_add(1, Ordering::SeqCst) > 0 {
            std::process::exit(130);
        }
    });

    let imported = load::model(args.model.as_deref(), args.at, args.allow_outside)?;
    let (environment, repaired) = load::environment(&args)?;
    let mut warnings: Vec<String> = imported.warnings.iter().map(ToString::to_string).collect();
    if repaired > 0 {
        warnings.push(format!(
            "the sky has {repaired} pixels that are not numbers, infinite or negative; they were mended"
        ));
    }
    let mut scene = imported.scene;
    scene.environment = environment;
    let triangles = scene.triangle_count();
    let loaded = started.elapsed();
    let world = World::new(scene)?;
    let built = started.elapsed();
    let (camera, size) = load::camera(&args, &world)?;
    let renderer = Renderer::new(&world, camera, settings(&args, size));
    let mut job = Job {
        info: film_info(&args, &renderer, &world),
        explicit_film: args.film.clone().or_else(|| args.resume.clone()),
        film_path: args
            .film
            .clone()
            .or_else(|| args.resume.clone())
            .unwrap_or_else(|| output.with_extension("film")),
        checkpointed: false,
        counters: Arc::new(Counters::default()),
        renderer,
        output,
        args,
    };
    if !job.args.quiet {
        warnings.iter().for_each(|w| eprintln!("warning: {w}"));
    }
    let mut film = job.renderer.film();
    if let Some((old, info)) = resumed {
        if info.picture != job.info.picture {
            let path = job.args.resume.clone().unwrap_or_default();
            return Err(CliError::Merge {
                path,
                source: MergeError::Picture(job.info.picture, info.picture),
            });
        }
        film = old;
    }

    let goal = Goal::new(&job.args, &film);
    let finished = job.sample(&mut film, &goal)?;
    let rendered = started.elapsed();
    let failed = |film: &Film, job: &Job, e: CliError| {
        // The samples are worth more than the picture: try to keep them.
        let _ = write_film(&job.film_path, film, &job.info);
        Err(e)
    };
    if let Err(e) = write_film_picture(&job.output, &film, &job.info, &job.args.develop, job.args.transparent)
    {
        return failed(&film, &job, e);
    }
    if job.explicit_film.is_some() || !finished {
        write_film(&job.film_path, &film, &job.info)?;
    } else if job.checkpointed {
        let _ = std::fs::remove_file(&job.film_path);
    }
    let times = Times { started, loaded, built, rendered };
    job.report(&film, &world, triangles, &warnings, &times, finished);
    if finished { Ok(()) } else { Err(job.interrupted(&film, &goal)) }
}

/// Rendering settings from arguments.
fn settings(args: &RenderArgs, (width, height): (u32, u32)) -> Settings {
    Settings {
        width,
        height,
        filter: args.filter,
        seed: args.seed,
        path: PathOptions {
            bounces: args.bounces,
            clamp_indirect: args.clamp_indirect.unwrap_or(f32::INFINITY),
            sky_visible: !args.transparent,
            ..PathOptions::default()
        },
        passes: args.passes,
    }
}

/// Arguments of a continued run: what the film was rendered with, and over it what this command says of work and output.
fn overlay(now: RenderArgs, info: &FilmInfo) -> Result<RenderArgs, CliError> {
    let path = now.resume.clone().unwrap_or_default();
    let text = info.notes.get(ARGUMENTS).ok_or_else(|| CliError::Film {
        path: path.clone(),
        source: crate::render::FilmError::Header("it does not say how it was rendered".into()),
    })?;
    let then: RenderArgs = serde_json::from_str(text)
        .map_err(|e| CliError::Film { path, source: crate::render::FilmError::Header(e.to_string()) })?;
    let given = |d: &DevelopArgs| format!("{d:?}") != format!("{:?}", RenderArgs::builtin().develop);
    let new_goal = now.spp.is_some() || now.noise.is_some() || now.time.is_some() || now.samples.is_some();
    let goal = if new_goal { &now } else { &then };
    Ok(RenderArgs {
        spp: goal.spp,
        noise: goal.noise,
        time: goal.time,
        samples: goal.samples,
        model: now.model.or(then.model),
        output: now.output.or(then.output),
        develop: if given(&now.develop) { now.develop } else { then.develop },
        threads: now.threads,
        film: now.film,
        resume: now.resume,
        watch: now.watch,
        json: now.json,
        quiet: now.quiet,
        ..then
    })
}

fn output_path(args: &RenderArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| match &args.model {
        Some(m) => Path::new(m.file_stem().unwrap_or_default()).with_extension("png"),
        None => "etendue.png".into(),
    })
}

/// Finds out before the work what would fail after it.
fn check_output(args: &RenderArgs, output: &Path) -> Result<(), CliError> {
    let format = PictureFormat::from_path(output)?;
    if !args.passes.is_empty() && format != PictureFormat::Exr {
        return Err(CliError::Usage(format!(
            "passes are layers of an .exr file, and {} is none; write to a .exr, or leave --passes out",
            output.display()
        )));
    }
    let folder = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let source = std::io::Error::new(
            std::io::ErrorKind::NotFound,
            format!("there is no folder {}", folder.display()),
        );
        return Err(CliError::Write { path: output.to_path_buf(), source });
    }
    Ok(())
}

fn film_info(args: &RenderArgs, renderer: &Renderer, world: &World) -> FilmInfo {
    let absolute = |p: &Path| std::path::absolute(p).unwrap_or_else(|_| p.to_path_buf());
    let mut stored = args.clone();
    stored.model = stored.model.as_deref().map(absolute);
    stored.output = Some(absolute(&output_path(args)));
    stored.env = stored
        .env
        .map(|e| if Path::new(&e).is_file() { absolute(Path::new(&e)).display().to_string() } else { e });
    let command: Vec<String> = std::env::args().collect();
    let mut entries = notes([
        (ARGUMENTS, serde_json::to_string(&stored).unwrap_or_default()),
        ("Command", command.join(" ")),
        ("Seed", args.seed.to_string()),
        ("Version", env!("CARGO_PKG_VERSION").into()),
    ]);
    if !args.passes.is_empty() {
        entries.insert(NAMES.into(), serde_json::to_string(&id_names(world.scene())).unwrap_or_default());
    }
    FilmInfo { picture: renderer.picture_id(), notes: entries }
}

/// When to stop.
struct Goal {
    from: u32,
    to: u32,
    noise: Option<f64>,
    time: Option<Duration>,
    /// Samples per pixel that this run takes at most.
    missing: u64,
    /// `to` is only a bound; error or time end the run.
    open: bool,
}

impl Goal {
    fn new(args: &RenderArgs, film: &Film) -> Self {
        let open = args.spp.is_none() && (args.noise.is_some() || args.time.is_some());
        let (from, to) = args
            .samples
            .unwrap_or((0, args.spp.unwrap_or(if open { MOST_SAMPLES } else { DEFAULT_SAMPLES })));
        let missing = film.ranges.missing(from, to).iter().map(|r| u64::from(r.1 - r.0)).sum();
        Self {
            from,
            to,
            noise: args.noise.map(f64::from),
            time: args.time,
            missing,
            open: open && args.samples.is_none(),
        }
    }
}

struct Times {
    started: Instant,
    loaded: Duration,
    built: Duration,
    rendered: Duration,
}

struct Job<'a> {
    args: RenderArgs,
    renderer: Renderer<'a>,
    info: FilmInfo,
    output: PathBuf,
    explicit_film: Option<PathBuf>,
    film_path: PathBuf,
    checkpointed: bool,
    counters: Arc<Counters>,
}

impl Job<'_> {
    /// Takes samples until the goal is reached (true) or the user stops it (false).
    fn sample(&mut self, film: &mut Film, goal: &Goal) -> Result<bool, CliError> {
        let start = Instant::now();
        let total = if goal.open { 0 } else { goal.missing };
        let visible = !self.args.quiet && !self.args.json;
        let pixels = film.pixels() as u64;
        let progress =
            Progress::new(self.counters.clone(), pixels, total, film.samples(), goal.time, visible);
        let mut last_film = start;
        let (mut last_watch, mut watch) = (start, WATCH);
        let mut batch = 1u32;
        let mut interrupted = false;
        'ranges: for (from, to) in film.ranges.missing(goal.from, goal.to) {
            let mut at = from;
            while at < to {
                if INTERRUPTS.load(Ordering::SeqCst) > 0 && film.samples() > 0 {
                    interrupted = true;
                    break 'ranges;
                }
                let mut n = batch.min(to - at);
                let begun = Instant::now();
                self.renderer.render(film, at, at + n, &self.counters);
                at += n;
                let rate = f64::from(n) / begun.elapsed().as_secs_f64().max(1e-6);
                // Batches of a quarter of a second: short enough to stop at, long enough to cost nothing.
                n = ((rate * 0.25) as u32).clamp(1, 4096).min(batch.saturating_mul(8));
                batch = n;
                if let Some(budget) = goal.time {
                    let left = budget.saturating_sub(start.elapsed()).as_secs_f64();
                    if left * rate < 1.0 {
                        break 'ranges;
                    }
                    batch = batch.min((left * rate) as u32).max(1);
                }
                if goal.noise.is_some() || progress.is_visible() {
                    let error = film.relative_error();
                    progress.set_error(error);
                    if goal.noise.is_some_and(|e| error < e) && film.samples() >= LEAST_FOR_NOISE {
                        break 'ranges;
                    }
                }
                if last_film.elapsed() >= CHECKPOINT {
                    write_film(&self.film_path, film, &self.info)?;
                    self.checkpointed = true;
                    last_film = Instant::now();
                }
                if self.args.watch && last_watch.elapsed() >= watch {
                    write_film_picture(
                        &self.output,
                        film,
                        &self.info,
                        &self.args.develop,
                        self.args.transparent,
                    )?;
                    last_watch = Instant::now();
                    watch = (watch * 5 / 4).min(Duration::from_secs(30));
                }
            }
        }
        progress.finish();
        Ok(!interrupted)
    }

    fn interrupted(&self, film: &Film, goal: &Goal) -> CliError {
        let wanted = if goal.open { String::new() } else { format!(" of {}", goal.to - goal.from) };
        CliError::Interrupted {
            done: format!("{}{wanted} samples", film.samples()),
            picture: self.output.clone(),
            film: self.film_path.clone(),
        }
    }

    fn report(
        &self,
        film: &Film,
        world: &World,
        triangles: u64,
        warnings: &[String],
        times: &Times,
        finished: bool,
    ) {
        let total = times.started.elapsed().as_secs_f64();
        let load = times.loaded.as_secs_f64();
        let build = (times.built - times.loaded).as_secs_f64();
        let render = (times.rendered - times.built).as_secs_f64();
        let write = total - times.rendered.as_secs_f64();
        let rays = self.counters.rays();
        let paths = self.counters.samples.load(Ordering::Relaxed);
        let error = film.relative_error();
        if self.args.json {
            let mut mean = [0.0f64; 3];
            for p in film.beauty() {
                (0..3).for_each(|c| mean[c] += f64::from(p[c]) / film.pixels() as f64);
            }
            let report = serde_json::json!({
                "output": self.output, "film": self.explicit_film, "picture": self.info.picture, "finished": finished,
                "width": film.width, "height": film.height, "samples": film.samples(),
                "seconds": { "load": load, "build": build, "render": render, "write": write, "total": total },
                "triangles": triangles, "lights": world.light_count(), "threads": rayon::current_num_threads(),
                "rays": { "closest": self.counters.closest_rays.load(Ordering::Relaxed), "any": self.counters.any_rays.load(Ordering::Relaxed) },
                "rays_per_second": rays as f64 / render.max(1e-9), "paths_per_second": paths as f64 / render.max(1e-9),
                "relative_error": error.is_finite().then_some(error), "mean": mean, "rejected_samples": film.rejected,
                "peak_memory_bytes": peak_memory(), "warnings": warnings,
            });
            say(&report.to_string());
        } else if !self.args.quiet {
            let mut text = format!(
                "{}  {} × {}, {} samples, error {:.2} %, {} (load {}, build {}, render {}), {}rays/s",
                self.output.display(),
                film.width,
                film.height,
                film.samples(),
                error * 100.0,
                clock(total),
                clock(load),
                clock(build),
                clock(render),
                count(rays as f64 / render.max(1e-9)),
            );
            if film.rejected > 0 {
                text += &format!(
                    "\n{} samples were not numbers and count as black: please report this",
                    film.rejected
                );
            }
            say(&text);
        }
    }
}
