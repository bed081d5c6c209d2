//! What drafts of glTF's material extensions add to a surface.

use crate::TextureRef;

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
