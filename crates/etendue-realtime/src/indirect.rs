//! Light from the sky.

use crate::choices::{Choices, Coupling, Diffuse, Pi, SplitFresnel};
use crate::gloss::{Draws, lattice, samples, to_world};
use crate::lighting::Lighting;
use crate::sky_light::SkyLight;
use crate::surface::{Surface, table, unit};
use etendue_bxdf::fresnel::schlick_rough;
use etendue_bxdf::sampling::Frame;
use etendue_bxdf::{Bsdf, MIN_COS};
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
    let at = Place { s, sky, lighting, choices };
    let (irradiance, kd) = at.matte(frame.z, e, dfg);
    let over = match choices.pi {
        Pi::Once => 1.0,
        Pi::Twice => FRAC_1_PI,
    };
    let mut diffuse = irradiance * s.matte[0] * kd * over;
    if !s.matte[1].is_black() {
        // The same surface, lit from behind.
        let behind = at.matte(-frame.z, sky.irradiance(-frame.z), dfg).0;
        diffuse += behind * s.matte[1] * kd * over;
    }
    let (mut specular, prefiltered, mip) = at.glossy(frame, dfg);
    if !s.bounces.wide.is_black() {
        specular += s.bounces.wide * s.bounces.lost * at.wide(frame.z, e) * s.below_layers();
    }
    if let Some(layers) = &s.layers {
        let [mirrored, scattered] = layers.tint;
        specular = (specular * mirrored + at.coat(frame)) * layers.over;
        if let Some(fibres) = &layers.fibres {
            diffuse += at.fibres(&fibres.lobe, frame) * layers.through[0];
        }
        diffuse *= scattered * layers.over;
        if let Some(top) = &layers.top {
            diffuse += at.fibres(&top.lobe, frame) * top.weight;
        }
    }
    Indirect { diffuse, specular, irradiance, kd, prefiltered, mip, dfg }
}

/// What all parts need.
struct Place<'a> {
    s: &'a Surface,
    sky: &'a SkyLight,
    lighting: &'a Lighting,
    choices: &'a Choices,
}

impl Place<'_> {
    /// Irradiance over π as the diffuse part sees it, and what of it the specular part and the layers leave.
    #[inline]
    fn matte(&self, n: Vec3A, e: Spectrum, dfg: Dfg) -> (Spectrum, Spectrum) {
        let (s, sky) = (self.s, self.sky);
        let plain = || match self.choices.diffuse {
            Diffuse::Exact => sky.exactly(n, |_| 1.0).unwrap_or(e),
            Diffuse::Sh9 => e,
            Diffuse::Cube | Diffuse::Sh9Windowed => e.max(Spectrum::ZERO),
        };
        let below = s.below_layers();
        match self.choices.coupling {
            Coupling::Albedo => {
                // ∫ L cos entering(cos) dω over its mean; for the base alone entering = 1 − F0 − (F90 − F0) W.
                let across = |cos: f32| vec3a((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
                let all = match (sky.exactly(n, |cos| s.entering_at(across(cos))), &s.bands) {
                    (Some(all), _) => all,
                    (None, Some(bands)) => sky.zonal(n, plain(), bands),
                    (None, None) => {
                        let e = plain();
                        let weighted = sky.zonal(n, e, &self.lighting.zonal.schlick(s.gloss.roughness));
                        e * (1.0 - s.under[0]) - weighted.min(e) * (s.under[1] - s.under[0])
                    }
                };
                (all * (s.inv_entering_average * FRAC_1_PI), Spectrum::splat(s.entering))
            }
            Coupling::OneMinusF => {
                let f = schlick_rough(s.gloss.wo.z, s.f0, s.gloss.roughness);
                (plain() * FRAC_1_PI, (Spectrum::ONE - f) * below)
            }
            Coupling::Filament => {
                let taken = dfg.albedo(s.f0, Spectrum::splat(s.f90));
                (plain() * FRAC_1_PI, (Spectrum::ONE - taken) * below)
            }
            Coupling::OneMinusF0 => (plain() * FRAC_1_PI, Spectrum::splat((1.0 - s.under[0]) * below)),
            Coupling::Whole => (plain() * FRAC_1_PI, Spectrum::splat(below)),
        }
    }

    /// ∫ L cos (1 − E(cos)) dω: the light that the wide lobe of further bounces meets.
    #[inline]
    fn wide(&self, n: Vec3A, e: Spectrum) -> Spectrum {
        let bounces = &self.s.bounces;
        let exact = match self.choices.diffuse {
            Diffuse::Exact => self.sky.exactly(n, |cos| bounces.loss.directional(cos)),
            _ => None,
        };
        exact.unwrap_or_else(|| self.sky.zonal(n, e, &self.lighting.zonal.loss(bounces.roughness)))
    }

    /// The base's specular lobe: its light, the mean light over the lobe, and the level of detail.
    #[inline]
    fn glossy(&self, frame: &Frame, dfg: Dfg) -> (Spectrum, Spectrum, f32) {
        let s = self.s;
        let [a, b] = s.bounces.scale;
        match samples(self.choices.specular) {
            Some(n) => {
                let film = s.film.as_ref().map(|f| (f, [s.f0, Spectrum::splat(s.f90)]));
                let draws = Draws::new(n, s.part);
                let lit = match &s.layers {
                    None => s.gloss.sampled(frame, self.sky, draws, film, |_| 1.0),
                    Some(_) => s.gloss.sampled(frame, self.sky, draws, film, |wi| s.specular_below(wi)),
                };
                let light = match film {
                    Some(_) => lit.film * a,
                    None => s.f0 * a * lit.straight + b * s.f90 * lit.grazing,
                };
                (light, lit.prefiltered, lit.mip)
            }
            // The split sum (Karis 2013): prefiltered light × reflectance.
            None => {
                let (prefiltered, mip) = s.gloss.prefiltered(frame, self.sky, self.choices);
                let cos = s.gloss.wo.z;
                let f0 = match self.choices.fresnel {
                    SplitFresnel::F0Ab => s.f0,
                    SplitFresnel::Notes => schlick_rough(cos, s.f0, s.gloss.roughness),
                };
                let reflectance = match &s.film {
                    None => f0 * a * dfg.scale + b * (s.f90 * dfg.bias),
                    // A film's colours at the view's angle stand for those of all facets.
                    Some(_) => {
                        let w = s.gloss.directional(s.gloss.wo).w;
                        s.fresnel(cos, w) * a * dfg.energy()
                    }
                };
                (prefiltered * reflectance * s.below_layers(), prefiltered, mip)
            }
        }
    }

    /// The lacquer's lobe.
    #[inline]
    fn coat(&self, frame: &Frame) -> Spectrum {
        let coat = self.s.layers.as_ref().and_then(|l| l.coat.as_ref());
        let Some((coat, gloss)) = coat.and_then(|c| c.gloss.as_ref().map(|g| (c, g))) else {
            return Spectrum::ZERO;
        };
        let (frame, [f0, f90]) = (coat.world_frame(frame), coat.ends());
        match samples(self.choices.specular) {
            Some(n) => {
                let lit = gloss.sampled(&frame, self.sky, Draws::new(n, self.s.part), None, |_| 1.0);
                lit.straight * f0 + lit.grazing * f90
            }
            None => {
                let d = table(gloss);
                gloss.prefiltered(&frame, self.sky, self.choices).0 * (f0 * d.scale + f90 * d.bias)
            }
        }
    }

    /// The fibres' lobe, by samples also beside the split sum: it is no lobe about a mirror direction, and a cube of its own for
    /// each roughness would only serve the rare cloth.
    #[inline]
    fn fibres<B: Bsdf>(&self, lobe: &B, frame: &Frame) -> Spectrum {
        let n = samples(self.choices.specular).unwrap_or(16).min(256);
        let (wo, inv) = (self.s.gloss.wo, 1.0 / n as f32);
        let (mut lit, mut white) = (Spectrum::ZERO, Spectrum::ZERO);
        for i in 0..n {
            // The third dimension by another irrational number.
            let uc = (i.wrapping_mul(0xb504_f334) >> 8) as f32 * (1.0 / 16_777_216.0);
            let Some(sample) = lobe.sample(wo, uc, lattice(i, inv)) else { continue };
            if !(sample.wi.z > MIN_COS) {
                continue;
            }
            let light = self.sky.averaged(to_world(frame, sample.wi), inv / sample.pdf).0;
            lit += sample.weight * light;
            white += sample.weight;
        }
        let known = lobe.albedo(wo);
        let mut out = Spectrum::ZERO;
        for i in 0..3 {
            if white[i] > 0.0 {
                out[i] = lit[i] / white[i] * known[i];
            }
        }
        out
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
