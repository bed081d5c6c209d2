//! Blinn's distribution: a power of the cosine.

use super::{Distribution, beckmann, v_cavity_g1, v_cavity_side};
use crate::{
    ggx::ALPHA_DELTA,
    math::{exp, ln, ln_1p, one_minus_exp_neg, sin_cos_tau},
};
use glam::{Vec3A, vec3a};

/// D(m) = (n + 2) / 2π · cosⁿθ (Blinn 1977; normalised as in Walter et al. 2007, eq. 30).
///
/// Smith's Λ is Beckmann's with α = √(2 / (n + 2)), which Walter et al. (section 5.2) recommend, the integral having no
/// closed form: the two distributions approach each other for large n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlinnPhong {
    exponent: f32,
    alpha: f32,
}

impl BlinnPhong {
    /// From the α of the Beckmann distribution that is most alike, n = 2/α² − 2; α clamped to [`ALPHA_DELTA`]..0.9999, NaN to the
    /// lower end.
    #[inline(always)]
    pub fn new(alpha: f32) -> Self {
        let alpha = alpha.max(ALPHA_DELTA).min(0.9999);
        Self { exponent: 2.0 * (1.0 - alpha) * (1.0 + alpha) / (alpha * alpha), alpha }
    }

    /// From the exponent n > 0.
    #[inline(always)]
    pub fn from_exponent(n: f32) -> Self {
        Self::new((2.0 / (n.max(0.0) + 2.0)).sqrt())
    }

    /// The exponent n.
    #[inline(always)]
    pub fn exponent(&self) -> f32 {
        self.exponent
    }
}

impl Distribution for BlinnPhong {
    #[inline]
    fn d(&self, h: Vec3A) -> f32 {
        if !(h.z > 0.0) {
            return 0.0;
        }
        let sin2 = ((h.x * h.x + h.y * h.y) / h.length_squared()).min(1.0);
        (self.exponent + 2.0) / core::f32::consts::TAU * exp(0.5 * self.exponent * ln_1p(-sin2))
    }

    #[inline]
    fn lambda(&self, w: Vec3A) -> f32 {
        beckmann::lambda(w.z.abs() / (self.alpha * (w.x * w.x + w.y * w.y).sqrt()))
    }

    /// cos θ = (1 − u)^{1/(n+2)}.
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec3A {
        let x = -ln((1.0 - u[1]).max(1e-9).min(1.0)) / (self.exponent + 2.0);
        let sin = one_minus_exp_neg(2.0 * x).max(0.0).sqrt();
        let (s, c) = sin_cos_tau(u[0]);
        vec3a(sin * c, sin * s, exp(-x))
    }

    #[inline]
    fn sample_visible(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        v_cavity_side(wo, self.sample(u), uc)
    }

    #[inline]
    fn visible_g1(&self, wo: Vec3A, h: Vec3A) -> f32 {
        v_cavity_g1(wo, h)
    }

    #[inline]
    fn alpha(&self) -> [f32; 2] {
        [self.alpha, self.alpha]
    }
}
