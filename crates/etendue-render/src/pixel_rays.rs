//! Camera rays through a pixel, placed by the pixel filter.

use crate::filter::{Filter, FilterSampler};
use crate::sampler::Sampler;
use etendue_scene::{Camera, CameraRays};
use glam::Vec3A;

/// Sends out the camera rays of a picture's samples. Whatever integrator shades them, the sample (seed, pixel, index) is the same
/// ray, so that pictures of one scene lie exactly over each other.
///
/// ```
/// use etendue_render::{Filter, PixelRays, Sampler};
/// use etendue_scene::Camera;
/// use glam::{Vec3, Vec3A};
/// let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 1.0);
/// let rays = PixelRays::new(&camera, [64, 64], Filter::Box);
/// let (origin, direction) = rays.sample([32, 32], &Sampler::new(0, 32, 32, 0));
/// assert!(origin == Vec3A::new(0.0, 0.0, 3.0) && direction.dot(Vec3A::NEG_Z) > 0.999);
/// ```
#[derive(Clone, Debug)]
pub struct PixelRays {
    pub(crate) rays: CameraRays,
    filter: FilterSampler,
    size: [f32; 2],
}

impl PixelRays {
    /// For a picture of `size` (width, height) pixels.
    pub fn new(camera: &Camera, size: [u32; 2], filter: Filter) -> Self {
        let size = size.map(|n| n as f32);
        Self { rays: camera.rays(size[0] / size[1]), filter: FilterSampler::new(filter), size }
    }

    /// Origin and unit direction of the camera ray of `sampler`'s sample of the pixel (column, row).
    #[inline(always)]
    pub fn sample(&self, [x, y]: [u32; 2], sampler: &Sampler) -> (Vec3A, Vec3A) {
        let [u0, u1, ..] = sampler.get4(0);
        let (dx, dy) = (self.filter.sample(u0), self.filter.sample(u1));
        let [w, h] = self.size;
        let ndc = [(x as f32 + 0.5 + dx) / w * 2.0 - 1.0, 1.0 - (y as f32 + 0.5 + dy) / h * 2.0];
        self.rays.ray(ndc)
    }

    /// The camera's unit view direction.
    pub fn axis(&self) -> Vec3A {
        self.rays.axis
    }
}
