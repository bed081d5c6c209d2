//! What one microfacet of the base does with light: metal, dielectric, film, refraction.

use crate::{
    dielectric::{Interface, MATCHED},
    fresnel::schlick_weight,
    thin_film::{FilmBase, Lanes, ThinFilm},
};
use etendue_color::Spectrum;

/// A thin film over both of the base's materials.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Film {
    coverage: f32,
    film: ThinFilm,
    dielectric: FilmBase,
    metal: FilmBase,
    /// The dielectric's largest lane, if its fringes are wide enough for a curve.
    under: Option<Curve>,
}

/// Intervals of [`Curve`].
const INTERVALS: usize = 16;

/// A reflectance over the cosine, from above: Schlick's curve and the difference to it, linear between even steps.
///
/// A quarter of the second difference's size is added at each node, twice the error of linear interpolation at such a
/// curvature: so that what is let in is never more than what is not reflected.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Curve {
    ends: [f32; 2],
    difference: [f32; INTERVALS + 1],
}

impl Curve {
    fn new(f: impl Fn(f32) -> f32) -> Self {
        let [f0, f90] = [f(1.0), f(0.0)];
        let raw: [f32; INTERVALS + 1] = core::array::from_fn(|i| {
            let cos = i as f32 / INTERVALS as f32;
            f(cos) - (f0 + (f90 - f0) * schlick_weight(cos))
        });
        let difference = core::array::from_fn(|i| {
            let at = i.clamp(1, INTERVALS - 1);
            raw[i] + 0.25 * (raw[at - 1] - 2.0 * raw[at] + raw[at + 1]).abs()
        });
        Self { ends: [f0, f90], difference }
    }

    #[inline(always)]
    fn at(&self, cos: f32) -> f32 {
        let x = cos * INTERVALS as f32;
        let i = (x as usize).min(INTERVALS - 1);
        let (a, b) = (self.difference[i], self.difference[i + 1]);
        let [f0, f90] = self.ends;
        let value = f0 + (f90 - f0) * schlick_weight(cos) + (a + (b - a) * (x - i as f32));
        value.max(0.0).min(1.0)
    }
}

/// A mix of a dielectric and a metal, each by Schlick's curve, under an optional film.
///
/// ```text
/// reflect  = mix(Fd, Fm, metallic),   transmit = 1 − max over lanes of Fd
/// Fd, Fm   = mix(F0 + (F90 − F0) (1 − cos)⁵, film's reflectance, coverage)
/// ```
///
/// The angle is that on the side of the smaller index; beyond the critical angle Fd is 1, also where `specular` lowers F90
/// (`KHR_materials_volume`, section "Interaction with other extensions").
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    /// Index of the far side over that of the near side; 1 where light is not bent.
    eta: f32,
    metallic: f32,
    dielectric_f0: Spectrum,
    dielectric_f90: f32,
    metal_f0: Spectrum,
    /// The mix's own F0 and F90.
    f0: Spectrum,
    f90: f32,
    /// The dielectric's largest F0.
    under_f0: f32,
    film: Option<Film>,
}

impl Facet {
    /// All inputs in range.
    #[inline(always)]
    pub fn new(dielectric_f0: Spectrum, dielectric_f90: f32, metal_f0: Spectrum, metallic: f32) -> Self {
        let dielectric = 1.0 - metallic;
        Self {
            eta: 1.0,
            metallic,
            dielectric_f0,
            dielectric_f90,
            metal_f0,
            f0: dielectric_f0 * dielectric + metal_f0 * metallic,
            f90: dielectric_f90 * dielectric + metallic,
            under_f0: dielectric_f0.max_element(),
            film: None,
        }
    }

    /// The same under a film of index `ior` and `thickness` nanometres that covers a part of the surface.
    #[inline]
    pub fn with_film(mut self, coverage: f32, ior: f32, thickness: f32, lanes: Lanes) -> Self {
        let film = ThinFilm::new(ior, thickness, 1.0, lanes);
        let (dielectric, metal) = (film.base(self.dielectric_f0), film.base(self.metal_f0));
        self.film = Some(Film { coverage, film, dielectric, metal, under: None });
        // The fringes of three colours are wide; those of one wavelength may be narrower than any step.
        let curve = (lanes == Lanes::Rgb && self.metallic < 1.0)
            .then(|| Curve::new(|cos| self.dielectric(cos).max_element()));
        if let Some(f) = &mut self.film {
            f.under = curve;
        }
        self
    }

    /// The same as the boundary to a medium of relative index `eta`.
    #[inline(always)]
    pub fn with_eta(mut self, eta: f32) -> Self {
        self.eta = if (eta - 1.0).abs() < MATCHED { 1.0 } else { eta };
        self
    }

    /// The same boundary for light that comes from the far side.
    #[inline(always)]
    pub fn reversed(mut self) -> Self {
        self.eta = 1.0 / self.eta;
        self
    }

    /// F0 and F90 of the mix, without the film.
    #[inline(always)]
    pub fn ends(&self) -> (Spectrum, f32) {
        (self.f0, self.f90)
    }

    /// What it reflects on average over the hemisphere, from the side of the smaller index: exact on Schlick's curve, under a
    /// film an estimate by the four-point Gauss-Legendre rule in the cosine.
    #[inline]
    pub fn average(&self) -> Spectrum {
        const NODES: [[f32; 2]; 4] = [
            [0.069_431_84, 0.173_927_42],
            [0.330_009_48, 0.326_072_58],
            [0.669_990_52, 0.326_072_58],
            [0.930_568_16, 0.173_927_42],
        ];
        if self.film.is_none() {
            return self.f0.lerp(Spectrum::splat(self.f90), 1.0 / 21.0);
        }
        let mut sum = Spectrum::ZERO;
        for [cos, weight] in NODES {
            sum += self.mixed(cos) * (2.0 * cos * weight);
        }
        sum.map(|v| v.max(0.0).min(1.0))
    }

    /// If the dielectric's largest lane is one curve of Schlick's: its F0 and F90.
    #[inline(always)]
    pub fn under_schlick(&self) -> Option<(f32, f32)> {
        (self.film.is_none() && self.eta >= 1.0).then_some((self.under_f0, self.dielectric_f90))
    }

    /// True if light that comes from the near side may be totally reflected.
    #[inline(always)]
    pub fn may_trap(&self) -> bool {
        self.eta < 1.0
    }

    /// Cosine on the side of the smaller index; `None` beyond the critical angle.
    #[inline(always)]
    fn outside(&self, cos: f32) -> Option<f32> {
        let c = cos.max(0.0).min(1.0);
        if self.eta >= 1.0 {
            return Some(c);
        }
        let cos2 = 1.0 - (1.0 - c) * (1.0 + c) / (self.eta * self.eta);
        (cos2 > 0.0).then(|| cos2.sqrt())
    }

    #[inline(always)]
    fn dielectric(&self, cos: f32) -> Spectrum {
        let w = schlick_weight(cos);
        let plain = self.dielectric_f0 + (Spectrum::splat(self.dielectric_f90) - self.dielectric_f0) * w;
        match &self.film {
            None => plain,
            Some(f) => plain.lerp(f.film.at(cos).gltf(&f.dielectric), f.coverage),
        }
    }

    /// The whole mix at an angle on the side of the smaller index.
    #[inline(always)]
    fn mixed(&self, cos: f32) -> Spectrum {
        let w = schlick_weight(cos);
        let plain = self.f0 + (Spectrum::splat(self.f90) - self.f0) * w;
        let Some(f) = &self.film else { return plain };
        let view = f.film.at(cos);
        let mut film = Spectrum::ZERO;
        if self.metallic < 1.0 {
            film += view.gltf(&f.dielectric) * (1.0 - self.metallic);
        }
        if self.metallic > 0.0 {
            film += view.gltf(&f.metal) * self.metallic;
        }
        plain.lerp(film, f.coverage)
    }

    /// [`Facet::under`] at an angle on the side of the smaller index.
    #[inline(always)]
    fn under_outside(&self, cos: f32) -> f32 {
        match &self.film {
            None => self.under_f0 + (self.dielectric_f90 - self.under_f0) * schlick_weight(cos),
            Some(Film { under: Some(curve), .. }) => curve.at(cos),
            _ => self.dielectric(cos).max_element(),
        }
    }

    /// The part that does not enter the dielectric, by its largest lane, 0..1.
    #[inline(always)]
    pub fn under(&self, cos: f32) -> f32 {
        self.outside(cos).map_or(1.0, |c| self.under_outside(c))
    }
}

impl Interface for Facet {
    #[inline(always)]
    fn eta(&self) -> f32 {
        self.eta
    }

    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        // Beyond the critical angle the metal's part is taken at the end of its curve too.
        self.outside(cos).map_or(Spectrum::ONE, |c| self.mixed(c))
    }

    #[inline(always)]
    fn reflect_between(&self, near: f32, far: f32) -> Spectrum {
        self.mixed(if self.eta >= 1.0 { near } else { far })
    }

    #[inline(always)]
    fn transmit_between(&self, near: f32, far: f32) -> Spectrum {
        let cos = if self.eta >= 1.0 { near } else { far };
        Spectrum::splat((1.0 - self.under_outside(cos)).max(0.0))
    }

    #[inline(always)]
    fn transmit(&self, cos: f32) -> Spectrum {
        Spectrum::splat((1.0 - self.under(cos)).max(0.0))
    }
}
