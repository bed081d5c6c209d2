//! Going on from a film: which arguments are its own, and which may change.

use super::CliError;
use super::args::RenderArgs;
use super::output::ARGUMENTS;
use crate::render::{Film, FilmError, FilmInfo, Renderer};
use serde_json::{Map, Value};
use std::path::Path;

/// These always come from the present command.
const PRESENT: [&str; 7] = ["film", "resume", "watch", "json", "quiet", "threads", "checkpoint"];
/// These belong together: one that is given replaces all.
const GOAL: [&str; 4] = ["spp", "noise", "time", "samples"];
/// These change how the picture is developed, not what it shows.
const DEVELOPMENT: [&str; 6] = ["output", "exposure", "curve", "linear", "bits", "quality"];

fn fields(args: &RenderArgs) -> Map<String, Value> {
    match serde_json::to_value(args) {
        Ok(Value::Object(m)) => m,
        _ => Map::new(),
    }
}

/// The arguments with which a film was rendered.
pub(crate) fn stored(path: &Path, info: &FilmInfo) -> Result<RenderArgs, CliError> {
    let fail = |e: String| CliError::Film { path: path.to_path_buf(), source: FilmError::Header(e) };
    let text = info.notes.get(ARGUMENTS).ok_or_else(|| fail("it does not say how it was rendered".into()))?;
    let stored: Map<String, Value> = serde_json::from_str(text).map_err(|e| fail(e.to_string()))?;
    // Options that the program learned after the film was written have their defaults.
    let mut all = fields(&RenderArgs::builtin());
    all.extend(stored);
    serde_json::from_value(Value::Object(all)).map_err(|e| fail(e.to_string()))
}

/// Arguments of a continued run: those of the film, and over them those that stood on the command line.
pub(crate) fn overlay(now: RenderArgs, path: &Path, info: &FilmInfo) -> Result<RenderArgs, CliError> {
    let mut all = fields(&stored(path, info)?);
    let new = fields(&now);
    let mut take = |key: &str| {
        if let Some(v) = new.get(key) {
            all.insert(key.to_string(), v.clone());
        }
    };
    PRESENT.iter().for_each(|k| take(k));
    if GOAL.iter().any(|k| now.given.contains(*k)) {
        GOAL.iter().for_each(|k| take(k));
    }
    now.given.iter().for_each(|k| take(k));
    // A camera given in one way replaces one given in the other.
    if now.given.contains("camera") {
        ["eye", "target", "up"].iter().for_each(|k| take(k));
    } else if now.given.contains("eye") {
        ["camera", "target", "up"].iter().for_each(|k| take(k));
    }
    let mut args: RenderArgs = serde_json::from_value(Value::Object(all))
        .map_err(|e| CliError::Film { path: path.to_path_buf(), source: FilmError::Header(e.to_string()) })?;
    args.given = now.given;
    Ok(args)
}

/// Finds out whether the film's samples are of the picture that is about to be rendered.
pub(crate) fn check(
    path: &Path,
    film: &Film,
    info: &FilmInfo,
    args: &RenderArgs,
    renderer: &Renderer,
) -> Result<(), CliError> {
    let s = renderer.settings();
    let same_size = (film.width, film.height, film.passes) == (s.width, s.height, s.passes);
    if same_size && info.picture == renderer.picture_id() {
        return Ok(());
    }
    let changing: Vec<String> = args
        .given
        .iter()
        .filter(|k| {
            let k = k.as_str();
            fields(args).contains_key(k)
                && !PRESENT.contains(&k)
                && !GOAL.contains(&k)
                && !DEVELOPMENT.contains(&k)
        })
        .map(|k| if k == "model" { "another model".into() } else { format!("--{}", k.replace('_', "-")) })
        .collect();
    let why = if changing.is_empty() {
        "the model, the sky or the program has changed since it was written".into()
    } else {
        format!("with {} it would be another picture", changing.join(", "))
    };
    Err(CliError::Resume { path: path.to_path_buf(), why })
}
