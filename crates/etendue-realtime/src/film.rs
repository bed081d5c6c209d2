//! A thin film over the base: `KHR_materials_iridescence`.

use crate::surface::unit;
use etendue_bxdf::fresnel::schlick_weight;
use etendue_bxdf::thin_film::{FilmBase, Lanes, ThinFilm};
use etendue_bxdf::{GltfParams, Schlick};
use etendue_color::Spectrum;

/// The film with the two materials under it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Film {
    coverage: f32,
    film: ThinFilm,
    /// Dielectric and metal under the film.
    bases: [FilmBase; 2],
    /// F0 and F90 of the dielectric without the film.
    dielectric: (Spectrum, f32),
    metallic: f32,
}

impl Film {
    /// `None` where there is none; F0 of the dielectric and of the metal, each lane 0..1.
    #[inline]
    pub fn new(
        p: &GltfParams,
        dielectric_f0: Spectrum,
        dielectric_f90: f32,
        metal_f0: Spectrum,
    ) -> Option<Self> {
        let coverage = unit(p.iridescence);
        if !(coverage > 0.0) {
            return None;
        }
        let film = ThinFilm::new(p.iridescence_ior, p.iridescence_thickness, 1.0, Lanes::Rgb);
        let bases = [film.base(dielectric_f0), film.base(metal_f0)];
        let dielectric = (dielectric_f0, dielectric_f90);
        Some(Self { coverage, film, bases, dielectric, metallic: unit(p.metallic) })
    }

    /// Fresnel's term of the whole base, which is `plain` without the film.
    #[inline]
    pub fn over(&self, plain: Spectrum, cos: f32) -> Spectrum {
        let view = self.film.at(cos);
        let [dielectric, metal] = [0, 1].map(|i: usize| view.gltf(&self.bases[i]));
        plain.lerp(dielectric.lerp(metal, self.metallic), self.coverage)
    }

    /// The mean of [`Film::over`] over the hemisphere, weighted by the cosine: the four-point Gauss-Legendre rule.
    #[inline]
    pub fn average(&self, plain: &Schlick) -> Spectrum {
        const NODES: [[f32; 2]; 4] = [
            [0.069_431_84, 0.173_927_42],
            [0.330_009_48, 0.326_072_58],
            [0.669_990_52, 0.326_072_58],
            [0.930_568_16, 0.173_927_42],
        ];
        let mut sum = Spectrum::ZERO;
        for [cos, weight] in NODES {
            sum += self.over(plain.eval(cos), cos) * (2.0 * cos * weight);
        }
        sum.map(unit)
    }

    /// What the dielectric reflects at an angle, by its largest lane.
    #[inline]
    pub fn under(&self, cos: f32) -> f32 {
        let (f0, f90) = self.dielectric;
        let plain = f0 + (Spectrum::splat(f90) - f0) * schlick_weight(cos);
        plain.lerp(self.film.at(cos).gltf(&self.bases[0]), self.coverage).max_element()
    }
}
