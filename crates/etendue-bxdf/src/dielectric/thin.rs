//! A sheet so thin that light leaves it where it entered, and so flat that it leaves in its own direction.

use super::interface::Interface;
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    energy::Row,
    ggx::{ALPHA_DELTA, Ggx, mirror},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// A thin sheet with GGX microfacets: reflection, and transmission as a reflection lobe turned over to the far side.
///
/// f(wi above) = R(wo·m) D G2 / (4 cos θo cos θi); f(wi below) the same with T and the mirror image of wi in place of wi
/// (Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", section 5.3). Each of the
/// two lobes may have its own α; below [`ALPHA_DELTA`] it is perfectly specular. Give it [`super::Sheet`] for light
/// that goes to and fro between the faces. Reciprocal. Its [`Bsdf::albedo`] is the table's ([`crate::energy`]), exact for
/// interfaces on Schlick's curve, an estimate for others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinGgx<I> {
    interface: I,
    /// Of reflection and of transmission.
    ggx: [Ggx; 2],
    smooth: [bool; 2],
    row: [Row; 2],
    tint: [Spectrum; 2],
}

/// (x, y, −z).
#[inline(always)]
fn turned_over(w: Vec3A) -> Vec3A {
    vec3a(w.x, w.y, -w.z)
}

impl<I: Interface> ThinGgx<I> {
    /// α along x and y (0..1) of both lobes, and what each microfacet does.
    #[inline(always)]
    pub fn new(alpha: [f32; 2], interface: I) -> Self {
        let lobe = Lobe::new(alpha);
        Self {
            interface,
            ggx: [lobe.ggx; 2],
            smooth: [lobe.smooth; 2],
            row: [lobe.row; 2],
            tint: [Spectrum::ONE; 2],
        }
    }

    /// The same sheet with another α for what passes.
    #[inline(always)]
    pub fn with_transmission_alpha(mut self, alpha: [f32; 2]) -> Self {
        let lobe = Lobe::new(alpha);
        (self.ggx[1], self.smooth[1], self.row[1]) = (lobe.ggx, lobe.smooth, lobe.row);
        self
    }

    /// The same sheet with reflected and transmitted light multiplied by colours (lanes ≥ 0; negative and NaN become 0).
    #[inline(always)]
    pub fn tinted(mut self, reflection: Spectrum, transmission: Spectrum) -> Self {
        self.tint = [reflection, transmission].map(|s| s.map(|v| v.max(0.0).min(1e6)));
        self
    }

    /// What a facet does on one side (0 reflects, 1 lets through).
    #[inline(always)]
    fn facet(&self, side: usize, cos: f32) -> Spectrum {
        let cos = cos.min(1.0);
        let part = if side == 0 { self.interface.reflect(cos) } else { self.interface.transmit(cos) };
        part * self.tint[side]
    }

    /// The parts of the light from `wo` that are reflected and that pass; see the type for how near.
    #[inline]
    pub fn energy(&self, wo: Vec3A) -> [Spectrum; 2] {
        if !(wo.z > MIN_COS) {
            return [Spectrum::ZERO; 2];
        }
        core::array::from_fn(|side| {
            if self.smooth[side] {
                return self.facet(side, wo.z);
            }
            let albedo = self.row[side].directional(wo.z);
            let mean = match side {
                0 => self.interface.reflect_mean(wo, albedo.w),
                _ => self.interface.transmit_mean(wo, albedo.w),
            };
            mean * self.tint[side] * albedo.e
        })
    }

    /// Probability that a reflection is drawn.
    #[inline(always)]
    fn p_reflect(&self, wo: Vec3A) -> f32 {
        let [r, t] = self.energy(wo).map(|s| s.0.iter().sum::<f32>());
        let p = if r + t > 0.0 { r / (r + t) } else { 1.0 };
        if self.tint[0].is_black() {
            0.0
        } else if self.tint[1].is_black() {
            1.0
        } else if self.smooth == [true; 2] {
            // A side of less than a millionth is never picked: one over its probability could leave f32.
            if p < 1e-6 {
                0.0
            } else if p > 1.0 - 1e-6 {
                1.0
            } else {
                p
            }
        } else {
            // Facets at odd angles may do what the mean facet does not.
            p.clamp(0.02, 0.98)
        }
    }

    /// Value and density on one side, for `wi` turned to the upper side.
    #[inline(always)]
    fn side(&self, side: usize, p_reflect: f32, wo: Vec3A, up: Vec3A) -> Eval {
        let pair = self.ggx[side].pair(wo, up);
        let p = if side == 0 { p_reflect } else { 1.0 - p_reflect };
        let (specular, pdf) = (self.facet(side, pair.cos_half) * pair.value, p * pair.pdf);
        if pdf < f32::INFINITY && specular.is_finite() {
            Eval { diffuse: Spectrum::ZERO, specular, pdf }
        } else {
            Eval::ZERO
        }
    }
}

/// The parts of a lobe that its α decides.
struct Lobe {
    ggx: Ggx,
    smooth: bool,
    row: Row,
}

impl Lobe {
    #[inline(always)]
    fn new([ax, ay]: [f32; 2]) -> Self {
        let ggx = Ggx::new(ax, ay);
        let [x, y] = ggx.alpha();
        // Roughness of the mean α: α = roughness².
        Self { ggx, smooth: !(ax.max(ay) >= ALPHA_DELTA), row: Row::new((x * y).sqrt().sqrt()) }
    }
}

impl<I: Interface> Bsdf for ThinGgx<I> {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        let (side, up) = if wi.z > 0.0 { (0, wi) } else { (1, turned_over(wi)) };
        if self.smooth[side] {
            return Eval::ZERO;
        }
        self.side(side, self.p_reflect(wo), wo, up)
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let p_reflect = self.p_reflect(wo);
        let side = if uc.max(0.0) < p_reflect { 0 } else { 1 };
        let (up, weight, pdf) = if self.smooth[side] {
            let p = if side == 0 { p_reflect } else { 1.0 - p_reflect };
            (mirror(wo), self.facet(side, wo.z) * (1.0 / p), p)
        } else {
            let up = self.ggx[side].sample_reflection(wo, u);
            if !(up.z > MIN_COS) {
                return None;
            }
            let e = self.side(side, p_reflect, wo, up);
            (up, e.specular * (up.z / e.pdf), e.pdf)
        };
        if !(pdf > 0.0 && up.is_finite()) {
            return None;
        }
        Some(BsdfSample {
            wi: if side == 0 { up } else { turned_over(up) },
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf,
            delta: self.smooth[side],
            lobe: LobeKind::Specular,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        let [r, t] = self.energy(wo);
        r + t
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return [None, None];
        }
        let p = self.p_reflect(wo);
        let part = |side: usize, wi: Vec3A, probability: f32| {
            (self.smooth[side] && probability > 0.0).then(|| DeltaPart {
                wi,
                reflectance: self.facet(side, wo.z),
                probability,
            })
        };
        [part(0, mirror(wo), p), part(1, -wo, 1.0 - p)]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        let mut out = [1.0f32; 2];
        for (ggx, smooth) in self.ggx.iter().zip(self.smooth) {
            if !smooth {
                let a = ggx.alpha();
                out = [out[0].min(a[0]), out[1].min(a[1])];
            }
        }
        out
    }

    #[inline]
    fn refraction(&self) -> Option<f32> {
        if self.tint[1].is_black() { None } else { Some(1.0) }
    }
}
