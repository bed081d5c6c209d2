//! The helmet's form: a star-shaped surface around the origin, given by its radius in every direction, and the curves on it.
//!
//! Frame: +Z front, +Y up, +X the wearer's left. Angles in radians: azimuth from +Z towards +X, elevation from the horizon.

use crate::noise::smoothstep;
use glam::{Vec2, Vec3};

/// Unit direction at an azimuth and elevation.
pub fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (sa, ca) = azimuth.sin_cos();
    let (se, ce) = elevation.sin_cos();
    Vec3::new(sa * ce, se, ca * ce)
}

/// Azimuth and elevation of a direction.
pub fn angles(d: Vec3) -> Vec2 {
    Vec2::new(d.x.atan2(d.z), d.y.clamp(-1.0, 1.0).asin())
}

/// Radius at which `Σ (x/a)² + k Σ (x/a)⁴ = 1 + k` in direction `d`: an ellipsoid, a little fuller for k > 0.
fn full_ellipsoid(d: Vec3, axes: Vec3, k: f32) -> f32 {
    let q = (d / axes) * (d / axes);
    let (a, b) = (q.element_sum(), k * (q * q).element_sum());
    ((-a + (a * a + 4.0 * b * (1.0 + k)).sqrt()) / (2.0 * b)).sqrt()
}

/// Radius in direction `d` of an ellipsoid around `centre` that contains the origin.
fn offset_ellipsoid(d: Vec3, centre: Vec3, axes: Vec3) -> f32 {
    let (u, v) = (d / axes, centre / axes);
    let (a, b, c) = (u.dot(u), u.dot(v), v.dot(v) - 1.0);
    (b + (b * b - a * c).max(0.0).sqrt()) / a
}

/// A maximum without a crease: k ln(e^{a/k} + e^{b/k}).
fn soft_max(a: f32, b: f32, k: f32) -> f32 {
    let m = a.max(b);
    m + k * (((a - m) / k).exp() + ((b - m) / k).exp()).ln()
}

/// Radius of the skull's form without anything on it: what the visor follows.
pub fn cranium(d: Vec3) -> f32 {
    full_ellipsoid(d, Vec3::new(0.122, 0.146, 0.150), 0.35)
}

/// Half width of the raised strip over the crown as the cosine of the angle to the X axis: it starts to rise at the second
/// and is at full height at the first.
pub const CREST: [f32; 2] = [0.150, 0.185];

/// Radius of the shell: cranium, jaw, and the raised strip over the crown.
pub fn shell(d: Vec3) -> f32 {
    let jaw = offset_ellipsoid(d, Vec3::new(0.0, -0.052, 0.026), Vec3::new(0.094, 0.092, 0.121));
    let base = soft_max(cranium(d), jaw, 0.006);
    let along = d.y.atan2(d.z);
    // It runs out before the visor's frame and below the nape.
    let fade = if along > 0.0 { smoothstep(0.66, 0.86, along) } else { smoothstep(-2.50, -2.75, along) };
    base + 0.0038 * smoothstep(CREST[1], CREST[0], d.x.abs()) * fade
}

/// The shell's point in direction `d`.
pub fn on_shell(d: Vec3) -> Vec3 {
    d * shell(d)
}

/// Unit outward normal of the star-shaped surface with radius `r` at direction `d`, by central differences.
pub fn normal(d: Vec3, r: impl Fn(Vec3) -> f32) -> Vec3 {
    let (t, b) = d.any_orthonormal_pair();
    let e = 2e-3;
    let at = |o: Vec3| {
        let q = (d + o).normalize();
        q * r(q)
    };
    let (du, dv) = (at(t * e) - at(t * -e), at(b * e) - at(b * -e));
    let n = du.cross(dv).normalize();
    if n.dot(d) < 0.0 { -n } else { n }
}

/// The visor's opening in the plane of azimuth and elevation: a superellipse, wider above, its ends lifted.
const HALF_WIDTH: f32 = 1.20;
const HALF_HEIGHT: f32 = 0.45;
const MIDDLE: f32 = 0.075;
const WIDER_ABOVE: f32 = 0.10;
const LIFT: f32 = 0.03;
const POWER: f32 = 2.7;

/// Azimuth and elevation at relative coordinates of the visor (both −1..1 inside its opening).
fn from_visor(q: Vec2) -> Vec2 {
    let x = q.x;
    // Below, the opening dips towards the cheeks and rises over the nose.
    let nose = 0.10 * smoothstep(0.2, -1.0, q.y) * (-(x / 0.30) * (x / 0.30)).exp();
    Vec2::new(x * HALF_WIDTH * (1.0 + WIDER_ABOVE * q.y), MIDDLE + HALF_HEIGHT * q.y + LIFT * x * x + nose)
}

/// The inverse of `from_visor`, by fixed-point iteration.
fn to_visor(a: Vec2) -> Vec2 {
    let mut q = Vec2::ZERO;
    for _ in 0..12 {
        let back = from_visor(q);
        q += (a - back) / Vec2::new(HALF_WIDTH, HALF_HEIGHT);
        q = q.clamp(Vec2::splat(-4.0), Vec2::splat(4.0));
    }
    q
}

/// Azimuth and elevation at `t` (0 centre, 1 edge of the opening) in the visor's own direction `phi`, counter-clockwise seen
/// from the front, 0 at the wearer's left.
pub fn visor_angles(phi: f32, t: f32) -> Vec2 {
    let (s, c) = phi.sin_cos();
    let r = t / (c.abs().powf(POWER) + s.abs().powf(POWER)).powf(1.0 / POWER);
    from_visor(Vec2::new(r * c, r * s))
}

/// How far out a direction lies in the visor's opening: 0 at the centre, 1 on its edge, more outside.
pub fn visor_extent(d: Vec3) -> f32 {
    let a = angles(d);
    if a.x.abs() > 2.2 {
        return 4.0;
    }
    let q = to_visor(a).abs();
    (q.x.powf(POWER) + q.y.powf(POWER)).powf(1.0 / POWER)
}

/// Height above the plane of the neck's opening, metres; the shell ends where it is 0. Lower at the chin than at the nape.
pub fn above_neck(p: Vec3) -> f32 {
    p.y + 0.118 + 0.10 * p.z
}

/// The direction of the neck's edge at an azimuth, by bisection.
pub fn neck_edge(azimuth: f32) -> Vec3 {
    let (mut low, mut high) = (-1.45f32, 0.0f32);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if above_neck(on_shell(direction(azimuth, middle))) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    direction(azimuth, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visor_coordinates_invert() {
        for i in 0..=20 {
            for j in 0..=20 {
                let q = Vec2::new(i as f32 / 10.0 - 1.0, j as f32 / 10.0 - 1.0) * 1.1;
                assert!(to_visor(from_visor(q)).distance(q) < 2e-3, "{q}");
            }
        }
    }

    #[test]
    fn the_opening_has_extent_one() {
        for i in 0..64 {
            let a = visor_angles(i as f32 * 0.1, 1.0);
            let e = visor_extent(direction(a.x, a.y));
            assert!((e - 1.0).abs() < 5e-3, "{e}");
        }
    }

    #[test]
    fn the_neck_edge_lies_on_the_plane() {
        for i in 0..64 {
            let p = on_shell(neck_edge(i as f32 * 0.1));
            assert!(above_neck(p).abs() < 1e-5, "{p}");
        }
    }

    #[test]
    fn the_radius_of_an_offset_ellipsoid_satisfies_its_equation() {
        let (c, axes) = (Vec3::new(0.0, -0.05, 0.03), Vec3::new(0.09, 0.10, 0.12));
        for i in 0..40 {
            let d = direction(i as f32 * 0.7, (i as f32 * 0.37).sin());
            let p = (d * offset_ellipsoid(d, c, axes) - c) / axes;
            assert!((p.length() - 1.0).abs() < 1e-5);
        }
    }
}
