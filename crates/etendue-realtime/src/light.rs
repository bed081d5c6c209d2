//! Lights other than the sky.

use etendue_color::Spectrum;
use etendue_scene::{Light, LightKind};
use glam::{Vec3, Vec3A};

/// A light without an extent, ready to be asked: glTF's directional, point and spot lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctualLight {
    /// Linear Rec.709: irradiance on a surface that faces a directional light; for others power per solid angle.
    pub intensity: Spectrum,
    /// Where it stands; unused for directional lights.
    pub position: Vec3A,
    /// Unit, along which it shines; unused for point lights.
    pub direction: Vec3A,
    /// No position: parallel light.
    pub directional: bool,
    /// 1 / range², 0 for no end.
    pub inv_range2: f32,
    /// Spot: factor and summand that take the cosine to the axis to 0..1 between the outer and the inner cone; (0, 1) for
    /// others.
    pub cone: [f32; 2],
}

/// Light that arrives at a point from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incoming {
    /// Unit, towards the light.
    pub wi: Vec3A,
    /// Metres; infinite for directional lights.
    pub distance: f32,
    /// On a surface that faces the light.
    pub irradiance: Spectrum,
}

impl From<&Light> for PunctualLight {
    fn from(l: &Light) -> Self {
        let cone = match l.kind {
            LightKind::Spot { inner, outer } => {
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
                [scale, -outer.cos() * scale]
            }
            _ => [0.0, 1.0],
        };
        let directional = l.kind == LightKind::Directional;
        let range = l.range.filter(|r| *r > 0.0 && !directional);
        Self {
            intensity: Spectrum::from_rgb(l.intensity.to_array()),
            position: l.position.into(),
            direction: l.direction.into(),
            directional,
            inv_range2: range.map_or(0.0, |r| 1.0 / (r * r)),
            cone,
        }
    }
}

impl PunctualLight {
    /// What arrives at `point`; `None` where the light does not reach. Range and cone as `KHR_lights_punctual` has them
    /// ("Range Property", "Inner and Outer Cone Angles").
    #[inline]
    pub fn at(&self, point: Vec3A) -> Option<Incoming> {
        if self.directional {
            return Some(Incoming {
                wi: -self.direction,
                distance: f32::INFINITY,
                irradiance: self.intensity,
            });
        }
        let to = self.position - point;
        let d2 = to.length_squared();
        let distance = d2.sqrt();
        if !(distance > 0.0) {
            return None;
        }
        let wi = to / distance;
        let x = d2 * self.inv_range2;
        let window = (1.0 - x * x).max(0.0).min(1.0);
        let t = (self.cone[0] * -wi.dot(self.direction) + self.cone[1]).max(0.0).min(1.0);
        let strength = window * t * t / d2;
        (strength > 0.0).then(|| Incoming { wi, distance, irradiance: self.intensity * strength })
    }
}

/// The form of a light with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaShape {
    /// Half its sides as two vectors at a right angle; it shines to the side of `x × y`.
    Rectangle {
        /// From the middle to the middle of a side, metres.
        x: Vec3,
        /// From the middle to the middle of the next side, metres.
        y: Vec3,
    },
    /// Its two half axes at a right angle (equal for a circle); it shines to the side of `x × y`.
    Disk {
        /// Half axis, metres.
        x: Vec3,
        /// The other half axis, metres.
        y: Vec3,
    },
    /// Shines to all sides.
    Sphere {
        /// Metres, > 0.
        radius: f32,
    },
}

/// A light with an extent: the same radiance from each point of it in each direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Its form.
    pub shape: AreaShape,
    /// Its middle, metres.
    pub center: Vec3,
    /// Linear Rec.709.
    pub radiance: Spectrum,
    /// A rectangle or disk shines to both sides.
    pub two_sided: bool,
}
