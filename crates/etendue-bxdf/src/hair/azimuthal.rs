//! How a fibre spreads light around itself: the lobe Np.

use crate::math::{exp, ln, nearest_integer};
use core::f32::consts::{PI, TAU};

/// Np: a logistic distribution trimmed to −π..π around a path's exit (Chiang, Bitterli, Tappan, Burley 2016, section 4.1).
///
/// ```text
/// Np(x) = e^{−|x|/s} / (s (1 + e^{−|x|/s})²) / tanh(π / 2s)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Azimuthal {
    s: f32,
    /// The untrimmed distribution's part below −π.
    below: f32,
    /// 1 / (s · part within −π..π).
    inv: f32,
}

impl Azimuthal {
    /// Of a scale s > 0, radians.
    pub fn new(s: f32) -> Self {
        let tail = exp(-PI / s);
        let below = tail / (1.0 + tail);
        Self { s, below, inv: 1.0 / (s * (1.0 - 2.0 * below)) }
    }

    /// s, radians.
    pub fn scale(&self) -> f32 {
        self.s
    }

    /// Density per radian at an angle given in turns from the path's exit; any number of turns below 2²⁰.
    #[inline(always)]
    pub fn eval(&self, turns: f32) -> f32 {
        let x = (turns - nearest_integer(turns)).abs() * TAU;
        let e = exp(-x / self.s);
        e / ((1.0 + e) * (1.0 + e)) * self.inv
    }

    /// An angle in turns, −½..½, with that density.
    #[inline(always)]
    pub fn sample(&self, u: f32) -> f32 {
        let u = u.max(0.0).min(1.0);
        let within = 1.0 - 2.0 * self.below;
        // The distribution function and its complement, each with its own digits; neither is zero for `f32`'s sake.
        let low = (self.below + u * within).max(1e-30);
        let high = (self.below + (1.0 - u) * within).max(1e-30);
        ((ln(low) - ln(high)) * (self.s / TAU)).max(-0.5).min(0.5)
    }
}
