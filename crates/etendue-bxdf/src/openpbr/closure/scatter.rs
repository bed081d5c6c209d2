//! Value and density for a pair of directions, and the perfectly specular parts.

use super::{
    Beyond, OpenPbr,
    parts::{BASE, BEYOND, COAT, DIFFUSE, DIFFUSE_THROUGH, FUZZ},
    view::View,
};
use crate::{
    bsdf::{Bsdf, DeltaPart, Eval, MIN_COS},
    ggx::mirror,
    openpbr::coat::Coat,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// (x, y, −z).
#[inline(always)]
pub(super) fn turned_over(w: Vec3A) -> Vec3A {
    vec3a(w.x, w.y, -w.z)
}

impl OpenPbr {
    /// Value by lobe and density; `wo` above [`MIN_COS`], `wi` away from the horizon.
    #[inline]
    pub(super) fn eval_with(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = if wi.z > 0.0 { self.reflected(view, wo, wi) } else { self.passed(view, wo, wi) };
        if self.outer < 1.0 {
            e.diffuse *= self.outer;
            e.specular *= self.outer;
            if let Beyond::Inside(r) = &self.beyond {
                let inside = r.eval_pdf(wo, wi);
                let tint = if wi.z > 0.0 { Spectrum::ONE } else { self.exit(wi) };
                e.specular += inside.specular * tint * view.inside;
                e.pdf += view.p[BEYOND] * inside.pdf;
            }
        }
        if e.pdf < f32::INFINITY && e.specular.is_finite() && e.diffuse.is_finite() { e } else { Eval::ZERO }
    }

    /// What light that leaves a volume towards `wi` is multiplied by.
    #[inline(always)]
    fn exit(&self, wi: Vec3A) -> Spectrum {
        match &self.coat {
            None => self.passage,
            Some(c) => self.passage * Spectrum::ONE.lerp(c.transmittance(c.longer(-wi.z)), c.weight),
        }
    }

    /// The coat's factor of the base for a pair of directions; `crossings` of `wi` as 1/µ within the coat, 0 if `wi` does
    /// not cross it.
    #[inline(always)]
    fn over(&self, view: &View, far: impl Fn(&Coat) -> f32) -> Spectrum {
        match (&self.coat, &view.coat) {
            (Some(c), Some(v)) => c.over(v, v.longer + far(c)) * view.under,
            _ => view.under,
        }
    }

    #[inline]
    fn reflected(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = Eval::ZERO;
        if let Some(f) = &self.fuzz {
            let fuzz = f.lobe.eval_pdf(wo, wi);
            e.diffuse += fuzz.diffuse * f.weight;
            e.pdf += view.p[FUZZ] * fuzz.pdf;
        }
        if let (Some(c), Some(v)) = (&self.coat, &view.coat) {
            let up = c.local(wi);
            if !c.lobe.mirror && v.wo.z > MIN_COS && up.z > MIN_COS {
                let pair = c.lobe.ggx.pair(v.wo, up);
                // The lobe's cosine is the coat's; the contract's the base's.
                let cosine = if c.is_tilted() { up.z / wi.z } else { 1.0 };
                let value = pair.value * v.scale * c.fresnel(pair.cos_half) * view.under_fuzz * cosine;
                e.specular += Spectrum::splat(value);
                e.pdf += view.p[COAT] * pair.pdf;
            }
        }
        let over = self.over(view, |c| c.longer(c.local(wi).z));
        if !self.base.mirror {
            let pair = self.base.ggx.pair(wo, wi);
            let f = self.facets.at(pair.cos_half.min(1.0));
            let facets = f.metal * view.metal + f.opaque * view.opaque + f.tinted * view.clear;
            e.specular += facets * over * pair.value;
            e.pdf += view.p[BASE] * pair.pdf;
        }
        if let Beyond::Volume(r) = &self.beyond
            && r.reflects()
        {
            let outside = r.eval_pdf(wo, wi);
            e.specular += outside.specular * self.facets.tint() * over * self.mix.clear;
            e.pdf += view.p[BEYOND] * outside.pdf;
        }
        for (i, matte) in self.diffuse[..DIFFUSE_THROUGH - DIFFUSE].iter().enumerate() {
            if let Some(d) = matte {
                let lobe = d.lobe.eval_pdf(wo, wi);
                e.diffuse += lobe.diffuse * d.scale * view.substrate * over;
                e.pdf += view.p[DIFFUSE + i] * lobe.pdf;
            }
        }
        e
    }

    #[inline]
    fn passed(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = Eval::ZERO;
        let over = self.over(view, |_| 0.0);
        if let Some(d) = &self.diffuse[DIFFUSE_THROUGH - DIFFUSE] {
            let lobe = d.lobe.eval_pdf(wo, turned_over(wi));
            e.diffuse += lobe.diffuse * d.scale * view.substrate * over;
            e.pdf += view.p[DIFFUSE_THROUGH] * lobe.pdf;
        }
        match &self.beyond {
            Beyond::Sheet(lobe) if !lobe.mirror => {
                let pair = lobe.ggx.pair(wo, turned_over(wi));
                let passed = self.facets.at(pair.cos_half.min(1.0)).passed;
                e.specular += passed * view.through * over * pair.value;
                e.pdf += view.p[BEYOND] * pair.pdf;
            }
            Beyond::Volume(r) => {
                let inside = r.eval_pdf(wo, wi);
                e.specular += inside.specular * view.through * over;
                e.pdf += view.p[BEYOND] * inside.pdf;
            }
            _ => {}
        }
        e
    }

    /// The perfectly specular reflection of coat, base and, from inside, boundary together.
    #[inline]
    pub(super) fn mirrored(&self, view: &View, wo: Vec3A) -> Option<DeltaPart> {
        let mut reflectance = Spectrum::ZERO;
        let mut probability = 0.0;
        if let (Some(c), Some(v)) = (&self.coat, &view.coat)
            && c.lobe.mirror
        {
            reflectance += Spectrum::splat(v.scale * c.fresnel(wo.z) * view.under_fuzz);
            probability += view.p[COAT];
        }
        if self.base.mirror {
            let f = self.facets.at(wo.z);
            let facets = f.metal * view.metal + f.opaque * view.opaque + f.tinted * view.clear;
            reflectance += facets * self.over(view, |c| c.longer(c.local(mirror(wo)).z));
            probability += view.p[BASE];
        }
        reflectance *= self.outer;
        if let Beyond::Inside(r) = &self.beyond
            && let [Some(d), _] = r.lobe.deltas(wo)
        {
            reflectance += d.reflectance * view.inside;
            probability += view.p[BEYOND] * d.probability;
        }
        // Shares that add up to one may miss it by a rounding.
        let probability = probability.min(1.0);
        (probability > 0.0).then_some(DeltaPart { wi: mirror(wo), reflectance, probability })
    }

    /// What passes in one direction.
    #[inline]
    pub(super) fn straight(&self, view: &View, wo: Vec3A) -> Option<DeltaPart> {
        match &self.beyond {
            Beyond::Sheet(lobe) if lobe.mirror && view.p[BEYOND] > 0.0 => {
                let passed = self.facets.at(wo.z).passed * view.through * self.over(view, |_| 0.0);
                // A sheet is no lens: it lets through what there is. (A film of absurd numbers may say otherwise.)
                let passed = passed.map(|v| v.max(0.0).min(1.0));
                Some(DeltaPart { wi: -wo, reflectance: passed, probability: view.p[BEYOND] })
            }
            Beyond::Volume(r) => {
                let d = r.lobe.deltas(wo)[1]?;
                let reflectance = d.reflectance * view.through * self.over(view, |_| 0.0);
                let probability = d.probability * view.p[BEYOND];
                (probability > 0.0).then_some(DeltaPart { reflectance, probability, ..d })
            }
            Beyond::Inside(r) => {
                let d = r.lobe.deltas(wo)[1]?;
                let reflectance = d.reflectance * self.exit(d.wi) * view.inside;
                let probability = d.probability * view.p[BEYOND];
                (probability > 0.0).then_some(DeltaPart { reflectance, probability, ..d })
            }
            _ => None,
        }
    }
}
