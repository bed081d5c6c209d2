//! `etendue lab`: plots, laws and formulas; the work is `etendue-lab`'s.

use super::error::shell_word;
use super::lab_args::{LabArgs, LabBxdfArgs, LabCommand, LabListArgs, LabNotesArgs, LabVerifyArgs};
use super::progress::clock;
use super::{CliError, note_line, say};
use crate::bxdf::laws::cases::{Settings, text};
use crate::bxdf::model::{Model, Value};
use crate::image::write_atomic;
use crate::lab::{bench, notes, verify};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(args: &LabArgs) -> Result<(), CliError> {
    match &args.command {
        LabCommand::List(a) => list(a),
        LabCommand::Bxdf(a) => bxdf(a),
        LabCommand::Verify(a) => laws(a),
        LabCommand::Notes(a) => formulas(a),
    }
}

fn list(args: &LabListArgs) -> Result<(), CliError> {
    if args.models.is_empty() {
        for name in Model::NAMES {
            say(&format!("{name:18} {}", Model::by_name(name)?.about()));
        }
        return Ok(());
    }
    for name in &args.models {
        let model = Model::by_name(name)?;
        say(&format!("{name}: {}", model.about()));
        for p in model.parameters() {
            let range = match p.default {
                Value::Number(_) | Value::Color(_) => format!("{} to {}", p.range[0], p.range[1]),
                Value::Vector(_) => "a direction".into(),
                Value::Flag(_) => "true or false".into(),
                Value::Choice(_) => p.choices.join(", "),
            };
            say(&format!("  {}={}   {range}", p.name, text(p.default)));
            for line in p.about.lines() {
                say(&format!("      {}", line.trim()));
            }
        }
    }
    Ok(())
}

fn bxdf(args: &LabBxdfArgs) -> Result<(), CliError> {
    let mut model = Model::by_name(&args.model)?;
    let mut command = format!("etendue lab bxdf {}", model.name());
    for p in &args.parameters {
        let (name, value) = p.split_once('=').ok_or_else(|| {
            CliError::Usage(format!(
                "{p:?} is not NAME=VALUE; `etendue lab list {}` has the names",
                args.model
            ))
        })?;
        model.set_text(name.trim(), value)?;
        command += &format!(" {}", shell_word(p));
    }
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}-plots", model.name())));
    make_folder(&folder)?;
    for plot in bench::plots(&model, &command) {
        let png = plot.drawing.to_png().map_err(|e| CliError::Other(format!("{}: {e}", plot.name)))?;
        write(&folder.join(format!("{}.png", plot.name)), &png)?;
        write(&folder.join(format!("{}.svg", plot.name)), plot.drawing.to_svg().as_bytes())?;
        if !args.quiet {
            let file = folder.join(plot.name);
            note_line(&format!("{}.png and .svg", file.display()));
        }
    }
    Ok(())
}

fn laws(args: &LabVerifyArgs) -> Result<(), CliError> {
    let names: Vec<&str> = if args.model.is_empty() {
        Model::NAMES.to_vec()
    } else {
        args.model.iter().map(String::as_str).collect()
    };
    let models = names.iter().map(|n| Model::by_name(n)).collect::<Result<Vec<_>, _>>()?;
    let mut settings = if args.full { Settings::full() } else { Settings::quick() };
    settings.seed = args.seed;
    if let Some(n) = args.samples {
        settings.samples = n as usize;
    }
    let mut command = "etendue lab verify".to_string();
    for n in &args.model {
        command += &format!(" --model {n}");
    }
    if args.full {
        command += " --full";
    }
    if let Some(n) = args.samples {
        command += &format!(" --samples {n}");
    }
    command += &format!(" --seed {} -o {}", args.seed, shell_word(&args.output.to_string_lossy()));

    let start = Instant::now();
    let target = if args.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(0), target);
    if let Ok(style) = ProgressStyle::with_template("{percent:>3}%  case {pos} of {len}  {wide_bar}") {
        bar.set_style(style.progress_chars("━╸ "));
    }
    let progress = |done: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, |n| n as usize))
        .build()
        .map_err(|e| CliError::Other(format!("cannot start threads: {e}")))?;
    let report = pool.install(|| verify::run(&models, &settings, &progress));
    bar.finish_and_clear();

    write(&args.output, verify::to_html(&report, &settings, &command).as_bytes())?;
    if let Some(path) = &args.json {
        let json = verify::to_json(&report, &settings, &command);
        write(path, format!("{json:#}\n").as_bytes())?;
    }
    let (failures, cells) = (report.failures().count(), report.cells().count());
    if !args.quiet || failures > 0 {
        say(verify::summary(&report).trim_end());
    }
    if !args.quiet {
        note_line(&format!(
            "{cells} cells of {} models in {}; {}",
            models.len(),
            clock(start.elapsed().as_secs_f64()),
            args.output.display()
        ));
    }
    if failures > 0 {
        return Err(CliError::Laws { count: failures, cells, report: args.output.clone() });
    }
    Ok(())
}

fn formulas(args: &LabNotesArgs) -> Result<(), CliError> {
    make_folder(&args.output)?;
    let file = args.output.join("notes.html");
    let entries = notes::entries();
    write(&file, notes::to_html(&entries).as_bytes())?;
    if !args.quiet {
        say(notes::summary(&entries).trim_end());
        note_line(&format!("{}", file.display()));
    }
    Ok(())
}

fn make_folder(path: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(path).map_err(|source| CliError::Write { path: path.into(), source })
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    write_atomic::<std::io::Error>(path, |w| w.write_all(bytes))
        .map_err(|source| CliError::Write { path: path.into(), source })
}
