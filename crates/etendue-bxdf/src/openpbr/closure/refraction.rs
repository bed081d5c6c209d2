//! The boundary of a volume.

use crate::{
    bsdf::{Bsdf, Eval},
    dielectric::GgxDielectric,
    model::Incidence,
    openpbr::facet::Boundary,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The boundary of a volume.
///
/// Where both parts are scattered by microfacets it is the lobe that keeps all light
/// ([`GgxDielectric::whole_eval_pdf`]), reflection and transmission from both sides. Elsewhere the lobe has what passes, and
/// from inside the reflection too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Refraction {
    pub lobe: GgxDielectric<Boundary>,
}

impl Refraction {
    #[inline]
    pub(super) fn new(alpha: [f32; 2], boundary: Boundary, at: &Incidence) -> Self {
        Self { lobe: GgxDielectric::new(alpha, boundary, at.transport) }
    }

    /// True if the lobe reflects, too, what the translucent base reflects.
    #[inline(always)]
    pub(super) fn reflects(&self) -> bool {
        self.lobe.is_rough()
    }

    #[inline]
    pub(super) fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        if self.reflects() {
            self.lobe.whole_eval_pdf(wo, wi, |cos| self.lobe.interface().whole(cos))
        } else {
            self.lobe.eval_pdf(wo, wi)
        }
    }

    /// A direction; the flag says that it is perfectly specular.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<(Vec3A, bool)> {
        if self.reflects() {
            let wi = self.lobe.whole_sample(wo, uc, u, |cos| self.lobe.interface().whole(cos))?;
            return Some((wi, false));
        }
        self.lobe.sample(wo, uc, u).map(|s| (s.wi, s.delta))
    }

    /// Estimates of the parts that are reflected and that pass, by lane; `mean` is the facets' mean reflectance.
    #[inline]
    pub(super) fn energy(&self, wo: Vec3A, mean: Spectrum) -> [Spectrum; 2] {
        if !self.reflects() {
            return self.lobe.energy(wo);
        }
        let mean = mean.map(|v| v.max(0.0).min(1.0));
        [mean, Spectrum::ONE - mean]
    }
}
