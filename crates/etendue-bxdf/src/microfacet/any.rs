//! Distributions and masking chosen when the program runs.

use super::{Beckmann, BlinnPhong, Distribution, Gtr, Masking, SchlickGgx, Smith, SmithSeparable, VCavity};
use crate::ggx::Ggx;
use glam::Vec3A;

macro_rules! either {
    ($self:ident, $name:ident => $e:expr) => {
        match $self {
            Self::Ggx($name) => $e,
            Self::Beckmann($name) => $e,
            Self::Gtr($name) => $e,
            Self::BlinnPhong($name) => $e,
        }
    };
}

/// One of the distributions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnyDistribution {
    /// GGX.
    Ggx(Ggx),
    /// Beckmann's.
    Beckmann(Beckmann),
    /// Trowbridge and Reitz's with a free tail.
    Gtr(Gtr),
    /// Blinn's.
    BlinnPhong(BlinnPhong),
}

impl Distribution for AnyDistribution {
    #[inline]
    fn d(&self, h: Vec3A) -> f32 {
        either!(self, x => Distribution::d(x, h))
    }
    #[inline]
    fn lambda(&self, w: Vec3A) -> f32 {
        either!(self, x => Distribution::lambda(x, w))
    }
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec3A {
        either!(self, x => x.sample(u))
    }
    #[inline]
    fn sample_visible(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        either!(self, x => x.sample_visible(wo, uc, u))
    }
    #[inline]
    fn visible_g1(&self, wo: Vec3A, h: Vec3A) -> f32 {
        either!(self, x => x.visible_g1(wo, h))
    }
    #[inline]
    fn alpha(&self) -> [f32; 2] {
        either!(self, x => Distribution::alpha(x))
    }
}

/// One of the masking terms.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnyMasking {
    /// Smith's, heights correlated.
    Smith(Smith),
    /// Smith's, separable.
    SmithSeparable(SmithSeparable),
    /// Schlick's curve.
    SchlickGgx(SchlickGgx),
    /// V-cavities.
    VCavity(VCavity),
}

impl Masking for AnyMasking {
    #[inline]
    fn g1<D: Distribution>(&self, d: &D, w: Vec3A, h: Vec3A) -> f32 {
        match self {
            Self::Smith(g) => g.g1(d, w, h),
            Self::SmithSeparable(g) => g.g1(d, w, h),
            Self::SchlickGgx(g) => g.g1(d, w, h),
            Self::VCavity(g) => g.g1(d, w, h),
        }
    }

    #[inline]
    fn g2<D: Distribution>(&self, d: &D, wo: Vec3A, wi: Vec3A, h: Vec3A) -> f32 {
        match self {
            Self::Smith(g) => g.g2(d, wo, wi, h),
            Self::SmithSeparable(g) => g.g2(d, wo, wi, h),
            Self::SchlickGgx(g) => g.g2(d, wo, wi, h),
            Self::VCavity(g) => g.g2(d, wo, wi, h),
        }
    }
}
