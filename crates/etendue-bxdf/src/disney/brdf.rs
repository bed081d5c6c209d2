//! Disney's principled BRDF.
//!
//! Burley 2012, "Physically Based Shading at Disney", and the code published with it (`disney.brdf` of the BRDF Explorer). With c
//! the base colour, h the half vector, θd the angle to it, F(x) = (1 − x)⁵ and t its hue ([`super::tint`]):
//!
//! ```text
//! f = (mix(f_base, f_flat, subsurface) + f_sheen) (1 − metallic) + f_specular + f_coat
//! f_base, f_flat     [`crate::diffuse::disney`]
//! f_sheen    = sheen · mix(1, t, sheen_tint) · F(cos θd)
//! f_specular = D(h) G mix(c_s, 1, F(cos θd)),  c_s = mix(0.08 specular mix(1, t, specular_tint), c, metallic)
//! f_coat     = clearcoat / 4 · D₁(h) G₁ (0.04 + 0.96 F(cos θd))
//! ```
//!
//! D is GGX with αx = r²/a, αy = r² a, a = √(1 − 0.9 anisotropic), each at least 0.001; D₁ the coat's GTR of γ = 1. G and G₁ are
//! products of Smith's masking for GGX, isotropic: of width (½ + r/2)² for the specular lobe ("to reduce extreme gain for
//! shiny surfaces", section 5.6) and ¼ for the coat.
//!
//! # Where this departs from the paper
//! αx is at most 1 (at full roughness and anisotropy it would be 3.2, a distribution with fewer facets up than sideways).

use super::{
    coat::{Coat, masking},
    tint::{sum, tinted, unit},
};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    diffuse::disney::{DisneyPair, DisneySampler, base_albedo, flat_albedo},
    energy::Row,
    fresnel::schlick_weight,
    ggx::{Ggx, anisotropic_alpha},
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::Vec3A;

/// The least α of the specular lobe.
pub(super) const LEAST_ALPHA: f32 = 0.001;

parameters! {
    /// What Disney's principled surface is at a point; all but the colour 0..1.
    pub struct DisneyBrdfParams {
        /// Colour of the body, or of a metal's reflection.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// From the base diffuse form to the flat one of light that scattered below the surface.
        subsurface: f32 = 0.0, 0.0..1.0;
        /// 0 dielectric .. 1 metal.
        metallic: f32 = 0.0, 0.0..1.0;
        /// Strength of the dielectric's reflection; ½ is an index of 1.5.
        specular: f32 = 0.5, 0.0..1.0;
        /// How much of the body's hue the dielectric's reflection has.
        specular_tint: f32 = 0.0, 0.0..1.0;
        /// Perceptual roughness of the diffuse and the specular lobe.
        roughness: f32 = 0.5, 0.0..1.0;
        /// 0 round highlights .. 1 long ones along x.
        anisotropic: f32 = 0.0, 0.0..1.0;
        /// A glow at grazing angles, meant for cloth.
        sheen: f32 = 0.0, 0.0..1.0;
        /// How much of the body's hue the sheen has.
        sheen_tint: f32 = 0.5, 0.0..1.0;
        /// Strength of a second, clear, specular lobe.
        clearcoat: f32 = 0.0, 0.0..1.0;
        /// 0 satin .. 1 gloss.
        clearcoat_gloss: f32 = 1.0, 0.0..1.0;
    }
}

impl ModelParams for DisneyBrdfParams {
    type Closure = DisneyBrdf;
    const ABOUT: &'static str = "Disney's principled BRDF (Burley 2012), literal";
    const CLAIMS: Claims = Claims {
        conserves: Claim::Breaks(
            "its lobes are added without one knowing of the other, and its masking is not its distribution's: white returns up to 1.66 of a white sky at 89° (roughness 1, every feature on)",
        ),
        ..Claims::ALL
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> DisneyBrdf {
        DisneyBrdf::new(self)
    }
}

/// The closure of Disney's principled surface; see the module's head.
///
/// Reciprocal; makes light at grazing angles. Its [`Bsdf::albedo`] is an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisneyBrdf {
    ggx: Ggx,
    row: Row,
    roughness: f32,
    /// (½ + r/2)².
    masking_alpha: f32,
    subsurface: f32,
    /// Base colour of the diffuse part.
    diffuse: Spectrum,
    sheen: Spectrum,
    f0: Spectrum,
    coat: Coat,
    sampler: DisneySampler,
}

/// About the sheen's albedo at strength 1, ∫ (1 − cos θd)⁵ cos θi dωi: a fit.
#[inline(always)]
pub(super) fn sheen_albedo(cos: f32) -> f32 {
    0.01 + 0.3 * schlick_weight(cos)
}

/// Probabilities of the lobes.
#[derive(Clone, Copy)]
struct Choice {
    diffuse: f32,
    specular: f32,
    coat: f32,
}

impl DisneyBrdf {
    /// The closure of a surface; parameters out of range are clamped, NaN counts as 0.
    #[inline]
    pub fn new(p: &DisneyBrdfParams) -> Self {
        let c = p.base_color.map(unit);
        let (metallic, roughness) = (unit(p.metallic), unit(p.roughness));
        let dielectric = 1.0 - metallic;
        let [ax, ay] = anisotropic_alpha(roughness, unit(p.anisotropic));
        let plastic = tinted(c, unit(p.specular_tint)) * (0.08 * unit(p.specular));
        let half = 0.5 + 0.5 * roughness;
        let subsurface = unit(p.subsurface);
        Self {
            ggx: Ggx::new(ax.max(LEAST_ALPHA), ay.max(LEAST_ALPHA)),
            row: Row::new(roughness),
            roughness,
            masking_alpha: half * half,
            subsurface,
            diffuse: c * dielectric,
            sheen: tinted(c, unit(p.sheen_tint)) * (unit(p.sheen) * dielectric),
            f0: (plastic * dielectric + c * metallic).map(unit),
            coat: Coat::new(unit(p.clearcoat), unit(p.clearcoat_gloss)),
            sampler: DisneySampler::new(roughness, subsurface),
        }
    }

    /// About the parts of the light that go to the diffuse lobes, the specular one and the coat.
    #[inline(always)]
    fn parts(&self, wo: Vec3A) -> (Spectrum, Spectrum, f32) {
        let base = base_albedo(wo.z, self.roughness);
        let body = if self.subsurface == 0.0 {
            base
        } else {
            base + (flat_albedo(wo.z, self.roughness) - base) * self.subsurface
        };
        let a = self.row.directional(wo.z);
        let specular = (self.f0 + (Spectrum::ONE - self.f0) * a.w) * a.e;
        (self.diffuse * body + self.sheen * sheen_albedo(wo.z), specular, self.coat.albedo(wo.z))
    }

    /// Each lobe is drawn in proportion to what it reflects, and none that is there never.
    #[inline(always)]
    fn choice(&self, wo: Vec3A) -> Choice {
        let (diffuse, specular, coat) = self.parts(wo);
        let diffuse = sum(diffuse);
        let (specular, coat) = (sum(specular), 4.0 * coat);
        let all = diffuse + specular + coat;
        if !(all > 0.0) {
            return Choice { diffuse: 1.0, specular: 0.0, coat: 0.0 };
        }
        let least = |there: bool, p: f32| if there { (p / all).max(0.02) } else { 0.0 };
        let d = least(diffuse > 0.0, diffuse);
        let s = least(specular > 0.0, specular);
        let c = least(!self.coat.is_none(), coat);
        let inv = 1.0 / (d + s + c);
        Choice { diffuse: d * inv, specular: s * inv, coat: c * inv }
    }

    /// Value by lobe and density; both directions above the surface.
    #[inline(always)]
    fn eval_above(&self, p: Choice, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = Eval::ZERO;
        let pair = DisneyPair::new(wo, wi);
        let fd = schlick_weight(pair.cos2_d.sqrt());
        if p.diffuse > 0.0 {
            let base = pair.base(self.roughness);
            let body = if self.subsurface == 0.0 {
                base
            } else {
                base + (pair.flat(self.roughness) - base) * self.subsurface
            };
            e.diffuse = self.diffuse * (body.max(0.0) * FRAC_1_PI) + self.sheen * fd;
            e.pdf = p.diffuse * self.sampler.pdf(wo, wi);
        }
        let g = masking(wo.z, self.masking_alpha) * masking(wi.z, self.masking_alpha);
        let d = self.ggx.d_along(wo + wi);
        e.specular = (self.f0 + (Spectrum::ONE - self.f0) * fd) * (d * g);
        e.pdf += p.specular * self.ggx.pair(wo, wi).pdf;
        if !self.coat.is_none() {
            let (value, pdf) = self.coat.pair(wo, wi);
            e.specular += Spectrum::splat(value);
            e.pdf += p.coat * pdf;
        }
        e
    }
}

impl Bsdf for DisneyBrdf {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let e = self.eval_above(self.choice(wo), wo, wi);
        if e.pdf < f32::INFINITY && e.value().is_finite() { e } else { Eval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let p = self.choice(wo);
        let uc = unit(uc);
        let (wi, lobe) = if uc < p.diffuse {
            (self.sampler.sample(wo, uc / p.diffuse, u), LobeKind::Diffuse)
        } else if uc < p.diffuse + p.specular || p.coat == 0.0 {
            (self.ggx.sample_reflection(wo, u), LobeKind::Specular)
        } else {
            let uc = (uc - p.diffuse - p.specular) / p.coat;
            (self.coat.sample(wo, uc, u), LobeKind::Specular)
        };
        if !(wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        let e = self.eval_above(p, wo, wi);
        if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
            return None;
        }
        let scale = wi.z / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        let weight = weight_diffuse + weight_specular;
        weight.is_finite().then_some(BsdfSample {
            wi,
            weight,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let (diffuse, specular, coat) = self.parts(wo);
        diffuse + specular + Spectrum::splat(coat)
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        let [x, y] = self.ggx.alpha();
        let coat = if self.coat.is_none() { 1.0 } else { self.coat.alpha() };
        [x.min(coat), y.min(coat)]
    }
}
