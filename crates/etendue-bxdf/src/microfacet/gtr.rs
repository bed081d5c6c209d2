//! Trowbridge and Reitz's distribution with a free tail.

use super::{Distribution, v_cavity_g1, v_cavity_side};
use crate::{
    ggx::ALPHA_DELTA,
    math::{exp, ln, ln_1p, one_minus_exp_neg, sin_cos_tau},
};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec3A, vec3a};

/// D(m) = c / (α² cos²θ + sin²θ)^γ (Burley 2012, "Physically Based Shading at Disney", appendix B), isotropic.
///
/// γ = 2 is GGX, γ = 1 (Berry) the long-tailed coat of Disney's model; γ → ∞ with α²/γ held fixed is Beckmann's in sin θ. The
/// normalisation, in one form for every γ: with L = −ln α², φ(x) = x / (1 − e⁻ˣ), q = cos²θ + sin²θ/α²,
///
/// ```text
/// D = φ((γ − 1) L) / φ(L) / (π α² q^γ)
/// ```
///
/// which is Burley's without the singularity at γ = 1 and at α = 1.
///
/// Smith's Λ is GGX's of the same α, as Disney's model takes it for its coat; it is exact for γ = 2 only, and for
/// other γ the integral has no short closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gtr {
    alpha: f32,
    gamma: f32,
    /// −ln α².
    l: f32,
    /// 1/α² − 1.
    inv_a2_less_one: f32,
    norm: f32,
}

/// x / (1 − e⁻ˣ), 1 at 0.
#[inline(always)]
fn phi(x: f32) -> f32 {
    if x.abs() < 1e-3 { 1.0 + 0.5 * x } else { x / one_minus_exp_neg(x) }
}

impl Gtr {
    /// α clamped to 0.9999 (at 1 every direction is alike, to 1e-4) and so that [`Distribution::alpha`] is at least
    /// [`ALPHA_DELTA`]; γ to 0.1..10. NaN becomes the lower end.
    #[inline(always)]
    pub fn new(alpha: f32, gamma: f32) -> Self {
        let gamma = gamma.max(0.1).min(10.0);
        let alpha = alpha.max(ALPHA_DELTA * (0.5 * gamma).max(1.0).sqrt()).min(0.9999);
        let a2 = alpha * alpha;
        let l = -ln(a2);
        let norm = FRAC_1_PI * phi((gamma - 1.0) * l) / (phi(l) * a2);
        Self { alpha, gamma, l, inv_a2_less_one: (1.0 - alpha) * (1.0 + alpha) / a2, norm }
    }

    /// The tail's exponent γ.
    #[inline(always)]
    pub fn gamma(&self) -> f32 {
        self.gamma
    }
}

impl Distribution for Gtr {
    #[inline]
    fn d(&self, h: Vec3A) -> f32 {
        if !(h.z > 0.0) {
            return 0.0;
        }
        let sin2 = (h.x * h.x + h.y * h.y) / h.length_squared();
        self.norm * exp(-self.gamma * ln_1p(sin2 * self.inv_a2_less_one))
    }

    #[inline]
    fn lambda(&self, w: Vec3A) -> f32 {
        let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// By inversion in t = ln q: u = (1 − e^{−(γ−1)t}) / (1 − e^{−(γ−1)L}), t in 0..L (Burley 2012, appendix B, in another variable).
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec3A {
        let u1 = u[1].max(0.0).min(1.0);
        let c = self.gamma - 1.0;
        let x = c * self.l;
        let t = if x.abs() < 1e-3 {
            // The first two terms of the series in x.
            u1 * self.l * (1.0 - 0.5 * x * (1.0 - u1))
        } else {
            -ln_1p(-u1 * one_minus_exp_neg(x)) / c
        };
        let t = t.max(0.0).min(self.l);
        // sin² = α² (q − 1) / (1 − α²); cos² likewise from the other end: neither cancels.
        let rest = self.l - t;
        let all = one_minus_exp_neg(self.l);
        let sin = (exp(-rest) * one_minus_exp_neg(t) / all).max(0.0).sqrt();
        let cos = (one_minus_exp_neg(rest) / all).max(0.0).sqrt();
        let (s, co) = sin_cos_tau(u[0]);
        vec3a(sin * co, sin * s, cos)
    }

    #[inline]
    fn sample_visible(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        v_cavity_side(wo, self.sample(u), uc)
    }

    #[inline]
    fn visible_g1(&self, wo: Vec3A, h: Vec3A) -> f32 {
        v_cavity_g1(wo, h)
    }

    /// Near the normal D is as exp(−γ tan²/α²): for γ > 2 narrower than GGX of the same α.
    #[inline]
    fn alpha(&self) -> [f32; 2] {
        let a = self.alpha / (0.5 * self.gamma).max(1.0).sqrt();
        [a, a]
    }
}
