//! Other projects' test suites of valid and broken files: what our readers make of each, beside what its suite expects.
//!
//! ```text
//! cargo run --release -p etendue --example suites -- ASSETS [--list] [--only NAME]
//! ```
//!
//! `ASSETS` holds `malformed/` and `images-valid/`, in each a folder per suite. Every file is read in a process of its own by
//! the reader that the program has for it, which may take ten seconds and 64 times the file's size and 64 MB of memory. What
//! is expected is said by reports beside the files, by their names or by what the suite is for (`expect.rs`). Valid pictures
//! that come with their decoded form are compared with it.
//!
//! Ends with 1 if a file makes a reader panic, hang or take too much memory, or if a valid one is refused for a reason other
//! than a feature that is named as not supported.
#![forbid(unsafe_code)]

mod child;
mod expect;
mod reference;

use child::{Outcome, watch};
use clap::Parser;
use expect::{Expected, expected, is_meant};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Reads every file of other projects' test suites and says whether the outcome is the expected one.
#[derive(Parser)]
struct Args {
    /// Folder of `malformed/` and `images-valid/`.
    assets: PathBuf,
    /// Only suites whose name contains this.
    #[arg(long)]
    only: Option<String>,
    /// Names each file that does not come out as expected, and why.
    #[arg(long)]
    list: bool,
    /// Reads this file and prints what comes of it: what the processes for single files are started with.
    #[arg(long, hide = true)]
    one: bool,
}

/// What became of a file, beside what was expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Loaded,
    Blamed,
    Refused,
    Unsupported,
    Tolerated,
    Silent,
    Either,
    WronglyRefused,
    Panic,
    Hang,
    Memory,
}

impl Verdict {
    const ALL: [(Self, &str); 11] = [
        (Self::Loaded, "valid, loaded"),
        (Self::Blamed, "valid, blamed"),
        (Self::Refused, "broken, refused"),
        (Self::Tolerated, "broken, warned"),
        (Self::Silent, "broken, silent"),
        (Self::Unsupported, "unsupported"),
        (Self::Either, "may be either"),
        (Self::WronglyRefused, "valid, REFUSED"),
        (Self::Panic, "PANIC"),
        (Self::Hang, "HANG"),
        (Self::Memory, "MEMORY"),
    ];

    fn of(expected: Expected, outcome: &Outcome) -> Self {
        match (outcome, expected) {
            (Outcome::Panicked(_), _) => Self::Panic,
            (Outcome::Hung, _) => Self::Hang,
            (Outcome::Greedy(_), _) => Self::Memory,
            (_, Expected::Either)
            | (Outcome::Refused { missing: true, .. }, Expected::Valid | Expected::Readable) => Self::Either,
            (Outcome::Loaded { breaches, .. }, Expected::Valid) if *breaches > 0 => Self::Blamed,
            (Outcome::Loaded { .. }, Expected::Valid | Expected::Readable) => Self::Loaded,
            (Outcome::Refused { unsupported: true, .. }, Expected::Valid | Expected::Readable) => {
                Self::Unsupported
            }
            (Outcome::Refused { .. }, Expected::Valid | Expected::Readable) => Self::WronglyRefused,
            (Outcome::Refused { .. }, Expected::Invalid) => Self::Refused,
            (Outcome::Loaded { warnings, .. }, Expected::Invalid) if *warnings > 0 => Self::Tolerated,
            (Outcome::Loaded { .. }, Expected::Invalid) => Self::Silent,
        }
    }

    fn is_good(self) -> bool {
        !matches!(self, Self::WronglyRefused | Self::Panic | Self::Hang | Self::Memory)
    }
}

/// All files under `folder`, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            out.extend(files(&path));
        } else {
            out.push(path);
        }
    }
    out.sort();
    out
}

/// Counts of one suite, and the largest share of its limit that a file's memory took.
#[derive(Default)]
struct Row {
    counts: BTreeMap<Verdict, usize>,
    memory: f64,
    seconds: f64,
}

fn suite(args: &Args, folder: &Path, name: &str) -> Result<Row, Box<dyn Error>> {
    let mut row = Row::default();
    for path in files(folder).into_iter().filter(|p| is_meant(name, p)) {
        let inside = path.strip_prefix(folder).unwrap_or(&path);
        let expected = expected(name, inside, &path);
        let run = watch(&path)?;
        row.memory = row.memory.max(run.share_of_memory);
        row.seconds = row.seconds.max(run.seconds);
        let verdict = Verdict::of(expected, &run.outcome);
        *row.counts.entry(verdict).or_default() += 1;
        let odd =
            !verdict.is_good() || matches!(verdict, Verdict::Silent | Verdict::Unsupported | Verdict::Blamed);
        if args.list && odd || !verdict.is_good() {
            let what = Verdict::ALL.iter().find(|v| v.0 == verdict).map_or("", |v| v.1);
            println!("{name}/{}: {what}: {}", inside.display(), run.outcome);
        }
    }
    Ok(row)
}

fn run(args: &Args) -> Result<bool, Box<dyn Error>> {
    let mut rows = Vec::new();
    for part in ["images-valid", "malformed"] {
        let mut folders: Vec<PathBuf> = std::fs::read_dir(args.assets.join(part))?
            .filter_map(|e| Some(e.ok()?.path()))
            .filter(|p| p.is_dir())
            .collect();
        folders.sort();
        for folder in folders {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if args.only.as_ref().is_none_or(|o| name.contains(o.as_str())) {
                rows.push((name.clone(), suite(args, &folder, &name)?));
            }
        }
    }
    let used: Vec<(Verdict, &str)> = Verdict::ALL
        .into_iter()
        .filter(|(v, _)| !v.is_good() || rows.iter().any(|(_, r)| r.counts.contains_key(v)))
        .collect();
    print!("\n{:<28}{:>7}", "suite", "files");
    used.iter().for_each(|(_, what)| print!("{what:>17}"));
    println!("{:>12}{:>10}", "memory", "seconds");
    let mut sums: BTreeMap<Verdict, usize> = BTreeMap::new();
    for (name, row) in &rows {
        print!("{name:<28}{:>7}", row.counts.values().sum::<usize>());
        for (v, _) in &used {
            let n = row.counts.get(v).copied().unwrap_or(0);
            *sums.entry(*v).or_default() += n;
            print!("{n:>17}");
        }
        println!("{:>10.0} %{:>10.2}", row.memory * 100.0, row.seconds);
    }
    print!("{:<28}{:>7}", "all", sums.values().sum::<usize>());
    used.iter().for_each(|(v, _)| print!("{:>17}", sums.get(v).copied().unwrap_or(0)));
    println!();
    println!("memory: largest share of what a file may take (64 times its size and 64 MB)");
    let exact = reference::compare(&args.assets.join("images-valid"))?;
    Ok(exact && sums.iter().all(|(v, n)| v.is_good() || *n == 0))
}

fn main() -> ExitCode {
    let args = Args::parse();
    if args.one {
        child::read_one(&args.assets);
        return ExitCode::SUCCESS;
    }
    match run(&args) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}
