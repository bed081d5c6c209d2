//! The closure from one direction, and its value and density for a pair.

use super::{Extended, sum, up};
use crate::{
    bsdf::{Bsdf, DeltaPart, Eval},
    gltf::lobes::{COAT, DIFFUSE, FUZZ, LOBES, SHEEN, SPECULAR, THROUGH, probabilities},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// What depends on `wo` alone.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// What the coat lets through; and coat and sheen together.
    pub layers: [f32; 2],
    /// What reaches the diffuse part.
    pub entering: f32,
    /// What the fuzz leaves to all the others.
    pub over: f32,
    /// Probability of each lobe.
    pub p: [f32; LOBES],
}

impl Extended {
    #[inline(always)]
    pub(super) fn view(&self, wo: Vec3A) -> View {
        let has_diffuse = self.sum_diffuse[0] + self.sum_diffuse[1] > 0.0;
        let mut layers = [1.0; 2];
        let mut weights = [0.0; LOBES];
        if self.layers[0] {
            if let Some(c) = &self.coat {
                let (through, reflected) = c.split(wo);
                layers = [through; 2];
                weights[COAT] = 3.0 * reflected;
            }
            if let Some(s) = &self.sheen {
                weights[SHEEN] = sum(s.albedo(wo)) * layers[0];
                layers[1] *= self.under_sheen(wo);
            }
        }
        let entering =
            if has_diffuse { self.base.shape.enters(&self.base.facet, wo) * layers[1] } else { 0.0 };
        let [reflected, passed] = self.base.energy(wo);
        weights[SPECULAR] = (sum(reflected) + sum(passed)) * layers[1];
        weights[DIFFUSE] = self.sum_diffuse[0] * entering;
        weights[THROUGH] = self.sum_diffuse[1] * entering;
        let mut over = 1.0;
        if self.layers[0] {
            if let Some(c) = &self.coat {
                let [mirrored, scattered] = c.varnished_over(wo).map(Spectrum::max_element);
                weights[SPECULAR] *= mirrored;
                for lobe in [SHEEN, DIFFUSE, THROUGH] {
                    weights[lobe] *= scattered;
                }
            }
            if let Some(f) = &self.fuzz {
                over = f.through(wo);
                weights = weights.map(|w| w * over);
                weights[FUZZ] = sum(f.albedo(wo));
            }
        }
        View { layers, entering, over, p: probabilities(weights) }
    }

    /// The factor of the base's specular part at a pair: of the layers' two transmittances the smaller, which keeps it
    /// reciprocal and below what reaches the base.
    #[inline(always)]
    pub(super) fn specular_factor(&self, view: &View, wo: Vec3A, wi: Vec3A) -> f32 {
        if self.coat.is_none() && self.sheen.is_none() && self.through_shape.is_none() {
            return 1.0;
        }
        let reflects = wi.z > 0.0;
        let w = up(wi);
        let layers = view.layers[1].min(self.layers_on(if reflects { 0 } else { 1 }, w));
        match &self.through_shape {
            // What passes with another roughness sees other facets than those that reflect: it must not take more
            // than these leave.
            Some(shape) if !reflects => {
                let ratio = |w: Vec3A| {
                    let (left, taken) =
                        (self.base.shape.enters(&self.base.facet, w), shape.enters(&self.base.facet, w));
                    if left < taken { left / taken } else { 1.0 }
                };
                layers * ratio(wo).min(ratio(w))
            }
            _ => layers,
        }
    }

    /// The factor of what lies below the coat by what that absorbs and darkens, for light that leaves on a side.
    #[inline(always)]
    fn varnished(&self, side: usize, wo: Vec3A, wi: Vec3A) -> Spectrum {
        match (&self.coat, self.layers) {
            (None, _) | (_, [false, false]) => Spectrum::ONE,
            (Some(c), [true, _]) => c.varnished(wo, self.layers[side].then(|| up(wi))),
            (Some(_), [false, true]) if side == 0 => Spectrum::ONE,
            (Some(c), [false, true]) => c.left(up(wi)),
        }
    }

    /// Value by lobe and density at a pair; |wi.z| and wo.z above [`MIN_COS`].
    #[inline(always)]
    pub(super) fn eval_at(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let reflects = wi.z > 0.0;
        let (side, lobe) = if reflects { (0, DIFFUSE) } else { (1, THROUGH) };
        let base = self.base.eval_pdf(wo, wi);
        let mut out = Eval {
            diffuse: Spectrum::ZERO,
            specular: base.specular * self.specular_factor(view, wo, wi),
            pdf: view.p[SPECULAR] * base.pdf,
        };
        if self.sum_diffuse[side] > 0.0 {
            let above = up(wi);
            let (o, i) = (view.entering, self.entering(side, above));
            let inv = self.inv_entering[side];
            // Total reflection is a step whose mean is not known well enough to divide by it.
            let coupled = if inv > 0.0 { o * i * inv } else { o.min(i) };
            out.diffuse += self.matte.value(side, wo, above) * coupled;
            out.pdf += view.p[lobe] * self.matte.pdf(wo, above);
        }
        let mut lacquer = 0.0;
        if reflects && self.layers[0] {
            if let Some(c) = &self.coat {
                let (value, pdf) = c.eval_pdf(wo, wi);
                lacquer = value;
                out.pdf += view.p[COAT] * pdf;
            }
            if let Some(s) = &self.sheen {
                let e = s.eval_pdf(wo, wi);
                let coat = self.coat.as_ref().map_or(1.0, |c| view.layers[0].min(c.through(wi)));
                out.diffuse += e.diffuse * coat;
                out.pdf += view.p[SHEEN] * e.pdf;
            }
        }
        let varnish = self.varnished(side, wo, wi);
        out.diffuse = out.diffuse * varnish * view.over;
        out.specular = (out.specular * varnish + Spectrum::splat(lacquer)) * view.over;
        if let (true, true, Some(f)) = (reflects, self.layers[0], &self.fuzz) {
            let e = f.eval_pdf(wo, wi);
            out.diffuse += e.diffuse;
            out.pdf += view.p[FUZZ] * e.pdf;
        }
        let fine = out.pdf < f32::INFINITY && out.specular.is_finite() && out.diffuse.is_finite();
        if fine { out } else { Eval::ZERO }
    }

    /// The perfectly specular parts: coat and base share the mirror's direction.
    pub(super) fn delta_parts(&self, view: &View, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let scaled = |d: DeltaPart| DeltaPart {
            reflectance: d.reflectance
                * self.specular_factor(view, wo, d.wi)
                * self.varnished(usize::from(!(d.wi.z > 0.0)), wo, d.wi)
                * view.over,
            probability: d.probability * view.p[SPECULAR],
            ..d
        };
        let [mut reflected, passed] = self.base.deltas(wo).map(|d| d.map(scaled));
        if let (true, Some(c)) = (self.layers[0], &self.coat)
            && let Some((wi, f)) = c.delta(wo)
        {
            let base = reflected.unwrap_or(DeltaPart { wi, reflectance: Spectrum::ZERO, probability: 0.0 });
            reflected = Some(DeltaPart {
                reflectance: base.reflectance + Spectrum::splat(f * view.over),
                // Shares that add up to one may miss it by a rounding.
                probability: (base.probability + view.p[COAT]).min(1.0),
                ..base
            });
        }
        [reflected, passed].map(|d| d.filter(|d| d.probability > 0.0))
    }

    /// True if nothing but the base's specular part is there.
    #[inline(always)]
    pub(super) fn is_bare(&self) -> bool {
        self.fuzz.is_none()
            && self.coat.is_none()
            && self.sheen.is_none()
            && self.through_shape.is_none()
            && self.sum_diffuse == [0.0; 2]
    }
}
