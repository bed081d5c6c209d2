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
    let (sh, irradiance) = (Sh9::project(sky), ExactIrradiance::with_rows(sky, 64));
    progress(0.05);
    let source = to_cube(sky, source_size(sky.height(), options.prefilter.size));
    integrate(sh, &irradiance, source, options, progress)
}

/// Integrates a cube of radiance, as a probe takes it of a scene: the same results as from a sky that looks like it. Its size should be a power of two:
/// rough lobes read its mips, which end where a size is odd.
pub fn bake_cube(cube: &CubeMap, options: &BakeOptions, progress: &(dyn Fn(f64) + Sync)) -> Baked {
    let (sh, irradiance) = (cube.project(), ExactIrradiance::of_cube(cube));
    progress(0.05);
    integrate(sh, &irradiance, cube.clone(), options, progress)
}

/// Shares of the time, as measured at the default size: a tenth for what comes before the prefilter.
fn integrate(
    sh: Sh9,
    irradiance: &ExactIrradiance,
    source: CubeMap,
    options: &BakeOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Baked {
    let window = options.window.factors(&sh);
    let irradiance = irradiance.cube(options.irradiance_size);
    let source = CubeLookup::new(&source.with_mips());
    progress(0.1);
    let specular = prefilter(&source, &options.prefilter, &|f| progress(0.1 + 0.9 * f));
    let steps = specular.mip_count() as u32 - 1;
    let roughness = (0..=steps).map(|mip| options.prefilter.mapping.roughness(mip, steps)).collect();
    Baked { sh, window, sh_windowed: sh.scale_bands(window), irradiance, specular, roughness }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::tests_support::lat_long;
    use etendue_color::Spectrum;

    fn quick() -> BakeOptions {
        let prefilter = PrefilterOptions { size: 16, steps: 2, samples: 64, ..Default::default() };
        BakeOptions { prefilter, irradiance_size: 8, window: Window::None }
    }

    fn far(a: Spectrum, b: Spectrum) -> f32 {
        (a - b).map(f32::abs).max_element()
    }

    /// A cube that shows a sky bakes to what the sky bakes to.
    #[test]
    fn cubes_and_skies_agree() {
        let sky = lat_long(64, 32, 0.4, |x, y| [1.0 + (x % 9) as f32, y as f32 / 16.0, 0.5]);
        let a = bake(&sky, &quick(), &|_| ());
        let b = bake_cube(&to_cube(&sky, 64), &quick(), &|_| ());
        for i in 0..9 {
            assert!(far(a.sh.0[i], b.sh.0[i]) < 0.01 * a.sh.0[0].max_element(), "coefficient {i}");
        }
        for (a, b) in a.irradiance.mip(0).iter().zip(b.irradiance.mip(0)) {
            assert!(far(*a, *b) < 0.01 * a.max_element(), "{a:?} {b:?}");
        }
        for mip in 1..a.specular.mip_count() {
            for (a, b) in a.specular.mip(mip).iter().zip(b.specular.mip(mip)) {
                assert!(far(*a, *b) < 0.05 * a.max_element(), "{a:?} {b:?}");
            }
        }
        assert_eq!(a.roughness, b.roughness);
    }

    #[test]
    fn a_white_cube_is_white() {
        let white = CubeMap::from_fn(32, |_| Spectrum::rgb(1.0, 2.0, 0.5));
        let b = bake_cube(&white, &quick(), &|_| ());
        let pi = std::f32::consts::PI;
        assert!(far(b.sh.irradiance(glam::Vec3::X), Spectrum::rgb(pi, 2.0 * pi, 0.5 * pi)) < 1e-4);
        assert!(b.irradiance.mip(0).iter().all(|e| (e[0] / pi - 1.0).abs() < 1e-3));
        assert!((0..3).all(|m| b.specular.mip(m).iter().all(|l| (l[1] - 2.0).abs() < 2e-4)));
    }
}
