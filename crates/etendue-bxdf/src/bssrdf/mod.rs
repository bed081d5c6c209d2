//! Light that enters a surface at one point and leaves it at another: the separable BSSRDF with normalized diffusion.
//!
//! ```text
//! S(po, wo, pi, wi) = Sp(|po − pi|) · Sw(wi)
//! ```
//!
//! `po` is where a camera path meets the surface, `pi` where the light entered. Sp, per square metre, is the profile of
//! Christensen and Burley ([`profile`]); Sw, per steradian, the share of the light from `wi` that enters ([`EntryLobe`]).
//! On an infinite plane ∫ Sp dA is the surface's albedo and ∫ Sw cos θ dω is one, lane by lane, so the colour that a user
//! asks for is the colour that an evenly lit plane shows.
//!
//! How a path tracer uses it at a point `po`, with a frame whose +Z is the normal there:
//!
//! 1. [`Subsurface::sample_probe`] gives a segment in that frame. Intersect it with the same object, and find **all** hits.
//! 2. Pick one of the N hits, each with probability 1/N. (Or take all of them.)
//! 3. [`Subsurface::found`] gives the profile's value and the density of that hit, over all the ways by which a probe could
//!    have found it. The path goes on from there with its throughput multiplied by `N · value / pdf`.
//! 4. At the hit the path is scattered by [`EntryLobe`], an ordinary [`crate::Bsdf`], in the frame of the normal there.
//!
//! Lanes without a mean free path leave the surface where they entered it: a point's Lambert lobe of colour
//! [`Subsurface::local`], which the profile does not contain. That is the crude end of the scale, and the profile tends to it: an
//! even stripe pattern of light with wave number k is seen with its contrast multiplied by ¼(1 + (kd)²)^−½ + ¾(1 + 9(kd)²)^−½,
//! which is 1 for d → 0.

mod entry;
mod inversion;
mod probe;
pub mod profile;

pub use entry::EntryLobe;
pub use inversion::{single_scattering_albedo, surface_albedo};
pub use probe::{Found, Probe};

use crate::{
    MetalRough, MetalRoughParams, choices,
    model::{Incidence, ModelParams},
    parameters,
};
use etendue_color::Spectrum;

choices! {
    /// What a subsurface radius measures.
    pub enum Distance {
        /// The mean free path ℓ in the medium; the profile is the one of light that enters perpendicularly.
        MeanFreePath = "mean-free-path",
        /// The mean free path ℓ in the medium; the profile is the one of light that enters from everywhere.
        DiffuseEntry = "diffuse-entry",
        /// The diffuse mean free path ℓd on the surface.
        DiffuseMeanFreePath = "diffuse-mean-free-path",
        /// The profile's own length d (Burley 2015): independent of the albedo.
        Shape = "shape",
    }
}

parameters! {
    /// What a translucent surface is at a point.
    pub struct SubsurfaceParams {
        /// Diffuse reflectance of an evenly lit plane, each lane 0..1.
        color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// How far light travels under the surface, metres, by lane; what it measures is said by `distance`.
        radius: Spectrum = Spectrum::rgb(0.001, 0.001, 0.001), 0.0..1.0;
        /// What `radius` measures: mean-free-path, diffuse-entry, diffuse-mean-free-path or shape.
        distance: Distance = Distance::DiffuseEntry, 0.0..1.0;
        /// Index of refraction of the surface, 1..4: how much of the light from each angle enters.
        ior: f32 = 1.4, 1.0..4.0;
        /// Perceptual roughness of the surface, 0..1.
        roughness: f32 = 0.4, 0.0..1.0;
    }
}

impl SubsurfaceParams {
    /// The reflection at the surface alone: what does not enter.
    pub fn gloss(&self) -> MetalRough {
        MetalRough::new(&MetalRoughParams { base_color: Spectrum::ZERO, ..self.metal_rough() })
    }

    /// What a path looks for under the surface.
    pub fn entry(&self) -> EntryLobe {
        EntryLobe::new(self.ior)
    }

    fn metal_rough(&self) -> MetalRoughParams {
        MetalRoughParams {
            base_color: self.color,
            roughness: self.roughness,
            ior: self.ior.max(1.0).min(4.0),
            ..MetalRoughParams::default()
        }
    }
}

impl ModelParams for SubsurfaceParams {
    type Closure = MetalRough;
    const ABOUT: &'static str = "a translucent surface by normalized diffusion (Christensen, Burley 2015); its closure is the \
        crude end of the scale, light that leaves where it entered; a path tracer moves the diffuse part by the profile";

    #[inline]
    fn closure(&self, _at: &Incidence) -> MetalRough {
        MetalRough::new(&self.metal_rough())
    }

    fn subsurface(&self) -> Option<SubsurfaceParams> {
        Some(*self)
    }
}

impl SubsurfaceParams {
    /// The lobe by which light enters the surface where a probe found it.
    pub fn entry_lobe(&self) -> EntryLobe {
        EntryLobe::new(self.ior)
    }
}

/// Shapes d below this, in metres, are taken as zero: such light leaves where it entered.
pub const MIN_SHAPE: f32 = 1e-7;
/// Shapes above this, in metres, are cut to it: with it no product leaves `f32`.
pub const MAX_SHAPE: f32 = 1e7;

/// The spatial part Sp of a separable BSSRDF at a point: one profile per lane.
///
/// ```
/// use etendue_bxdf::bssrdf::{Subsurface, SubsurfaceParams};
/// use etendue_color::Spectrum;
/// use glam::Vec3A;
///
/// let skin = Subsurface::new(&SubsurfaceParams {
///     color: Spectrum::rgb(0.85, 0.55, 0.3),
///     radius: Spectrum::rgb(0.004, 0.0013, 0.0006),
///     ..Default::default()
/// });
/// // A probe along the normal meets the plane of the surface half way.
/// let probe = skin.sample_probe(0.1, [0.5, 0.25]).expect("light travels in each lane");
/// let hit = probe.origin + probe.direction * (0.5 * probe.length);
/// let found = skin.found(hit, Vec3A::Z);
/// // What the path's throughput is multiplied by.
/// assert!((found.value / found.pdf).is_finite() && found.pdf > 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subsurface {
    /// Albedo of the lanes that travel.
    albedo: Spectrum,
    /// Albedo of the lanes that do not.
    local: Spectrum,
    /// d, metres; one where a lane does not travel.
    shape: Spectrum,
    /// With which probability a lane's radius is drawn; all zero if nothing travels.
    probability: Spectrum,
    /// Largest radius at which anything is found, metres.
    reach: f32,
}

impl Subsurface {
    /// The profile of a surface.
    ///
    /// Lanes of `color` are clamped to 0..1, of `radius` to 0 and above; NaN counts as zero.
    pub fn new(p: &SubsurfaceParams) -> Self {
        let color = p.color.map(|a| a.max(0.0).min(1.0));
        let shape = Spectrum(core::array::from_fn(|i| shape_of(color[i], p.radius[i], p.distance)));
        Self::from_shape(color, shape)
    }

    /// From the albedo and the profile's length d, metres, by lane.
    pub fn from_shape(albedo: Spectrum, shape: Spectrum) -> Self {
        let mut out = Self {
            albedo: Spectrum::ZERO,
            local: Spectrum::ZERO,
            shape: Spectrum::ONE,
            probability: Spectrum::ZERO,
            reach: 0.0,
        };
        let mut sum = 0.0;
        for lane in 0..4 {
            let a = albedo[lane].max(0.0).min(1.0);
            // A NaN counts as zero.
            let d = shape[lane].max(0.0).min(MAX_SHAPE);
            if d < MIN_SHAPE {
                out.local[lane] = a;
            } else if a > 0.0 {
                out.albedo[lane] = a;
                out.shape[lane] = d;
                out.reach = out.reach.max(d * profile::CUT);
                sum += a;
            }
        }
        if sum > 0.0 {
            out.probability = out.albedo / sum;
        }
        out
    }

    /// Albedo of the lanes whose light travels: ∫ Sp dA over an infinite plane.
    pub fn albedo(&self) -> Spectrum {
        self.albedo
    }

    /// Albedo of the lanes whose light does not travel: the colour of a Lambert lobe to put beside the profile.
    pub fn local(&self) -> Spectrum {
        self.local
    }

    /// The profiles' length d, metres, by lane; one for lanes that do not travel.
    pub fn shape(&self) -> Spectrum {
        self.shape
    }

    /// No light is found farther than this from where it leaves, metres; zero if none travels.
    pub fn reach(&self) -> f32 {
        self.reach
    }
}

/// d of one lane from what the user measured.
fn shape_of(albedo: f32, radius: f32, distance: Distance) -> f32 {
    let s = match distance {
        Distance::MeanFreePath => profile::scaling_searchlight(albedo),
        Distance::DiffuseEntry => profile::scaling_diffuse(albedo),
        Distance::DiffuseMeanFreePath => profile::scaling_diffuse_mean_free_path(albedo),
        Distance::Shape => 1.0,
    };
    radius.max(0.0) / s
}
