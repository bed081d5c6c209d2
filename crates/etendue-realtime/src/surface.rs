//! A surface made ready for shading: what does not depend on where light comes from.

use crate::choices::{Choices, Compensation, DfgSource, LeastRoughness};
use crate::film::Film;
use crate::gloss::Gloss;
use crate::inputs::{Inputs, Part};
use crate::layers::Layers;
use crate::transmit::Passing;
use crate::zonal::{Bands, quadrature_bands};
use etendue_bxdf::diffuse::eon::Eon;
use etendue_bxdf::fresnel::{f0_from_ior, schlick_weight};
use etendue_bxdf::ggx::ALPHA_DELTA;
use etendue_bxdf::math::sin_cos_tau;
use etendue_bxdf::multiscatter::loss::MirrorLoss;
use etendue_bxdf::{Fresnel, Schlick};
use etendue_color::Spectrum;
use etendue_ibl::{Dfg, dfg_fit};
use glam::{Vec3A, vec3a};
use std::f32::consts::{FRAC_1_PI, PI};

/// The base, metal and dielectric and what lies under the dielectric, and the layers above. Directions are in [`Inputs::frame`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Which of the samples of glossy lobes are taken.
    pub part: Part,
    /// The base's lobe; its `wo` is the direction to the viewer.
    pub gloss: Gloss,
    pub base_color: Spectrum,
    pub metallic: f32,
    /// F0 and F90 of dielectric and metal together.
    pub f0: Spectrum,
    pub f90: f32,
    /// The dielectric's largest F0, and its F90: what the diffuse part lies under.
    pub under: [f32; 2],
    /// One over the mean of what reaches the diffuse part.
    pub inv_entering_average: f32,
    /// What of the light from `wo` reaches the diffuse part.
    pub entering: f32,
    /// Bands of cosine × what reaches the diffuse part, where layers or a film make these other than the base's own.
    pub bands: Option<Bands>,
    /// Colour of the diffuse part on the near side and on the far side: albedo, not yet over π; of a rough one as it is seen from
    /// `wo` under even light.
    pub matte: [Spectrum; 2],
    /// The lobes of a rough diffuse part on either side.
    pub rough: Option<[Eon; 2]>,
    pub bounces: Bounces,
    pub film: Option<Film>,
    pub layers: Option<Layers>,
    pub passing: Option<Passing>,
}

/// What is done about light that meets several microfacets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounces {
    pub loss: MirrorLoss,
    /// Perceptual roughness of the α that stands for both of an anisotropic lobe's.
    pub roughness: f32,
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
    /// For a lobe of α along x and y, seen at `cos`, with Fresnel's term between F0 and F90 and its mean over the hemisphere.
    #[inline]
    fn new(
        alpha: [f32; 2],
        cos: f32,
        f0: Spectrum,
        f90: f32,
        average: Spectrum,
        choice: Compensation,
    ) -> Self {
        // As `etendue_bxdf::multiscatter` does: one α that loses as much, and the part of its loss that may be given back.
        let [x, y] = alpha;
        let (alpha, share) = if x == y {
            (x, 1.0)
        } else {
            let ratio = x.min(y) / x.max(y);
            ((0.5 * (x * x + y * y)).sqrt(), ratio * ratio.sqrt().sqrt())
        };
        let loss = MirrorLoss::new(alpha);
        let scale = [Spectrum::ONE; 2];
        let mut out = Self { loss, roughness: alpha.sqrt(), lost: 0.0, scale, wide: Spectrum::ZERO };
        if choice == Compensation::None || !(alpha >= ALPHA_DELTA) {
            return out;
        }
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
    /// Factor of the coupling in the diffuse light from `wi` (turned to the upper side) on a side: the colour, or π times the rough
    /// lobe.
    #[inline(always)]
    pub fn matte_at(&self, side: usize, wi: Vec3A) -> Spectrum {
        match &self.rough {
            None => self.matte[side],
            Some(lobes) => lobes[side].value(self.gloss.wo, wi) * PI,
        }
    }

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
        let metallic = unit(p.metallic);
        let dielectric = 1.0 - metallic;
        let specular = unit(p.specular);
        let base_color = p.base_color.map(unit);
        let dielectric_f0 = (p.specular_color * f0_from_ior(p.ior)).map(unit) * specular;
        let f0 = dielectric_f0 * dielectric + base_color * metallic;
        let f90 = specular * dielectric + metallic;
        let under = [dielectric_f0.max_element(), specular];
        let gloss = Gloss::new(wo, alpha);
        let film = Film::new(p, dielectric_f0, specular, base_color);
        let schlick = Schlick { f0, f90: Spectrum::splat(f90) };
        let (straight, average) = match &film {
            None => (f0, schlick.average()),
            Some(film) => (film.over(f0, 1.0), film.average(&schlick)),
        };
        let passing = Passing::new(p, roughness, &gloss, inputs.front);
        let deep = passing.as_ref().and_then(|t| t.scattered(p));
        let sides = p.matte(deep.unwrap_or_else(|| p.scattered_by_sheet()));
        let roughness = unit(p.diffuse_roughness);
        let rough =
            (roughness > 0.0).then(|| sides.map(|(color, share)| Eon::new(color, roughness).scaled(share)));
        let matte = match &rough {
            None => sides.map(|(color, share)| color * share),
            Some(lobes) => lobes.map(|l| l.reflected(wo.z)),
        };
        // Coat and fibres lie outside of a volume that is seen from inside.
        let outside = inputs.front || !passing.is_some_and(|t| t.is_solid());
        let mut s = Self {
            part: inputs.part,
            gloss,
            base_color,
            metallic,
            f0,
            f90,
            under,
            inv_entering_average: 1.0,
            entering: 1.0,
            bands: None,
            matte,
            rough,
            bounces: Bounces::new(alpha, wo.z, straight, f90, average, choices.compensation),
            film,
            layers: outside.then(|| Layers::new(p, wo, least)).flatten(),
            passing,
        };
        if dielectric > 0.0 {
            s.entering = s.entering_at(wo);
            let plain = s.film.is_none() && s.layers.is_none() && gloss.is_isotropic();
            let average = if plain {
                1.0 - (under[0] + (under[1] - under[0]) * gloss.average_weight())
            } else {
                let bands = s.entering_bands();
                s.bands = Some(bands);
                bands[0] / PI
            };
            s.inv_entering_average = 1.0 / average.max(1e-6);
        }
        s
    }

    /// Bands of cosine × what reaches the diffuse part, averaged over azimuths where these matter: a tilted coat has no symmetry, an
    /// anisotropic base repeats each quarter.
    fn entering_bands(&self) -> Bands {
        let tilted = self.layers.as_ref().and_then(|l| l.coat.as_ref()).is_some_and(|c| c.has_azimuths());
        let (count, range) = match (tilted, self.gloss.is_isotropic()) {
            (true, _) => (8, 1.0),
            (false, false) => (3, 0.25),
            (false, true) => (1, 0.0),
        };
        quadrature_bands(|cos| {
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let at = |i: u32| {
                let (y, x) = sin_cos_tau((i as f32 + 0.5) / count as f32 * range);
                self.entering_at(vec3a(sin * x, sin * y, cos))
            };
            (0..count).map(at).sum::<f32>() / count as f32
        })
    }

    /// Fresnel's term at a half angle's cosine and Schlick's weight of it, without energy compensation.
    #[inline(always)]
    pub fn fresnel(&self, cos: f32, w: f32) -> Spectrum {
        let plain = self.f0 + (Spectrum::splat(self.f90) - self.f0) * w;
        match &self.film {
            None => plain,
            Some(film) => film.over(plain, cos),
        }
    }

    /// The same with the factors of energy compensation on both of its ends.
    #[inline(always)]
    pub fn compensated(&self, cos: f32, w: f32) -> Spectrum {
        let [a, b] = self.bounces.scale;
        match &self.film {
            None => self.f0 * a * (1.0 - w) + b * (self.f90 * w),
            Some(_) => self.fresnel(cos, w) * a,
        }
    }

    /// What of the light from `w` (above) reaches the diffuse part, below base and layers.
    #[inline(always)]
    pub fn entering_at(&self, w: Vec3A) -> f32 {
        let under = match &self.film {
            None => self.under[0] + (self.under[1] - self.under[0]) * self.gloss.directional(w).w,
            Some(film) => {
                let rule = self.gloss.rule(w);
                rule.cos.iter().zip(rule.weight).map(|(c, weight)| film.under(*c) * weight).sum()
            }
        };
        (1.0 - under).max(0.0) * self.layers.as_ref().map_or(1.0, |l| l.at(w)[1])
    }

    /// What fuzz and a lacquer's colour leave of mirrored and of diffuse light from below, wherever it comes from.
    #[inline(always)]
    pub fn veil(&self) -> [Spectrum; 2] {
        self.layers.as_ref().map_or([Spectrum::ONE; 2], |l| l.tint.map(|t| t * l.over))
    }

    /// What the layers let through of light from the viewer.
    #[inline(always)]
    pub fn below_layers(&self) -> f32 {
        self.layers.as_ref().map_or(1.0, |l| l.through[1])
    }

    /// What the layers let through of specular light between `wo` and `wi` (above): the smaller of both.
    #[inline(always)]
    pub fn specular_below(&self, wi: Vec3A) -> f32 {
        self.layers.as_ref().map_or(1.0, |l| l.through[1].min(l.at(wi)[1]))
    }

    /// A and B of the lobe's reflectance, F0 · A + F90 · B.
    #[inline]
    pub fn dfg(&self, source: DfgSource) -> Dfg {
        let (r, cos) = (self.gloss.roughness, self.gloss.wo.z);
        match source {
            DfgSource::Table => table(&self.gloss),
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

/// A and B of a lobe by the table.
#[inline]
pub(crate) fn table(gloss: &Gloss) -> Dfg {
    let a = gloss.directional(gloss.wo);
    Dfg { scale: a.e * (1.0 - a.w), bias: a.e * a.w }
}
