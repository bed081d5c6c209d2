//! The closure: all layers at a point.

mod bsdf;
mod matte;
mod parts;
mod refraction;
mod scatter;
mod view;

use self::{
    matte::{Matte, mattes},
    refraction::Refraction,
};
use super::{
    OpenPbrParams,
    coat::Coat,
    facet::{Boundary, Facets, Mix},
    index::{self, anisotropic_alpha, unit},
    lobe::Lobe,
};
use crate::{bsdf::MIN_COS, fresnel::f0_from_ior, model::Incidence, sheen::Fuzz, varnish::Under};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The closure of an OpenPBR surface at a point; see the [module](super).
///
/// Not reciprocal. Its [`albedo`](crate::Bsdf::albedo) is the tables' for isotropic roughness, within 2e-3 of the
/// integral for cos θ ≥ 0.05 if the coat is clear and nothing enters a volume (1e-2 under a thin film), and an estimate
/// otherwise. Where α falls below [`crate::ggx::ALPHA_DELTA`] a lobe is perfectly specular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenPbr {
    fuzz: Option<FuzzLayer>,
    coat: Option<Coat>,
    base: Lobe,
    facets: Facets,
    mix: Mix,
    /// The metal's `specular_weight`.
    metal_weight: f32,
    /// The rough diffuse base, the subsurface, and what diffuses through a sheet.
    diffuse: [Option<Matte>; 3],
    beyond: Beyond,
    /// The part of the surface that looks from behind as it does from the front; the rest is the inside of the
    /// translucent base. 1 from the front.
    outer: f32,
    /// What light is multiplied by that passes into or out of the translucent base, without the coat.
    passage: Spectrum,
    emission: Spectrum,
}

/// Fibres on top of all.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FuzzLayer {
    lobe: Fuzz,
    weight: f32,
}

/// What lies behind the translucent part.
#[derive(Clone, Copy, Debug, PartialEq)]
// The closure is on the stack in any case.
#[allow(clippy::large_enum_variant)]
enum Beyond {
    /// There is none.
    Nothing,
    /// The other side of a sheet.
    Sheet(Lobe),
    /// A volume that light enters.
    Volume(Refraction),
    /// The volume that light comes from.
    Inside(Refraction),
}

/// What the coat's darkening must know of the base.
fn under_coat(p: &OpenPbrParams, facets: &Facets, mix: Mix) -> Under {
    let f0 = f0_from_ior(facets.eta());
    let subsurface = unit(p.subsurface_weight);
    let diffuse =
        (p.base_color.map(unit) * unit(p.base_weight)).lerp(p.subsurface_color.map(unit), subsurface);
    let substrate = diffuse.lerp(passage(p), unit(p.transmission_weight));
    let metal = facets.metal_f0() * unit(p.specular_weight);
    Under::new(f0, p.specular_color.map(unit), substrate, metal, mix.metal, unit(p.specular_roughness))
}

/// The colour of passing the surface of the translucent base, or the sheet that it is.
fn passage(p: &OpenPbrParams) -> Spectrum {
    let clear_surface = !p.geometry_thin_walled && p.transmission_depth > 0.0;
    if clear_surface { Spectrum::ONE } else { p.transmission_color.map(unit) }
}

impl OpenPbr {
    /// The closure for light that arrives as `at` says.
    pub fn new(p: &OpenPbrParams, at: &Incidence) -> Self {
        let thin = p.geometry_thin_walled;
        let mix = Mix::new(p);
        // Seen from within, the translucent part is another surface; the rest looks as it does from outside.
        let inside = !at.front && !thin && mix.clear > 0.0;
        let outer = if inside { 1.0 - mix.clear } else { 1.0 };
        let shown = if inside {
            let scale = if outer > 0.0 { 1.0 / outer } else { 0.0 };
            Mix { metal: mix.metal * scale, opaque: mix.opaque * scale, clear: 0.0 }
        } else {
            mix
        };

        let outside = index::index(at.exterior_ior);
        let coverage = unit(p.coat_weight);
        let roughness = index::roughened(unit(p.specular_roughness), unit(p.coat_roughness), coverage);
        let alpha = anisotropic_alpha(roughness, p.specular_roughness_anisotropy);
        let facets = Facets::new(p, outside, coverage, mix);
        let base = Lobe::new(alpha);

        let beyond = if mix.clear == 0.0 {
            Beyond::Nothing
        } else if thin {
            // Light is bent at both faces, each time by (η − 1) times the facet's tilt; reflection turns it by twice the
            // tilt.
            let narrower = (facets.eta().max(1.0 / facets.eta()) - 1.0) * core::f32::consts::FRAC_1_SQRT_2;
            Beyond::Sheet(Lobe::new(alpha.map(|a| (a * narrower).min(1.0))))
        } else {
            let ior = p.interior_ior(outside, at.lane);
            let eta = if inside { outside / ior } else { ior / outside };
            let lobe = Refraction::new(alpha, Boundary::new(facets, base, eta, !inside), at);
            if inside { Beyond::Inside(lobe) } else { Beyond::Volume(lobe) }
        };

        let fuzz_weight = unit(p.fuzz_weight);
        Self {
            fuzz: (fuzz_weight > 0.0)
                .then(|| FuzzLayer { lobe: Fuzz::new(p.fuzz_color, p.fuzz_roughness), weight: fuzz_weight }),
            coat: Coat::new(p, outside, under_coat(p, &facets, mix)),
            base,
            facets: facets.showing(shown),
            mix: shown,
            metal_weight: unit(p.specular_weight),
            diffuse: mattes(p, shown),
            beyond,
            outer,
            passage: if thin { Spectrum::ONE } else { passage(p) },
            emission: p.emission_color.map(|v| v.max(0.0).min(f32::MAX))
                * if inside { 0.0 } else { p.emission_luminance.max(0.0).min(1e30) },
        }
    }

    /// Luminance that the base sends towards `wo`, by lane, cd/m², as it leaves the fuzz (OpenPBR 1.1, "Reduction to a
    /// mixture of lobes": lerp(1, T, coat_weight) of what the base emits, here over the coat's path length towards `wo`,
    /// times what the fuzz lets through). Zero from inside a volume.
    #[inline]
    pub fn emission(&self, wo: Vec3A) -> Spectrum {
        if self.emission.is_black() { Spectrum::ZERO } else { self.emission * self.emission_tint(wo) }
    }

    /// The part of the base's emission towards `wo` that coat and fuzz let through; zero below the surface.
    #[inline]
    pub fn emission_tint(&self, wo: Vec3A) -> Spectrum {
        if !(wo.z > MIN_COS) {
            return Spectrum::ZERO;
        }
        let fuzz = self.fuzz.map_or(1.0, |f| 1.0 - f.weight * f.lobe.reflectance(wo.z));
        match &self.coat {
            None => Spectrum::splat(fuzz),
            Some(c) => {
                let crossed = c.transmittance(c.longer(c.local(wo).z));
                Spectrum::ONE.lerp(crossed, c.weight) * fuzz
            }
        }
    }
}
