//! Clipped linearly transformed cosines: a density over the hemisphere that follows rough diffuse lobes.
//!
//! A cosine lobe is clipped by a plane and carried by a 3×3 matrix M so that it fills the upper hemisphere exactly
//! (Portsmouth, Kutz, Hill 2024, "EON: A practical energy-preserving rough diffuse BRDF", section 4): unlike a plain
//! linear transform (Heitz, Dupuy, Hill, Neubelt 2016) no sample falls below the horizon. A small uniform part bounds
//! the weights.

use crate::{
    math::{exp2, ln},
    sampling::{concentric_disk, uniform_hemisphere},
};
use core::f32::consts::{FRAC_1_PI, LOG2_E, TAU};
use glam::{Vec3A, vec3a};

/// The density for one roughness: found once for a closure, then asked for directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cltc {
    r: f32,
    /// r^0.1.
    uniform: f32,
}

/// What depends on `wo` alone.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    /// M = [[a, 0, b], [0, c, 0], [d, 0, 1]] in the frame whose x axis lies under `wo`.
    a: f32,
    b: f32,
    c: f32,
    d: f32,
    /// What clipping leaves of the cosine lobe: (1 + 1 / √(1 + d²)) / 2.
    kept: f32,
    /// Cosine and sine of the azimuth of `wo`.
    x: [f32; 2],
    p_uniform: f32,
}

impl Cltc {
    /// Roughness 0 (a cosine lobe) .. 1; NaN as 0.
    #[inline]
    pub fn new(roughness: f32) -> Self {
        let r = roughness.max(0.0).min(1.0);
        let uniform = if r > 0.0 { exp2(0.1 * LOG2_E * ln(r)) } else { 0.0 };
        Self { r, uniform }
    }

    /// The fits of the paper's listing 3 (matrix) and 4 (share of the uniform part).
    #[inline(always)]
    fn lobe(&self, wo: Vec3A) -> Lobe {
        let (r, mu) = (self.r, wo.z.max(0.0).min(1.0));
        let a = 1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu + (-0.276266 + 0.335918 * mu) * r);
        let b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r) / (mu * mu * mu - 1.43545);
        let c = 1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r;
        let d = r * (0.540852 + (-1.01625 + 0.475392 * mu) * mu) / (-1.0743 + mu * (0.0725628 + mu));
        // The clip is on the right side for d ≤ 0 only; the fit passes zero by 0.004 at mu = 1.
        let d = d.min(0.0);
        let len2 = wo.x * wo.x + wo.y * wo.y;
        let x = if len2 > 0.0 {
            let inv = 1.0 / len2.sqrt();
            [wo.x * inv, wo.y * inv]
        } else {
            [1.0, 0.0]
        };
        let kept = 0.5 + 0.5 / (1.0 + d * d).sqrt();
        let p_uniform = self.uniform * (0.162925 + mu * (-0.372058 + (0.538233 - 0.290822 * mu) * mu));
        Lobe { a, b, c, d, kept, x, p_uniform }
    }

    /// Density of [`Cltc::sample`], per steradian; both directions above the horizon.
    #[inline(always)]
    pub fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let l = self.lobe(wo);
        let x = l.x[0] * wi.x + l.x[1] * wi.y;
        let y = l.x[0] * wi.y - l.x[1] * wi.x;
        // The adjugate of M: det(M) M⁻¹ wi.
        let t = l.a - l.b * l.d;
        let h = vec3a(l.c * (x - l.b * wi.z), t * y, l.c * (l.a * wi.z - l.d * x));
        let (det, len2) = (l.c * t, h.length_squared());
        let q = det / len2;
        let transformed = q * q * h.z.max(0.0) * FRAC_1_PI / l.kept;
        l.p_uniform * (1.0 / TAU) + (1.0 - l.p_uniform) * transformed
    }

    /// A direction of the upper hemisphere; `uc` picks the part.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        let l = self.lobe(wo);
        if uc < l.p_uniform {
            return uniform_hemisphere(u);
        }
        let [x, y] = concentric_disk(u);
        // A chord of the disk is scaled to what the clip leaves of it: from −q to q / √(1 + d²).
        let chord = (1.0 - y * y).max(0.0).sqrt();
        let x = -(chord + (x - chord) * l.kept);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let w = vec3a(l.a * x + l.b * z, l.c * y, l.d * x + z);
        let w = w * (1.0 / w.length_squared().sqrt());
        vec3a(l.x[0] * w.x - l.x[1] * w.y, l.x[1] * w.x + l.x[0] * w.y, w.z)
    }
}
