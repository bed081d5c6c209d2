//! How a fibre spreads light along itself: the lobe Mp.

use crate::math::{bessel_i0_scaled, exp, ln, sin_cos_tau};

/// Mp of one variance v (d'Eon, Francois, Hill, Letteri, Aubry 2011, "An Energy-Conserving Hair Reflectance Model", eq. 7):
///
/// ```text
/// Mp(θi, θo) = e^{−sinθi sinθo / v} I0(cosθi cosθo / v) / (2v sinh(1/v)),   ∫ Mp cosθi dθi = 1
/// ```
///
/// written as e^{−(1 − cos(θi + θo))/v} · e^{−a} I0(a) / (v (1 − e^{−2/v})) with a = cosθi cosθo / v: no factor of it leaves
/// `f32`, and narrow lobes keep their digits, because 1 − cos is taken from the sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Longitudinal {
    inv_v: f32,
    v: f32,
    /// e^{−2/v}.
    tail: f32,
    /// 1 / (v (1 − e^{−2/v})).
    scale: f32,
}

/// Sine and cosine of an angle to the fibre's normal plane; the cosine is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inclination {
    pub sin: f32,
    pub cos: f32,
}

impl Inclination {
    /// Turned by an angle, given by its sine and cosine, and folded back over the pole.
    #[inline(always)]
    pub fn turned(self, [sin, cos]: [f32; 2]) -> Self {
        Self { sin: self.sin * cos + self.cos * sin, cos: (self.cos * cos - self.sin * sin).abs() }
    }
}

impl Longitudinal {
    /// Of a variance v > 0.
    pub fn new(v: f32) -> Self {
        let tail = exp(-2.0 / v);
        Self { inv_v: 1.0 / v, v, tail, scale: 1.0 / (v * (1.0 - tail)) }
    }

    /// v.
    pub fn variance(&self) -> f32 {
        self.v
    }

    /// Mp, per steradian of a band: density of θi with respect to cosθi dθi.
    #[inline(always)]
    pub fn eval(&self, i: Inclination, o: Inclination) -> f32 {
        let cos = i.cos * o.cos - i.sin * o.sin;
        let sin = i.sin * o.cos + i.cos * o.sin;
        let one_minus_cos = if cos > 0.0 { sin * sin / (1.0 + cos) } else { 1.0 - cos };
        exp(-one_minus_cos * self.inv_v) * bessel_i0_scaled(i.cos * o.cos * self.inv_v) * self.scale
    }

    /// θi drawn from Mp (d'Eon, Marschner, Hanika 2013, "Importance Sampling for Physically-Based Hair Fiber Models", section
    /// 4): a spherical Gaussian around the direction −θo.
    #[inline(always)]
    pub fn sample(&self, o: Inclination, u: [f32; 2]) -> Inclination {
        let t = u[0].max(1e-12).min(1.0);
        // 1 − cos of the angle to the lobe's axis.
        let d = (-self.v * ln(t + (1.0 - t) * self.tail)).max(0.0).min(2.0);
        let (_, cos_phi) = sin_cos_tau(u[1]);
        let across = (d * (2.0 - d)).max(0.0).sqrt() * cos_phi;
        let sin = ((d - 1.0) * o.sin + across * o.cos).max(-1.0).min(1.0);
        Inclination { sin, cos: ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt() }
    }
}
