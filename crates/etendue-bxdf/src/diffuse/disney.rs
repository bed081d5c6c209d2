//! Disney's diffuse surface.
//!
//! Burley 2012, "Physically Based Shading at Disney", section 5.3: a Fresnel factor fitted to measured materials that
//! darkens smooth surfaces towards grazing and brightens rough ones where light comes from behind the eye:
//!
//! ```text
//! f = c/π (1 + (F90 − 1)(1 − µi)⁵)(1 + (F90 − 1)(1 − µo)⁵),   F90 = 1/2 + 2 r cos²θd
//! ```
//!
//! with θd half of the angle between the two directions. (Retellings sometimes lose the fifth power; then even a surface seen
//! from 45° is half darkened.) Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering",
//! eq. 4, splits it into a Lambert part, which subsurface scattering may replace, and a retro-reflection:
//!
//! ```text
//! f = c/π (1 − (1 − µi)⁵/2)(1 − (1 − µo)⁵/2) + f_retro
//! f_retro = c/π R ((1 − µi)⁵ + (1 − µo)⁵ + (1 − µi)⁵ (1 − µo)⁵ (R − 1)),   R = 2 r cos²θd
//! ```
//!
//! The two are the same function, term by term. The flat form, for thin skin over scattering, follows Hanrahan, Krueger 1993
//! (Lommel-Seeliger's 1/(µo + µi)), as published with the 2012 model:
//!
//! ```text
//! f = 1.25 c/π (F (1/(µo + µi) − 1/2) + 1/2),   F as the product above with F90 = r cos²θd
//! ```

use super::{
    cltc::Cltc,
    eon::{diffuse_eval, diffuse_sample},
};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, MIN_COS},
    fresnel::schlick_weight,
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
    sampling::uniform_hemisphere,
};
use core::f32::consts::{FRAC_1_PI, TAU};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What the forms need of a pair of directions above the surface.
#[derive(Clone, Copy, Debug)]
pub struct DisneyPair {
    /// (1 − µo)⁵.
    pub fo: f32,
    /// (1 − µi)⁵.
    pub fi: f32,
    /// cos²θd.
    pub cos2_d: f32,
    /// µo + µi.
    pub sum: f32,
}

impl DisneyPair {
    /// From unit directions above the surface.
    #[inline(always)]
    pub fn new(wo: Vec3A, wi: Vec3A) -> Self {
        Self {
            fo: schlick_weight(wo.z),
            fi: schlick_weight(wi.z),
            // |wo + wi|² = 4 cos²θd.
            cos2_d: (0.25 * (wo + wi).length_squared()).min(1.0),
            sum: wo.z + wi.z,
        }
    }

    /// π f / c of the 2012 base form.
    #[inline(always)]
    pub fn base(&self, roughness: f32) -> f32 {
        let a = 2.0 * roughness * self.cos2_d - 0.5;
        (1.0 + a * self.fo) * (1.0 + a * self.fi)
    }

    /// π f / c of the Lambert part of 2015.
    #[inline(always)]
    pub fn lambert(&self) -> f32 {
        (1.0 - 0.5 * self.fo) * (1.0 - 0.5 * self.fi)
    }

    /// π f / c of the retro-reflection of 2015; may be less than zero, by up to 1/4, where R < 1 and both graze.
    #[inline(always)]
    pub fn retro(&self, roughness: f32) -> f32 {
        let r = 2.0 * roughness * self.cos2_d;
        r * (self.fo + self.fi + self.fo * self.fi * (r - 1.0))
    }

    /// π f / c of the flat form.
    #[inline(always)]
    pub fn flat(&self, roughness: f32) -> f32 {
        let a = roughness * self.cos2_d - 1.0;
        let f = (1.0 + a * self.fo) * (1.0 + a * self.fi);
        1.25 * (f * (1.0 / self.sum - 0.5) + 0.5)
    }
}

/// Albedo of the base form at c = 1: with 2 cos²θd = 1 + wo·wi everything is a polynomial in µi, integrated term by term.
#[inline]
pub fn base_albedo(mu: f32, roughness: f32) -> f32 {
    let (mu, r) = (mu.max(0.0).min(1.0), roughness);
    let f = schlick_weight(mu);
    // ∫ 2µ^(k+1) (1 − µ)⁵ dµ.
    const B: [f32; 3] = [1.0 / 21.0, 1.0 / 84.0, 1.0 / 252.0];
    let s2 = (1.0 - mu) * (1.0 + mu);
    let h = r - 0.5;
    let first = h * B[0] + r * mu * B[1];
    let view = f * (h + r * mu * (2.0 / 3.0));
    let both = h * h * B[0] + 2.0 * h * r * mu * B[1] + r * r * (mu * mu * B[2] + 0.5 * s2 * (B[0] - B[2]));
    1.0 + first + view + f * both
}

/// Albedo of the flat form at c = 1, by five nodes over µi at the mean azimuth: within 0.05, and within 0.01 for µ > 0.1.
#[inline]
pub fn flat_albedo(mu: f32, roughness: f32) -> f32 {
    // Gauss-Legendre on 0..1 (Abramowitz, Stegun table 25.4).
    const NODES: [[f32; 2]; 5] = [
        [0.046_910_077, 0.118_463_44],
        [0.230_765_34, 0.239_314_34],
        [0.5, 0.284_444_44],
        [0.769_234_66, 0.239_314_34],
        [0.953_089_92, 0.118_463_44],
    ];
    let mu = mu.max(0.0).min(1.0);
    let fo = schlick_weight(mu);
    NODES
        .iter()
        .map(|&[m, w]| {
            let pair = DisneyPair { fo, fi: schlick_weight(m), cos2_d: 0.5 + 0.5 * mu * m, sum: mu + m };
            2.0 * w * m * pair.flat(roughness)
        })
        .sum()
}

/// How the forms are sampled: a clipped cosine as of a rough diffuse surface, and an even part where the flat form is
/// bright near grazing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisneySampler {
    cltc: Cltc,
    flat: f32,
}

impl DisneySampler {
    /// Roughness and share of the flat form, 0..1.
    #[inline]
    pub fn new(roughness: f32, flat: f32) -> Self {
        Self { cltc: Cltc::new(roughness), flat }
    }

    /// Share of the even part.
    #[inline(always)]
    fn p_even(&self, wo: Vec3A) -> f32 {
        let grazing = (1.0 - wo.z).max(0.0).min(1.0);
        0.5 * self.flat * grazing * grazing
    }

    /// Density, per steradian; both directions above the surface.
    #[inline(always)]
    pub fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let p = self.p_even(wo);
        p * (1.0 / TAU) + (1.0 - p) * self.cltc.pdf(wo, wi)
    }

    /// A direction of the upper hemisphere.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        let p = self.p_even(wo);
        if uc < p { uniform_hemisphere(u) } else { self.cltc.sample(wo, (uc - p) / (1.0 - p), u) }
    }
}

parameters! {
    /// What Disney's diffuse surface is at a point.
    pub struct DisneyDiffuseParams {
        /// Colour, each lane 0..1.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// Perceptual roughness, 0..1: from dark to bright at grazing.
        roughness: f32 = 0.5, 0.0..1.0;
        /// 0 the base form .. 1 the flat form of light that scattered below the surface.
        subsurface: f32 = 0.0, 0.0..1.0;
    }
}

impl ModelParams for DisneyDiffuseParams {
    type Closure = DisneyDiffuse;
    const ABOUT: &'static str =
        "Disney's diffuse surface (Burley 2012), with its flat form for subsurface scattering";
    const CLAIMS: Claims = Claims {
        conserves: Claim::Breaks(
            "fitted by eye and measurement, not by energy: white returns up to 1.56 of a white sky (roughness 1, grazing angles)",
        ),
        ..Claims::ALL
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> DisneyDiffuse {
        DisneyDiffuse::new(self.base_color, self.roughness, self.subsurface)
    }
}

/// Disney's diffuse surface; see the module's head.
///
/// Reciprocal; makes light at grazing angles if rough. Its [`Bsdf::albedo`] is exact for the base form, within 0.05 for the flat one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisneyDiffuse {
    color: Spectrum,
    roughness: f32,
    subsurface: f32,
    sampler: DisneySampler,
}

impl DisneyDiffuse {
    /// Colour, each lane 0..1, roughness and share of the flat form, 0..1; all are clamped.
    #[inline]
    pub fn new(color: Spectrum, roughness: f32, subsurface: f32) -> Self {
        let unit = |v: f32| v.max(0.0).min(1.0);
        let (roughness, subsurface) = (unit(roughness), unit(subsurface));
        Self {
            color: color.map(unit),
            roughness,
            subsurface,
            sampler: DisneySampler::new(roughness, subsurface),
        }
    }

    /// π f / c; both directions above the surface.
    #[inline(always)]
    fn shape(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let pair = DisneyPair::new(wo, wi);
        let base = pair.base(self.roughness);
        if self.subsurface == 0.0 {
            return base;
        }
        base + (pair.flat(self.roughness) - base) * self.subsurface
    }
}

impl Bsdf for DisneyDiffuse {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        diffuse_eval(wo, wi, || {
            (self.color * (self.shape(wo, wi).max(0.0) * FRAC_1_PI), self.sampler.pdf(wo, wi))
        })
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        diffuse_sample(self, wo, || self.sampler.sample(wo, uc, u))
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let base = base_albedo(wo.z, self.roughness);
        let all = if self.subsurface == 0.0 {
            base
        } else {
            base + (flat_albedo(wo.z, self.roughness) - base) * self.subsurface
        };
        self.color * all
    }
}
