//! Where the picture is taken from.

use crate::Scene;
use glam::{Affine3A, DVec3, Mat3A, Vec3, Vec3A};

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

    /// A camera that shows all of `scene`'s triangles, from the front, a little to the right and above, as a product
    /// photographer would start; see [`Camera::framing_points`].
    pub fn framing(scene: &Scene, aspect: f32, yfov: f32) -> Self {
        let points = scene.instances.iter().flat_map(|i| {
            let mesh = &scene.meshes[i.mesh as usize];
            // Only corners of triangles: vertices that no triangle uses are not seen.
            let corners = mesh.indices.iter().flatten().map(|&k| mesh.positions[k as usize]);
            corners.map(|p| i.transform.transform_point3a(p.into()))
        });
        Self::framing_points(points, aspect, yfov)
    }

    /// A camera that shows all of `points`, from the front, a little to the right and above: as near as possible, so that
    /// their picture fills 88 % of the width or of the height, in the middle of both.
    ///
    /// `aspect` is width over height, `yfov` the vertical field of view in radians. Points that are not finite do not count;
    /// without any the camera shows a cube of one metre at the origin.
    ///
    /// In the camera's axes, with the camera at (cx, cy, cz), a point lies inside the right edge of the filled frame if
    /// x − cx ≤ k (cz − z), where k is the tangent of half the frame's width, that is, if x + k z ≤ cx + k cz; the other edges
    /// likewise. So the largest x + k z and −x + k z over all points give the nearest cz and the best cx, without iteration.
    pub fn framing_points(points: impl IntoIterator<Item = Vec3A>, aspect: f32, yfov: f32) -> Self {
        const FILL: f64 = 0.88;
        let view = Vec3::new(0.45, 0.22, 1.0);
        let mut camera = Self::look_at(view, Vec3::ZERO, Vec3::Y, yfov);
        let axes = camera.transform.matrix3;
        let [right, up, back] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.as_dvec3());
        let half = (f64::from(yfov) * 0.5).clamp(1e-4, 1.57).tan() * FILL;
        let k = [half * f64::from(aspect).clamp(1e-3, 1e3), half];

        // Largest of ±x + k z and ±y + k z, and the box in the camera's axes.
        let mut edges = [f64::NEG_INFINITY; 4];
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut include = |p: Vec3A| {
            let p = p.as_dvec3();
            let q = DVec3::new(p.dot(right), p.dot(up), p.dot(back));
            let sides = [q.x + k[0] * q.z, k[0] * q.z - q.x, q.y + k[1] * q.z, k[1] * q.z - q.y];
            (0..4).for_each(|i| edges[i] = edges[i].max(sides[i]));
            bounds = [bounds[0].min(q), bounds[1].max(q)];
        };
        let mut any = false;
        for p in points.into_iter().filter(|p| p.is_finite()) {
            include(p);
            any = true;
        }
        if !any {
            (0..8).for_each(|i| {
                include(Vec3A::from([0, 1, 2].map(|axis| (i >> axis & 1) as f32 - 0.5)));
            });
        }
        // What has no depth in front of the camera (a point, a line towards it) still needs some room.
        let size = (bounds[1] - bounds[0]).length();
        let room = if size > 0.0 { size * 0.05 } else { 1.0 };
        let [right_most, left_most, top_most, bottom_most] = edges;
        let cz = ((right_most + left_most) / (2.0 * k[0]))
            .max((top_most + bottom_most) / (2.0 * k[1]))
            .max(bounds[1].z + room);
        let eye =
            right * ((right_most - left_most) * 0.5) + up * ((top_most - bottom_most) * 0.5) + back * cz;
        let most = DVec3::splat(f64::from(f32::MAX) * 0.25);
        camera.transform.translation = eye.clamp(-most, most).as_vec3a();
        camera
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the camera sees `p`: x and y in −1..1 over the picture, and the distance along its axis.
    fn project(c: &Camera, aspect: f32, p: Vec3A) -> [f32; 3] {
        let Projection::Perspective { yfov } = c.projection else { panic!("a pinhole") };
        let q = c.transform.inverse().transform_point3a(p);
        let t = (yfov * 0.5).tan();
        [q.x / (-q.z * t * aspect), q.y / (-q.z * t), -q.z]
    }

    fn extent(c: &Camera, aspect: f32, points: &[Vec3A]) -> [[f32; 2]; 2] {
        let mut b = [[f32::MAX, f32::MIN]; 2];
        for p in points {
            let q = project(c, aspect, *p);
            assert!(q[2] > 0.0, "{p} lies behind the camera: {q:?}");
            (0..2).for_each(|i| b[i] = [b[i][0].min(q[i]), b[i][1].max(q[i])]);
        }
        b
    }

    fn cube(center: Vec3A, size: Vec3A) -> Vec<Vec3A> {
        (0..8).map(|i| center + size * Vec3A::from([0, 1, 2].map(|a| (i >> a & 1) as f32 - 0.5))).collect()
    }

    #[test]
    fn framing_fills_the_picture_and_centres() {
        let shapes =
            [Vec3A::ONE, Vec3A::new(10.0, 0.1, 3.0), Vec3A::new(0.2, 7.0, 0.0), Vec3A::new(30.0, 0.0, 30.0)];
        for scale in [1e-12f32, 1.0, 1e12] {
            for shape in shapes {
                for aspect in [0.3, 1.0, 16.0 / 9.0, 10.0] {
                    for yfov in [0.05f32, 0.6, 2.0] {
                        let points = cube(shape * scale * 0.3, shape * scale);
                        let c = Camera::framing_points(points.iter().copied(), aspect, yfov);
                        let b = extent(&c, aspect, &points);
                        let sides = b.map(|[lo, hi]| (hi - lo) * 0.5);
                        let what = format!("{shape} × {scale}, {aspect}, {yfov}: {b:?}");
                        let filled = sides[0].max(sides[1]);
                        assert!(filled < 0.885, "{what}");
                        // A very wide lens may be held back by the room that it keeps to the nearest point.
                        let wide = (yfov * 0.5).tan() * aspect.max(1.0) > 1.0;
                        assert!(filled > 0.875 || wide, "{what}");
                        let tight = usize::from(sides[1] > sides[0]);
                        assert!(wide || (b[tight][0] + b[tight][1]).abs() < 0.01, "{what}");
                        assert!(b.iter().flatten().all(|v| v.abs() < 0.89), "{what}");
                    }
                }
            }
        }
    }

    #[test]
    fn framing_survives_odd_scenes() {
        let nan = Vec3A::new(f32::NAN, 0.0, 0.0);
        let far = Vec3A::splat(f32::MAX);
        let view = Vec3A::new(0.45, 0.22, 1.0);
        let odd: [&[Vec3A]; 7] =
            [&[], &[nan], &[Vec3A::ONE], &[far, -far], &[nan, Vec3A::X, Vec3A::Y], &[-view, view], &[far]];
        for points in odd {
            for (aspect, yfov) in [(1.0, 0.6), (0.0, 0.0), (f32::MAX, std::f32::consts::PI)] {
                let c = Camera::framing_points(points.iter().copied(), aspect, yfov);
                assert!(c.transform.is_finite(), "{points:?} {aspect} {yfov}: {c:?}");
            }
        }
        // A point, and a line towards the camera, are in front of it.
        for points in [&[Vec3A::ONE][..], &[-view, view]] {
            let c = Camera::framing_points(points.iter().copied(), 1.0, 0.6);
            extent(&c, 1.0, points);
        }
        // Nothing at all: what would hold a cube of a metre.
        assert_eq!(
            Camera::framing(&Scene::default(), 1.0, 0.6),
            Camera::framing_points(cube(Vec3A::ZERO, Vec3A::ONE), 1.0, 0.6)
        );
    }

    #[test]
    fn framing_looks_at_triangles_where_they_stand() {
        let mesh = crate::Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(100.0)],
            indices: vec![[0, 1, 2]],
            ..Default::default()
        };
        let transform = Affine3A::from_translation(Vec3::new(5.0, 0.0, 0.0));
        let instance = crate::Instance { name: String::new(), mesh: 0, material: None, transform };
        let scene = Scene { meshes: vec![mesh.into()], instances: vec![instance], ..Scene::default() };
        let points = [Vec3A::new(5.0, 0.0, 0.0), Vec3A::new(6.0, 0.0, 0.0), Vec3A::new(5.0, 1.0, 0.0)];
        // Without the vertex that no triangle uses.
        assert_eq!(Camera::framing(&scene, 1.0, 0.6), Camera::framing_points(points, 1.0, 0.6));
    }
}
