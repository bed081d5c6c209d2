//! How light scatters at a point.
//!
//! Everything here happens in a local frame whose +Z is the shading normal; directions are unit vectors that point
//! away from the surface. There are no textures, no scene and no files: a caller evaluates its textures, builds a
//! small closure on the stack (for glTF surfaces [`MetalRough`]) and asks it through the verbs of [`Bsdf`].
//!
//! From the contract over Fresnel terms, microfacets, single lobes and whole surfaces to what integrates them:
//!
//! | module | what it holds |
//! |---|---|
//! | [`bsdf`] | the contract: what `eval`, `pdf`, `sample`, `albedo` return, in which measure |
//! | [`model`] | the whole models by name, with their parameters |
//! | [`laws`] | χ², furnace, reciprocity, as code to run on any closure |
//! | [`fresnel`] | how much an interface reflects: Schlick, exact dielectric, ior ↔ F0 |
//! | [`conductor`] | metals: the exact reflectance of a complex index, unpolarised and as amplitudes |
//! | [`f82`] | metals by two colours, at normal incidence and at 82° |
//! | [`fresnel_term`] | any of these as a type parameter; mean reflectance of a dielectric |
//! | [`fresnel_average`] | any Fresnel term averaged over the microfacets that a GGX lobe shows |
//! | [`thin_film`] | colours of films: Airy's sum, and its mean over three colours |
//! | [`ior_table`] | measured metals and dielectrics by name |
//! | [`ggx`] | the Trowbridge-Reitz microfacet lobe, isotropic and anisotropic |
//! | [`microfacet`] | other distributions of normals and masking terms, and the lobe that they make |
//! | [`energy`] | the GGX lobe's albedo as a table |
//! | [`multiscatter`] | light that meets several microfacets: compensated lobes, and the random walk beside them |
//! | [`diffuse`] | matte surfaces: Lambert, Oren-Nayar, EON, Disney's |
//! | [`dielectric`] | glass and thin sheets: light that is reflected and refracted, smooth and rough |
//! | [`rough_conductor`] | metals by name, index or colours |
//! | [`sheen`] | fibres: glTF's sheen, OpenPBR's fuzz |
//! | [`hair`] | fibres of hair and fur |
//! | [`bssrdf`] | light that leaves a surface elsewhere than it entered: normalized diffusion, probes |
//! | [`measured`] | materials as tables from files |
//! | [`metal_rough`] | glTF 2.0 Appendix B with `KHR_materials_ior` and `KHR_materials_specular` |
//! | [`gltf`] | the glTF surface with the Khronos material extensions |
//! | [`openpbr`] | OpenPBR 1.1: metal, diffuse, subsurface and glass under film, coat and fuzz |
//! | [`disney`] | Disney's BRDF of 2012 and BSDF of 2015 |
//! | [`classic`] | what shaders compute: Cook-Torrance, Phong, Blinn-Phong |
//! | [`layered`] | two interfaces and what lies between, by random walk: the measure of layerings |
//! | [`reflectance`] | the reflectances of Nicodemus 1977, reflection and transmission apart |
//! | [`quadrature`] | integrals over directions on both sides of a surface: maps, panels, total density |
//! | [`sampling`] | disks, hemispheres, cones, triangles, frames, MIS weights |
//! | [`math`] | elementary functions with the same bits on each platform |
//!
//! # Example
//! ```
//! use etendue_bxdf::{Bsdf, MetalRough, MetalRoughParams};
//! use etendue_color::Spectrum;
//! use glam::Vec3A;
//!
//! let gold = MetalRough::new(&MetalRoughParams {
//!     base_color: Spectrum::rgb(1.0, 0.77, 0.34),
//!     metallic: 1.0,
//!     roughness: 0.3,
//!     ..Default::default()
//! });
//! let wo = Vec3A::new(0.6, 0.0, 0.8);
//! if let Some(s) = gold.sample(wo, 0.5, [0.25, 0.75]) {
//!     let f = gold.eval(wo, s.wi);
//!     let weight = f * (s.wi.z / s.pdf);
//!     assert!((weight - s.weight).max_element().abs() < 1e-4);
//! }
//! ```
#![forbid(unsafe_code)]
// `!(x > 0.0)` and `x.max(0.0).min(1.0)` are meant as they stand: they also catch NaN, which the forms that the lints
// propose let through.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::manual_clamp)]

pub mod bsdf;
pub mod bssrdf;
pub mod classic;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod disney;
pub mod energy;
pub mod f82;
pub mod fresnel;
pub mod fresnel_average;
pub mod fresnel_term;
pub mod ggx;
pub mod gltf;
pub mod hair;
mod ior_metals;
pub mod ior_table;
pub mod laws;
pub mod layered;
pub mod math;
pub mod measured;
pub mod metal_rough;
pub mod microfacet;
pub mod model;
pub mod multiscatter;
pub mod openpbr;
pub mod quadrature;
pub mod reflectance;
pub mod rough_conductor;
pub mod sampling;
pub mod sheen;
pub mod thin_film;
pub mod varnish;

pub use bsdf::{Bsdf, BsdfSample, DeltaPart, Eval, LobeKind, MIN_COS};
pub use conductor::Conductor;
pub use dielectric::{GgxDielectric, ThinGgx};
pub use diffuse::{Lambert, disney::DisneyDiffuse, eon::Eon, oren_nayar::OrenNayar};
pub use disney::{DisneyBrdf, DisneyBsdf};
pub use f82::F82Tint;
pub use fresnel::Schlick;
pub use fresnel_term::{Dielectric, Fresnel};
pub use ggx::{Ggx, GgxReflection};
pub use gltf::{Gltf, GltfParams};
pub use metal_rough::{Coupling, MetalRough, MetalRoughParams};
pub use sheen::{Fuzz, Sheen, SheenRow};
