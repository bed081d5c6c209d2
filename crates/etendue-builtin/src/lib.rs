//! Makes what `etendue` shows when it is given nothing: a helmet and a studio sky.
//!
//! Everything is computed from formulas in this crate; the results are committed under `crates/etendue/assets`, and a test
//! holds the two together. To make them anew: `cargo run --release -p etendue-builtin -- crates/etendue/assets`.
#![forbid(unsafe_code)]

mod bake;
mod details;
mod fabric;
mod form;
mod gltf_write;
mod helmet;
mod lathe;
mod marks;
mod noise;
mod occlusion;
mod paint_parts;
mod paint_shell;
mod paint_visor;
mod rim;
mod shape;
mod shell;
mod strap;
mod studio;
mod sweep;
mod visor;

pub use helmet::helmet;
pub use studio::studio;
