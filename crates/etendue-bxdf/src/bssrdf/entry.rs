//! How light enters the surface at the far end of a probe.

use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    fresnel, sampling,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::Vec3A;

/// The directional part of a separable BSSRDF, Sw(wi) = (1 − F(cos θi)) / (π c), with c such that ∫ Sw cos θ dω = 1
/// (Pharr, Jakob, Humphreys, "Physically Based Rendering" 3rd ed., eq. 11.7 and 11.8).
///
/// A diffuse lobe of albedo 1 for each `wo`, which only has to lie above the surface: where the light leaves the surface is
/// another place, with another frame. **Not reciprocal**: it is one end of a function of two points. With the index 1
/// it is Lambert's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EntryLobe {
    eta: f32,
    /// 1 / c.
    scale: f32,
}

/// Nodes and weights of Gauss-Legendre quadrature on 0..1, eight of them (Abramowitz, Stegun table 25.4, moved from −1..1).
const NODES: [(f32, f32); 8] = [
    (0.019_855_07, 0.050_614_27),
    (0.101_666_76, 0.111_190_52),
    (0.237_233_8, 0.156_853_32),
    (0.408_282_68, 0.181_341_9),
    (0.591_717_3, 0.181_341_9),
    (0.762_766_2, 0.156_853_32),
    (0.898_333_25, 0.111_190_52),
    (0.980_144_9, 0.050_614_27),
];

impl EntryLobe {
    /// For a surface with the index of refraction `eta` relative to its surroundings, clamped to 1..4; NaN counts as 1.
    pub fn new(eta: f32) -> Self {
        let eta = eta.max(1.0).min(4.0);
        // c = ∫ (1 − F(μ)) 2μ dμ; with μ = t² the nodes are dense at grazing angles, where F is steep.
        let c = NODES.iter().fold(0.0, |sum, &(t, w)| {
            let mu = t * t;
            sum + w * 4.0 * t * mu * (1.0 - fresnel::dielectric(mu, eta))
        });
        Self { eta, scale: 1.0 / c }
    }

    /// c: the part of even light that enters.
    pub fn entering(&self) -> f32 {
        1.0 / self.scale
    }

    /// Sw · π.
    #[inline(always)]
    fn factor(&self, cos: f32) -> f32 {
        self.scale * (1.0 - fresnel::dielectric(cos, self.eta))
    }
}

impl Bsdf for EntryLobe {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let value = Spectrum::splat(self.factor(wi.z) * FRAC_1_PI);
        Eval { diffuse: value, specular: Spectrum::ZERO, pdf: wi.z * FRAC_1_PI }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, _uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = sampling::cosine_hemisphere(u);
        if !(wo.z > MIN_COS && wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        let weight = Spectrum::splat(self.factor(wi.z));
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: weight,
            weight_specular: Spectrum::ZERO,
            pdf: wi.z * FRAC_1_PI,
            delta: false,
            lobe: LobeKind::Diffuse,
        })
    }

    /// One; within 2e-4 of the integral, which is what the quadrature of c misses.
    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { Spectrum::ONE } else { Spectrum::ZERO }
    }
}
