//! Light from one direction.

use crate::choices::{Choices, Coupling, DirectPi, Matte};
use crate::surface::Surface;
use etendue_bxdf::MIN_COS;
use etendue_bxdf::fresnel::{pow5, schlick_weight};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use std::f32::consts::FRAC_1_PI;

/// The surface's value at a pair of directions, and what it is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// f of the diffuse part, 1/sr.
    pub diffuse: Spectrum,
    /// f of the specular part, 1/sr.
    pub specular: Spectrum,
    pub nl: f32,
    pub hv: f32,
    pub d: f32,
    pub f: Spectrum,
    pub g: f32,
    pub kd: Spectrum,
}

/// What the specular part and the layers leave for the diffuse part at a pair of directions, `f` being Fresnel's term there.
#[inline(always)]
pub(crate) fn coupled(s: &Surface, wi: Vec3A, f: Spectrum, choices: &Choices) -> Spectrum {
    match choices.coupling {
        Coupling::Albedo => Spectrum::splat(s.entering * s.entering_at(wi) * s.inv_entering_average),
        Coupling::OneMinusF => (Spectrum::ONE - f) * s.below_layers(),
        Coupling::OneMinusF0 => Spectrum::splat((1.0 - s.under[0]) * s.below_layers()),
        Coupling::Filament | Coupling::Whole => Spectrum::splat(s.below_layers()),
    }
}

/// Value for light from `wi` (local); `None` below the horizon.
#[inline]
pub(crate) fn pair(s: &Surface, wi: Vec3A, choices: &Choices) -> Option<Pair> {
    if !(wi.z > MIN_COS) {
        return None;
    }
    let wo = s.gloss.wo;
    let hv = 0.5 * (wo + wi).length();
    let w = schlick_weight(hv);
    let (d, dv) = s.gloss.lobe(wi, choices.masking);
    let f = s.fresnel(hv, w);
    let mut specular = s.compensated(hv, w) * dv;
    if !s.bounces.wide.is_black() {
        specular += s.bounces.wide * (s.bounces.lost * s.bounces.loss.directional(wi.z));
    }
    let kd = coupled(s, wi, f, choices);
    let kd = match choices.matte {
        Matte::Lambert => kd,
        Matte::Disney => {
            let fd90 = 0.5 + 2.0 * hv * hv * s.gloss.roughness;
            let bend = |cos: f32| 1.0 + (fd90 - 1.0) * pow5((1.0 - cos).max(0.0));
            kd * (bend(wo.z) * bend(wi.z))
        }
    };
    let mut diffuse = s.matte_at(0, wi) * kd * over_pi(choices);
    if let Some(layers) = &s.layers {
        let tint = layers.tint_at(wo, wi);
        specular *= tint * s.specular_below(wi);
        if let Some(coat) = &layers.coat {
            specular += Spectrum::splat(coat.eval(wi, choices.masking));
        }
        diffuse = (diffuse + layers.fibres_value(wo, wi)) * tint * layers.over + layers.top_value(wo, wi);
        specular *= layers.over;
    }
    let g = if d > 0.0 { dv / d * (4.0 * wo.z * wi.z) } else { 0.0 };
    Some(Pair { diffuse, specular, nl: wi.z, hv, d, f, g, kd })
}

/// Light from the far side: what is diffusely transmitted, and what passes a sheet.
#[inline]
pub(crate) fn from_behind(s: &Surface, wi: Vec3A, choices: &Choices) -> Option<[Spectrum; 2]> {
    if !(wi.z < -MIN_COS) || (s.matte[1].is_black() && s.passing.is_none()) {
        return None;
    }
    let up = vec3a(wi.x, wi.y, -wi.z);
    let f = s.fresnel(s.gloss.wo.z, schlick_weight(s.gloss.wo.z));
    let diffuse = s.matte_at(1, up) * coupled(s, up, f, choices) * over_pi(choices);
    let [mirrored, scattered] = s.veil();
    let passed = s.passing.as_ref().map_or(Spectrum::ZERO, |p| p.eval(s, up));
    Some([diffuse * scattered, passed * mirrored])
}

#[inline(always)]
pub(crate) fn over_pi(choices: &Choices) -> f32 {
    match choices.direct_pi {
        DirectPi::Once => FRAC_1_PI,
        DirectPi::Never => 1.0,
    }
}
