//! Scene files on the command line: their settings under the arguments, and their models in the place of one.

use super::CliError;
use super::args::{Cli, Command, RenderArgs};
use super::settings::{self, Setting};
use crate::builtin::HELMET_GLB;
use crate::import::scene_file::{Grammar, LoadOptions, SceneFile, SceneModels, is_scene_file, schema};
use crate::import::{ImportOptions, Imported, Limits};
use clap::Parser;
use serde_json::{Map, Value};
use std::path::Path;

/// Models that need no file.
pub(crate) const BUILTINS: [(&str, &[u8]); 1] = [("helmet", HELMET_GLB)];

/// Their names.
pub(crate) fn builtin_names() -> Vec<&'static str> {
    BUILTINS.iter().map(|(n, _)| *n).collect()
}

/// Reads a scene file.
pub(crate) fn read(path: &Path, limits: &Limits, settings: &[Setting]) -> Result<SceneFile, CliError> {
    let sections = settings::sections(settings);
    let builtins = builtin_names();
    let grammar =
        Grammar { sections: &sections, builtins: &builtins, limits: limits.clone(), ..Grammar::default() };
    Ok(SceneFile::read(path, &grammar)?)
}

/// Reads and loads a scene file; `variant` goes before those that it names.
pub(crate) fn load(path: &Path, import: &ImportOptions, variant: Option<&str>) -> Result<Imported, CliError> {
    let options = LoadOptions { import: import.clone(), builtins: &BUILTINS, variant };
    Ok(read(path, &import.limits, &settings::settings())?.load(&options)?)
}

/// Reads a scene file and the files of its models, to be shown at many moments.
pub(crate) fn models<'v>(
    path: &Path,
    import: &ImportOptions,
    variant: Option<&'v str>,
) -> Result<SceneModels<'v>, CliError> {
    let options = LoadOptions { import: import.clone(), builtins: &BUILTINS, variant };
    Ok(read(path, &import.limits, &settings::settings())?.with_models(&options)?)
}

/// The arguments with the settings of the scene file under them, if the model is one: what stood on the command line goes first,
/// then what the file says, then defaults.
pub(crate) fn under(args: RenderArgs) -> Result<RenderArgs, CliError> {
    let Some(path) = args.model.clone().filter(|m| is_scene_file(m)) else { return Ok(args) };
    let settings = settings::settings();
    let file = read(&path, &args.limits.limits(), &settings)?;
    let of = |s: &crate::import::scene_file::Setting| {
        settings.iter().find(|known| known.section == s.section && known.key.name == s.key)
    };
    let found: Vec<_> = file.settings.iter().filter_map(|s| Some((s, of(s)?))).collect();
    let parse = |words: Vec<String>| {
        let line = ["etendue".to_owned(), "render".to_owned()].into_iter().chain(words);
        Cli::try_parse_from(line)
    };
    type Found<'a> = (&'a crate::import::scene_file::Setting, &'a Setting);
    let words = |(s, known): &Found<'_>| settings::words(&known.long, &s.value);
    let base = match parse(found.iter().flat_map(words).collect()) {
        Ok(Cli { command: Some(Command::Render(base)) }) => *base,
        Ok(_) => return Ok(args),
        Err(all) => {
            // Which of them it is: one that is wrong alone, or one that the message names.
            let is_value = |e: &clap::Error| {
                matches!(
                    e.kind(),
                    clap::error::ErrorKind::ValueValidation | clap::error::ErrorKind::InvalidValue
                )
            };
            let alone = found.iter().find_map(|f| Some((f, parse(words(f)).err().filter(is_value)?)));
            let text = reason(&all);
            let (at, text) = match alone {
                Some((f, e)) => (Some(f), reason(&e)),
                None => (found.iter().find(|f| text.contains(&format!("--{}", f.1.long))), text),
            };
            let span = at.map_or(0..0, |f| f.0.span.clone());
            return Err(file.mistake(&span, text, None).into());
        }
    };
    let mut merged = over(&base, &args)?;
    merged.in_file = found.iter().map(|(_, known)| known.id.clone()).collect();
    // As they were given, even if they are no Unicode.
    merged.model = args.model;
    Ok(merged)
}

/// The sentence of an error of the command line's parser.
fn reason(e: &clap::Error) -> String {
    let text = e.to_string();
    let first = text.lines().next().unwrap_or_default();
    first.strip_prefix("error: ").unwrap_or(first).to_owned()
}

/// Options of which one that is given replaces all.
pub(crate) const GOAL: [&str; 4] = ["spp", "noise", "time", "samples"];

/// The arguments `base`, and over them those of `now` that stood on the command line.
pub(crate) fn over(base: &RenderArgs, now: &RenderArgs) -> Result<RenderArgs, CliError> {
    let (mut all, new) = (fields(base), fields(now));
    let mut take = |key: &str| {
        if let Some(v) = new.get(key) {
            all.insert(key.to_string(), v.clone());
        }
    };
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
    let mut args: RenderArgs =
        serde_json::from_value(Value::Object(all)).map_err(|e| CliError::Other(e.to_string()))?;
    args.given.clone_from(&now.given);
    Ok(args)
}

/// Arguments by name.
pub(crate) fn fields(args: &RenderArgs) -> Map<String, Value> {
    match serde_json::to_value(args) {
        Ok(Value::Object(m)) => m,
        _ => Map::new(),
    }
}

/// `etendue schema`.
pub(crate) fn print_schema() {
    super::say(&schema_text());
}

/// The schema of scene files, with a line break after each value.
pub(crate) fn schema_text() -> String {
    let settings = settings::settings();
    format!("{:#}", schema(&settings::sections(&settings), &builtin_names()))
}
