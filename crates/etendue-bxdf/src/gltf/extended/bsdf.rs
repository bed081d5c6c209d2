//! The closure as a [`Bsdf`].

use super::Extended;
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    gltf::{
        body::Body,
        lobes::{COAT, FUZZ, SHEEN, SPECULAR, THROUGH, pick},
    },
};
use etendue_color::Spectrum;
use glam::Vec3A;

impl Bsdf for Extended {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        if self.is_bare() {
            let e = self.base.eval_pdf(wo, wi);
            return if e.pdf < f32::INFINITY { e } else { Eval::ZERO };
        }
        self.eval_at(&self.view(wo), wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let opaque = self.base.is_opaque();
        if self.is_bare() && !opaque && self.base.further.is_none() {
            return self.base.sample_bare(wo, uc, u);
        }
        let view = self.view(wo);
        let (lobe, uc) = pick(&view.p, uc);
        let kind = if matches!(lobe, COAT | SPECULAR) { LobeKind::Specular } else { LobeKind::Diffuse };
        let (wi, delta) = match (lobe, &self.coat, &self.sheen) {
            (COAT, Some(c), _) => (c.sample(wo, u)?, c.is_mirror()),
            (SHEEN, _, Some(s)) => (s.sample(wo, uc, u)?.wi, false),
            (SPECULAR, ..) => self.base.sample(wo, uc, u)?,
            (FUZZ, ..) => (self.fuzz.as_ref()?.sample(wo, uc, u)?, false),
            (THROUGH, ..) => (self.matte.sample(1, wo, uc, u), false),
            _ => (self.matte.sample(0, wo, uc, u), false),
        };
        let below = lobe == THROUGH || (lobe == SPECULAR && !opaque);
        if !(wi.z.abs() > MIN_COS && wi.is_finite()) || (!below && wi.z < 0.0) {
            return None;
        }
        if delta {
            let part = self.delta_parts(&view, wo)[if wi.z > 0.0 { 0 } else { 1 }]?;
            let weight = part.reflectance * (1.0 / part.probability);
            return Some(BsdfSample {
                wi: part.wi,
                weight,
                weight_diffuse: Spectrum::ZERO,
                weight_specular: weight,
                pdf: part.probability,
                delta: true,
                lobe: LobeKind::Specular,
            });
        }
        let e = self.eval_at(&view, wo, wi);
        if !(e.pdf > 0.0) {
            return None;
        }
        let scale = wi.z.abs() / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        Some(BsdfSample {
            wi,
            weight: weight_diffuse + weight_specular,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe: kind,
        })
    }

    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return Spectrum::ZERO;
        }
        let view = self.view(wo);
        let [reflected, passed] = self.base.energy(wo);
        let squeeze = match &self.base.body {
            Body::Solid(lobe) => lobe.albedo(wo) - reflected,
            _ => passed,
        };
        let (coat, sheen, fuzz) = if self.layers[0] {
            (self.coat.as_ref(), self.sheen.as_ref(), self.fuzz.as_ref())
        } else {
            (None, None, None)
        };
        let [mirrored, scattered] = coat.map_or([Spectrum::ONE; 2], |c| c.varnished_over(wo));
        let mut out = (reflected + squeeze) * view.layers[1] * mirrored;
        out += self.matte.albedo(wo, view.entering) * scattered;
        if let Some(c) = coat {
            out += Spectrum::splat(c.split(wo).1);
        }
        if let Some(s) = sheen {
            out += s.albedo(wo) * view.layers[0] * scattered;
        }
        out * view.over + fuzz.map_or(Spectrum::ZERO, |f| f.albedo(wo))
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return [None, None];
        }
        if self.is_bare() {
            return self.base.deltas(wo);
        }
        self.delta_parts(&self.view(wo), wo)
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        let base = self.base.narrowest_alpha();
        match &self.coat {
            Some(c) if self.layers[0] && !c.is_mirror() => {
                let a = c.alpha();
                [base[0].min(a[0]), base[1].min(a[1])]
            }
            _ => base,
        }
    }

    fn refraction(&self) -> Option<f32> {
        self.base.refraction().or_else(|| (!self.matte.is_black(1)).then_some(1.0))
    }
}
