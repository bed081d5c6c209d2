//! The metallic-roughness surface of glTF 2.0.
//!
//! Appendix B of the specification, with `KHR_materials_ior` and `KHR_materials_specular`:
//!
//! ```text
//! material   = mix(dielectric, metal, metallic)
//! metal      = (c + (1 − c) w) · S                      c: base colour
//! dielectric = (1 − max F) · c / π + F · S
//! F          = f0 + (f90 − f0) w,  w = (1 − |wo·h|)⁵
//! f0         = min(((1 − ior) / (1 + ior))² · specular_color, 1) · specular,  f90 = specular
//! ```
//!
//! S is the GGX lobe with heights correlated. Both specular parts share S and w, so the mix is one Fresnel term whose
//! ends are mixed, and one diffuse term: nothing is evaluated twice.

use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    fresnel::{f0_from_ior, schlick_weight},
    ggx::{ALPHA_DELTA, Ggx, mirror},
    sampling::cosine_hemisphere,
};
use core::f32::consts::{FRAC_1_PI, PI};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What a metallic-roughness surface is at a point, after its textures.
///
/// Out of range is clamped, NaN counts as zero (for `ior` as 1.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalRoughParams {
    /// Diffuse colour of a dielectric, F0 of a metal; lanes 0..1.
    pub base_color: Spectrum,
    /// 0 dielectric .. 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, 0..1; α = roughness².
    pub roughness: f32,
    /// Index of refraction, ≥ 1; 0 means infinite: reflects everything at each angle.
    pub ior: f32,
    /// Strength of the dielectric's reflection, 0..1.
    pub specular: f32,
    /// Tint of the dielectric's F0; lanes ≥ 0, may exceed 1.
    pub specular_color: Spectrum,
}

impl Default for MetalRoughParams {
    /// A white, fully rough dielectric of index 1.5.
    fn default() -> Self {
        Self {
            base_color: Spectrum::ONE,
            metallic: 0.0,
            roughness: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Spectrum::ONE,
        }
    }
}

/// The closure of a metallic-roughness surface at a point: small, `Copy`, made anew at each hit.
///
/// Reciprocal. Its [`Bsdf::albedo`] is an estimate. Where α falls below [`ALPHA_DELTA`] the specular part is a perfect
/// mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalRough {
    ggx: Ggx,
    mirror: bool,
    /// Base colour of the diffuse part / π.
    diffuse: Spectrum,
    f0: Spectrum,
    f90: f32,
    /// The diffuse part is scaled by `through − through_slope · w`.
    through: f32,
    through_slope: f32,
    /// Sums over lanes, for the choice of lobe.
    sum_diffuse: f32,
    sum_f0: f32,
    sum_f90: f32,
}

/// 0..1, NaN to 0.
#[inline(always)]
fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

#[inline(always)]
fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}

impl MetalRough {
    /// The closure of a surface.
    #[inline]
    pub fn new(p: &MetalRoughParams) -> Self {
        let roughness = unit(p.roughness);
        let alpha = roughness * roughness;
        let metallic = unit(p.metallic);
        let dielectric = 1.0 - metallic;
        let specular = unit(p.specular);
        let base = p.base_color.map(unit);
        let dielectric_f0 = (p.specular_color * f0_from_ior(p.ior)).map(unit) * specular;
        let f0 = dielectric_f0 * dielectric + base * metallic;
        let f90 = specular * dielectric + metallic;
        // max over lanes of F is linear in w as well: F grows with w in each lane, to the same f90.
        let f0_max = dielectric_f0.max_element();
        let diffuse = base * (dielectric * FRAC_1_PI);
        Self {
            ggx: Ggx::new(alpha, alpha),
            mirror: alpha < ALPHA_DELTA,
            diffuse,
            f0,
            f90,
            through: 1.0 - f0_max,
            through_slope: specular - f0_max,
            sum_diffuse: sum(diffuse) * (PI * (1.0 - f0_max)),
            sum_f0: sum(f0),
            // Lanes that take no part are zero in the base colour and in `specular_color`: three stand for all.
            sum_f90: 3.0 * f90,
        }
    }

    #[inline(always)]
    fn fresnel(&self, w: f32) -> Spectrum {
        self.f0 + (Spectrum::splat(self.f90) - self.f0) * w
    }

    /// Probability of the specular lobe.
    #[inline(always)]
    fn specular_probability(&self, cos: f32) -> f32 {
        let w = schlick_weight(cos);
        let specular = self.sum_f0 + (self.sum_f90 - self.sum_f0) * w;
        let all = specular + self.sum_diffuse;
        if all > 0.0 { specular / all } else { 1.0 }
    }

    /// Value by lobe and density; both directions must lie above [`MIN_COS`].
    #[inline(always)]
    fn eval_above(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let p_specular = self.specular_probability(wo.z);
        let pdf_diffuse = (1.0 - p_specular) * (wi.z * FRAC_1_PI);
        if self.mirror {
            let w = schlick_weight(0.5 * (wo + wi).length());
            let diffuse = self.diffuse * (self.through - self.through_slope * w);
            return Eval { diffuse, specular: Spectrum::ZERO, pdf: pdf_diffuse };
        }
        let pair = self.ggx.pair(wo, wi);
        let w = schlick_weight(pair.cos_half);
        Eval {
            diffuse: self.diffuse * (self.through - self.through_slope * w),
            specular: self.fresnel(w) * pair.value,
            pdf: p_specular * pair.pdf + pdf_diffuse,
        }
    }
}

impl Bsdf for MetalRough {
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
        let p_specular = self.specular_probability(wo.z);
        let specular = uc < p_specular;
        if specular && self.mirror {
            let weight = self.fresnel(schlick_weight(wo.z)) * (1.0 / p_specular);
            return Some(BsdfSample {
                wi: mirror(wo),
                weight,
                weight_diffuse: Spectrum::ZERO,
                weight_specular: weight,
                pdf: p_specular,
                delta: true,
                lobe: LobeKind::Specular,
            });
        }
        let wi = if specular { self.ggx.sample_reflection(wo, u) } else { cosine_hemisphere(u) };
        if !(wi.z > MIN_COS) {
            return None;
        }
        let e = self.eval_above(wo, wi);
        if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
            return None;
        }
        let scale = wi.z / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        Some(BsdfSample {
            wi,
            weight: weight_diffuse + weight_specular,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe: if specular { LobeKind::Specular } else { LobeKind::Diffuse },
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        self.diffuse * (PI * self.through) + self.fresnel(schlick_weight(wo.z))
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !self.mirror || !(wo.z > MIN_COS) {
            return [None, None];
        }
        let part = DeltaPart {
            wi: mirror(wo),
            reflectance: self.fresnel(schlick_weight(wo.z)),
            probability: self.specular_probability(wo.z),
        };
        [Some(part), None]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.mirror { [1.0, 1.0] } else { self.ggx.alpha() }
    }
}
