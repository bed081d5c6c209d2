//! The glTF 2.0 surface with the material extensions of Khronos.
//!
//! From the top, with the extensions' names:
//!
//! ```text
//! fuzz                         fibres as a volume (Zeltner, Burley, Chiang 2022)
//! clearcoat or coat            GGX, own index (1.5), normal, roughness and anisotropy; may absorb and darken
//! sheen                        fibres (Estevez, Kulla 2017)
//! base = mix(dielectric, metal, metallic)
//!   F        Schlick, F0 from ior, specular, specular_color; under a film where iridescence covers it
//!   S        GGX, α = roughness², along x mix(α, 1, anisotropy_strength²)
//!   metal    = F · S
//!   dielectric = F · S + (1 − max F) · mix(diffuse, through, transmission)
//!   through  = base_color · the sheet's or volume's transmission with S's microfacets; of a sheet that scatters
//!              mix(that, multiscatter_color / π with (1 + scatter_anisotropy) / 2 of it on the far side, scatter_strength)
//!   diffuse  = mix(base_color / π, diffuse_transmission_color / π on the far side, diffuse_transmission);
//!              with diffuse_roughness EON's lobe in place of 1 / π
//! ```
//!
//! Surfaces without extensions are [`MetalRough`] itself, to the bit.
//!
//! # Layers
//! Each layer takes what its microfacets do not let in and leaves the rest: T(w) = 1 − mean F for the coat, 1 − max colour · E for
//! the sheen ([`crate::sheen::SheenRow`]). The extensions multiply what lies below by T(wo) alone, which is not reciprocal. Here
//!
//! - specular light from below is multiplied by min(T(wo), T(wi)), the rule that `KHR_materials_sheen` gives: reciprocal and
//!   never more than T(wo);
//! - diffuse light by T(wo) T(wi) / ∫ T cos/π: reciprocal and exactly T(wo) of its albedo, T being the product over all layers
//!   above it, the base's own (1 − mean F) included, as in [`crate::metal_rough`]. Of rough diffuse light the mean is weighted by
//!   the lobe for light from straight up, of which T lets most through; from elsewhere the lobe then returns up to 2 % less than
//!   T(wo) of its albedo.
//!
//! The fuzz leaves 1 − weight · R(wo) to all that lies below it, by the viewer's direction alone: its lobe is not reciprocal either.
//!
//! A clear coat without `coat_darkening` is `KHR_materials_clearcoat`: no light goes to and fro between it and the base, and a coated
//! surface keeps its colour. `KHR_materials_coat` adds absorption and darkening, as OpenPBR has them ([`crate::varnish`]): what lies
//! below is multiplied by mix(1, coat_color^½(1/µo + 1/µi), clearcoat), µ being the cosines within the coat, and by a factor for the
//! light to and fro that depends on the base's albedo and on the viewer's direction.
//!
//! # Further bounces
//! Light that is reflected by several microfacets comes back by a wide lobe, as in [`crate::metal_rough`]
//! ([`Compensation`](crate::multiscatter::Compensation)). Light that passes a rough sheet or boundary gets none.
//!
//! # Volumes
//! `thickness` > 0 with `transmission` > 0 is the boundary of a volume: microfacets refract ([`crate::dielectric::GgxDielectric`]), total
//! reflection is complete, coat and sheen lie outside. Without `transmission`, light that is diffusely transmitted enters the
//! volume without refraction, and the boundary reflects alike from both sides. Where a boundary both refracts and scatters
//! diffusely (`transmission` between 0 and 1), diffuse light is multiplied by min(T(wo), T(wi)) too: total reflection makes T a
//! step.
//!
//! With `scatter_strength` above 0 what is attenuated is not all absorbed: `KHR_materials_scatter`. `multiscatter_color` times it is
//! the colour of a deep body after many events; the single-scattering albedo is Kulla and Conty's inverse of it
//! ([`crate::openpbr::single_scattering_albedo`]), for the anisotropy that the medium has. Who follows the light finds both in
//! [`Interior::scatter`].
//!
//! A sheet that scatters adds to the diffuse part. With `diffuse_roughness` what it scatters has the rough lobe, too; the draft
//! leaves that open.
//!
//! # The index by lane
//! `KHR_materials_dispersion` gives red, green, blue the indices ior ∓ (ior − 1) · 0.025 · dispersion; for wavelengths the same
//! extension's form of Cauchy's equation holds. A path that carries one lane ([`Incidence::lane`]) gets that lane's.

mod body;
mod coat;
mod extended;
mod facet;
mod fibres;
mod lobes;
mod matte;
mod params;
mod shape;

pub use coat::{Tint, coat_f0, under_coat};
pub use params::GltfParams;

use crate::{
    bsdf::{Bsdf, BsdfSample, DeltaPart, Eval},
    dielectric::absorption::coefficient,
    metal_rough::MetalRough,
    model::{Claim, Claims, Incidence, Interior, ModelParams, Scatter},
    openpbr::single_scattering_albedo,
    thin_film::Lanes,
};
use etendue_color::Spectrum;
use extended::Extended;
use glam::Vec3A;

/// The index that stands for the infinite one.
const LARGEST_IOR: f32 = 1e3;

/// The closure of a glTF surface at a point: small, `Copy`, made anew at each hit.
///
/// Reciprocal where the model claims it (see [`GltfParams`]'s claims); never gives more light than it gets. Its [`Bsdf::albedo`] is
/// an estimate, for plain surfaces the table's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gltf(Form);

#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)]
enum Form {
    Plain(MetalRough),
    Extended(Extended),
}

impl Gltf {
    /// The closure for light that arrives as `at` says; `lanes` says what the four lanes are, for films and dispersion.
    #[inline]
    pub fn new(p: &GltfParams, at: &Incidence, lanes: Lanes) -> Self {
        Self(if p.has_extensions() {
            Form::Extended(Extended::new(p, at, lanes))
        } else {
            Form::Plain(MetalRough::new(&p.metal_rough()))
        })
    }
}

/// The index of refraction inside, for the lane that the path carries: 1..[`LARGEST_IOR`].
#[inline]
fn ior_in_lane(p: &GltfParams, lane: Option<u8>, lanes: Lanes) -> f32 {
    if p.ior == 0.0 {
        return LARGEST_IOR;
    }
    let ior = if p.ior >= 0.0 { p.ior.max(1.0).min(LARGEST_IOR) } else { 1.5 };
    let Some(lane) = lane.filter(|_| p.dispersion > 0.0) else { return ior };
    let strength = p.dispersion.min(1e3);
    let shift = match lanes {
        Lanes::Rgb => match lane {
            0 => -0.025,
            2 => 0.025,
            _ => 0.0,
        },
        // (n − 1) / V · (523655 / λ² − 1.5168), V = 20 / dispersion.
        Lanes::Wavelengths(nm) => {
            let l = nm[(lane as usize).min(3)].max(100.0).min(1e5);
            (523_655.0 / (l * l) - 1.5168) / 20.0
        }
    };
    (ior + (ior - 1.0) * strength * shift).max(1.0).min(LARGEST_IOR)
}

impl GltfParams {
    /// How what attenuates light in the volume scatters it, if it does.
    pub fn scatter(&self) -> Option<Scatter> {
        let strength = self.scatter_strength.max(0.0).min(1.0);
        let color = self.multiscatter_color.map(|c| c.max(0.0).min(1.0) * strength);
        // At ±1 there is no density.
        let g = self.scatter_anisotropy.max(-0.999).min(0.999);
        (color.max_element() > 0.0)
            .then(|| Scatter { albedo: color.map(|c| single_scattering_albedo(c, g)), anisotropy: g })
    }
}

impl ModelParams for GltfParams {
    type Closure = Gltf;
    const ABOUT: &'static str = "glTF 2.0's surface with the KHR_materials extensions: clearcoat, coat, sheen, fuzz, \
         transmission, volume, scatter, ior, specular, iridescence, anisotropy, dispersion, diffuse_transmission, diffuse_roughness";
    const CLAIMS: Claims = Claims {
        reciprocal: Claim::Breaks(
            "a coat with a normal of its own meets light by its own cosine, its darkening and the fuzz follow the viewer, and \
             diffuse light through a boundary that also refracts is not scaled by the squared index; all else is reciprocal",
        ),
        conserves: Claim::Holds,
    };

    #[inline]
    fn closure(&self, at: &Incidence) -> Gltf {
        Gltf::new(self, at, Lanes::Rgb)
    }

    fn interior(&self) -> Option<Interior> {
        let dielectric = 1.0 - self.metallic.max(0.0).min(1.0);
        let refracts = self.transmission > 0.0;
        if !(self.thickness > 0.0 && dielectric > 0.0 && (refracts || self.diffuse_transmission > 0.0)) {
            return None;
        }
        let absorption = coefficient(self.attenuation_color, self.attenuation_distance);
        Some(Interior {
            ior: if refracts { ior_in_lane(self, None, Lanes::Rgb) } else { 1.0 },
            absorption,
            scatter: self.scatter().filter(|_| !absorption.is_black()),
            priority: 0,
            dispersive: refracts && self.dispersion > 0.0 && self.ior != 0.0,
        })
    }
}

impl Bsdf for Gltf {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        match &self.0 {
            Form::Plain(c) => c.eval_pdf(wo, wi),
            Form::Extended(c) => c.eval_pdf(wo, wi),
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        match &self.0 {
            Form::Plain(c) => c.sample(wo, uc, u),
            Form::Extended(c) => c.sample(wo, uc, u),
        }
    }

    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        match &self.0 {
            Form::Plain(c) => c.albedo(wo),
            Form::Extended(c) => c.albedo(wo),
        }
    }

    #[inline]
    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        match &self.0 {
            Form::Plain(c) => c.deltas(wo),
            Form::Extended(c) => c.deltas(wo),
        }
    }

    fn narrowest_alpha(&self) -> [f32; 2] {
        match &self.0 {
            Form::Plain(c) => c.narrowest_alpha(),
            Form::Extended(c) => c.narrowest_alpha(),
        }
    }

    fn refraction(&self) -> Option<f32> {
        match &self.0 {
            Form::Plain(_) => None,
            Form::Extended(c) => c.refraction(),
        }
    }
}
