//! What a point asks about the rest of the scene, answered by rays.

use super::Twin;
use crate::around::{Around, Behind, Toward};
use crate::inputs::Part;
use crate::shade::shade;
use etendue_bxdf::math::sin_cos_tau;
use etendue_bxdf::sampling::Frame;
use etendue_color::Spectrum;
use etendue_render::ShadingPoint;
use etendue_trace::Ray;
use glam::Vec3A;
use std::cell::Cell;

/// The scene around a point.
pub(super) struct Neighbourhood<'a> {
    pub twin: &'a Twin<'a>,
    pub point: &'a ShadingPoint,
    /// The point's share of the pixel.
    pub part: Part,
    /// Two numbers in [0, 1) of this sample, which choose a direction out of a rough surface's lobe; `None` where the point is itself
    /// seen through a surface: then nothing more is.
    pub lobe: Option<[f32; 2]>,
    /// Closest-hit and any-hit rays.
    pub rays: &'a [Cell<u64>; 2],
}

impl Around for Neighbourhood<'_> {
    #[inline]
    fn visible(&self, toward: &Toward) -> f32 {
        let from = self.point.ray_origin(toward.direction);
        let ray = if toward.distance.is_finite() {
            // To the light from where the ray really starts, and not quite there.
            let to = self.point.position + toward.direction * toward.distance - from;
            Ray { origin: from, direction: to, t_min: 0.0, t_max: 1.0 - 1e-4 }
        } else {
            Ray::new(from, toward.direction)
        };
        self.rays[1].set(self.rays[1].get() + 1);
        self.twin.world.transmittance(&ray)
    }

    /// The opaque scene behind, by one ray of the lobe that the surface's roughness makes of the direction: what the samples of a
    /// pixel see is blurred together. As in rasterisers, surfaces that transmit light are not seen through others.
    #[inline(never)]
    fn behind(&self, at: &Behind) -> Option<Spectrum> {
        let u = self.lobe?;
        let direction = spread(at.direction, at.roughness, u);
        let mut seen = Spectrum::ZERO;
        let left = self.twin.layers(
            Ray::new(at.point, direction),
            self.part,
            self.rays,
            |p| p.params.transmission > 0.0,
            |p, inputs, weight| {
                let around = Neighbourhood { point: p, lobe: None, ..*self };
                let twin = self.twin;
                seen += shade(inputs, twin.lighting, &twin.choices, &around).terms.sum() * weight;
            },
        );
        if left >= 1.0 {
            // The sky's own lookup is smoother than a ray.
            return None;
        }
        Some(if left > 0.0 { seen + self.twin.world.sky_radiance(direction) * left } else { seen })
    }
}

/// A direction of the lobe that microfacets of perceptual roughness `roughness` make of light along `d`: mirrored at a normal
/// drawn from GGX about it (Walter et al. 2007, eq. 35 and 36), as at normal incidence.
fn spread(d: Vec3A, roughness: f32, u: [f32; 2]) -> Vec3A {
    let alpha = roughness * roughness;
    if !(alpha > 1e-4) {
        return d;
    }
    let tan2 = alpha * alpha * u[0] / (1.0 - u[0]).max(1e-6);
    let cos = 1.0 / (1.0 + tan2).sqrt();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = sin_cos_tau(u[1]);
    let h = Frame::from_normal(d).to_world(Vec3A::new(sin * c, sin * s, cos));
    let out = h * (2.0 * h.dot(d)) - d;
    // Beyond a right angle the lobe would look back through the surface.
    if out.dot(d) > 0.0 { out } else { h }
}
