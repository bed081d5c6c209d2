//! What a material is to a path, decided once for the whole scene.

use crate::extended;
use crate::skin::Skin;
use etendue_bxdf::Bsdf;
use etendue_bxdf::model::{Incidence, Interior, ModelParams};
use etendue_scene::{Material, Substitute};

/// How a surface's closure is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Kind {
    /// glTF's core material: metalness and roughness.
    #[default]
    Plain,
    /// With material extensions.
    Extended,
    /// A model of another family.
    Model,
    /// A table from a measurement.
    Measured,
}

/// A material as a path sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Body {
    pub kind: Kind,
    /// What fills the space behind the surface; `None` for opaque surfaces and thin sheets.
    pub interior: Option<Interior>,
    /// Light can come from behind.
    pub passes: bool,
    /// What fills it scatters otherwise where light enters elsewhere.
    pub mottled: bool,
    /// Its lobes have a direction within the surface.
    pub directed: bool,
    /// Light travels under the surface.
    pub skin: Option<Skin>,
}

impl Body {
    pub fn new(m: &Material) -> Self {
        if let Some(Substitute::Measured(_)) = &m.substitute {
            return Self { kind: Kind::Measured, directed: true, ..Self::default() };
        }
        if let Some(Substitute::Model(model)) = &m.substitute {
            let passes = model.closure(&Incidence::default()).refraction().is_some();
            return Self {
                kind: Kind::Model,
                interior: model.interior(),
                passes,
                mottled: false,
                directed: true,
                skin: model.subsurface().map(|p| Skin::new(&p)),
            };
        }
        let Some(e) = &m.extensions else { return Self::default() };
        let passes = e.transmission.is_some() || e.diffuse_transmission.is_some();
        let interior = passes.then(|| interior(m)).flatten();
        let mottled = e.scatter.is_some_and(|s| s.texture.is_some() || s.color_texture.is_some());
        Self {
            kind: Kind::Extended,
            interior,
            passes,
            mottled: mottled && interior.is_some_and(|i| i.scatter.is_some()),
            skin: None,
            directed: e.anisotropy.is_some()
                || e.clearcoat.is_some_and(|c| c.normal_texture.is_some() || c.anisotropy.strength > 0.0),
        }
    }
}

/// What fills a glTF body; the same everywhere in it, whatever its textures say of the surface, but for what [`Body::mottled`] says.
fn interior(m: &Material) -> Option<Interior> {
    let mut p = extended::factors(m);
    if m.metallic_roughness_texture.is_some() {
        // Metal where the texture says so does not let light in; where it says otherwise there is an inside.
        p.metallic = 0.0;
    }
    p.interior()
}
