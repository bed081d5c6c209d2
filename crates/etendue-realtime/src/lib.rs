//! The shading that engines use, on the processor: Cook-Torrance for lights, image-based light for the sky.
//!
//! [`shade()`] is one function on plain inputs, the twin of a fragment shader: what the textures said of a point
//! ([`Inputs`]), the lights and the sky made ready ([`Lighting`]), and which approximation stands where ([`Choices`]). It
//! gives the radiance term by term ([`Terms`]) and the values on the way ([`Values`]), so that each can be looked at and
//! set beside the reference's.
//!
//! | module | what it holds |
//! |---|---|
//! | [`choices`] | the approximations by name |
//! | [`preset`] | sets of them: the founding notes', Unity's, Filament's |
//! | [`inputs`] | what is known of a point |
//! | [`terms`] | what shading gives |
//! | [`around`] | what a point may ask about its neighbourhood: shadows, what lies behind |
//! | [`light`] | directional, point and spot lights; rectangles, disks and spheres |
//! | [`sky_light`] | the sky made ready |
//! | [`zonal`] | kernels about a normal that are no cosine, against spherical harmonics |
//! | [`ltc`] | the GGX lobe as a stretched cosine, for lights with an extent |
//! | [`lighting`] | lights and sky together |
//! | [`mod@shade`] | the shading itself |
//! | [`twin`] | the picture, drawn pixel by pixel on the processor |
//! | [`passes`] | every term and every value on the way to it as a picture |
//!
//! # Example
//! ```
//! use etendue_realtime::{Choices, Inputs, Lighting, shade};
//! use etendue_scene::{Environment, Scene};
//! use glam::{Vec3, Vec3A};
//!
//! let scene = Scene { environment: Environment::Constant(Vec3::ONE), ..Scene::default() };
//! let choices = Choices::default();
//! let lighting = Lighting::new(&scene, &choices)?;
//! let point = Inputs::new(Vec3A::ZERO, Vec3A::Y, Vec3A::Y);
//! let radiance = shade(&point, &lighting, &choices, &()).terms.sum();
//! // A white surface under a white sky is nearly white.
//! assert!((radiance[0] - 1.0).abs() < 0.05);
//! # Ok::<(), etendue_ibl::BadSky>(())
//! ```
#![forbid(unsafe_code)]
// `!(x > 0.0)` and `x.max(0.0).min(1.0)` are meant as they stand: they also catch NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::manual_clamp)]

mod area;
pub mod around;
pub mod choices;
mod direct;
mod film;
mod gloss;
mod indirect;
pub mod inputs;
mod layers;
pub mod light;
pub mod lighting;
pub mod ltc;
mod names;
pub mod passes;
mod polygon;
pub mod preset;
pub mod shade;
pub mod sky_light;
mod slab;
mod surface;
pub mod terms;
mod transmit;
pub mod twin;
pub mod zonal;

pub use around::{Around, Behind, Toward};
pub use choices::{Ablation, ChoiceError, Choices, DfgSource};
pub use inputs::{Inputs, Part};
pub use light::{AreaLight, AreaShape, PunctualLight};
pub use lighting::Lighting;
pub use preset::Preset;
pub use shade::shade;
pub use sky_light::SkyLight;
pub use terms::{Shaded, Terms, Values};
pub use twin::{Frame, Twin, TwinSettings};
