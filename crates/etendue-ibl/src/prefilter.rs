//! The sky as a GGX lobe sees it: the split sum's first factor.
//!
//! For each direction, with the normal, the view and the reflection all along it,
//!
//! ```text
//! L(R, roughness) = ∫ L(l) D(h) k(l) dl / ∫ D(h) k(l) dl          h halfway between R and l
//! ```
//!
//! with k the cosine (Karis 2013, "Real Shading in Unreal Engine 4") or the rest of the lobe, Smith's masking. Samples are
//! drawn from D and take the sky from a mip whose texels are as large as the sample's share of the sphere, so that a small
//! sun is seen by all samples near it a little instead of by few a lot (Křivánek, Colbert 2008, "Real-Time Shading with
//! Filtered Importance Sampling", section 4).

use crate::cube::{CubeMap, face_texels};
use crate::cube_lookup::CubeLookup;
use crate::mip_mapping::MipMapping;
use crate::sky::SkyMap;
use etendue_bxdf::Ggx;
use etendue_bxdf::math::{ln, sin_cos_tau};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use rayon::prelude::*;
use std::f32::consts::PI;
use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};

/// k of the module's head: what beside D weighs the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// N·L: what engines bake.
    #[default]
    Cosine,
    /// Smith's height-correlated G2: the lobe itself at normal incidence, so that light × [`crate::Dfg`] is exact there.
    Lobe,
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cosine => "cosine",
            Self::Lobe => "lobe",
        })
    }
}

impl FromStr for Kernel {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "cosine" => Ok(Self::Cosine),
            "lobe" => Ok(Self::Lobe),
            _ => Err("give cosine or lobe".into()),
        }
    }
}

/// What to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrefilterOptions {
    /// Texels along an edge of mip 0.
    pub size: u32,
    /// The mip that stands for roughness 1; mip 0 is the sky itself.
    pub steps: u32,
    /// Samples for each texel of the rough mips.
    pub samples: u32,
    /// Roughness of each mip.
    pub mapping: MipMapping,
    /// What beside D weighs the light.
    pub kernel: Kernel,
    /// Levels added to each sample's level of detail: above 0 smoother, below sharper and more grainy.
    pub lod_bias: f32,
}

impl Default for PrefilterOptions {
    /// 256² faces, 1024 samples, linear mips down to 8².
    fn default() -> Self {
        Self {
            size: 256,
            steps: 5,
            samples: 1024,
            mapping: MipMapping::Linear,
            kernel: Kernel::Cosine,
            lod_bias: 0.0,
        }
    }
}

impl PrefilterOptions {
    /// The steps that bring faces of `size`² down to 8² (or to one mip less for smaller ones), 1 at least.
    pub fn steps_for(size: u32) -> u32 {
        size.max(1).ilog2().saturating_sub(3).max(1)
    }
}

/// One direction about +Z with its weight, and the level of detail to see it at.
#[derive(Clone, Copy, Debug)]
struct Sample {
    direction: Vec3A,
    weight: f32,
    lod: f32,
}

/// The samples of one roughness: a golden-angle spiral, even over the part of D that reflects upwards.
fn samples(roughness: f32, n: u32, source_size: u32, kernel: Kernel, lod_bias: f32) -> Vec<Sample> {
    let alpha = roughness * roughness;
    let ggx = Ggx::new(alpha, alpha);
    let a2 = alpha * alpha;
    // D's normals have cos² = (1 − u) / (1 + (α² − 1) u); those with cos² > ½ reflect upwards: u < 1/(1 + α²).
    let top = 1.0 / (1.0 + a2);
    let texel = 4.0 * PI / (6.0 * source_size as f32 * source_size as f32);
    let mut out: Vec<Sample> = (0..n)
        .map(|i| {
            let u = top * (i as f32 + 0.5) / n as f32;
            let cos2 = (1.0 - u) / (1.0 + (a2 - 1.0) * u);
            let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).max(0.0).sqrt());
            let (sin_phi, cos_phi) = sin_cos_tau((f64::from(i) * 0.618_033_988_749_894_9).fract() as f32);
            let z = (2.0 * cos2 - 1.0).max(0.0);
            let direction = vec3a(2.0 * cos * sin * cos_phi, 2.0 * cos * sin * sin_phi, z);
            let weight = match kernel {
                Kernel::Cosine => z,
                Kernel::Lobe => ggx.g2(Vec3A::Z, direction),
            };
            // Density of the reflected direction: D cos / (4 cos), over the part that is sampled.
            let density = ggx.d(vec3a(sin, 0.0, cos)) * 0.25 / top;
            let share = 1.0 / (n as f32 * density);
            Sample { direction, weight, lod: 0.5 * ln(share / texel) * std::f32::consts::LOG2_E + lod_bias }
        })
        .filter(|s| s.weight > 0.0)
        .collect();
    let total: f64 = out.iter().map(|s| f64::from(s.weight)).sum();
    out.iter_mut().for_each(|s| s.weight = (f64::from(s.weight) / total) as f32);
    out
}

/// Prefilters a cube that has its chain of mips ([`CubeMap::with_mips`]).
///
/// The result has `steps` + 1 mips, or fewer if the size does not allow them. `progress` is told the fraction that is done, from any thread.
/// The result depends on nothing but the arguments.
pub fn prefilter(
    source: &CubeLookup,
    options: &PrefilterOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> CubeMap {
    let size = options.size.max(1);
    let steps = options.steps.clamp(1, size.ilog2().max(1));
    // Mip 0 is the sky at the output's own resolution.
    let ratio = source.size() as f32 / size as f32;
    let lod = if ratio > 1.0 { ln(ratio) * std::f32::consts::LOG2_E } else { 0.0 };
    let mut cube = CubeMap::from_fn(size, |d| source.trilinear(d, lod));
    let total: u64 = (1..=steps).map(|m| u64::from((size >> m).max(1)).pow(2) * 6).sum();
    let done = AtomicU64::new(0);
    for mip in 1..=steps {
        let n = (size >> mip).max(1);
        let roughness = options.mapping.roughness(mip, steps);
        let samples =
            samples(roughness, options.samples.max(1), source.size(), options.kernel, options.lod_bias);
        let texels = face_texels(n, |d| {
            let light = gather(source, d, &samples);
            let now = done.fetch_add(1, Ordering::Relaxed) + 1;
            if now.is_multiple_of(1024) || now == total {
                progress(now as f64 / total as f64);
            }
            light
        });
        if !cube.push_mip(texels) {
            break;
        }
    }
    cube
}

#[inline(always)]
fn gather(source: &CubeLookup, n: Vec3A, samples: &[Sample]) -> Spectrum {
    let (x, y) = n.any_orthonormal_pair();
    let mut sum = Spectrum::ZERO;
    for s in samples {
        let d = x * s.direction.x + y * s.direction.y + n * s.direction.z;
        sum += source.trilinear(d, s.lod) * s.weight;
    }
    sum
}

/// The integral that [`prefilter()`] approximates, summed over all texels of the sky.
#[derive(Clone, Debug)]
pub struct ExactPrefilter {
    /// Direction, radiance and solid angle of each cell.
    cells: Vec<(Vec3A, Spectrum, f32)>,
}

impl ExactPrefilter {
    /// Divides each texel of the sky into `parts`² cells with the bilinear picture's radiance in their middles. A lobe should span
    /// several cells: for a picture of w columns, α ≥ 10 / (w · parts) is good.
    pub fn new(sky: &SkyMap, parts: usize) -> Self {
        let (w, h) = (sky.width() * parts.max(1), sky.height() * parts.max(1));
        let cells = (0..h)
            .into_par_iter()
            .flat_map_iter(|y| {
                let at = |f: f64| std::f64::consts::PI * (y as f64 + f) / h as f64;
                let solid_angle = (at(0.0).cos() - at(1.0).cos()) * std::f64::consts::TAU / w as f64;
                let (sin, cos) = at(0.5).sin_cos();
                (0..w).map(move |x| {
                    let u = (x as f64 + 0.5) / w as f64;
                    let (s, c) = (std::f64::consts::TAU * (u - 0.5)).sin_cos();
                    let d = vec3a((sin * c) as f32, cos as f32, (sin * s) as f32);
                    let l = sky.bilinear(u as f32 + sky.turn(), (y as f32 + 0.5) / h as f32);
                    (d, l, solid_angle as f32)
                })
            })
            .collect();
        Self { cells }
    }

    /// The prefiltered radiance in the unit direction `n` for a perceptual roughness above 0.
    pub fn at(&self, n: Vec3A, roughness: f32, kernel: Kernel) -> Spectrum {
        let alpha = roughness.max(0.0).min(1.0).powi(2);
        let ggx = Ggx::new(alpha, alpha);
        let parts: Vec<([f64; 3], f64)> = self
            .cells
            .par_chunks(1 << 14)
            .map(|cells| {
                let (mut sum, mut total) = ([0.0f64; 3], 0.0f64);
                for (d, l, solid_angle) in cells {
                    let z = d.dot(n);
                    if !(z > 0.0) {
                        continue;
                    }
                    // The lobe is symmetric about n: only the angle to it matters. The sine by the cross product, whose
                    // digits do not vanish near the peak.
                    let local = vec3a(d.cross(n).length(), 0.0, z);
                    let k = match kernel {
                        Kernel::Cosine => z,
                        Kernel::Lobe => ggx.g2(Vec3A::Z, local),
                    };
                    let weight = f64::from(ggx.d_along(local + Vec3A::Z) * k * solid_angle);
                    total += weight;
                    (0..3).for_each(|c| sum[c] += weight * f64::from(l[c]));
                }
                (sum, total)
            })
            .collect();
        let (mut sum, mut total) = ([0.0f64; 3], 0.0);
        for (s, t) in parts {
            (0..3).for_each(|c| sum[c] += s[c]);
            total += t;
        }
        if total > 0.0 { Spectrum::from_rgb(sum.map(|v| (v / total) as f32)) } else { Spectrum::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resample::to_cube;
    use crate::sky::tests_support::lat_long;
    use etendue_bxdf::laws::Rng;

    fn small(kernel: Kernel, mapping: MipMapping) -> PrefilterOptions {
        PrefilterOptions { size: 32, steps: 3, samples: 256, mapping, kernel, lod_bias: 0.0 }
    }

    #[test]
    fn a_white_sky_is_one_at_every_mip() {
        let source = to_cube(&lat_long(16, 8, 0.0, |_, _| [1.0, 0.5, 0.25]), 32).with_mips();
        for kernel in [Kernel::Cosine, Kernel::Lobe] {
            for mapping in [MipMapping::Linear, MipMapping::Notes] {
                let cube = prefilter(&CubeLookup::new(&source), &small(kernel, mapping), &|_| ());
                assert_eq!(cube.mip_count(), 4);
                for mip in 0..4 {
                    for l in cube.mip(mip) {
                        let error = (*l - Spectrum::rgb(1.0, 0.5, 0.25)).map(f32::abs).max_element();
                        assert!(error < 1e-4, "mip {mip}: {l:?}");
                    }
                }
            }
        }
    }

    /// Against the direct sum, on a sky with a small bright light, each mip at random texels.
    #[test]
    fn mips_meet_the_integral() {
        let sky = lat_long(128, 64, 0.9, |x, y| {
            let sun = if (60..62).contains(&x) && y == 20 { 2000.0 } else { 0.0 };
            [sun + 0.5 + (x % 32) as f32 / 32.0, 1.0 + y as f32 / 64.0, if y < 32 { 1.0 } else { 0.2 }]
        });
        let source = CubeLookup::new(&to_cube(&sky, 128).with_mips());
        let exact = ExactPrefilter::new(&sky, 2);
        for kernel in [Kernel::Cosine, Kernel::Lobe] {
            let options = small(kernel, MipMapping::Linear);
            let cube = prefilter(&source, &options, &|_| ());
            let mut rng = Rng::new(8);
            for mip in 1..=3u32 {
                let n = cube.mip_size(mip as usize);
                let (mut error, mut count) = (0.0, 0.0);
                for _ in 0..40 {
                    let i = (rng.uniform() * (6 * n * n) as f32) as u32 % (6 * n * n);
                    let c = |v| crate::cube::texel_centre(v, n);
                    let d = crate::cube::face_direction((i / (n * n)) as usize, c(i % n), c(i / n % n));
                    let want = exact.at(d.normalize(), options.mapping.roughness(mip, 3), kernel);
                    let got = cube.mip(mip as usize)[i as usize];
                    for c in 0..3 {
                        error += ((got[c] - want[c]) / (want[c] + 0.01)).powi(2);
                        count += 1.0;
                    }
                }
                let rel_mse = error / count;
                println!("{kernel} mip {mip}: relMSE {rel_mse:.1e}");
                assert!(rel_mse < 2e-3, "{kernel} mip {mip}: relMSE {rel_mse}");
            }
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let source = CubeLookup::new(
            &to_cube(&lat_long(32, 16, 0.0, |x, y| [x as f32, y as f32, 1.0]), 16).with_mips(),
        );
        let options = PrefilterOptions { size: 16, steps: 2, samples: 32, ..Default::default() };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| prefilter(&source, &options, &|_| ()))
        };
        assert_eq!(run(1), run(3));
    }
}
