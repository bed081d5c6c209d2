//! Light from the sky.

use crate::choices::{Choices, Coupling, Diffuse, Lobe, Pi, Specular, SplitFresnel};
use crate::lighting::Lighting;
use crate::sky_light::SkyLight;
use crate::surface::{Surface, unit};
use etendue_bxdf::MIN_COS;
use etendue_bxdf::fresnel::{schlick_rough, schlick_weight};
use etendue_bxdf::sampling::Frame;
use etendue_color::Spectrum;
use etendue_ibl::Dfg;
use glam::{Vec3A, vec3a};
use std::f32::consts::FRAC_1_PI;

/// The sky's light by part, without occlusion, and the values on the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Indirect {
    pub diffuse: Spectrum,
    pub specular: Spectrum,
    /// Irradiance over π.
    pub irradiance: Spectrum,
    /// Factor of the base colour.
    pub kd: Spectrum,
    pub prefiltered: Spectrum,
    pub mip: f32,
    pub dfg: Dfg,
}

/// The light of a sky on a surface in a frame.
#[inline]
pub(crate) fn indirect(
    s: &Surface,
    frame: &Frame,
    sky: &SkyLight,
    lighting: &Lighting,
    choices: &Choices,
) -> Indirect {
    let dfg = s.dfg(choices.dfg);
    let e = sky.irradiance(frame.z);
    let (irradiance, kd) = matte(s, frame.z, e, sky, lighting, choices, dfg);
    let over = match choices.pi {
        Pi::Once => 1.0,
        Pi::Twice => FRAC_1_PI,
    };
    let glossy = match choices.specular {
        Specular::SplitSum => split_sum(s, frame, sky, choices, dfg),
        Specular::Sampled => sampled(s, frame, sky, 32),
        Specular::SampledFew => sampled(s, frame, sky, 8),
        Specular::Exact => sampled(s, frame, sky, 1024),
    };
    let mut specular = glossy.light;
    if !s.bounces.wide.is_black() {
        specular += s.bounces.wide * s.bounces.lost * wide(s, frame.z, e, sky, lighting, choices);
    }
    Indirect {
        diffuse: irradiance * s.matte * kd * over,
        specular,
        irradiance,
        kd,
        prefiltered: glossy.prefiltered,
        mip: glossy.mip,
        dfg,
    }
}

/// Irradiance over π as the diffuse part sees it, and what of it the specular part leaves.
#[inline]
fn matte(
    s: &Surface,
    n: Vec3A,
    e: Spectrum,
    sky: &SkyLight,
    lighting: &Lighting,
    choices: &Choices,
    dfg: Dfg,
) -> (Spectrum, Spectrum) {
    let plain = || match choices.diffuse {
        Diffuse::Exact => sky.exactly(n, |_| 1.0).unwrap_or(e),
        Diffuse::Sh9 => e,
        Diffuse::Cube | Diffuse::Sh9Windowed => e.max(Spectrum::ZERO),
    };
    match choices.coupling {
        Coupling::Albedo => {
            // ∫ L cos (1 − F̄(cos)) dω over its mean; F̄ = F0 + (F90 − F0) W.
            let all = match sky.exactly(n, |cos| s.through_at(cos)) {
                Some(all) => all,
                None => {
                    let e = plain();
                    let taken = sky.zonal(n, e, &lighting.zonal.schlick(s.roughness)).min(e);
                    e * (1.0 - s.under[0]) - taken * (s.under[1] - s.under[0])
                }
            };
            (all * (s.inv_through_average * FRAC_1_PI), Spectrum::splat(s.through))
        }
        Coupling::OneMinusF => {
            let f = schlick_rough(s.wo.z, s.f0, s.roughness);
            (plain() * FRAC_1_PI, Spectrum::ONE - f)
        }
        Coupling::Filament => {
            let taken = dfg.albedo(s.f0, Spectrum::splat(s.f90));
            (plain() * FRAC_1_PI, Spectrum::ONE - taken)
        }
        Coupling::OneMinusF0 => (plain() * FRAC_1_PI, Spectrum::splat(1.0 - s.under[0])),
        Coupling::Whole => (plain() * FRAC_1_PI, Spectrum::ONE),
    }
}

/// ∫ L cos (1 − E(cos)) dω: the light that the wide lobe of further bounces meets.
#[inline]
fn wide(
    s: &Surface,
    n: Vec3A,
    e: Spectrum,
    sky: &SkyLight,
    lighting: &Lighting,
    choices: &Choices,
) -> Spectrum {
    let exact = match choices.diffuse {
        Diffuse::Exact => sky.exactly(n, |cos| s.bounces.loss.directional(cos)),
        _ => None,
    };
    exact.unwrap_or_else(|| sky.zonal(n, e, &lighting.zonal.loss(s.roughness)))
}

/// The specular lobe's light.
struct Glossy {
    light: Spectrum,
    prefiltered: Spectrum,
    mip: f32,
}

#[inline(always)]
fn to_world(f: &Frame, w: Vec3A) -> Vec3A {
    f.x * w.x + f.y * w.y + f.z * w.z
}

/// Filtered importance sampling of the real lobe: Σ L(wi, level) f cos / (n pdf), where the level's texels are as large as the
/// sample's share 1 / (n pdf) of the sphere (Křivánek, Colbert 2008, "Real-Time Shading with Filtered Importance Sampling",
/// section 4).
#[inline]
fn sampled(s: &Surface, frame: &Frame, sky: &SkyLight, n: u32) -> Glossy {
    if s.mirror {
        let light = sky.radiance(to_world(frame, mirror(s.wo)));
        return Glossy { light: light * s.fresnel(schlick_weight(s.wo.z)), prefiltered: light, mip: 0.0 };
    }
    // F is linear in Schlick's weight: two sums serve all its lanes.
    let (mut straight, mut grazing, mut mean) = (Spectrum::ZERO, Spectrum::ZERO, Spectrum::ZERO);
    let (mut total, mut level) = (0.0, 0.0);
    let inv = 1.0 / n as f32;
    for i in 0..n {
        let u = [lattice(i), (i as f32 + 0.5) * inv];
        let wi = s.ggx.sample_reflection(s.wo, u);
        if !(wi.z > MIN_COS) {
            continue;
        }
        let pair = s.ggx.pair(s.wo, wi);
        let share = inv / pair.pdf;
        let (light, lod) = sky.averaged(to_world(frame, wi), share);
        let weight = pair.value * wi.z * share;
        let w = schlick_weight(pair.cos_half);
        let lit = light * weight;
        straight += lit * (1.0 - w);
        grazing += lit * w;
        mean += lit;
        total += weight;
        level += weight * lod;
    }
    let [a, b] = s.bounces.scale;
    let inv = if total > 0.0 { 1.0 / total } else { 0.0 };
    Glossy { light: s.f0 * a * straight + b * s.f90 * grazing, prefiltered: mean * inv, mip: level * inv }
}

/// The golden ratio's multiples: with the index they are a lattice of the square that is even for every number of points.
#[inline(always)]
fn lattice(i: u32) -> f32 {
    // 2³² over the golden ratio.
    (i.wrapping_mul(0x9e37_79b9) >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[inline(always)]
fn mirror(wo: Vec3A) -> Vec3A {
    vec3a(-wo.x, -wo.y, wo.z)
}

/// The split sum (Karis 2013): prefiltered light × reflectance.
#[inline]
fn split_sum(s: &Surface, frame: &Frame, sky: &SkyLight, choices: &Choices, dfg: Dfg) -> Glossy {
    let r = mirror(s.wo);
    let alpha = s.roughness * s.roughness;
    let (prefiltered, mip) = match choices.lobe {
        Lobe::Mirror => sky.prefiltered(to_world(frame, r), s.roughness),
        Lobe::Dominant => {
            let smooth = unit(1.0 - alpha);
            let towards_mirror = smooth * (smooth.sqrt() + alpha);
            let d = r * towards_mirror + Vec3A::Z * (1.0 - towards_mirror);
            sky.prefiltered(to_world(frame, d), s.roughness)
        }
        Lobe::Stretched => stretched(s, frame, sky),
    };
    let [a, b] = s.bounces.scale;
    let f0 = match choices.fresnel {
        SplitFresnel::F0Ab => s.f0,
        SplitFresnel::Notes => schlick_rough(s.wo.z, s.f0, s.roughness),
    };
    let reflectance = f0 * a * dfg.scale + b * (s.f90 * dfg.bias);
    Glossy { light: prefiltered * reflectance, prefiltered, mip }
}

/// The mean of five looks whose half vectors lie in the plane of incidence.
///
/// Half vectors are spread over an angle of about α around the normal in each direction. Mirrored at them, the view moves by
/// twice the angle within the plane of incidence, but by 2 V·H times it beside the plane: the lobe is an ellipse 1 : V·H, where a
/// prefiltered cube has circles. So each look is at a circle narrower by V·H, and the looks stand at the quantiles 0.1, 0.3, … 0.9
/// of the slopes within the plane, whose density is α² / (2 (α² + x²)^(3/2)), each weighted with what is visible of it.
#[inline]
fn stretched(s: &Surface, frame: &Frame, sky: &SkyLight) -> (Spectrum, f32) {
    // x / α = q / √(1 − q²) for q = 2u − 1.
    const SLOPES: [f32; 5] = [-1.333_333_4, -0.436_435_8, 0.0, 0.436_435_8, 1.333_333_4];
    let alpha = s.roughness * s.roughness;
    let along = vec3a(s.wo.x, s.wo.y, 0.0).normalize_or_zero();
    let (mut sum, mut total, mut mip) = (Spectrum::ZERO, 0.0, 0.0);
    for slope in SLOPES {
        let h = (Vec3A::Z + along * (alpha * slope)).normalize();
        let cos = s.wo.dot(h);
        let wi = h * (2.0 * cos) - s.wo;
        if !(cos > 0.0 && wi.z > 0.0) {
            continue;
        }
        let weight = cos * s.ggx.g2(s.wo, wi);
        // Not narrower than what lies between two looks.
        let narrow = s.roughness * cos.max(0.35).sqrt();
        let (light, lod) = sky.prefiltered(to_world(frame, wi), narrow);
        sum += light * weight;
        total += weight;
        mip += lod * weight;
    }
    if total > 0.0 {
        (sum * (1.0 / total), mip / total)
    } else {
        sky.prefiltered(to_world(frame, mirror(s.wo)), s.roughness)
    }
}

/// What of the specular lobe an ambient occlusion of 0..1 leaves open (Lagarde, de Rousiers 2014, section 4.10.2, listing 26):
/// clamp((N·V + ao)^(2^(−16 α − 1)) − 1 + ao).
#[inline]
pub(crate) fn specular_occlusion(nv: f32, ao: f32, alpha: f32) -> f32 {
    let exponent = etendue_bxdf::math::exp2(-16.0 * alpha - 1.0);
    let x = (nv + ao).max(1e-6);
    unit(etendue_bxdf::math::exp(exponent * etendue_bxdf::math::ln(x)) - 1.0 + ao)
}
