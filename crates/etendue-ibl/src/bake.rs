//! Everything that an engine needs of one sky.

use crate::cube::CubeMap;
use crate::cube_lookup::CubeLookup;
use crate::irradiance::ExactIrradiance;
use crate::prefilter::{PrefilterOptions, prefilter};
use crate::resample::to_cube;
use crate::sh::Sh9;
use crate::sh_window::Window;
use crate::sky::SkyMap;

/// What to make of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// The prefiltered cube.
    pub prefilter: PrefilterOptions,
    /// Texels along an edge of the irradiance cube.
    pub irradiance_size: u32,
    /// Damping of the harmonics.
    pub window: Window,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self { prefilter: PrefilterOptions::default(), irradiance_size: 32, window: Window::Auto }
    }
}

/// A sky, integrated.
#[derive(Clone, Debug)]
pub struct Baked {
    /// Radiance as harmonics, undamped.
    pub sh: Sh9,
    /// What the window multiplied bands 0, 1, 2 with.
    pub window: [f64; 3],
    /// The harmonics with the window applied.
    pub sh_windowed: Sh9,
    /// Irradiance by direction (π under a sky of 1).
    pub irradiance: CubeMap,
    /// Prefiltered radiance, a mip for each roughness.
    pub specular: CubeMap,
    /// The perceptual roughness of each mip.
    pub roughness: Vec<f32>,
}

/// The face size of the cube from which a sky of `rows` rows is prefiltered: as fine as the picture (a face has as many texels as a
/// quarter of a row of it, and as in a half of its height), at least the output's, at most 1024.
pub fn source_size(rows: usize, output: u32) -> u32 {
    (rows.min(1 << 12) as u32).next_power_of_two().min(1024).max(output.next_power_of_two())
}

/// Integrates a sky. `progress` is told the fraction that is done, from any thread.
pub fn bake(sky: &SkyMap, options: &BakeOptions, progress: &(dyn Fn(f64) + Sync)) -> Baked {
    // Shares of the time, as measured at the default size.
    let sh = Sh9::project(sky);
    let window = options.window.factors(&sh);
    let irradiance = ExactIrradiance::with_rows(sky, 64).cube(options.irradiance_size);
    progress(0.05);
    let source = to_cube(sky, source_size(sky.height(), options.prefilter.size)).with_mips();
    let source = CubeLookup::new(&source);
    progress(0.1);
    let specular = prefilter(&source, &options.prefilter, &|f| progress(0.1 + 0.9 * f));
    let steps = specular.mip_count() as u32 - 1;
    let roughness = (0..=steps).map(|mip| options.prefilter.mapping.roughness(mip, steps)).collect();
    Baked { sh, window, sh_windowed: sh.scale_bands(window), irradiance, specular, roughness }
}
