//! The fibres of `KHR_materials_fuzz`, on top of everything.
//!
//! The lobe is [`crate::sheen::fuzz`]'s, as in OpenPBR. What it leaves for the layers below is as the extension has it:
//! 1 − weight · R(wo), grey, and by the viewer's direction alone.

use super::{coat::own_normal, params::GltfParams};
use crate::{
    bsdf::{Bsdf, Eval, MIN_COS},
    sampling::Frame,
    sheen::Fuzz,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fibres {
    lobe: Fuzz,
    /// Coverage, above 0.
    weight: f32,
    /// Its frame if its normal is not the base's.
    frame: Option<Frame>,
}

impl Fibres {
    /// `None` if there are none. They follow the surface below them: their normal is the coat's as far as that covers the base's.
    #[inline]
    pub fn new(p: &GltfParams) -> Option<Self> {
        let weight = super::extended::unit(p.fuzz);
        if weight == 0.0 {
            return None;
        }
        let coverage = super::extended::unit(p.clearcoat);
        let frame = own_normal(p.clearcoat_normal)
            .filter(|_| coverage > 0.0)
            .and_then(|n| own_normal(Vec3A::Z.lerp(n, coverage)))
            .map(Frame::from_normal);
        Some(Self { lobe: Fuzz::new(p.fuzz_color, p.fuzz_roughness), weight, frame })
    }

    #[inline(always)]
    fn local(&self, w: Vec3A) -> Vec3A {
        self.frame.as_ref().map_or(w, |f| f.to_local(w))
    }

    /// The part of the light from `w` that reaches what lies below.
    #[inline(always)]
    pub fn through(&self, w: Vec3A) -> f32 {
        1.0 - self.weight * self.lobe.reflectance(self.local(w).z.abs())
    }

    /// What the fibres return of the light from `wo`.
    #[inline(always)]
    pub fn albedo(&self, wo: Vec3A) -> Spectrum {
        self.lobe.albedo(self.local(wo)) * self.weight
    }

    /// Value (without the base's cosine) and density of a pair above the base.
    #[inline(always)]
    pub fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let i = self.local(wi);
        let e = self.lobe.eval_pdf(self.local(wo), i);
        // With a normal of their own they meet light by the cosine to that normal.
        let tilt = if self.frame.is_some() { i.z / wi.z } else { 1.0 };
        let diffuse = e.diffuse * (self.weight * tilt);
        if diffuse.is_finite() { Eval { diffuse, ..e } } else { Eval::ZERO }
    }

    /// A direction; it may lie below the base.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<Vec3A> {
        let o = self.local(wo);
        if !(o.z > MIN_COS) {
            return None;
        }
        let wi = self.lobe.sample(o, uc, u)?.wi;
        Some(self.frame.as_ref().map_or(wi, |f| f.to_world(wi)))
    }
}
