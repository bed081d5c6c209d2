//! The random walk of light between microfacets: the oracle for everything that compensates for it.
//!
//! Heitz, Hanika, d'Eon, Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model". Under Smith's
//! assumption (heights without correlation between neighbours) a rough surface is a volume of microfacets: a ray at height
//! h travels to a next height by a free-path law, meets a facet that is visible from its direction, reflects or refracts,
//! and so on until it leaves. Heights are even in −1..1 here, C(h) = (h + 1) / 2; the result does not depend on their
//! distribution (section 4.1). Estimates are stochastic, unbiased but for paths of more than [`Microsurface::MOST`] events.

use crate::{bsdf::MIN_COS, dielectric::Interface, fresnel_term::Fresnel, ggx::Ggx, math};
use etendue_color::Spectrum;
use glam::Vec3A;

/// A Fresnel term whose rest is absorbed: a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opaque<F>(pub F);

impl<F: Fresnel> Interface for Opaque<F> {
    #[inline(always)]
    fn eta(&self) -> f32 {
        1.0
    }
    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        self.0.eval(cos)
    }
    #[inline(always)]
    fn transmit(&self, _cos: f32) -> Spectrum {
        Spectrum::ZERO
    }
}

/// Where a walk ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walked {
    /// The direction in which it left, z < 0 on the far side.
    pub wi: Vec3A,
    /// What is left of the light, counted as power.
    pub weight: Spectrum,
    /// Facets met.
    pub order: u32,
}

/// A surface of GGX microfacets between two media (or before an [`Opaque`] one), as a random process.
///
/// Values and weights count power ([`crate::model::Transport::Importance`]). The interfaces are given for light from the
/// near side and for light from the far side. Media must not be matched (a facet would have to pass light straight).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microsurface<I> {
    ggx: Ggx,
    near: I,
    far: I,
}

/// A ray among the facets.
#[derive(Clone, Copy)]
struct Ray {
    /// Where it goes.
    direction: Vec3A,
    height: f32,
    /// On the near side of the facets.
    outside: bool,
}

fn cumulative(h: f32) -> f32 {
    (0.5 * (h + 1.0)).clamp(0.0, 1.0)
}

fn inverse(u: f32) -> f32 {
    (2.0 * u - 1.0).clamp(-1.0, 1.0)
}

/// x to the power of y, x in 0..1, y ≥ 0.
fn power(x: f32, y: f32) -> f32 {
    if y == 0.0 { 1.0 } else { math::exp(y * math::ln(x)) }
}

impl<I: Interface> Microsurface<I> {
    /// The most events that a walk may have; at roughness 1 less than 1e-9 of F = 1 walks are longer.
    pub const MOST: u32 = 400;

    /// α along x and y (0..1), and the interface as seen from the near side and from the far side.
    pub fn new(alpha: [f32; 2], near: I, far: I) -> Self {
        Self { ggx: Ggx::new(alpha[0], alpha[1]), near, far }
    }

    /// Λ of any direction, also downwards: (t / z − 1) / 2.
    fn lambda(&self, w: Vec3A) -> f32 {
        0.5 * (self.ggx.stretched_length(w) / w.z - 1.0)
    }

    /// Probability that a ray from height `h` towards `w` leaves upwards (eq. 13).
    fn escape(&self, w: Vec3A, h: f32) -> f32 {
        if w.z <= MIN_COS { 0.0 } else { power(cumulative(h), self.lambda(w)) }
    }

    /// The height at which a ray from `h` towards `w` meets a facet; `None` if it leaves (algorithm 1).
    fn next_height(&self, w: Vec3A, h: f32, u: f32) -> Option<f32> {
        if w.z.abs() < 1e-5 {
            return Some(h);
        }
        let lambda = self.lambda(w);
        if w.z > 0.0 && u > 1.0 - power(cumulative(h), lambda) {
            return None;
        }
        if w.z > 0.0 && lambda < 1e-7 {
            return None;
        }
        Some(inverse(cumulative(h) * power(1.0 - u, -1.0 / lambda)))
    }

    /// Density of the visible normals of any direction `v` (eq. 9): max(0, v·m) D(m) / σ(v), σ = (v.z + t(v)) / 2.
    fn visible(&self, v: Vec3A, m: Vec3A) -> f32 {
        let dot = v.dot(m);
        let area = 0.5 * (v.z + self.ggx.stretched_length(v));
        if dot > 0.0 && area > 0.0 { self.ggx.d(m) * dot / area } else { 0.0 }
    }

    /// What the facets that `ray` meets send towards `w`, which leaves on the near side or not: the phase function (eq. 11 and
    /// 16).
    fn phase(&self, ray: &Ray, w: Vec3A, leaves_outside: bool) -> Spectrum {
        // In a frame in which the ray is on the upper side.
        let flip = if ray.outside { 1.0 } else { -1.0 };
        let (v, w) = (-ray.direction * flip, w * flip);
        let interface = if ray.outside { &self.near } else { &self.far };
        if ray.outside == leaves_outside {
            let h = v + w;
            let len = h.length();
            if !(len > 1e-6) {
                return Spectrum::ZERO;
            }
            let m = h * (1.0 / len);
            let dot = v.dot(m);
            if !(dot > 1e-6) {
                return Spectrum::ZERO;
            }
            return interface.reflect(dot.min(1.0)) * (0.25 * self.visible(v, m) / dot);
        }
        let eta = interface.eta();
        if eta == 1.0 {
            return Spectrum::ZERO;
        }
        let h = v + w * eta;
        let m = h * (if eta > 1.0 { -1.0 } else { 1.0 } / h.length());
        let (near, far) = (v.dot(m), -w.dot(m));
        if !(m.z > 0.0 && near > 0.0 && far > 0.0) {
            return Spectrum::ZERO;
        }
        let density = self.visible(v, m) * eta * eta * far / h.length_squared();
        interface.transmit_between(near.min(1.0), far.min(1.0)) * density
    }

    /// The ray at its next facet; `None` if it has left.
    fn advance(&self, ray: &mut Ray, u: f32) -> Option<()> {
        let flip = if ray.outside { 1.0 } else { -1.0 };
        let h = self.next_height(ray.direction * flip, ray.height * flip, u)?;
        ray.height = h * flip;
        Some(())
    }

    /// Scatters the ray at a facet and gives the weight; zero if all is absorbed.
    fn scatter(&self, ray: &mut Ray, random: &mut impl FnMut() -> f32) -> Spectrum {
        let flip = if ray.outside { 1.0 } else { -1.0 };
        let v = -ray.direction * flip;
        let interface = if ray.outside { self.near } else { self.far };
        let m = self.ggx.sample_half(v, [random(), random()]);
        let cos = v.dot(m).clamp(0.0, 1.0);
        let (r, t) = (interface.reflect(cos), interface.transmit(cos));
        let sum = |s: Spectrum| s.0.iter().sum::<f32>();
        let all = sum(r) + sum(t);
        if !(all > 0.0) {
            return Spectrum::ZERO;
        }
        let p = sum(r) / all;
        let (w, weight) = if random() < p {
            (m * (2.0 * v.dot(m)) - v, r * (1.0 / p))
        } else {
            let Some(w) = crate::dielectric::refract(v, m, interface.eta()) else { return Spectrum::ZERO };
            ray.outside = !ray.outside;
            (w, t * (1.0 / (1.0 - p)))
        };
        ray.direction = (w * flip).normalize_or(Vec3A::Z);
        weight
    }

    /// A ray that comes in against `wo`.
    fn enter(wo: Vec3A) -> Ray {
        Ray { direction: -wo, height: 1.0, outside: true }
    }

    /// Walks from `wo` (above the surface) until the light leaves; `None` if it is absorbed or walks too long.
    pub fn sample(&self, wo: Vec3A, mut random: impl FnMut() -> f32) -> Option<Walked> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let mut ray = Self::enter(wo);
        let mut weight = Spectrum::ONE;
        for order in 0..Self::MOST {
            if self.advance(&mut ray, random()).is_none() {
                return (order > 0).then_some(Walked { wi: ray.direction, weight, order });
            }
            weight *= self.scatter(&mut ray, &mut random);
            if weight.is_black() {
                return None;
            }
        }
        None
    }

    /// One unbiased estimate of f(wo, wi) |cos θi|, as [after one event, after more].
    pub fn eval(&self, wo: Vec3A, wi: Vec3A, mut random: impl FnMut() -> f32) -> [Spectrum; 2] {
        let mut sums = [Spectrum::ZERO; 2];
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return sums;
        }
        let leaves_outside = wi.z > 0.0;
        let mut ray = Self::enter(wo);
        let mut weight = Spectrum::ONE;
        for order in 0..Self::MOST {
            if self.advance(&mut ray, random()).is_none() {
                break;
            }
            let seen =
                if leaves_outside { self.escape(wi, ray.height) } else { self.escape(-wi, -ray.height) };
            let value = self.phase(&ray, wi, leaves_outside) * seen * weight;
            if value.is_finite() {
                sums[usize::from(order > 0)] += value;
            }
            weight *= self.scatter(&mut ray, &mut random);
            if weight.is_black() {
                break;
            }
        }
        sums
    }
}
