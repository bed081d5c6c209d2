//! A rough boundary between dielectrics with the light of further bounces.

use super::{Compensation, loss::BoundaryLoss, mean_alpha, wide::Wide};
use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS},
    dielectric::{GgxDielectric, Interface},
    fresnel_term::{Dielectric, dielectric_average},
    model::Transport,
};
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::Vec3A;

/// A boundary of GGX microfacets between two dielectrics, and what is done about light that meets several of them.
///
/// With a and b the two sides, L the losses of single scattering from either ([`super::loss`]), F̄ Fresnel's means over
/// the hemisphere and n the indices:
///
/// - [`Compensation::KullaConty`] adds wide lobes on both sides (after Kulla, Conty 2017, slides 21 to 27), counting power:
///
/// ```text
/// f_aa = (1 − k_a) La(wo) La(wi) / (π L̄a),   f_ab = k_a La(wo) Lb(wi) / (π L̄b),   k_a = q n_b² L̄b
/// ```
///
///   Each side gets back what it lost, and the common factor q makes transmission reciprocal, f_ab / n_b² = f_ba / n_a².
///   Where both losses are alike k_a is 1 − F̄a, because n_a² (1 − F̄a) = n_b² (1 − F̄b); they differ, and q takes
///   the geometric mean: q = (1 − F̄a) / (n_b² √(L̄a L̄b)), no more than leaves both k ≤ 1. (The slides choose the parts by
///   a ratio of their own.)
/// - [`Compensation::Turquin`] divides both lobes by E(wo) (Turquin 2019, section 4). Not reciprocal.
///
/// Returns all light (counted as power), from 0.006 less to 0.001 more, where both α are equal; with Turquin's scaling these
/// over E. Where
/// they differ a part of the loss is given back, as by [`super::CompensatedGgx`]. Smooth and matched boundaries lose nothing and get nothing. Tints multiply the wide lobes
/// once, as they do the narrow ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedDielectric {
    single: GgxDielectric<Dielectric>,
    compensation: Compensation,
    near: BoundaryLoss,
    far: BoundaryLoss,
    wide: Wide,
    /// The part of the wide lobes that passes; k_a.
    passes: f32,
    /// The part of the loss that is given back: less than 1 where the two α differ.
    share: f32,
    /// Factors of L(wo) L(wi) on both sides, with tints and the scaling of radiance.
    multiple: [Spectrum; 2],
}

impl CompensatedDielectric {
    /// α along x and y (0..1), Fresnel's equations as seen from the near side, and what the path carries.
    #[inline]
    pub fn new(alpha: [f32; 2], face: Dielectric, transport: Transport, compensation: Compensation) -> Self {
        let single = GgxDielectric::new(alpha, face, transport);
        let compensation = if single.is_rough() { compensation } else { Compensation::None };
        let eta = Interface::eta(&face);
        let (mean, share) = mean_alpha(single.ggx().alpha());
        let (near, far) = (BoundaryLoss::new(mean, eta), BoundaryLoss::new(mean, 1.0 / eta));
        let mut out = Self {
            single,
            compensation,
            near,
            far,
            wide: Wide::new(mean),
            passes: 0.0,
            share,
            multiple: [Spectrum::ZERO; 2],
        };
        if compensation == Compensation::KullaConty {
            let (a, b) = (near.average(), far.average());
            // In units in which n_a is 1: q, no more than 1 / (n_b² L̄b) and 1 / (n_a² L̄a).
            let eta2 = eta * eta;
            let q = ((1.0 - dielectric_average(eta)) / (eta2 * (a * b).sqrt()))
                .min(1.0 / (eta2 * b))
                .min(1.0 / a);
            out.passes = (q * eta2 * b).min(1.0);
            let scale = match transport {
                Transport::Radiance => 1.0,
                Transport::Importance => eta2,
            };
            out.multiple =
                [(1.0 - out.passes) / a, q * scale].map(|v| Spectrum::splat(v * (share * FRAC_1_PI)));
        }
        out
    }

    /// The same boundary with reflected and transmitted light multiplied by colours; see [`GgxDielectric::tinted`].
    #[inline]
    pub fn tinted(mut self, reflection: Spectrum, transmission: Spectrum) -> Self {
        self.single = self.single.tinted(reflection, transmission);
        let [r, t] = self.single.tints();
        self.multiple = [self.multiple[0] * r, self.multiple[1] * t];
        self
    }

    /// The boundary without compensation.
    #[inline(always)]
    pub fn single(&self) -> &GgxDielectric<Dielectric> {
        &self.single
    }

    /// Probability of the wide lobes: their part of the energy.
    #[inline(always)]
    fn p_multiple(&self, lost: f32) -> f32 {
        if self.compensation == Compensation::KullaConty { lost } else { 0.0 }
    }

    /// What the narrow lobes are multiplied by.
    #[inline(always)]
    fn scale(&self, lost: f32) -> f32 {
        if self.compensation == Compensation::Turquin {
            1.0 + self.share * lost / (1.0 - lost).max(0.02)
        } else {
            1.0
        }
    }

    #[inline(always)]
    fn at(&self, lost: f32, wo: Vec3A, wi: Vec3A) -> Eval {
        let single = self.single.eval_pdf(wo, wi);
        let mut e = Eval { specular: single.specular * self.scale(lost), ..single };
        if self.compensation == Compensation::KullaConty {
            let p = self.p_multiple(lost);
            let cos = wi.z.abs();
            let (multiple, there, part) = if wi.z > 0.0 {
                (self.multiple[0], self.near.directional(cos), 1.0 - self.passes)
            } else {
                (self.multiple[1], self.far.directional(cos), self.passes)
            };
            e.specular += multiple * (lost * there);
            e.pdf = (1.0 - p) * single.pdf + p * part * self.wide.pdf(cos);
        }
        if e.pdf < f32::INFINITY && e.specular.is_finite() { e } else { Eval::ZERO }
    }
}

impl Bsdf for CompensatedDielectric {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        if self.compensation == Compensation::None {
            return self.single.eval_pdf(wo, wi);
        }
        // Also taken by NaN.
        if !(wo.z > MIN_COS && wi.z.abs() > MIN_COS) {
            return Eval::ZERO;
        }
        self.at(self.near.directional(wo.z), wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if self.compensation == Compensation::None {
            return self.single.sample(wo, uc, u);
        }
        if !(wo.z > MIN_COS && wo.is_finite()) {
            return None;
        }
        let lost = self.near.directional(wo.z);
        let p = self.p_multiple(lost);
        let uc = uc.max(0.0);
        // What is left of `uc` picks the side.
        let wi = if uc < p {
            let mut wi = self.wide.sample(u);
            if uc < p * self.passes {
                wi.z = -wi.z;
            }
            wi
        } else {
            self.single.sample(wo, (uc - p) / (1.0 - p), u)?.wi
        };
        if !(wi.z.abs() > MIN_COS && wi.is_finite()) {
            return None;
        }
        let e = self.at(lost, wo, wi);
        if !(e.pdf > 0.0) {
            return None;
        }
        let weight = e.specular * (wi.z.abs() / e.pdf);
        Some(BsdfSample {
            wi,
            weight,
            weight_diffuse: Spectrum::ZERO,
            weight_specular: weight,
            pdf: e.pdf,
            delta: false,
            lobe: LobeKind::Specular,
        })
    }

    /// An estimate: the smooth boundary's split of what single scattering brings out, and the wide lobes.
    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        let smooth = self.single.albedo(wo);
        if !(self.single.is_rough() && wo.z > MIN_COS) {
            return smooth;
        }
        let lost = self.near.directional(wo.z);
        let wide = [self.near.average(), self.far.average()];
        let multiple = self.multiple[0] * wide[0] + self.multiple[1] * wide[1];
        smooth * ((1.0 - lost) * self.scale(lost)) + multiple * (lost * core::f32::consts::PI)
    }

    #[inline]
    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        self.single.deltas(wo)
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        self.single.narrowest_alpha()
    }

    #[inline]
    fn refraction(&self) -> Option<f32> {
        self.single.refraction()
    }
}
