//! Grids of light probes: spherical harmonics by path tracing.

use super::{ProbeSettings, backs, face_camera};
use crate::color::Spectrum;
use crate::ibl::sh::basis;
use crate::ibl::{ProbeFile, Sh9};
use crate::render::{Filter, PathOptions, PixelRays, Renderer, Sampler, Settings, World};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Pixels along an edge of a face: each gets its own stratified samples.
const FACE: u32 = 8;

/// Where the probes of a grid stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// The first probe, metres.
    pub first: Vec3,
    /// The last probe, metres.
    pub last: Vec3,
    /// Probes along x, y and z, at least 1 each.
    pub counts: [u32; 3],
}

impl Volume {
    /// Probes in the middles of equal cells of a box, so that none stands on its walls. `None` if the corners are not in order or not finite, or a count
    /// is 0.
    pub fn cells([min, max]: [Vec3; 2], counts: [u32; 3]) -> Option<Self> {
        let half = (max - min) / Vec3::from(counts.map(|c| c as f32)) * 0.5;
        let good =
            counts.iter().all(|c| *c > 0) && min.is_finite() && half.is_finite() && min.cmple(max).all();
        // An axis of one probe has it in the middle, and its last place is its first.
        let (first, last) = (min + half, max - half);
        good.then_some(Self { first, last: last.max(first), counts })
    }

    /// The place of the probe (i, j, k).
    fn position(&self, index: [u32; 3]) -> Vec3 {
        let spans = Vec3::from(self.counts.map(|c| c.saturating_sub(1).max(1) as f32));
        self.first + (self.last - self.first) / spans * Vec3::from(index.map(|i| i as f32))
    }
}

/// Traces the light that arrives at each probe of a grid into nine harmonics, and counts the backs of surfaces that each sees. In parallel; the result is
/// the same on any number of threads. `progress` is told the fraction that is done, from any thread. `None` if the volume is none
/// ([`crate::ibl::ProbeGrid::from_probes`]).
pub fn light_probes(
    world: &World,
    scene: &str,
    volume: &Volume,
    settings: &ProbeSettings,
    progress: &(dyn Fn(f64) + Sync),
) -> Option<ProbeFile> {
    let total = volume.counts.iter().try_fold(1usize, |n, c| n.checked_mul(*c as usize))?;
    if total == 0 || total as u64 > crate::ibl::ProbeGrid::MOST {
        return None;
    }
    let done = AtomicUsize::new(0);
    let found: Vec<(Sh9, f32)> = (0..total)
        .into_par_iter()
        .map(|i| {
            let [nx, ny, _] = volume.counts.map(|c| c as usize);
            let index = [i % nx, i / nx % ny, i / (nx * ny)].map(|k| k as u32);
            let at = Vec3A::from(volume.position(index));
            let probe = (one(world, at, i as u32, settings), backs(world, at));
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / total as f64);
            probe
        })
        .collect();
    let (probes, backs) = found.into_iter().unzip();
    ProbeFile::new(scene.to_string(), [volume.first, volume.last], volume.counts, probes, backs)
}

/// The harmonics at one place: c = ∫ L Y dω over six faces, each sample with its own direction. A face's element ds dt has the solid angle
/// ds dt / (1 + s² + t²)^(3/2).
fn one(world: &World, at: Vec3A, number: u32, settings: &ProbeSettings) -> Sh9 {
    let samples = settings.samples.max(1).div_ceil(6 * FACE * FACE);
    let mut sum = [[0.0f64; 4]; 9];
    for face in 0..6 {
        let camera = face_camera(face, at);
        let path = PathOptions { bounces: settings.bounces, ..PathOptions::default() };
        let seed =
            settings.seed.wrapping_add((number.wrapping_mul(6) + face as u32).wrapping_mul(0x9e37_79b9));
        let rays = PixelRays::new(&camera, [FACE; 2], Filter::Box);
        let axis = rays.axis();
        let whole =
            Settings { width: FACE, height: FACE, filter: Filter::Box, seed, path, ..Settings::default() };
        let renderer = Renderer::new(world, camera, whole);
        for (y, x) in (0..FACE).flat_map(|y| (0..FACE).map(move |x| (y, x))) {
            for index in 0..samples {
                let (radiance, _) = renderer.sample(x, y, index);
                if !radiance.is_finite() {
                    continue;
                }
                let (_, d) = rays.sample([x, y], &Sampler::new(seed, x, y, index));
                let weight = f64::from(d.dot(axis)).powi(3);
                for (s, b) in sum.iter_mut().zip(basis(d.into())) {
                    (0..4).for_each(|c| s[c] += weight * f64::from(b * radiance[c]));
                }
            }
        }
    }
    // A face is 2 × 2 wide.
    let scale = 4.0 / f64::from(FACE * FACE * samples);
    Sh9(sum.map(|c| Spectrum(c.map(|v| (v * scale) as f32))))
}
