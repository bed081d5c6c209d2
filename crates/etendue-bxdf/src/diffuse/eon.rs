//! EON: Oren-Nayar's rough diffuse surface in the form that keeps all energy.
//!
//! Portsmouth, Kutz, Hill 2024, "EON: A practical energy-preserving rough diffuse BRDF". With r the roughness 0..1, ρ the
//! colour of a facet, s = wo·wi − µo µi and t = max(µo, µi) if s > 0, else 1 (Fujii 2012, "A tiny improvement of
//! Oren-Nayar reflectance model"):
//!
//! ```text
//! f     = f_ss + f_ms
//! f_ss  = ρ/π A (1 + r s/t),   A = 1 / (1 + (1/2 − 2/(3π)) r)                      (FON, eq. 9 to 14)
//! f_ms  = ρ_ms/π (1 − E(µo)) (1 − E(µi)) / (1 − Ē)
//! ρ_ms  = ρ² Ē / (1 − ρ (1 − Ē))
//! E(µ)  = A (1 + r G(µ)/π),    Ē = A (1 + (2/3 − 28/(15π)) r)
//! G(µ)  = S (acos µ − S µ) + 2/3 (S/µ (1 − S³) − S),   S = √(1 − µ²)
//! ```
//!
//! E and Ē are FON's directional and mean albedo at ρ = 1, so a white surface returns exactly what comes in. What
//! single scattering loses is computed as 1 − E = A r (c₁ − G/π), without the difference of two numbers near one.

use super::cltc::Cltc;
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    math::acos,
    model::{Incidence, ModelParams},
    parameters,
};
use core::f32::consts::{FRAC_1_PI, PI};
use etendue_color::Spectrum;
use glam::Vec3A;

/// 1/2 − 2/(3π): what A is made of, and G(0)/π.
const C1: f32 = 0.5 - 2.0 / (3.0 * PI);
/// 2/3 − 28/(15π): the mean of G/π.
const C2: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// A of Fujii's form for a roughness 0..1.
#[inline(always)]
pub fn fon_a(roughness: f32) -> f32 {
    1.0 / (1.0 + C1 * roughness)
}

/// s/t of Fujii's form: the geometry of a pair of directions above the surface.
#[inline(always)]
pub fn fon_s_over_t(wo: Vec3A, wi: Vec3A) -> f32 {
    let s = wo.x * wi.x + wo.y * wi.y;
    if s > 0.0 { s / wo.z.max(wi.z) } else { s }
}

/// G(µ)/π, exact up to rounding, for µ in 0..1.
#[inline(always)]
fn g_over_pi(mu: f32) -> f32 {
    let mu = mu.max(0.0).min(1.0);
    let s = ((1.0 - mu) * (1.0 + mu)).sqrt();
    // (1 − S³)/µ = µ (1 + S + S²) / (1 + S): nothing to cancel at the horizon.
    let g = s * (acos(mu) - s * mu) + (2.0 / 3.0) * s * (mu * (1.0 + s + s * s) / (1.0 + s) - 1.0);
    g * FRAC_1_PI
}

/// Directional albedo of Fujii's form at ρ = 1 (the paper's listing 1, `exact`), for µ and roughness in 0..1.
#[inline]
pub fn fon_albedo(mu: f32, roughness: f32) -> f32 {
    fon_a(roughness) * (1.0 + roughness * g_over_pi(mu))
}

/// The paper's polynomial for [`fon_albedo`] (its listing 1, `approx`), for shaders that have no arc cosine to spare.
///
/// Within 5e-4 of it.
#[inline]
pub fn fon_albedo_fit(mu: f32, roughness: f32) -> f32 {
    let x = 1.0 - mu.max(0.0).min(1.0);
    let g = x * (0.057_108_53 + x * (0.491_881_87 + x * (-0.332_181_44 + x * 0.071_442_996)));
    fon_a(roughness) * (1.0 + roughness * g)
}

parameters! {
    /// What a rough matte surface is at a point.
    pub struct EonParams {
        /// Colour of a facet: reflectance of a smooth surface of the same stuff, each lane 0..1.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// 0 Lambert .. 1 as rough as can be.
        roughness: f32 = 0.5, 0.0..1.0;
    }
}

impl ModelParams for EonParams {
    type Closure = Eon;
    const ABOUT: &'static str = "a rough matte surface that keeps energy (Portsmouth, Kutz, Hill 2024, EON)";

    #[inline]
    fn closure(&self, _at: &Incidence) -> Eon {
        Eon::new(self.base_color, self.roughness)
    }
}

/// The energy-preserving Oren-Nayar surface; see the module's head.
///
/// Reciprocal; its [`Bsdf::albedo`] is exact. Sampled by [`Cltc`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eon {
    /// ρ A / π.
    single: Spectrum,
    /// ρ_ms A r / (π (c₁ − c₂)).
    multiple: Spectrum,
    roughness: f32,
    cltc: Cltc,
}

impl Eon {
    /// Colour of a facet, each lane 0..1, and roughness 0..1; both are clamped.
    #[inline]
    pub fn new(color: Spectrum, roughness: f32) -> Self {
        let rho = color.map(|v| v.max(0.0).min(1.0));
        let r = roughness.max(0.0).min(1.0);
        let a = fon_a(r);
        let mean = a * (1.0 + C2 * r);
        let rho_ms = rho.map(|v| v * v * mean / (1.0 - v * (1.0 - mean)));
        Self {
            single: rho * (a * FRAC_1_PI),
            multiple: rho_ms * (a * r * FRAC_1_PI / (C1 - C2)),
            roughness: r,
            cltc: Cltc::new(r),
        }
    }

    /// Value, 1/sr; both directions above the surface.
    #[inline(always)]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        let single = (1.0 + self.roughness * fon_s_over_t(wo, wi)).max(0.0);
        let lost = (C1 - g_over_pi(wo.z)).max(0.0) * (C1 - g_over_pi(wi.z)).max(0.0);
        self.single * single + self.multiple * lost
    }

    /// The same lobe, times a factor ≥ 0.
    #[inline]
    pub fn scaled(mut self, factor: f32) -> Self {
        self.single *= factor;
        self.multiple *= factor;
        self
    }

    /// Density of [`Eon::direction`], per steradian; both directions above the surface.
    #[inline(always)]
    pub fn density(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        self.cltc.pdf(wo, wi)
    }

    /// A direction above the surface.
    #[inline(always)]
    pub fn direction(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        self.cltc.sample(wo, uc, u)
    }

    /// Directional albedo at an angle of cosine `cos`.
    #[inline(always)]
    pub fn reflected(&self, cos: f32) -> Spectrum {
        let g = g_over_pi(cos);
        // The mean of c₁ − G/π over wi is c₁ − c₂.
        self.single * (PI * (1.0 + self.roughness * g)) + self.multiple * (PI * (C1 - g).max(0.0) * (C1 - C2))
    }

    /// π f of a white surface of this roughness, for light between straight up and an angle of cosine `cos`.
    #[inline(always)]
    pub fn white_straight_up(&self, cos: f32) -> f32 {
        let r = self.roughness;
        fon_a(r) * (1.0 + r * C1 * (C1 - g_over_pi(cos)).max(0.0) / (C1 - C2))
    }
}

impl Bsdf for Eon {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        diffuse_eval(wo, wi, || (self.value(wo, wi), self.cltc.pdf(wo, wi)))
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        diffuse_sample(self, wo, || self.cltc.sample(wo, uc, u))
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        self.reflected(wo.z)
    }
}

/// The shape of `eval_pdf` for a lobe that is diffuse and reflects only: nothing below the surface or for what is no
/// direction; `above` gives value and density.
#[inline(always)]
pub(crate) fn diffuse_eval(wo: Vec3A, wi: Vec3A, above: impl FnOnce() -> (Spectrum, f32)) -> Eval {
    // Also taken by NaN.
    if !(wo.z > MIN_COS && wi.z > MIN_COS) {
        return Eval::ZERO;
    }
    let (diffuse, pdf) = above();
    if !((0.0..f32::INFINITY).contains(&pdf) && diffuse.is_finite()) {
        return Eval::ZERO;
    }
    Eval { diffuse, specular: Spectrum::ZERO, pdf }
}

/// The shape of `sample` for such a lobe: `draw` gives a direction, value and density come from `eval_pdf`.
#[inline(always)]
pub(crate) fn diffuse_sample<B: Bsdf>(
    bsdf: &B,
    wo: Vec3A,
    draw: impl FnOnce() -> Vec3A,
) -> Option<BsdfSample> {
    if !(wo.z > MIN_COS && wo.is_finite()) {
        return None;
    }
    let wi = draw();
    if !(wi.z > MIN_COS && wi.is_finite()) {
        return None;
    }
    let e = bsdf.eval_pdf(wo, wi);
    if !(e.pdf > 0.0) {
        return None;
    }
    let weight = e.diffuse * (wi.z / e.pdf);
    weight.is_finite().then_some(BsdfSample {
        wi,
        weight,
        weight_diffuse: weight,
        weight_specular: Spectrum::ZERO,
        pdf: e.pdf,
        delta: false,
        lobe: LobeKind::Diffuse,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fit_is_near_the_exact_albedo() {
        let mut worst = 0.0f32;
        for i in 0..=1000 {
            let mu = i as f32 / 1000.0;
            for r in [0.1, 0.5, 1.0] {
                worst = worst.max((fon_albedo(mu, r) - fon_albedo_fit(mu, r)).abs());
            }
        }
        println!("worst error of the fit {worst:.1e}");
        assert!(worst < 5e-4, "{worst}");
    }
}
