//! A surface made ready for shading: what does not depend on where light comes from.

use crate::choices::{Choices, Compensation, DfgSource, LeastRoughness};
use crate::inputs::Inputs;
use etendue_bxdf::energy::Row;
use etendue_bxdf::fresnel::{f0_from_ior, schlick_weight};
use etendue_bxdf::ggx::ALPHA_DELTA;
use etendue_bxdf::multiscatter::loss::MirrorLoss;
use etendue_bxdf::{Fresnel, Ggx, Schlick};
use etendue_color::Spectrum;
use etendue_ibl::{Dfg, dfg_fit};
use glam::{Vec3A, vec3a};
use std::f32::consts::FRAC_1_PI;

/// The base: metal, dielectric and what lies under the dielectric. Directions are in [`Inputs::frame`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Towards the viewer.
    pub wo: Vec3A,
    /// Perceptual roughness; where the lobe is anisotropic that of the mean α.
    pub roughness: f32,
    pub ggx: Ggx,
    /// Too smooth for a lobe: a perfect mirror.
    pub mirror: bool,
    pub base_color: Spectrum,
    pub metallic: f32,
    /// F0 and F90 of dielectric and metal together.
    pub f0: Spectrum,
    pub f90: f32,
    /// The dielectric's largest F0, and its F90: what the diffuse part lies under.
    pub under: [f32; 2],
    /// Mean Fresnel terms and albedo by angle.
    pub row: Row,
    /// One over the mean of what reaches the diffuse part.
    pub inv_through_average: f32,
    /// What of the light from `wo` reaches the diffuse part.
    pub through: f32,
    /// Colour of the diffuse part: albedo, not yet over π.
    pub matte: Spectrum,
    pub bounces: Bounces,
}

/// What is done about light that meets several microfacets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounces {
    pub loss: MirrorLoss,
    /// The part of the light from `wo` that single scattering loses.
    pub lost: f32,
    /// Factors of the F0 part and of the F90 part of the single-scattering lobe.
    pub scale: [Spectrum; 2],
    /// The wide lobe over what both directions lose.
    pub wide: Spectrum,
}

/// 0..1, NaN to 0.
#[inline(always)]
pub(crate) fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

impl Bounces {
    /// For a lobe of the α that stands for both of an anisotropic one's, seen at `cos`, between F0 and F90; `share` is the part that
    /// is given back.
    #[inline]
    fn new(alpha: f32, share: f32, cos: f32, f0: Spectrum, f90: f32, choice: Compensation) -> Self {
        let loss = MirrorLoss::new(alpha);
        let none = [Spectrum::ONE; 2];
        let mut out = Self { loss, lost: 0.0, scale: none, wide: Spectrum::ZERO };
        if choice == Compensation::None || !(alpha >= ALPHA_DELTA) {
            return out;
        }
        let average = Schlick { f0, f90: Spectrum::splat(f90) }.average();
        // As the reference: where less than a hundredth of what was lost would come back nothing is done.
        let most = average.max_element();
        if !(most * most > 0.01) {
            return out;
        }
        out.lost = loss.directional(cos);
        let ratio = share * out.lost / (1.0 - out.lost);
        let (mean_lost, mean_kept) = (loss.average(), 1.0 - loss.average());
        match choice {
            Compensation::None => {}
            Compensation::KullaConty => {
                let returned = average.map(|f| f * f * mean_kept / (1.0 - f * mean_lost));
                out.wide = returned * (share * FRAC_1_PI / mean_lost);
            }
            Compensation::Turquin => out.scale = [Spectrum::ONE + f0 * ratio; 2],
            Compensation::Endpoint => {
                let series = |f: f32| 1.0 + ratio * f * mean_kept / (1.0 - f * mean_lost);
                out.scale = [f0.map(series), Spectrum::splat(series(f90))];
            }
        }
        out
    }
}

impl Surface {
    /// Reads the inputs as `choices` want them.
    #[inline]
    pub fn new(inputs: &Inputs, choices: &Choices) -> Self {
        let p = &inputs.surface;
        let f = &inputs.frame;
        let v = inputs.view;
        let wo = vec3a(f.x.dot(v), f.y.dot(v), f.z.dot(v).max(1e-4).min(1.0));
        let least = match choices.least_roughness {
            LeastRoughness::Zero => 0.0,
            LeastRoughness::Filament => 0.045,
        };
        let roughness = unit(p.roughness).max(least);
        let alpha = roughness * roughness;
        let strength = unit(p.anisotropy_strength);
        let alpha = [alpha + (1.0 - alpha) * (strength * strength), alpha];
        let anisotropic = alpha[0] != alpha[1];
        let (mean, share) = if anisotropic { mean_alpha(alpha) } else { (alpha[0], 1.0) };
        let roughness = if anisotropic { mean.sqrt() } else { roughness };
        let metallic = unit(p.metallic);
        let dielectric = 1.0 - metallic;
        let specular = unit(p.specular);
        let base_color = p.base_color.map(unit);
        let dielectric_f0 = (p.specular_color * f0_from_ior(p.ior)).map(unit) * specular;
        let f0 = dielectric_f0 * dielectric + base_color * metallic;
        let f90 = specular * dielectric + metallic;
        let under = [dielectric_f0.max_element(), specular];
        let row = Row::new(roughness);
        let through = |w: f32| 1.0 - (under[0] + (under[1] - under[0]) * w);
        Self {
            wo,
            roughness,
            ggx: Ggx::new(alpha[0], alpha[1]),
            mirror: !(alpha[0].max(alpha[1]) >= ALPHA_DELTA),
            base_color,
            metallic,
            f0,
            f90,
            under,
            row,
            inv_through_average: 1.0 / through(row.average().w).max(1e-6),
            through: through(row.directional(wo.z).w).max(0.0),
            matte: base_color * dielectric,
            bounces: Bounces::new(mean, share, wo.z, f0, f90, choices.compensation),
        }
    }

    /// Fresnel's term for Schlick's weight `w`, without any factor.
    #[inline(always)]
    pub fn fresnel(&self, w: f32) -> Spectrum {
        self.f0 + (Spectrum::splat(self.f90) - self.f0) * w
    }

    /// The same with the factors of energy compensation on both of its ends.
    #[inline(always)]
    pub fn compensated(&self, w: f32) -> Spectrum {
        let [a, b] = self.bounces.scale;
        self.f0 * a * (1.0 - w) + b * (self.f90 * w)
    }

    /// What of the light from a direction of cosine `cos` reaches the diffuse part.
    #[inline(always)]
    pub fn through_at(&self, cos: f32) -> f32 {
        let w = self.row.directional(cos).w;
        (1.0 - (self.under[0] + (self.under[1] - self.under[0]) * w)).max(0.0)
    }

    /// A and B of the lobe's reflectance, F0 · A + F90 · B.
    #[inline]
    pub fn dfg(&self, source: DfgSource) -> Dfg {
        let (r, cos) = (self.roughness, self.wo.z);
        match source {
            DfgSource::Table => {
                let a = self.row.directional(cos);
                Dfg { scale: a.e * (1.0 - a.w), bias: a.e * a.w }
            }
            DfgSource::Exact => Dfg::sampled(r, cos, 2048),
            DfgSource::Fit => dfg_fit::ours(r, cos),
            DfgSource::Karis => dfg_fit::karis(r, cos),
            DfgSource::Lazarov => dfg_fit::lazarov(r, cos),
            DfgSource::Unity => {
                let reflectivity = self.under[0] + (1.0 - self.under[0]) * self.metallic;
                let grazing = unit(1.0 - r + reflectivity);
                let alpha = r * r;
                let (surface, w) = (1.0 / (alpha * alpha + 1.0), schlick_weight(cos));
                Dfg { scale: surface * (1.0 - w), bias: surface * w * grazing }
            }
        }
    }
}

/// The one α that stands for two, √((αx² + αy²) / 2), and the part of its loss that may be given back, (αmin / αmax)^(5/4): as
/// [`etendue_bxdf::multiscatter`] does.
#[inline]
fn mean_alpha([x, y]: [f32; 2]) -> (f32, f32) {
    let ratio = x.min(y) / x.max(y);
    ((0.5 * (x * x + y * y)).sqrt(), ratio * ratio.sqrt().sqrt())
}
