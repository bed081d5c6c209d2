//! A rough boundary that keeps all light.
//!
//! Single scattering loses what is masked on its way out, and what leaves a microfacet towards the wrong side of the surface.
//! From inside a dense medium that is up to nine tenths, and how much depends on both widths, on the azimuth, on the index
//! and on films: more than a table holds. So nothing is looked up here; light that finds no way out goes where its next
//! events would most likely bring it, *into the denser medium*: what is in the thinner one meets another microfacet and
//! enters, what is in the denser one is totally reflected.
//!
//! With pr and pt the densities by which visible microfacets send light (Dv: Heitz 2014, eq. 16), w' being w mirrored at the
//! surface, and g(w) = G2 / G1 the part of the light towards w that is not masked,
//!
//! ```text
//! pr(w) = R(wo·m) Dv(m) / (4 wo·m),   pt(w) = T(wo·m) Dv(m) η² |w·m| / |wo + η w|²,
//! f |cos θi| = g(wi) thin(wi)                                              on the side of the thinner medium,
//!              dense(wi) + dense(wi') + thin(wi) + (1 − g(wi')) thin(wi')  on that of the denser one,
//! ```
//!
//! where (thin, dense) is (pr, pt) from the thinner medium and (pt, pr) from the denser one. ∫ f |cos θi| = R + T = 1 for
//! each `wo`, whatever the microfacets reflect. The price is reciprocity. Towards the thinner medium this is single
//! scattering. A random walk over the microfacets ([`crate::multiscatter::Microsurface`]) reflects, from outside at 60° and index
//! 1.5, 0.059 at roughness 0.6 and 0.027 at roughness 1; this 0.055 and 0.024. From inside it reflects 0.82 and 0.66, this
//! 0.84 and 0.74; they differ most from inside at normal incidence and roughness 1, 0.41 and 0.61.

use super::{
    Interface,
    rough::{GgxDielectric, Split, refract},
};
use crate::{
    bsdf::{Eval, MIN_COS},
    math::beta,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

impl<I: Interface> GgxDielectric<I> {
    /// Value and density of the lobe that keeps all light, for a boundary of which [`GgxDielectric::is_rough`] is true.
    ///
    /// A microfacet met at an angle of cosine x reflects `reflect(x)` and lets the rest pass: it must reflect all where
    /// nothing can be refracted. `wo` above the surface, `wi` on either side, both more than [`MIN_COS`] away from it.
    #[inline]
    pub fn whole_eval_pdf(&self, wo: Vec3A, wi: Vec3A, reflect: impl Fn(f32) -> Spectrum) -> Eval {
        // From the thinner medium what is in it is reflected, from the denser one it has passed.
        let far_is_denser = self.eta > 1.0;
        let dense = |w| {
            if far_is_denser { self.refracted(wo, w, &reflect) } else { self.reflected(wo, w, &reflect) }
        };
        let thin = |w| {
            if far_is_denser { self.reflected(wo, w, &reflect) } else { self.refracted(wo, w, &reflect) }
        };
        let seen = |w| if far_is_denser { self.seen_mirrored(wo, w) } else { self.seen_bent(wo, w) };
        let mut sum = Sum { value: Spectrum::ZERO, pdf: 0.0 };
        if (wi.z < 0.0) == far_is_denser {
            let other = vec3a(wi.x, wi.y, -wi.z);
            sum.add(dense(wi), 1.0);
            sum.add(dense(other), 1.0);
            sum.add(thin(wi), 1.0);
            sum.add(thin(other), 1.0 - seen(other));
        } else {
            sum.add(thin(wi), seen(wi));
        }
        let visible = 2.0 / (wo.z + self.ggx.stretched_length(wo));
        let scale = if wi.z < 0.0 { self.scale } else { 1.0 };
        Eval {
            diffuse: Spectrum::ZERO,
            specular: sum.value * (visible * scale / wi.z.abs()),
            pdf: sum.pdf * visible,
        }
    }

    /// A direction of that lobe.
    #[inline]
    pub fn whole_sample(
        &self,
        wo: Vec3A,
        uc: f32,
        u: [f32; 2],
        reflect: impl Fn(f32) -> Spectrum,
    ) -> Option<Vec3A> {
        let m = self.ggx.sample_half(wo, u);
        let cos = wo.dot(m);
        let p = self.parts(cos, &reflect).p_reflect;
        let far_is_denser = self.eta > 1.0;
        // What is left of `uc` decides about masking.
        let (mut wi, masked) = if uc < p {
            let wi = m * (2.0 * cos) - wo;
            (wi, far_is_denser && wi.z > 0.0 && uc >= p * self.seen_mirrored(wo, wi))
        } else {
            let wi = refract(wo, m, self.eta)?;
            (wi, !far_is_denser && wi.z < 0.0 && uc - p >= (1.0 - p) * self.seen_bent(wo, wi))
        };
        // The side on which the light ends: that of the denser medium, except for what gets out to the thinner one.
        let thin_part = (uc < p) == far_is_denser;
        let out = thin_part && !masked && (wi.z > 0.0) == far_is_denser;
        wi.z = if out == far_is_denser { wi.z.abs() } else { -wi.z.abs() };
        (wi.z.abs() > MIN_COS && wi.is_finite()).then_some(wi)
    }

    #[inline(always)]
    fn parts(&self, cos: f32, reflect: &impl Fn(f32) -> Spectrum) -> Split {
        // A film's sum of waves may miss 0 or 1 by a rounding.
        let reflected = reflect(cos.min(1.0)).map(|v| v.max(0.0).min(1.0));
        self.split(reflected, Spectrum::ONE - reflected)
    }

    /// pr over the normalisation of the visible normals, by lane, and its part of the density.
    #[inline(always)]
    fn reflected(&self, wo: Vec3A, w: Vec3A, reflect: &impl Fn(f32) -> Spectrum) -> (Spectrum, f32) {
        let Some((cos, density)) = self.mirror_density(wo, w) else { return (Spectrum::ZERO, 0.0) };
        let split = self.parts(cos, reflect);
        (split.reflected * density, split.p_reflect * density)
    }

    /// pt, likewise.
    #[inline(always)]
    fn refracted(&self, wo: Vec3A, w: Vec3A, reflect: &impl Fn(f32) -> Spectrum) -> (Spectrum, f32) {
        let Some((cos, density)) = self.bent_density(wo, w) else { return (Spectrum::ZERO, 0.0) };
        let split = self.parts(cos, reflect);
        (split.transmitted * density, (1.0 - split.p_reflect) * density)
    }

    /// g of reflection into `w`, above the surface.
    #[inline(always)]
    fn seen_mirrored(&self, wo: Vec3A, w: Vec3A) -> f32 {
        let o = 0.5 + 0.5 * self.ggx.stretched_length(wo) / wo.z;
        let i = 0.5 + 0.5 * self.ggx.stretched_length(w) / w.z;
        // i is 1 or more, but for rounding.
        (o / (o + i - 1.0)).min(1.0)
    }

    /// g of refraction into `w`, below the surface.
    #[inline(always)]
    fn seen_bent(&self, wo: Vec3A, w: Vec3A) -> f32 {
        let o = 0.5 + 0.5 * self.ggx.stretched_length(wo) / wo.z;
        let i = 0.5 + 0.5 * self.ggx.stretched_length(w) / -w.z;
        (beta(o, i) * o).min(1.0)
    }

    /// Cosine at the microfacet that mirrors `wo` into `w`, and D / 4 of it; `None` if there is none.
    #[inline(always)]
    fn mirror_density(&self, wo: Vec3A, w: Vec3A) -> Option<(f32, f32)> {
        let h = wo + w;
        (h.z > 0.0).then(|| (0.5 * h.length(), 0.25 * self.ggx.d_along(h)))
    }

    /// Cosine at the microfacet that bends `wo` into `w`, and D (wo·m) η² |w·m| / |wo + η w|²; `None` if there is none.
    #[inline(always)]
    fn bent_density(&self, wo: Vec3A, w: Vec3A) -> Option<(f32, f32)> {
        // The half vector points into the thinner medium; the facet's normal to wo's side.
        let side = if self.eta > 1.0 { -1.0 } else { 1.0 };
        let h = (wo + w * self.eta) * side;
        let (oh, ih) = (wo.dot(h), w.dot(h));
        // Also taken by NaN.
        if !(h.z > 0.0 && oh > 0.0 && ih < 0.0) {
            return None;
        }
        let len2 = h.length_squared();
        let density = self.ggx.d_along(h) * (oh * -ih) / (len2 * len2) * (self.eta * self.eta);
        Some((oh / len2.sqrt(), density))
    }
}

/// Value and density in the making.
struct Sum {
    value: Spectrum,
    pdf: f32,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, (value, pdf): (Spectrum, f32), share: f32) {
        self.value += value * share;
        self.pdf += pdf * share;
    }
}
