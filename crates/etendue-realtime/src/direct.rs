//! Light from one direction.

use crate::choices::{Choices, Coupling, DirectPi, Masking, Matte};
use crate::surface::Surface;
use etendue_bxdf::MIN_COS;
use etendue_bxdf::fresnel::{pow5, schlick_weight};
use etendue_color::Spectrum;
use glam::Vec3A;
use std::f32::consts::{FRAC_1_PI, PI};

/// The surface's value at a pair of directions, and what it is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// f of the diffuse part, 1/sr.
    pub diffuse: Spectrum,
    /// f of the specular part, 1/sr.
    pub specular: Spectrum,
    pub nl: f32,
    pub hv: f32,
    pub d: f32,
    pub f: Spectrum,
    pub g: f32,
    pub kd: Spectrum,
}

/// D, and D · V with V = G / (4 NL NV).
#[inline(always)]
fn distribution_and_masking(s: &Surface, wi: Vec3A, masking: Masking) -> (f32, f32) {
    let (nv, nl) = (s.wo.z, wi.z);
    match masking {
        Masking::Smith => {
            if s.mirror {
                return (0.0, 0.0);
            }
            let d = s.ggx.d_along(s.wo + wi);
            (d, s.ggx.pair(s.wo, wi).value)
        }
        Masking::Fast => {
            let d = s.ggx.d_along(s.wo + wi);
            let a = s.roughness * s.roughness;
            (d, d * 0.5 / (2.0 * nl * nv * (1.0 - a) + (nl + nv) * a).max(1e-5))
        }
        Masking::Schlick => {
            let d = s.ggx.d_along(s.wo + wi);
            let k = schlick_k(s.roughness);
            (d, d * 0.25 / ((nv * (1.0 - k) + k) * (nl * (1.0 - k) + k)))
        }
        Masking::Notes => {
            // The helmet shader line by line, with its guards; a guard keeps D of a smooth surface from its peak.
            let a = s.roughness * s.roughness;
            let a2 = a * a;
            let nh = (s.wo + wi).normalize_or_zero().z.max(0.0);
            let denominator = nh * nh * (a2 - 1.0) + 1.0;
            let d = a2 / (PI * denominator * denominator).max(1e-5);
            let k = schlick_k(s.roughness);
            let g1 = |cos: f32| cos / (cos * (1.0 - k) + k).max(1e-5);
            (d, d * g1(nv) * g1(nl) / (4.0 * nv * nl).max(1e-4))
        }
    }
}

/// Karis' k for lights: (roughness + 1)² / 8.
#[inline(always)]
fn schlick_k(roughness: f32) -> f32 {
    let a = roughness + 1.0;
    a * a / 8.0
}

/// Value for light from `wi` (local); `None` below the horizon.
#[inline]
pub(crate) fn pair(s: &Surface, wi: Vec3A, choices: &Choices) -> Option<Pair> {
    if !(wi.z > MIN_COS) {
        return None;
    }
    let hv = 0.5 * (s.wo + wi).length();
    let w = schlick_weight(hv);
    let (d, dv) = distribution_and_masking(s, wi, choices.masking);
    let f = s.fresnel(w);
    let mut specular = s.compensated(w) * dv;
    if !s.bounces.wide.is_black() {
        specular += s.bounces.wide * (s.bounces.lost * s.bounces.loss.directional(wi.z));
    }
    let kd = match choices.coupling {
        Coupling::Albedo => Spectrum::splat(s.through * s.through_at(wi.z) * s.inv_through_average),
        Coupling::OneMinusF => Spectrum::ONE - f,
        Coupling::OneMinusF0 => Spectrum::splat(1.0 - s.under[0]),
        Coupling::Filament | Coupling::Whole => Spectrum::ONE,
    };
    let kd = match choices.matte {
        Matte::Lambert => kd,
        Matte::Disney => {
            let fd90 = 0.5 + 2.0 * hv * hv * s.roughness;
            let bend = |cos: f32| 1.0 + (fd90 - 1.0) * pow5((1.0 - cos).max(0.0));
            kd * (bend(s.wo.z) * bend(wi.z))
        }
    };
    let over_pi = match choices.direct_pi {
        DirectPi::Once => FRAC_1_PI,
        DirectPi::Never => 1.0,
    };
    let g = if d > 0.0 { dv / d * (4.0 * s.wo.z * wi.z) } else { 0.0 };
    Some(Pair { diffuse: s.matte * kd * over_pi, specular, nl: wi.z, hv, d, f, g, kd })
}
