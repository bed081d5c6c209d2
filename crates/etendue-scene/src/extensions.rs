//! What glTF's material extensions add to a surface.
//!
//! Factors are multiplied by their textures where there are some; each field's documentation names the texture's channel.

use crate::material::normal;
use crate::{DiffuseRoughness, Fuzz, NormalTexture, Scatter, TextureRef};
use glam::Vec3;

/// The extensions that a material uses; absent ones cost nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extensions {
    /// `KHR_materials_anisotropy`.
    pub anisotropy: Option<Anisotropy>,
    /// `KHR_materials_clearcoat`, or the draft `KHR_materials_coat`, which says more of the same layer.
    pub clearcoat: Option<Clearcoat>,
    /// `KHR_materials_diffuse_roughness`, a draft.
    pub diffuse_roughness: Option<DiffuseRoughness>,
    /// `KHR_materials_diffuse_transmission`.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// `KHR_materials_dispersion`: 20 over the Abbe number of the interior; 0 for none.
    pub dispersion: f32,
    /// `KHR_materials_fuzz`, a draft.
    pub fuzz: Option<Fuzz>,
    /// `KHR_materials_iridescence`.
    pub iridescence: Option<Iridescence>,
    /// `KHR_materials_scatter` or `KHR_materials_volume_scatter`, drafts: without it a volume absorbs all that it attenuates.
    pub scatter: Option<Scatter>,
    /// `KHR_materials_sheen`.
    pub sheen: Option<Sheen>,
    /// `KHR_materials_pbrSpecularGlossiness`: replaces metalness and roughness.
    pub specular_glossiness: Option<SpecularGlossiness>,
    /// `KHR_materials_transmission`.
    pub transmission: Option<Transmission>,
    /// `KHR_materials_volume`: without it the surface is an infinitely thin sheet.
    pub volume: Option<Volume>,
}

/// Stretched highlights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// 0 isotropic .. 1.
    pub strength: f32,
    /// Direction of the larger roughness: radians from the tangent, counter-clockwise.
    pub rotation: f32,
    /// Direction in RG (−1..1 stored as 0..1, turned by `rotation`), strength in B.
    pub texture: Option<TextureRef>,
}

/// A layer of lacquer. What `KHR_materials_clearcoat` cannot say is by default what it means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearcoat {
    /// Coverage, 0..1.
    pub factor: f32,
    /// Coverage in R.
    pub texture: Option<TextureRef>,
    /// Perceptual roughness, 0..1.
    pub roughness: f32,
    /// Roughness in G.
    pub roughness_texture: Option<TextureRef>,
    /// Bends the coat's own normal, which otherwise is the one without the base's normal map.
    pub normal_texture: Option<NormalTexture>,
    /// Index of refraction, ≥ 1; 0 means infinite.
    pub ior: f32,
    /// What is left of white light that goes through it and back, at normal incidence, linear.
    pub color: Vec3,
    /// sRGB.
    pub color_texture: Option<TextureRef>,
    /// How much light that goes to and fro between it and the base darkens the base, 0..1.
    pub darkening: f32,
    /// Stretches its highlights.
    pub anisotropy: Anisotropy,
}

impl Clearcoat {
    /// True if `KHR_materials_clearcoat` says all of it.
    pub fn is_plain(&self) -> bool {
        let plain = Self::default();
        (self.ior, self.color, self.color_texture, self.darkening, self.anisotropy)
            == (plain.ior, plain.color, plain.color_texture, plain.darkening, plain.anisotropy)
    }
}

impl Default for Clearcoat {
    fn default() -> Self {
        Self {
            factor: 0.0,
            texture: None,
            roughness: 0.0,
            roughness_texture: None,
            normal_texture: None,
            ior: 1.5,
            color: Vec3::ONE,
            color_texture: None,
            darkening: 0.0,
            anisotropy: Anisotropy::default(),
        }
    }
}

/// Light that passes and comes out evenly, as through a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// Part of the diffuse light that passes, 0..1.
    pub factor: f32,
    /// Factor in A.
    pub texture: Option<TextureRef>,
    /// Colour of what passes, linear.
    pub color: Vec3,
    /// sRGB.
    pub color_texture: Option<TextureRef>,
}

/// A thin film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// Coverage, 0..1.
    pub factor: f32,
    /// Coverage in R.
    pub texture: Option<TextureRef>,
    /// Index of the film.
    pub ior: f32,
    /// Thickness, nanometres, where the texture is 0, and where it is 1 or absent.
    pub thickness: [f32; 2],
    /// Thickness in G.
    pub thickness_texture: Option<TextureRef>,
}

/// Fuzz: the back-scattering of cloth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Linear colour and strength; black for none.
    pub color: Vec3,
    /// sRGB.
    pub color_texture: Option<TextureRef>,
    /// Perceptual roughness, 0..1.
    pub roughness: f32,
    /// Roughness in A.
    pub roughness_texture: Option<TextureRef>,
}

/// The older workflow: diffuse colour (kept in the material's base colour) and F0, instead of metalness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularGlossiness {
    /// F0, linear.
    pub specular: Vec3,
    /// 1 − perceptual roughness.
    pub glossiness: f32,
    /// sRGB F0, and glossiness in A.
    pub texture: Option<TextureRef>,
}

/// Light that passes the surface and is refracted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transmission {
    /// Part of the light that is refracted instead of scattered diffusely, 0..1.
    pub factor: f32,
    /// Factor in R.
    pub texture: Option<TextureRef>,
}

/// What fills a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Thickness beneath the surface in the mesh's space. Light transport only asks whether it is above 0; rasterisers
    /// need the number.
    pub thickness: f32,
    /// Thickness in G.
    pub thickness_texture: Option<TextureRef>,
    /// Metres after which white light has the attenuation colour; infinite for a clear volume.
    pub attenuation_distance: f32,
    /// Linear colour after that distance.
    pub attenuation_color: Vec3,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self { factor: 0.0, texture: None, color: Vec3::ONE, color_texture: None }
    }
}

impl Default for Iridescence {
    fn default() -> Self {
        Self { factor: 0.0, texture: None, ior: 1.3, thickness: [100.0, 400.0], thickness_texture: None }
    }
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self { specular: Vec3::ONE, glossiness: 1.0, texture: None }
    }
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            thickness: 0.0,
            thickness_texture: None,
            attenuation_distance: f32::INFINITY,
            attenuation_color: Vec3::ONE,
        }
    }
}

/// The textures of extensions, shared or to be changed: one list for both.
macro_rules! textures {
    ($e:ident, $borrow:ident) => {{
        let (mut coat, mut sheen, mut fuzz) = ([const { None }; 5], [None, None], [const { None }; 3]);
        let (mut diffuse, mut film, mut scatter) = ([None, None], [None, None], [None, None]);
        if let Some(Clearcoat {
            texture, roughness_texture, normal_texture, color_texture, anisotropy, ..
        }) = $e.clearcoat.$borrow()
        {
            coat = [
                texture.$borrow(),
                roughness_texture.$borrow(),
                normal!(normal_texture, $borrow),
                color_texture.$borrow(),
                anisotropy.texture.$borrow(),
            ];
        }
        if let Some(Fuzz { texture, color_texture, roughness_texture, .. }) = $e.fuzz.$borrow() {
            fuzz = [texture.$borrow(), color_texture.$borrow(), roughness_texture.$borrow()];
        }
        if let Some(DiffuseTransmission { texture, color_texture, .. }) = $e.diffuse_transmission.$borrow() {
            diffuse = [texture.$borrow(), color_texture.$borrow()];
        }
        if let Some(Iridescence { texture, thickness_texture, .. }) = $e.iridescence.$borrow() {
            film = [texture.$borrow(), thickness_texture.$borrow()];
        }
        if let Some(Scatter { texture, color_texture, .. }) = $e.scatter.$borrow() {
            scatter = [texture.$borrow(), color_texture.$borrow()];
        }
        if let Some(Sheen { color_texture, roughness_texture, .. }) = $e.sheen.$borrow() {
            sheen = [color_texture.$borrow(), roughness_texture.$borrow()];
        }
        let others = [
            $e.anisotropy.$borrow().and_then(|e| e.texture.$borrow()),
            $e.diffuse_roughness.$borrow().and_then(|e| e.texture.$borrow()),
            $e.specular_glossiness.$borrow().and_then(|e| e.texture.$borrow()),
            $e.transmission.$borrow().and_then(|e| e.texture.$borrow()),
            $e.volume.$borrow().and_then(|e| e.thickness_texture.$borrow()),
        ];
        let pairs = [diffuse, film, scatter, sheen].into_iter().flatten();
        coat.into_iter().chain(fuzz).chain(pairs).chain(others).flatten()
    }};
}

impl Extensions {
    /// Every texture that they refer to.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        textures!(self, as_ref)
    }

    /// The same, to be changed.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureRef> {
        textures!(self, as_mut)
    }

    /// True if every factor is a number, and finite where it has to be.
    pub fn is_finite(&self) -> bool {
        self.dispersion.is_finite()
            && self.anisotropy.is_none_or(|e| e.strength.is_finite() && e.rotation.is_finite())
            && self.clearcoat.is_none_or(|e| {
                e.factor.is_finite()
                    && e.roughness.is_finite()
                    && e.normal_texture.is_none_or(|n| n.scale.is_finite())
                    && e.ior.is_finite()
                    && e.color.is_finite()
                    && e.darkening.is_finite()
                    && e.anisotropy.strength.is_finite()
                    && e.anisotropy.rotation.is_finite()
            })
            && self.fuzz.is_none_or(|e| e.is_finite())
            && self.diffuse_roughness.is_none_or(|e| e.is_finite())
            && self.diffuse_transmission.is_none_or(|e| e.factor.is_finite() && e.color.is_finite())
            && self.iridescence.is_none_or(|e| {
                e.factor.is_finite() && e.ior.is_finite() && e.thickness.iter().all(|t| t.is_finite())
            })
            && self.scatter.is_none_or(|e| e.is_finite())
            && self.sheen.is_none_or(|e| e.color.is_finite() && e.roughness.is_finite())
            && self.specular_glossiness.is_none_or(|e| e.specular.is_finite() && e.glossiness.is_finite())
            && self.transmission.is_none_or(|e| e.factor.is_finite())
            && self.volume.is_none_or(|e| {
                e.thickness.is_finite() && !e.attenuation_distance.is_nan() && e.attenuation_color.is_finite()
            })
    }
}
