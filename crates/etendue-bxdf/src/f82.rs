//! A metal's Fresnel curve from two colours: at normal incidence, and near the dip at 82°.

use crate::fresnel::{pow5, schlick_weight};
use etendue_color::Spectrum;

/// The cosine at which the second colour stands: 1/7, an angle of 81.79°.
pub const F82_COS: f32 = 1.0 / 7.0;

/// Schlick's curve less a dip whose depth is chosen by the reflectance at cos θ = 1/7 (Hoffman 2019, "Fresnel Equations
/// Considered Harmful"; Kutz, Hašan, Edmondson 2021, "Novel aspects of the Adobe Standard Material", eq. 1; OpenPBR 1.1,
/// "Metal"):
///
/// ```text
/// F(μ) = S(μ) − b μ (1 − μ)⁶,   S(μ) = F0 + (1 − F0)(1 − μ)⁵,   b = (S(1/7) − F82) / (1/7 · (6/7)⁶)
/// ```
///
/// Clamped to 0..1: only a dark F0 with a far darker F82, which no metal has, reaches the clamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct F82Tint {
    f0: Spectrum,
    b: Spectrum,
}

/// S(1/7)'s weight of F90, (6/7)⁵.
const SCHLICK_82: f32 = 7776.0 / 16807.0;
/// 1 / (1/7 · (6/7)⁶).
const INV_BUMP_82: f32 = 823543.0 / 46656.0;

impl F82Tint {
    /// From the reflectance at normal incidence and a factor on Schlick's curve at 82° (OpenPBR's `specular_color`); both
    /// clamped to 0..1, NaN to 0. A tint of one is Schlick's curve.
    #[inline(always)]
    pub fn from_tint(f0: Spectrum, tint: Spectrum) -> Self {
        let f0 = f0.map(|v| v.max(0.0).min(1.0));
        let tint = tint.map(|v| v.max(0.0).min(1.0));
        let schlick = f0.lerp(Spectrum::ONE, SCHLICK_82);
        Self { f0, b: schlick * (Spectrum::ONE - tint) * INV_BUMP_82 }
    }

    /// From the reflectances at normal incidence and at cos θ = 1/7; both clamped to 0..1, NaN to 0.
    #[inline(always)]
    pub fn from_f82(f0: Spectrum, f82: Spectrum) -> Self {
        let f0 = f0.map(|v| v.max(0.0).min(1.0));
        let f82 = f82.map(|v| v.max(0.0).min(1.0));
        let schlick = f0.lerp(Spectrum::ONE, SCHLICK_82);
        Self { f0, b: (schlick - f82) * INV_BUMP_82 }
    }

    /// The reflectance at normal incidence.
    #[inline(always)]
    pub fn f0(&self) -> Spectrum {
        self.f0
    }

    /// The reflectance at an angle of cosine `cos`, clamped to 0..1.
    #[inline(always)]
    pub fn eval(&self, cos: f32) -> Spectrum {
        let c = cos.max(0.0).min(1.0);
        let bump = c * (1.0 - c) * pow5(1.0 - c);
        let f = self.f0.lerp(Spectrum::ONE, schlick_weight(c)) - self.b * bump;
        f.max(Spectrum::ZERO).min(Spectrum::ONE)
    }

    /// 2 ∫ F(μ) μ dμ = F0 + (1 − F0)/21 − b/126; exact where [`F82Tint::eval`] does not clamp.
    #[inline(always)]
    pub fn average(&self) -> Spectrum {
        let f = self.f0.lerp(Spectrum::ONE, 1.0 / 21.0) - self.b * (1.0 / 126.0);
        f.max(Spectrum::ZERO).min(Spectrum::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::Schlick;

    #[test]
    fn passes_through_its_three_points() {
        let (f0, f82) = (Spectrum([1.0, 0.7, 0.3, 0.04]), Spectrum([0.8, 0.75, 0.5, 0.4]));
        let f = F82Tint::from_f82(f0, f82);
        assert!((f.eval(1.0) - f0).map(f32::abs).max_element() < 1e-6);
        assert!((f.eval(F82_COS) - f82).map(f32::abs).max_element() < 1e-5);
        assert_eq!(f.eval(0.0), Spectrum::ONE);
        let schlick = Schlick { f0, f90: Spectrum::ONE };
        let tint = Spectrum([0.9, 0.5, 0.0, 1.0]);
        let t = F82Tint::from_tint(f0, tint);
        assert!((t.eval(F82_COS) - schlick.eval(F82_COS) * tint).map(f32::abs).max_element() < 1e-5);
        // A tint of one leaves Schlick's curve.
        for i in 0..=50 {
            let c = i as f32 / 50.0;
            assert!((F82Tint::from_tint(f0, Spectrum::ONE).eval(c) - schlick.eval(c)).is_black());
        }
    }

    #[test]
    fn stays_within_bounds_for_any_input() {
        for f0 in [f32::NAN, -1.0, 0.0, 0.5, 1.0, 7.0] {
            for f82 in [f32::NAN, -1.0, 0.0, 0.5, 1.0, f32::INFINITY] {
                let (a, b) = (Spectrum::splat(f0), Spectrum::splat(f82));
                for f in [F82Tint::from_tint(a, b), F82Tint::from_f82(a, b)] {
                    for c in [f32::NAN, -1.0, 0.0, 0.1, 0.5, 1.0, 2.0] {
                        let v = f.eval(c)[0];
                        assert!((0.0..=1.0).contains(&v), "{f0} {f82} {c}: {v}");
                    }
                    assert!((0.0..=1.0).contains(&f.average()[0]));
                }
            }
        }
    }
}
