//! Surfaces, in the words of glTF 2.0 and its ratified extensions.

use crate::{Extensions, Substitute, TextureRef};
use etendue_bxdf::multiscatter::Compensation;
use glam::Vec3;

/// How the base colour's alpha is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Ignored.
    #[default]
    Opaque,
    /// Present where alpha is at least this cutoff, absent elsewhere.
    Mask(f32),
    /// Coverage: that fraction of the light meets the surface, the rest passes.
    Blend,
}

/// A tangent-space normal map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalTexture {
    /// The map; +Y up (glTF's convention), data not colour.
    pub texture: TextureRef,
    /// Multiplies the map's x and y.
    pub scale: f32,
}

/// A glTF metallic-roughness surface: factors, each multiplied by its texture where there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For people: the file's name for it.
    pub name: String,
    /// Linear Rec.709 base colour, 0..1.
    pub base_color: Vec3,
    /// Opacity, 0..1; read as `alpha_mode` says.
    pub alpha: f32,
    /// sRGB colour and linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric .. 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, 0..1; alpha = roughness².
    pub roughness: f32,
    /// Roughness in G, metalness in B.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Bends the shading normal.
    pub normal_texture: Option<NormalTexture>,
    /// Ambient occlusion in R. Not used by light transport, which computes occlusion; kept for real-time shading.
    pub occlusion_texture: Option<TextureRef>,
    /// How much of the occlusion texture applies, 0..1.
    pub occlusion_strength: f32,
    /// Emitted radiance, linear Rec.709: `emissiveFactor × KHR_materials_emissive_strength`.
    pub emissive: Vec3,
    /// sRGB, multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// Meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// If false the surface is invisible from behind.
    pub double_sided: bool,
    /// `KHR_materials_unlit`: the base colour is shown as it is, without lighting.
    pub unlit: bool,
    /// `KHR_materials_ior`: index of refraction; 1.5 by default; 0 means infinite (F = 1 everywhere).
    pub ior: f32,
    /// `KHR_materials_specular`: strength of the dielectric reflection, 0..1.
    pub specular: f32,
    /// Strength in A.
    pub specular_texture: Option<TextureRef>,
    /// `KHR_materials_specular`: tints F0 of the dielectric; may exceed 1.
    pub specular_color: Vec3,
    /// sRGB, multiplies `specular_color`.
    pub specular_color_texture: Option<TextureRef>,
    /// What is done about light that meets several microfacets: glTF leaves it open.
    pub compensation: Compensation,
    /// What further extensions add; `None` if the material uses none of them.
    pub extensions: Option<Box<Extensions>>,
    /// What scatters in place of the factors above.
    pub substitute: Option<Substitute>,
}

impl Default for Material {
    /// glTF's default material: white, metallic 1, roughness 1.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::ONE,
            alpha: 1.0,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            compensation: Compensation::default(),
            extensions: None,
            substitute: None,
        }
    }
}

/// The textures of a material without its extensions, shared or to be changed: one list for both.
macro_rules! textures {
    ($m:ident, $borrow:ident) => {
        [
            $m.base_color_texture.$borrow(),
            $m.metallic_roughness_texture.$borrow(),
            normal!($m.normal_texture, $borrow),
            $m.occlusion_texture.$borrow(),
            $m.emissive_texture.$borrow(),
            $m.specular_texture.$borrow(),
            $m.specular_color_texture.$borrow(),
        ]
        .into_iter()
        .flatten()
    };
}

/// The texture of an optional normal map.
macro_rules! normal {
    ($map:expr, $borrow:ident) => {
        $map.$borrow().map(|crate::NormalTexture { texture, .. }| texture)
    };
}
pub(crate) use normal;

impl Material {
    /// Every texture that the material refers to.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        textures!(self, as_ref).chain(self.extensions.iter().flat_map(|e| e.textures()))
    }

    /// The same, to be changed: for those who put scenes together.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureRef> {
        textures!(self, as_mut).chain(self.extensions.iter_mut().flat_map(|e| e.textures_mut()))
    }

    /// True if every factor is a finite number.
    pub fn is_finite(&self) -> bool {
        let scalars =
            [self.alpha, self.metallic, self.roughness, self.occlusion_strength, self.ior, self.specular];
        self.base_color.is_finite()
            && self.emissive.is_finite()
            && self.specular_color.is_finite()
            && scalars.iter().all(|v| v.is_finite())
            && self.normal_texture.is_none_or(|n| n.scale.is_finite())
            && self.extensions.as_ref().is_none_or(|e| e.is_finite())
            && self.textures().all(|t| t.transform.is_finite())
    }

    /// True if the surface sends out light of its own.
    pub fn is_emissive(&self) -> bool {
        self.emissive.max_element() > 0.0
    }

    /// True if light can pass through the surface because of its alpha.
    pub fn has_alpha(&self) -> bool {
        self.alpha_mode != AlphaMode::Opaque
    }
}
