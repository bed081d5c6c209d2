//! `etendue bake --probe` and `--probes`: the light at places of a model, path-traced.

use super::bake::bar;
use super::bake_args::BakeArgs;
use super::bake_files::File;
use super::{CliError, load, note_line, scene_file};
use crate::ibl::CubeMap;
use crate::ibl::manifest::ProbeEntry;
use crate::ibl::probe_file::HIDDEN;
use crate::probe::{self, ProbeSettings, Volume};
use crate::render::World;
use crate::scene::Environment;
use glam::{Vec3, Vec3A};
use std::path::Path;

/// A model under its sky, ready to be traced.
struct Stage {
    world: World,
    /// The sky's name.
    sky: String,
    /// What was noted, and told.
    notes: Vec<String>,
    bounces: u32,
}

/// The model as `render` shows it: a scene file's settings count, and the sky that a model brings along.
fn stage(args: &BakeArgs, model: &Path) -> Result<Stage, CliError> {
    let render = scene_file::under(args.as_render(model))?;
    let (scene, notes) = load::scene(&render)?;
    let own = matches!(scene.environment, Environment::LatLong { .. }) && render.sky.env.is_none();
    let default = if own { "the model's own" } else { "studio" };
    let sky = render.sky.env.unwrap_or_else(|| default.into());
    Ok(Stage { world: World::new(scene)?, sky, notes, bounces: render.bounces })
}

fn tell(args: &BakeArgs, note: &str) {
    if !args.quiet {
        note_line(&format!("warning: {note}"));
    }
}

/// Traces a reflection probe: where it stood, its picture, the sky's name, and what was noted.
pub(crate) fn reflection_probe(
    args: &BakeArgs,
    model: &Path,
) -> Result<(ProbeEntry, CubeMap, String, Vec<String>), CliError> {
    let Some(at) = args.at else { return Err(CliError::Usage("--probe needs --at".into())) };
    let Stage { world, sky, mut notes, bounces } = stage(args, model)?;
    let place = Vec3A::from(at.0);
    let backs = probe::backs(&world, place);
    if backs > HIDDEN {
        let [x, y, z] = at.0;
        let note = format!(
            "{:.0} % of what ({x}, {y}, {z}) sees are backs of surfaces: it is inside of something",
            100.0 * backs
        );
        tell(args, &note);
        notes.push(note);
    }
    if let Some(b) = args.volume
        && !(0..3).all(|k| (b.0[0][k]..=b.0[1][k]).contains(&at.0[k]))
    {
        return Err(CliError::Usage("--at is outside of --box".into()));
    }
    let settings = ProbeSettings {
        size: args.probe_size.unwrap_or(args.size),
        samples: args.probe_samples.unwrap_or(64),
        bounces,
        ..ProbeSettings::default()
    };
    let bar = bar(!args.quiet);
    let cube = probe::cube_probe(&world, place, &settings, &|f| bar.set_position((f * 1000.0) as u64));
    bar.finish_and_clear();
    let scene = model.display().to_string();
    let entry =
        ProbeEntry { scene, at: at.0, volume: args.volume.map(|b| b.0), samples: settings.samples, backs };
    Ok((entry, cube, sky, notes))
}

/// Traces a grid of light probes: its file, and the report.
pub(crate) fn light_probes(args: &BakeArgs) -> Result<(Vec<File>, serde_json::Value), CliError> {
    let (Some(counts), Some(model)) = (args.probes, args.sky.as_deref()) else {
        return Err(CliError::Usage("--probes needs a model".into()));
    };
    let Stage { world, sky, mut notes, bounces } = stage(args, Path::new(model))?;
    let corners = match args.volume {
        Some(b) => b.0.map(Vec3::from),
        None => {
            let b = world.accel().bounds();
            if b.is_empty() {
                return Err(CliError::Usage(format!("{model} has no surface; say where with --box")));
            }
            [b.min.into(), b.max.into()]
        }
    };
    let volume = Volume::cells(corners, counts)
        .ok_or_else(|| CliError::Usage("the model's size is no number; give a --box".into()))?;
    let settings =
        ProbeSettings { samples: args.probe_samples.unwrap_or(6144), bounces, ..ProbeSettings::default() };
    let bar = bar(!args.quiet);
    let told = |f: f64| bar.set_position((f * 1000.0) as u64);
    let file = probe::light_probes(&world, model, &volume, &settings, &told)
        .ok_or_else(|| CliError::Usage("the box is too large for its places to be numbers".into()))?;
    bar.finish_and_clear();
    let hidden = file.backs.iter().filter(|b| **b > HIDDEN).count();
    if hidden > 0 {
        let note = format!(
            "{hidden} of {} probes stand inside of something; lookups leave them out",
            file.backs.len()
        );
        tell(args, &note);
        notes.push(note);
    }
    let report = serde_json::json!({
        "scene": model, "sky": sky, "notes": notes, "counts": counts, "first": volume.first.to_array(),
        "last": volume.last.to_array(), "hidden": hidden,
    });
    Ok((vec![File { path: args.output.clone(), bytes: file.to_json().into_bytes() }], report))
}
