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

    /// The camera's rays for a picture `aspect` times as wide as high.
    pub fn rays(&self, aspect: f32) -> CameraRays {
        let m = &self.transform.matrix3;
        let (half, perspective) = match self.projection {
            Projection::Perspective { yfov } => ((yfov * 0.5).tan(), true),
            Projection::Orthographic { ymag } => (ymag, false),
        };
        CameraRays {
            origin: self.transform.translation,
            axis: -m.z_axis,
            across: m.x_axis * (half * aspect),
            up: m.y_axis * half,
            perspective,
        }
    }
}

/// A camera made ready to send out rays.
///
/// ```
/// use etendue_scene::Camera;
/// use glam::{Vec3, Vec3A};
/// let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 1.0);
/// let (origin, direction) = camera.rays(16.0 / 9.0).ray([0.0, 0.0]);
/// assert_eq!((origin, direction), (Vec3A::new(0.0, 0.0, 3.0), Vec3A::NEG_Z));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRays {
    origin: Vec3A,
    /// Unit direction of view.
    pub axis: Vec3A,
    across: Vec3A,
    up: Vec3A,
    perspective: bool,
}

impl CameraRays {
    /// The ray through the picture at `ndc`, x and y in −1..1 (y up): origin and unit direction.
    #[inline]
    pub fn ray(&self, ndc: [f32; 2]) -> (Vec3A, Vec3A) {
        let offset = self.across * ndc[0] + self.up * ndc[1];
        if self.perspective {
            (self.origin, (self.axis + offset).normalize())
        } else {
            (self.origin + offset, self.axis)
        }
    }
}
