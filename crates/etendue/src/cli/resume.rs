//! Going on from a film: which arguments are its own, and which may change.

use super::CliError;
use super::args::RenderArgs;
use super::output::ARGUMENTS;
use super::scene_file::{GOAL, fields, over};
use super::shot::Shot;
use crate::render::{Film, FilmError, FilmInfo};
use serde_json::{Map, Value};
use std::path::Path;

/// These always come from the present command.
const PRESENT: [&str; 8] = ["film", "resume", "watch", "json", "quiet", "threads", "checkpoint", "overwrite"];
/// These change how the picture is developed, not what it shows.
const DEVELOPMENT: [&str; 6] = ["output", "exposure", "curve", "linear", "bits", "quality"];

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
    let mut base = fields(&stored(path, info)?);
    let new = fields(&now);
    for key in PRESENT {
        if let Some(v) = new.get(key) {
            base.insert(key.to_string(), v.clone());
        }
    }
    let base: RenderArgs = serde_json::from_value(Value::Object(base))
        .map_err(|e| CliError::Film { path: path.to_path_buf(), source: FilmError::Header(e.to_string()) })?;
    over(&base, &now)
}

/// Finds out whether the film's samples are of the picture that is about to be rendered.
pub(crate) fn check(
    path: &Path,
    film: &Film,
    info: &FilmInfo,
    args: &RenderArgs,
    shot: &Shot,
) -> Result<(), CliError> {
    let s = shot.settings();
    let same_size = (film.width, film.height, film.passes) == (s.width, s.height, s.passes);
    if same_size && info.picture == shot.picture_id() {
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
