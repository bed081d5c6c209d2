//! What a layer of varnish does to the light that passes it, besides reflecting a part: it absorbs, and darkens what lies below by
//! the light that goes to and fro.
//!
//! OpenPBR 1.1, sections "View-dependent absorption" and "Darkening"; [`crate::openpbr`] and the coat of [`crate::gltf`] share it.

use crate::{fresnel_term::dielectric_average, math};
use etendue_color::Spectrum;

/// What the darkening must know of the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Under {
    /// Its albedo at normal incidence.
    pub albedo: Spectrum,
    /// How rough it is to the light within the coat: r_b of OpenPBR 1.1, equation "base_roughness_estimate".
    pub roughness: f32,
}

impl Under {
    /// A base of a dielectric with reflectance `f0` at normal incidence, tinted by `tint`, over what returns `substrate`; mixed with a
    /// metal of F0 `metal`. `roughness` is the perceptual one of its microfacets.
    #[inline]
    pub fn new(
        f0: f32,
        tint: Spectrum,
        substrate: Spectrum,
        metal: Spectrum,
        metallic: f32,
        roughness: f32,
    ) -> Self {
        let dielectric = tint * f0 + substrate * (1.0 - f0);
        // OpenPBR 1.1, equations "dielectric_roughness_estimate" and "base_roughness_estimate".
        let dielectric_roughness = 1.0 + (roughness - 1.0) * f0;
        Self {
            albedo: dielectric.lerp(metal, metallic),
            roughness: dielectric_roughness + (roughness - dielectric_roughness) * metallic,
        }
    }
}

/// The layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Varnish {
    inv_eta2: f32,
    /// ln of the transmittance of one crossing at normal incidence; `None` if the layer is clear.
    log: Option<Spectrum>,
    /// Albedo of the base at normal incidence, for the darkening.
    base: Spectrum,
    /// Coverage times how much of the darkening is there.
    darkening: f32,
    /// Internal diffuse reflection coefficient over a rough base, and how rough the base is.
    k_rough: f32,
    base_roughness: f32,
}

impl Varnish {
    /// `eta` is the index of the layer over that of the surroundings, `color` (0..1) what is left of light that goes through it to
    /// the base and back at normal incidence, `darkening` (0..1) the coverage times the part of the darkening that is there.
    #[inline]
    pub fn new(eta: f32, color: Spectrum, under: Under, darkening: f32) -> Self {
        Self {
            inv_eta2: 1.0 / (eta * eta),
            // The colour is that of two crossings.
            log: (color != Spectrum::ONE).then(|| color.map(|c| 0.5 * math::ln(c.max(1e-6)))),
            base: under.albedo,
            darkening,
            // OpenPBR 1.1, equation "internal_diffuse_reflection_coefficient_for_rough_base".
            k_rough: (1.0 - (1.0 - dielectric_average(eta)) / (eta * eta)).max(0.0).min(1.0),
            base_roughness: under.roughness,
        }
    }

    /// 1/µ within the layer for a cosine outside (OpenPBR 1.1, "View-dependent absorption": µ² = 1 − (1 − µ²) / η²).
    #[inline(always)]
    pub fn longer(&self, cos: f32) -> f32 {
        1.0 / (1.0 - (1.0 - cos * cos).max(0.0) * self.inv_eta2).max(1e-6).sqrt()
    }

    /// What is left of light that crosses the layer over `crossings` times its thickness.
    #[inline(always)]
    pub fn transmittance(&self, crossings: f32) -> Spectrum {
        match self.log {
            None => Spectrum::ONE,
            Some(log) => log.map(|l| math::exp(l * crossings)),
        }
    }

    /// The factor of the base by light that goes to and fro between layer and base, whose Fresnel term towards the viewer is
    /// `k_smooth` (OpenPBR 1.1, equations "general_darkening_formula" and "modulated_darkening_factor"):
    /// lerp(1, (1 − K) / (1 − E K), darkening).
    #[inline(always)]
    pub fn darkened(&self, k_smooth: f32) -> Spectrum {
        if self.darkening == 0.0 {
            return Spectrum::ONE;
        }
        let k = k_smooth + (self.k_rough - k_smooth) * self.base_roughness;
        // Keeps a white base white where K reaches one.
        const LEAST: f32 = 1e-6;
        let part = self.darkening;
        self.base.map(|e| {
            let delta = (1.0 - k + LEAST) / (1.0 - e * k + LEAST);
            1.0 + (delta.min(1.0) - 1.0) * part
        })
    }
}
