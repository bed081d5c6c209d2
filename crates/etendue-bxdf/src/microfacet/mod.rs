//! Microfacet reflection in parts: a distribution of normals, a masking term, a Fresnel term.
//!
//! f = F(wo·m) D(m) G2(wo, wi, m) / (4 cos θo cos θi), m the half vector (Cook, Torrance 1982, in the form of Walter et al.
//! 2007, eq. 20). [`Microfacet`] puts any [`Distribution`], [`Masking`] and [`crate::Fresnel`] together at compile time.
//! The lobe of daily use is [`crate::GgxReflection`], which is the combination GGX, height-correlated Smith and Schlick
//! with fewer operations. [`crate::ggx::anisotropic_alpha`] makes αx and αy of a perceptual roughness and an
//! anisotropy.
//!
//! | distribution | Λ for Smith's masking | visible normals |
//! |---|---|---|
//! | [`Ggx`] | exact | Smith's, by spherical caps |
//! | [`Beckmann`] | exact | Smith's, by Jakob's inversion |
//! | [`Gtr`] | GGX's of the same α; exact for γ = 2 | V-cavities' |
//! | [`BlinnPhong`] | Beckmann's of the same α | V-cavities' |
//!
//! Where Λ is exact, ∫ G1 D (wo·m)⁺ dm = cos θo, and no combination with Smith's masking reflects more than it receives.
//! Where it is not, energy is lost or made by what the shapes differ: F = 1, α = 0.0002, γ = 0.5 returns 18 of a sky of
//! radiance 1 at 89° (the worst of the grid in `tests/microfacets.rs`). [`VCavity`] keeps the balance for any distribution.

mod any;
mod beckmann;
mod blinn_phong;
mod gtr;
mod lobe;
mod masking;

pub use any::{AnyDistribution, AnyMasking};
pub use beckmann::Beckmann;
pub use blinn_phong::BlinnPhong;
pub use gtr::Gtr;
pub use lobe::Microfacet;
pub use masking::{Masking, SchlickGgx, Smith, SmithSeparable, VCavity};

use crate::ggx::Ggx;
use core::f32::consts::FRAC_1_PI;
use glam::{Vec3A, vec3a};

/// A distribution of microfacet normals.
///
/// `h` is a half vector of any length with z > 0: at the unnormalised `wo + wi` no digit of a tight lobe is lost.
pub trait Distribution: Copy {
    /// D at the direction of `h`, per steradian: area of the facets that face there, per area of the surface.
    fn d(&self, h: Vec3A) -> f32;

    /// Smith's Λ for a direction above or below the surface; the module's head says how near to the exact one.
    fn lambda(&self, w: Vec3A) -> f32;

    /// A normal, density D(m) cos θm per steradian.
    fn sample(&self, u: [f32; 2]) -> Vec3A;

    /// A normal that is visible from `wo`, density [`Distribution::visible_g1`] · D(m) (wo·m)⁺ / cos θo per steradian; `uc`
    /// is one more number in 0..1.
    fn sample_visible(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A;

    /// The masking term of [`Distribution::sample_visible`]'s density.
    fn visible_g1(&self, wo: Vec3A, h: Vec3A) -> f32;

    /// The widths along x and y, as the α of the GGX that is most alike.
    fn alpha(&self) -> [f32; 2];
}

impl Distribution for Ggx {
    #[inline]
    fn d(&self, h: Vec3A) -> f32 {
        let [ax, ay] = self.alpha();
        let (x, y) = (h.x / ax, h.y / ay);
        let r = h.length_squared() / (x * x + y * y + h.z * h.z);
        if h.z > 0.0 { FRAC_1_PI / (ax * ay) * r * r } else { 0.0 }
    }

    #[inline]
    fn lambda(&self, w: Vec3A) -> f32 {
        Ggx::lambda(self, w)
    }

    /// Slopes are √(u / (1 − u)) α (Walter et al. 2007, eq. 35).
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec3A {
        let [ax, ay] = self.alpha();
        let u1 = u[1].max(0.0).min(1.0);
        let (r, z) = (u1.sqrt(), (1.0 - u1).sqrt());
        let (s, c) = crate::math::sin_cos_tau(u[0]);
        normalized(vec3a(ax * r * c, ay * r * s, z))
    }

    #[inline]
    fn sample_visible(&self, wo: Vec3A, _uc: f32, u: [f32; 2]) -> Vec3A {
        self.sample_half(wo, u)
    }

    #[inline]
    fn visible_g1(&self, wo: Vec3A, _h: Vec3A) -> f32 {
        self.g1(wo)
    }

    #[inline]
    fn alpha(&self) -> [f32; 2] {
        Ggx::alpha(self)
    }
}

/// A vector over its length.
#[inline(always)]
fn normalized(v: Vec3A) -> Vec3A {
    v * (1.0 / v.length_squared().sqrt())
}

/// The part of the facets of normal `h` that a V-cavity leaves visible from `w`: min(1, 2 cos θm cos θw / (w·m)) (Torrance,
/// Sparrow 1967; Heitz 2014, section 4.2).
///
/// `h` of any length. Keeps ∫ G1 D (w·m)⁺ dm = cos θw for every distribution that is symmetric under a half turn.
#[inline(always)]
pub fn v_cavity_g1(w: Vec3A, h: Vec3A) -> f32 {
    let dot = w.dot(h);
    if !(dot > 0.0) {
        return 0.0;
    }
    (2.0 * h.z * w.z.abs() / dot).min(1.0)
}

/// Of the two sides `m` and its half turn of a V-cavity the one that `wo` sees, each with the probability of its projected
/// area (Heitz, d'Eon 2014, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals",
/// section 4).
#[inline(always)]
fn v_cavity_side(wo: Vec3A, m: Vec3A, uc: f32) -> Vec3A {
    let turned = vec3a(-m.x, -m.y, m.z);
    let (a, b) = (wo.dot(m).max(0.0), wo.dot(turned).max(0.0));
    if uc * (a + b) < b { turned } else { m }
}
