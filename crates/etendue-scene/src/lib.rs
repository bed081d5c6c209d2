//! What is in the world, as plain data: geometry, instances, camera, lights, environment, textures, materials.
//!
//! Frame: right-handed, +Y up, a camera looks down its −Z, metres; UV origin top-left (all as in glTF 2.0).
//! Indices between parts (an instance's mesh, a texture's image …) are plain `u32` into the [`Scene`]'s vectors;
//! [`Scene::validate`] checks them all once, so that no one after it has to.
#![forbid(unsafe_code)]

mod camera;
mod drafts;
mod environment;
mod extensions;
mod light;
mod light_profile;
mod material;
mod mesh;
mod scene;
mod substitute;
mod texture;

pub use camera::{Camera, CameraRays, Projection};
pub use drafts::{DiffuseRoughness, Fuzz, Scatter};
pub use environment::Environment;
pub use extensions::{
    Anisotropy, Clearcoat, DiffuseTransmission, Extensions, Iridescence, Sheen, SpecularGlossiness,
    Transmission, Volume,
};
pub use light::{Light, LightKind};
pub use light_profile::{AimedProfile, LightProfile, Web};
pub use material::{AlphaMode, Material, NormalTexture};
pub use mesh::{Instance, Mesh};
pub use scene::{Bounds, InvalidScene, Scene, Variant};
pub use substitute::{MeasuredMaterial, Substitute};
pub use texture::{Filter, Footprint, Sampler, Texture, TextureRef, Wrap};
