//! `etendue check`: what is wrong with files, over many of them, for pipelines.

use super::find_models::find_models;
use super::info::table;
use super::model_args::CheckArgs;
use super::output::{bytes, count};
use super::{CliError, load, say};
use crate::import::{ImportOptions, Imported};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// How a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
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

/// What there is to say of a file.
pub(crate) struct Checked {
    pub verdict: Verdict,
    row: Vec<String>,
    /// What is to say, with its place.
    pub messages: Vec<String>,
    json: Value,
}

impl Checked {
    /// Of a model that loaded.
    pub fn loaded(path: &Path, model: &Imported) -> Self {
        let (name, info) = (path.display().to_string(), &model.info);
        let all = || model.warnings.iter().chain(&info.breaches);
        let verdict = if all().next().is_none() { Verdict::Good } else { Verdict::Warned };
        let notes: u64 = all().map(|w| w.count).sum();
        let row = vec![
            name.clone(),
            verdict.word().into(),
            info.format.to_owned(),
            bytes(info.bytes + info.external_bytes),
            format!("{} triangles", count(info.counts.shown_triangles as f64)),
            match notes {
                0 => String::new(),
                1 => "1 warning".into(),
                n => format!("{n} warnings"),
            },
        ];
        let json = json!({
            "file": name,
            "verdict": verdict.word(),
            "format": info.format,
            "bytes": info.bytes + info.external_bytes,
            "triangles": info.counts.shown_triangles,
            "warnings": model.warnings,
            "breaches": info.breaches,
            "unusual": info.unusual,
        });
        let messages = all().map(ToString::to_string).collect();
        Self { verdict, row, messages, json }
    }

    /// Of one that did not.
    pub fn refused(path: &Path, error: &CliError) -> Self {
        // The message begins with the file's name, which stands there already.
        let text = error.to_string();
        let message = text.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&text);
        Self::failed(path, message)
    }

    /// Of one that came to nothing for the reason given.
    pub fn failed(path: &Path, message: &str) -> Self {
        let (name, word) = (path.display().to_string(), Verdict::Bad.word());
        Self {
            verdict: Verdict::Bad,
            row: vec![name.clone(), word.into()],
            json: json!({ "file": name, "verdict": word, "error": message }),
            messages: vec![message.to_owned()],
        }
    }

    /// Notes how long it took.
    pub fn took(mut self, seconds: f64) -> Self {
        self.json["seconds"] = json!(seconds);
        self
    }
}

/// What there is to say of many files.
#[derive(Default)]
pub(crate) struct Checklist {
    rows: Vec<Vec<String>>,
    list: Vec<Value>,
    said: String,
    counts: [usize; 3],
}

impl Checklist {
    /// Adds a file.
    pub fn add(&mut self, path: &Path, c: Checked) {
        self.counts[c.verdict as usize] += 1;
        for m in &c.messages {
            self.said += &format!("{}: {}: {m}\n", path.display(), c.verdict.word());
        }
        self.rows.push(c.row);
        self.list.push(c.json);
    }

    /// Prints a table and what is wrong, or with `json` one document, to which `more` is added.
    pub fn print(&self, json: bool, more: &[(&str, Value)]) -> Result<(), CliError> {
        let [good, warned, bad] = self.counts;
        if json {
            let mut report = json!({ "files": self.list, "ok": good, "warnings": warned, "errors": bad });
            more.iter().for_each(|(key, value)| report[*key] = value.clone());
            say(&serde_json::to_string_pretty(&report).map_err(|e| CliError::Other(e.to_string()))?);
            return Ok(());
        }
        let mut out = String::new();
        table(&mut out, "files", &self.rows);
        say(out.trim());
        if !self.said.is_empty() {
            say(&format!("\n{}", self.said.trim_end()));
        }
        say(&format!("\n{good} ok, {warned} with warnings, {bad} with errors"));
        Ok(())
    }

    /// An error if a file does not load, or with `strict` not without warnings.
    pub fn judge(&self, strict: bool) -> Result<(), CliError> {
        let [_, warned, bad] = self.counts;
        match if strict { warned + bad } else { bad } {
            0 => Ok(()),
            wanting => Err(CliError::Wanting { wanting, files: self.list.len() }),
        }
    }
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), CliError> {
    let options = ImportOptions { conformance: true, ..args.limits.options() };
    let mut list = Checklist::default();
    for path in find_models(&args.files)? {
        let started = Instant::now();
        let checked = match load::read(Some(&path), &options, None) {
            Ok(model) => Checked::loaded(&path, &model),
            Err(e) => Checked::refused(&path, &e),
        };
        list.add(&path, checked.took(started.elapsed().as_secs_f64()));
    }
    list.print(args.json, &[])?;
    list.judge(args.strict)
}
