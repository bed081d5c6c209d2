//! `etendue compare`: how far a picture is from its reference.

use super::compare_args::CompareArgs;
use super::error::shell_word;
use super::output::read_whole;
use super::{CliError, note_line, say};
use crate::image::{DecodeLimits, Development, Image, decode_picture, write_atomic};
use crate::lab::compare::{CompareError, PictureReport};
use std::path::Path;

pub(crate) fn run(args: &CompareArgs) -> Result<(), CliError> {
    let read = |path: &Path| -> Result<(String, Image), CliError> {
        let image =
            decode_picture(&read_whole(path)?, &DecodeLimits::default()).map_err(|e| e.in_file(path))?;
        Ok((path.display().to_string(), image))
    };
    let (reference, picture) = (read(&args.reference)?, read(&args.picture)?);
    let mut report = PictureReport::new(reference, picture, args.ppd)?;
    // From its text: a float's digits beyond those that were written would be noise in the report.
    report.max_flip = args.max_flip.and_then(|x| x.to_string().parse().ok());
    report.development =
        Development { exposure_ev: args.exposure, curve: args.curve, ..Development::default() };
    report.command = command();

    let json = format!("{:#}\n", report.to_json());
    if let Some(folder) = &args.output {
        make_folder(folder)?;
        // The page last: who finds it finds all.
        write(&folder.join("report.json"), json.as_bytes())?;
        write(&folder.join("index.html"), report.to_html().as_bytes())?;
    }
    if args.json {
        say(json.trim_end());
    } else if !args.quiet {
        say(report.comparison.figures.to_text().trim_end());
    }
    if let (Some(folder), false) = (&args.output, args.quiet) {
        note_line(&folder.join("index.html").display().to_string());
    }
    let flip = report.comparison.figures.flip.mean;
    match report.max_flip {
        Some(limit) if !report.passes() => {
            Err(CliError::Differs { flip, limit, report: args.output.as_ref().map(|f| f.join("index.html")) })
        }
        _ => Ok(()),
    }
}

/// The command line as it could be typed again.
fn command() -> String {
    let mut words: Vec<String> = std::env::args_os().map(|a| shell_word(&a.to_string_lossy())).collect();
    // The program by its name: where it lies is nobody's business.
    if let Some(first) = words.first_mut() {
        *first = "etendue".into();
    }
    words.join(" ")
}

fn make_folder(path: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(path).map_err(|source| CliError::Write { path: path.into(), source })
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    write_atomic::<std::io::Error>(path, |w| w.write_all(bytes))
        .map_err(|source| CliError::Write { path: path.into(), source })
}

impl From<CompareError> for CliError {
    fn from(e: CompareError) -> Self {
        match e {
            CompareError::Image(e) => e.into(),
            e => Self::Incomparable(e),
        }
    }
}
