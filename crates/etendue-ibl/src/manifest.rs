//! What is what in a folder of baked files, as JSON for other programs.

use crate::bake::Baked;
use crate::sh::Sh9;
use crate::unity::UnitySh;
use serde::Serialize;

/// A cube in a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CubeEntry {
    /// File names beside the manifest: one file with all mips, or one for each mip from the largest.
    pub files: Vec<String>,
    /// Texel format.
    pub encoding: String,
    /// Texels along an edge of the largest mip.
    pub size: u32,
    /// What the numbers are.
    pub quantity: &'static str,
    /// How the faces are turned.
    pub orientation: &'static str,
    /// The perceptual roughness of each mip, if mips mean roughness.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub roughness: Vec<f32>,
    /// The curve from roughness to level of detail.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mapping: Option<String>,
}

/// The reflectance table in a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DfgEntry {
    /// File name beside the manifest.
    pub file: String,
    /// Texels along an edge.
    pub size: u32,
    /// What the axes and channels are.
    pub layout: &'static str,
}

/// Spherical harmonics, in three forms.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShEntry {
    /// Order and convention of the coefficients.
    pub convention: &'static str,
    /// Radiance, undamped: nine RGB triples.
    pub radiance: Sh9,
    /// Name of the window.
    pub window: String,
    /// Its factors of bands 0, 1, 2.
    pub window_factors: [f64; 3],
    /// Radiance, windowed.
    pub windowed: Sh9,
    /// The windowed coefficients for Unity's `ShadeSH9`, for normals in this frame (right-handed, +Y up).
    pub unity: UnitySh,
    /// The same for Unity's left-handed world, z turned around.
    pub unity_left_handed: UnitySh,
}

/// The whole folder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Manifest {
    /// Program and version.
    pub generator: &'static str,
    /// The sky as it was named.
    pub sky: String,
    /// Where the light was taken; absent for a sky.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe: Option<ProbeEntry>,
    /// Frame and orientation of all that is here.
    pub frame: &'static str,
    /// What was done to the sky on reading it.
    pub notes: Vec<String>,
    /// Harmonics.
    pub sh9: ShEntry,
    /// Irradiance.
    pub irradiance: CubeEntry,
    /// Prefiltered radiance.
    pub specular: CubeEntry,
    /// Reflectance.
    pub dfg: DfgEntry,
}

/// Program and version.
pub const GENERATOR: &str = concat!("etendue ", env!("CARGO_PKG_VERSION"));

/// Frame and orientation.
pub const FRAME: &str = "right-handed, +Y up (glTF's), metres; linear Rec.709";

/// Orientation of faces as textures.
pub const FACES_AS_TEXTURES: &str = "+X -X +Y -Y +Z -Z as in OpenGL, Vulkan, D3D and KTX2";

/// Orientation of faces in OpenEXR's strips.
pub const FACES_AS_OPENEXR: &str = "+X -X +Y -Y +Z -Z below one another as in OpenEXR's envmap = cube (seen from inside: against textures, \
    sides are mirrored left to right, top and bottom upside down); texels centred";

/// Order and convention of harmonics in files.
pub const SH_CONVENTION: &str = "c = integral of L Y; real harmonics Y00 Y1-1 Y10 Y11 Y2-2 Y2-1 Y20 Y21 Y22 \
    (0.282095; 0.488603 y, z, x; 1.092548 xy, yz; 0.315392 (3zz-1); 1.092548 xz; 0.546274 (xx-yy)); \
    irradiance = sum of A c Y with A = pi, 2pi/3, pi/4 by band";

/// Where a probe stood.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbeEntry {
    /// The scene as it was named.
    pub scene: String,
    /// The place, metres.
    pub at: [f32; 3],
    /// Lower and upper corner of the box whose walls the picture is taken to lie on, for parallax correction: cut the reflected ray with it, look
    /// from `at` to the point that is hit.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub volume: Option<[[f32; 3]; 2]>,
    /// Path-traced samples for each texel.
    pub samples: u32,
    /// The share of directions in which the probe sees the back of a one-sided surface first: near 1, it stands inside of something.
    pub backs: f32,
}

impl ShEntry {
    /// Of a baked sky.
    pub fn new(baked: &Baked, window: String) -> Self {
        Self {
            convention: SH_CONVENTION,
            radiance: baked.sh,
            window,
            window_factors: baked.window,
            windowed: baked.sh_windowed,
            unity: UnitySh::new(&baked.sh_windowed),
            unity_left_handed: UnitySh::new(&baked.sh_windowed.mirror_z()),
        }
    }
}
