//! What light is made of, and how a number becomes a colour on a screen.
//!
//! This room knows no other. It holds the four-lane [`Spectrum`] that all scattering code works on.
#![forbid(unsafe_code)]

mod spectrum;

pub use spectrum::Spectrum;
