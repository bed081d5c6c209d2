//! What is scattered diffusely: evenly, or by rough facets (`KHR_materials_diffuse_roughness`).
//!
//! The rough lobe is EON ([`crate::diffuse::eon`]), the one of OpenPBR, in place of Lambert's on both sides; light that comes out
//! on the far side leaves by the mirror image of its direction, as that extension has `KHR_materials_diffuse_transmission` do.

use crate::{diffuse::eon::Eon, sampling::cosine_hemisphere};
use core::f32::consts::{FRAC_1_PI, PI};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// The diffuse lobes of the near and of the far side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matte {
    /// Albedo / π of each side at roughness 0.
    even: [Spectrum; 2],
    rough: Option<[Eon; 2]>,
}

impl Matte {
    /// Colour (0..1) and share / π (≥ 0) of each side, roughness 0..1.
    #[inline]
    pub fn new(color: [Spectrum; 2], share: [f32; 2], roughness: f32) -> Self {
        let even = core::array::from_fn(|i| color[i] * share[i]);
        let lobe = |i| Eon::new(color[i], roughness).scaled(share[i] * PI);
        Self { even, rough: (roughness > 0.0).then(|| [lobe(0), lobe(1)]) }
    }

    /// True if nothing comes out on a side.
    #[inline(always)]
    pub fn is_black(&self, side: usize) -> bool {
        self.even[side].is_black()
    }

    /// The sums over lanes of what an even surface of these colours returns on each side.
    #[inline(always)]
    pub fn sums(&self) -> [f32; 2] {
        self.even.map(|c| super::extended::sum(c) * PI)
    }

    /// Value on a side, for `wi` turned to the upper side.
    #[inline(always)]
    pub fn value(&self, side: usize, wo: Vec3A, wi: Vec3A) -> Spectrum {
        match &self.rough {
            None => self.even[side],
            Some(lobes) => lobes[side].value(wo, wi),
        }
    }

    /// Density of [`Matte::sample`], for `wi` turned to the upper side.
    #[inline(always)]
    pub fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        match &self.rough {
            None => wi.z * FRAC_1_PI,
            Some([lobe, _]) => lobe.density(wo, wi),
        }
    }

    /// A direction on a side.
    #[inline(always)]
    pub fn sample(&self, side: usize, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        match (&self.rough, side) {
            (None, 0) => cosine_hemisphere(u),
            (None, _) => -cosine_hemisphere(u),
            (Some([lobe, _]), 0) => lobe.direction(wo, uc, u),
            (Some([lobe, _]), _) => lobe.direction(wo, uc, u) * vec3a(1.0, 1.0, -1.0),
        }
    }

    /// What both sides return, if the part `entering` of the light enters.
    #[inline(always)]
    pub fn albedo(&self, wo: Vec3A, entering: f32) -> Spectrum {
        match &self.rough {
            None => (self.even[0] + self.even[1]) * (PI * entering),
            Some([near, far]) => (near.reflected(wo.z) + far.reflected(wo.z)) * entering,
        }
    }

    /// π f for light between straight up and an angle of cosine `cos`, of a white surface.
    #[inline(always)]
    pub fn straight_up(&self, cos: f32) -> f32 {
        self.rough.as_ref().map_or(1.0, |[lobe, _]| lobe.white_straight_up(cos))
    }
}
