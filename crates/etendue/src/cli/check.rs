//! `etendue check`: what is wrong with files, over many of them, for pipelines.

use super::info::table;
use super::model_args::CheckArgs;
use super::output::{bytes, count};
use super::{CliError, say};
use crate::import::{ImportOptions, Imported, Limits, import};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// How a file is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Good,
    /// It loads, with warnings.
    Warned,
    /// It does not load.
    Bad,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Good => "ok",
            Self::Warned => "warnings",
            Self::Bad => "error",
        }
    }
}

struct Checked {
    verdict: Verdict,
    row: Vec<String>,
    /// What is to say, with its place.
    messages: Vec<String>,
    json: Value,
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), CliError> {
    let limits = Limits { outside_folder: args.allow_outside, ..Limits::default() };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let (mut rows, mut list, mut said) = (Vec::new(), Vec::new(), String::new());
    let mut counts = [0usize; 3];
    for path in &args.files {
        let c = check(path, &options);
        counts[c.verdict as usize] += 1;
        for m in &c.messages {
            said += &format!("{}: {}: {m}\n", path.display(), c.verdict.word());
        }
        rows.push(c.row);
        list.push(c.json);
    }
    let [good, warned, bad] = counts;
    if args.json {
        let report = json!({ "files": list, "ok": good, "warnings": warned, "errors": bad });
        say(&serde_json::to_string_pretty(&report).map_err(|e| CliError::Other(e.to_string()))?);
    } else {
        let mut out = String::new();
        table(&mut out, "files", &rows);
        say(out.trim());
        if !said.is_empty() {
            say(&format!("\n{}", said.trim_end()));
        }
        say(&format!("\n{good} ok, {warned} with warnings, {bad} with errors"));
    }
    let wanting = if args.strict { warned + bad } else { bad };
    if wanting > 0 { Err(CliError::Wanting { wanting, files: args.files.len() }) } else { Ok(()) }
}

fn check(path: &Path, options: &ImportOptions) -> Checked {
    let started = Instant::now();
    let result = import(path, options);
    let seconds = started.elapsed().as_secs_f64();
    let name = path.display().to_string();
    let mut c = match result {
        Ok(model) => loaded(&name, &model),
        Err(e) => {
            // The message begins with the file's name, which stands there already.
            let text = e.to_string();
            let message = text.strip_prefix(&format!("{name}: ")).unwrap_or(&text).to_owned();
            Checked {
                verdict: Verdict::Bad,
                row: vec![name.clone(), Verdict::Bad.word().into()],
                json: json!({ "file": name, "verdict": Verdict::Bad.word(), "error": message }),
                messages: vec![message],
            }
        }
    };
    c.json["seconds"] = json!(seconds);
    c
}

fn loaded(name: &str, model: &Imported) -> Checked {
    let info = &model.info;
    let verdict = if model.warnings.is_empty() { Verdict::Good } else { Verdict::Warned };
    let notes: u64 = model.warnings.iter().map(|w| w.count).sum();
    let row = vec![
        name.to_owned(),
        verdict.word().into(),
        info.format.to_owned(),
        bytes(info.bytes + info.external_bytes),
        format!("{} triangles", count(info.counts.shown_triangles as f64)),
        if notes > 0 { format!("{notes} warnings") } else { String::new() },
    ];
    let json = json!({
        "file": name,
        "verdict": verdict.word(),
        "format": info.format,
        "bytes": info.bytes + info.external_bytes,
        "triangles": info.counts.shown_triangles,
        "warnings": model.warnings,
        "unusual": info.unusual,
    });
    Checked { verdict, row, messages: model.warnings.iter().map(ToString::to_string).collect(), json }
}
