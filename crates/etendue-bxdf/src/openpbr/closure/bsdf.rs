//! The closure's side of the contract.

use super::{
    Beyond, OpenPbr,
    parts::{DIFFUSE, DIFFUSE_THROUGH, FUZZ},
};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    openpbr::coat::Coat,
};
use etendue_color::Spectrum;
use glam::Vec3A;

impl Bsdf for OpenPbr {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS && wo.is_finite() && wi.is_finite()) {
            return Eval::ZERO;
        }
        self.eval_with(&self.view(wo), wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let view = self.view(wo);
        let mut rest = uc.max(0.0);
        let mut part = None;
        for (i, &p) in view.p.iter().enumerate() {
            if p > 0.0 {
                // Rounding at the end falls to the last part that is there.
                part = Some((i, (rest / p).min(1.0 - f32::EPSILON)));
                if rest < p {
                    break;
                }
                rest -= p;
            }
        }
        let (part, uc) = part?;
        let (wi, delta) = self.draw(&view, part, wo, uc, u)?;
        if delta {
            let d = if wi.z > 0.0 { self.mirrored(&view, wo)? } else { self.straight(&view, wo)? };
            let weight = d.reflectance * (1.0 / d.probability);
            return Some(BsdfSample {
                wi: d.wi,
                weight,
                weight_diffuse: Spectrum::ZERO,
                weight_specular: weight,
                pdf: d.probability,
                delta: true,
                lobe: LobeKind::Specular,
            });
        }
        if !(wi.is_finite() && wi.z.abs() > MIN_COS) {
            return None;
        }
        let e = self.eval_with(&view, wo, wi);
        if !(e.pdf > 0.0) {
            return None;
        }
        let scale = wi.z.abs() / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        let diffuse = part == FUZZ || (DIFFUSE..=DIFFUSE_THROUGH).contains(&part);
        Some(BsdfSample {
            wi,
            weight: weight_diffuse + weight_specular,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe: if diffuse { LobeKind::Diffuse } else { LobeKind::Specular },
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return Spectrum::ZERO;
        }
        self.view(wo).albedo.into_iter().fold(Spectrum::ZERO, |a, b| a + b)
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return [None, None];
        }
        let view = self.view(wo);
        [self.mirrored(&view, wo), self.straight(&view, wo)]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        let mut out = [1.0f32; 2];
        let mut narrow = |a: [f32; 2]| out = [out[0].min(a[0]), out[1].min(a[1])];
        self.base.alpha().into_iter().for_each(&mut narrow);
        if let Some(a) = self.coat.as_ref().and_then(|c| c.lobe.alpha()) {
            // A coat with a frame of its own may be narrow along any axis.
            let least = a[0].min(a[1]);
            narrow(if self.coat.as_ref().is_some_and(Coat::has_frame) { [least; 2] } else { a });
        }
        if let Beyond::Sheet(lobe) = &self.beyond {
            lobe.alpha().into_iter().for_each(&mut narrow);
        }
        out
    }

    fn refraction(&self) -> Option<f32> {
        match &self.beyond {
            Beyond::Volume(r) | Beyond::Inside(r) => r.lobe.refraction(),
            Beyond::Sheet(_) => Some(1.0),
            Beyond::Nothing => self.diffuse[DIFFUSE_THROUGH - DIFFUSE].map(|_| 1.0),
        }
    }
}
