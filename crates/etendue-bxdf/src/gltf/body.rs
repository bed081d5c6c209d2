//! The base's specular part: reflection, and what passes it.

use super::{facet::Facet, shape::Shape};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval},
    dielectric::{GgxDielectric, Interface, ThinGgx},
    fresnel::schlick_weight,
    ggx::mirror,
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
}

impl Base {
    /// The base's specular part on both sides, without layers.
    #[inline(always)]
    pub fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        match &self.body {
            Body::Thin(lobe) => lobe.eval_pdf(wo, wi),
            Body::Solid(lobe) => lobe.eval_pdf(wo, wi),
            Body::Opaque if self.shape.mirror || !(wi.z > 0.0) => Eval::ZERO,
            Body::Opaque => {
                let pair = self.shape.ggx.pair(wo, wi);
                let specular = self.facet.reflect(pair.cos_half) * pair.value;
                Eval { diffuse: Spectrum::ZERO, specular, pdf: pair.pdf }
            }
        }
    }

    #[inline(always)]
    pub fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        match &self.body {
            Body::Thin(lobe) => lobe.deltas(wo),
            Body::Solid(lobe) => lobe.deltas(wo),
            Body::Opaque => {
                let part =
                    DeltaPart { wi: mirror(wo), reflectance: self.facet.reflect(wo.z), probability: 1.0 };
                [self.shape.mirror.then_some(part), None]
            }
        }
    }

    /// What the base's specular part reflects and lets through, summed over lanes: an estimate.
    #[inline(always)]
    pub fn energy(&self, wo: Vec3A) -> [Spectrum; 2] {
        match &self.body {
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
        }
    }

    /// True if it lets nothing through.
    #[inline(always)]
    pub fn is_opaque(&self) -> bool {
        matches!(self.body, Body::Opaque)
    }

    /// A sample of its own, if light passes it.
    #[inline(always)]
    pub fn sample_through(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
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
