//! Disney's BSDF.
//!
//! Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering". The BRDF of 2012 with the exact
//! dielectric's Fresnel term, its own α in the masking, and light that passes. With c the base colour and
//! dw = (1 − metallic)(1 − spec_trans), the weight of everything diffuse:
//!
//! | lobe | solid | thin |
//! |---|---|---|
//! | diffuse | dw c · base form | dw (1 − diff_trans/2) c · mix(base, flat, flatness) |
//! | diffuse, passed | – | dw diff_trans/2 · c/π |
//! | sheen | dw · sheen · mix(1, hue, sheen_tint) (1 − cos θd)⁵ | the same |
//! | specular | GGX with mix(F, Schlick(c_s), metallic) | the same |
//! | specular, passed | (1 − metallic) spec_trans √c · refraction by GGX, 1 − F | (1 − metallic) spec_trans c · mirrored lobe, 1 − F |
//! | coat | [`super::coat`] | the same |
//!
//! F is the dielectric's, c_s = mix(F0 mix(1, hue, specular_tint), c, metallic); so the tint shows only in half metals, as
//! published. The root of the colour is for light that enters a solid and leaves it again. In a thin sheet the lobe of what
//! passes is narrower or wider by the index: its roughness is (0.65 ior − 0.35) roughness.
//!
//! Where a solid has a scatter distance and its lobes are the diffuse and the specular one alone, [`ModelParams::subsurface`]
//! gives the profile by normalized diffusion; the closure itself is the limit of distance 0, with the base form.
//!
//! # Where this departs from the paper
//! Masking is correlated by height ([`crate::ggx`]; refraction: [`crate::dielectric`]) rather than a product, which keeps
//! reflection and refraction in balance. Diffuse light that passes has the weight dw, without which a sheet of
//! spec_trans = 1 would pass everything twice. A solid that light passes has no coat on its inner side.

use super::{
    brdf::LEAST_ALPHA,
    coat::Coat,
    tint::{sum, tinted, unit},
};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    bssrdf::{Distance, SubsurfaceParams},
    dielectric::{Dielectric, GgxDielectric, Interface, ThinGgx},
    diffuse::disney::{DisneyPair, DisneySampler, base_albedo, flat_albedo},
    fresnel::{Schlick, f0_from_ior, schlick_weight},
    ggx::anisotropic_alpha,
    model::{Claim, Claims, Incidence, Interior, ModelParams},
    parameters,
    sampling::cosine_hemisphere,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What Disney's BSDF is at a point.
    pub struct DisneyBsdfParams {
        /// Colour of the body, of a metal's reflection, and of what passes.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// 0 dielectric .. 1 metal.
        metallic: f32 = 0.0, 0.0..1.0;
        /// Perceptual roughness of the diffuse and the specular lobes.
        roughness: f32 = 0.5, 0.0..1.0;
        /// 0 round highlights .. 1 long ones along x.
        anisotropic: f32 = 0.0, 0.0..1.0;
        /// Index of refraction.
        ior: f32 = 1.5, 1.0..4.0;
        /// How much of the body's hue Schlick's part of the reflection has.
        specular_tint: f32 = 0.0, 0.0..1.0;
        /// A glow at grazing angles, meant for cloth.
        sheen: f32 = 0.0, 0.0..1.0;
        /// How much of the body's hue the sheen has.
        sheen_tint: f32 = 0.5, 0.0..1.0;
        /// Strength of a second, clear, specular lobe.
        clearcoat: f32 = 0.0, 0.0..1.0;
        /// 0 satin .. 1 gloss.
        clearcoat_gloss: f32 = 1.0, 0.0..1.0;
        /// 0 opaque .. 1 clear: how much of the body's light is refracted.
        spec_trans: f32 = 0.0, 0.0..1.0;
        /// Thin only: from the base diffuse form to the flat one.
        flatness: f32 = 0.0, 0.0..1.0;
        /// Thin only: 0 reflects all diffuse light, 1 half of it, 2 passes all.
        diff_trans: f32 = 1.0, 0.0..2.0;
        /// Solid only: how far diffuse light travels under the surface (diffuse mean free path), metres, by lane.
        scatter_distance: Spectrum = Spectrum::ZERO, 0.0..1.0;
        /// A sheet of no thickness rather than the boundary of a body.
        thin: bool = false, 0.0..1.0;
    }
}

impl ModelParams for DisneyBsdfParams {
    type Closure = DisneyBsdf;
    const ABOUT: &'static str = "Disney's BSDF, solid or thin (Burley 2015), literal";
    const CLAIMS: Claims = Claims {
        conserves: Claim::Breaks(
            "its lobes are added without one knowing of the other: white returns up to 1.72 of a white sky at 89° (roughness 1, every feature on), and up to 2.15 from inside a body that is hardly clear, where total reflection adds to the diffuse lobe",
        ),
        ..Claims::ALL
    };

    #[inline]
    fn closure(&self, at: &Incidence) -> DisneyBsdf {
        DisneyBsdf::new(self, at)
    }

    fn interior(&self) -> Option<Interior> {
        let passes = !self.thin && self.spec_trans > 0.0 && !(self.metallic >= 1.0);
        passes.then(|| Interior {
            ior: index(self.ior),
            absorption: Spectrum::ZERO,
            scatter: None,
            priority: 0,
            dispersive: false,
        })
    }

    fn subsurface(&self) -> Option<SubsurfaceParams> {
        let alone = [self.metallic, self.spec_trans, self.sheen, self.clearcoat].iter().all(|&v| !(v > 0.0));
        let travels = self.scatter_distance.0.iter().any(|&v| v > 0.0);
        (alone && travels && !self.thin).then_some(SubsurfaceParams {
            color: self.base_color,
            radius: self.scatter_distance,
            distance: Distance::DiffuseMeanFreePath,
            ior: self.ior,
            roughness: self.roughness,
        })
    }
}

/// An index of refraction, 1..4, NaN to 1.
#[inline(always)]
fn index(ior: f32) -> f32 {
    ior.max(1.0).min(4.0)
}

/// What a microfacet does: a dielectric's reflection mixed with Schlick's of a metal, a dielectric's transmission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    dielectric: Dielectric,
    schlick: Schlick,
    metallic: f32,
}

impl Face {
    #[inline(always)]
    fn mixed(&self, dielectric: Spectrum, cos: f32) -> Spectrum {
        if self.metallic == 0.0 { dielectric } else { dielectric.lerp(self.schlick.eval(cos), self.metallic) }
    }
}

impl Interface for Face {
    #[inline(always)]
    fn eta(&self) -> f32 {
        Interface::eta(&self.dielectric)
    }
    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        self.mixed(self.dielectric.reflect(cos), cos)
    }
    #[inline(always)]
    fn transmit(&self, cos: f32) -> Spectrum {
        self.dielectric.transmit(cos)
    }
    #[inline(always)]
    fn reflect_between(&self, near: f32, far: f32) -> Spectrum {
        self.mixed(self.dielectric.reflect_between(near, far), near)
    }
    #[inline(always)]
    fn transmit_between(&self, near: f32, far: f32) -> Spectrum {
        self.dielectric.transmit_between(near, far)
    }
}

/// The specular lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Specular {
    /// The boundary of a clear body.
    Solid(GgxDielectric<Face>),
    /// A sheet, or an opaque surface, which passes nothing.
    Thin(ThinGgx<Face>),
}

macro_rules! each {
    ($specular:expr, $lobe:ident => $do:expr) => {
        match $specular {
            Specular::Solid($lobe) => $do,
            Specular::Thin($lobe) => $do,
        }
    };
}

/// The closure of Disney's BSDF; see the module's head.
///
/// Reciprocal, refraction up to the scaling of radiance; makes light at grazing angles. Its [`Bsdf::albedo`] is an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisneyBsdf {
    specular: Specular,
    coat: Coat,
    roughness: f32,
    flatness: f32,
    diffuse: Spectrum,
    passed: Spectrum,
    sheen: Spectrum,
    sampler: DisneySampler,
}

/// Probabilities of the lobes.
#[derive(Clone, Copy)]
struct Choice {
    diffuse: f32,
    passed: f32,
    specular: f32,
    coat: f32,
}

impl DisneyBsdf {
    /// The closure of a surface; parameters out of range are clamped, NaN counts as the lower end.
    #[inline]
    pub fn new(p: &DisneyBsdfParams, at: &Incidence) -> Self {
        let c = p.base_color.map(unit);
        let (metallic, roughness) = (unit(p.metallic), unit(p.roughness));
        let (clear, anisotropic) = (unit(p.spec_trans), unit(p.anisotropic));
        let (body, spec_trans) = ((1.0 - metallic) * (1.0 - clear), (1.0 - metallic) * clear);
        let alpha = |r: f32| anisotropic_alpha(r, anisotropic).map(|a| a.max(LEAST_ALPHA));
        let ior = index(p.ior);
        let outside = index(at.exterior_ior);
        let bent = spec_trans > 0.0 && !p.thin;
        let eta = if bent && !at.front { outside / ior } else { ior / outside };
        let f0 = tinted(c, unit(p.specular_tint)) * f0_from_ior(ior);
        let face = Face {
            dielectric: Dielectric::new(eta),
            schlick: Schlick { f0: f0.lerp(c, metallic).map(unit), f90: Spectrum::ONE },
            metallic,
        };
        let specular = if bent {
            let lobe = GgxDielectric::new(alpha(roughness), face, at.transport);
            Specular::Solid(lobe.tinted(Spectrum::ONE, c.sqrt() * spec_trans))
        } else {
            let through = alpha(unit((0.65 * ior - 0.35) * roughness));
            let lobe = ThinGgx::new(alpha(roughness), face).with_transmission_alpha(through);
            Specular::Thin(lobe.tinted(Spectrum::ONE, c * spec_trans))
        };
        let (flatness, passes) =
            if p.thin { (unit(p.flatness), 0.5 * p.diff_trans.max(0.0).min(2.0)) } else { (0.0, 0.0) };
        let coat = if at.front || !bent { unit(p.clearcoat) } else { 0.0 };
        Self {
            specular,
            coat: Coat::new(coat, unit(p.clearcoat_gloss)),
            roughness,
            flatness,
            diffuse: c * (body * (1.0 - passes)),
            passed: c * (body * passes),
            sheen: tinted(c, unit(p.sheen_tint)) * (body * unit(p.sheen)),
            sampler: DisneySampler::new(roughness, flatness),
        }
    }

    /// About the part of the light that the diffuse lobes on the near side return.
    #[inline(always)]
    fn returned(&self, wo: Vec3A) -> Spectrum {
        let base = base_albedo(wo.z, self.roughness);
        let all = if self.flatness == 0.0 {
            base
        } else {
            base + (flat_albedo(wo.z, self.roughness) - base) * self.flatness
        };
        self.diffuse * all + self.sheen * super::brdf::sheen_albedo(wo.z)
    }

    /// Each lobe is drawn in proportion to what it returns, and none that is there never.
    #[inline(always)]
    fn choice(&self, wo: Vec3A) -> Choice {
        let diffuse = sum(self.returned(wo));
        let passed = sum(self.passed);
        let [reflected, transmitted] = each!(&self.specular, lobe => lobe.energy(wo));
        let specular = sum(reflected) + sum(transmitted);
        let coat = 4.0 * self.coat.albedo(wo.z);
        let all = diffuse + passed + specular + coat;
        if !(all > 0.0) {
            return Choice { diffuse: 0.0, passed: 0.0, specular: 1.0, coat: 0.0 };
        }
        let least = |there: bool, p: f32| if there { (p / all).max(0.02) } else { 0.0 };
        let d = least(diffuse > 0.0, diffuse);
        let t = least(passed > 0.0, passed);
        // A facet at an odd angle may reflect where the mean one does not.
        let s = least(true, specular);
        let c = least(!self.coat.is_none(), coat);
        let inv = 1.0 / (d + t + s + c);
        Choice { diffuse: d * inv, passed: t * inv, specular: s * inv, coat: c * inv }
    }

    /// Value by lobe and density, on either side.
    #[inline(always)]
    fn eval_either(&self, p: Choice, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = each!(&self.specular, lobe => lobe.eval_pdf(wo, wi));
        e.pdf *= p.specular;
        if wi.z < 0.0 {
            if p.passed > 0.0 {
                e.diffuse = self.passed * FRAC_1_PI;
                e.pdf += p.passed * (-wi.z * FRAC_1_PI);
            }
            return e;
        }
        if p.diffuse > 0.0 {
            let pair = DisneyPair::new(wo, wi);
            let base = pair.base(self.roughness);
            let body = if self.flatness == 0.0 {
                base
            } else {
                base + (pair.flat(self.roughness) - base) * self.flatness
            };
            let fd = schlick_weight(pair.cos2_d.sqrt());
            e.diffuse = self.diffuse * (body.max(0.0) * FRAC_1_PI) + self.sheen * fd;
            e.pdf += p.diffuse * self.sampler.pdf(wo, wi);
        }
        if !self.coat.is_none() {
            let (value, pdf) = self.coat.pair(wo, wi);
            e.specular += Spectrum::splat(value);
            e.pdf += p.coat * pdf;
        }
        e
    }
}

impl Bsdf for DisneyBsdf {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        let e = self.eval_either(self.choice(wo), wo, wi);
        if e.pdf < f32::INFINITY && e.value().is_finite() { e } else { Eval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let p = self.choice(wo);
        let mut uc = unit(uc);
        let (wi, lobe) = if uc < p.diffuse {
            (self.sampler.sample(wo, uc / p.diffuse, u), LobeKind::Diffuse)
        } else if uc < p.diffuse + p.passed {
            (-cosine_hemisphere(u), LobeKind::Diffuse)
        } else if uc < p.diffuse + p.passed + p.coat {
            uc = (uc - p.diffuse - p.passed) / p.coat;
            let wi = self.coat.sample(wo, uc, u);
            // Below the horizon a coat has nothing, whatever the other lobes have there.
            ((wi.z > MIN_COS).then_some(wi)?, LobeKind::Specular)
        } else {
            uc = ((uc - p.diffuse - p.passed - p.coat) / p.specular).min(1.0);
            let s = each!(&self.specular, lobe => lobe.sample(wo, uc, u))?;
            if s.delta {
                let weight = s.weight * (1.0 / p.specular);
                return Some(BsdfSample { weight, weight_specular: weight, pdf: s.pdf * p.specular, ..s });
            }
            (s.wi, LobeKind::Specular)
        };
        if !(wi.z.abs() > MIN_COS && wi.is_finite()) {
            return None;
        }
        let e = self.eval_either(p, wo, wi);
        if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
            return None;
        }
        let scale = wi.z.abs() / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        let weight = weight_diffuse + weight_specular;
        weight.is_finite().then_some(BsdfSample {
            wi,
            weight,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe,
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let specular = each!(&self.specular, lobe => lobe.albedo(wo));
        self.returned(wo) + self.passed + specular + Spectrum::splat(self.coat.albedo(wo.z))
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return [None, None];
        }
        let p = self.choice(wo).specular;
        let parts = each!(&self.specular, lobe => lobe.deltas(wo));
        parts.map(|d| d.map(|d| DeltaPart { probability: d.probability * p, ..d }))
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        let [x, y] = each!(&self.specular, lobe => lobe.narrowest_alpha());
        let coat = if self.coat.is_none() { 1.0 } else { self.coat.alpha() };
        [x.min(coat), y.min(coat)]
    }

    #[inline]
    fn refraction(&self) -> Option<f32> {
        let specular = each!(&self.specular, lobe => lobe.refraction());
        specular.or_else(|| (!self.passed.is_black()).then_some(1.0))
    }
}
