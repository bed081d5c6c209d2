//! What can be said on the command line.

use super::CliError;
use super::bake_args::BakeArgs;
use super::compare_args::CompareArgs;
use super::lab_args::LabArgs;
use super::limit_args::LimitArgs;
use super::model_args::{CheckArgs, ConvertArgs, InfoArgs, NewArgs};
use super::motion_args::MotionArgs;
use super::sheet_args::SheetArgs;
use super::sky_args::SkyArgs;
use super::values::{
    Vec3Arg, bits, duration, field_of_view, finite, path, positive, range, size, text, vec3,
};
use crate::bxdf::model::Field;
use crate::bxdf::multiscatter::Compensation;
use crate::color::ToneCurve;
use crate::render::{Filter, PassSet};
use clap::{Args, Parser, Subcommand};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Duration;

/// A physically based renderer that shows its own correctness.
///
/// Without a command it renders the built-in helmet under the built-in sky to etendue.png.
#[derive(Debug, Parser)]
#[command(name = "etendue", version, args_conflicts_with_subcommands = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Path-trace a model (glTF, OBJ, PLY, STL) under a sky
    Render(Box<RenderArgs>),
    /// Add films that hold different samples of one picture
    Merge(MergeArgs),
    /// Develop an .exr or .hdr picture without rendering it again
    Tonemap(TonemapArgs),
    /// Say what a model holds, what of it is supported, and what is unusual in it
    Info(InfoArgs),
    /// Try many models and say what is wrong with each; ends with 3 if one does not load
    Check(CheckArgs),
    /// Draw many models side by side, with their names and what is wrong with them; ends with 3 if one does not load
    Sheet(SheetArgs),
    /// Write a model as one glTF file: textures in it, tangents added, instances kept
    Convert(ConvertArgs),
    /// Write a scene file to begin with: everything that can be said in one, as comments
    New(NewArgs),
    /// Print the JSON Schema of scene files, from which an editor completes them
    Schema,
    /// Measure build time, rays, samples and time to equal error on fixed scenes, and the cost of each model
    Bench(BenchArgs),
    /// Integrate a sky for real-time shading: harmonics, irradiance, prefiltered cube, reflectance table
    Bake(Box<BakeArgs>),
    /// Measure how far a picture is from its reference, or a model's real-time picture from its path-traced one; ends with 3 above --max-flip
    Compare(Box<CompareArgs>),
    /// Plot scattering models, put them to the laws of light, compare formulas
    Lab(LabArgs),
}

#[derive(Clone, Debug, Default, Args, Serialize, Deserialize)]
pub(crate) struct RenderArgs {
    /// A .glb, .gltf, .obj, .ply or .stl file, or a scene file (.toml), whose settings these options go before; the built-in helmet if absent
    #[serde(with = "path")]
    pub model: Option<PathBuf>,
    /// Where the picture goes: .png .jpg .webp (developed), .exr .hdr (light) [default: MODEL.png, or etendue.png]
    #[arg(short, long, value_name = "FILE")]
    #[serde(with = "path")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub sky: SkyArgs,
    /// Evaluate the model's animation at this time instead of at rest
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = finite, help_heading = "Scene")]
    pub at: Option<f32>,
    #[command(flatten)]
    #[serde(flatten)]
    pub motion: MotionArgs,
    /// One of the model's sets of materials, by name (`etendue info` lists them) [default: the model's own]
    #[arg(long, value_name = "NAME", help_heading = "Scene")]
    pub variant: Option<String>,
    /// Another model instead of the file's materials, for all or the one called NAME (repeatable), e.g. gold, visor=openpbr:coat_weight=1; `etendue lab list` lists models and parameters
    #[arg(long, value_name = "[NAME=]MODEL[:PARAMETER=VALUE]", help_heading = "Scene")]
    #[serde(default)]
    pub material: Vec<String>,
    /// What is done about light that meets several microfacets of a glTF surface: a second lobe gives it back (kulla-conty), the lobe is scaled (turquin), or it is lost, as in glTF's appendix (none) [default: kulla-conty]
    #[arg(long, value_name = "WAY", value_parser = clap::builder::PossibleValuesParser::new(Compensation::CHOICES), help_heading = "Scene")]
    #[serde(default)]
    pub compensation: Option<String>,
    #[command(flatten)]
    #[serde(flatten)]
    pub limits: LimitArgs,
    /// A camera of the file, by number (from 0) or name [default: frames the model]
    #[arg(long, value_name = "N|NAME", conflicts_with_all = ["eye", "target"], help_heading = "Camera")]
    pub camera: Option<String>,
    /// Where the camera stands, metres
    #[arg(long, value_name = "X,Y,Z", value_parser = vec3, allow_hyphen_values = true, help_heading = "Camera")]
    pub eye: Option<Vec3Arg>,
    /// What the camera looks at [default: the model's middle]
    #[arg(long, value_name = "X,Y,Z", value_parser = vec3, allow_hyphen_values = true, requires = "eye", help_heading = "Camera")]
    pub target: Option<Vec3Arg>,
    /// What is up for the camera [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = vec3, allow_hyphen_values = true, requires = "eye", help_heading = "Camera")]
    pub up: Option<Vec3Arg>,
    /// Vertical field of view, degrees [default: 35, or the camera's own]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = field_of_view, help_heading = "Camera")]
    pub vfov: Option<f32>,
    /// Picture size, pixels [default: 512x512, or the camera's aspect at height 512]
    #[arg(short, long, value_name = "WxH", value_parser = size, help_heading = "Picture")]
    pub size: Option<(u32, u32)>,
    /// Pixel filter: box, gaussian, blackman-harris
    #[arg(long, default_value_t, help_heading = "Picture")]
    #[serde(with = "text")]
    pub filter: Filter,
    /// Show what the lights and the sky alone make of each surface: nothing shadows, no surface lights another
    #[arg(long, help_heading = "Picture")]
    #[serde(default)]
    pub light_only: bool,
    /// Leave the sky out of the picture: transparent where there is no surface
    #[arg(long, help_heading = "Picture")]
    pub transparent: bool,
    /// Record passes, separated by commas: layers of an .exr; in real time also pictures beside a .png. Of paths: albedo, normal, position, depth, uv, direct, indirect, diffuse, specular, emission, environment, light-diffuse, light-specular, sky-diffuse, sky-specular, bounce-diffuse, bounce-specular, transmission, object, material; parts for those that add up to the picture, or all; in real time others (--help)
    #[arg(long, value_name = "LIST", default_value = "", hide_default_value = true, long_help = super::realtime_help::passes(), help_heading = "Picture")]
    pub passes: String,
    #[command(flatten)]
    #[serde(flatten)]
    pub develop: DevelopArgs,
    /// Samples per pixel [default: 64, or as many as --noise or --time need]
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Work")]
    pub spp: Option<u32>,
    /// Stop when the estimated relative error of the picture falls below this, e.g. 0.01 (at the same sample on every machine)
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = positive, help_heading = "Work")]
    pub noise: Option<f32>,
    /// Stop after this time, e.g. 60s, 5m, 1h
    #[arg(long, value_name = "TIME", value_parser = duration, help_heading = "Work")]
    pub time: Option<Duration>,
    /// Take only these samples, half-open (for parts that `etendue merge` adds)
    #[arg(long, value_name = "A..B", value_parser = range, conflicts_with = "spp", help_heading = "Work")]
    pub samples: Option<(u32, u32)>,
    /// Another seed gives other noise
    #[arg(long, default_value_t = 0, help_heading = "Work")]
    pub seed: u32,
    /// Most times that light is scattered
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(..=1024), help_heading = "Work")]
    pub bounces: u32,
    /// Clamp a sample's indirect light to this (biased; off by default)
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = positive, help_heading = "Work")]
    pub clamp_indirect: Option<f32>,
    /// Threads [default: all]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Work")]
    pub threads: Option<u32>,
    /// How light is found: path (the reference) or realtime (as engines do, in a moment)
    #[arg(long, value_name = "NAME", default_value_t, help_heading = "Work")]
    #[serde(with = "text", default)]
    pub integrator: Integrator,
    /// Keep the film here (sums of samples, to resume or merge)
    #[arg(long, value_name = "FILE", help_heading = "Work")]
    #[serde(with = "path")]
    pub film: Option<PathBuf>,
    /// Write the film at least this often during the work, so that little is lost if the run is killed
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = duration, help_heading = "Work")]
    pub checkpoint: Duration,
    /// Go on from a film; options that are not given are taken from it
    #[arg(long, value_name = "FILM", help_heading = "Work")]
    #[serde(with = "path")]
    pub resume: Option<PathBuf>,
    /// In real time: whose approximations to make: exact, notes, unity, filament [default: exact]
    #[arg(long, value_name = "NAME", long_help = super::realtime_help::presets(), help_heading = "Real time")]
    #[serde(default)]
    pub preset: Option<String>,
    /// In real time: one approximation or another, as KEY=VALUE, several with commas (repeatable); --help lists them
    #[arg(long, value_name = "KEY=VALUE", long_help = super::realtime_help::choices(), help_heading = "Real time")]
    #[serde(default)]
    pub choice: Vec<String>,
    /// Rewrite the output while it refines
    #[arg(long, help_heading = "Report")]
    pub watch: bool,
    /// Print one JSON report to standard output
    #[arg(long, help_heading = "Report")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Report")]
    pub quiet: bool,
    /// Names of the fields that stood on the command line, as opposed to defaults.
    #[arg(skip)]
    #[serde(skip)]
    pub given: BTreeSet<String>,
    /// Names of the fields that a scene file sets.
    #[arg(skip)]
    #[serde(skip)]
    pub in_file: BTreeSet<String>,
}

/// Names of the arguments that stood on the command line.
pub(crate) fn given(matches: &clap::ArgMatches) -> BTreeSet<String> {
    let on_line =
        |id: &&clap::Id| matches.value_source(id.as_str()) == Some(clap::parser::ValueSource::CommandLine);
    matches.ids().filter(on_line).map(|id| id.to_string()).collect()
}

/// How light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Integrator {
    /// By tracing paths: the reference.
    #[default]
    Path,
    /// By real-time shading.
    Realtime,
}

impl Integrator {
    pub const ALL: [Self; 2] = [Self::Path, Self::Realtime];

    pub fn name(self) -> &'static str {
        if self == Self::Path { "path" } else { "realtime" }
    }
}

impl std::fmt::Display for Integrator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Integrator {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "path" => Ok(Self::Path),
            "realtime" => Ok(Self::Realtime),
            _ => Err(format!("no integrator is called {s:?}; there are path and realtime")),
        }
    }
}

impl RenderArgs {
    /// Whether the field stood on the command line or in the scene file.
    pub fn says(&self, field: &str) -> bool {
        self.given.contains(field) || self.in_file.contains(field)
    }

    /// The passes to record while tracing paths.
    pub fn path_passes(&self) -> Result<PassSet, CliError> {
        PassSet::parse(&self.passes).map_err(CliError::Usage)
    }

    /// What `etendue` without arguments does.
    pub fn builtin() -> Self {
        match Cli::parse_from(["etendue", "render"]).command {
            Some(Command::Render(a)) => *a,
            _ => unreachable!("`render` is a command without required arguments"),
        }
    }
}

#[derive(Clone, Debug, Default, Args, Serialize, Deserialize)]
pub(crate) struct DevelopArgs {
    /// Exposure, EV: each step doubles the light
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Development")]
    pub exposure: f32,
    /// Tone curve: none, aces, aces-fitted, agx, neutral, reinhard
    #[arg(long, default_value_t = ToneCurve::Neutral, help_heading = "Development")]
    #[serde(with = "text")]
    pub curve: ToneCurve,
    /// Leave out tone curve and sRGB encoding: values proportional to light
    #[arg(long, help_heading = "Development")]
    pub linear: bool,
    /// Bits per channel of .png: 8 or 16; of .exr: 16 (half) or 32 (float) [default: 8 and 16]
    #[arg(long, value_name = "BITS", value_parser = bits, help_heading = "Development")]
    pub bits: Option<u8>,
    /// Quality of .jpg
    #[arg(long, default_value_t = 92, value_parser = clap::value_parser!(u8).range(1..=100), help_heading = "Development")]
    pub quality: u8,
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Films to add, in any order
    #[arg(required = true)]
    pub films: Vec<PathBuf>,
    /// A picture (.exr .png …) or a .film
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub develop: DevelopArgs,
    /// Print one JSON report to standard output
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// As in [`RenderArgs`].
    #[arg(skip)]
    pub given: BTreeSet<String>,
}

#[derive(Debug, Args)]
pub(crate) struct TonemapArgs {
    /// An .exr or .hdr picture
    pub input: PathBuf,
    /// .png .jpg .webp, or .exr .hdr for exposure alone
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Layer of the .exr [default: the beauty picture]
    #[arg(long, default_value = "")]
    pub layer: String,
    #[command(flatten)]
    pub develop: DevelopArgs,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Only scenes and models whose name contains this; `models` for all models
    pub filter: Option<String>,
    /// Seconds for each measurement
    #[arg(long, default_value_t = 2.0, value_parser = positive)]
    pub seconds: f32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn arguments_survive_the_film() {
        let cli = Cli::parse_from([
            "etendue",
            "render",
            "a.glb",
            "--eye=-1,2,3",
            "--passes",
            "depth",
            "--curve",
            "agx",
        ]);
        let Some(Command::Render(a)) = cli.command else { panic!("not render") };
        let text = serde_json::to_string(&a).unwrap();
        let b: RenderArgs = serde_json::from_str(&text).unwrap();
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
}
