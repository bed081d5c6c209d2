//! The base's specular part: reflection, and what passes it.

use super::{facet::Facet, shape::Shape};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval},
    dielectric::{GgxDielectric, Interface, ThinGgx},
    fresnel::schlick_weight,
    ggx::mirror,
    multiscatter::Further,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What the base's microfacets do with the light that they do not reflect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Body {
    /// It is scattered diffusely or lost.
    Opaque,
    /// Some of it passes straight through.
    Thin(ThinGgx<Facet>),
    /// Some of it is refracted into a volume.
    Solid(GgxDielectric<Facet>),
}

/// The base without its diffuse part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Base {
    pub facet: Facet,
    pub shape: Shape,
    pub body: Body,
    /// Reflected light of further bounces.
    pub further: Option<Further>,
}

impl Base {
    /// What is done about light that is reflected more than once: the factor of what the facets reflect once, and the
    /// probability of the wide lobe.
    #[inline(always)]
    fn further_at(&self, wo: Vec3A) -> (f32, Spectrum, f32) {
        self.further.as_ref().map_or((0.0, Spectrum::ONE, 0.0), |f| {
            let lost = f.lost(wo.z);
            (lost, f.scale(lost), f.probability(lost))
        })
    }

    /// The base's specular part on both sides, without layers.
    #[inline(always)]
    pub fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = match &self.body {
            Body::Thin(lobe) => lobe.eval_pdf(wo, wi),
            Body::Solid(lobe) => lobe.eval_pdf(wo, wi),
            Body::Opaque if self.shape.mirror || !(wi.z > 0.0) => Eval::ZERO,
            Body::Opaque => {
                let pair = self.shape.ggx.pair(wo, wi);
                let specular = self.facet.reflect(pair.cos_half) * pair.value;
                Eval { diffuse: Spectrum::ZERO, specular, pdf: pair.pdf }
            }
        };
        if let Some(f) = &self.further {
            let (lost, scale, p) = self.further_at(wo);
            e.pdf *= 1.0 - p;
            if wi.z > 0.0 {
                e.specular = e.specular * scale + f.value(lost, wi.z);
                e.pdf += p * f.pdf(wi.z);
            }
        }
        e
    }

    #[inline(always)]
    pub fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let parts = match &self.body {
            Body::Thin(lobe) => lobe.deltas(wo),
            Body::Solid(lobe) => lobe.deltas(wo),
            Body::Opaque => {
                let part =
                    DeltaPart { wi: mirror(wo), reflectance: self.facet.reflect(wo.z), probability: 1.0 };
                [self.shape.mirror.then_some(part), None]
            }
        };
        if self.further.is_none() {
            return parts;
        }
        // Of a sheet whose reflection is rough and whose transmission is not.
        let (_, _, p) = self.further_at(wo);
        parts.map(|d| d.map(|d| DeltaPart { probability: d.probability * (1.0 - p), ..d }))
    }

    /// What the base's specular part reflects and lets through, summed over lanes: an estimate.
    #[inline(always)]
    pub fn energy(&self, wo: Vec3A) -> [Spectrum; 2] {
        let [mut reflected, passed] = match &self.body {
            Body::Thin(lobe) => lobe.energy(wo),
            Body::Solid(lobe) => lobe.energy(wo),
            Body::Opaque => {
                let (f0, f90) = self.facet.ends();
                let (w, e) = if self.shape.mirror {
                    (schlick_weight(wo.z), 1.0)
                } else {
                    let a = self.shape.row.directional(wo.z);
                    (a.w, a.e)
                };
                [(f0 + (Spectrum::splat(f90) - f0) * w) * e, Spectrum::ZERO]
            }
        };
        if let Some(f) = &self.further {
            let (lost, scale, _) = self.further_at(wo);
            reflected = reflected * scale + f.albedo(lost);
        }
        [reflected, passed]
    }

    /// True if it lets nothing through.
    #[inline(always)]
    pub fn is_opaque(&self) -> bool {
        matches!(self.body, Body::Opaque)
    }

    /// A direction with the density of [`Base::eval_pdf`], and whether it is one of [`Base::deltas`].
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<(Vec3A, bool)> {
        let mut uc = uc;
        if let Some(f) = &self.further {
            let (_, _, p) = self.further_at(wo);
            if uc < p {
                return Some((f.sample(u), false));
            }
            uc = (uc - p) / (1.0 - p);
        }
        match &self.body {
            Body::Thin(lobe) => lobe.sample(wo, uc, u).map(|s| (s.wi, s.delta)),
            Body::Solid(lobe) => lobe.sample(wo, uc, u).map(|s| (s.wi, s.delta)),
            Body::Opaque if self.shape.mirror => Some((mirror(wo), true)),
            Body::Opaque => Some((self.shape.ggx.sample_reflection(wo, u), false)),
        }
    }

    /// The whole sample of a body that light passes, where nothing else scatters.
    #[inline(always)]
    pub fn sample_bare(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        match &self.body {
            Body::Thin(lobe) => lobe.sample(wo, uc, u),
            Body::Solid(lobe) => lobe.sample(wo, uc, u),
            Body::Opaque => None,
        }
    }

    pub fn narrowest_alpha(&self) -> [f32; 2] {
        match &self.body {
            Body::Thin(lobe) => lobe.narrowest_alpha(),
            Body::Solid(lobe) => lobe.narrowest_alpha(),
            Body::Opaque if self.shape.mirror => [1.0; 2],
            Body::Opaque => self.shape.ggx.alpha(),
        }
    }

    pub fn refraction(&self) -> Option<f32> {
        match &self.body {
            Body::Thin(lobe) => lobe.refraction(),
            Body::Solid(lobe) => lobe.refraction(),
            Body::Opaque => None,
        }
    }
}
