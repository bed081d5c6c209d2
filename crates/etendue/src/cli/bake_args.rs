//! What can be said to `etendue bake`.

use super::args::RenderArgs;
use super::limit_args::LimitArgs;
use super::sky_args::SkyArgs;
use super::values::{Vec3Arg, finite, non_negative, vec3};
use crate::ibl::{DfgLayout, Kernel, MipMapping, TexelFormat, Window};
use crate::image::SkyLayout;
use clap::{Args, ValueEnum};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A kind of file for cubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CubeFormat {
    /// Khronos' container, all mips
    Ktx2,
    /// DirectX' container, all mips
    Dds,
    /// OpenEXR, the faces below one another, a file for each mip
    Exr,
    /// Radiance, likewise
    Hdr,
}

impl CubeFormat {
    pub fn extension(self) -> &'static str {
        match self {
            Self::Ktx2 => "ktx2",
            Self::Dds => "dds",
            Self::Exr => "exr",
            Self::Hdr => "hdr",
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct BakeArgs {
    /// Sky: a .hdr, .exr, .ktx2 or .dds file, `studio` (built in), or a colour as R,G,B (linear); with --probes the model, a .glb or .gltf file
    #[arg(value_name = "SKY|MODEL", required_unless_present_any = ["dfg", "probe"])]
    pub sky: Option<String>,
    /// A folder for everything, or a file for the prefiltered cube alone (.ktx2 .dds .exr .hdr), for the table with --dfg (.exr .hdr), or for
    /// --probes (.json)
    #[arg(short, long, value_name = "DIR|FILE")]
    pub output: PathBuf,
    /// Kind of the cubes' files [default: ktx2 in a folder, else by the extension]
    #[arg(long, value_name = "KIND", help_heading = "Files")]
    pub format: Option<CubeFormat>,
    /// Texels of .ktx2 and .dds: rgba16f, rgb9e5, bc6h
    #[arg(long, value_name = "TEXEL", default_value_t, help_heading = "Files")]
    pub encoding: TexelFormat,
    /// How the sky's file shows all directions: latlong, strip, strip-exr, cross, cross-texture [default: what the file says or looks like]
    #[arg(long, value_name = "LAYOUT", help_heading = "Sky")]
    pub env_layout: Option<SkyLayout>,
    /// Turn the sky about the vertical, degrees, counter-clockwise from above
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Sky")]
    pub env_rotation: f32,
    /// Multiply the sky
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true, value_parser = non_negative, help_heading = "Sky")]
    pub env_intensity: f32,
    /// Bake what this model looks like from a place inside of it, path-traced, instead of a sky: a reflection probe
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["sky", "dfg"], requires = "at", help_heading = "Probes")]
    pub probe: Option<PathBuf>,
    /// Where the reflection probe stands, metres
    #[arg(long, value_name = "X,Y,Z", value_parser = vec3, allow_hyphen_values = true, requires = "probe", help_heading = "Probes")]
    pub at: Option<Vec3Arg>,
    /// Path-trace so many light probes along x, y and z, nine harmonics each, in the middles of the cells of a box
    #[arg(long, value_name = "NX,NY,NZ", value_parser = counts, conflicts_with_all = ["dfg", "probe", "format"], help_heading = "Probes")]
    pub probes: Option<[u32; 3]>,
    /// The box of --probes [default: the model's], or the one on whose walls the picture of --probe lies (for parallax correction), metres
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_parser = corners, allow_hyphen_values = true, help_heading = "Probes")]
    pub volume: Option<Corners>,
    /// Sky of the model: a .hdr, .exr, .ktx2 or .dds file, `studio`, `none`, or a colour as R,G,B [default: what a scene file says, the model's own, or studio]
    #[arg(long, value_name = "SKY", help_heading = "Probes")]
    pub env: Option<String>,
    /// Texels along an edge of the faces that are path-traced [default: --size]
    #[arg(long, value_name = "N", value_parser = power_of_two, requires = "probe", help_heading = "Probes")]
    pub probe_size: Option<u32>,
    /// Samples for each texel of --probe [default: 64], for each probe of --probes [default: 6144]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24), help_heading = "Probes")]
    pub probe_samples: Option<u32>,
    /// Most times that light is scattered on its way to a probe
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(..=1024), help_heading = "Probes")]
    pub bounces: u32,
    #[command(flatten)]
    pub limits: LimitArgs,
    /// Texels along an edge of the prefiltered cube: a power of two, 4 to 2048
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = power_of_two, help_heading = "Cubes")]
    pub size: u32,
    /// Samples for each texel of the rough mips
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65536), help_heading = "Cubes")]
    pub samples: u32,
    /// Roughness of the mips: linear, or notes (roughness (1.7 − 0.7 roughness) × 6, as Unity)
    #[arg(long, value_name = "CURVE", default_value_t, help_heading = "Cubes")]
    pub mapping: MipMapping,
    /// The mip of roughness 1 [default: the one of 8 texels for linear, 6 for notes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=11), help_heading = "Cubes")]
    pub steps: Option<u32>,
    /// What weighs the light beside the microfacets: cosine (as engines bake), lobe (Smith's masking)
    #[arg(long, value_name = "KERNEL", default_value_t, help_heading = "Cubes")]
    pub kernel: Kernel,
    /// Texels along an edge of the irradiance cube
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=256), help_heading = "Cubes")]
    pub irradiance_size: u32,
    /// Damping of the harmonics against ringing: auto, none, hann, lanczos, cosine (=WIDTH), laplacian=LAMBDA
    #[arg(long, value_name = "WINDOW", default_value_t, help_heading = "Harmonics")]
    pub window: Window,
    /// The reflectance table alone, which needs no sky
    #[arg(long, conflicts_with_all = ["sky", "format"], help_heading = "Table")]
    pub dfg: bool,
    /// Texels along an edge of the table
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(2..=1024), help_heading = "Table")]
    pub dfg_size: u32,
    /// Channels of the table: scale-bias (F0·r + g), multiscatter (mix(r, g, F0), b for cloth)
    #[arg(long, value_name = "LAYOUT", default_value = "scale-bias", value_parser = layout, help_heading = "Table")]
    pub dfg_layout: DfgLayout,
    /// Samples for each texel of the table; 0 for quadrature
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(..=1 << 20), help_heading = "Table")]
    pub dfg_samples: u32,
    /// Threads [default: all]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Work")]
    pub threads: Option<u32>,
    /// Print one JSON report to standard output
    #[arg(long, help_heading = "Report")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Report")]
    pub quiet: bool,
    /// The options that stood on the command line.
    #[arg(skip)]
    pub given: BTreeSet<String>,
}

/// What means the same to `render`; its `--at`, `--size` and `--samples` are others.
const AS_RENDER: [&str; 9] = [
    "env",
    "env_layout",
    "env_rotation",
    "env_intensity",
    "bounces",
    "drafts",
    "allow_outside",
    "max_memory",
    "limit",
];

impl BakeArgs {
    /// What of this concerns how the model of a probe is loaded and lit.
    pub fn as_render(&self, model: &Path) -> RenderArgs {
        RenderArgs {
            model: Some(model.to_path_buf()),
            sky: SkyArgs {
                env: self.env.clone(),
                env_layout: self.env_layout,
                env_rotation: self.env_rotation,
                env_intensity: self.env_intensity,
                light: Vec::new(),
            },
            limits: self.limits.clone(),
            bounces: self.bounces,
            quiet: self.quiet,
            json: self.json,
            given: self.given.iter().filter(|k| AS_RENDER.contains(&k.as_str())).cloned().collect(),
            ..Default::default()
        }
    }
}

/// Lower and upper corner of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corners(pub [[f32; 3]; 2]);

fn corners(s: &str) -> Result<Corners, String> {
    let v: Option<Vec<f32>> =
        s.split(',').map(|p| p.trim().parse().ok().filter(|v: &f32| v.is_finite())).collect();
    match v.as_deref() {
        Some(&[a, b, c, d, e, f]) if a < d && b < e && c < f => Ok(Corners([[a, b, c], [d, e, f]])),
        _ => Err("give six numbers, the lower corner and the upper one, as in -1,0,-1,1,2,1".into()),
    }
}

fn counts(s: &str) -> Result<[u32; 3], String> {
    let v: Option<Vec<u32>> = s.split(',').map(|p| p.trim().parse().ok().filter(|n| *n > 0)).collect();
    match v.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().map(|n| u128::from(*n)).product::<u128>() <= 1 << 20 => {
            Ok([x, y, z])
        }
        _ => Err("give three counts, as in 8,4,8, of a million probes at most".into()),
    }
}

fn power_of_two(s: &str) -> Result<u32, String> {
    s.parse()
        .ok()
        .filter(|n: &u32| n.is_power_of_two() && (4..=2048).contains(n))
        .ok_or_else(|| "give a power of two from 4 to 2048".into())
}

fn layout(s: &str) -> Result<DfgLayout, String> {
    match s {
        "scale-bias" => Ok(DfgLayout::ScaleBias),
        "multiscatter" => Ok(DfgLayout::Multiscatter),
        _ => Err("give scale-bias or multiscatter".into()),
    }
}
