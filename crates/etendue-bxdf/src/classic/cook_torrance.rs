//! The Cook-Torrance surface of real-time shaders.

use super::{choice, sample_of, sum, unit};
use crate::{
    bsdf::{Bsdf, BsdfSample, Eval, LobeKind, MIN_COS},
    choices,
    fresnel::{schlick_rough, schlick_weight},
    ggx::Ggx,
    microfacet::{
        AnyDistribution, AnyMasking, Beckmann, BlinnPhong, Distribution, Gtr, Masking, SchlickGgx, Smith,
        SmithSeparable, VCavity,
    },
    model::{Claim, Claims, Incidence, ModelParams},
    parameters,
    sampling::cosine_hemisphere,
};
use core::f32::consts::{FRAC_1_PI, PI};
use etendue_color::Spectrum;
use glam::Vec3A;

choices! {
    /// The distribution of facets, all of α = roughness².
    pub enum CookTorranceDistribution {
        /// GGX.
        Ggx = "ggx",
        /// Beckmann's.
        Beckmann = "beckmann",
        /// Trowbridge and Reitz's with the tail `gamma`.
        Gtr = "gtr",
        /// Blinn's.
        BlinnPhong = "blinn-phong",
    }
}

choices! {
    /// The masking term.
    pub enum CookTorranceMasking {
        /// Schlick's curve, k = (r + 1)²/8: for light from single directions.
        SchlickDirect = "schlick-direct",
        /// Schlick's curve, k = r²/2: for light from everywhere.
        SchlickIndirect = "schlick-indirect",
        /// Smith's, heights correlated.
        Smith = "smith",
        /// Smith's, separable.
        SmithSeparable = "smith-separable",
        /// V-cavities: what Cook and Torrance used.
        VCavity = "v-cavity",
    }
}

choices! {
    /// The Fresnel term and its angle.
    pub enum CookTorranceFresnel {
        /// Schlick's curve of the half vector's angle.
        Schlick = "schlick",
        /// Schlick's curve of the angle of `wo` to the normal: some shaders' shortcut, not reciprocal.
        SchlickView = "schlick-view",
        /// The same with the edge dimmed by roughness, as for light from everywhere; not reciprocal.
        RoughView = "rough-view",
    }
}

parameters! {
    /// What a Cook-Torrance surface is at a point.
    pub struct CookTorranceParams {
        /// Diffuse colour of a dielectric, F0 of a metal; lanes 0..1.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// 0 dielectric .. 1 metal.
        metallic: f32 = 0.0, 0.0..1.0;
        /// Perceptual roughness, 0..1; α = roughness².
        roughness: f32 = 0.5, 0.0..1.0;
        /// Divides the diffuse part by π; without, it is π times as bright as it should be.
        divide_by_pi: bool = true, 0.0..1.0;
        /// Keeps the denominators of D and of the whole above 10⁻⁵ and 10⁻⁴, as shaders do.
        clamps: bool = true, 0.0..1.0;
        /// The distribution of facets.
        distribution: CookTorranceDistribution = CookTorranceDistribution::Ggx, 0.0..1.0;
        /// The tail of `distribution` = `gtr`, 0.1..10; 2 is GGX.
        gamma: f32 = 2.0, 0.5..4.0;
        /// The masking term.
        masking: CookTorranceMasking = CookTorranceMasking::SchlickDirect, 0.0..1.0;
        /// The Fresnel term.
        fresnel: CookTorranceFresnel = CookTorranceFresnel::Schlick, 0.0..1.0;
    }
}

impl ModelParams for CookTorranceParams {
    type Closure = CookTorrance;
    const ABOUT: &'static str = "the direct light of real-time shaders: Cook-Torrance with GGX, Schlick-GGX and Schlick's Fresnel (Karis 2013)";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Breaks(
            "`fresnel` = `schlick-view` and `rough-view` take the angle of `wo` alone; `schlick` is reciprocal",
        ),
        conserves: Claim::Breaks(
            "the diffuse part is weighed by the Fresnel term at the half vector, which lets too much through at grazing angles, \
             and without `divide_by_pi` is π times too bright",
        ),
    };

    #[inline]
    fn closure(&self, _at: &Incidence) -> CookTorrance {
        CookTorrance::new(self)
    }
}

/// The least denominator of D.
const LEAST_D: f32 = 1e-5;
/// The least 4 cos θo cos θi.
const LEAST_COSINES: f32 = 1e-4;
/// The α² at which D's denominator π α⁴ is [`LEAST_D`]: below it the clamp rounds the peak off to the width of this one.
const ROUNDED_ALPHA2: f32 = 1.784_124e-3;

/// The shaders' surface, line by line:
///
/// ```text
/// F0 = lerp(0.04, base, metallic)        Ks = F0 + (1 − F0)(1 − v·h)⁵       Kd = (1 − Ks)(1 − metallic)
/// D  = a²/ max(π (NH² (a² − 1) + 1)², 10⁻⁵), a = r²      G = g(NV) g(NL), g(c) = c / max(c (1 − k) + k, 10⁻⁵)
/// f  = Kd base / π + D Ks G / max(4 NV NL, 10⁻⁴)
/// ```
///
/// with the same formulas, not the same rounding: D is taken without the cancellation in NH² (a² − 1) + 1.
///
/// What is wrong with it, and kept: the clamp on D's denominator takes away the highlights of smooth surfaces (below
/// r = 0.21; at r = 0.1 the peak is 10 where it should be 3183, and at r = 0 the surface has no reflection); Kd makes light
/// at grazing angles as [`crate::Coupling::HalfVector`] does; k = (r + 1)²/8 masks too much of a smooth surface. Its
/// [`Bsdf::albedo`] is an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CookTorrance {
    distribution: AnyDistribution,
    /// What directions are drawn by.
    sampler: AnyDistribution,
    masking: AnyMasking,
    fresnel: CookTorranceFresnel,
    clamps: bool,
    roughness: f32,
    f0: Spectrum,
    /// Base colour of the diffuse part, over π if that is asked for.
    diffuse: Spectrum,
    p_specular: f32,
}

impl CookTorrance {
    /// The closure of a surface; out of range is clamped, NaN counts as the lower end.
    #[inline(always)]
    pub fn new(p: &CookTorranceParams) -> Self {
        let (roughness, metallic) = (unit(p.roughness), unit(p.metallic));
        let alpha = roughness * roughness;
        let base = p.base_color.map(unit);
        let distribution = match p.distribution {
            CookTorranceDistribution::Ggx => AnyDistribution::Ggx(Ggx::new(alpha, alpha)),
            CookTorranceDistribution::Beckmann => AnyDistribution::Beckmann(Beckmann::new(alpha, alpha)),
            CookTorranceDistribution::Gtr => AnyDistribution::Gtr(Gtr::new(alpha, p.gamma)),
            CookTorranceDistribution::BlinnPhong => AnyDistribution::BlinnPhong(BlinnPhong::new(alpha)),
        };
        let clamps = p.clamps;
        let masking = match p.masking {
            CookTorranceMasking::SchlickDirect => AnyMasking::SchlickGgx(SchlickGgx::direct(roughness)),
            CookTorranceMasking::SchlickIndirect => AnyMasking::SchlickGgx(SchlickGgx::indirect(roughness)),
            CookTorranceMasking::Smith => AnyMasking::Smith(Smith),
            CookTorranceMasking::SmithSeparable => AnyMasking::SmithSeparable(SmithSeparable),
            CookTorranceMasking::VCavity => AnyMasking::VCavity(VCavity),
        };
        let masking = match masking {
            AnyMasking::SchlickGgx(g) if clamps => AnyMasking::SchlickGgx(g.with_least_denominator(LEAST_D)),
            other => other,
        };
        // A rounded peak has the shape of the wider lobe, and the part of its light that the clamp leaves.
        let rounded = clamps && p.distribution == CookTorranceDistribution::Ggx;
        let (sampler, left) = if rounded && alpha * alpha < ROUNDED_ALPHA2 {
            let wide = ROUNDED_ALPHA2.sqrt();
            (AnyDistribution::Ggx(Ggx::new(wide, wide)), alpha * alpha / ROUNDED_ALPHA2)
        } else {
            (distribution, 1.0)
        };
        let f0 = Spectrum::splat(0.04 * (1.0 - metallic)) + base * metallic;
        let diffuse = base * (1.0 - metallic) * if p.divide_by_pi { FRAC_1_PI } else { 1.0 };
        let p_specular = choice(sum(f0.lerp(Spectrum::ONE, 1.0 / 21.0)) * left, sum(diffuse) * PI);
        Self {
            distribution,
            sampler,
            masking,
            fresnel: p.fresnel,
            clamps,
            roughness,
            f0,
            diffuse,
            p_specular,
        }
    }

    #[inline(always)]
    fn reflectance(&self, wo: Vec3A, cos_half: f32) -> Spectrum {
        match self.fresnel {
            CookTorranceFresnel::Schlick => self.f0.lerp(Spectrum::ONE, schlick_weight(cos_half)),
            CookTorranceFresnel::SchlickView => self.f0.lerp(Spectrum::ONE, schlick_weight(wo.z)),
            CookTorranceFresnel::RoughView => schlick_rough(wo.z, self.f0, self.roughness),
        }
    }

    /// Value and density; both directions above [`MIN_COS`].
    #[inline(always)]
    fn eval_above(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let h = wo + wi;
        let len2 = h.length_squared();
        let ks = self.reflectance(wo, 0.5 * len2.sqrt());
        let d = match self.distribution {
            AnyDistribution::Ggx(_) if self.clamps => {
                let a = self.roughness * self.roughness;
                let a2 = a * a;
                // NH² (a² − 1) + 1 = sin² + a² cos².
                let t = (h.x * h.x + h.y * h.y + a2 * (h.z * h.z)) / len2;
                a2 / (PI * t * t).max(LEAST_D)
            }
            other => other.d(h),
        };
        let cosines = 4.0 * wo.z * wi.z;
        let cosines = if self.clamps { cosines.max(LEAST_COSINES) } else { cosines };
        let g = self.masking.g2(&self.distribution, wo, wi, h);
        let pdf_specular = 0.25 * self.sampler.d(h) * self.sampler.visible_g1(wo, h) / wo.z;
        Eval {
            diffuse: self.diffuse * (Spectrum::ONE - ks),
            specular: ks * (d * g / cosines),
            pdf: self.p_specular * pdf_specular + (1.0 - self.p_specular) * (wi.z * FRAC_1_PI),
        }
    }
}

impl Bsdf for CookTorrance {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let e = self.eval_above(wo, wi);
        if e.pdf < f32::INFINITY && e.specular.is_finite() { e } else { Eval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let uc = uc.max(0.0);
        let specular = uc < self.p_specular;
        let wi = if specular {
            let m = self.sampler.sample_visible(wo, uc / self.p_specular, u);
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
        let ks = self.reflectance(wo, wo.z);
        self.diffuse * (Spectrum::ONE - ks) * PI + ks
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.p_specular > 0.0 { self.sampler.alpha() } else { [1.0, 1.0] }
    }
}
