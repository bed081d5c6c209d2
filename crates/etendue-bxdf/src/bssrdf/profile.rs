//! Normalized diffusion, one lane: how far light travels under a surface.
//!
//! ```text
//! R(r) = A (e^{−r/d} + e^{−r/3d}) / (8π d r),   d = ℓ / s(A)
//! ```
//!
//! Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering"; Christensen, Burley 2015,
//! "Approximate Reflectance Profiles for Efficient Subsurface Scattering" (Pixar Technical Memo 15-04), with A the surface's
//! albedo, ℓ the mean free path and s a fit to Monte Carlo references. ∫ R 2πr dr = A for each d.
//!
//! The functions below are of x = r/d, and of A = 1. **Departure:** the profile is cut at x = [`CUT`] and what is left
//! scaled up, so that a probe has a bounded length and nothing is lost: 2.5e-4 of the light moves inwards.

use crate::math::{exp, exp2, ln, ln_1p};
use core::f32::consts::TAU;

/// Radius, in units of d, at which the profile ends.
pub const CUT: f32 = 24.0;
/// The uncut profile's light within [`CUT`]: 1 − ¼e⁻²⁴ − ¾e⁻⁸.
const WITHIN: f32 = 0.999_748_4;

/// s(A) for light that enters perpendicularly (the searchlight configuration): 1.85 − A + 7 |A − 0.8|³.
pub fn scaling_searchlight(a: f32) -> f32 {
    let t = (a - 0.8).abs();
    1.85 - a + 7.0 * t * t * t
}

/// s(A) for light that enters from everywhere (diffuse surface transmission): 1.9 − A + 3.5 (A − 0.8)².
pub fn scaling_diffuse(a: f32) -> f32 {
    let t = a - 0.8;
    1.9 - a + 3.5 * t * t
}

/// s(A) where ℓ is the diffuse mean free path on the surface: 3.5 + 100 (A − 0.33)⁴.
pub fn scaling_diffuse_mean_free_path(a: f32) -> f32 {
    let t = (a - 0.33) * (a - 0.33);
    3.5 + 100.0 * t * t
}

/// Part of the light within x: (1 − ¼e^{−x} − ¾e^{−x/3}) / W with W the same at the cut; 0 below 0, 1 beyond [`CUT`].
pub fn cdf(x: f32) -> f32 {
    // Also taken by NaN.
    if !(x > 0.0) {
        return 0.0;
    }
    if x >= CUT {
        return 1.0;
    }
    // 4 times the numerator is 6w − 3w² + w³ with w = 1 − e^{−x/3}: no cancellation for small x.
    let w = one_minus_exp(x * (1.0 / 3.0));
    w * (6.0 + w * (w - 3.0)) * (0.25 / WITHIN)
}

/// Density of x: (e^{−x} + e^{−x/3}) / 4W for 0 ≤ x < [`CUT`], else 0.
#[inline(always)]
pub fn radial_density(x: f32) -> f32 {
    if !(0.0..CUT).contains(&x) {
        return 0.0;
    }
    let y = exp(x * (-1.0 / 3.0));
    y * (1.0 + y * y) * (0.25 / WITHIN)
}

/// Density per area at x, in units of 1/d²: the radial density over 2πx. Infinite at x = 0.
#[inline(always)]
pub fn area_density(x: f32) -> f32 {
    radial_density(x) / (TAU * x)
}

/// The x with [`cdf`]`(x) = u`, in closed form; `u` is clamped to 0..1. The relative error of x is below 2e-6.
///
/// With y = e^{−x/3} the equation is y³ + 3y = 4(1 − uW), whose only real root is c − 1/c with c the cube root of
/// k + √(1 + k²) and k = 2(1 − uW) (Cardano). Rounding is undone by a step of Newton's method for w = 1 − y, in which
/// the equation is w³ − 3w² + 6w = 4uW: w keeps its digits for small u.
#[inline]
pub fn sample(u: f32) -> f32 {
    let u = u.max(0.0).min(1.0) * WITHIN;
    let k = 2.0 * (1.0 - u);
    let c = exp2(ln(k + (1.0 + k * k).sqrt()) * (core::f32::consts::LOG2_E / 3.0));
    let mut w = 1.0 - (c - 1.0 / c);
    for _ in 0..2 {
        let value = w * (6.0 + w * (w - 3.0)) - 4.0 * u;
        w -= value / (6.0 + w * (3.0 * w - 6.0));
    }
    (-3.0 * ln_1p(-w.max(0.0).min(1.0))).max(0.0).min(CUT)
}

/// 1 − e^{−t} for t ≥ 0 with its digits kept for small t.
fn one_minus_exp(t: f32) -> f32 {
    if t < 0.25 {
        // Taylor; the first term left out is t⁶/720 of t: 3.4e-7.
        t * (1.0 - t * (0.5 - t * (1.0 / 6.0 - t * (1.0 / 24.0 - t * (1.0 / 120.0 - t * (1.0 / 720.0))))))
    } else {
        1.0 - exp(-t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact_cdf(x: f64) -> f64 {
        let f = |x: f64| -0.25 * (-x).exp_m1() - 0.75 * (-x / 3.0).exp_m1();
        f(x) / f(CUT as f64)
    }

    #[test]
    fn cdf_is_the_integral_of_the_density_and_sampling_inverts_it() {
        let x = CUT as f64;
        let within = 1.0 - 0.25 * (-x).exp() - 0.75 * (-x / 3.0).exp();
        assert!((WITHIN as f64 - within).abs() < 6e-8);
        // The closed form is the integral of the density, by quadrature.
        let nodes = crate::quadrature::gauss_legendre(24);
        for end in [1e-3, 0.5, 3.0, 10.0, 23.9] {
            let sum: f64 =
                nodes.iter().map(|&(t, w)| w * end * radial_density((t * end) as f32) as f64).sum();
            assert!((sum - exact_cdf(end)).abs() < 1e-6, "{end}: {sum}");
            assert!((cdf(end as f32) as f64 / exact_cdf(end) - 1.0).abs() < 1e-6, "{end}");
        }
        let mut worst: f64 = 0.0;
        for i in 1..200_000 {
            let u = (i as f32 / 200_000.0).powi(4);
            let x = sample(u);
            // What an error in u of the last bit makes of x is let in.
            let slack = 1.2e-7 * u as f64 / (radial_density(x).max(1e-6) as f64 * x as f64);
            worst = worst
                .max((exact_cdf(x as f64) - u as f64).abs() / (radial_density(x) as f64 * x as f64) - slack);
        }
        println!("relative error of x {worst:.1e}");
        assert!(worst < 2e-6);
        assert_eq!((sample(0.0), cdf(0.0), cdf(1e9)), (0.0, 0.0, 1.0));
        assert!(sample(f32::NAN) == 0.0 && sample(-1.0) == 0.0 && (sample(1.0) - CUT).abs() < 0.02);
        assert_eq!((cdf(f32::NAN), radial_density(f32::NAN)), (0.0, 0.0));
    }
}
