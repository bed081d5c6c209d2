//! Fuzz: a thin volume of fibres, as a linearly transformed cosine.
//!
//! Zeltner, Burley, Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines": light that is
//! scattered many times in a layer of fibre-like flakes was simulated, and for each angle and roughness fitted by its
//! albedo R and a cosine lobe under the linear transform
//!
//! ```text
//!       | A  0  B |
//! M⁻¹ = | 0  A  0 |     in the frame whose x axis lies under wo,  t = M⁻¹ wi
//!       | 0  0  1 |
//! f(wo, wi) cos θi = R · A² wi.z / (π |t|⁴)
//! ```
//!
//! A, B and R are functions of cos θo and roughness: here the rational fits and the Gaussian with offset that MaterialX 1.39
//! (`mx_microfacet_sheen.glsl`, Academy Software Foundation) gives for the authors' table; OpenPBR 1.1's reference uses the
//! same. The sampling is exact: each weight is R times the colour.
//!
//! # Where this departs from the fits, and why
//! A is kept above [`LEAST_A`]. Only roughness below 0.1 is touched, near grazing, where the fits make the lobe a sheet of
//! less than half a degree above the horizon, down to 8e-5 of it, thinner than directions and the lights of a scene can
//! tell; R, the light in it, is as it was.

use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    math::exp,
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
    sampling::cosine_hemisphere,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// The least A; see the module's head.
pub const LEAST_A: f32 = 0.01;

parameters! {
    /// What a layer of fibres is at a point, seen by itself: what it does not reflect goes nowhere.
    pub struct FuzzParams {
        /// Colour of the fibres, each lane 0..1.
        color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Spread of the fibres, 0 (even out of sight from above) .. 1 (seen from everywhere).
        roughness: f32 = 0.5, 0.0..1.0;
    }
}

impl ModelParams for FuzzParams {
    type Closure = Fuzz;
    const ABOUT: &'static str =
        "a layer of fibres with multiple scattering (Zeltner, Burley, Chiang 2022), OpenPBR's fuzz";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Breaks("the lobe is fitted for each wo by itself, as a transformed cosine"),
        conserves: Claim::Holds,
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> Fuzz {
        Fuzz::new(self.color, self.roughness)
    }
}

/// The fuzz lobe.
///
/// Not reciprocal. Its [`Bsdf::albedo`] is exact. It reflects only: a layer stack scales what lies below by
/// 1 − weight · [`Fuzz::reflectance`] of `wo`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fuzz {
    color: Spectrum,
    roughness: f32,
}

/// The transform for one `wo`.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    a: f32,
    b: f32,
    /// Cosine and sine of the azimuth of `wo`.
    x: [f32; 2],
}

impl Fuzz {
    /// Colour of the fibres, each lane clamped to 0..1, and roughness, clamped to 0.01..1 (the fits' range).
    #[inline]
    pub fn new(color: Spectrum, roughness: f32) -> Self {
        Self { color: color.map(|v| v.max(0.0).min(1.0)), roughness: roughness.max(0.01).min(1.0) }
    }

    /// R: the part of the light from an angle of cosine `cos` that white fibres reflect, 0..1.
    #[inline]
    pub fn reflectance(&self, cos: f32) -> f32 {
        let (x, y) = (cos.max(0.0).min(1.0), self.roughness);
        let width = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
        let middle = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
        let offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y));
        let z = (x - middle) / width;
        // 1/√(2π).
        const NORM: f32 = 0.398_942_3;
        (NORM / width * exp(-0.5 * z * z) + offset).max(0.0).min(1.0)
    }

    #[inline(always)]
    fn lobe(&self, wo: Vec3A) -> Lobe {
        let (x, y) = (wo.z.max(0.0).min(1.0), self.roughness);
        let a = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y);
        let b = (1.0 - x).sqrt() * (y - 1.0) * y * y * y
            / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
        let len2 = wo.x * wo.x + wo.y * wo.y;
        let x = if len2 > 0.0 {
            let inv = 1.0 / len2.sqrt();
            [wo.x * inv, wo.y * inv]
        } else {
            [1.0, 0.0]
        };
        Lobe { a: a.max(LEAST_A), b, x }
    }
}

impl Bsdf for Fuzz {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let l = self.lobe(wo);
        let x = l.x[0] * wi.x + l.x[1] * wi.y;
        let y = l.x[0] * wi.y - l.x[1] * wi.x;
        let t = vec3a(l.a * x + l.b * wi.z, l.a * y, wi.z);
        let q = l.a / t.length_squared();
        // The density without its cosine.
        let shape = q * q * FRAC_1_PI;
        let pdf = shape * wi.z;
        if !(shape < f32::INFINITY && pdf < f32::INFINITY) {
            return Eval::ZERO;
        }
        Eval { diffuse: self.color * (self.reflectance(wo.z) * shape), specular: Spectrum::ZERO, pdf }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, _uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let l = self.lobe(wo);
        let h = cosine_hemisphere(u);
        // M times a, which is one length with M after normalisation.
        let w = vec3a(h.x - l.b * h.z, h.y, l.a * h.z);
        let w = w * (1.0 / w.length_squared().sqrt());
        let wi = vec3a(l.x[0] * w.x - l.x[1] * w.y, l.x[1] * w.x + l.x[0] * w.y, w.z);
        if !(wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        let e = self.eval_pdf(wo, wi);
        if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
            return None;
        }
        let weight = self.color * self.reflectance(wo.z);
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: weight,
            weight_specular: Spectrum::ZERO,
            pdf: e.pdf,
            delta: false,
            lobe: LobeKind::Diffuse,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { self.color * self.reflectance(wo.z) } else { Spectrum::ZERO }
    }
}
