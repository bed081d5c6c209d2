//! `etendue sheet`: many models side by side, for people to look over.

use super::args::Integrator;
use super::check::{Checked, Checklist};
use super::find_models::find_models;
use super::sheet_args::SheetArgs;
use super::sheet_page::{Cell, Layout, titles};
use super::{CliError, load, note_line, target};
use crate::image::{Development, Image, develop, write_atomic};
use crate::import::{ImportOptions, Imported};
use crate::lab::draw::Rgb;
use crate::realtime::{Choices, Lighting, Twin, TwinSettings};
use crate::render::{PathOptions, Renderer, Settings, World};
use crate::scene::{Camera, Environment, Scene};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Vertical field of view, radians: as `etendue render` frames a model.
const FIELD_OF_VIEW: f32 = 35.0 * std::f32::consts::PI / 180.0;

/// Everything but the model.
struct Studio {
    options: ImportOptions,
    at: Option<f32>,
    environment: Environment,
    /// The sky made ready for real-time shading; `None` to trace paths.
    lighting: Option<Lighting>,
    development: Development,
    cell: u32,
    samples: u32,
    time: Duration,
}

pub(crate) fn run(args: &SheetArgs) -> Result<(), CliError> {
    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
        return Err(CliError::Usage(format!("a sheet is a .png, and {} is none", args.output.display())));
    }
    let files = find_models(&args.files)?;
    target::check_writable(&args.output)?;
    let (environment, notes) = load::sky(&args.env, 0.0, 1.0)?;
    if !args.quiet {
        notes.iter().for_each(|n| note_line(&format!("warning: {n}")));
    }
    let lighting = match args.integrator {
        Integrator::Path => None,
        Integrator::Realtime => {
            let scene = Scene { environment: environment.clone(), ..Scene::default() };
            let made = Lighting::new(&scene, &Choices::default());
            Some(made.map_err(|e| CliError::Other(format!("the sky: {e}")))?)
        }
    };
    let studio = Arc::new(Studio {
        options: args.limits.options(),
        at: args.at,
        environment,
        lighting,
        development: Development { exposure_ev: args.exposure, curve: args.curve, ..Development::default() },
        cell: args.cell,
        samples: args.spp,
        time: args.time,
    });
    let layout = Layout { cell: args.cell, columns: args.columns, rows: args.rows };
    let (list, pages) = draw(args, &files, &studio, layout)?;
    let paths: Vec<String> = pages.iter().map(|p| p.display().to_string()).collect();
    if args.json || !args.quiet {
        list.print(args.json, &[("pages", json!(paths))])?;
    }
    if !args.quiet && !args.json {
        note_line(&format!("written: {}", paths.join(", ")));
    }
    list.judge(args.strict)
}

/// Draws and writes page by page.
fn draw(
    args: &SheetArgs,
    files: &[PathBuf],
    studio: &Arc<Studio>,
    layout: Layout,
) -> Result<(Checklist, Vec<PathBuf>), CliError> {
    let hidden = args.quiet || args.json;
    let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(files.len() as u64), target);
    if let Ok(style) = ProgressStyle::with_template("{pos}/{len}  {msg}  {wide_bar}") {
        bar.set_style(style.progress_chars("━╸ "));
    }
    let (mut list, mut pages) = (Checklist::default(), Vec::new());
    let names = titles(files, args.names);
    let mut left = files.iter().zip(names).peekable();
    while left.peek().is_some() {
        let mut cells = Vec::new();
        for (path, name) in left.by_ref().take(layout.per_page()) {
            bar.set_message(name.clone());
            let started = Instant::now();
            let (picture, triangles, checked) = bounded(path, studio);
            let warnings = if picture.is_ok() { checked.messages.len() } else { 0 };
            cells.push(Cell { name, picture, warnings, triangles });
            list.add(path, checked.took(started.elapsed().as_secs_f64()));
            bar.inc(1);
        }
        let path = page_path(&args.output, pages.len() + 1);
        let bytes = layout.page(&cells).to_png().map_err(|e| CliError::Other(e.to_string()))?;
        write_atomic::<std::io::Error>(&path, |w| w.write_all(&bytes))
            .map_err(|source| CliError::Write { path: path.clone(), source })?;
        pages.push(path);
    }
    bar.finish_and_clear();
    Ok((list, pages))
}

/// The file of a page: `sheet.png`, `sheet-2.png`.
fn page_path(output: &Path, page: usize) -> PathBuf {
    if page == 1 {
        return output.to_path_buf();
    }
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}-{page}.png"))
}

type Drawn = (Result<Vec<Rgb>, String>, u64, Checked);

/// Loads and draws one model on a thread of its own, which is left alone if it takes too long.
fn bounded(path: &Path, studio: &Arc<Studio>) -> Drawn {
    let (send, receive) = mpsc::channel();
    let (file, on) = (path.to_path_buf(), studio.clone());
    let spawned = std::thread::Builder::new().spawn(move || {
        // Nobody listens any more if it took too long.
        let _ = send.send(model(&file, &on));
    });
    let failed = |why: &str| (Err(why.to_owned()), 0, Checked::failed(path, why));
    if let Err(e) = spawned {
        return failed(&format!("cannot start a thread: {e}"));
    }
    match receive.recv_timeout(studio.time) {
        Ok(drawn) => drawn,
        Err(RecvTimeoutError::Timeout) => {
            failed(&format!("took longer than {} s", studio.time.as_secs_f64()))
        }
        Err(RecvTimeoutError::Disconnected) => failed("the program itself failed: please report this"),
    }
}

fn model(path: &Path, studio: &Studio) -> Drawn {
    let moment = |model: Imported| match studio.at {
        // Of what does not move there is no other moment.
        Some(_) if !model.info.animations.is_empty() => {
            load::read(Some(path), &ImportOptions { at: studio.at, ..studio.options.clone() }, None)
        }
        _ => Ok(model),
    };
    match load::read(Some(path), &studio.options, None).and_then(moment) {
        Ok(model) => {
            let mut checked = Checked::loaded(path, &model);
            let triangles = model.scene.triangle_count();
            let picture = studio.picture(model.scene);
            if let Err(why) = &picture {
                checked = Checked::failed(path, why);
            }
            (picture, triangles, checked)
        }
        Err(e) => {
            let checked = Checked::refused(path, &e);
            (Err(checked.messages.concat()), 0, checked)
        }
    }
}

impl Studio {
    /// The model's picture, rows of sRGB pixels.
    fn picture(&self, mut scene: Scene) -> Result<Vec<Rgb>, String> {
        scene.environment = self.environment.clone();
        let camera = Camera::framing(&scene, 1.0, FIELD_OF_VIEW);
        let world = World::new(scene).map_err(|e| e.to_string())?;
        let (width, height) = (self.cell, self.cell);
        let light = match &self.lighting {
            Some(sky) => {
                let settings =
                    TwinSettings { width, height, samples: self.samples, ..TwinSettings::default() };
                let lighting = sky.with_lights_of(world.scene());
                Twin::new(&world, &camera, &lighting, Choices::default(), settings)
                    .render(&Default::default())
                    .picture(false)
            }
            None => {
                let path = PathOptions { sky_visible: true, ..PathOptions::default() };
                let settings = Settings { width, height, path, ..Settings::default() };
                let renderer = Renderer::new(&world, camera, settings);
                let mut film = renderer.film();
                renderer.render(&mut film, 0, self.samples, &Default::default());
                film.picture(false)
            }
        };
        Ok(colors(&develop(&light, &self.development)))
    }
}

/// The pixels of a developed picture of three channels.
fn colors(picture: &Image) -> Vec<Rgb> {
    let byte = |x, y, c| (picture.sample(x, y, c) * 255.0 + 0.5) as u8;
    let row = |y| (0..picture.width).map(move |x| [0, 1, 2].map(|c| byte(x, y, c)));
    (0..picture.height).flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_numbered_from_the_second_on() {
        assert_eq!(page_path(Path::new("a/s.png"), 1), Path::new("a/s.png"));
        assert_eq!(page_path(Path::new("a/s.png"), 12), Path::new("a/s-12.png"));
    }
}
