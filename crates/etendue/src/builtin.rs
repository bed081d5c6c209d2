//! The model and the sky that need no file.
//!
//! Both were made by the generator in `crates/etendue-builtin`.

use crate::image::{DecodeLimits, decode_environment};
use crate::import::{ImportError, ImportOptions, Imported, import_bytes};
use crate::scene::{Environment, Scene};
use std::sync::Arc;

/// The helmet as a `.glb` file.
pub const HELMET_GLB: &[u8] = include_bytes!("../assets/helmet.glb");
/// The studio sky as a Radiance `.hdr` file.
pub const STUDIO_HDR: &[u8] = include_bytes!("../assets/studio.hdr");

/// The helmet as the importer reads it.
///
/// # Errors
/// None that the project's tests would let pass: the file is part of the program.
pub fn import_helmet(options: &ImportOptions) -> Result<Imported, ImportError> {
    import_bytes(HELMET_GLB, "built-in helmet", options)
}

/// The studio sky, turned by `rotation` radians and `intensity` times as bright.
///
/// # Errors
/// As [`import_helmet`].
pub fn studio(rotation: f32, intensity: f32) -> Result<Environment, crate::image::ImageError> {
    let sky = decode_environment(STUDIO_HDR, &DecodeLimits::default())?;
    Ok(Environment::LatLong { image: Arc::new(sky.image), rotation, intensity })
}

/// The helmet under the studio sky.
///
/// # Errors
/// As [`import_helmet`].
pub fn helmet() -> Result<Scene, Box<dyn std::error::Error + Send + Sync>> {
    let mut scene = import_helmet(&ImportOptions::default())?.scene;
    scene.environment = studio(0.0, 1.0)?;
    Ok(scene)
}
