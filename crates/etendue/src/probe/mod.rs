//! Light at a place of a scene, by path tracing, for real-time shading to look up: reflection probes and grids of light probes.
//!
//! This stands in the facade because it knows both the path tracer and the tables that are made of its light. Both kinds see a scene as
//! a camera does: through the backs of one-sided surfaces.

mod cube;
mod grid;

pub use cube::cube_probe;
pub use grid::{Volume, light_probes};

use crate::render::World;
use crate::scene::{Camera, Projection};
use crate::trace::Ray;
use glam::{Affine3A, Mat3A, Vec3A};

/// How a probe takes its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProbeSettings {
    /// Texels along an edge of a face of a reflection probe, at least 1.
    pub size: u32,
    /// Samples for each texel of a reflection probe; for each light probe, all in all.
    pub samples: u32,
    /// Most times that light is scattered.
    pub bounces: u32,
    /// Changes all random numbers.
    pub seed: u32,
}

impl Default for ProbeSettings {
    /// Faces of 256² texels, 64 samples each, 8 bounces.
    fn default() -> Self {
        Self { size: 256, samples: 64, bounces: 8, seed: 0 }
    }
}

/// A pinhole at `at` whose square picture of 90° is a face of a cube, texel for texel. Its axes are the face's, which is seen from outside: it is a
/// mirrored camera.
fn face_camera(face: usize, at: Vec3A) -> Camera {
    let along = |s: f32, t: f32| crate::ibl::cube::face_direction(face, s, t);
    let forward = along(0.0, 0.0);
    let (right, up) = (along(1.0, 0.0) - forward, forward - along(0.0, 1.0));
    Camera {
        name: crate::ibl::FACES[face].into(),
        transform: Affine3A { matrix3: Mat3A::from_cols(right, up, -forward), translation: at },
        projection: Projection::Perspective { yfov: std::f32::consts::FRAC_PI_2 },
        aspect: Some(1.0),
    }
}

/// The share of all directions (of 384 even ones) in which a ray from `at` first meets the back of a one-sided surface: 0 in the open,
/// 1 inside of a closed body.
pub fn backs(world: &World, at: Vec3A) -> f32 {
    const RAYS: u32 = 384;
    let seen = (0..RAYS).filter(|i| {
        // A spiral of equal areas by the golden angle.
        let z = 1.0 - (2 * i + 1) as f32 / RAYS as f32;
        let (sin, cos) = (*i as f32 * 2.399_963_2).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let direction = Vec3A::new(r * cos, z, r * sin);
        let hit = world.accel().closest(&Ray::new(at, direction), &|_, _, _, _| true);
        hit.is_some_and(|h| {
            let point = world.shading_point(&h, direction);
            !point.front && !world.scene().materials[point.material as usize].double_sided
        })
    });
    seen.count() as f32 / RAYS as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ibl::cube::{face_direction, texel_centre};

    /// The ray through the middle of each pixel is the direction of the texel.
    #[test]
    fn pixels_are_texels() {
        let n = 8;
        for face in 0..6 {
            let rays = face_camera(face, Vec3A::ONE).rays(1.0);
            for (y, x) in (0..n).flat_map(|y| (0..n).map(move |x| (y, x))) {
                let ndc = [(x as f32 + 0.5) / n as f32 * 2.0 - 1.0, 1.0 - (y as f32 + 0.5) / n as f32 * 2.0];
                let (origin, d) = rays.ray(ndc);
                let want = face_direction(face, texel_centre(x, n), texel_centre(y, n)).normalize();
                assert!(origin == Vec3A::ONE && (d - want).length() < 1e-6, "{face} {x} {y}: {d} {want}");
            }
        }
    }
}
