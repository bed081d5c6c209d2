//! Sampling of the wide lobes.

use crate::{math, sampling::concentric_disk};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec3A, vec3a};

/// Directions with density proportional to cos θ / (1 + cos² θ / b²), b = 2 α.
///
/// This is the shape of loss times cosine (its bump at cosines of about α, its fall as (α / cos)²) to a factor of two: the
/// cosine alone would meet a smooth surface's lobe, which lies at the horizon, once in 1/α² samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wide {
    b2: f32,
    /// ln(1 + 1 / b²).
    log: f32,
}

impl Wide {
    /// For an α of 1e-4..1.
    #[inline]
    pub(super) fn new(alpha: f32) -> Self {
        let b2 = 4.0 * alpha * alpha;
        Self { b2, log: math::ln_1p(1.0 / b2) }
    }

    /// A direction above the surface; its density is [`Wide::pdf`].
    #[inline(always)]
    pub(super) fn sample(&self, u: [f32; 2]) -> Vec3A {
        let [x, y] = concentric_disk(u);
        // The disk's squared radius is even in 0..1 and picks the cosine; its azimuth stays.
        let r2 = (x * x + y * y).min(1.0);
        let z2 = (self.b2 * (math::exp(r2 * self.log) - 1.0)).max(0.0).min(1.0);
        if r2 > 0.0 {
            let scale = ((1.0 - z2) / r2).sqrt();
            vec3a(x * scale, y * scale, z2.sqrt())
        } else {
            vec3a((1.0 - z2).sqrt(), 0.0, z2.sqrt())
        }
    }

    /// Density at a cosine of 0..1, per steradian.
    #[inline(always)]
    pub(super) fn pdf(&self, cos: f32) -> f32 {
        FRAC_1_PI * cos / ((self.b2 + cos * cos) * self.log)
    }
}
