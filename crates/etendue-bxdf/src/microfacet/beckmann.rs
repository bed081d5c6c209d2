//! Beckmann's distribution: normally distributed slopes.

use super::{Distribution, normalized};
use crate::{
    ggx::ALPHA_DELTA,
    math::{erf, erf_inv, erfcx, exp, ln, sin_cos_tau},
};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec3A, vec3a};

/// 1 / √π.
const INV_ROOT_PI: f32 = 0.564_189_6;

/// D(m) = exp(−(mx²/αx² + my²/αy²) / mz²) / (π αx αy mz⁴) (Beckmann, Spizzichino 1963; Heitz 2014, appendix A).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    ax: f32,
    ay: f32,
}

impl Beckmann {
    /// Widths along x and y, clamped to [`ALPHA_DELTA`]..1; NaN becomes the lower end. α is √2 times the deviation of the
    /// slopes.
    #[inline(always)]
    pub fn new(alpha_x: f32, alpha_y: f32) -> Self {
        let clamped = |a: f32| a.max(ALPHA_DELTA).min(1.0);
        Self { ax: clamped(alpha_x), ay: clamped(alpha_y) }
    }
}

/// Λ as a function of a = 1 / (α tan θ): (exp(−a²) / (a√π) − erfc a) / 2 (Heitz 2014, eq. 66), exact to rounding.
#[inline(always)]
pub(super) fn lambda(a: f32) -> f32 {
    if !(a < 9.0) {
        // Below 1e-36: also taken by the infinity of the normal itself.
        return 0.0;
    }
    (0.5 * exp(-a * a) * (INV_ROOT_PI / a - erfcx(a))).max(0.0)
}

impl Distribution for Beckmann {
    #[inline]
    fn d(&self, h: Vec3A) -> f32 {
        if !(h.z > 0.0) {
            return 0.0;
        }
        let inv = 1.0 / h.z;
        let (x, y) = (h.x * inv / self.ax, h.y * inv / self.ay);
        let s2 = x * x + y * y;
        // Beyond, the exponential is below what the fourth power of a cosine of 1e-6 could lift into sight.
        if !(s2 < 80.0) {
            return 0.0;
        }
        let sec2 = h.length_squared() * inv * inv;
        exp(-s2) * sec2 * sec2 * FRAC_1_PI / (self.ax * self.ay)
    }

    #[inline]
    fn lambda(&self, w: Vec3A) -> f32 {
        let (x, y) = (self.ax * w.x, self.ay * w.y);
        lambda(w.z.abs() / (x * x + y * y).sqrt())
    }

    /// Slopes are √(−ln(1 − u)) α (Walter et al. 2007, eq. 28).
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec3A {
        let r = (-ln((1.0 - u[1]).max(1e-9).min(1.0))).max(0.0).sqrt();
        let (s, c) = sin_cos_tau(u[0]);
        normalized(vec3a(self.ax * r * c, self.ay * r * s, 1.0))
    }

    /// The distribution of the visible slopes along `wo` inverted by Newton's method in the error function, the slopes across
    /// directly (Jakob 2014, "An Improved Visible Normal Sampling Routine for the Beckmann Distribution"). The starting point
    /// is plain bisection's: no fit is needed where the derivative is known.
    #[inline]
    fn sample_visible(&self, wo: Vec3A, _uc: f32, u: [f32; 2]) -> Vec3A {
        let (x, y) = (self.ax * wo.x, self.ay * wo.y);
        let sin = (x * x + y * y).sqrt();
        // Seen from the normal no azimuth counts.
        let (cos_phi, sin_phi) = if sin > 0.0 { (x / sin, y / sin) } else { (1.0, 0.0) };
        let tan = sin / wo.z;
        let along = visible_slope(tan, u[0].max(0.0).min(1.0));
        let across = erf_inv(2.0 * u[1].max(0.0).min(1.0) - 1.0);
        let slope_x = cos_phi * along - sin_phi * across;
        let slope_y = sin_phi * along + cos_phi * across;
        normalized(vec3a(-self.ax * slope_x, -self.ay * slope_y, 1.0))
    }

    #[inline]
    fn visible_g1(&self, wo: Vec3A, _h: Vec3A) -> f32 {
        1.0 / (1.0 + self.lambda(wo))
    }

    #[inline]
    fn alpha(&self) -> [f32; 2] {
        [self.ax, self.ay]
    }
}

/// The slope x, density ∝ exp(−x²) (1 − x tan θ)⁺, whose distribution function is `u`.
///
/// The function is N (1 + b + tan θ exp(−x²) / √π) with b = erf x (Jakob 2014), to b's derivative N (1 − x tan θ).
#[inline]
fn visible_slope(tan: f32, u: f32) -> f32 {
    let cot = 1.0 / tan;
    let (mut low, mut high) = (-1.0f32, erf(cot.min(10.0)));
    let tail = |x: f32| tan * INV_ROOT_PI * exp(-x * x);
    let inv = 1.0 + high + if cot < 9.0 { tail(cot) } else { 0.0 };
    let goal = u * inv;
    let mut b = 0.5 * (low + high);
    for _ in 0..24 {
        let x = erf_inv(b);
        let error = 1.0 + b + tail(x) - goal;
        if error.abs() <= 4e-7 * inv {
            break;
        }
        if error > 0.0 {
            high = b
        } else {
            low = b
        }
        let next = b - error / (1.0 - x * tan);
        // Also taken where the derivative vanishes, at the end of the visible slopes.
        b = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    erf_inv(b).min(cot)
}
