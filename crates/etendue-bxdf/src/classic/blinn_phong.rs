//! Blinn's variant of Phong's model.

use super::{choice, sample_of, sum, unit};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    math::exp2,
    microfacet::{BlinnPhong, Distribution},
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
    sampling::cosine_hemisphere,
};
use core::f32::consts::{FRAC_1_PI, PI, TAU};
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What a Blinn-Phong surface is at a point.
    pub struct BlinnPhongParams {
        /// Colour of the matte part, each lane 0..1.
        diffuse: Spectrum = Spectrum::rgb(0.5, 0.5, 0.5), 0.0..1.0;
        /// Colour of the highlight, each lane 0..1.
        specular: Spectrum = Spectrum::rgb(0.3, 0.3, 0.3), 0.0..1.0;
        /// Exponent of the highlight, 0..10⁶: about four times Phong's for the same size.
        exponent: f32 = 200.0, 1.0..10000.0;
        /// Divides the matte part by π and scales the highlight so that both reflect at most their colour.
        normalized: bool = true, 0.0..1.0;
    }
}

impl ModelParams for BlinnPhongParams {
    type Closure = BlinnPhongSurface;
    const ABOUT: &'static str = "a matte surface with a highlight where the half vector nears the normal (Blinn 1977; normalised by Giesen 2009)";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Holds,
        conserves: Claim::Breaks(
            "the two colours are added whatever their sum, and without `normalized` there is no ÷π and no factor for the exponent",
        ),
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> BlinnPhongSurface {
        BlinnPhongSurface::new(self)
    }
}

/// Blinn's surface: f = kd/π + ks N cosⁿθh, θh the half vector's angle to the normal, N = (n + 2)(n + 4) / (8π (2^{−n/2} + n))
/// (Giesen 2009, "Phong Normalization Factor derivation"): what makes the highlight of ks = 1 reflect everything at normal
/// incidence, and less elsewhere. Reciprocal.
///
/// ((n + 2)/2π, often written here, normalises the *distribution* of half vectors, and (n + 8)/8π is an approximation of N.)
/// Not normalised it is f = kd + ks cosⁿθh, what the sum `kd · N·L + ks · (N·H)ⁿ · N·L` of shaders is as a scattering function. Its
/// [`Bsdf::albedo`] is an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlinnPhongSurface {
    half: BlinnPhong,
    diffuse: Spectrum,
    /// The highlight over D.
    specular: Spectrum,
    p_specular: f32,
}

impl BlinnPhongSurface {
    /// The closure of a surface; out of range is clamped, NaN counts as the lower end.
    #[inline(always)]
    pub fn new(p: &BlinnPhongParams) -> Self {
        let half = BlinnPhong::from_exponent(p.exponent.max(0.0).min(1e6));
        let n = half.exponent();
        let factor = (n + 2.0) * (n + 4.0) / (8.0 * PI * (exp2(-0.5 * n) + n));
        let (diffuse, specular) = (p.diffuse.map(unit), p.specular.map(unit));
        let (diffuse, specular) =
            if p.normalized { (diffuse * FRAC_1_PI, specular * factor) } else { (diffuse, specular) };
        let p_specular = choice(sum(specular) / factor, sum(diffuse) * PI);
        Self { half, diffuse, specular: specular * (TAU / (n + 2.0)), p_specular }
    }

    /// Value and density; both directions above [`MIN_COS`].
    #[inline(always)]
    fn eval_above(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let h = wo + wi;
        let d = self.half.d(h);
        // The distribution's normals as V-cavities show them, reflected: D G1 / (4 cos θo).
        let pdf = self.p_specular * (0.25 * d * self.half.visible_g1(wo, h) / wo.z)
            + (1.0 - self.p_specular) * (wi.z * FRAC_1_PI);
        Eval { diffuse: self.diffuse, specular: self.specular * d, pdf }
    }
}

impl Bsdf for BlinnPhongSurface {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let e = self.eval_above(wo, wi);
        if e.pdf < f32::INFINITY { e } else { Eval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let uc = uc.max(0.0);
        let specular = uc < self.p_specular;
        let wi = if specular {
            let m = self.half.sample_visible(wo, uc / self.p_specular, u);
            m * (2.0 * wo.dot(m)) - wo
        } else {
            cosine_hemisphere(u)
        };
        if !(wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        sample_of(self.eval_above(wo, wi), wi, if specular { LobeKind::Specular } else { LobeKind::Diffuse })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let n = self.half.exponent();
        self.diffuse * PI + self.specular * (4.0 * (exp2(-0.5 * n) + n) / (n + 4.0))
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.p_specular > 0.0 { self.half.alpha() } else { [1.0, 1.0] }
    }
}
