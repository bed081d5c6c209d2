//! The lab: what a scattering model does, as pictures and as verdicts.
//!
//! | module | what it holds |
//! |---|---|
//! | [`draw`] | drawings with two faces, SVG and PNG; charts made of them |
//! | [`bench`](mod@bench) | the plots of one model: lobe, sphere, D G F, albedo, sampling, energy loss |
//! | [`verify`] | the laws of [`etendue_bxdf::laws`] over many models in parallel, and the report |
//! | [`mod@compare`] | how far a picture is from its reference: figures, maps, a page |
//! | [`notes`] | formulas of the founding notes beside the right ones, with the size of the error |
#![forbid(unsafe_code)]

pub mod bench;
pub mod compare;
pub mod draw;
mod html;
pub mod notes;
pub mod verify;
