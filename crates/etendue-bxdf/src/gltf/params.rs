//! What a glTF surface with extensions is at a point.

use crate::{metal_rough::MetalRoughParams, multiscatter::Compensation, parameters};
use etendue_color::Spectrum;
use glam::Vec3A;

parameters! {
    /// What a glTF 2.0 surface with its material extensions is at a point, after its textures; by default a white, fully
    /// rough dielectric without extensions.
    ///
    /// Fields have the names of the specification and of the `KHR_materials_*` extensions. Out of range is clamped, NaN
    /// counts as the lower end (for `ior` as 1.5, for `attenuation_distance` as infinite).
    pub struct GltfParams {
        /// Diffuse colour of a dielectric, tint of what it transmits, F0 of a metal; lanes 0..1.
        base_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// 0 dielectric .. 1 metal.
        metallic: f32 = 0.0, 0.0..1.0;
        /// Perceptual roughness, 0..1; α = roughness².
        roughness: f32 = 1.0, 0.0..1.0;
        /// Index of refraction, ≥ 1; 0 means infinite: reflects everything at each angle.
        ior: f32 = 1.5, 1.0..4.0;
        /// Strength of the dielectric's reflection, 0..1.
        specular: f32 = 1.0, 0.0..1.0;
        /// Tint of the dielectric's F0; lanes ≥ 0, may exceed 1.
        specular_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Coverage by a layer of lacquer, 0..1.
        clearcoat: f32 = 0.0, 0.0..1.0;
        /// Perceptual roughness of the lacquer, 0..1.
        clearcoat_roughness: f32 = 0.0, 0.0..1.0;
        /// The lacquer's normal in the local frame, whose +Z is the base's normal; need not be unit.
        clearcoat_normal: Vec3A = Vec3A::Z, -1.0..1.0;
        /// Index of refraction of the lacquer, ≥ 1; 0 means infinite.
        coat_ior: f32 = 1.5, 1.0..4.0;
        /// What is left of white light that goes through the lacquer to the base and back, at normal incidence; lanes 0..1.
        coat_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// How much light that goes to and fro between lacquer and base darkens the base, 0 (not at all) .. 1.
        coat_darkening: f32 = 0.0, 0.0..1.0;
        /// How much longer the lacquer's highlights are along `coat_tangent`, 0..1, as `anisotropy_strength` of the base.
        coat_anisotropy_strength: f32 = 0.0, 0.0..1.0;
        /// Direction of the lacquer's longer highlights in the local frame; need neither be unit nor perpendicular to its normal.
        coat_tangent: Vec3A = Vec3A::X, -1.0..1.0;
        /// Coverage by fuzz, fibres on top of all, 0..1.
        fuzz: f32 = 0.0, 0.0..1.0;
        /// Colour of the fuzz; lanes 0..1.
        fuzz_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Roughness of the fuzz, 0 upright fibres .. 1 dust.
        fuzz_roughness: f32 = 0.5, 0.0..1.0;
        /// Colour and strength of the sheen, fibres under the lacquer; lanes 0..1, black for none.
        sheen_color: Spectrum = Spectrum::ZERO, 0.0..1.0;
        /// Perceptual roughness of the sheen, 0..1.
        sheen_roughness: f32 = 0.0, 0.0..1.0;
        /// Part of the light that enters a dielectric and is let through instead of being scattered diffusely, 0..1.
        transmission: f32 = 0.0, 0.0..1.0;
        /// Thickness of the volume behind the surface. Only its sign matters: 0 is a thin sheet, above 0 the boundary of a
        /// volume, which refracts.
        thickness: f32 = 0.0, 0.0..1.0;
        /// What white light becomes in the volume after `attenuation_distance`; lanes 0..1.
        attenuation_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Metres, > 0; infinite for a clear volume.
        attenuation_distance: f32 = f32::INFINITY, 0.0..10.0;
        /// How much of what is let through is scattered, 0..1: by a sheet that part; in a volume a factor of `multiscatter_color`.
        scatter_strength: f32 = 0.0, 0.0..1.0;
        /// Colour of the volume where it is deep and light is scattered in it many times; of what a sheet scatters. Lanes 0..1.
        multiscatter_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Mean cosine of the angle by which the volume turns light, −1 back .. 1 straight on; (1 + it) / 2 of what a sheet scatters
        /// comes out on its far side.
        scatter_anisotropy: f32 = 0.0, -1.0..1.0;
        /// Coverage by a thin film, 0..1.
        iridescence: f32 = 0.0, 0.0..1.0;
        /// Index of refraction of the film, ≥ 1.
        iridescence_ior: f32 = 1.3, 1.0..3.0;
        /// Thickness of the film, nanometres.
        iridescence_thickness: f32 = 400.0, 0.0..1200.0;
        /// How much longer highlights are along local x, 0..1: αx = mix(α, 1, strength²), αy = α.
        anisotropy_strength: f32 = 0.0, 0.0..1.0;
        /// 20 over the Abbe number of the volume, ≥ 0; 0 for none.
        dispersion: f32 = 0.0, 0.0..1.0;
        /// Part of the diffuse light that comes out on the far side, 0..1.
        diffuse_transmission: f32 = 0.0, 0.0..1.0;
        /// Colour of the light that is diffusely transmitted; lanes 0..1.
        diffuse_transmission_color: Spectrum = Spectrum::ONE, 0.0..1.0;
        /// Roughness of what is scattered diffusely, 0 (Lambert's) .. 1.
        diffuse_roughness: f32 = 0.0, 0.0..1.0;
        /// What is done about light that is reflected by several microfacets.
        compensation: Compensation = Compensation::KullaConty, 0.0..1.0;
    }
}

impl GltfParams {
    /// A surface of the older workflow, `KHR_materials_pbrSpecularGlossiness`: diffuse colour and F0, lanes 0..1, and
    /// glossiness = 1 − roughness.
    ///
    /// It is the dielectric of infinite index that `KHR_materials_specular` (section "Specular-glossiness materials")
    /// translates it to: `ior` 0 lets `specular_color` be F0 itself. The older extension darkens the diffuse colour by
    /// 1 − max F0; here Fresnel's term does that once, as in that translation.
    pub fn specular_glossiness(diffuse: Spectrum, specular: Spectrum, glossiness: f32) -> Self {
        let glossiness = glossiness.max(0.0).min(1.0);
        Self {
            base_color: diffuse,
            metallic: 0.0,
            roughness: 1.0 - glossiness,
            ior: 0.0,
            specular_color: specular,
            ..Self::default()
        }
    }

    /// The part of these parameters that plain metallic-roughness surfaces have.
    pub fn metal_rough(&self) -> MetalRoughParams {
        MetalRoughParams {
            base_color: self.base_color,
            metallic: self.metallic,
            roughness: self.roughness,
            ior: self.ior,
            specular: self.specular,
            specular_color: self.specular_color,
            compensation: self.compensation,
        }
    }

    /// How much of what enters a thin sheet is scattered: 0 for volumes.
    #[inline]
    pub fn sheet_scatter(&self) -> f32 {
        if self.thickness > 0.0 { 0.0 } else { self.scatter_strength.max(0.0).min(1.0) }
    }

    /// What of the light that enters a thin sheet is scattered to the near side and to the far side: colours 0..1, shares with a sum
    /// up to 1.
    #[inline]
    pub fn scattered_by_sheet(&self) -> [(Spectrum, f32); 2] {
        let unit = |x: f32| x.max(0.0).min(1.0);
        let (color, strength) = (self.multiscatter_color.map(unit), self.sheet_scatter());
        let forward = unit(0.5 + 0.5 * self.scatter_anisotropy);
        [(color, strength * (1.0 - forward)), (color, strength * forward)]
    }

    /// Colours of what comes out diffusely on the near side and on the far side, and their shares of the light that passes the
    /// facets, if `entered` are those of the light that enters what is beneath: colours 0..1, shares ≥ 0 with a sum up to 1.
    #[inline]
    pub fn matte(&self, entered: [(Spectrum, f32); 2]) -> [(Spectrum, f32); 2] {
        let unit = |x: f32| x.max(0.0).min(1.0);
        let transmission = unit(self.transmission);
        let far = unit(self.diffuse_transmission);
        let dielectric = 1.0 - unit(self.metallic);
        let rest = dielectric * (1.0 - transmission);
        let base = [self.base_color, self.diffuse_transmission_color].map(|c| c.map(unit));
        let share = [rest * (1.0 - far), rest * far];
        core::array::from_fn(|i| {
            let (color, more) = (entered[i].0, dielectric * transmission * entered[i].1);
            if more > 0.0 {
                let sum = share[i] + more;
                (((base[i] * share[i] + color * more) * (1.0 / sum)).map(unit), sum)
            } else {
                (base[i], share[i])
            }
        })
    }

    /// True if some extension beyond `KHR_materials_ior` and `KHR_materials_specular` changes how the surface scatters;
    /// otherwise [`crate::MetalRough`] is the same surface and faster.
    pub fn has_extensions(&self) -> bool {
        self.clearcoat > 0.0
            || self.sheen_color.max_element() > 0.0
            || self.transmission > 0.0
            || self.iridescence > 0.0
            || self.anisotropy_strength > 0.0
            || self.diffuse_transmission > 0.0
            || self.diffuse_roughness > 0.0
            || self.fuzz > 0.0
    }
}

impl From<MetalRoughParams> for GltfParams {
    fn from(p: MetalRoughParams) -> Self {
        Self {
            base_color: p.base_color,
            metallic: p.metallic,
            roughness: p.roughness,
            ior: p.ior,
            specular: p.specular,
            specular_color: p.specular_color,
            compensation: p.compensation,
            ..Self::default()
        }
    }
}
