//! Phong's model.

use super::{choice, sample_of, sum, unit};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    ggx::mirror,
    math::{exp, ln, ln_1p, one_minus_exp_neg, sin_cos_tau},
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
    sampling::{Frame, cosine_hemisphere},
};
use core::f32::consts::{FRAC_1_PI, PI, TAU};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

parameters! {
    /// What a Phong surface is at a point.
    pub struct PhongParams {
        /// Colour of the matte part, each lane 0..1.
        diffuse: Spectrum = Spectrum::rgb(0.5, 0.5, 0.5), 0.0..1.0;
        /// Colour of the highlight, each lane 0..1.
        specular: Spectrum = Spectrum::rgb(0.3, 0.3, 0.3), 0.0..1.0;
        /// Exponent of the highlight, 0..10⁶: the larger, the smaller and sharper.
        exponent: f32 = 50.0, 1.0..10000.0;
        /// Divides the matte part by π and scales the highlight so that both reflect at most their colour.
        normalized: bool = true, 0.0..1.0;
    }
}

impl ModelParams for PhongParams {
    type Closure = PhongSurface;
    const ABOUT: &'static str = "a matte surface with a highlight around the mirror direction (Phong 1975; normalised by Lafortune, Willems 1994)";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Holds,
        conserves: Claim::Breaks(
            "the two colours are added whatever their sum, and without `normalized` there is no ÷π and no factor for the exponent",
        ),
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> PhongSurface {
        PhongSurface::new(self)
    }
}

/// Phong's surface: f = kd/π + ks (n + 2)/2π cosⁿα, α the angle of `wi` to the mirror direction of `wo` (Lafortune, Willems
/// 1994, "Using the Modified Phong Reflectance Model for Physically Based Rendering", eq. 2 to 6). Reciprocal; each part
/// reflects at most its colour.
///
/// Not normalised it is f = kd + ks cosⁿα, what the sum `kd · N·L + ks · (R·V)ⁿ · N·L` of shaders is as a scattering function:
/// the matte part reflects π times its colour, the highlight 2π/(n + 2) times. (Phong's own sum has no N·L in the highlight,
/// which is not reciprocal.) Its [`Bsdf::albedo`] is an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongSurface {
    diffuse: Spectrum,
    specular: Spectrum,
    exponent: f32,
    p_specular: f32,
}

impl PhongSurface {
    /// The closure of a surface; out of range is clamped, NaN counts as the lower end.
    #[inline(always)]
    pub fn new(p: &PhongParams) -> Self {
        let exponent = p.exponent.max(0.0).min(1e6);
        let (diffuse, specular) = (p.diffuse.map(unit), p.specular.map(unit));
        let lobe = (exponent + 2.0) / TAU;
        let (diffuse, specular) =
            if p.normalized { (diffuse * FRAC_1_PI, specular * lobe) } else { (diffuse, specular) };
        let p_specular = choice(sum(specular) / lobe, sum(diffuse) * PI);
        Self { diffuse, specular, exponent, p_specular }
    }

    /// Value and density; both directions above [`MIN_COS`].
    #[inline(always)]
    fn eval_above(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // cos α = 1 − |r − wi|² / 2 keeps the digits that a large exponent asks for.
        let drop = 0.5 * (mirror(wo) - wi).length_squared();
        let power = if drop < 1.0 { exp(self.exponent * ln_1p(-drop)) } else { 0.0 };
        let pdf = self.p_specular * ((self.exponent + 1.0) / TAU * power)
            + (1.0 - self.p_specular) * (wi.z * FRAC_1_PI);
        Eval { diffuse: self.diffuse, specular: self.specular * power, pdf }
    }
}

impl Bsdf for PhongSurface {
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
        let specular = uc.max(0.0) < self.p_specular;
        let wi = if specular {
            // cos α = (1 − u)^{1/(n+1)}.
            let x = -ln((1.0 - u[1]).max(1e-9).min(1.0)) / (self.exponent + 1.0);
            let sin = one_minus_exp_neg(2.0 * x).max(0.0).sqrt();
            let (s, c) = sin_cos_tau(u[0]);
            Frame::from_normal(mirror(wo)).to_world(vec3a(sin * c, sin * s, exp(-x)))
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
        self.diffuse * PI + self.specular * (TAU / (self.exponent + 2.0))
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        // exp(−n α²/2) with the half vector at α/2: as GGX of α² = 1/n near the peak.
        let a = 1.0 / (self.exponent + 1.0).sqrt();
        if self.p_specular > 0.0 { [a, a] } else { [1.0, 1.0] }
    }
}
