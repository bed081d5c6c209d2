//! `etendue bake --probe` and `--probes`: the light at places of a model, path-traced.

use super::bake::bar;
use super::bake_args::BakeArgs;
use super::bake_files::File;
use super::{CliError, load, note_line};
use crate::ibl::CubeMap;
use crate::ibl::manifest::ProbeEntry;
use crate::ibl::probe_file::HIDDEN;
use crate::probe::{self, ProbeSettings, Volume};
use crate::render::World;
use glam::{Vec3, Vec3A};
use std::path::Path;

/// The model under its sky, ready to be traced; the sky's name, and what was noted.
fn world(args: &BakeArgs, model: &Path) -> Result<(World, String, Vec<String>), CliError> {
    let imported = load::model(Some(model), None, &args.limits)?;
    let sky = args.env.as_deref().unwrap_or("studio");
    let (environment, notes) = load::sky_as(sky, args.env_layout, args.env_rotation, args.env_intensity)?;
    let notes: Vec<String> = imported.warnings.iter().map(ToString::to_string).chain(notes).collect();
    let mut scene = imported.scene;
    scene.environment = environment;
    Ok((World::new(scene)?, sky.to_string(), notes))
}

fn tell(args: &BakeArgs, notes: &[String]) {
    if !args.quiet {
        notes.iter().for_each(|n| note_line(&format!("warning: {n}")));
    }
}

/// Traces a reflection probe: where it stood, its picture, the sky's name, and what was noted.
pub(crate) fn reflection_probe(
    args: &BakeArgs,
    model: &Path,
) -> Result<(ProbeEntry, CubeMap, String, Vec<String>), CliError> {
    let Some(at) = args.at else { return Err(CliError::Usage("--probe needs --at".into())) };
    let (world, sky, mut notes) = world(args, model)?;
    let place = Vec3A::from(at.0);
    let backs = probe::backs(&world, place);
    if backs > HIDDEN {
        let [x, y, z] = at.0;
        notes.push(format!(
            "{:.0} % of what ({x}, {y}, {z}) sees are backs of surfaces: it is inside of something",
            100.0 * backs
        ));
    }
    if let Some(b) = args.volume
        && !(0..3).all(|k| (b.0[0][k]..=b.0[1][k]).contains(&at.0[k]))
    {
        return Err(CliError::Usage("--at is outside of --box".into()));
    }
    tell(args, &notes);
    let settings = ProbeSettings {
        size: args.probe_size.unwrap_or(args.size),
        samples: args.probe_samples.unwrap_or(64),
        bounces: args.bounces,
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
    let (world, sky, mut notes) = world(args, Path::new(model))?;
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
    tell(args, &notes);
    let settings = ProbeSettings {
        samples: args.probe_samples.unwrap_or(6144),
        bounces: args.bounces,
        ..ProbeSettings::default()
    };
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
        tell(args, std::slice::from_ref(&note));
        notes.push(note);
    }
    let report = serde_json::json!({
        "scene": model, "sky": sky, "notes": notes, "counts": counts, "first": volume.first.to_array(),
        "last": volume.last.to_array(), "hidden": hidden,
    });
    Ok((vec![File { path: args.output.clone(), bytes: file.to_json().into_bytes() }], report))
}
