//! Reflection probes: six pictures of 90°.

use super::{ProbeSettings, face_camera};
use crate::color::Spectrum;
use crate::ibl::CubeMap;
use crate::render::{Counters, Filter, PathOptions, Renderer, Settings, World};
use glam::Vec3A;

/// Samples after which progress is told.
const BATCH: u32 = 4;

/// The light that arrives at `at`, metres: a cube of linear Rec.709 radiance without mips, each texel the mean over its square (box filter).
/// `progress` is told the fraction that is done.
///
/// Bit for bit the same on any number of threads. [`crate::ibl::bake_cube`] makes it fit for lookups.
pub fn cube_probe(world: &World, at: Vec3A, settings: &ProbeSettings, progress: &dyn Fn(f64)) -> CubeMap {
    let size = settings.size.max(1);
    let samples = settings.samples.max(1);
    let mut texels = Vec::with_capacity(6 * size as usize * size as usize);
    for face in 0..6 {
        let path = PathOptions { bounces: settings.bounces, ..PathOptions::default() };
        // Faces would otherwise repeat each other's noise.
        let seed = settings.seed.wrapping_add((face as u32).wrapping_mul(0x9e37_79b9));
        let whole =
            Settings { width: size, height: size, filter: Filter::Box, seed, path, ..Settings::default() };
        let renderer = Renderer::new(world, face_camera(face, at), whole);
        let mut film = renderer.film();
        let counters = Counters::default();
        let mut from = 0;
        while from < samples {
            let to = (from + BATCH).min(samples);
            renderer.render(&mut film, from, to, &counters);
            progress((face as f64 + f64::from(to) / f64::from(samples)) / 6.0);
            from = to;
        }
        texels.extend(film.beauty().iter().map(|[r, g, b, _]| Spectrum::rgb(*r, *g, *b)));
    }
    // There are 6 size² texels by construction.
    CubeMap::new(size, texels).unwrap_or_else(|| CubeMap::from_fn(1, |_| Spectrum::ZERO))
}
