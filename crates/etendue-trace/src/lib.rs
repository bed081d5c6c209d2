//! Rays against the triangles of a scene.

mod accel;
mod build;
mod emit;
mod instance;
mod lanes;
mod pages;
mod query;
mod ray;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;
mod wide;

pub use accel::{Accel, Kernel};
pub use ray::{Hit, Ray};
