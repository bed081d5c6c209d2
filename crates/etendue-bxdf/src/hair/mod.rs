//! Hair and fur: how a fibre scatters light.
//!
//! Chiang, Bitterli, Tappan, Burley 2016, "A Practical and Controllable Hair and Fur Model for Production Path Tracing":
//!
//! ```text
//! F(ωo, ωi) = Σp Ap(ωo) Mp(θo, θi) Np(φ),   p = 0 (R), 1 (TT), 2 (TRT), and all that follows as one
//! ```
//!
//! Ap is the part of the light that takes p paths inside the fibre, Mp spreads it along and Np around the fibre.
//!
//! # The frame
//! Local +X runs along the fibre, from root to tip; θ is the angle of a direction to the plane perpendicular to it
//! (sin θ = x), φ its angle around the fibre. +Z is any perpendicular direction that faces `wo`: the model only depends on
//! the difference of φ, and on `h`, the offset at which light that goes to `wo` left the fibre: −1 at one silhouette, 0 on the
//! axis, 1 at the other. If +Z is the normal of a round fibre at the point, [`Hair::offset_at`] gives it.
//!
//! # The cosine
//! A BCSDF S is per projected radiance on the fibre: L(ωo) = ∫ S(ωo, ωi) L(ωi) cosθi dωi, with θi to the normal plane and S =
//! F / cosθi. The contract multiplies by |ωi·z|, which means nothing for a fibre. So `eval` returns
//!
//! ```text
//! f = S · cosθi / |ωi·z| = F / |ωi·z|
//! ```
//!
//! and whoever multiplies by |ωi·z| gets the fibre's integral. Hair scatters over the whole sphere: ωi·z < 0 is "transmission".
//! Of the light, the millionth within [`MIN_COS`] of the plane z = 0 is lost.

mod azimuthal;
mod longitudinal;
mod pigment;

pub use pigment::{absorption_from_color, absorption_from_melanin};

use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    choices, fresnel,
    math::{asin, atan2_turns, exp, sin_cos_tau},
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
};
use azimuthal::Azimuthal;
use core::f32::consts::TAU;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use longitudinal::{Inclination, Longitudinal};

choices! {
    /// What says how much a fibre absorbs.
    pub enum Pigment {
        /// `color`: how hair looks as a whole.
        Color = "color",
        /// `eumelanin` and `pheomelanin`.
        Melanin = "melanin",
        /// `absorption` itself.
        Absorption = "absorption",
    }
}

parameters! {
    /// What a fibre is at a point.
    ///
    /// Out of range is clamped, NaN to the lower end.
    pub struct HairParams {
        /// What says how much the fibre absorbs: color, melanin or absorption.
        pigment: Pigment = Pigment::Color, 0.0..1.0;
        /// Colour of the hair as a whole, each lane 0..1.
        color: Spectrum = Spectrum::rgb(0.35, 0.2, 0.1), 0.0..1.0;
        /// Concentration of eumelanin (black, brown), ≥ 0.
        eumelanin: f32 = 1.3, 0.0..8.0;
        /// Concentration of pheomelanin (red, yellow), ≥ 0.
        pheomelanin: f32 = 0.0, 0.0..8.0;
        /// Absorption per fibre radius, ≥ 0.
        absorption: Spectrum = Spectrum::rgb(0.06, 0.1, 0.2), 0.0..10.0;
        /// Roughness along the fibre βM, 0.01..1.
        beta_m: f32 = 0.3, 0.01..1.0;
        /// Roughness around the fibre βN, 0.01..1.
        beta_n: f32 = 0.3, 0.01..1.0;
        /// Tilt of the scales on the fibre, degrees.
        alpha: f32 = 2.0, 0.0..10.0;
        /// Index of refraction, 1..4.
        eta: f32 = 1.55, 1.0..4.0;
        /// Where across the fibre the light leaves: −1 and 1 at the silhouettes, 0 on the axis.
        h: f32 = 0.0, -1.0..1.0;
    }
}

impl ModelParams for HairParams {
    type Closure = Hair;
    const ABOUT: &'static str = "a hair or fur fibre along local x (Chiang, Bitterli, Tappan, Burley 2016)";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Breaks(
            "the offset h, the tilt of the scales and the attenuation belong to wo alone, and f is divided by the \
             cosine of wi to a z axis that means nothing to a fibre",
        ),
        conserves: Claim::Holds,
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> Hair {
        Hair::new(self)
    }
}

/// Lobes: R, TT, TRT, and the rest.
const LOBES: usize = 4;
/// Below this roughness a lobe would be narrower than is worth its noise.
const MIN_BETA: f32 = 0.01;

/// The closure of a fibre at a point.
///
/// ```
/// use etendue_bxdf::{Bsdf, hair::{Hair, HairParams, Pigment}};
/// use glam::Vec3A;
///
/// let wo = Vec3A::new(0.0, 0.6, 0.8);
/// let blond = Hair::new(&HairParams {
///     pigment: Pigment::Melanin,
///     eumelanin: 0.3,
///     h: Hair::offset_at(wo),
///     ..Default::default()
/// });
/// let [red, _, blue] = blond.albedo(wo).to_rgb();
/// assert!(red > blue && red < 1.0);
/// ```
///
/// Not reciprocal (see [`HairParams`]'s claims). Its [`Bsdf::albedo`] is exact: a fibre without absorption returns all light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hair {
    absorption: Spectrum,
    eta: f32,
    h: f32,
    cos_gamma_o: f32,
    /// Angle to the normal where the light leaves, in turns.
    gamma_o: f32,
    /// Sine and cosine of the turn of θo for R, TT and TRT: −2α, α, 4α.
    tilt: [[f32; 2]; 3],
    /// Of R, TT and TRT; the rest has TRT's.
    along: [Longitudinal; 3],
    around: Azimuthal,
}

/// What depends on `wo` alone.
struct View {
    o: Inclination,
    /// What each lobe keeps of the light.
    attenuation: [Spectrum; LOBES],
    /// With which probability each is drawn.
    probability: [f32; LOBES],
    /// Where R, TT and TRT leave, in turns around the fibre from `wo`.
    exit: [f32; 3],
}

#[inline(always)]
fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}

impl Hair {
    /// The closure of a fibre.
    pub fn new(p: &HairParams) -> Self {
        let clamp = |x: f32, low: f32, high: f32| x.max(low).min(high);
        let (beta_m, beta_n) = (clamp(p.beta_m, MIN_BETA, 1.0), clamp(p.beta_n, MIN_BETA, 1.0));
        let absorption = match p.pigment {
            Pigment::Color => absorption_from_color(p.color, beta_n),
            Pigment::Melanin => absorption_from_melanin(p.eumelanin, p.pheomelanin),
            Pigment::Absorption => p.absorption.map(|v| clamp(v, 0.0, 1e4)),
        };
        // Chiang et al. 2016, eq. 7 (variance along) and 8 (logistic scale around).
        let m = 0.726 * beta_m + 0.812 * beta_m * beta_m + 3.7 * power(beta_m, 20);
        let v = m * m;
        const ROOT_PI_8: f32 = 0.626_657_07;
        let s = ROOT_PI_8 * (0.265 * beta_n + 1.194 * beta_n * beta_n + 5.372 * power(beta_n, 22));
        let h = clamp(p.h, -1.0, 1.0);
        let alpha = clamp(p.alpha, -45.0, 45.0) * (1.0 / 360.0);
        let tilt = |turns: f32| {
            let (sin, cos) = sin_cos_tau(turns);
            [sin, cos]
        };
        Self {
            absorption,
            eta: clamp(p.eta, 1.0, 4.0),
            h,
            cos_gamma_o: ((1.0 - h) * (1.0 + h)).sqrt(),
            gamma_o: asin(h) / TAU,
            tilt: [tilt(-2.0 * alpha), tilt(alpha), tilt(4.0 * alpha)],
            along: [Longitudinal::new(v), Longitudinal::new(0.25 * v), Longitudinal::new(4.0 * v)],
            around: Azimuthal::new(s),
        }
    }

    /// The offset h of a point on a round fibre, if the frame's +Z is the fibre's normal there: minus the sine of the angle by
    /// which `wo`, seen along the fibre, leans from the normal towards +Y.
    pub fn offset_at(wo: Vec3A) -> f32 {
        let across = (wo.y * wo.y + wo.z * wo.z).sqrt();
        // Also taken by NaN.
        if across > 0.0 { (-wo.y / across).max(-1.0).min(1.0) } else { 0.0 }
    }

    fn view(&self, wo: Vec3A) -> View {
        let o = inclination(wo);
        // The direction inside, and the offset there by the index that a section sees (Bravais; Marschner et al. 2003, eq. 2).
        let sin_t = o.sin / self.eta;
        let cos_t = ((1.0 - sin_t) * (1.0 + sin_t)).max(0.0).sqrt();
        let bravais = ((self.eta - o.sin) * (self.eta + o.sin)).max(0.0).sqrt() / o.cos;
        let sin_gamma = (self.h / bravais).max(-1.0).min(1.0);
        let cos_gamma = ((1.0 - sin_gamma) * (1.0 + sin_gamma)).sqrt();
        let gamma_t = asin(sin_gamma) / TAU;

        let path = 2.0 * cos_gamma / cos_t.max(1e-6);
        let through = self.absorption.map(|a| exp(-a * path));
        let f = fresnel::dielectric(o.cos * self.cos_gamma_o, self.eta);
        let tt = through * ((1.0 - f) * (1.0 - f));
        let trt = tt * through * f;
        // The geometric series of all longer paths. It only divides zero by zero, at the silhouette.
        let rest = Spectrum(core::array::from_fn(|i| {
            let t = through[i] * f;
            trt[i] * t / (1.0 - t).max(1e-12)
        }));
        let attenuation = [Spectrum::splat(f), tt, trt, rest];
        let weights = attenuation.map(sum);
        let all = (weights[0] + weights[1]) + (weights[2] + weights[3]);
        // Without an interface everything may be absorbed: then any lobe will do.
        let probability = if all > 0.0 { weights.map(|w| w / all) } else { [1.0, 0.0, 0.0, 0.0] };
        let exit = core::array::from_fn(|p| {
            let p = p as f32;
            2.0 * p * gamma_t - 2.0 * self.gamma_o + 0.5 * p
        });
        View { o, attenuation, probability, exit }
    }

    /// θo as lobe p sees it.
    #[inline(always)]
    fn tilted(&self, o: Inclination, p: usize) -> Inclination {
        if p < 3 { o.turned(self.tilt[p]) } else { o }
    }

    /// F (per steradian, the fibre's cosine in it) and the density of `wi`.
    fn scatter(&self, view: &View, wo: Vec3A, wi: Vec3A) -> (Spectrum, f32) {
        let i = inclination(wi);
        // φi − φo by one arc tangent; φ is atan2(z, y).
        let phi = atan2_turns(wo.y * wi.z - wo.z * wi.y, wo.y * wi.y + wo.z * wi.z);
        let (mut value, mut pdf) = (Spectrum::ZERO, 0.0);
        for p in 0..LOBES {
            let m = self.along[p.min(2)].eval(i, self.tilted(view.o, p));
            let n = if p < 3 { self.around.eval(phi - view.exit[p]) } else { 1.0 / TAU };
            value += view.attenuation[p] * (m * n);
            pdf += view.probability[p] * (m * n);
        }
        (value, pdf)
    }
}

/// Sine and cosine to the normal plane; the cosine by the other two coordinates, which keeps its digits near the fibre.
#[inline(always)]
fn inclination(w: Vec3A) -> Inclination {
    Inclination { sin: w.x, cos: (w.y * w.y + w.z * w.z).sqrt() }
}

/// xⁿ by squaring.
fn power(x: f32, n: u32) -> f32 {
    let (mut result, mut square, mut n) = (1.0, x, n);
    while n > 0 {
        if n & 1 == 1 {
            result *= square;
        }
        square *= square;
        n >>= 1;
    }
    result
}

impl Bsdf for Hair {
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS && wo.is_finite() && wi.is_finite()) {
            return Eval::ZERO;
        }
        let (value, pdf) = self.scatter(&self.view(wo), wo, wi);
        let specular = value * (1.0 / wi.z.abs());
        if specular.is_finite() && pdf.is_finite() {
            Eval { diffuse: Spectrum::ZERO, specular, pdf }
        } else {
            Eval::ZERO
        }
    }

    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let view = self.view(wo);
        // `uc` picks the lobe; what is left of it is even again, and gives the angle around the lobe's axis.
        let mut rest = uc.max(0.0).min(0.999_999_94);
        let mut lobe = 0;
        for (p, &probability) in view.probability.iter().enumerate() {
            if probability > 0.0 {
                lobe = p;
                if rest < probability {
                    break;
                }
                rest -= probability;
            }
        }
        rest = (rest / view.probability[lobe]).max(0.0).min(1.0);
        let i = self.along[lobe.min(2)].sample(self.tilted(view.o, lobe), [u[0], rest]);
        let around = u[1].max(0.0).min(1.0);
        let turns = if lobe < 3 { view.exit[lobe] + self.around.sample(around) } else { around };
        // wo turned around the fibre by φ, at the drawn inclination.
        let (sin, cos) = sin_cos_tau(turns);
        let scale = i.cos / view.o.cos;
        let wi = vec3a(i.sin, (wo.y * cos - wo.z * sin) * scale, (wo.y * sin + wo.z * cos) * scale);
        if !(wi.z.abs() > MIN_COS && wi.is_finite()) {
            return None;
        }
        let wi = wi.normalize();
        let (value, pdf) = self.scatter(&view, wo, wi);
        let weight = value * (1.0 / pdf);
        if !(pdf > 0.0 && pdf < f32::INFINITY && weight.is_finite() && wi.z.abs() > MIN_COS) {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf,
            delta: false,
            lobe: LobeKind::Specular,
        })
    }

    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return Spectrum::ZERO;
        }
        let [a, b, c, d] = self.view(wo).attenuation;
        (a + b) + (c + d)
    }

    /// TT's width along the fibre, and the logistic's around it, each as the half vector sees it.
    fn narrowest_alpha(&self) -> [f32; 2] {
        let (m, n) = self.widths();
        [m.min(1.0), n.min(1.0)]
    }

    /// Light passes to the far side, straight on if at all in a preferred direction.
    fn refraction(&self) -> Option<f32> {
        Some(1.0)
    }
}

impl Hair {
    /// Half the widths, radians, of the narrowest lobe along and around the fibre.
    fn widths(&self) -> (f32, f32) {
        (0.5 * self.along[1].variance().sqrt(), self.around.scale())
    }
}
