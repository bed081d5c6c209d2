//! The white furnace: under even light from both sides a surface must not give back more than arrives.
//!
//! This is a law of energy, and radiance is not energy: light that enters a medium of relative index η is compressed
//! into a narrower cone and has η² times the radiance there, so a window to a denser world looks brighter than the
//! window of the dense world to a thin one. The closure must therefore be made for
//! [`crate::model::Transport::Importance`], in which what passes is counted as power: a lossless interface gives back
//! exactly 1 from either side. (In radiance mode its transmitted part is 1/η² of that.) Where both sides have the same
//! index, or nothing passes, the two modes are the same.

use super::Rng;
use crate::{bsdf::Bsdf, quadrature::directional_albedo};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What the furnace showed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Furnace {
    /// Directional albedo, reflection and transmission, by quadrature.
    pub albedo: Spectrum,
    /// Directional albedo as the mean weight of samples.
    pub sampled: Spectrum,
    /// Standard error of `sampled`, by lane.
    pub error: Spectrum,
    /// Variance of one sample's weight, by lane: what a path's throughput suffers from this sampling.
    pub variance: Spectrum,
    /// Largest |sampled − albedo| over lanes, in standard errors (with 2e-5 let in for the
    /// quadrature, and 3 / samples for events too rare to show in the variance).
    pub z: f64,
    /// What [`Bsdf::albedo`] says.
    pub claimed: Spectrum,
}

/// Puts a closure into the furnace, seen from `wo`, with `samples` samples.
pub fn furnace<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A, samples: usize, seed: u64) -> Furnace {
    furnace_against(directional_albedo(bsdf, wo), bsdf, wo, samples, seed)
}

/// [`furnace`] with an albedo by quadrature that is there already.
pub fn furnace_against<B: Bsdf + ?Sized>(
    albedo: Spectrum,
    bsdf: &B,
    wo: Vec3A,
    samples: usize,
    seed: u64,
) -> Furnace {
    let mut rng = Rng::new(seed);
    // Differences from the expected mean keep the sums of squares exact enough.
    let (mut first, mut second) = ([0.0f64; 4], [0.0f64; 4]);
    for _ in 0..samples {
        let weight = bsdf.sample(wo, rng.uniform(), rng.square()).map_or(Spectrum::ZERO, |s| s.weight);
        for lane in 0..4 {
            let d = (weight[lane] - albedo[lane]) as f64;
            first[lane] += d;
            second[lane] += d * d;
        }
    }
    let n = samples.max(1) as f64;
    let mean = first.map(|v| v / n);
    let variance: [f64; 4] = core::array::from_fn(|i| (second[i] / n - mean[i] * mean[i]).max(0.0));
    let error = variance.map(|v| (v / n).sqrt());
    let z = (0..4).map(|i| mean[i].abs() / (error[i] + 2e-5 + 3.0 / n)).fold(0.0, f64::max);
    Furnace {
        albedo,
        sampled: albedo + Spectrum(mean.map(|v| v as f32)),
        error: Spectrum(error.map(|v| v as f32)),
        variance: Spectrum(variance.map(|v| v as f32)),
        z,
        claimed: bsdf.albedo(wo),
    }
}
