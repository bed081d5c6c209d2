//! How the sheen lobe is sampled.

use crate::sampling::uniform_hemisphere;
use core::f32::consts::TAU;
use glam::Vec3A;

/// The density for one roughness: even over the hemisphere, as Estevez, Kulla 2017 propose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampler;

impl Sampler {
    #[inline]
    pub(super) fn new(_roughness: f32) -> Self {
        Self
    }

    #[inline(always)]
    pub(super) fn pdf(&self, _wo: Vec3A, _wi: Vec3A) -> f32 {
        1.0 / TAU
    }

    #[inline(always)]
    pub(super) fn sample(&self, _wo: Vec3A, _uc: f32, u: [f32; 2]) -> Vec3A {
        uniform_hemisphere(u)
    }
}
