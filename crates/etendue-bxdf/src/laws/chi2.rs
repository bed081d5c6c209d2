//! `sample` draws from `pdf`: Pearson's χ² test of drawn directions against the integrated density.
//!
//! The expected counts are quadrature of `pdf` ([`Expected`]); perfectly specular directions and rejected samples are
//! bins of their own.

use super::{
    Rng,
    expected::{Expected, LEAST_EXPECTED},
    gamma::chi2_p_value,
};
use crate::bsdf::Bsdf;
use glam::Vec3A;

/// What the test found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chi2 {
    /// Σ (observed − expected)² / expected over the pooled bins.
    pub statistic: f64,
    /// Pooled bins less one.
    pub dof: usize,
    /// Probability of a statistic at least as large if `sample` draws from `pdf`.
    pub p: f64,
    /// ∫ pdf over all directions as summed over the bins.
    pub pdf_integral: f64,
}

/// Draws `samples` directions and tests them.
pub fn chi2<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A, samples: usize, seed: u64) -> Chi2 {
    chi2_against(&Expected::new(bsdf, wo, samples), bsdf, wo, samples, seed)
}

/// [`chi2`] with expected counts that are there already.
pub fn chi2_against<B: Bsdf + ?Sized>(
    expected: &Expected,
    bsdf: &B,
    wo: Vec3A,
    samples: usize,
    seed: u64,
) -> Chi2 {
    // Observed: the bins of each side, then a bin for rejected samples, then one for each perfectly specular part. A
    // direction through a surface that lets nothing pass is counted as rejected.
    let cells = expected.bins.len();
    let deltas = bsdf.deltas(wo);
    let mut observed = vec![0u64; cells + 3];
    let mut rng = Rng::new(seed);
    for _ in 0..samples {
        let bin = match bsdf.sample(wo, rng.uniform(), rng.square()) {
            None => cells,
            Some(s) if s.delta => {
                // A perfectly specular direction that the closure does not declare is counted as rejected.
                let near =
                    |d: &Option<crate::bsdf::DeltaPart>| d.is_some_and(|d| (d.wi - s.wi).length() < 1e-4);
                deltas.iter().position(near).map_or(cells, |i| cells + 1 + i)
            }
            Some(s) => {
                let dithered = core::array::from_fn(|i| dither(s.wi[i], rng.uniform()));
                expected.bin(dithered.into()).unwrap_or(cells)
            }
        };
        observed[bin] += 1;
    }

    let n = samples as f64;
    let pdf_integral = expected.pdf_integral;
    let discrete = deltas.map(|d| d.map_or(0.0, |d| d.probability as f64));
    let rejected = n * (1.0 - pdf_integral - discrete[0] - discrete[1]).max(0.0) + n * expected.gap;
    let counts: Vec<f64> =
        expected.bins.iter().map(|p| n * p).chain([rejected]).chain(discrete.map(|p| n * p)).collect();
    let (statistic, dof) = pearson(&observed, &counts);
    Chi2 { statistic, dof, p: chi2_p_value(statistic, dof), pdf_integral }
}

/// A real number that rounds to `v`: `u` in 0..1 says which.
///
/// At α = 1e-4 and grazing angles a lobe is only some fifty `f32` values wide, and a bin a few: without this the test
/// would see the raster of the numbers.
fn dither(v: f32, u: f32) -> f64 {
    let step = v.next_up() as f64 - v as f64;
    v as f64 + step * (u as f64 - 0.5)
}

/// Pearson's statistic over bins pooled, least expected first, until each pool expects [`LEAST_EXPECTED`]; and the degrees of freedom.
fn pearson(observed: &[u64], expected: &[f64]) -> (f64, usize) {
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let (mut statistic, mut pools) = (0.0, 0usize);
    let (mut pool_observed, mut pool_expected) = (0.0, 0.0);
    for i in order {
        pool_observed += observed[i] as f64;
        pool_expected += expected[i];
        if pool_expected >= LEAST_EXPECTED {
            let difference: f64 = pool_observed - pool_expected;
            statistic += difference * difference / pool_expected;
            pools += 1;
            (pool_observed, pool_expected) = (0.0, 0.0);
        }
    }
    // What is left expects too little to be a pool: it only speaks if something was seen where nothing could be.
    if pool_observed > 0.0 && pools == 0 {
        statistic = f64::INFINITY;
    }
    (statistic, pools.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pearson_pools_small_bins() {
        // Three bins of 2 become one of 6; 100 and 50 stand alone.
        let (statistic, dof) = pearson(&[110, 3, 40, 0, 4], &[100.0, 2.0, 50.0, 2.0, 2.0]);
        assert!((statistic - (1.0 + 2.0 + 1.0 / 6.0)).abs() < 1e-12);
        assert_eq!(dof, 2);
    }
}
