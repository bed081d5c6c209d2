//! Disney's clear coat.

use crate::{
    fresnel::schlick_weight,
    microfacet::{Distribution, Gtr, v_cavity_g1},
};
use glam::Vec3A;

/// Smith's masking for GGX of width `alpha`, over twice the cosine: 1 / (cos + √(α² + cos² − α² cos²)).
///
/// A product of two of these is G / (4 cos θo cos θi) of separable masking.
#[inline(always)]
pub(super) fn masking(cos: f32, alpha: f32) -> f32 {
    let (a2, c2) = (alpha * alpha, cos * cos);
    1.0 / (cos + (a2 + c2 - a2 * c2).sqrt())
}

/// The coat: GTR with γ = 1 (Burley 2012, appendix B), Fresnel of index 1.5 by Schlick's curve, masking of GGX with α = 0.25
/// whatever the gloss, a quarter of the strength of a real coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    distribution: Gtr,
    /// A quarter of the strength.
    weight: f32,
}

impl Coat {
    /// Strength 0..1 and gloss 0 (satin, α = 0.1) .. 1 (α = 0.001).
    #[inline]
    pub fn new(strength: f32, gloss: f32) -> Self {
        Self { distribution: Gtr::new(0.1 + (0.001 - 0.1) * gloss, 1.0), weight: 0.25 * strength }
    }

    /// True if there is no coat.
    #[inline(always)]
    pub fn is_none(&self) -> bool {
        self.weight == 0.0
    }

    /// Width of the lobe.
    #[inline(always)]
    pub fn alpha(&self) -> f32 {
        self.distribution.alpha()[0]
    }

    /// About the part of the light that it reflects.
    #[inline(always)]
    pub fn albedo(&self, cos: f32) -> f32 {
        // Masking of α = 0.25 loses little but near grazing, where it keeps the product about even.
        self.weight * (0.04 + 0.96 * schlick_weight(cos)).min(0.5)
    }

    /// Value, 1/sr, and density of [`Coat::sample`], per steradian; both directions above the surface.
    #[inline(always)]
    pub fn pair(&self, wo: Vec3A, wi: Vec3A) -> (f32, f32) {
        let h = wo + wi;
        let d = self.distribution.d(h);
        let fresnel = 0.04 + 0.96 * schlick_weight(0.5 * h.length());
        let value = self.weight * fresnel * d * masking(wo.z, 0.25) * masking(wi.z, 0.25);
        // Visible from wo with the masking of V-cavities, and reflected: divided by 4 (wo·m).
        (value, v_cavity_g1(wo, h * (1.0 / h.length())) * d / (4.0 * wo.z))
    }

    /// A reflected direction; may lie below the horizon.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        let m = self.distribution.sample_visible(wo, uc, u);
        m * (2.0 * wo.dot(m)) - wo
    }
}
