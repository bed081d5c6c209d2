//! How points are found where light enters: segments that probe the surface, and their density.
//!
//! King, Kulla, Conty, Fajardo 2013, "BSSRDF Importance Sampling": a radius is drawn from a lane's profile on a disk
//! perpendicular to an axis, and the surface probed along the axis within the sphere of the lane's cut. The axis is the
//! normal (half the time) or a tangent (a quarter each). A point could have been found along each axis and by each lane;
//! its density is the sum over all of them, which is the balance heuristic in one-sample form (Veach 1997, section 9.2.4).

use super::{Subsurface, profile};
use crate::math::sin_cos_tau;
use core::f32::consts::FRAC_1_PI;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// With which probability a probe goes along x, y and z of the frame.
const AXES: [f32; 3] = [0.25, 0.25, 0.5];
/// The profile is infinite at r = 0: radii are raised to this, metres.
const MIN_RADIUS: f32 = 1e-18;

/// A segment to be intersected with the object, in the frame of the point where the light leaves, in metres from that point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Where it begins.
    pub origin: Vec3A,
    /// Where it goes, unit.
    pub direction: Vec3A,
    /// How long it is, metres.
    pub length: f32,
}

/// What a point found by a probe is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Sp, per square metre.
    pub value: Spectrum,
    /// Density of the point over the surface, per square metre, as if a probe with several hits returned each of them.
    pub pdf: f32,
}

impl Subsurface {
    /// A probe: `uc` picks axis and lane, `u` the radius and the angle; all in 0..1.
    ///
    /// `None` if no lane travels, or the drawn radius is at the cut.
    pub fn sample_probe(&self, uc: f32, u: [f32; 2]) -> Option<Probe> {
        // A quarter of the range each for x and y, the rest for z; what is left of `uc` is even again and picks the lane.
        let quarter = 4.0 * uc.max(0.0).min(0.999_999_94);
        let (axis, mut rest) = if quarter < 2.0 {
            (2, 0.5 * quarter)
        } else if quarter < 3.0 {
            (0, quarter - 2.0)
        } else {
            (1, quarter - 3.0)
        };
        let mut picked = None;
        for (lane, p) in self.probability.0.into_iter().enumerate() {
            if p > 0.0 {
                picked = Some(lane);
                if rest < p {
                    break;
                }
                rest -= p;
            }
        }
        let d = self.shape[picked?];
        let (r, cut) = (d * profile::sample(u[0]), d * profile::CUT);
        let half = ((cut - r) * (cut + r)).max(0.0).sqrt();
        // Also taken by NaN.
        if !(half > 0.0) {
            return None;
        }
        // An angle that is no number is no direction.
        let (sin, cos) = sin_cos_tau(if u[1].abs() <= 1.0 { u[1] } else { 0.0 });
        let (a, b) = (r * cos, r * sin);
        let (origin, direction) = match axis {
            0 => (vec3a(half, a, b), -Vec3A::X),
            1 => (vec3a(b, half, a), -Vec3A::Y),
            _ => (vec3a(a, b, half), -Vec3A::Z),
        };
        Some(Probe { origin, direction, length: 2.0 * half })
    }

    /// The profile at a distance, per square metre; zero for lanes that do not travel. Distances below 1e-18 m count as that.
    pub fn eval(&self, distance: f32) -> Spectrum {
        // Also taken by NaN.
        if !(distance >= 0.0) {
            return Spectrum::ZERO;
        }
        let r = distance.max(MIN_RADIUS);
        Spectrum(core::array::from_fn(|lane| self.albedo[lane] * self.area_density(lane, r)))
    }

    /// The value and density of a point found by a probe.
    ///
    /// `offset` is the point in the frame of [`Subsurface::sample_probe`], metres; `normal` the surface's true (geometric)
    /// unit normal there, in that frame; its sign does not matter. Density and value are zero beyond the reach.
    pub fn found(&self, offset: Vec3A, normal: Vec3A) -> Found {
        let distance = offset.length();
        if !(distance >= 0.0 && distance.is_finite() && normal.is_finite()) {
            return Found { value: Spectrum::ZERO, pdf: 0.0 };
        }
        let o = offset * offset;
        // The distance as seen along each axis, and the cosine by which the disk's area is seen on the surface.
        let seen = [(o.y + o.z).sqrt(), (o.z + o.x).sqrt(), (o.x + o.y).sqrt()];
        let mut pdf = 0.0;
        for lane in 0..4 {
            let p = self.probability[lane];
            // A probe ends at the sphere of its lane's cut, along whatever axis.
            if p > 0.0 && distance < self.shape[lane] * profile::CUT {
                let mut sum = 0.0;
                for axis in 0..3 {
                    let cos = normal[axis].abs().min(1.0);
                    sum += AXES[axis] * cos * self.area_density(lane, seen[axis].max(MIN_RADIUS));
                }
                pdf += p * sum;
            }
        }
        Found { value: self.eval(distance), pdf }
    }

    /// A lane's profile for albedo 1, per square metre.
    #[inline(always)]
    fn area_density(&self, lane: usize, r: f32) -> f32 {
        let d = self.shape[lane];
        profile::radial_density(r / d) * (0.5 * FRAC_1_PI) / (d * r)
    }
}
