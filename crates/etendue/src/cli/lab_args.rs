//! What can be said to `etendue lab`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct LabArgs {
    #[command(subcommand)]
    pub command: LabCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum LabCommand {
    /// List the models, or the parameters of some
    List(LabListArgs),
    /// Plot a model: its lobe, D, G and F, albedo, samples against density
    Bxdf(LabBxdfArgs),
    /// Put models to every law, write a report; ends with 1 if a claimed law is broken
    Verify(LabVerifyArgs),
    /// Set the formulas that the founding notes got wrong beside the right ones
    Notes(LabNotesArgs),
}

#[derive(Debug, Args)]
pub(crate) struct LabListArgs {
    /// Models to describe with all their parameters [default: a line for each]
    pub models: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct LabBxdfArgs {
    /// The model; `etendue lab list` has them
    pub model: String,
    /// Parameters as NAME=VALUE: numbers, colours as R,G,B or #rrggbb, true or false, words
    #[arg(value_name = "NAME=VALUE")]
    pub parameters: Vec<String>,
    /// Folder for the plots, made if it is not there [default: MODEL-plots]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct LabVerifyArgs {
    /// Only this model; may be repeated
    #[arg(long, value_name = "NAME")]
    pub model: Vec<String>,
    /// The whole grid with 10⁶ samples per cell, instead of a part with 2·10⁴
    #[arg(long)]
    pub full: bool,
    /// Samples per cell
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1000..))]
    pub samples: Option<u32>,
    /// Another seed gives other samples
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Where the report goes, one HTML page
    #[arg(short, long, value_name = "FILE", default_value = "laws.html")]
    pub output: PathBuf,
    /// Write every cell as JSON, too
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Threads [default: all]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Print nothing but errors and what fails
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct LabNotesArgs {
    /// Folder for the page, made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "notes")]
    pub output: PathBuf,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}
