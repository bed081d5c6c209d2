//! What can be said to `etendue compare`.

use super::args::{DevelopArgs, RenderArgs};
use super::limit_args::LimitArgs;
use super::sky_args::SkyArgs;
use super::values::{Vec3Arg, finite, non_negative, size, vec3};
use crate::color::ToneCurve;
use clap::Args;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// A reference picture (.png .jpg .webp display values, .exr .hdr light); or a model (.glb .gltf .obj .ply .stl, a scene file .toml, the built-in helmet if absent), whose real-time picture is compared with its path-traced one
    #[arg(value_name = "REFERENCE|MODEL")]
    pub reference: Option<PathBuf>,
    /// The picture to compare with the reference, of the same size and kind
    pub picture: Option<PathBuf>,
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
    /// Exposure of light, EV: each step doubles it. Figures of two pictures of light do not depend on it
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Report")]
    pub exposure: f32,
    /// Tone curve of light: none, aces, aces-fitted, agx, neutral, reinhard
    #[arg(long, default_value_t = ToneCurve::Neutral, help_heading = "Report")]
    pub curve: ToneCurve,
    #[command(flatten)]
    pub model: ModelArgs,
    /// Names of the fields that stood on the command line, as opposed to defaults.
    #[arg(skip)]
    pub given: BTreeSet<String>,
}

/// What only concerns models.
#[derive(Debug, Args)]
pub(crate) struct ModelArgs {
    #[command(flatten)]
    pub sky: SkyArgs,
    /// A camera of the file, by number (from 0) or name [default: frames the model]
    #[arg(long, value_name = "N|NAME", conflicts_with_all = ["eye", "target"], help_heading = "Model")]
    pub camera: Option<String>,
    /// Where the camera stands, metres
    #[arg(long, value_name = "X,Y,Z", value_parser = vec3, allow_hyphen_values = true, help_heading = "Model")]
    pub eye: Option<Vec3Arg>,
    /// What the camera looks at [default: the model's middle]
    #[arg(long, value_name = "X,Y,Z", value_parser = vec3, allow_hyphen_values = true, requires = "eye", help_heading = "Model")]
    pub target: Option<Vec3Arg>,
    /// Picture size, pixels
    #[arg(short, long, value_name = "WxH", value_parser = size, help_heading = "Model")]
    pub size: Option<(u32, u32)>,
    /// One of the model's sets of materials, by name
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    pub variant: Option<String>,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Choices of the real-time shading: exact, notes, unity, filament
    #[arg(long, value_name = "NAME", help_heading = "Real time")]
    pub preset: Option<String>,
    /// One choice otherwise (repeatable), e.g. dfg=karis; `etendue help render` lists them
    #[arg(long, value_name = "KEY=VALUE", help_heading = "Real time")]
    pub choice: Vec<String>,
    /// Samples of a pixel of the real-time picture
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=65536), help_heading = "Real time")]
    pub realtime_samples: u32,
    /// Which choices are changed in turn: all, or keys separated by commas
    #[arg(long, value_name = "LIST", default_value = "all", help_heading = "Real time")]
    pub ablations: String,
    /// Leave out the ablations and the presets
    #[arg(long, conflicts_with = "ablations", help_heading = "Real time")]
    pub quick: bool,
    /// Samples of a pixel of the pictures of the ablations
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=65536), help_heading = "Real time")]
    pub ablation_samples: u32,
    /// Samples of a pixel of each path-traced reference
    #[arg(short = 'n', long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..), help_heading = "Reference")]
    pub samples: u32,
    /// Most times that light is scattered
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(..=1024), help_heading = "Reference")]
    pub bounces: u32,
    /// Another seed gives other noise
    #[arg(long, default_value_t = 0, help_heading = "Reference")]
    pub seed: u32,
    /// Let --max-flip judge the shading beside lights and sky alone, without shadows, occlusion and interreflection, instead of the picture
    #[arg(long, requires = "max_flip", help_heading = "Reference")]
    pub light_only: bool,
    /// Threads [default: all]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Reference")]
    pub threads: Option<u32>,
}

/// What is to be compared.
pub(crate) enum Task<'a> {
    Pictures(&'a Path, &'a Path),
    Model(Option<&'a Path>),
}

impl CompareArgs {
    /// What the arguments ask for; an error for a mixture.
    pub fn task(&self) -> Result<Task<'_>, String> {
        let is_model = |p: &Path| {
            let extension = p.extension().and_then(|e| e.to_str()).unwrap_or("");
            ["glb", "gltf", "obj", "ply", "stl", "toml"].iter().any(|e| extension.eq_ignore_ascii_case(e))
        };
        let model_option = self.given.iter().find(|k| OF_MODELS.contains(&k.as_str()));
        match (self.reference.as_deref(), self.picture.as_deref()) {
            (None, _) => Ok(Task::Model(None)),
            (Some(m), None) if is_model(m) => Ok(Task::Model(Some(m))),
            (Some(m), Some(p)) if is_model(m) || is_model(p) => {
                Err(format!("{} and {}: give one model, or two pictures", m.display(), p.display()))
            }
            (Some(r), None) => Err(format!(
                "{} is a picture: give the one to compare with it, too (or a model, or a scene file)",
                r.display()
            )),
            (Some(r), Some(p)) => match model_option {
                Some(option) => {
                    Err(format!("--{} is for models, not for two pictures", option.replace('_', "-")))
                }
                None => Ok(Task::Pictures(r, p)),
            },
        }
    }

    /// The same scene and camera in the words of `etendue render`.
    pub fn as_render(&self, model: Option<&Path>) -> RenderArgs {
        let m = &self.model;
        RenderArgs {
            model: model.map(Path::to_path_buf),
            sky: m.sky.clone(),
            camera: m.camera.clone(),
            eye: m.eye,
            target: m.target,
            size: m.size,
            variant: m.variant.clone(),
            limits: m.limits.clone(),
            preset: m.preset.clone(),
            choice: m.choice.clone(),
            threads: m.threads,
            bounces: m.bounces,
            seed: m.seed,
            develop: DevelopArgs { exposure: self.exposure, curve: self.curve, ..Default::default() },
            quiet: self.quiet,
            json: self.json,
            // Words that mean something else here.
            given: self
                .given
                .iter()
                .filter(|k| !["output", "samples"].contains(&k.as_str()))
                .cloned()
                .collect(),
            ..RenderArgs::builtin()
        }
    }
}

/// Fields of [`ModelArgs`].
const OF_MODELS: [&str; 25] = [
    "light",
    "env",
    "env_layout",
    "env_rotation",
    "env_intensity",
    "camera",
    "eye",
    "target",
    "size",
    "variant",
    "drafts",
    "allow_outside",
    "max_memory",
    "limit",
    "preset",
    "choice",
    "realtime_samples",
    "ablations",
    "quick",
    "ablation_samples",
    "samples",
    "bounces",
    "seed",
    "light_only",
    "threads",
];

fn pixels_per_degree(s: &str) -> Result<f32, String> {
    finite(s).ok().filter(|v| (1.0..=2000.0).contains(v)).ok_or_else(|| "give a number from 1 to 2000".into())
}
