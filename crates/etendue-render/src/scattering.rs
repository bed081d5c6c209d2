//! Any closure that a path may meet, on the stack.

use etendue_bxdf::bssrdf::EntryLobe;
use etendue_bxdf::measured::Measured;
use etendue_bxdf::model::Closure;
use etendue_bxdf::{Bsdf, BsdfSample, Eval, MetalRough};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The closure of a surface point.
///
/// The core material's is inlined into the path, and compiled with it for the processor's wide instructions; the others are
/// called.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Scattering<'w> {
    Plain(MetalRough),
    Whole(Closure),
    /// Where light enters that leaves elsewhere.
    Entry(EntryLobe),
    Measured(&'w Measured),
}

impl Bsdf for Scattering<'_> {
    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        match self {
            Self::Plain(c) => c.eval_pdf(wo, wi),
            Self::Whole(c) => eval_pdf(c, wo, wi),
            Self::Entry(c) => c.eval_pdf(wo, wi),
            Self::Measured(c) => c.eval_pdf(wo, wi),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        match self {
            Self::Plain(c) => c.sample(wo, uc, u),
            Self::Whole(c) => sample(c, wo, uc, u),
            Self::Entry(c) => c.sample(wo, uc, u),
            Self::Measured(c) => c.sample(wo, uc, u),
        }
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        match self {
            Self::Plain(c) => c.albedo(wo),
            Self::Whole(c) => c.albedo(wo),
            Self::Entry(c) => c.albedo(wo),
            Self::Measured(c) => c.albedo(wo),
        }
    }

    #[inline(always)]
    fn refraction(&self) -> Option<f32> {
        match self {
            Self::Plain(_) | Self::Entry(_) | Self::Measured(_) => None,
            Self::Whole(c) => c.refraction(),
        }
    }
}

#[inline(never)]
fn eval_pdf(c: &Closure, wo: Vec3A, wi: Vec3A) -> Eval {
    c.eval_pdf(wo, wi)
}

#[inline(never)]
fn sample(c: &Closure, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
    c.sample(wo, uc, u)
}
