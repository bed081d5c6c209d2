//! Light that entered a surface and comes out again without a preferred direction.
//!
//! | module | what it holds |
//! |---|---|
//! | here | Lambert's even surface |
//! | [`oren_nayar`] | rough surfaces of grooves, single scattering |
//! | [`eon`] | the same keeping all energy |
//! | [`disney`] | Disney's fit to measured surfaces, and its parts |
//! | [`cltc`] | how rough diffuse lobes are sampled |

pub mod cltc;
pub mod disney;
pub mod eon;
pub mod oren_nayar;

use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    model::{Incidence, ModelParams},
    parameters, sampling,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What a Lambertian surface is at a point.
    pub struct LambertParams {
        /// Reflectance, each lane 0..1.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
    }
}

impl ModelParams for LambertParams {
    type Closure = Lambert;
    const ABOUT: &'static str = "an ideally matte surface (Lambert 1760)";

    #[inline]
    fn closure(&self, _at: &Incidence) -> Lambert {
        Lambert { color: self.base_color.map(|v| v.max(0.0).min(1.0)) }
    }
}

/// Lambert's surface: f = ρ / π (Lambert 1760), sampled by the cosine.
///
/// Its [`Bsdf::albedo`] is exact. Reciprocal; reflects `color` at each angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Reflectance ρ, each lane 0..1.
    pub color: Spectrum,
}

impl Bsdf for Lambert {
    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        Eval { diffuse: self.color * FRAC_1_PI, specular: Spectrum::ZERO, pdf: wi.z * FRAC_1_PI }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3A, _uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = sampling::cosine_hemisphere(u);
        if !(wo.z > MIN_COS && wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight: self.color,
            weight_diffuse: self.color,
            weight_specular: Spectrum::ZERO,
            pdf: wi.z * FRAC_1_PI,
            delta: false,
            lobe: LobeKind::Diffuse,
        })
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { self.color } else { Spectrum::ZERO }
    }
}
