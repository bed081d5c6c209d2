//! Environments as light that costs a lookup.
//!
//! A path tracer asks the sky for light ray by ray. An engine cannot; it asks small tables that were integrated before.
//! This room integrates them: for matte surfaces nine numbers per colour or a small cube, for glossy ones a cube that
//! is blurrier from mip to mip, and for how a surface reflects light from everywhere a table by roughness and angle, or a
//! formula fitted to it. Beside each approximation stands the integral that it approximates.
//!
//! | module | what it holds |
//! |---|---|
//! | [`sky`] | an environment made ready to be looked up and integrated |
//! | [`sh`] | nine spherical harmonics: projection, radiance, irradiance |
//! | [`sh_window`] | damping against ringing, and the least that keeps irradiance from falling below zero |
//! | [`unity`] | the seven vectors that Unity's `ShadeSH9` reads |
//! | [`irradiance`] | irradiance as a cube, and exactly |
//! | [`probe_grid`] | spherical harmonics at the points of a grid, and what lies between |
//! | [`probe_file`] | such grids in files |
//! | [`cube`] | cube maps with mips: faces, texels, solid angles |
//! | [`cube_lookup`] | cube maps without seams: bilinear and trilinear lookup |
//! | [`resample`] | latitude-longitude pictures into cubes |
//! | [`mip_mapping`] | which mip stands for which roughness |
//! | [`mod@prefilter`] | the sky as a GGX lobe sees it, by roughness |
//! | [`local`] | probes that stand in a room: parallax by a box, blending of two |
//! | [`dfg`] | how much a GGX lobe reflects, by roughness and angle: tables |
//! | [`dfg_fit`] | the same as formulas: Lazarov's, Karis', ours |
//! | [`texel_format`] | what a texel becomes in a file: half floats, shared exponent, BC6H |
//! | [`bc6h`] | block compression of light |
//! | [`ktx2`], [`dds`], [`faces`] | cube maps into files |
//! | [`mod@bake`] | everything from one sky |
//! | [`manifest`] | what is what in a folder of baked files |
//!
//! # Example
//! ```
//! use etendue_ibl::{Sh9, SkyMap};
//! use etendue_scene::Environment;
//! use glam::Vec3;
//!
//! let sky = SkyMap::new(&Environment::Constant(Vec3::ONE))?;
//! let irradiance = Sh9::project(&sky).irradiance(Vec3::Y);
//! assert!((irradiance[0] - std::f32::consts::PI).abs() < 1e-5);
//! # Ok::<(), etendue_ibl::BadSky>(())
//! ```
#![forbid(unsafe_code)]
// `!(x > 0.0)` and `x.max(0.0).min(1.0)` are meant as they stand: they also catch NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::manual_clamp)]

pub mod bake;
pub mod bc6h;
pub mod cube;
pub mod cube_lookup;
pub mod dds;
pub mod dfg;
pub mod dfg_fit;
pub mod faces;
pub mod irradiance;
pub mod ktx2;
pub mod local;
pub mod manifest;
pub mod mip_mapping;
pub mod prefilter;
pub mod probe_file;
pub mod probe_grid;
pub mod resample;
pub mod sh;
pub mod sh_window;
pub mod sky;
pub mod texel_format;
pub mod unity;

pub use bake::{BakeOptions, Baked, bake, bake_cube};
pub use cube::{CubeMap, FACES};
pub use cube_lookup::CubeLookup;
pub use dfg::{Dfg, DfgLayout, DfgMethod, DfgTable};
pub use irradiance::ExactIrradiance;
pub use local::{Probe, ProbeBox};
pub use mip_mapping::MipMapping;
pub use prefilter::{ExactPrefilter, Kernel, PrefilterOptions, prefilter};
pub use probe_file::{BadProbes, ProbeFile};
pub use probe_grid::ProbeGrid;
pub use resample::to_cube;
pub use sh::Sh9;
pub use sh_window::Window;
pub use sky::{BadSky, SkyMap};
pub use texel_format::TexelFormat;
pub use unity::UnitySh;
