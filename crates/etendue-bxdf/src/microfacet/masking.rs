//! How much of the facets can be seen.

use super::{Distribution, v_cavity_g1};
use glam::Vec3A;

/// A masking and shadowing term. `h` is the half vector, of any length; all directions lie above the surface.
pub trait Masking: Copy {
    /// The part of the facets of normal `h` that `w` sees, 0..1.
    fn g1<D: Distribution>(&self, d: &D, w: Vec3A, h: Vec3A) -> f32;

    /// The part of them that both directions see, 0..1, symmetric in the directions.
    fn g2<D: Distribution>(&self, d: &D, wo: Vec3A, wi: Vec3A, h: Vec3A) -> f32;
}

/// Smith's with heights correlated: 1 / (1 + Λ(wo) + Λ(wi)) (Ross et al. 2005; Heitz 2014, eq. 99).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smith;

impl Masking for Smith {
    #[inline(always)]
    fn g1<D: Distribution>(&self, d: &D, w: Vec3A, _h: Vec3A) -> f32 {
        1.0 / (1.0 + d.lambda(w))
    }

    #[inline(always)]
    fn g2<D: Distribution>(&self, d: &D, wo: Vec3A, wi: Vec3A, _h: Vec3A) -> f32 {
        1.0 / (1.0 + d.lambda(wo) + d.lambda(wi))
    }
}

/// Smith's as if masking and shadowing were independent: G1(wo) G1(wi) (Smith 1967; Heitz 2014, eq. 98): darker than
/// [`Smith`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SmithSeparable;

impl Masking for SmithSeparable {
    #[inline(always)]
    fn g1<D: Distribution>(&self, d: &D, w: Vec3A, _h: Vec3A) -> f32 {
        1.0 / (1.0 + d.lambda(w))
    }

    #[inline(always)]
    fn g2<D: Distribution>(&self, d: &D, wo: Vec3A, wi: Vec3A, _h: Vec3A) -> f32 {
        1.0 / ((1.0 + d.lambda(wo)) * (1.0 + d.lambda(wi)))
    }
}

/// Schlick's rational curve c / (c (1 − k) + k) for each direction (Schlick 1994, eq. 19), whatever the distribution.
///
/// Near GGX's G1 for k = α/2. With the k that engines use it is no distribution's masking: [`SchlickGgx::direct`] remaps
/// the roughness to (r + 1)/2 first "to reduce hotness" (Karis 2013, "Real Shading in Unreal Engine 4"), which masks too
/// much of a smooth surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchlickGgx {
    k: f32,
    least: f32,
}

impl SchlickGgx {
    /// From k, clamped to 0..1; NaN to 0.
    #[inline(always)]
    pub fn new(k: f32) -> Self {
        Self { k: k.max(0.0).min(1.0), least: 0.0 }
    }

    /// k = (r + 1)² / 8 for light from single directions; `roughness` perceptual, clamped to 0..1.
    #[inline(always)]
    pub fn direct(roughness: f32) -> Self {
        let r = roughness.max(0.0).min(1.0) + 1.0;
        Self::new(r * r / 8.0)
    }

    /// k = r² / 2 for light from everywhere; `roughness` perceptual, clamped to 0..1.
    #[inline(always)]
    pub fn indirect(roughness: f32) -> Self {
        let r = roughness.max(0.0).min(1.0);
        Self::new(r * r / 2.0)
    }

    /// The same with the denominator kept above `least`, as shaders do against division by zero.
    #[inline(always)]
    pub fn with_least_denominator(self, least: f32) -> Self {
        Self { least, ..self }
    }

    #[inline(always)]
    fn one(&self, c: f32) -> f32 {
        c / (c * (1.0 - self.k) + self.k).max(self.least)
    }
}

impl Masking for SchlickGgx {
    #[inline(always)]
    fn g1<D: Distribution>(&self, _d: &D, w: Vec3A, _h: Vec3A) -> f32 {
        self.one(w.z.abs())
    }

    #[inline(always)]
    fn g2<D: Distribution>(&self, _d: &D, wo: Vec3A, wi: Vec3A, _h: Vec3A) -> f32 {
        self.one(wo.z.abs()) * self.one(wi.z.abs())
    }
}

/// Facets as the two sides of grooves: min(1, 2 cos θm cos θo / (wo·m), 2 cos θm cos θi / (wo·m)) (Torrance, Sparrow 1967;
/// Cook, Torrance 1982, eq. 10). Conserves with any distribution; sharper than what surfaces do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VCavity;

impl Masking for VCavity {
    #[inline(always)]
    fn g1<D: Distribution>(&self, _d: &D, w: Vec3A, h: Vec3A) -> f32 {
        v_cavity_g1(w, h)
    }

    #[inline(always)]
    fn g2<D: Distribution>(&self, _d: &D, wo: Vec3A, wi: Vec3A, h: Vec3A) -> f32 {
        v_cavity_g1(wo, h).min(v_cavity_g1(wi, h))
    }
}
