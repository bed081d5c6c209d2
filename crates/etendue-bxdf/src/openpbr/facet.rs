//! What one microfacet of the base does: metal, opaque dielectric and translucent dielectric side by side, each with or
//! without a film.

use super::{
    OpenPbrParams, index,
    index::unit,
    lobe::{Lobe, Seen},
};
use crate::{
    conductor::k_from_f0,
    dielectric::{Interface, MATCHED, Sheet},
    f82::F82Tint,
    fresnel::{Schlick, dielectric},
    math,
    thin_film::{FilmView, Lanes, ThinFilm},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The reflectances of the three kinds of facet, lanes 0..1, without tints and weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub metal: Spectrum,
    pub opaque: Spectrum,
    /// Of the translucent part: one boundary, or both faces of a sheet.
    pub clear: Spectrum,
    /// The same with `specular_color`, which tints the first reflection alone.
    pub tinted: Spectrum,
    /// What passes through a sheet.
    pub passed: Spectrum,
}

/// A film between the base and what lies above it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Film {
    weight: f32,
    film: ThinFilm,
    /// Index of the surroundings over that of what lies directly above the film, squared: light is bent on its way to a film
    /// under a coat.
    bend2: f32,
    /// Index of the dielectric.
    base: f32,
    /// The metal's index, and its tint at grazing angles as the ratio of F82-tint and Schlick's curve.
    metal_n: Spectrum,
    metal_k: Spectrum,
    schlick: Schlick,
}

/// The base's Fresnel terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facets {
    metal: F82Tint,
    /// `specular_color` of the dielectric.
    tint: Spectrum,
    /// Relative index as the coat leaves it and `specular_weight` changes it.
    eta: f32,
    /// The same for an opaque base, which never reflects totally: ≥ 1.
    opaque_eta: f32,
    film: Option<Film>,
    sheet: Option<Crossing>,
    has: Has,
}

/// Which kinds of facet there are at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Has {
    metal: bool,
    opaque: bool,
    clear: bool,
}

/// The absorption within a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crossing {
    /// ln of the part that survives a crossing straight through; `None` if all does.
    log: Option<Spectrum>,
    inv_eta2: f32,
}

/// A face of a sheet at one angle, where its reflectance is known.
#[derive(Clone, Copy)]
struct Known(Spectrum);

impl Interface for Known {
    #[inline(always)]
    fn eta(&self) -> f32 {
        1.0
    }
    #[inline(always)]
    fn reflect(&self, _cos: f32) -> Spectrum {
        self.0
    }
}

/// The weights of the three kinds of facet, which sum to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mix {
    pub metal: f32,
    pub opaque: f32,
    pub clear: f32,
}

impl Mix {
    #[inline(always)]
    pub fn new(p: &OpenPbrParams) -> Self {
        let metal = unit(p.base_metalness);
        let clear = (1.0 - metal) * unit(p.transmission_weight);
        Self { metal, opaque: 1.0 - metal - clear, clear }
    }
}

/// Reflectance of a boundary, without the noise of the formula where the indices match.
#[inline(always)]
pub(super) fn boundary(cos: f32, eta: f32) -> f32 {
    if (eta - 1.0).abs() < MATCHED { 0.0 } else { dielectric(cos, eta) }
}

impl Facets {
    /// For surroundings of index `outside`, of which the part `coat` is covered by the coat.
    #[inline]
    pub fn new(p: &OpenPbrParams, outside: f32, coat: f32, mix: Mix) -> Self {
        let base = index::index(p.specular_ior);
        let coat_ior = index::index(p.coat_ior);
        let above = outside + (coat_ior - outside) * coat;
        let eta =
            index::modulated_index(index::relative_index(base, coat_ior, outside, coat), p.specular_weight);
        let f0 = p.base_color.map(unit) * unit(p.base_weight);
        let metal = F82Tint::from_tint(f0, p.specular_color);
        let weight = unit(p.thin_film_weight);
        let film = (weight > 0.0).then(|| {
            let n = f0.map(|f| (1.0 - f) / (1.0 + f));
            Film {
                weight,
                film: ThinFilm::new(p.thin_film_ior, p.thin_film_thickness * 1000.0, above, Lanes::Rgb),
                bend2: (outside / above) * (outside / above),
                base: eta * above,
                metal_n: n * above,
                metal_k: Spectrum(core::array::from_fn(|i| k_from_f0(n[i], f0[i]))) * above,
                schlick: Schlick { f0, f90: Spectrum::ONE },
            }
        });
        let sheet = p.geometry_thin_walled.then(|| {
            let color = p.transmission_color.map(unit);
            Crossing {
                log: (color != Spectrum::ONE).then(|| color.map(|c| math::ln(c.max(1e-6)))),
                inv_eta2: eta.min(1.0 / eta).powi(2),
            }
        });
        Self {
            metal,
            tint: p.specular_color.map(unit),
            eta,
            opaque_eta: eta.max(1.0 / eta),
            film,
            sheet,
            has: Has { metal: mix.metal > 0.0, opaque: mix.opaque > 0.0, clear: mix.clear > 0.0 },
        }
    }

    /// The same, evaluated only for the kinds that `mix` has.
    #[inline(always)]
    pub fn showing(mut self, mix: Mix) -> Self {
        self.has = Has { metal: mix.metal > 0.0, opaque: mix.opaque > 0.0, clear: mix.clear > 0.0 };
        self
    }

    /// All kinds at an angle of cosine `cos`; those that are not there are black.
    #[inline(always)]
    pub fn at(&self, cos: f32) -> Facet {
        let black = Spectrum::ZERO;
        let film = self.film.as_ref().map(|f| (f, f.at(cos)));
        let metal = if self.has.metal { self.metal(cos, &film) } else { black };
        let opaque = if self.has.opaque { self.boundary(cos, self.opaque_eta, &film) } else { black };
        let (clear, tinted, passed) = match (self.has.clear, &self.sheet) {
            (false, _) => (black, black, black),
            (true, None) => {
                let r = if self.has.opaque && self.eta >= 1.0 {
                    opaque
                } else {
                    self.boundary(cos, self.eta, &film)
                };
                (r, r * self.tint, black)
            }
            (true, Some(crossing)) => {
                let r = if self.has.opaque { opaque } else { self.boundary(cos, self.opaque_eta, &film) };
                let sheet = Sheet::new(Known(r), crossing.survives(cos));
                let both = sheet.reflect(cos);
                (both, r * self.tint + (both - r).max(black), sheet.transmit(cos))
            }
        };
        Facet { metal, opaque, clear, tinted, passed }
    }

    /// `specular_color` of the dielectric.
    #[inline(always)]
    pub fn tint(&self) -> Spectrum {
        self.tint
    }

    /// One face of the translucent part, seen from above.
    #[inline(always)]
    pub fn transparent(&self, cos: f32) -> Spectrum {
        self.boundary(cos, self.eta, &self.film.as_ref().map(|f| (f, f.at(cos))))
    }

    /// The relative index of the dielectric under the coat.
    #[inline(always)]
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// Reflectance of the metal at normal incidence.
    #[inline(always)]
    pub fn metal_f0(&self) -> Spectrum {
        self.metal.f0()
    }

    #[inline(always)]
    fn boundary(&self, cos: f32, eta: f32, film: &Option<(&Film, FilmView)>) -> Spectrum {
        let bare = Spectrum::splat(boundary(cos, eta));
        match film {
            None => bare,
            Some((f, view)) => bare.lerp(f.dielectric(view), f.weight),
        }
    }

    #[inline(always)]
    fn metal(&self, cos: f32, film: &Option<(&Film, FilmView)>) -> Spectrum {
        let bare = self.metal.eval(cos);
        match film {
            None => bare,
            Some((f, view)) => bare.lerp(f.metal(cos, view, bare), f.weight),
        }
    }
}

impl Film {
    /// The film under light that meets the surface at an angle of cosine `cos`, bent by what lies above the film.
    #[inline]
    fn at(&self, cos: f32) -> FilmView {
        let cos =
            if self.bend2 == 1.0 { cos } else { (1.0 - (1.0 - cos * cos) * self.bend2).max(0.0).sqrt() };
        self.film.at(cos)
    }

    #[inline]
    fn dielectric(&self, view: &FilmView) -> Spectrum {
        view.exact(Spectrum::splat(self.base), Spectrum::ZERO)
    }

    /// The metal of index n + ik whose F0 is the base colour, n as small as that allows (Gulbrandsen 2014, "Artist Friendly
    /// Metallic Fresnel", with an edge tint of one), darkened near grazing angles as the F82-tint curve `bare` is darker
    /// than Schlick's.
    #[inline]
    fn metal(&self, cos: f32, view: &FilmView, bare: Spectrum) -> Spectrum {
        let film = view.exact(self.metal_n, self.metal_k);
        let schlick = self.schlick.eval(cos);
        let ratio =
            Spectrum(core::array::from_fn(
                |i| if schlick[i] > 0.0 { unit(bare[i] / schlick[i]) } else { 1.0 },
            ));
        film * ratio
    }
}

impl Crossing {
    /// The part of the light that survives a crossing, entered at an angle of cosine `cos`.
    #[inline(always)]
    fn survives(&self, cos: f32) -> Spectrum {
        match self.log {
            None => Spectrum::ONE,
            Some(log) => {
                let inside2 = (1.0 - (1.0 - cos * cos).max(0.0) * self.inv_eta2).max(1e-6);
                let longer = 1.0 / inside2.sqrt();
                log.map(|l| math::exp(l * longer))
            }
        }
    }
}

/// The boundary of a translucent base, for what passes it: from outside the transmission alone (reflection belongs to the
/// lobe that all facets share), from inside both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Boundary {
    facets: Facets,
    /// The lobe of its facets, for their mean.
    lobe: Lobe,
    /// Index of the far side over that of the near side, without the coat: layers with parallel faces do not change where
    /// light goes behind them.
    eta: f32,
    front: bool,
}

impl Boundary {
    #[inline(always)]
    pub fn new(facets: Facets, lobe: Lobe, eta: f32, front: bool) -> Self {
        // The interfaces' own range.
        Self {
            facets,
            lobe,
            eta: if (eta - 1.0).abs() < MATCHED { 1.0 } else { eta.max(0.1).min(10.0) },
            front,
        }
    }

    /// Reflectance at an angle on the near side; 1 where light cannot be refracted, whatever coat or film say.
    #[inline(always)]
    pub fn whole(&self, cos: f32) -> Spectrum {
        let refracted = 1.0 - (1.0 - cos) * (1.0 + cos) / (self.eta * self.eta);
        if refracted > 0.0 { self.both(cos) } else { Spectrum::ONE }
    }

    /// The mean reflectance of the facets seen from `wo`.
    #[inline]
    fn mean(&self, seen: &Seen) -> Spectrum {
        let [mean] = seen.mean(|cos| [self.both(cos)]);
        mean
    }

    /// Reflectance at an angle on the near side.
    #[inline(always)]
    fn both(&self, cos: f32) -> Spectrum {
        if self.front {
            return self.facets.transparent(cos);
        }
        // The same facet from outside: reciprocal.
        let cos2 = 1.0 - (1.0 - cos) * (1.0 + cos) / (self.eta * self.eta);
        if cos2 > 0.0 { self.facets.transparent(cos2.sqrt().min(1.0)) } else { Spectrum::ONE }
    }
}

impl Interface for Boundary {
    #[inline(always)]
    fn eta(&self) -> f32 {
        self.eta
    }
    #[inline(always)]
    fn reflect(&self, cos: f32) -> Spectrum {
        if self.front { Spectrum::ZERO } else { self.both(cos) }
    }
    #[inline(always)]
    fn transmit(&self, cos: f32) -> Spectrum {
        Spectrum::ONE - self.both(cos)
    }
    /// Asked for where both sides have the same index, and a film or a coat reflects.
    #[inline(always)]
    fn reflect_mean(&self, wo: Vec3A, _w: f32) -> Spectrum {
        if self.front { Spectrum::ZERO } else { self.mean(&self.lobe.seen(wo)) }
    }
    #[inline(always)]
    fn transmit_mean(&self, wo: Vec3A, _w: f32) -> Spectrum {
        let seen = self.lobe.seen(wo);
        // From inside what the facets mask of their reflection passes; the slack is the table's.
        let [taken, slack] = if self.front { [1.0, 0.0] } else { [seen.e, seen.slack] };
        (Spectrum::splat(1.0 - slack) - self.mean(&seen) * taken).max(Spectrum::ZERO)
    }
    /// Both sides of the boundary ask at the outer angle, which they agree on.
    #[inline(always)]
    fn reflect_between(&self, _near: f32, far: f32) -> Spectrum {
        if self.front { Spectrum::ZERO } else { self.facets.transparent(far) }
    }
    #[inline(always)]
    fn transmit_between(&self, near: f32, far: f32) -> Spectrum {
        Spectrum::ONE - self.facets.transparent(if self.front { near } else { far })
    }
}
