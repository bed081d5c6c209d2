//! What an OpenPBR surface is at a point.

use crate::parameters;
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What an OpenPBR 1.1 surface is at a point, after its textures; by default a grey, half glossy dielectric.
    ///
    /// Names, defaults and ranges are the specification's; lengths are metres unless they say otherwise. Out of range is
    /// clamped, NaN counts as the lower end. Opacity, the base's normal and the tangents are the caller's: the local frame
    /// has the base's normal along +Z and its tangent along +X.
    pub struct OpenPbrParams {
        /// Factor of the base colour of the metal and of the diffuse part.
        base_weight: f32 = 1.0, 0.0..1.0;
        /// Reflectance of the diffuse part, F0 of the metal.
        base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// Roughness of the diffuse part (and of a thin sheet's subsurface): 0 is Lambert's.
        base_diffuse_roughness: f32 = 0.0, 0.0..1.0;
        /// 0 dielectric .. 1 metal.
        base_metalness: f32 = 0.0, 0.0..1.0;
        /// Factor of the dielectric's reflectance at normal incidence (by way of its index; may exceed 1), and of the
        /// metal's reflectance (as far as 1).
        specular_weight: f32 = 1.0, 0.0..1.0;
        /// Tint of the dielectric's reflection, and of the metal's near grazing angles.
        specular_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Perceptual roughness of the base's microfacets; α = roughness².
        specular_roughness: f32 = 0.3, 0.0..1.0;
        /// How much longer highlights are along local x.
        specular_roughness_anisotropy: f32 = 0.0, 0.0..1.0;
        /// Index of refraction of the dielectric.
        specular_ior: f32 = 1.5, 1.0..3.0;
        /// 0 opaque .. 1 translucent dielectric.
        transmission_weight: f32 = 0.0, 0.0..1.0;
        /// What white light becomes at `transmission_depth`; if that is zero, the tint of each passage through the surface.
        transmission_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Distance in the volume at which light has become `transmission_color`, metres; zero for a clear volume.
        transmission_depth: f32 = 0.0, 0.0..1.0;
        /// Scattering coefficient of the volume, per `transmission_depth`.
        transmission_scatter: Spectrum = Spectrum::ZERO, 0.0..1.0;
        /// Mean cosine of the scattering in the volume.
        transmission_scatter_anisotropy: f32 = 0.0, -1.0..1.0;
        /// Strength of the dispersion: the Abbe number is `transmission_dispersion_abbe_number` over this.
        transmission_dispersion_scale: f32 = 0.0, 0.0..1.0;
        /// Abbe number at full `transmission_dispersion_scale`.
        transmission_dispersion_abbe_number: f32 = 20.0, 9.0..91.0;
        /// 0 diffuse .. 1 subsurface.
        subsurface_weight: f32 = 0.0, 0.0..1.0;
        /// The part of the light that enters the subsurface and comes out again.
        subsurface_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
        /// Mean free path in the subsurface, metres.
        subsurface_radius: f32 = 1.0, 0.0..1.0;
        /// Factor of `subsurface_radius` by lane.
        subsurface_radius_scale: Spectrum = Spectrum::rgb(1.0, 0.5, 0.25), 0.0..1.0;
        /// Mean cosine of the scattering in the subsurface; in a thin sheet, what part of the light comes out behind:
        /// (1 + this) / 2.
        subsurface_scatter_anisotropy: f32 = 0.0, -1.0..1.0;
        /// Coverage by a coat of varnish.
        coat_weight: f32 = 0.0, 0.0..1.0;
        /// What is left of white light that goes through the coat to the base and back, at normal incidence.
        coat_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Perceptual roughness of the coat; also roughens the base's reflections.
        coat_roughness: f32 = 0.0, 0.0..1.0;
        /// How much longer the coat's highlights are along the x of its own frame.
        coat_roughness_anisotropy: f32 = 0.0, 0.0..1.0;
        /// Index of refraction of the coat.
        coat_ior: f32 = 1.6, 1.0..3.0;
        /// 1: light that goes to and fro between coat and base darkens the base; 0: the base is lightened to undo that.
        coat_darkening: f32 = 1.0, 0.0..1.0;
        /// Coverage by fuzz: fibres or dust.
        fuzz_weight: f32 = 0.0, 0.0..1.0;
        /// Tint of the light that the fuzz reflects.
        fuzz_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Roughness of the fuzz: 0 upright fibres .. 1 dust.
        fuzz_roughness: f32 = 0.5, 0.0..1.0;
        /// Luminance of the base's emission for a white `emission_color`, cd/m².
        emission_luminance: f32 = 0.0, 0.0..1000.0;
        /// Factor of the emission; lanes ≥ 0, may exceed 1.
        emission_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Coverage of the base by a thin film.
        thin_film_weight: f32 = 0.0, 0.0..1.0;
        /// Thickness of the film, micrometres.
        thin_film_thickness: f32 = 0.5, 0.0..1.0;
        /// Index of refraction of the film.
        thin_film_ior: f32 = 1.4, 1.0..3.0;
        /// True if the surface is a sheet without an inside.
        geometry_thin_walled: bool = false, 0.0..1.0;
        /// The coat's normal in the local frame, whose +Z is the base's normal; need not be unit.
        geometry_coat_normal: Vec3A = Vec3A::Z, -1.0..1.0;
        /// The coat's tangent in the local frame; need neither be unit nor perpendicular.
        geometry_coat_tangent: Vec3A = Vec3A::X, -1.0..1.0;
    }
}
