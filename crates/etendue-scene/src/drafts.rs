//! What drafts of glTF's material extensions add to a surface.

use crate::TextureRef;
use glam::Vec3;

/// Rough facets that scatter diffusely (`KHR_materials_diffuse_roughness`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiffuseRoughness {
    /// 0 even (Lambert's) .. 1.
    pub factor: f32,
    /// Factor in R.
    pub texture: Option<TextureRef>,
}

impl DiffuseRoughness {
    pub(crate) fn is_finite(&self) -> bool {
        self.factor.is_finite()
    }
}

/// Fibres or dust on top of everything (`KHR_materials_fuzz`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fuzz {
    /// Coverage, 0..1.
    pub factor: f32,
    /// Coverage in R.
    pub texture: Option<TextureRef>,
    /// Linear colour.
    pub color: Vec3,
    /// sRGB.
    pub color_texture: Option<TextureRef>,
    /// 0 upright fibres .. 1 dust.
    pub roughness: f32,
    /// Roughness in A.
    pub roughness_texture: Option<TextureRef>,
}

impl Default for Fuzz {
    fn default() -> Self {
        Self {
            factor: 0.0,
            texture: None,
            color: Vec3::ONE,
            color_texture: None,
            roughness: 0.5,
            roughness_texture: None,
        }
    }
}

impl Fuzz {
    pub(crate) fn is_finite(&self) -> bool {
        self.factor.is_finite() && self.color.is_finite() && self.roughness.is_finite()
    }
}

/// Light that enters is scattered (`KHR_materials_scatter`): in the volume behind the surface, or, without one, by the sheet that
/// the surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Part of what enters a sheet that is scattered; of a volume a factor of the colour. 0..1.
    pub strength: f32,
    /// Strength in A.
    pub texture: Option<TextureRef>,
    /// Linear: of a deep body after many events; of a sheet what it returns and lets through together.
    pub color: Vec3,
    /// sRGB.
    pub color_texture: Option<TextureRef>,
    /// Mean cosine of the angle by which an event turns light, −1 back .. 1 straight on; (1 + anisotropy) / 2 of what a sheet scatters
    /// comes out on its far side.
    pub anisotropy: f32,
}

impl Default for Scatter {
    fn default() -> Self {
        Self { strength: 0.0, texture: None, color: Vec3::ONE, color_texture: None, anisotropy: 0.0 }
    }
}

impl Scatter {
    pub(crate) fn is_finite(&self) -> bool {
        self.strength.is_finite() && self.color.is_finite() && self.anisotropy.is_finite()
    }
}
