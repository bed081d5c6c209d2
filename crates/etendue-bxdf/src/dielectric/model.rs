//! The models `dielectric` and `thin-sheet`.

use super::{Dielectric, DiffuseTransmission, Sheet, ThinGgx, absorption};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, MIN_COS},
    ggx::anisotropic_alpha,
    model::{Claim, Claims, Incidence, Interior, ModelParams},
    multiscatter::{CompensatedDielectric, Compensation},
    parameters,
};
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What a body of glass, water or another clear medium is at its surface and inside.
    ///
    /// Out of range is clamped, NaN counts as the lower end.
    pub struct DielectricParams {
        /// Index of refraction; with dispersion, of the middle lane.
        ior: f32 = 1.5, 1.0..4.0;
        /// Perceptual roughness; α = roughness².
        roughness: f32 = 0.0, 0.0..1.0;
        /// 0 round highlights .. 1 long ones (Burley 2012).
        anisotropy: f32 = 0.0, 0.0..1.0;
        /// Tint of light that passes the surface, each time.
        transmission_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// What is left of white light after `absorption_distance` inside.
        absorption_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Metres; 0 absorbs nothing.
        absorption_distance: f32 = 1.0, 0.0..1000.0;
        /// 20 over the Abbe number, as `KHR_materials_dispersion` has it; 0 is none, most glasses have 0.3 to 1.
        dispersion: f32 = 0.0, 0.0..10.0;
        /// Where bodies overlap, the one with the larger (whole) number fills the space.
        priority: f32 = 0.0, 0.0..100.0;
        /// What is done about light that meets several microfacets.
        compensation: Compensation = Compensation::KullaConty, 0.0..1.0;
    }
}

/// `x` clamped, NaN to `low`.
#[inline(always)]
fn clamp(x: f32, low: f32, high: f32) -> f32 {
    x.max(low).min(high)
}

/// Far index over near index for a body of index `ior`.
#[inline(always)]
fn relative_index(ior: f32, at: &Incidence) -> f32 {
    let outside = clamp(at.exterior_ior, 1.0, 10.0);
    if at.front { ior / outside } else { outside / ior }
}

impl DielectricParams {
    /// Index of refraction of a lane, or the middle one.
    ///
    /// `KHR_materials_dispersion` gives red, green and blue n ∓ (n − 1) · 0.025 · dispersion, which is half of the Abbe
    /// number's n_F − n_C to either side. Lanes 0, 1, 2 stand for these; lane 3 has the middle.
    #[inline(always)]
    pub fn ior_of(&self, lane: Option<u8>) -> f32 {
        let ior = clamp(self.ior, 1.0, 4.0);
        let half = (ior - 1.0) * 0.025 * clamp(self.dispersion, 0.0, 10.0);
        match lane {
            Some(0) => ior - half,
            Some(2) => ior + half,
            _ => ior,
        }
    }
}

impl ModelParams for DielectricParams {
    type Closure = CompensatedDielectric;
    const ABOUT: &'static str = "glass, water, gems: reflection and refraction by GGX microfacets (Walter et al. 2007), with absorption inside";

    #[inline]
    fn closure(&self, at: &Incidence) -> CompensatedDielectric {
        let roughness = clamp(self.roughness, 0.0, 1.0);
        let alpha = anisotropic_alpha(roughness, clamp(self.anisotropy, 0.0, 1.0));
        let face = Dielectric::new(relative_index(self.ior_of(at.lane), at));
        let tint = self.transmission_color.map(|v| clamp(v, 0.0, 1.0));
        CompensatedDielectric::new(alpha, face, at.transport, self.compensation).tinted(Spectrum::ONE, tint)
    }

    fn claims(&self) -> Claims {
        let claims = self.compensation.claims();
        match self.compensation {
            Compensation::Turquin => Claims {
                conserves: Claim::Breaks(
                    "scaling by 1 / E enlarges the loss table's error: 0.001 / E at most",
                ),
                ..claims
            },
            _ => claims,
        }
    }

    fn interior(&self) -> Option<Interior> {
        Some(Interior {
            ior: self.ior_of(None),
            absorption: absorption::coefficient(self.absorption_color, self.absorption_distance),
            scatter: None,
            priority: clamp(self.priority, 0.0, 100.0) as i32,
            dispersive: self.dispersion > 0.0,
        })
    }
}

parameters! {
    /// What a thin sheet is at a point: from a pane of glass or a soap film to paper and cloth.
    ///
    /// Out of range is clamped, NaN counts as the lower end.
    pub struct ThinSheetParams {
        /// Index of refraction of the clear part.
        ior: f32 = 1.5, 1.0..4.0;
        /// Perceptual roughness of the clear part; α = roughness².
        roughness: f32 = 0.0, 0.0..1.0;
        /// 0 round highlights .. 1 long ones (Burley 2012).
        anisotropy: f32 = 0.0, 0.0..1.0;
        /// What is left of light that crosses the clear part once.
        crossing_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// 0 is clear (a pane, a film), 1 scatters all light (paper, cloth).
        fibers: f32 = 0.0, 0.0..1.0;
        /// What the fibres send back.
        reflect_color: Spectrum = Spectrum::rgb(0.4, 0.4, 0.4), 0.0..1.0;
        /// What the fibres let through; scaled down with `reflect_color` where the two exceed 1.
        transmit_color: Spectrum = Spectrum::rgb(0.4, 0.4, 0.4), 0.0..1.0;
    }
}

impl ModelParams for ThinSheetParams {
    type Closure = ThinSheet;
    const ABOUT: &'static str = "a thin sheet: two faces with light to and fro between them (Stokes 1862), mixed with fibres that scatter evenly";

    #[inline]
    fn closure(&self, at: &Incidence) -> ThinSheet {
        // Both faces are seen from outside, whichever side the path comes from.
        let face = Dielectric::new(clamp(self.ior, 1.0, 4.0) / clamp(at.exterior_ior, 1.0, 10.0));
        let alpha = anisotropic_alpha(clamp(self.roughness, 0.0, 1.0), clamp(self.anisotropy, 0.0, 1.0));
        ThinSheet {
            clear: ThinGgx::new(alpha, Sheet::new(face, self.crossing_color)),
            scattering: DiffuseTransmission::new(self.reflect_color, self.transmit_color),
            fibers: clamp(self.fibers, 0.0, 1.0),
        }
    }
}

/// A thin sheet at a point: a clear part and fibres, side by side.
///
/// Reciprocal. Its [`Bsdf::albedo`] is exact where smooth or all fibres, else an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinSheet {
    clear: ThinGgx<Sheet<Dielectric>>,
    scattering: DiffuseTransmission,
    fibers: f32,
}

impl ThinSheet {
    /// Probability that the clear part is drawn from.
    #[inline(always)]
    fn p_clear(&self, wo: Vec3A) -> f32 {
        if self.fibers <= 0.0 {
            return 1.0;
        }
        if self.fibers >= 1.0 {
            return 0.0;
        }
        let part = |s: Spectrum, by: f32| s.0.iter().sum::<f32>() * by;
        let clear = part(self.clear.albedo(wo), 1.0 - self.fibers);
        let all = clear + part(self.scattering.albedo(wo), self.fibers);
        // Never quite 0 or 1: what the estimate misses must be drawn too.
        if all > 0.0 { (clear / all).clamp(0.01, 0.99) } else { 0.5 }
    }

    /// Both parts, given the probability.
    #[inline(always)]
    fn mixed(&self, p_clear: f32, wo: Vec3A, wi: Vec3A) -> Eval {
        let (c, d) = (self.clear.eval_pdf(wo, wi), self.scattering.eval_pdf(wo, wi));
        Eval {
            diffuse: d.diffuse * self.fibers,
            specular: c.specular * (1.0 - self.fibers),
            pdf: c.pdf * p_clear + d.pdf * (1.0 - p_clear),
        }
    }
}

impl Bsdf for ThinSheet {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        let e = self.mixed(self.p_clear(wo), wo, wi);
        if e.pdf < f32::INFINITY { e } else { Eval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !(wo.z > MIN_COS) {
            return None;
        }
        let p = self.p_clear(wo);
        let uc = uc.max(0.0);
        // What is left of `uc` picks the side within the part.
        let s = if uc < p {
            self.clear.sample(wo, uc / p, u)?
        } else {
            self.scattering.sample(wo, (uc - p) / (1.0 - p), u)?
        };
        if s.delta {
            let weight = s.weight * ((1.0 - self.fibers) / p);
            return Some(BsdfSample { weight, weight_specular: weight, pdf: s.pdf * p, ..s });
        }
        let e = self.mixed(p, wo, s.wi);
        if !(e.pdf > 0.0 && e.pdf < f32::INFINITY) {
            return None;
        }
        let scale = s.wi.z.abs() / e.pdf;
        let (weight_diffuse, weight_specular) = (e.diffuse * scale, e.specular * scale);
        Some(BsdfSample {
            weight: weight_diffuse + weight_specular,
            weight_diffuse,
            weight_specular,
            pdf: e.pdf,
            ..s
        })
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        self.clear.albedo(wo) * (1.0 - self.fibers) + self.scattering.albedo(wo) * self.fibers
    }

    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let p = self.p_clear(wo);
        self.clear.deltas(wo).map(|d| {
            d.filter(|_| p > 0.0).map(|d| DeltaPart {
                reflectance: d.reflectance * (1.0 - self.fibers),
                probability: d.probability * p,
                ..d
            })
        })
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        if self.fibers >= 1.0 { [1.0, 1.0] } else { self.clear.narrowest_alpha() }
    }

    #[inline]
    fn refraction(&self) -> Option<f32> {
        Some(1.0)
    }
}
