//! Light that comes out evenly on both sides.

use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    sampling::cosine_hemisphere,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::Vec3A;

/// A thin diffuser: f = reflect / π on the side that the light comes from, transmit / π on the other.
///
/// Paper, leaves and cloth, without shine. Reciprocal; its [`Bsdf::albedo`] is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    reflect: Spectrum,
    transmit: Spectrum,
    p_reflect: f32,
}

impl DiffuseTransmission {
    /// The parts of the light that are reflected and that pass; lanes clamped to 0..1 (NaN to 0), and scaled down
    /// together where they add up to more than 1.
    #[inline]
    pub fn new(reflect: Spectrum, transmit: Spectrum) -> Self {
        let unit = |v: f32| v.max(0.0).min(1.0);
        let (r, t) = (reflect.map(unit), transmit.map(unit));
        let scale = (r + t).map(|v| 1.0 / v.max(1.0));
        let (reflect, transmit) = (r * scale, t * scale);
        let sum = |s: Spectrum| s.0.iter().sum::<f32>();
        let all = sum(reflect) + sum(transmit);
        let p = if all > 0.0 { sum(reflect) / all } else { 1.0 };
        // A side of less than a millionth is never picked: one over its probability could leave f32.
        let p_reflect = if p < 1e-6 {
            0.0
        } else if p > 1.0 - 1e-6 {
            1.0
        } else {
            p
        };
        Self { reflect, transmit, p_reflect }
    }

    /// Value and density for a side.
    #[inline(always)]
    fn side(&self, above: bool) -> (Spectrum, f32) {
        if above { (self.reflect, self.p_reflect) } else { (self.transmit, 1.0 - self.p_reflect) }
    }
}

impl Bsdf for DiffuseTransmission {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        let (color, p) = self.side(wi.z > 0.0);
        let pdf = p * (wi.z.abs() * FRAC_1_PI);
        if pdf < f32::INFINITY {
            Eval { diffuse: color * FRAC_1_PI, specular: Spectrum::ZERO, pdf }
        } else {
            Eval::ZERO
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let above = uc.max(0.0) < self.p_reflect;
        let mut wi = cosine_hemisphere(u);
        if !(wo.z > MIN_COS && wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        let (color, p) = self.side(above);
        if !above {
            wi.z = -wi.z;
        }
        let pdf = p * (wi.z.abs() * FRAC_1_PI);
        if !(pdf > 0.0) {
            return None;
        }
        let weight = color * (1.0 / p);
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: weight,
            weight_specular: Spectrum::ZERO,
            pdf,
            delta: false,
            lobe: LobeKind::Diffuse,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { self.reflect + self.transmit } else { Spectrum::ZERO }
    }

    #[inline]
    fn refraction(&self) -> Option<f32> {
        if self.transmit.is_black() { None } else { Some(1.0) }
    }
}
