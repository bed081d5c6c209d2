//! Light from infinitely far away.

use etendue_image::Image;
use glam::Vec3;
use std::sync::Arc;

/// The sky: a constant, or a picture of all directions.
///
/// A direction `d` is looked up at `u = atan2(d.z, d.x)/2π + ½`, `v = ½ − asin(d.y)/π` after turning it back by
/// `rotation`; the picture's centre is +X.
#[derive(Clone, Debug)]
pub enum Environment {
    /// The same radiance from everywhere, linear Rec.709.
    Constant(Vec3),
    /// An equirectangular picture of radiance, linear Rec.709, at least 3 channels of finite, non-negative floats.
    LatLong {
        /// `F32` pixels.
        image: Arc<Image>,
        /// Turn about +Y, radians, counter-clockwise seen from above.
        rotation: f32,
        /// Multiplies the picture.
        intensity: f32,
    },
}

impl Default for Environment {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}
