//! The metallic-roughness surface of glTF 2.0.
//!
//! Appendix B of the specification, with `KHR_materials_ior` and `KHR_materials_specular`:
//!
//! ```text
//! material   = mix(dielectric, metal, metallic)
//! metal      = (c + (1 − c) w) · S                      c: base colour
//! dielectric = (1 − max F) · c / π + F · S
//! F          = f0 + (f90 − f0) w,  w = (1 − |wo·h|)⁵
//! f0         = min(((1 − ior) / (1 + ior))² · specular_color, 1) · specular,  f90 = specular
//! ```
//!
//! S is the GGX lobe with heights correlated. Both specular parts share S and w, so the mix is one Fresnel term whose
//! ends are mixed, and one diffuse term: nothing is evaluated twice.
//!
//! # Where this departs from the appendix, and why
//! Taken literally, the diffuse weight `1 − max F(wo·h)` makes light: at grazing `wo` the specular lobe reflects nearly
//! everything, while most of the half vectors that the diffuse lobe meets still see F ≈ f0. A white dielectric of
//! roughness 0.1 then returns 1.35 of a white sky at 80° and 1.71 at 89° (`cargo run --release -p etendue-bxdf
//! --example laws`). The appendix is informative and leaves better layering to the renderer. By default the weight is
//! therefore the albedo-scaled one (Kelemen, Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF
//! Model with Importance Sampling"), which is reciprocal and loses and makes nothing:
//!
//! ```text
//! (1 − F̄(wo)) (1 − F̄(wi)) / (1 − F̄avg),   F̄ = max over lanes of the dielectric's mean Fresnel term
//! ```
//!
//! F̄(w) is F averaged over the microfacets seen from w ([`crate::energy`]): the part that does not enter the base,
//! whether or not the single-scattering lobe gets all of it out again.
//!
//! [`Coupling::HalfVector`] is the literal one, for comparison with renderers that use it.
//!
//! The appendix' S loses light that meets a second microfacet: a white metal of roughness 1 reflects 0.31 of what comes
//! straight down. By default a second lobe gives it back ([`Compensation::KullaConty`]); [`Compensation::None`] is the
//! appendix. Dielectrics get none: at an index of 1.5 it would be at most 0.006 of the light.

use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    energy::Row,
    fresnel::{Schlick, f0_from_ior, schlick_weight},
    fresnel_term::Fresnel,
    ggx::{ALPHA_DELTA, Ggx, mirror},
    model::{Claims, Incidence, ModelParams},
    multiscatter::{Compensation, Further},
    parameters,
    sampling::cosine_hemisphere,
};
use core::f32::consts::{FRAC_1_PI, PI};
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What a metallic-roughness surface is at a point, after its textures; by default a white, fully rough dielectric.
    ///
    /// Out of range is clamped, NaN counts as zero (for `ior` as 1.5).
    pub struct MetalRoughParams {
        /// Diffuse colour of a dielectric, F0 of a metal; lanes 0..1.
        base_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// 0 dielectric .. 1 metal.
        metallic: f32 = 0.0, 0.0..1.0;
        /// Perceptual roughness, 0..1; α = roughness².
        roughness: f32 = 1.0, 0.0..1.0;
        /// Index of refraction, ≥ 1; 0 means infinite: reflects everything at each angle.
        ior: f32 = 1.5, 1.0..4.0;
        /// Strength of the dielectric's reflection, 0..1.
        specular: f32 = 1.0, 0.0..1.0;
        /// Tint of the dielectric's F0; lanes ≥ 0, may exceed 1.
        specular_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// What is done about light that meets several microfacets.
        compensation: Compensation = Compensation::KullaConty, 0.0..1.0;
    }
}

impl ModelParams for MetalRoughParams {
    type Closure = MetalRough;
    const ABOUT: &'static str =
        "glTF 2.0's metallic-roughness surface with KHR_materials_ior and KHR_materials_specular";

    #[inline]
    fn closure(&self, _at: &Incidence) -> MetalRough {
        MetalRough::new(self)
    }

    fn claims(&self) -> Claims {
        self.compensation.claims()
    }
}

/// How much light the diffuse part gets, given what the specular part took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Coupling {
    /// By the mean Fresnel terms of both directions: conserves energy.
    #[default]
    Albedo,
    /// By Fresnel's term at the half vector, as glTF's Appendix B writes it: makes energy at grazing angles.
    HalfVector,
}

/// The closure of a metallic-roughness surface at a point: small, `Copy`, made anew at each hit.
///
/// Reciprocal, but for [`Compensation::Turquin`]. Its [`Bsdf::albedo`] is the table's ([`crate::energy`]) with [`Coupling::Albedo`], within 0.003 of the
/// integral for cos θ ≥ 0.01; an estimate with [`Coupling::HalfVector`]. Where α falls below [`ALPHA_DELTA`] the
/// specular part is a perfect mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalRough {
    ggx: Ggx,
    mirror: bool,
    coupling: Coupling,
    row: Row,
    further: Option<Further>,
    /// Base colour of the diffuse part / π.
    diffuse: Spectrum,
    f0: Spectrum,
    f90: f32,
    /// The dielectric's largest F0 and its F90, which the diffuse part is scaled by.
    under_f0: f32,
    under_f90: f32,
    /// 1 / (1 − F̄avg).
    inv_through_average: f32,
    /// Sums over lanes, for the choice of lobe.
    sum_diffuse: f32,
    sum_f0: f32,
    sum_f90: f32,
}

/// What depends on `wo` alone.
#[derive(Clone, Copy)]
struct View {
    p_specular: f32,
    /// Of the wide lobe of further bounces.
    p_further: f32,
    /// Part of the light that single scattering loses.
    lost: f32,
    /// Part of the light that reaches the base: 1 − F̄(wo).
    through: f32,
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

impl MetalRough {
    /// The closure of a surface.
    #[inline(always)]
    pub fn new(p: &MetalRoughParams) -> Self {
        let roughness = unit(p.roughness);
        let alpha = roughness * roughness;
        let metallic = unit(p.metallic);
        let dielectric = 1.0 - metallic;
        let specular = unit(p.specular);
        let base = p.base_color.map(unit);
        let dielectric_f0 = (p.specular_color * f0_from_ior(p.ior)).map(unit) * specular;
        let f0 = dielectric_f0 * dielectric + base * metallic;
        let f90 = specular * dielectric + metallic;
        // max over lanes of F is linear in w as well: F grows with w in each lane, to the same f90.
        let under_f0 = dielectric_f0.max_element();
        let diffuse = base * (dielectric * FRAC_1_PI);
        let row = Row::new(roughness);
        let average = row.average();
        // Where nothing gets through on average nothing gets through anywhere: the inverse only has to be finite.
        let through_average = (1.0 - (under_f0 + (specular - under_f0) * average.w)).max(1e-6);
        let all = Schlick { f0, f90: Spectrum::splat(f90) };
        Self {
            ggx: Ggx::new(alpha, alpha),
            further: Further::worthwhile([alpha; 2], all.average(), f0, p.compensation),
            mirror: alpha < ALPHA_DELTA,
            coupling: Coupling::Albedo,
            row,
            diffuse,
            f0,
            f90,
            under_f0,
            under_f90: specular,
            inv_through_average: 1.0 / through_average,
            sum_diffuse: sum(diffuse) * PI,
            sum_f0: sum(f0),
            // Lanes that take no part are zero in the base colour and in `specular_color`: three stand for all.
            sum_f90: 3.0 * f90,
        }
    }

    /// The same surface with another rule for its diffuse part.
    #[inline(always)]
    pub fn with_coupling(mut self, coupling: Coupling) -> Self {
        self.coupling = coupling;
        self
    }

    #[inline(always)]
    fn fresnel(&self, w: f32) -> Spectrum {
        self.f0 + (Spectrum::splat(self.f90) - self.f0) * w
    }

    /// 1 − F̄ of the specular layer over the diffuse part, F̄ from the mean Schlick weight.
    #[inline(always)]
    fn through(&self, w: f32) -> f32 {
        (1.0 - (self.under_f0 + (self.under_f90 - self.under_f0) * w)).max(0.0)
    }

    /// The specular lobe is picked in proportion to its albedo, summed over lanes. In a furnace over base colours,
    /// metalness, roughness and angles nothing else tried (exponents 0.6, 0.8; 10, 20, 30 % towards one half) has a
    /// lower mean variance of weights.
    #[inline(always)]
    fn view(&self, wo: Vec3A) -> View {
        let lost = self.further.as_ref().map_or(0.0, |f| f.lost(wo.z));
        let wide = self.further.as_ref().is_some_and(Further::is_wide);
        // A metal has nothing to couple.
        if self.sum_diffuse == 0.0 {
            let p_further = if wide { lost } else { 0.0 };
            return View { p_specular: 1.0 - p_further, p_further, lost, through: 0.0 };
        }
        let albedo = self.row.directional(wo.z);
        let through = match self.coupling {
            Coupling::Albedo => self.through(albedo.w),
            Coupling::HalfVector => 1.0 - self.under_f0,
        };
        let specular = (self.sum_f0 + (self.sum_f90 - self.sum_f0) * albedo.w) * albedo.e;
        let further = match &self.further {
            Some(f) if wide => sum(f.albedo(lost)),
            _ => 0.0,
        };
        let all = specular + further + self.sum_diffuse * through;
        // A part of less than a millionth is never picked: one over its probability could leave f32.
        let part = |x: f32| {
            let p = if all > 0.0 { x / all } else { 0.0 };
            if p < 1e-6 { 0.0 } else { p }
        };
        let p_specular = if all > 0.0 { part(specular) } else { 1.0 };
        View { p_specular, p_further: part(further), lost, through }
    }

    /// The diffuse part's factor at a pair of directions; `w` is Schlick's weight at their half vector.
    #[inline(always)]
    fn coupled(&self, view: View, wi: Vec3A, w: f32) -> f32 {
        if self.sum_diffuse == 0.0 {
            return 0.0;
        }
        match self.coupling {
            Coupling::Albedo => {
                view.through * self.through(self.row.directional(wi.z).w) * self.inv_through_average
            }
            Coupling::HalfVector => self.through(w),
        }
    }

    /// Value by lobe and density; both directions must lie above [`MIN_COS`].
    #[inline(always)]
    fn eval_above(&self, view: View, wo: Vec3A, wi: Vec3A) -> Eval {
        let p_diffuse = 1.0 - (view.p_specular + view.p_further);
        let pdf_diffuse = p_diffuse.max(0.0) * (wi.z * FRAC_1_PI);
        if self.mirror {
            let w = schlick_weight(0.5 * (wo + wi).length());
            let diffuse = self.diffuse * self.coupled(view, wi, w);
            return Eval { diffuse, specular: Spectrum::ZERO, pdf: pdf_diffuse };
        }
        let pair = self.ggx.pair(wo, wi);
        let w = schlick_weight(pair.cos_half);
        let mut specular = self.fresnel(w) * pair.value;
        let mut pdf = view.p_specular * pair.pdf + pdf_diffuse;
        if let Some(f) = &self.further {
            specular = specular * f.scale(view.lost) + f.value(view.lost, wi.z);
            pdf += view.p_further * f.pdf(wi.z);
        }
        Eval { diffuse: self.diffuse * self.coupled(view, wi, w), specular, pdf }
    }
}

impl Bsdf for MetalRough {
    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z > MIN_COS) {
            return Eval::ZERO;
        }
        let e = self.eval_above(self.view(wo), wo, wi);
        if e.pdf < f32::INFINITY { e } else { Eval::ZERO }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let view = self.view(wo);
        let p_specular = view.p_specular;
        // A `uc` below its range must not pick a lobe of probability zero.
        let uc = uc.max(0.0);
        let specular = uc < p_specular;
        let further = self.further.as_ref().filter(|_| !specular && uc < p_specular + view.p_further);
        if specular && self.mirror {
            if !wo.is_finite() {
                return None;
            }
            let weight = self.fresnel(schlick_weight(wo.z)) * (1.0 / p_specular);
            return Some(BsdfSample {
                wi: mirror(wo),
                weight,
                weight_diffuse: Spectrum::ZERO,
                weight_specular: weight,
                pdf: p_specular,
                delta: true,
                lobe: LobeKind::Specular,
            });
        }
        let wi = match further {
            Some(f) => f.sample(u),
            None if specular => self.ggx.sample_reflection(wo, u),
            None => cosine_hemisphere(u),
        };
        if !(wi.z > MIN_COS && wi.is_finite()) {
            return None;
        }
        let e = self.eval_above(view, wo, wi);
        if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
            return None;
        }
        let scale = wi.z / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        Some(BsdfSample {
            wi,
            weight: weight_diffuse + weight_specular,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            delta: false,
            lobe: if specular || further.is_some() { LobeKind::Specular } else { LobeKind::Diffuse },
        })
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let albedo = self.row.directional(wo.z);
        let mut specular = self.fresnel(albedo.w) * albedo.e;
        if let Some(f) = &self.further {
            let lost = f.lost(wo.z);
            specular = specular * f.scale(lost) + f.albedo(lost);
        }
        self.diffuse * (PI * self.through(albedo.w)) + specular
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        if !self.mirror || !(wo.z > MIN_COS) {
            return [None, None];
        }
        let part = DeltaPart {
            wi: mirror(wo),
            reflectance: self.fresnel(schlick_weight(wo.z)),
            probability: self.view(wo).p_specular,
        };
        [Some(part), None]
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.mirror { [1.0, 1.0] } else { self.ggx.alpha() }
    }
}
