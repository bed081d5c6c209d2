//! What light is made of, and how a number becomes a colour on a screen.
//!
//! This room knows no other. It holds the four-lane [`Spectrum`] that all scattering code works on, the sRGB
//! [transfer functions](srgb_encode), the [primaries](Primaries) and the matrices between them, and the [tone
//! curves](ToneCurve) that bring scene light into the range of a display.
#![forbid(unsafe_code)]

mod agx;
mod primaries;
mod spectrum;
mod tone;
mod transfer;

pub use primaries::{
    ACES_AP0, ACES_AP1, Matrix3, Primaries, REC709, bradford, matrix_apply, matrix_inverse, matrix_mul,
    rgb_to_rgb, rgb_to_xyz, xyz_to_rgb,
};
pub use spectrum::Spectrum;
pub use tone::{ToneCurve, UnknownToneCurve};
pub use transfer::{srgb_decode, srgb_encode, srgb8_decode, srgb8_encode};
