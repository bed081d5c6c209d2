//! What can be said to `etendue compare`.

use super::args::{finite, non_negative};
use crate::color::ToneCurve;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// The reference picture: .png .jpg .webp (display values), .exr .hdr (light)
    pub reference: PathBuf,
    /// The picture to compare with it, of the same size and kind
    pub picture: PathBuf,
    /// Folder for the report (index.html, which needs nothing else, and report.json), made if it is not there
    #[arg(short, long, value_name = "DIR", help_heading = "Report")]
    pub output: Option<PathBuf>,
    /// Print the figures as JSON to standard output
    #[arg(long, help_heading = "Report")]
    pub json: bool,
    /// End with 3 if the mean FLIP is above this, 0 to 1
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = non_negative, help_heading = "Report")]
    pub max_flip: Option<f32>,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Report")]
    pub quiet: bool,
    /// Pixels per degree at which FLIP looks at the pictures
    #[arg(long, value_name = "N", default_value_t = crate::image::DEFAULT_PPD, value_parser = pixels_per_degree, help_heading = "Report")]
    pub ppd: f32,
    /// Exposure of light on the page, EV: each step doubles it; figures do not depend on it
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Report")]
    pub exposure: f32,
    /// Tone curve of light on the page: none, aces, aces-fitted, agx, neutral, reinhard
    #[arg(long, default_value_t = ToneCurve::Neutral, help_heading = "Report")]
    pub curve: ToneCurve,
}

fn pixels_per_degree(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|v| (1.0..=2000.0).contains(v)).ok_or_else(|| "give a number from 1 to 2000".into())
}
