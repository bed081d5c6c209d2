//! Where the picture is taken from.

use crate::Bounds;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// How the camera maps directions to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole; the angle is from the picture's bottom to its top, radians, 0 < yfov < π.
    Perspective {
        /// Vertical field of view.
        yfov: f32,
    },
    /// Parallel rays; half the picture's height in metres.
    Orthographic {
        /// Half height of the view volume.
        ymag: f32,
    },
}

/// A camera: looks down −Z of its own space, +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// For people: the file's name for it.
    pub name: String,
    /// Camera space to world space, without scale.
    pub transform: Affine3A,
    /// Pinhole or parallel.
    pub projection: Projection,
    /// Width over height that the file asks for; the picture's own size decides when absent.
    pub aspect: Option<f32>,
}

impl Camera {
    /// A pinhole camera at `eye` that looks at `target`; `yfov` in radians. `up` must not be parallel to the view.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, yfov: f32) -> Self {
        let z = (eye - target).try_normalize().unwrap_or(Vec3::Z);
        let x = up.cross(z).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
        let y = z.cross(x);
        let transform =
            Affine3A { matrix3: Mat3A::from_cols(x.into(), y.into(), z.into()), translation: eye.into() };
        Self { name: String::new(), transform, projection: Projection::Perspective { yfov }, aspect: None }
    }

    /// A camera that shows all of `bounds`, from the front, a little to the right and above, as a product photographer
    /// would start. `aspect` is width over height.
    pub fn framing(bounds: &Bounds, aspect: f32, yfov: f32) -> Self {
        let (center, radius) = if bounds.is_empty() {
            (Vec3A::ZERO, 1.0)
        } else {
            (bounds.center(), bounds.diagonal().max(1e-6) * 0.5)
        };
        let narrow = yfov.min(2.0 * ((yfov * 0.5).tan() * aspect.max(1e-3)).atan());
        let direction = Vec3::new(0.45, 0.22, 1.0).normalize();
        // The bounding sphere would always fit; a model seldom fills it, so stand a little closer.
        let distance = 0.88 * radius / (narrow * 0.5).sin();
        let center = Vec3::from(center);
        Self::look_at(center + direction * distance, center, Vec3::Y, yfov)
    }

    /// Ray through the picture at `ndc`, x and y in −1..1 (y up), of a picture `aspect` wide: origin and unit direction.
    #[inline]
    pub fn ray(&self, ndc: [f32; 2], aspect: f32) -> (Vec3A, Vec3A) {
        match self.projection {
            Projection::Perspective { yfov } => {
                let h = (yfov * 0.5).tan();
                let d = Vec3A::new(ndc[0] * h * aspect, ndc[1] * h, -1.0).normalize();
                (self.transform.translation, self.transform.matrix3 * d)
            }
            Projection::Orthographic { ymag } => {
                let o = Vec3A::new(ndc[0] * ymag * aspect, ndc[1] * ymag, 0.0);
                (self.transform.transform_point3a(o), self.transform.matrix3 * Vec3A::NEG_Z)
            }
        }
    }
}
