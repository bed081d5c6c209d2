//! The light of a polygon on a cosine lobe.

use glam::Vec3A;
use std::f32::consts::{PI, TAU};

/// Corners that a polygon may have after it was cut at the horizon.
const MOST: usize = 32;
/// Corners that stand for a circle.
const CIRCLE: usize = 24;

/// A polygon seen from the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [Vec3A; MOST],
    count: usize,
}

impl Polygon {
    pub fn quad(center: Vec3A, x: Vec3A, y: Vec3A) -> Self {
        let mut corners = [Vec3A::ZERO; MOST];
        corners[..4].copy_from_slice(&[center - x - y, center + x - y, center + x + y, center - x + y]);
        Self { corners, count: 4 }
    }

    /// An ellipse of these half axes, as a polygon of the same area.
    pub fn ellipse(center: Vec3A, x: Vec3A, y: Vec3A) -> Self {
        let step = TAU / CIRCLE as f32;
        let grow = (step / step.sin()).sqrt();
        let mut corners = [Vec3A::ZERO; MOST];
        for (i, corner) in corners.iter_mut().enumerate().take(CIRCLE) {
            let (s, c) = etendue_bxdf::math::sin_cos_tau(i as f32 / CIRCLE as f32);
            *corner = center + (x * c + y * s) * grow;
        }
        Self { corners, count: CIRCLE }
    }

    pub fn map(&self, f: impl Fn(Vec3A) -> Vec3A) -> Self {
        let mut out = *self;
        out.corners[..self.count].iter_mut().for_each(|c| *c = f(*c));
        out
    }

    /// The part above z = 0.
    pub fn above(&self) -> Self {
        let mut out = Self { corners: [Vec3A::ZERO; MOST], count: 0 };
        let mut push = |v: Vec3A| {
            if out.count < MOST {
                out.corners[out.count] = v;
                out.count += 1;
            }
        };
        for i in 0..self.count {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % self.count]);
            if a.z > 0.0 {
                push(a);
            }
            if (a.z > 0.0) != (b.z > 0.0) {
                push(a + (b - a) * (a.z / (a.z - b.z)));
            }
        }
        out
    }

    /// ∫ ω dω cos-weighted over the part above the horizon, over π, as a vector: its z is the form factor, the part of a cosine lobe
    /// about z that the polygon fills (Lambert 1760; Baum, Rushmeier, Winget 1989, eq. 4: Σ θ (a × b) / |a × b| / 2π), 0..1. Its
    /// direction is the mean direction to what is seen. Corners may go round in either sense.
    pub fn form_factor(&self) -> Vec3A {
        let cut = self.above();
        if cut.count < 3 {
            return Vec3A::ZERO;
        }
        let unit = cut.map(|v| v.normalize_or_zero());
        let mut sum = Vec3A::ZERO;
        for i in 0..unit.count {
            let (a, b) = (unit.corners[i], unit.corners[(i + 1) % unit.count]);
            let cross = a.cross(b);
            let sin = cross.length();
            // The angle over its sine; the sine keeps its digits where the angle is small.
            let cos = a.dot(b);
            let angle = if cos > 0.0 {
                etendue_bxdf::math::asin(sin.min(1.0))
            } else {
                PI - etendue_bxdf::math::asin(sin.min(1.0))
            };
            if sin > 1e-12 {
                sum += cross * (angle / sin);
            }
        }
        let sum = sum * (1.0 / TAU);
        if sum.z < 0.0 { -sum } else { sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3a;

    /// A disk straight above at distance h: sin² of its angular radius. A quad that covers the sky: 1.
    #[test]
    fn known_form_factors() {
        for (radius, h) in [(1.0f32, 1.0f32), (0.1, 1.0), (3.0, 0.5)] {
            let disk = Polygon::ellipse(vec3a(0.0, 0.0, h), Vec3A::X * radius, Vec3A::Y * radius);
            let want = radius * radius / (radius * radius + h * h);
            let got = disk.form_factor();
            assert!((got.z / want - 1.0).abs() < 5e-3, "{radius} {h}: {got} {want}");
            assert!(got.x.abs() < 1e-4 && got.y.abs() < 1e-4);
        }
        let sky = Polygon::quad(vec3a(0.0, 0.0, 1.0), Vec3A::X * 1e4, Vec3A::Y * 1e4);
        assert!((sky.form_factor().z - 1.0).abs() < 1e-3);
        // Half of a wall that stands on the horizon is below it: half of the sky is ½.
        let wall = Polygon::quad(vec3a(1.0, 0.0, 0.0), Vec3A::Y * 1e4, Vec3A::Z * 1e4);
        assert!((wall.form_factor().z - 0.5).abs() < 1e-3, "{}", wall.form_factor());
        let below = Polygon::quad(vec3a(0.0, 0.0, -1.0), Vec3A::X, Vec3A::Y);
        assert_eq!(below.form_factor(), Vec3A::ZERO);
    }
}
