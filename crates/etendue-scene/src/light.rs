//! Lights without a surface: `KHR_lights_punctual`, `EXT_lights_ies`.

use glam::Vec3;

/// What a punctual light's intensity is measured in, and its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from infinitely far; `intensity` is illuminance (lux) on a surface that faces it.
    Directional,
    /// From a point, equal in all directions; `intensity` is luminous intensity (candela).
    Point,
    /// From a point within a cone; full up to the inner angle, none from the outer one on (radians from the axis,
    /// 0 ≤ inner < outer ≤ π/2), falling off between them as in `KHR_lights_punctual`.
    Spot {
        /// Where the fall-off starts.
        inner: f32,
        /// Where the light ends.
        outer: f32,
    },
    /// From a point, as a lamp was measured: `intensity` multiplies the candela of its profile.
    Profile {
        /// Index into [`crate::Scene::profiles`].
        profile: u32,
        /// Unit vector at a right angle to the light's direction, where the profile's horizontal angle 0 is.
        side: Vec3,
    },
}

/// A light without extent.
///
/// Units follow glTF: candela and lux are carried as the numbers W/sr and W/m² of the renderer's radiometric scale
/// (no 683 lm/W), which is what real-time viewers do and keeps them comparable with a file's emissive surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// For people: the file's name for it.
    pub name: String,
    /// Shape and unit.
    pub kind: LightKind,
    /// Linear Rec.709 colour times intensity.
    pub intensity: Vec3,
    /// Where it stands (unused for directional lights), metres, world space.
    pub position: Vec3,
    /// Unit vector along which the light shines (unused for point lights), world space.
    pub direction: Vec3,
    /// Distance at which the light ends smoothly; `None` is unlimited. Only point and spot lights have one.
    pub range: Option<f32>,
}

impl Light {
    /// True if every value is a finite number.
    pub fn is_finite(&self) -> bool {
        let angles = match self.kind {
            LightKind::Spot { inner, outer } => inner.is_finite() && outer.is_finite(),
            LightKind::Profile { side, .. } => side.is_finite(),
            _ => true,
        };
        angles
            && self.intensity.is_finite()
            && self.position.is_finite()
            && self.direction.is_finite()
            && self.range.is_none_or(|r| r.is_finite())
    }
}
