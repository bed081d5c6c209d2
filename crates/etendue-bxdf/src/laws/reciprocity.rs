//! Helmholtz reciprocity: light that travels a path backwards is scattered as much.

use super::Rng;
use crate::{bsdf::Bsdf, sampling::uniform_hemisphere};
use glam::Vec3A;

/// The largest |f(a, b) − f(b, a)| relative to the larger of the two, over `pairs` pairs and all lanes, and the pair.
///
/// Half the pairs are even over the hemisphere; half are a direction and a sample from it, which is where tight lobes are.
pub fn reciprocity<B: Bsdf + ?Sized>(bsdf: &B, pairs: usize, seed: u64) -> (f64, [Vec3A; 2]) {
    let mut rng = Rng::new(seed);
    let mut worst = (0.0, [Vec3A::Z; 2]);
    for i in 0..pairs {
        let a = uniform_hemisphere(rng.square());
        let b = if i % 2 == 0 {
            uniform_hemisphere(rng.square())
        } else {
            match bsdf.sample(a, rng.uniform(), rng.square()) {
                Some(s) if !s.delta => s.wi,
                _ => continue,
            }
        };
        let (f, g) = (bsdf.eval(a, b), bsdf.eval(b, a));
        for lane in 0..4 {
            let (f, g) = (f[lane] as f64, g[lane] as f64);
            let larger = f.abs().max(g.abs());
            let error = if larger > 0.0 { (f - g).abs() / larger } else { 0.0 };
            // Not a number counts as the worst.
            if !(error <= worst.0) {
                worst = (error, [a, b]);
            }
        }
    }
    worst
}
