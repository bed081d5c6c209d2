//! The GGX mirror with the light of further bounces.

use super::{Compensation, Further, mean_alpha};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    energy::Row,
    fresnel::schlick_weight,
    fresnel_term::Fresnel,
    ggx::{ALPHA_DELTA, Ggx, mirror},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// A surface of GGX microfacets with any Fresnel term, and what is done about light that meets several of them.
///
/// With L the loss of single scattering ([`super::loss`]) and F̄ the Fresnel term's mean over the hemisphere:
///
/// - [`Compensation::KullaConty`] adds (Kulla, Conty 2017, "Revisiting Physically Based Shading at Imageworks", slides 16
///   to 20; the lobe's shape is Kelemen, Szirmay-Kalos 2001)
///
/// ```text
/// f_ms = F_ms L(wo) L(wi) / (π L̄),   F_ms = F̄² Ē / (1 − F̄ L̄),   Ē = 1 − L̄
/// ```
///
///   F_ms is the geometric series of bounces: after the first two (F̄²) each leaves with probability Ē or goes on with
///   F̄ L̄. The slides have F̄ in place of F̄², which counts the first bounce as if it reflected everything; the square is
///   Hill's correction (2018, "A Multi-Faceted Exploration", part 3), and agrees better with the random walk: at roughness
///   1 and F0 = 0.64 the walk returns 0.425, this 0.398, the slides' form about 0.50. Reciprocal;
///   returns 1 ± 0.001 of white light for F = 1 where both α are equal.
/// - [`Compensation::Turquin`] multiplies by 1 + F(1) L(wo) / E(wo) (Turquin 2019, "Practical multiple scattering
///   compensation for microfacet models", eq. 16). Not reciprocal.
///
/// Where the two α differ L is known only near, and a part of it, (αmin / αmax)^(5/4), is given back: no direction gets more
/// than it lost.
///
/// Its [`Bsdf::albedo`] is exact to 0.003 for F = 1 and for Schlick's curve, an estimate for others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedGgx<F> {
    ggx: Ggx,
    fresnel: F,
    smooth: bool,
    further: Further,
    row: Row,
    f0: Spectrum,
}

impl<F: Fresnel> CompensatedGgx<F> {
    /// α along x and y (0..1), what each microfacet reflects, and what is done about further bounces.
    #[inline]
    pub fn new(alpha: [f32; 2], fresnel: F, compensation: Compensation) -> Self {
        let ggx = Ggx::new(alpha[0], alpha[1]);
        let f0 = fresnel.eval(1.0);
        Self {
            ggx,
            fresnel,
            // Also taken by NaN.
            smooth: !(alpha[0].max(alpha[1]) >= ALPHA_DELTA),
            further: Further::new(ggx.alpha(), fresnel.average(), f0, compensation),
            row: Row::new(mean_alpha(ggx.alpha()).0.sqrt()),
            f0,
        }
    }

    /// The distribution of its microfacets.
    #[inline(always)]
    pub fn ggx(&self) -> &Ggx {
        &self.ggx
    }

    /// True if it is a perfect mirror.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.smooth
    }

    #[inline(always)]
    fn at(&self, lost: f32, wo: Vec3A, wi: Vec3A) -> Eval {
        let pair = self.ggx.pair(wo, wi);
        let single = self.fresnel.eval(pair.cos_half) * pair.value * self.further.scale(lost);
        let p = self.further.probability(lost);
        let pdf = (1.0 - p) * pair.pdf + p * self.further.pdf(wi.z);
        let specular = single + self.further.value(lost, wi.z);
        if pdf < f32::INFINITY && specular.is_finite() {
            Eval { diffuse: Spectrum::ZERO, specular, pdf }
        } else {
            Eval::ZERO
        }
    }
}

impl<F: Fresnel> Bsdf for CompensatedGgx<F> {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if self.smooth || !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        self.at(self.further.lost(wo.z), wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let (wi, weight, pdf) = if self.smooth {
            (mirror(wo), self.fresnel.eval(wo.z), 1.0)
        } else {
            let lost = self.further.lost(wo.z);
            let wi = if uc.max(0.0) < self.further.probability(lost) {
                self.further.sample(u)
            } else {
                self.ggx.sample_reflection(wo, u)
            };
            if !(wi.z > MIN_COS && wi.is_finite()) {
                return None;
            }
            let e = self.at(lost, wo, wi);
            (wi, e.specular * (wi.z / e.pdf), e.pdf)
        };
        if !(pdf > 0.0) {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf,
            delta: self.smooth,
            lobe: LobeKind::Specular,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let straight = self.fresnel.eval(wo.z);
        if self.smooth {
            return straight;
        }
        // The mean over the facets that are seen, by the shape of Schlick's curve between the Fresnel term's ends.
        let w = self.row.directional(wo.z).w - schlick_weight(wo.z);
        let mean = (straight + (self.fresnel.eval(0.0) - self.f0) * w).map(|v| v.max(0.0).min(1.0));
        let lost = self.further.lost(wo.z);
        mean * (1.0 - lost) * self.further.scale(lost) + self.further.albedo(lost)
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let there = self.smooth && wo.z > MIN_COS && wo.is_finite();
        let part = || DeltaPart { wi: mirror(wo), reflectance: self.fresnel.eval(wo.z), probability: 1.0 };
        [there.then(part), None]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.smooth { [1.0, 1.0] } else { self.ggx.alpha() }
    }
}
