//! Coordinates of the half vector that measured tables are laid out in.
//!
//! u = √(2θ/π), dense around the normal, and v = (φ + π)/2π, both 0..1: dω = 2π² u sin θ du dv.

use crate::math::{asin, atan2_turns, sin_cos_tau};
use core::f32::consts::{FRAC_2_PI, PI};
use glam::{Vec3A, vec3a};

/// The angle to +Z in radians; its digits are kept near the pole.
#[inline(always)]
pub(super) fn elevation(w: Vec3A) -> f32 {
    2.0 * asin(0.5 * (w - Vec3A::Z).length())
}

/// The angle around +Z in turns, −½..½.
#[inline(always)]
pub(super) fn azimuth(w: Vec3A) -> f32 {
    atan2_turns(w.y, w.x)
}

/// u of an angle to the normal, radians.
#[inline(always)]
pub(super) fn u_of(theta: f32) -> f32 {
    (theta * FRAC_2_PI).max(0.0).sqrt()
}

/// (u, v) of a unit vector, with its azimuth counted from `turns`.
#[inline(always)]
pub(super) fn coordinates(m: Vec3A, turns: f32) -> [f32; 2] {
    let v = azimuth(m) - turns + 0.5;
    [u_of(elevation(m)), v - v.floor()]
}

/// The unit vector at (u, v).
#[inline(always)]
pub(super) fn direction([u, v]: [f32; 2], turns: f32) -> Vec3A {
    let (sin, cos) = sin_cos_tau(0.25 * u * u);
    let (s, c) = sin_cos_tau(v - 0.5 + turns);
    vec3a(c * sin, s * sin, cos)
}

/// dωi / (du dv) for the direction that is the mirror image of `wo` at `m`: 2π² u sin θm · 4 (wo·m).
#[inline(always)]
pub(super) fn jacobian(wo: Vec3A, m: Vec3A, u: f32) -> f32 {
    let sin = (m.x * m.x + m.y * m.y).sqrt();
    (8.0 * PI * PI * u * sin * wo.dot(m)).max(1e-9)
}
