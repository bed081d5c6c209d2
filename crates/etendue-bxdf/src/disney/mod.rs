//! Disney's surfaces, as published.
//!
//! | module | what it holds |
//! |---|---|
//! | [`brdf`] | the principled BRDF of 2012 |
//! | [`bsdf`] | the BSDF of 2015: thin and solid, with light that passes |
//! | [`coat`] | the clear coat of both, and the choice between lobes |
//! | [`tint`] | hue of a colour |
//!
//! Both are kept as their author wrote them, for pictures that must look like his: their lobes are added without one knowing
//! of the other, so that at grazing angles they return more light than they receive. Their claims say how much.

pub mod brdf;
pub mod bsdf;
pub mod coat;
pub mod tint;

pub use brdf::{DisneyBrdf, DisneyBrdfParams};
pub use bsdf::{DisneyBsdf, DisneyBsdfParams};
