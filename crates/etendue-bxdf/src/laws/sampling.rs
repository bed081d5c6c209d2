//! Each sample is what `eval` and `pdf` say of it, and `pdf` integrates to what `sample` returns.

use super::{Rng, gamma::upper_regularised};
use crate::{bsdf::Bsdf, quadrature::pdf_integral};
use glam::Vec3A;

/// What was measured over many samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Samples {
    /// Largest |weight − eval · cos / pdf| relative to the weight.
    pub weight_error: f64,
    /// Largest |sample's pdf − pdf(wo, wi)| relative to the larger.
    pub pdf_error: f64,
    /// Largest |weight − (weight_diffuse + weight_specular)|.
    pub split_error: f64,
    /// Largest | |wi| − 1 |.
    pub length_error: f64,
    /// Largest lane of a weight.
    pub largest_weight: f64,
    /// True if anything was not finite or negative, or lay on a side to which the surface lets nothing pass.
    pub broken: bool,
    /// Part of the samples that are neither `None` nor perfectly specular.
    pub continuous: f64,
    /// ∫ pdf, which `continuous` estimates.
    pub pdf_integral: f64,
    /// Standard deviations between the two.
    pub z: f64,
    /// Probability of a difference at least as large, by Poisson's distribution where few samples are on one side.
    pub p: f64,
}

/// Draws `samples` directions and compares each with `eval` and `pdf`.
pub fn samples<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A, samples: usize, seed: u64) -> Samples {
    samples_against(pdf_integral(bsdf, wo), bsdf, wo, samples, seed)
}

/// [`samples`] with a ∫ pdf that is there already.
pub fn samples_against<B: Bsdf + ?Sized>(
    pdf_integral: f64,
    bsdf: &B,
    wo: Vec3A,
    samples: usize,
    seed: u64,
) -> Samples {
    let mut out = Samples::default();
    let mut rng = Rng::new(seed);
    let mut continuous = 0usize;
    let passes = bsdf.refraction().is_some();
    for _ in 0..samples {
        let Some(s) = bsdf.sample(wo, rng.uniform(), rng.square()) else { continue };
        out.broken |= !s.weight.is_finite() || s.weight.0.iter().any(|&v| v < 0.0) || !(s.pdf > 0.0);
        out.broken |= !s.pdf.is_finite() || !(s.wi.z > 0.0 || (passes && s.wi.z < 0.0));
        out.length_error = out.length_error.max((s.wi.as_dvec3().length() - 1.0).abs());
        out.largest_weight = out.largest_weight.max(s.weight.max_element() as f64);
        let split = s.weight - (s.weight_diffuse + s.weight_specular);
        out.split_error = out.split_error.max(split.map(f32::abs).max_element() as f64);
        if s.delta {
            continue;
        }
        continuous += 1;
        let e = bsdf.eval_pdf(wo, s.wi);
        out.pdf_error = out.pdf_error.max(relative(s.pdf, e.pdf));
        let value = e.value();
        for lane in 0..4 {
            out.weight_error =
                out.weight_error.max(relative(s.weight[lane], value[lane] * s.wi.z.abs() / e.pdf));
        }
    }
    let n = samples.max(1) as f64;
    out.continuous = continuous as f64 / n;
    out.pdf_integral = pdf_integral;
    let p = out.pdf_integral.clamp(0.0, 1.0);
    // The quadrature's own error is let in as 1e-5.
    let sigma = (p * (1.0 - p) / n).sqrt() + 1e-5;
    out.z = (out.continuous - out.pdf_integral).abs() / sigma;
    let rare = (n * p.min(1.0 - p), n * if p < 0.5 { out.continuous } else { 1.0 - out.continuous });
    out.p = if rare.0 < 0.01 * n {
        poisson_p(rare.1.round(), rare.0, 1e-5 * n)
    } else {
        upper_regularised(0.5, 0.5 * out.z * out.z)
    };
    out
}

/// Two-sided p-value of `k` events where `expected` ± `slack` were expected.
fn poisson_p(k: f64, expected: f64, slack: f64) -> f64 {
    // P(X ≥ k) = 1 − Q(k, λ), P(X ≤ k) = Q(k + 1, λ) (Abramowitz, Stegun 26.4.21).
    let many = if k > 0.0 { 1.0 - upper_regularised(k, expected + slack) } else { 1.0 };
    let few = upper_regularised(k + 1.0, (expected - slack).max(0.0));
    (2.0 * many.min(few)).min(1.0)
}

/// Numbers below this have lost digits on the way, or have come from some that have: near f32's least normal number.
const FEW_DIGITS: f64 = 1e-34;

/// |a − b| relative to the larger, or to [`FEW_DIGITS`] where both are smaller.
fn relative(a: f32, b: f32) -> f64 {
    ((a as f64) - (b as f64)).abs() / (a.abs().max(b.abs()) as f64).max(FEW_DIGITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rare_events_are_judged_by_poisson() {
        // e⁻² and 1 − e⁻²(1 + 2 + 2): no event, and three or more, of two expected.
        assert!((poisson_p(0.0, 2.0, 0.0) - 2.0 * 0.135_335).abs() < 1e-5);
        assert!((poisson_p(3.0, 2.0, 0.0) - 2.0 * 0.323_324).abs() < 1e-5);
        assert!(poisson_p(30.0, 2.0, 0.0) < 1e-12 && poisson_p(30.0, 2.0, 30.0) == 1.0);
    }
}
