//! What can be said to the commands that look at models: `info`, `check`, `convert`, and to `new`, which writes one.

use super::limit_args::LimitArgs;
use super::values::finite;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// A .glb, .gltf, .obj, .ply or .stl file or a scene file (.toml); the built-in helmet if absent
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Models, and folders in which all models are found: .glb, .gltf, .obj, .ply, .stl; scene files (.toml) by name
    #[arg(required = true, value_name = "FILE|FOLDER")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Count warnings as errors
    #[arg(long)]
    pub strict: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// A .glb, .gltf, .obj, .ply or .stl file or a scene file (.toml); the built-in helmet if absent
    pub model: Option<PathBuf>,
    /// Where it goes: .glb, or .gltf for JSON that holds everything
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// The model as it is at this time of its animation, and nothing else of it: no animation, no skins, no hierarchy
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = finite)]
    pub at: Option<f32>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// The scene file
    #[arg(default_value = "scene.toml")]
    pub file: PathBuf,
    /// Write over files that are there
    #[arg(long)]
    pub force: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}
