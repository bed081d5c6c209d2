//! How much of the light an interface reflects.

use etendue_color::Spectrum;

/// x⁵ by three multiplications.
#[inline(always)]
pub fn pow5(x: f32) -> f32 {
    let x2 = x * x;
    x2 * x2 * x
}

/// The weight of F90 in Schlick's approximation: (1 − cos θ)⁵, for cos θ clamped to 0..1.
#[inline(always)]
pub fn schlick_weight(cos: f32) -> f32 {
    pow5((1.0 - cos).clamp(0.0, 1.0))
}

/// Fresnel reflectance as F0 + (F90 − F0)(1 − cos θ)⁵ (Schlick 1994, eq. 15, with a free value at grazing incidence).
///
/// θ is the angle to the microfacet's normal, that is, to the half vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schlick {
    /// Reflectance at normal incidence, 0..1.
    pub f0: Spectrum,
    /// Reflectance at grazing incidence, 0..1.
    pub f90: Spectrum,
}

impl Schlick {
    /// Reflects everything at each angle.
    pub const ONE: Self = Self { f0: Spectrum::ONE, f90: Spectrum::ONE };

    /// The reflectance at an angle of cosine `cos`.
    #[inline(always)]
    pub fn eval(&self, cos: f32) -> Spectrum {
        self.f0.lerp(self.f90, schlick_weight(cos))
    }
}

/// Unpolarised reflectance of a smooth boundary between two dielectrics (Fresnel 1823; Pharr, Jakob, Humphreys,
/// "Physically Based Rendering" 4th ed., eq. 9.5), exact.
///
/// `cos_i` is the cosine of the angle of incidence, 0..1; `eta` the index of refraction on the far side relative to
/// that on the near side, > 0. Total internal reflection gives 1. What is not a number gives 1.
pub fn dielectric(cos_i: f32, eta: f32) -> f32 {
    let c = cos_i.clamp(0.0, 1.0);
    // sin²θt = sin²θi / η²; written with (1−c)(1+c), which keeps its digits near normal incidence.
    let cos2_t = 1.0 - (1.0 - c) * (1.0 + c) / (eta * eta);
    // Also taken by NaN.
    if !(cos2_t > 0.0) {
        return 1.0;
    }
    let t = cos2_t.sqrt();
    let parallel = (eta * c - t) / (eta * c + t);
    let perpendicular = (c - eta * t) / (c + eta * t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).clamp(0.0, 1.0)
}

/// Reflectance at normal incidence of a dielectric in air: ((1 − ior) / (1 + ior))².
///
/// `KHR_materials_ior`: `ior = 0` stands for an infinite index, and gives 1 as the formula does. Negative or NaN: 0.04,
/// the glTF default.
#[inline(always)]
pub fn f0_from_ior(ior: f32) -> f32 {
    if ior == f32::INFINITY {
        return 1.0;
    }
    let ior = if ior >= 0.0 { ior } else { 1.5 };
    let r = (1.0 - ior) / (1.0 + ior);
    r * r
}

/// The index of refraction ≥ 1 that reflects `f0` at normal incidence: (1 + √F0) / (1 − √F0); infinite for F0 ≥ 1.
#[inline(always)]
pub fn ior_from_f0(f0: f32) -> f32 {
    let r = f0.clamp(0.0, 1.0).sqrt();
    (1.0 + r) / (1.0 - r)
}

/// Schlick's curve for light from everywhere on a rough surface, where no half vector is known: F0 + (max(1 − r, F0) −
/// F0)(1 − cos θ)⁵ (Lagarde 2011, "Adopting a physically based shading model").
///
/// `cos` is the cosine of the view to the *surface's* normal, clamped to 0..1; `roughness` is perceptual, 0..1. An
/// approximation for image-based light: the edge of a rough surface must not shine as a smooth one's.
#[inline(always)]
pub fn schlick_rough(cos: f32, f0: Spectrum, roughness: f32) -> Spectrum {
    let smooth = Spectrum::splat(1.0 - roughness.max(0.0).min(1.0));
    f0.lerp(smooth.max(f0), schlick_weight(cos.max(0.0)))
}

/// The speed of light in vacuum, m/s (exact by the definition of the metre).
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// The speed at which a wave's crests travel through a medium of index `ior` > 0: c / n, in m/s.
#[inline]
pub fn phase_velocity(ior: f64) -> f64 {
    SPEED_OF_LIGHT / ior
}

/// The wavelength in a medium of index `ior` > 0 of light whose wavelength in vacuum is `vacuum`: λ / n, in its unit. (The
/// frequency, and with it the colour, stays.)
#[inline]
pub fn wavelength_in(vacuum: f64, ior: f64) -> f64 {
    vacuum / ior
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dielectric_meets_known_values() {
        // Normal incidence: ((n−1)/(n+1))². Brewster's angle: only the perpendicular part, ((n²−1)/(n²+1))² / 2.
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-7);
        let n = 1.5f32;
        let brewster = 1.0 / (1.0 + n * n).sqrt();
        let s = (n * n - 1.0) / (n * n + 1.0);
        assert!((dielectric(brewster, n) - 0.5 * s * s).abs() < 1e-6);
        assert_eq!(dielectric(0.0, 1.5), 1.0);
        // From the inside the critical angle has sin θ = 1/n.
        let critical = (1.0 - 1.0 / (n * n)).sqrt();
        assert_eq!(dielectric(critical - 1e-4, 1.0 / n), 1.0);
        assert!(dielectric(critical + 1e-3, 1.0 / n) < 0.9);
    }

    #[test]
    fn dielectric_is_the_same_from_both_sides() {
        for i in 10..100 {
            let c = i as f32 / 100.0;
            let t = (1.0 - (1.0 - c * c) / 2.25f32).sqrt();
            assert!((dielectric(c, 1.5) - dielectric(t, 1.0 / 1.5)).abs() < 1e-5, "cos {c}");
        }
    }

    #[test]
    fn ior_and_f0_are_inverse() {
        for ior in [1.0f32, 1.1, 1.33, 1.5, 2.42, 4.0] {
            assert!((ior_from_f0(f0_from_ior(ior)) - ior).abs() < 2e-5 * ior);
        }
        assert_eq!(f0_from_ior(0.0), 1.0);
        assert_eq!(f0_from_ior(f32::INFINITY), 1.0);
        assert_eq!(ior_from_f0(1.0), f32::INFINITY);
        assert!((f0_from_ior(f32::NAN) - 0.04).abs() < 1e-7);
    }

    #[test]
    fn schlick_is_near_the_exact_curve() {
        let s = Schlick { f0: Spectrum::splat(0.04), f90: Spectrum::ONE };
        for i in 0..=100 {
            let c = i as f32 / 100.0;
            // The largest difference for n = 1.5 is 0.0357, at cos θ = 0.088.
            assert!((s.eval(c).0[0] - dielectric(c, 1.5)).abs() < 0.036);
        }
        assert_eq!(s.eval(0.0).0[0], 1.0);
        assert!((s.eval(1.0).0[0] - 0.04).abs() < 1e-7);
    }

    #[test]
    fn rough_schlick_has_its_ends() {
        let f0 = Spectrum([0.04, 0.5, 0.9, 1.0]);
        // Smooth: Schlick; fully rough: F0 alone; between, the edge is the larger of 1 − r and F0.
        assert_eq!(schlick_rough(0.3, f0, 0.0), Schlick { f0, f90: Spectrum::ONE }.eval(0.3));
        assert_eq!(schlick_rough(0.0, f0, 1.0), f0);
        assert_eq!(schlick_rough(0.0, f0, 0.25), Spectrum([0.75, 0.75, 0.9, 1.0]));
        assert!(schlick_rough(f32::NAN, f0, f32::NAN).is_finite());
    }

    #[test]
    fn waves_slow_down_in_glass() {
        assert!((phase_velocity(1.5) - 1.998_616_4e8).abs() < 1e2);
        // Wavelength times frequency is the velocity.
        let frequency = SPEED_OF_LIGHT / 589.3e-9;
        assert!((wavelength_in(589.3e-9, 1.5) * frequency - phase_velocity(1.5)).abs() < 1e-3);
    }
}
