//! Light that passes through a surface: glass, water, thin sheets.
//!
//! | type | what it is |
//! |---|---|
//! | [`Interface`] | how much a boundary reflects and lets through at an angle: [`Dielectric`], [`SchlickInterface`], [`Sheet`] |
//! | [`GgxDielectric`] | a boundary between two media, smooth or of GGX microfacets: reflection and refraction |
//! | [`ThinGgx`] | a sheet too thin to refract: reflection, and transmission as its mirror image |
//! | [`DiffuseTransmission`] | light scattered evenly to both sides: paper, leaves, cloth |
//! | [`absorption`] | Bouguer, Beer and Lambert's law: colour at a distance ↔ absorption coefficient |
//! | [`DielectricParams`], [`ThinSheetParams`] | the models `dielectric` and `thin-sheet` |
//!
//! The lobes are generic over the interface and implement [`crate::Bsdf`], so that whole models can compose them.

pub mod absorption;
mod diffuse_transmission;
mod interface;
mod model;
mod rough;
mod thin;
mod whole;

pub use crate::fresnel_term::Dielectric;
pub use diffuse_transmission::DiffuseTransmission;
pub use interface::{Interface, MATCHED, SchlickInterface, Sheet};
pub use model::{DielectricParams, ThinSheet, ThinSheetParams};
pub use rough::GgxDielectric;
pub(crate) use rough::refract;
pub use thin::ThinGgx;
