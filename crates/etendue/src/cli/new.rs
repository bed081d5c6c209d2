//! `etendue new`: a scene file to begin with, and the schema that an editor completes it from.

use super::model_args::NewArgs;
use super::{CliError, note_line, say, scene_file, settings, target};
use crate::image::write_atomic;
use crate::import::scene_file::template;
use std::path::Path;

/// Beside the scene file; its first line says so.
const SCHEMA: &str = "etendue.schema.json";

pub(crate) fn run(args: &NewArgs) -> Result<(), CliError> {
    let path = &args.file;
    if !crate::import::scene_file::is_scene_file(path) {
        return Err(CliError::Usage(format!("{}: a scene file is a .toml", path.display())));
    }
    if path.exists() && !args.force {
        return Err(CliError::Usage(format!("{} is there already; --force writes over it", path.display())));
    }
    target::check_writable(path)?;
    let schema = path.with_file_name(SCHEMA);
    // An older one would not know what this program does.
    let text = scene_file::schema_text() + "\n";
    let write_schema = std::fs::read_to_string(&schema).is_ok_and(|old| old != text);
    if write_schema && !args.force {
        note_line(&format!(
            "{} is there already and says otherwise: left as it is; --force renews it",
            schema.display()
        ));
    } else {
        write(&schema, &text)?;
    }
    let settings = settings::settings();
    write(path, &template(&settings::sections(&settings), &scene_file::builtin_names(), SCHEMA))?;
    if !args.quiet {
        let name = super::error::shell_word(&path.to_string_lossy());
        say(&format!("{}: etendue render {name}", path.display()));
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), CliError> {
    write_atomic::<std::io::Error>(path, |w| w.write_all(text.as_bytes()))
        .map_err(|source| CliError::Write { path: path.to_path_buf(), source })
}
