//! Oren-Nayar's rough diffuse surface, and Fujii's forms of it.
//!
//! Oren, Nayar 1994, "Generalization of Lambert's Reflectance Model", is a surface of V-shaped grooves whose slopes have the
//! standard deviation σ. All forms here are
//!
//! ```text
//! f = ρ/π (A + B g),   s = wo·wi − µo µi = sin θo sin θi cos Δφ
//! ```
//!
//! | form | A | B | g | source |
//! |---|---|---|---|---|
//! | `qualitative` | 1 − σ²/2 / (σ² + 0.33) | 0.45 σ² / (σ² + 0.09) | max(0, s) / max(µo, µi) | Oren, Nayar 1994, eq. 30 |
//! | `fujii` | the same + 0.17 ρ σ² / (σ² + 0.13) | the same | s / t | Fujii 2012, "A tiny improvement of Oren-Nayar reflectance model", his first form |
//! | `fujii-scaled` | 1 / (1 + (1/2 − 2/(3π)) r) | r A | s / t | Fujii 2012, his second form (FON) |
//!
//! with t = max(µo, µi) if s > 0, else 1, and σ = r π/2 for a roughness r of 0..1. `max(0, s) / max(µo, µi)` is the
//! better known max(0, cos Δφ) sin α tan β. The qualitative form is dark in a ring where s changes sign; Fujii's are smooth
//! there. Rough surfaces lose what the grooves pass to each other; [`super::eon`] gives it back. A slightly rough white surface
//! makes light near grazing in the fits of the first two forms: 1.015 of a white sky in the qualitative one (roughness 0.13),
//! 1.029 in Fujii's first (0.16).

use super::{
    cltc::Cltc,
    eon::{diffuse_eval, diffuse_sample, fon_a, fon_albedo, fon_s_over_t},
};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, MIN_COS},
    choices,
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
};
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use etendue_color::Spectrum;
use glam::Vec3A;

choices! {
    /// Which of the forms; see the module's head.
    pub enum OrenNayarForm {
        /// Oren and Nayar's own short form.
        Qualitative = "qualitative",
        /// Fujii's first form: smooth, with the light between grooves in A.
        Fujii = "fujii",
        /// Fujii's second form, which EON is built on.
        FujiiScaled = "fujii-scaled",
    }
}

parameters! {
    /// What a rough matte surface is at a point.
    pub struct OrenNayarParams {
        /// Colour of a groove's walls, each lane 0..1.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// 0 Lambert .. 1 as rough as can be (σ = π/2).
        roughness: f32 = 0.5, 0.0..1.0;
        /// Which form of the model.
        form: OrenNayarForm = OrenNayarForm::Qualitative, 0.0..1.0;
    }
}

impl ModelParams for OrenNayarParams {
    type Closure = OrenNayar;
    const ABOUT: &'static str = "a rough matte surface (Oren, Nayar 1994; Fujii 2012), single scattering";
    const CLAIMS: Claims = Claims {
        conserves: Claim::Breaks(
            "the fits of the qualitative form and of Fujii's first return up to 1.015 and 1.029 of a white sky near grazing at roughness 0.1 to 0.2; fujii-scaled never more than 1",
        ),
        ..Claims::ALL
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> OrenNayar {
        OrenNayar::new(self.base_color, self.roughness, self.form)
    }
}

/// The Oren-Nayar surface; see the module's head.
///
/// Reciprocal; its [`Bsdf::albedo`] is exact. Sampled by [`Cltc`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    /// ρ A / π.
    a: Spectrum,
    /// ρ B / π.
    b: Spectrum,
    /// Whether negative s counts.
    smooth: bool,
    cltc: Cltc,
}

impl OrenNayar {
    /// Colour of the walls, each lane 0..1, roughness 0..1, both clamped, and form.
    #[inline]
    pub fn new(color: Spectrum, roughness: f32, form: OrenNayarForm) -> Self {
        let rho = color.map(|v| v.max(0.0).min(1.0));
        let r = roughness.max(0.0).min(1.0);
        let s2 = (r * FRAC_PI_2) * (r * FRAC_PI_2);
        let a = 1.0 - 0.5 * s2 / (s2 + 0.33);
        let b = 0.45 * s2 / (s2 + 0.09);
        let over_pi = rho * FRAC_1_PI;
        let (a, b) = match form {
            OrenNayarForm::Qualitative => (over_pi * a, over_pi * b),
            OrenNayarForm::Fujii => {
                (over_pi * (rho * (0.17 * s2 / (s2 + 0.13)) + Spectrum::splat(a)), over_pi * b)
            }
            OrenNayarForm::FujiiScaled => (over_pi * fon_a(r), over_pi * (r * fon_a(r))),
        };
        Self { a, b, smooth: form != OrenNayarForm::Qualitative, cltc: Cltc::new(r) }
    }

    /// g of the module's head.
    #[inline(always)]
    fn g(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let g = fon_s_over_t(wo, wi);
        if self.smooth { g } else { g.max(0.0) }
    }
}

impl Bsdf for OrenNayar {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // A > B in each form and g ≥ −1; the bound is for directions that are not unit.
        diffuse_eval(wo, wi, || {
            ((self.a + self.b * self.g(wo, wi)).map(|v| v.max(0.0)), self.cltc.pdf(wo, wi))
        })
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
        // The mean of s/t is G/π, which FON's albedo at roughness 1 holds; of max(0, s)/t it is more by ∫ of the negative s,
        // S ∫ S' 2µ' dµ' / π = 2 S / (3π).
        let mean = fon_albedo(wo.z, 1.0) / fon_a(1.0) - 1.0;
        let s = (1.0 - wo.z.min(1.0) * wo.z.min(1.0)).sqrt();
        let mean = if self.smooth { mean } else { mean + s * (2.0 / (3.0 * PI)) };
        (self.a + self.b * mean) * PI
    }
}
