//! The closure of a surface that uses extensions.

use super::{
    body::{Base, Body},
    coat::Coat,
    facet::Facet,
    lobes::{COAT, DIFFUSE, LOBES, SHEEN, SPECULAR, THROUGH, pick, probabilities},
    params::GltfParams,
    shape::Shape,
};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    dielectric::{GgxDielectric, Interface, ThinGgx},
    fresnel::f0_from_ior,
    model::{Incidence, Transport},
    multiscatter::Further,
    sampling::cosine_hemisphere,
    sheen::Sheen,
    thin_film::Lanes,
};
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// A surface with extensions, at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extended {
    coat: Option<Coat>,
    sheen: Option<Sheen>,
    /// The sheen's largest lane.
    sheen_max: f32,
    /// Whether coat and sheen lie on the side of `wo`, and on the other.
    layers: [bool; 2],
    base: Base,
    /// The roughness of what passes a thin sheet, if it is another than that of what is reflected.
    through_shape: Option<Shape>,
    /// Colours / π of what is scattered diffusely on the near and on the far side.
    diffuse: [Spectrum; 2],
    /// One over the mean of [`Extended::entering`] over the hemisphere, on the near and on the far side; 0 where total
    /// reflection is in it.
    inv_entering: [f32; 2],
    /// Sums over lanes, for the choice of lobe.
    sum_diffuse: [f32; 2],
    sum_f0: f32,
    sum_f90: f32,
}

/// What depends on `wo` alone.
#[derive(Clone, Copy)]
struct View {
    /// What the coat lets through; and coat and sheen together.
    layers: [f32; 2],
    /// What reaches the diffuse part.
    entering: f32,
    /// Probability of each lobe.
    p: [f32; LOBES],
}

/// 0..1, NaN to 0.
#[inline(always)]
fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

#[inline(always)]
fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}

/// `w` on the upper side.
#[inline(always)]
fn up(w: Vec3A) -> Vec3A {
    vec3a(w.x, w.y, w.z.abs())
}

/// How much smaller the roughness of light that passes a thin sheet is than the surface's: the two faces' facets are
/// prisms, which bend light the less the nearer their index is to 1. As Khronos' sample renderer has it: nothing at ior 1, all at
/// 1.5 (also for the infinite index, 0).
#[inline(always)]
fn thin_roughness_scale(ior: f32) -> f32 {
    if ior == 0.0 { 1.0 } else { unit(2.0 * ior - 2.0) }
}

impl Extended {
    pub fn new(p: &GltfParams, at: &Incidence, lanes: Lanes) -> Self {
        let roughness = unit(p.roughness);
        let alpha = roughness * roughness;
        let strength = unit(p.anisotropy_strength);
        let alpha = [alpha + (1.0 - alpha) * (strength * strength), alpha];
        let metallic = unit(p.metallic);
        let dielectric = 1.0 - metallic;
        let specular = unit(p.specular);
        let base = p.base_color.map(unit);
        let transmission = unit(p.transmission);
        let passes = transmission * dielectric > 0.0;
        let solid = passes && p.thickness > 0.0;
        let relative = super::ior_in_lane(p, at.lane, lanes) / at.exterior_ior.max(1.0).min(1e3);
        let normal = if solid && p.ior != 0.0 { f0_from_ior(relative) } else { f0_from_ior(p.ior) };
        let dielectric_f0 = (p.specular_color * normal).map(unit) * specular;

        let mut facet = Facet::new(dielectric_f0, specular, base, metallic);
        let coverage = unit(p.iridescence);
        if coverage > 0.0 {
            facet = facet.with_film(coverage, p.iridescence_ior, p.iridescence_thickness, lanes);
        }
        if solid {
            facet = facet.with_eta(if at.front { relative } else { 1.0 / relative });
        }
        let shape = Shape::new(alpha);
        let tint = base * (transmission * dielectric);
        let mut through_shape = None;
        let body = if solid {
            Body::Solid(GgxDielectric::new(alpha, facet, at.transport).tinted(Spectrum::ONE, tint))
        } else if passes {
            let scale = thin_roughness_scale(p.ior);
            let through = alpha.map(|a| a * (scale * scale));
            if through != alpha {
                through_shape = Some(Shape::new(through));
            }
            let sheet = ThinGgx::new(alpha, facet).with_transmission_alpha(through);
            Body::Thin(sheet.tinted(Spectrum::ONE, tint))
        } else {
            Body::Opaque
        };

        let rest = dielectric * (1.0 - transmission);
        let far = unit(p.diffuse_transmission);
        // Diffuse light that enters a volume is compressed as refracted light is.
        let squeeze = match at.transport {
            Transport::Radiance => 1.0 / (facet.eta() * facet.eta()),
            Transport::Importance => 1.0,
        };
        let far_color = p.diffuse_transmission_color.map(unit);
        let diffuse =
            [base * (rest * (1.0 - far) * FRAC_1_PI), far_color * (rest * far * FRAC_1_PI * squeeze)];

        let further =
            Further::worthwhile(shape.ggx.alpha(), facet.average(), facet.reflect(1.0), p.compensation);

        let coverage = unit(p.clearcoat);
        let mut coat =
            (coverage > 0.0).then(|| Coat::new(coverage, unit(p.clearcoat_roughness), p.clearcoat_normal));
        let sheen_color = p.sheen_color.map(unit);
        let sheen_max = sheen_color.max_element();
        let (f0, f90) = facet.ends();
        let mut out = Self {
            coat: None,
            sheen: (sheen_max > 0.0).then(|| Sheen::new(sheen_color, p.sheen_roughness)),
            sheen_max,
            layers: if solid { [at.front, !at.front] } else { [true, true] },
            base: Base { facet, shape, body, further },
            through_shape,
            diffuse,
            inv_entering: [1.0; 2],
            sum_diffuse: diffuse.map(|d| sum(d) * PI),
            sum_f0: sum(f0),
            // Lanes that take no part are zero in the colours: three stand for all.
            sum_f90: 3.0 * f90,
        };
        // There is one place for a perfectly specular reflection: of two in different directions the coat's gives way.
        if let Some(c) = &mut coat
            && c.is_mirror()
            && c.has_own_normal()
            && out.base.deltas(Vec3A::Z)[0].is_some()
        {
            *c = c.blurred();
        }
        out.coat = coat;
        let traps =
            [out.base.facet.may_trap(), out.base.facet.may_trap() || out.base.facet.reversed().may_trap()];
        for side in 0..2 {
            if !out.diffuse[side].is_black() {
                out.inv_entering[side] =
                    if traps[side] { 0.0 } else { 1.0 / out.mean_entering(side).max(1e-6) };
            }
        }
        out
    }

    /// What coat and sheen let through of light from `w` above them: the coat alone, and both.
    #[inline(always)]
    fn layers_at(&self, w: Vec3A) -> [f32; 2] {
        let coat = self.coat.as_ref().map_or(1.0, |c| c.through(w));
        [coat, coat * self.under_sheen(w)]
    }

    #[inline(always)]
    fn under_sheen(&self, w: Vec3A) -> f32 {
        self.sheen.as_ref().map_or(1.0, |s| s.row().below_view(self.sheen_max, w.z))
    }

    /// Both layers on a side (0 the near, 1 the far), for `w` turned to the upper side.
    #[inline(always)]
    fn layers_on(&self, side: usize, w: Vec3A) -> f32 {
        if self.layers[side] { self.layers_at(w)[1] } else { 1.0 }
    }

    /// The part of the light from `w` (turned to the upper side) on a side that enters the base, below all layers.
    #[inline(always)]
    fn entering(&self, side: usize, w: Vec3A) -> f32 {
        let facet = if side == 0 { self.base.facet } else { self.base.facet.reversed() };
        self.base.shape.enters(&facet, w) * self.layers_on(side, w)
    }

    /// ∫ entering · cos / π over the hemisphere: six Gauss-Legendre nodes in the cosine, exact for a mirror on Schlick's
    /// curve under another, times azimuths where these matter.
    fn mean_entering(&self, side: usize) -> f32 {
        const NODES: [[f32; 2]; 6] = [
            [0.033_765_24, 0.085_662_25],
            [0.169_395_31, 0.180_380_79],
            [0.380_690_4, 0.233_956_97],
            [0.619_309_6, 0.233_956_97],
            [0.830_604_7, 0.180_380_79],
            [0.966_234_8, 0.085_662_25],
        ];
        // A tilted coat has no symmetry; an anisotropic base repeats each quarter.
        let tilted = self.layers[side] && self.coat.as_ref().is_some_and(Coat::has_own_normal);
        let (count, range) = match (tilted, self.base.shape.is_isotropic()) {
            (true, _) => (8, TAU),
            (false, false) => (3, FRAC_PI_2),
            (false, true) => (1, 0.0),
        };
        let mut mean = 0.0;
        for i in 0..count {
            let turns = (i as f32 + 0.5) / count as f32 * (range / TAU);
            let (y, x) = crate::math::sin_cos_tau(turns);
            for [z, weight] in NODES {
                let r = ((1.0 - z) * (1.0 + z)).sqrt();
                mean += 2.0 * z * weight * self.entering(side, vec3a(r * x, r * y, z));
            }
        }
        mean / count as f32
    }

    #[inline(always)]
    fn view(&self, wo: Vec3A) -> View {
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
        View { layers, entering, p: probabilities(weights) }
    }

    /// The factor of the base's specular part at a pair: of the layers' two transmittances the smaller, which keeps it
    /// reciprocal and below what reaches the base.
    #[inline(always)]
    fn specular_factor(&self, view: &View, wo: Vec3A, wi: Vec3A) -> f32 {
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

    /// Value by lobe and density at a pair; |wi.z| and wo.z above [`MIN_COS`].
    #[inline(always)]
    fn eval_at(&self, view: &View, wo: Vec3A, wi: Vec3A) -> Eval {
        let reflects = wi.z > 0.0;
        let (side, lobe) = if reflects { (0, DIFFUSE) } else { (1, THROUGH) };
        let base = self.base.eval_pdf(wo, wi);
        let mut out = Eval {
            diffuse: Spectrum::ZERO,
            specular: base.specular * self.specular_factor(view, wo, wi),
            pdf: view.p[SPECULAR] * base.pdf,
        };
        if self.sum_diffuse[side] > 0.0 {
            let (o, i) = (view.entering, self.entering(side, up(wi)));
            let inv = self.inv_entering[side];
            // Total reflection is a step whose mean is not known well enough to divide by it.
            let coupled = if inv > 0.0 { o * i * inv } else { o.min(i) };
            out.diffuse += self.diffuse[side] * coupled;
            out.pdf += view.p[lobe] * (wi.z.abs() * FRAC_1_PI);
        }
        if reflects && self.layers[0] {
            if let Some(c) = &self.coat {
                let (value, pdf) = c.eval_pdf(wo, wi);
                out.specular += Spectrum::splat(value);
                out.pdf += view.p[COAT] * pdf;
            }
            if let Some(s) = &self.sheen {
                let e = s.eval_pdf(wo, wi);
                let coat = self.coat.as_ref().map_or(1.0, |c| view.layers[0].min(c.through(wi)));
                out.diffuse += e.diffuse * coat;
                out.pdf += view.p[SHEEN] * e.pdf;
            }
        }
        let fine = out.pdf < f32::INFINITY && out.specular.is_finite() && out.diffuse.is_finite();
        if fine { out } else { Eval::ZERO }
    }

    /// The perfectly specular parts: coat and base share the mirror's direction.
    fn delta_parts(&self, view: &View, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let scaled = |d: DeltaPart| DeltaPart {
            reflectance: d.reflectance * self.specular_factor(view, wo, d.wi),
            probability: d.probability * view.p[SPECULAR],
            ..d
        };
        let [mut reflected, passed] = self.base.deltas(wo).map(|d| d.map(scaled));
        if let (true, Some(c)) = (self.layers[0], &self.coat)
            && let Some((wi, f)) = c.delta(wo)
        {
            let base = reflected.unwrap_or(DeltaPart { wi, reflectance: Spectrum::ZERO, probability: 0.0 });
            reflected = Some(DeltaPart {
                reflectance: base.reflectance + Spectrum::splat(f),
                // Shares that add up to one may miss it by a rounding.
                probability: (base.probability + view.p[COAT]).min(1.0),
                ..base
            });
        }
        [reflected, passed].map(|d| d.filter(|d| d.probability > 0.0))
    }

    /// True if nothing but the base's specular part is there.
    #[inline(always)]
    fn is_bare(&self) -> bool {
        self.coat.is_none()
            && self.sheen.is_none()
            && self.through_shape.is_none()
            && self.sum_diffuse == [0.0; 2]
    }
}

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
            (THROUGH, ..) => (-cosine_hemisphere(u), false),
            _ => (cosine_hemisphere(u), false),
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
        let mut out = (reflected + squeeze) * view.layers[1];
        out += (self.diffuse[0] + self.diffuse[1]) * (PI * view.entering);
        if self.layers[0] {
            if let Some(c) = &self.coat {
                out += Spectrum::splat(c.split(wo).1);
            }
            if let Some(s) = &self.sheen {
                out += s.albedo(wo) * view.layers[0];
            }
        }
        out
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
        self.base.refraction().or_else(|| (!self.diffuse[1].is_black()).then_some(1.0))
    }
}
