//! What `etendue sheet` can be told.

use super::args::Integrator;
use super::limit_args::LimitArgs;
use super::values::{finite, positive_duration};
use crate::color::ToneCurve;
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
pub(crate) struct SheetArgs {
    /// Models, and folders in which all models are found: .glb, .gltf, .obj, .ply, .stl
    #[arg(required = true, value_name = "FILE|FOLDER")]
    pub files: Vec<PathBuf>,
    /// Where the sheet goes; further pages beside it, as in sheet-2.png
    #[arg(short, long, value_name = "FILE.png", default_value = "sheet.png")]
    pub output: PathBuf,
    /// Width and height of a picture, pixels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(32..=2048), help_heading = "Sheet")]
    pub cell: u32,
    /// Pictures side by side
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=64), help_heading = "Sheet")]
    pub columns: u32,
    /// Rows on a page
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=256), help_heading = "Sheet")]
    pub rows: u32,
    /// What stands under a picture: the name of its file, or its path
    #[arg(long, value_name = "file|path", default_value = "file", value_parser = names, help_heading = "Sheet")]
    pub names: Names,
    /// Sky: a .hdr or .exr file, `studio` (built in), `none`, or a colour as R,G,B (linear)
    #[arg(long, value_name = "SKY", default_value = "studio", help_heading = "Scene")]
    pub env: String,
    /// Evaluate animations at this time instead of at rest
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = finite, help_heading = "Scene")]
    pub at: Option<f32>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Exposure, EV: each step doubles the light
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Picture")]
    pub exposure: f32,
    /// Tone curve: none, aces, aces-fitted, agx, neutral, reinhard
    #[arg(long, default_value_t = ToneCurve::Neutral, help_heading = "Picture")]
    pub curve: ToneCurve,
    /// How light is found: path or realtime
    #[arg(long, value_name = "NAME", default_value_t = Integrator::Realtime, help_heading = "Work")]
    pub integrator: Integrator,
    /// Samples per pixel
    #[arg(short = 'n', long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=65536), help_heading = "Work")]
    pub spp: u32,
    /// Most time for one model, loading and drawing; one that takes longer is shown as failed
    #[arg(long, value_name = "TIME", default_value = "2m", value_parser = positive_duration, help_heading = "Work")]
    pub time: Duration,
    /// Count warnings as errors
    #[arg(long, help_heading = "Report")]
    pub strict: bool,
    /// Print JSON
    #[arg(long, help_heading = "Report")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Report")]
    pub quiet: bool,
}

/// What stands under a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Names {
    /// The file's name without its extension.
    File,
    /// Its path as far as there is room.
    Path,
}

fn names(s: &str) -> Result<Names, String> {
    match s {
        "file" => Ok(Names::File),
        "path" => Ok(Names::Path),
        _ => Err("give file or path".into()),
    }
}
