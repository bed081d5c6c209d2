//! What a point may ask about the rest of the scene.

use etendue_color::Spectrum;
use glam::Vec3A;

/// A light as seen from a point, for the question whether it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toward {
    /// The light's number in [`crate::Lighting::lights`].
    pub light: usize,
    /// Unit, towards the light; for one with an extent towards its middle.
    pub direction: Vec3A,
    /// Metres; infinite for directional lights.
    pub distance: f32,
}

/// Light that comes through a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Behind {
    /// Where the light enters the volume on the far side: there the scene is looked up.
    pub point: Vec3A,
    /// Unit, where one looks from there.
    pub direction: Vec3A,
    /// Perceptual roughness of what is between: how blurred the scene is seen, 0..1.
    pub roughness: f32,
}

/// The neighbourhood of a point: shadows, and what lies behind it.
///
/// `()` is an empty neighbourhood: nothing hides a light, and behind everything is the sky.
pub trait Around {
    /// The part of a light that reaches the point, 0..1. Asked only if the choices want shadows and the light would matter.
    #[inline(always)]
    fn visible(&self, _toward: &Toward) -> f32 {
        1.0
    }

    /// The radiance of the scene behind the surface; `None` leaves it to the sky.
    #[inline(always)]
    fn behind(&self, _at: &Behind) -> Option<Spectrum> {
        None
    }
}

impl Around for () {}
