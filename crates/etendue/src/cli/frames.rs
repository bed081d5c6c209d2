//! `etendue render --frames` and `--turntable`: one picture after another.

use super::args::RenderArgs;
use super::motion_args::FrameRange;
use super::output::{FRAME, TIME, read_film};
use super::render::{Facts, Order, picture, settings};
use super::report::Times;
use super::sequence::{self, Clock, SETTINGS, frame_paths, is_done, numbers, settings_key};
use super::shot::Shot;
use super::stage::{self, Stage};
use super::work::listen_for_interrupts;
use super::{CliError, load, note_line, realtime as twin, say, target};
use crate::render::{Film, FilmInfo, Moment, Renderer, Series, id_names};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Path-traces the frames.
pub(crate) fn run(args: RenderArgs, resumed: Option<(PathBuf, Film, FilmInfo)>) -> Result<(), CliError> {
    let list = List::new(&args, args.resume.as_deref())?;
    if resumed.is_some() && list.frames.len() > 1 {
        return Err(CliError::Usage(
            "--resume goes on with one picture; to go on with frames, give the same command again".into(),
        ));
    }
    let passes = args.path_passes()?;
    list.frames.iter().try_for_each(|f| target::check_output(&args, &f.output))?;
    load::start_threads(&args)?;
    listen_for_interrupts();
    let file = stage::file(&args)?;
    let stage = Stage::new(&file, &args)?;
    let (mut done, mut series) = (0, Series::default());
    let mut resumed = resumed;
    for frame in &list.frames {
        let started = Instant::now();
        let args = frame.args(&args);
        let clock = Clock::of_frame(&args, frame.number);
        let (Moment { scene, camera }, size) = stage.moment(&clock)?;
        target::check_size(size, passes)?;
        let settings = settings(&args, size, passes);
        let open_for = args.motion.open_for();
        let id = match open_for {
            Some(s) => Shot::moving(&stage, clock, s, settings.clone(), &mut series)?.picture_id(),
            None => series.picture_id(&scene, &camera, &settings),
        };
        let goal = format!("{:?}", (args.spp, args.noise, args.time, args.samples));
        let key = settings_key(&[&id, &goal, &development(&args), &args.passes]);
        if resumed.is_none() && list.skips(frame, &key, &mut done) {
            continue;
        }
        let names = id_names(&scene);
        let facts = Facts { names, triangles: scene.triangle_count(), warnings: stage.warnings() };
        let film = resumed.take().or_else(|| frame.film_of(&id));
        let order = Order {
            output: frame.output.clone(),
            explicit_film: frame.film.clone(),
            resumed: film,
            label: list.label(frame),
            notes: frame.notes(&clock),
            finished: Some((SETTINGS, key)),
        };
        let loaded = started.elapsed();
        let times = |built| Times { started, loaded, built, rendered: built };
        let result = match open_for {
            Some(s) => {
                let shot = Shot::moving(&stage, clock, s, settings, &mut series)?;
                picture(&args, shot, &facts, order, times(loaded))
            }
            None => {
                let world = series.world(scene)?;
                let shot = Shot::Still(Box::new(Renderer::new(world, camera, settings)), world);
                picture(&args, shot, &facts, order, times(started.elapsed()))
            }
        };
        result.map_err(|e| list.interrupted(frame, e))?;
    }
    list.conclude(done);
    Ok(())
}

/// Draws the frames as engines do.
pub(crate) fn realtime(args: RenderArgs) -> Result<(), CliError> {
    let mut artist = twin::Artist::new(args.clone())?;
    let list = List::new(&args, None)?;
    list.frames.iter().try_for_each(|f| artist.check_output(&f.output))?;
    load::start_threads(&args)?;
    let file = stage::file(&args)?;
    let stage = Stage::new(&file, &args)?;
    let (mut done, mut series) = (0, Series::default());
    for frame in &list.frames {
        let started = Instant::now();
        let clock = Clock::of_frame(&args, frame.number);
        let (Moment { scene, camera }, size) = stage.moment(&clock)?;
        let settings = settings(&args, size, Default::default());
        let id = series.picture_id(&scene, &camera, &settings);
        let key = settings_key(&[&id, &artist.style(), &development(&args), &args.passes]);
        if list.skips(frame, &key, &mut done) {
            continue;
        }
        let triangles = scene.triangle_count();
        let loaded = started.elapsed();
        let world = series.world(scene)?;
        let mut notes = frame.notes(&clock);
        notes.push((SETTINGS, key));
        let what = twin::Subject { world, camera: &camera, size, triangles, warnings: stage.warnings() };
        artist.draw(&what, &frame.output, &list.label(frame), &notes, started, loaded)?;
    }
    list.conclude(done);
    Ok(())
}

/// All that a frame's development depends on.
fn development(args: &RenderArgs) -> String {
    let version = env!("CARGO_PKG_VERSION");
    format!("{:?} {} {:?} {version}", args.develop, args.transparent, args.integrator)
}

/// One picture of several.
struct Frame {
    number: u32,
    output: PathBuf,
    film: Option<PathBuf>,
}

impl Frame {
    /// The arguments of this frame alone, as its film remembers them.
    fn args(&self, all: &RenderArgs) -> RenderArgs {
        let mut args = all.clone();
        let one = FrameRange { first: self.number, last: self.number };
        // A turntable alone has frames by itself; as one of them it needs its number.
        if args.motion.frames.is_some() {
            args.motion.frames = Some(one);
        } else {
            args.motion.turn_frame = Some(self.number);
        }
        args
    }

    fn notes(&self, clock: &Clock) -> Vec<(&'static str, String)> {
        let time = clock.at.map(|t| (TIME, t.to_string()));
        std::iter::once((FRAME, self.number.to_string())).chain(time).collect()
    }

    /// What an interrupted run left of the picture with the name `id`.
    fn film_of(&self, id: &str) -> Option<(PathBuf, Film, FilmInfo)> {
        let path = self.film.clone().unwrap_or_else(|| self.output.with_extension("film"));
        let (film, info) = path.is_file().then(|| read_film(&path).ok()).flatten()?;
        (info.picture == id).then_some((path, film, info))
    }
}

/// The frames to be rendered.
struct List {
    frames: Vec<Frame>,
    overwrite: bool,
    quiet: bool,
}

impl List {
    fn new(args: &RenderArgs, resume: Option<&Path>) -> Result<Self, CliError> {
        let pattern = match &args.output {
            Some(path) => path.clone(),
            None => sequence::with_number(&target::output_path(args)),
        };
        let outputs = frame_paths("--output", &pattern, args)?;
        let films = match args.film.as_deref().or(resume) {
            Some(pattern) => frame_paths("--film", pattern, args)?.into_iter().map(Some).collect(),
            None => vec![None; outputs.len()],
        };
        let frames = numbers(args).zip(outputs).zip(films);
        Ok(Self {
            frames: frames.map(|((number, output), film)| Frame { number, output, film }).collect(),
            overwrite: args.motion.overwrite,
            quiet: args.quiet || args.json,
        })
    }

    fn label(&self, frame: &Frame) -> String {
        let last = self.frames.last().map_or(0, |f| f.number);
        format!("frame {} of {}..{last}", frame.number, self.frames[0].number)
    }

    /// True if the frame is there as it would be rendered. Says so if something else is there.
    fn skips(&self, frame: &Frame, key: &str, done: &mut u32) -> bool {
        if self.overwrite || !frame.output.exists() {
            return false;
        }
        if is_done(&frame.output, key) {
            *done += 1;
            return true;
        }
        if !self.quiet {
            note_line(&format!(
                "{}: not finished, or made with other settings; rendered again",
                frame.output.display()
            ));
        }
        false
    }

    /// `e`, with a way out that is about frames.
    fn interrupted(&self, frame: &Frame, e: CliError) -> CliError {
        match e {
            CliError::Interrupted { done, film, .. } if self.frames.len() > 1 => {
                CliError::InterruptedFrames { frame: frame.number, done, film }
            }
            e => e,
        }
    }

    fn conclude(&self, done: u32) {
        if done > 0 && !self.quiet {
            let were = if done == 1 { "was" } else { "were" };
            say(&format!(
                "{done} of {} frames {were} there already, made with the same settings (--overwrite renders them again)",
                self.frames.len()
            ));
        }
    }
}
