//! Any Fresnel reflectance as one type parameter of a microfacet lobe.

use crate::{
    conductor::Conductor,
    f82::F82Tint,
    fresnel::{self, Schlick},
};
use etendue_color::Spectrum;

/// How much a microfacet reflects, by angle.
///
/// Lobes take it as a type parameter: the formula is chosen at compile time.
pub trait Fresnel: Copy {
    /// Reflectance at an angle of cosine `cos` (to the microfacet's normal), each lane 0..1; `cos` outside 0..1 is
    /// clamped.
    fn eval(&self, cos: f32) -> Spectrum;

    /// Mean over the hemisphere, cosine-weighted: 2 ∫₀¹ F(μ) μ dμ.
    fn average(&self) -> Spectrum;
}

impl Fresnel for Schlick {
    #[inline(always)]
    fn eval(&self, cos: f32) -> Spectrum {
        Schlick::eval(self, cos)
    }

    /// F0 + (F90 − F0) / 21, exact.
    #[inline(always)]
    fn average(&self) -> Spectrum {
        self.f0.lerp(self.f90, 1.0 / 21.0)
    }
}

impl Fresnel for Conductor {
    #[inline(always)]
    fn eval(&self, cos: f32) -> Spectrum {
        Conductor::eval(self, cos)
    }

    #[inline]
    fn average(&self) -> Spectrum {
        Conductor::average(self)
    }
}

impl Fresnel for F82Tint {
    #[inline(always)]
    fn eval(&self, cos: f32) -> Spectrum {
        F82Tint::eval(self, cos)
    }

    #[inline(always)]
    fn average(&self) -> Spectrum {
        F82Tint::average(self)
    }
}

/// The exact dielectric ([`fresnel::dielectric`]) as a Fresnel term, the same in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    eta: f32,
}

impl Dielectric {
    /// From the index of refraction of the far side over that of the near side, clamped to 10⁻³..10³; NaN counts as the
    /// lower end.
    #[inline(always)]
    pub fn new(eta: f32) -> Self {
        Self { eta: eta.max(1e-3).min(1e3) }
    }

    /// The ratio of indices, as clamped.
    #[inline(always)]
    pub fn eta(&self) -> f32 {
        self.eta
    }
}

impl Fresnel for Dielectric {
    #[inline(always)]
    fn eval(&self, cos: f32) -> Spectrum {
        Spectrum::splat(fresnel::dielectric(cos, self.eta))
    }

    #[inline]
    fn average(&self) -> Spectrum {
        Spectrum::splat(dielectric_average(self.eta))
    }
}

/// Mean reflectance of a dielectric boundary under diffuse light, 2 ∫₀¹ F(μ) μ dμ; `eta` as in
/// [`fresnel::dielectric`].
///
/// For `eta` > 1 a fit in r = (η − 1) / (η + 1), made for this file, of the closed form of Walsh (Duntley 1942, "The
/// Optical Properties of Diffusing Materials", eq. 24); absolute error < 4e-4 for every η ≥ 1. Below 1 the exact relation
/// of the two sides, n² (1 − F̄(1/n)) = 1 − F̄(n) (Egan, Hilgeman 1973), on top of it.
#[inline]
pub fn dielectric_average(eta: f32) -> f32 {
    let eta = eta.max(1e-6);
    if eta < 1.0 {
        return 1.0 - eta * eta * (1.0 - average_from_outside(1.0 / eta));
    }
    average_from_outside(eta)
}

#[inline]
fn average_from_outside(eta: f32) -> f32 {
    if !(eta < 1e6) {
        return 1.0;
    }
    let r = (eta - 1.0) / (eta + 1.0);
    // Made for this file: least largest error over r, with the ends F̄(0) = 0 and F̄(1) = 1 held.
    let p = -0.391_811_94
        + r * (-2.421_347_5 + r * (7.489_861 + r * (-15.643_349 + r * (15.915_912 + r * -6.546_958_7))));
    r + r * (1.0 - r) * p
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 ∫ F μ dμ by the midpoint rule in t with μ = t³, which resolves grazing angles.
    pub fn average_by_quadrature(f: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        (0..n)
            .map(|i| {
                let t = (i as f64 + 0.5) / n as f64;
                6.0 * f(t * t * t) * t.powi(5)
            })
            .sum::<f64>()
            / n as f64
    }

    fn dielectric_f64(c: f64, n: f64) -> f64 {
        let cos2 = 1.0 - (1.0 - c * c) / (n * n);
        if cos2 <= 0.0 {
            return 1.0;
        }
        let t = cos2.sqrt();
        let (p, s) = ((n * c - t) / (n * c + t), (c - n * t) / (c + n * t));
        0.5 * (p * p + s * s)
    }

    #[test]
    fn dielectric_average_is_near_the_integral() {
        let mut worst = 0.0f64;
        for i in 0..=200 {
            let n = 10f64.powf(-1.0 + i as f64 / 200.0 * 3.0);
            let exact = average_by_quadrature(|c| dielectric_f64(c, n));
            worst = worst.max((dielectric_average(n as f32) as f64 - exact).abs());
        }
        println!("dielectric average: largest error {worst:.2e}");
        assert!(worst < 4e-4);
        assert_eq!(dielectric_average(1.0), 0.0);
        assert!(dielectric_average(f32::INFINITY) == 1.0 && dielectric_average(f32::NAN).is_finite());
    }

    #[test]
    fn averages_are_those_of_the_curves() {
        fn check<F: Fresnel>(name: &str, f: F, bound: f64) {
            let average = f.average();
            for lane in 0..4 {
                let exact = average_by_quadrature(|c| f.eval(c as f32)[lane] as f64);
                let error = (average[lane] as f64 - exact).abs();
                assert!(error < bound, "{name} lane {lane}: {average:?}, {exact}");
            }
        }
        let f0 = Spectrum([1.0, 0.77, 0.34, 0.0]);
        check("schlick", Schlick { f0, f90: Spectrum::splat(0.9) }, 2e-6);
        check("f82", F82Tint::from_tint(f0, Spectrum([0.5, 0.8, 1.0, 1.0])), 2e-6);
        // Gold, silver, iron, and a metal of small n and k.
        let n = Spectrum([0.18, 0.05, 2.9, 0.3]);
        let k = Spectrum([3.4, 4.2, 3.1, 0.6]);
        check("conductor", Conductor::new(n, k), 3e-4);
        check("dielectric", Dielectric::new(1.5), 4e-4);
    }
}
