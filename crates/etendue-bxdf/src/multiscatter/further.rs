//! What further bounces add to the lobe of a GGX mirror.

use super::{Compensation, loss::MirrorLoss, mean_alpha, wide::Wide};
use crate::ggx::ALPHA_DELTA;
use core::f32::consts::{FRAC_1_PI, PI};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Light that met several microfacets, for a closure that has the single-scattering lobe itself: a factor of that lobe
/// ([`Further::scale`]), and a wide lobe beside it ([`Further::value`], [`Further::sample`], [`Further::pdf`]). Formulas:
/// [`super::CompensatedGgx`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Further {
    compensation: Compensation,
    loss: MirrorLoss,
    wide: Wide,
    /// F_ms / (π L̄), of [`Compensation::KullaConty`].
    multiple: Spectrum,
    /// F(1), less where the two α differ, of [`Compensation::Turquin`].
    gain: Spectrum,
}

impl Further {
    /// For α along x and y (0..1), the Fresnel term's mean over the hemisphere and its value at normal incidence. Nothing
    /// for smooth surfaces, which lose nothing.
    #[inline]
    pub fn new(alpha: [f32; 2], average: Spectrum, f0: Spectrum, compensation: Compensation) -> Self {
        let (mean, share) = mean_alpha(alpha);
        let loss = MirrorLoss::new(mean);
        // Also taken by NaN.
        let smooth = !(alpha[0].max(alpha[1]) >= ALPHA_DELTA);
        let compensation = if smooth { Compensation::None } else { compensation };
        let mut out = Self {
            compensation,
            loss,
            wide: Wide::new(mean),
            multiple: Spectrum::ZERO,
            gain: Spectrum::ZERO,
        };
        match compensation {
            Compensation::None => {}
            Compensation::KullaConty => {
                let (lost, kept) = (loss.average(), 1.0 - loss.average());
                let returned = average.map(|f| f * f * kept / (1.0 - f * lost));
                out.multiple = returned * (share * FRAC_1_PI / lost);
            }
            Compensation::Turquin => out.gain = f0 * share,
        }
        out
    }

    /// The same, or nothing where it would give back less than a hundredth of what was lost: an engine's question about
    /// dielectrics, to which further bounces on the outside matter little.
    #[inline(always)]
    pub fn worthwhile(
        alpha: [f32; 2],
        average: Spectrum,
        f0: Spectrum,
        compensation: Compensation,
    ) -> Option<Self> {
        // F_ms ≤ F̄².
        let most = average.max_element();
        let rough = alpha[0].max(alpha[1]) >= ALPHA_DELTA;
        (compensation != Compensation::None && rough && most * most > 0.01)
            .then(|| Self::new(alpha, average, f0, compensation))
    }

    /// The part of the light from a direction of cosine `cos` that single scattering loses, 0..1.
    #[inline(always)]
    pub fn lost(&self, cos: f32) -> f32 {
        self.loss.directional(cos)
    }

    /// Factor of the single-scattering lobe for light lost from `wo`.
    #[inline(always)]
    pub fn scale(&self, lost: f32) -> Spectrum {
        match self.compensation {
            Compensation::Turquin => Spectrum::ONE + self.gain * (lost / (1.0 - lost)),
            _ => Spectrum::ONE,
        }
    }

    /// True if there is a wide lobe.
    #[inline(always)]
    pub fn is_wide(&self) -> bool {
        self.compensation == Compensation::KullaConty
    }

    /// The wide lobe's value (without the cosine) for light lost from `wo`, towards a direction of cosine `cos` above 0.
    #[inline(always)]
    pub fn value(&self, lost: f32, cos: f32) -> Spectrum {
        if self.is_wide() { self.multiple * (lost * self.lost(cos)) } else { Spectrum::ZERO }
    }

    /// The wide lobe's albedo for light lost from `wo`.
    #[inline(always)]
    pub fn albedo(&self, lost: f32) -> Spectrum {
        self.multiple * (lost * self.loss.average() * PI)
    }

    /// A good probability for the wide lobe beside the single-scattering one: its albedo, in the largest lane.
    #[inline(always)]
    pub fn probability(&self, lost: f32) -> f32 {
        self.albedo(lost).max_element().min(lost)
    }

    /// A direction of the wide lobe.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3A {
        self.wide.sample(u)
    }

    /// Density of [`Further::sample`], per steradian.
    #[inline(always)]
    pub fn pdf(&self, cos: f32) -> f32 {
        self.wide.pdf(cos)
    }
}
