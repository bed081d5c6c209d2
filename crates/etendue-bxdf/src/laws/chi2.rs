//! `sample` draws from `pdf`: Pearson's χ² test of drawn directions against the integrated density.
//!
//! Bins lie in the coordinates of [`HemisphereMap`], stretched half vectors or their like for refraction, so that they
//! fit a lobe of any width; those of the far side are there if [`Bsdf::refraction`] says that light passes. The expected
//! counts are quadrature of `pdf`; perfectly specular directions and rejected samples are bins of their own.

use super::{Rng, gamma::chi2_p_value};
use crate::{bsdf::Bsdf, quadrature::HemisphereMap};
use core::f64::consts::{FRAC_PI_2, TAU};
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

/// Bins in ψ.
const PSI_BINS: usize = 16;
/// Bins by quantiles of the slope distribution of the narrowest lobe.
const LOBE_BINS: usize = 14;
/// Further rings, evenly in the half vector's angle, for lobes that are wider.
const WIDE_BINS: usize = 8;
/// Bins whose expected count is below this are pooled.
const LEAST_EXPECTED: f64 = 5.0;

/// Draws `samples` directions and tests them.
pub fn chi2<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A, samples: usize, seed: u64) -> Chi2 {
    let alpha = bsdf.narrowest_alpha();
    let edges = s_edges(alpha);
    let rings = edges.len() - 1;
    let sides = [Some(HemisphereMap::upper(bsdf, wo)), HemisphereMap::lower(bsdf, wo)];
    let sides: Vec<HemisphereMap> = sides.into_iter().flatten().collect();
    let cells = sides.len() * rings * PSI_BINS;

    // Observed: the bins of each side, then a bin for rejected samples, then one for each perfectly specular part. A
    // direction through a surface that lets nothing pass is counted as rejected.
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
                let side = usize::from(s.wi.z < 0.0);
                sides.get(side).map_or(cells, |map| {
                    let (r, psi) = map.coordinates_exact(dithered.into());
                    let ring = edges.partition_point(|&e| e <= r).clamp(1, rings) - 1;
                    let sector = ((psi / TAU * PSI_BINS as f64) as usize).min(PSI_BINS - 1);
                    (side * rings + ring) * PSI_BINS + sector
                })
            }
        };
        observed[bin] += 1;
    }

    let n = samples as f64;
    let mut expected = Vec::with_capacity(cells + 3);
    for map in &sides {
        for ring in 0..rings {
            for sector in 0..PSI_BINS {
                let psi = |i: usize| i as f64 / PSI_BINS as f64 * TAU;
                // What the lower order lacks is a part of the count's own spread; the higher one lacks far less.
                let tolerance = |mass: f64| 0.3 * (n * mass).max(LEAST_EXPECTED).sqrt() / n;
                let mass = map.integrate_within(
                    (edges[ring], edges[ring + 1]),
                    (psi(sector), psi(sector + 1)),
                    tolerance,
                    |wi| [bsdf.pdf(wo, wi), 0.0, 0.0, 0.0],
                );
                expected.push(n * mass[0]);
            }
        }
    }
    let pdf_integral = expected.iter().sum::<f64>() / n;
    let discrete = deltas.map(|d| d.map_or(0.0, |d| d.probability as f64));
    expected.push(n * (1.0 - pdf_integral - discrete[0] - discrete[1]).max(0.0));
    expected.extend(discrete.map(|p| n * p));

    let (statistic, dof) = pearson(&observed, &expected);
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

/// Radial edges: quantiles of the narrowest lobe's slopes, then even steps of the half vector's angle.
fn s_edges(alpha: [f32; 2]) -> Vec<f64> {
    let a = (alpha[0] as f64 * alpha[1] as f64).sqrt();
    // Slopes of GGX have the distribution function s² / (1 + s²).
    let lobe = (0..LOBE_BINS).map(|i| {
        let u = i as f64 / LOBE_BINS as f64;
        (u / (1.0 - u)).sqrt()
    });
    let mut edges: Vec<f64> = lobe.collect();
    let last = edges[LOBE_BINS - 1];
    edges.extend(
        (1..WIDE_BINS)
            .map(|i| (i as f64 / WIDE_BINS as f64 * FRAC_PI_2).tan() / a)
            .filter(|&s| s > 1.2 * last),
    );
    edges.push(f64::INFINITY);
    edges
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
