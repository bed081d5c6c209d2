//! glTF's sheen: fibres that stand on a surface, as microfacets.
//!
//! `KHR_materials_sheen`, after Estevez, Kulla 2017, "Production Friendly Microfacet Sheen BRDF": with α = roughness² and h
//! the half vector,
//!
//! ```text
//! f = color · D(h) / (4 µo µi (1 + Λ(µo) + Λ(µi)))
//! D = (2 + 1/α) sin^(1/α) θh / 2π                                         (their eq. 2)
//! Λ = exp(L(µ)) for µ < ½, exp(2 L(½) − L(1 − µ)) above                      (their eq. 3)
//! L = a / (1 + b µ^c) + d µ + e, with a..e between the columns of their table 1 by (1 − α)²
//! ```
//!
//! The softening of the terminator (their eq. 4) is left out, as in the extension's text; it is not reciprocal.
//!
//! # Where this departs from the extension, and why
//! Below roughness 0.28 the lobe as written makes light near grazing: white fibres return 1.2 of a white sky at roughness
//! 0.2, 2.1 at 0.1, up to 7 at [`LEAST_ROUGHNESS`] (the generator of the table prints it), because the fit of Λ knows nothing of D's
//! normalisation there. With E₀ that literal albedo, the lobe here is
//!
//! ```text
//! f / max(1, E₀(µo), E₀(µi))
//! ```
//!
//! which is reciprocal, returns at most what comes in, and is the literal lobe wherever that does. [`Sheen::literal`] is the
//! lobe as written.

use super::{albedo::SheenRow, sampler::Sampler};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, MIN_COS},
    diffuse::eon::{diffuse_eval, diffuse_sample},
    math::{exp, exp2, ln, ln_1p},
    model::{Incidence, ModelParams},
    parameters,
};
use core::f32::consts::{LOG2_E, TAU};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The least roughness: α = 1e-3. Below it the lobe is a sheet within two degrees of the horizon; at it white fibres already
/// return less than 1e-3 of the light at all angles up to 78°.
pub const LEAST_ROUGHNESS: f32 = 0.031_622_78;

parameters! {
    /// What a layer of fibres is at a point, seen by itself: what it does not reflect goes nowhere.
    pub struct SheenParams {
        /// Colour of the fibres, each lane 0..1.
        color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// How far the fibres lean from the normal, 0..1; α = roughness².
        roughness: f32 = 0.5, 0.0..1.0;
    }
}

impl ModelParams for SheenParams {
    type Closure = Sheen;
    const ABOUT: &'static str =
        "fibres as microfacets (Estevez, Kulla 2017, \"Charlie\"), the layer of KHR_materials_sheen";

    #[inline]
    fn closure(&self, _at: &Incidence) -> Sheen {
        Sheen::new(self.color, self.roughness)
    }
}

/// The sheen lobe.
///
/// Reciprocal. Its [`Bsdf::albedo`] is the table's ([`SheenRow`]). It reflects only; [`SheenRow`] also says what is left for
/// the layers below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheen {
    color: Spectrum,
    fibres: Fibres,
    row: SheenRow,
    sampler: Sampler,
    literal: bool,
}

/// Distribution and masking of the fibres at one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibres {
    inv_alpha: f32,
    /// a..e of L.
    l: [f32; 5],
    /// 2 L(½).
    twice_l_half: f32,
}

impl Fibres {
    /// Roughness, clamped to [`LEAST_ROUGHNESS`]..1.
    #[inline]
    pub fn new(roughness: f32) -> Self {
        let r = roughness.max(LEAST_ROUGHNESS).min(1.0);
        let alpha = r * r;
        let t = (1.0 - alpha) * (1.0 - alpha);
        // Table 1: α = 1, then α = 0.
        const ROUGH: [f32; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
        const SMOOTH: [f32; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
        let l: [f32; 5] = core::array::from_fn(|i| ROUGH[i] + (SMOOTH[i] - ROUGH[i]) * t);
        let mut fibres = Self { inv_alpha: 1.0 / alpha, l, twice_l_half: 0.0 };
        fibres.twice_l_half = 2.0 * fibres.l(0.5);
        fibres
    }

    #[inline(always)]
    fn l(&self, mu: f32) -> f32 {
        let [a, b, c, d, e] = self.l;
        let power = if mu > 0.0 { exp2(c * LOG2_E * ln(mu)) } else { 0.0 };
        a / (1.0 + b * power) + d * mu + e
    }

    /// Λ(µ) for µ in 0..1.
    #[inline]
    pub fn lambda(&self, mu: f32) -> f32 {
        let mu = mu.max(0.0).min(1.0);
        exp(if mu < 0.5 { self.l(mu) } else { self.twice_l_half - self.l(1.0 - mu) })
    }

    /// D, per steradian, at a half vector of any length above the surface.
    #[inline(always)]
    pub fn d(&self, h: Vec3A) -> f32 {
        // ln sin² from whichever of sine and cosine is small, where it keeps its digits.
        let inv = 1.0 / h.length_squared();
        let (sin2, cos2) = ((h.x * h.x + h.y * h.y) * inv, h.z * h.z * inv);
        let ln_sin2 = if sin2 < 0.5 { ln(sin2) } else { ln_1p(-cos2.min(0.5)) };
        let power = exp(0.5 * self.inv_alpha * ln_sin2);
        (2.0 + self.inv_alpha) * (1.0 / TAU) * power
    }

    /// D · V, 1/sr: the lobe of white fibres; both directions above the surface.
    #[inline(always)]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let masking = 1.0 + self.lambda(wo.z) + self.lambda(wi.z);
        self.d(wo + wi) / (4.0 * wo.z * wi.z * masking)
    }
}

impl Sheen {
    /// Colour of the fibres, each lane clamped to 0..1, and roughness, clamped to [`LEAST_ROUGHNESS`]..1.
    #[inline]
    pub fn new(color: Spectrum, roughness: f32) -> Self {
        Self {
            color: color.map(|v| v.max(0.0).min(1.0)),
            fibres: Fibres::new(roughness),
            row: SheenRow::new(roughness),
            sampler: Sampler::new(roughness),
            literal: false,
        }
    }

    /// The lobe as its formulas stand, which makes light near grazing below roughness 0.28; [`Bsdf::albedo`] and [`Sheen::row`]
    /// stay those of the conserving lobe.
    #[inline]
    pub fn literal(mut self) -> Self {
        self.literal = true;
        self
    }

    /// The lobe of white fibres, 1/sr; both directions above the surface.
    #[inline(always)]
    fn value(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let value = self.fibres.value(wo, wi);
        if self.literal { value } else { value / self.row.literal(wo.z).max(self.row.literal(wi.z)).max(1.0) }
    }

    /// The albedo of white fibres at its roughness, by angle, and what it leaves to the layers below.
    #[inline(always)]
    pub fn row(&self) -> &SheenRow {
        &self.row
    }

    /// The colour of the fibres, each lane 0..1.
    #[inline(always)]
    pub fn color(&self) -> Spectrum {
        self.color
    }
}

impl Bsdf for Sheen {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        diffuse_eval(wo, wi, || (self.color * self.value(wo, wi), self.sampler.pdf(wo, wi)))
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        diffuse_sample(self, wo, || self.sampler.sample(wo, uc, u))
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { self.color * self.row.directional(wo.z) } else { Spectrum::ZERO }
    }
}
