//! The reflection lobe of any distribution, masking and Fresnel term.

use super::{Distribution, Masking};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    fresnel_term::Fresnel,
    ggx::{ALPHA_DELTA, mirror},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// [`ALPHA_DELTA`] with room for the rounding of a distribution's width.
const MIRROR: f32 = ALPHA_DELTA * 1.000_01;

/// Reflection by microfacets: F D G2 / (4 cos θo cos θi), single scattering. Reciprocal.
///
/// Its [`Bsdf::albedo`] is an estimate. With widths at [`ALPHA_DELTA`] or below it is a perfect mirror.
///
/// ```
/// use etendue_bxdf::{Bsdf, Conductor, microfacet::{Beckmann, Microfacet, Smith}};
/// use etendue_color::Spectrum;
/// use glam::Vec3A;
///
/// let metal = Conductor::new(Spectrum::rgb(0.2, 0.5, 1.5), Spectrum::rgb(3.0, 2.3, 1.8));
/// let lobe = Microfacet::new(Beckmann::new(0.3, 0.3), Smith, metal);
/// assert!(lobe.eval(Vec3A::Z, Vec3A::new(0.6, 0.0, 0.8))[0] > 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacet<D, G, F> {
    distribution: D,
    masking: G,
    fresnel: F,
    mirror: bool,
}

impl<D: Distribution, G: Masking, F: Fresnel> Microfacet<D, G, F> {
    /// The lobe of these three.
    #[inline(always)]
    pub fn new(distribution: D, masking: G, fresnel: F) -> Self {
        let [x, y] = distribution.alpha();
        Self { distribution, masking, fresnel, mirror: x.max(y) <= MIRROR }
    }

    /// The distribution of its facets.
    #[inline(always)]
    pub fn distribution(&self) -> &D {
        &self.distribution
    }

    /// F = 1 value and density; both directions above [`MIN_COS`].
    #[inline(always)]
    fn pair(&self, wo: Vec3A, wi: Vec3A) -> (f32, f32, f32) {
        let h = wo + wi;
        let d = self.distribution.d(h);
        let value = 0.25 * d * self.masking.g2(&self.distribution, wo, wi, h) / (wo.z * wi.z);
        // Visible normals have density G1 D (wo·m) / cos θo; reflection divides by 4 (wo·m).
        let pdf = 0.25 * d * self.distribution.visible_g1(wo, h) / wo.z;
        (value, pdf, 0.5 * h.length_squared().sqrt())
    }
}

impl<D: Distribution, G: Masking, F: Fresnel> Bsdf for Microfacet<D, G, F> {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if self.mirror || !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let (value, pdf, cos_half) = self.pair(wo, wi);
        if !(pdf < f32::INFINITY && value < f32::INFINITY) {
            return Eval::ZERO;
        }
        Eval { diffuse: Spectrum::ZERO, specular: self.fresnel.eval(cos_half) * value, pdf }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let (wi, weight, pdf) = if self.mirror {
            (mirror(wo), self.fresnel.eval(wo.z), 1.0)
        } else {
            let m = self.distribution.sample_visible(wo, uc, u);
            let wi = m * (2.0 * wo.dot(m)) - wo;
            if !(wi.z > MIN_COS) {
                return None;
            }
            let (value, pdf, cos_half) = self.pair(wo, wi);
            if !(pdf > 0.0 && pdf < f32::INFINITY && value < f32::INFINITY) {
                return None;
            }
            (wi, self.fresnel.eval(cos_half) * (value * wi.z / pdf), pdf)
        };
        if !(wi.is_finite() && weight.is_finite()) {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf,
            delta: self.mirror,
            lobe: LobeKind::Specular,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { self.fresnel.eval(wo.z) } else { Spectrum::ZERO }
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let part = DeltaPart { wi: mirror(wo), reflectance: self.fresnel.eval(wo.z), probability: 1.0 };
        [(self.mirror && wo.z > MIN_COS).then_some(part), None]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.mirror { [1.0, 1.0] } else { self.distribution.alpha() }
    }
}
