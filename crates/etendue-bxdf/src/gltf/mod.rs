//! The glTF 2.0 surface with the material extensions of Khronos.

mod params;

pub use params::GltfParams;
