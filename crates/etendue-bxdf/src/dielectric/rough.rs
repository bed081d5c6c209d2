//! A boundary between two media, smooth or of GGX microfacets.
//!
//! Reflection is the lobe of [`crate::ggx`]. Refraction (Walter, Marschner, Li, Torrance 2007, "Microfacet Models for
//! Refraction through Rough Surfaces", eq. 21), for radiance that arrives along `wi` from the far side:
//!
//! ```text
//! f = |wo·m| |wi·m| / (|cos θo| |cos θi|) · T(wo·m) G D(m) / (wo·m + η wi·m)²,   m ∝ wo + η wi
//! ```
//!
//! with η the index of the far side over that of the near side. For importance it is larger by η² (Veach 1997, section
//! 5.2). The unnormalised half vector h = wo + η wi does all the work: |wo·m + η wi·m| is its length, so no difference
//! of nearly equal numbers is left.
//!
//! # Masking of refracted light
//! With Smith's heights, light that leaves upward from a microfacet at height h is seen with probability C(h)^Λ, light
//! that leaves downward with (1 − C(h))^Λ, C being the distribution of heights. Reflection therefore has
//! 1 / (1 + Λo + Λi), and refraction ∫₀¹ u^Λo (1 − u)^Λi du = B(1 + Λo, 1 + Λi), Euler's beta function (Heitz, Hanika,
//! d'Eon, Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model", section 5.2). Walter's separable
//! product 1 / ((1 + Λo)(1 + Λi)) is larger (by a half where both Λ are 1): it takes the two heights for independent. The
//! beta function is what the random walk over microsurfaces finds for its first bounce, so it is taken here.

use super::interface::Interface;
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    energy::Row,
    ggx::{ALPHA_DELTA, Ggx, mirror},
    math::beta,
    model::Transport,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Below this α · |η − 1| the refracted lobe is too narrow for directions in `f32` (which are right to 6e-8).
const NARROWEST_REFRACTION: f32 = 2e-5;

/// What light that passes does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Reflected and refracted by microfacets.
    Rough,
    /// Reflected by microfacets, passes straight: both sides have the same index.
    Matched,
    /// Reflected and refracted in one direction each.
    Smooth,
}

/// A boundary between two media: reflection and refraction by GGX microfacets (single scattering), or smooth.
///
/// Reciprocal up to the scaling of refracted radiance. Where both α lie below [`ALPHA_DELTA`], or refraction would be narrower
/// than directions can be told apart, both parts are perfectly specular; where the indices match
/// ([`super::MATCHED`]) light passes straight. Total internal reflection is the interface's.
///
/// Each microfacet is drawn from the visible ones and then reflects or refracts in proportion to what it does, so that
/// a sample's weight is bounded by 1 (for tints of 1 and importance). Its [`Bsdf::albedo`] is an estimate.
///
/// ```
/// use etendue_bxdf::{Bsdf, GgxDielectric, dielectric::Dielectric, model::Transport};
/// use glam::vec3a;
///
/// let frosted = GgxDielectric::new([0.1, 0.1], Dielectric::new(1.5), Transport::Radiance);
/// assert!(frosted.eval(vec3a(0.0, 0.0, 1.0), vec3a(0.0, 0.0, -1.0)).max_element() > 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxDielectric<I> {
    pub(super) ggx: Ggx,
    interface: I,
    kind: Kind,
    pub(super) eta: f32,
    /// Factor of what is refracted: 1/η² for radiance, 1 for importance.
    pub(super) scale: f32,
    reflection: Spectrum,
    transmission: Spectrum,
}

/// What one microfacet does with light.
#[derive(Clone, Copy)]
pub(super) struct Split {
    pub reflected: Spectrum,
    /// Without the scaling of radiance.
    pub transmitted: Spectrum,
    pub p_reflect: f32,
}

#[inline(always)]
fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}

/// The direction behind a facet `m` (on the side of `wo`) into which light is bent; `None` beyond the critical angle.
#[inline(always)]
pub(crate) fn refract(wo: Vec3A, m: Vec3A, eta: f32) -> Option<Vec3A> {
    let cos = wo.dot(m);
    let inv = 1.0 / eta;
    let cos2_t = 1.0 - (1.0 - cos) * (1.0 + cos) * (inv * inv);
    // Also taken by NaN.
    if !(cos2_t > 0.0 && cos > 0.0) {
        return None;
    }
    let wi = m * (cos * inv - cos2_t.sqrt()) - wo * inv;
    Some(wi * (1.0 / wi.length_squared().sqrt()))
}

impl<I: Interface> GgxDielectric<I> {
    /// α along x and y (0..1), what each microfacet does, and what the path carries.
    ///
    /// In a strongly anisotropic surface of nearly matched media the smaller α is raised until its refracted lobe can be
    /// told from a line (α |η − 1| ≥ 2e-5).
    #[inline(always)]
    pub fn new(alpha: [f32; 2], interface: I, transport: Transport) -> Self {
        let eta = interface.eta();
        let bend = (eta - 1.0).abs();
        let widest = alpha[0].max(alpha[1]);
        // Also taken by NaN.
        let kind = if !(widest >= ALPHA_DELTA) {
            Kind::Smooth
        } else if bend == 0.0 {
            Kind::Matched
        } else if !(widest * bend >= NARROWEST_REFRACTION) {
            Kind::Smooth
        } else {
            Kind::Rough
        };
        let least = if kind == Kind::Rough { NARROWEST_REFRACTION / bend } else { 0.0 };
        let scale = match transport {
            Transport::Radiance => 1.0 / (eta * eta),
            Transport::Importance => 1.0,
        };
        Self {
            ggx: Ggx::new(alpha[0].max(least), alpha[1].max(least)),
            interface,
            kind,
            eta,
            scale,
            reflection: Spectrum::ONE,
            transmission: Spectrum::ONE,
        }
    }

    /// The same boundary with reflected and transmitted light multiplied by colours (lanes ≥ 0; negative and NaN
    /// become 0).
    #[inline(always)]
    pub fn tinted(mut self, reflection: Spectrum, transmission: Spectrum) -> Self {
        let lane = |v: f32| v.max(0.0).min(1e6);
        (self.reflection, self.transmission) = (reflection.map(lane), transmission.map(lane));
        self
    }

    /// The distribution of its microfacets.
    #[inline(always)]
    pub fn ggx(&self) -> &Ggx {
        &self.ggx
    }

    /// What each microfacet does.
    #[inline(always)]
    pub fn interface(&self) -> &I {
        &self.interface
    }

    /// True if both parts are perfectly specular.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.kind == Kind::Smooth
    }

    /// True if both parts are scattered by microfacets.
    #[inline(always)]
    pub fn is_rough(&self) -> bool {
        self.kind == Kind::Rough
    }

    /// The colours that reflected and transmitted light are multiplied by.
    #[inline(always)]
    pub fn tints(&self) -> [Spectrum; 2] {
        [self.reflection, self.transmission]
    }

    #[inline(always)]
    pub(super) fn split(&self, reflect: Spectrum, transmit: Spectrum) -> Split {
        let (reflected, transmitted) = (reflect * self.reflection, transmit * self.transmission);
        let (r, t) = (sum(reflected), sum(transmitted));
        let p = if r + t > 0.0 { r / (r + t) } else { 1.0 };
        // A side of less than a millionth is never picked: one over its probability could leave f32.
        let p_reflect = if p < 1e-6 {
            0.0
        } else if p > 1.0 - 1e-6 {
            1.0
        } else {
            p
        };
        Split { reflected, transmitted, p_reflect }
    }

    /// At a microfacet that light meets at an angle of cosine `cos`.
    #[inline(always)]
    fn at(&self, cos: f32) -> Split {
        let cos = cos.min(1.0);
        self.split(self.interface.reflect(cos), self.interface.transmit(cos))
    }

    /// Over all microfacets that are seen from `wo`: of matched media.
    #[inline(always)]
    fn mean(&self, wo: Vec3A) -> Split {
        let [ax, ay] = self.ggx.alpha();
        // Roughness of the mean α: α = roughness².
        let w = Row::new((ax * ay).sqrt().sqrt()).directional(wo.z).w;
        self.split(self.interface.reflect_mean(wo, w), self.interface.transmit_mean(wo, w))
    }

    /// Value and density of a pair on one side.
    #[inline(always)]
    fn reflection_pair(&self, wo: Vec3A, wi: Vec3A) -> (Spectrum, f32) {
        if self.kind == Kind::Matched {
            let pair = self.ggx.pair(wo, wi);
            let value = self.interface.reflect(pair.cos_half) * self.reflection * pair.value;
            return (value, self.mean(wo).p_reflect * pair.pdf);
        }
        let h = wo + wi;
        let d = self.ggx.d_along(h);
        let (to, ti) = (self.ggx.stretched_length(wo), self.ggx.stretched_length(wi));
        let split = self.at(0.5 * h.length());
        (split.reflected * (d * 0.5 / (wi.z * to + wo.z * ti)), split.p_reflect * (d * 0.5 / (wo.z + to)))
    }

    /// Value and density of a pair on two sides, of unmatched media.
    #[inline(always)]
    fn refraction_pair(&self, wo: Vec3A, wi: Vec3A) -> (Spectrum, f32) {
        let none = (Spectrum::ZERO, 0.0);
        // The half vector points into the thinner medium; the facet's normal to wo's side.
        let side = if self.eta > 1.0 { -1.0 } else { 1.0 };
        let h = (wo + wi * self.eta) * side;
        let (oh, ih) = (wo.dot(h), wi.dot(h));
        // Also taken by NaN.
        if !(h.z > 0.0 && oh > 0.0 && ih < 0.0) {
            return none;
        }
        let len2 = h.length_squared();
        let inv = 1.0 / len2.sqrt();
        let (near, far) = ((oh * inv).min(1.0), (-ih * inv).min(1.0));
        let interface = &self.interface;
        let split = self.split(interface.reflect_between(near, far), interface.transmit_between(near, far));
        let (to, ti) = (self.ggx.stretched_length(wo), self.ggx.stretched_length(wi));
        let (zo, zi) = (wo.z, -wi.z);
        // D (wo·m)(wi·m) / |h|².
        let common = self.ggx.d_along(h) * (oh * -ih) / (len2 * len2);
        // 1 + Λ = (1 + t / z) / 2.
        let g = beta(0.5 + 0.5 * to / zo, 0.5 + 0.5 * ti / zi);
        let eta2 = self.eta * self.eta;
        let value = split.transmitted * (self.scale * eta2 * common * g / (zo * zi));
        (value, (1.0 - split.p_reflect) * (common * eta2 * 2.0 / (zo + to)))
    }

    /// The perfectly specular parts: what is mirrored, and what passes.
    #[inline(always)]
    fn delta_parts(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return [None, None];
        }
        let (split, through) = match self.kind {
            Kind::Rough => return [None, None],
            Kind::Matched => (self.mean(wo), Some(-wo)),
            Kind::Smooth => (self.at(wo.z), refract(wo, Vec3A::Z, self.eta)),
        };
        let mirrored = (self.kind == Kind::Smooth && split.p_reflect > 0.0).then(|| DeltaPart {
            wi: mirror(wo),
            reflectance: split.reflected,
            probability: split.p_reflect,
        });
        let passed = through.filter(|wi| wi.z < -MIN_COS && split.p_reflect < 1.0).map(|wi| DeltaPart {
            wi,
            reflectance: split.transmitted * self.scale,
            probability: 1.0 - split.p_reflect,
        });
        [mirrored, passed]
    }

    /// The parts of the light from `wo` that are reflected and that pass, without the scaling of radiance: estimates by
    /// the smooth boundary.
    #[inline]
    pub fn energy(&self, wo: Vec3A) -> [Spectrum; 2] {
        if !(wo.z > MIN_COS) {
            return [Spectrum::ZERO; 2];
        }
        let split = if self.kind == Kind::Matched { self.mean(wo) } else { self.at(wo.z) };
        [split.reflected, split.transmitted]
    }
}

impl<I: Interface> Bsdf for GgxDielectric<I> {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if self.kind == Kind::Smooth || !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        let (specular, pdf) = if wi.z > 0.0 {
            self.reflection_pair(wo, wi)
        } else if self.kind == Kind::Rough {
            self.refraction_pair(wo, wi)
        } else {
            return Eval::ZERO;
        };
        if !(pdf < f32::INFINITY && specular.is_finite()) {
            return Eval::ZERO;
        }
        Eval { diffuse: Spectrum::ZERO, specular, pdf }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let uc = uc.max(0.0);
        let specular = |wi: Vec3A, weight: Spectrum, pdf: f32, delta: bool| BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf,
            delta,
            lobe: LobeKind::Specular,
        };
        let wi = match self.kind {
            Kind::Smooth => {
                let [mirrored, passed] = self.delta_parts(wo);
                let p = mirrored.map_or(0.0, |d| d.probability);
                let d = if uc < p { mirrored } else { passed }?;
                return Some(specular(d.wi, d.reflectance * (1.0 / d.probability), d.probability, true));
            }
            Kind::Matched => {
                if !(uc < self.mean(wo).p_reflect) {
                    let d = self.delta_parts(wo)[1]?;
                    return Some(specular(d.wi, d.reflectance * (1.0 / d.probability), d.probability, true));
                }
                let wi = self.ggx.sample_reflection(wo, u);
                (wi.z > MIN_COS).then_some(wi)?
            }
            Kind::Rough => {
                let m = self.ggx.sample_half(wo, u);
                let cos = wo.dot(m);
                if uc < self.at(cos).p_reflect {
                    let wi = m * (2.0 * cos) - wo;
                    (wi.z > MIN_COS).then_some(wi)?
                } else {
                    refract(wo, m, self.eta).filter(|wi| wi.z < -MIN_COS)?
                }
            }
        };
        let e = self.eval_pdf(wo, wi);
        if !(e.pdf > 0.0 && wi.is_finite()) {
            return None;
        }
        Some(specular(wi, e.specular * (wi.z.abs() / e.pdf), e.pdf, false))
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        let [reflected, transmitted] = self.energy(wo);
        reflected + transmitted * self.scale
    }

    #[inline]
    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        self.delta_parts(wo)
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.kind == Kind::Smooth { [1.0, 1.0] } else { self.ggx.alpha() }
    }

    #[inline]
    fn refraction(&self) -> Option<f32> {
        if self.transmission.is_black() { None } else { Some(self.eta) }
    }
}
