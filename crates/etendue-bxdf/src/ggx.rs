//! The Trowbridge-Reitz (GGX) microfacet lobe, isotropic and anisotropic.
//!
//! Symbols: `m` a microfacet's normal; `αx`, `αy` the widths along the local x and y axes (α = roughness², perceptual
//! roughness 0..1); `t(w) = √(αx² wx² + αy² wy² + wz²)`, the length of a direction stretched by α, which all of
//! Smith's masking for GGX is made of: Λ(w) = (t/|wz| − 1) / 2.
//!
//! How precision is kept down to [`ALPHA_DELTA`] in `f32`: no formula here has 1 − cos² in it. The distribution is
//! taken at the *unnormalised* half vector `wo + wi`, whose x and y are small sums of large numbers and therefore
//! exact to the rounding of the inputs; its length gives the half angle's cosine.

use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    fresnel::Schlick,
    math::sin_cos_tau,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// Below this α in both directions a lobe is a perfect mirror.
///
/// α = 1e-4 (roughness 0.01) has a lobe of 0.02° across: a twenty-fifth of the sun, a quarter of a pixel of a 16k
/// environment. A mirror in its place reflects the same energy to 1e-4, and costs no precision.
pub const ALPHA_DELTA: f32 = 0.95e-4;

/// αx and αy of a perceptual roughness and an anisotropy, both clamped to 0..1, NaN to 0 (Burley 2012, "Physically Based
/// Shading at Disney", addenda: aspect = √(1 − 0.9 a), αx = α / aspect, αy = α · aspect, α = roughness²).
#[inline(always)]
pub fn anisotropic_alpha(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let (r, a) = (roughness.max(0.0).min(1.0), anisotropy.max(0.0).min(1.0));
    let alpha = r * r;
    let aspect = (1.0 - 0.9 * a).sqrt();
    [alpha / aspect, alpha * aspect]
}

/// The distribution of microfacet normals (Trowbridge, Reitz 1975; Walter et al. 2007) with Smith's masking
/// (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    ax: f32,
    ay: f32,
    inv_ax: f32,
    inv_ay: f32,
    /// 1 / (π αx αy).
    norm: f32,
    /// min(αx, αy)².
    a2: f32,
}

/// What a pair of directions above the surface needs: computed together because the terms share their parts.
#[derive(Clone, Copy, Debug)]
pub struct GgxPair {
    /// D(m) · G2 / (4 cos θo cos θi), 1/sr: the reflected lobe for F = 1, without the cosine.
    pub value: f32,
    /// Density of [`Ggx::sample_reflection`], per steradian.
    pub pdf: f32,
    /// Cosine between either direction and the half vector.
    pub cos_half: f32,
}

impl Ggx {
    /// Widths along x and y, clamped to [`ALPHA_DELTA`]..1; NaN becomes the lower end.
    #[inline(always)]
    pub fn new(alpha_x: f32, alpha_y: f32) -> Self {
        let ax = alpha_x.max(ALPHA_DELTA).min(1.0);
        let ay = alpha_y.max(ALPHA_DELTA).min(1.0);
        let (inv_ax, inv_ay) = (1.0 / ax, 1.0 / ay);
        let a = ax.min(ay);
        Self { ax, ay, inv_ax, inv_ay, norm: FRAC_1_PI * inv_ax * inv_ay, a2: a * a }
    }

    /// αx and αy.
    #[inline(always)]
    pub fn alpha(&self) -> [f32; 2] {
        [self.ax, self.ay]
    }

    /// D(m), per steradian, for a unit `m`: 1 / (π αx αy (mx²/αx² + my²/αy² + mz²)²) (Heitz 2014, eq. 85).
    #[inline(always)]
    pub fn d(&self, m: Vec3A) -> f32 {
        if !(m.z > 0.0) {
            return 0.0;
        }
        let (x, y) = (m.x * self.inv_ax, m.y * self.inv_ay);
        let q = x * x + y * y + m.z * m.z;
        self.norm / (q * q)
    }

    /// D(h / |h|), per steradian, for any `h` ≠ 0, also one that points down: keeps the digits of a half vector that
    /// was never normalised.
    #[inline(always)]
    pub fn d_along(&self, h: Vec3A) -> f32 {
        let (x, y) = (h.x * self.inv_ax, h.y * self.inv_ay);
        let r = h.length_squared() / (x * x + y * y + h.z * h.z);
        self.norm * (r * r)
    }

    /// t(w) of the module's head.
    #[inline(always)]
    pub fn stretched_length(&self, w: Vec3A) -> f32 {
        let (x, y) = (self.ax * w.x, self.ay * w.y);
        (x * x + y * y + w.z * w.z).sqrt()
    }

    /// Smith's Λ(w) (Heitz 2014, eq. 72 and 86).
    #[inline(always)]
    pub fn lambda(&self, w: Vec3A) -> f32 {
        0.5 * (self.stretched_length(w) / w.z.abs() - 1.0)
    }

    /// The part of the microfacets facing `w` that is visible from it: 1 / (1 + Λ(w)).
    #[inline(always)]
    pub fn g1(&self, w: Vec3A) -> f32 {
        let z = w.z.abs();
        2.0 * z / (z + self.stretched_length(w))
    }

    /// The part that is visible from both, heights correlated: 1 / (1 + Λ(wo) + Λ(wi)) (Heitz 2014, eq. 99).
    #[inline(always)]
    pub fn g2(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        let (zo, zi) = (wo.z.abs(), wi.z.abs());
        2.0 * zo * zi / (zi * self.stretched_length(wo) + zo * self.stretched_length(wi))
    }

    /// The bound k of the spherical cap for reflection (Eto, Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX
    /// Reflections", eq. 5), for α ≤ 1 and `wo` above the surface.
    #[inline(always)]
    fn cap_bound(&self, wo: Vec3A) -> f32 {
        let s = 1.0 + (wo.x * wo.x + wo.y * wo.y).sqrt();
        let s2 = s * s;
        (1.0 - self.a2) * s2 / (s2 + self.a2 * (wo.z * wo.z))
    }

    /// Value and density of a reflection; both directions must lie above [`MIN_COS`].
    #[inline(always)]
    pub fn pair(&self, wo: Vec3A, wi: Vec3A) -> GgxPair {
        // D at the unnormalised half vector h: D(h/|h|) = |h|⁴ / (π αx αy (hx²/αx² + hy²/αy² + hz²)²).
        let h = wo + wi;
        let len2 = h.length_squared();
        let (x, y) = (h.x * self.inv_ax, h.y * self.inv_ay);
        let r = len2 / (x * x + y * y + h.z * h.z);
        let d = self.norm * r * r;
        let (to, ti) = (self.stretched_length(wo), self.stretched_length(wi));
        GgxPair {
            // G2 / (4 cos cos) with the cosines of G2's numerator divided out.
            value: d * 0.5 / (wi.z * to + wo.z * ti),
            // Visible normals have density G1(wo) D(m) (wo·m) / cos θo; reflection divides by 4 (wo·m); the bounded
            // cap replaces cos θo + t by k cos θo + t (Eto, Tokuyoshi 2023, eq. 8).
            pdf: d * 0.5 / (self.cap_bound(wo) * wo.z + to),
            // |wo + wi| = 2 cos of half the angle between them.
            cos_half: 0.5 * len2.sqrt(),
        }
    }

    /// A visible microfacet normal, density G1(wo) D(m) max(0, wo·m) / cos θo per steradian: spherical caps (Dupuy,
    /// Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps").
    #[inline(always)]
    pub fn sample_half(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        self.sample_cap(wo, u, 1.0)
    }

    /// Density of [`Ggx::sample_half`], per steradian.
    #[inline(always)]
    pub fn pdf_half(&self, wo: Vec3A, m: Vec3A) -> f32 {
        let cos = wo.dot(m);
        if !(cos > 0.0 && wo.z > MIN_COS) {
            return 0.0;
        }
        2.0 * self.d(m) * cos / (wo.z + self.stretched_length(wo))
    }

    /// A reflected direction from a visible normal, with the cap bounded so that fewer fall below the horizon (Eto,
    /// Tokuyoshi 2023); density [`GgxPair::pdf`]. The direction may still lie below. The bound takes the variance of a
    /// furnace's weights, F = 1, from 0.107 to 0.016 at roughness 0.6 and from 0.133 to 0.020 at roughness 1 (normal
    /// incidence; the example `laws` prints the second figures).
    #[inline(always)]
    pub fn sample_reflection(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        let m = self.sample_cap(wo, u, self.cap_bound(wo));
        m * (2.0 * wo.dot(m)) - wo
    }

    /// A normal from the cap of the stretched sphere that reaches down to −k cos of the stretched `wo`.
    #[inline(always)]
    fn sample_cap(&self, wo: Vec3A, u: [f32; 2], k: f32) -> Vec3A {
        let i = vec3a(self.ax * wo.x, self.ay * wo.y, wo.z);
        let i = i * (1.0 / i.length_squared().sqrt());
        // z = 1 − u (1 + b) with b = k iz; the sine from 1 − z, not from z, to keep the digits near the pole.
        let drop = u[1] * (1.0 + k * i.z);
        let sin = (drop * (2.0 - drop)).max(0.0).sqrt();
        let (s, c) = sin_cos_tau(u[0]);
        let m = vec3a(self.ax * (sin * c + i.x), self.ay * (sin * s + i.y), (1.0 - drop) + i.z);
        m * (1.0 / m.length_squared().sqrt())
    }
}

/// A mirror made of GGX microfacets with a Schlick Fresnel: a metal, or the coat of a dielectric.
///
/// f = F(wo·m) D(m) G2(wo, wi) / (4 cos θo cos θi), single scattering (energy lost between microfacets is lost).
/// Reciprocal. Its [`Bsdf::albedo`] is an estimate. Below [`ALPHA_DELTA`] it is a perfect mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxReflection {
    ggx: Ggx,
    fresnel: Schlick,
    mirror: bool,
}

impl GgxReflection {
    /// Widths along x and y, 0..1 (α = roughness²), and the reflectance of each microfacet.
    #[inline(always)]
    pub fn new(alpha_x: f32, alpha_y: f32, fresnel: Schlick) -> Self {
        let mirror = !(alpha_x.max(alpha_y) >= ALPHA_DELTA);
        Self { ggx: Ggx::new(alpha_x, alpha_y), fresnel, mirror }
    }

    /// The distribution of its microfacets.
    #[inline(always)]
    pub fn ggx(&self) -> &Ggx {
        &self.ggx
    }
}

/// The mirror direction of `wo` about +Z.
#[inline(always)]
pub(crate) fn mirror(wo: Vec3A) -> Vec3A {
    vec3a(-wo.x, -wo.y, wo.z)
}

impl Bsdf for GgxReflection {
    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if self.mirror || !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let p = self.ggx.pair(wo, wi);
        if !(p.pdf < f32::INFINITY) {
            return Eval::ZERO;
        }
        Eval { diffuse: Spectrum::ZERO, specular: self.fresnel.eval(p.cos_half) * p.value, pdf: p.pdf }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3A, _uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let (wi, weight, pdf) = if self.mirror {
            (mirror(wo), self.fresnel.eval(wo.z), 1.0)
        } else {
            let wi = self.ggx.sample_reflection(wo, u);
            if !(wi.z > MIN_COS) {
                return None;
            }
            let p = self.ggx.pair(wo, wi);
            if !(p.pdf > 0.0 && p.pdf < f32::INFINITY) {
                return None;
            }
            (wi, self.fresnel.eval(p.cos_half) * (p.value * wi.z / p.pdf), p.pdf)
        };
        if !wi.is_finite() {
            return None;
        }
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf,
            delta: self.mirror,
            lobe: LobeKind::Specular,
        })
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if wo.z > MIN_COS { self.fresnel.eval(wo.z) } else { Spectrum::ZERO }
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let part = DeltaPart { wi: mirror(wo), reflectance: self.fresnel.eval(wo.z), probability: 1.0 };
        [(self.mirror && wo.z > MIN_COS).then_some(part), None]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.mirror { [1.0, 1.0] } else { self.ggx.alpha() }
    }
}
