//! Light that is scattered on its way through a body (`KHR_materials_scatter`).
//!
//! A path flies through a homogeneous medium until it meets the body's border or an event. How far is drawn from the exponential law
//! of one lane, chosen in proportion to what the path carries in it; the value is divided by the density over all lanes (the
//! one-sample model with the balance heuristic: Veach 1997, section 9.2.4; Kutz, Habel, Li, Novák 2017, "Spectral and Decomposition
//! Tracking for Rendering Heterogeneous Volumes", section 3 for the choice by what is carried). So no lane's weight exceeds what
//! all lanes carried together.
//!
//! At an event no light is asked for: the border would hide it. What the path finds afterwards counts fully.

use etendue_bxdf::math::{exp, ln, sin_cos_tau};
use etendue_bxdf::model::Scatter;
use etendue_bxdf::sampling::Frame;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// Events before which a path that has not lost light is never ended by chance.
const PATIENCE: u32 = 1024;
/// The part of the paths that goes on at each event after these: the mean number of further ones is 128.
const GOES_ON: f32 = 1.0 - 1.0 / 128.0;
/// Events after which a path is ended in any case. One in e⁻⁵⁰⁰ paths would have gone on.
const MOST: u32 = 1 << 16;
/// Events before which the light that is left does not end a path.
const FREE: u32 = 4;

/// What becomes of a path on its way to the next border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flight {
    /// Where an event stops it; `None` if it gets to the border.
    pub event: Option<f32>,
    /// What its throughput is multiplied by.
    pub factor: Spectrum,
    /// A uniform number that the choice of the lane has left over.
    pub left: f32,
}

/// Draws the flight over at most `reach` through a medium of an extinction coefficient, by two uniform numbers in 0..1. `carried` is
/// the path's throughput, of which the first `lanes` count. `None` if it carries nothing.
#[inline]
pub(crate) fn fly(
    extinction: Spectrum,
    scatter: &Scatter,
    carried: Spectrum,
    lanes: usize,
    reach: f32,
    [pick, u]: [f32; 2],
) -> Option<Flight> {
    let mut p = [0.0; 4];
    let total: f32 = carried.0[..lanes].iter().sum();
    if !(total > 0.0 && total < f32::INFINITY) {
        return None;
    }
    for i in 0..lanes {
        p[i] = carried[i] / total;
    }
    let (mut lane, mut left) = (0, pick);
    while lane + 1 < lanes && left >= p[lane] {
        left -= p[lane];
        lane += 1;
    }
    let left = if p[lane] > 0.0 { (left / p[lane]).clamp(0.0, 1.0) } else { 0.0 };
    let sigma = extinction[lane];
    let free = if sigma > 0.0 { -ln(1.0 - u) / sigma } else { f32::INFINITY };
    let event = (free < reach).then_some(free);
    let passed = extinction.map(|s| exp(-s * free.min(reach)));
    let mut density = 0.0;
    for i in 0..lanes {
        density += p[i] * passed[i] * if event.is_some() { extinction[i] } else { 1.0 };
    }
    if !(density > 0.0 && density < f32::INFINITY) {
        return None;
    }
    let value = if event.is_some() { passed * extinction * scatter.albedo } else { passed };
    Some(Flight { event, factor: value * (1.0 / density), left })
}

/// A direction after an event for light that travels along `direction` (unit): Henyey, Greenstein 1941, mean cosine `g` of the angle
/// between both, so that g > 0 goes on forward. (The extension writes +2 g v·l for a v that points back to where the path comes
/// from.)
#[inline]
pub(crate) fn scattered(direction: Vec3A, g: f32, u: [f32; 2]) -> Vec3A {
    let cos = if g.abs() < 1e-3 {
        // To first order in g, where the formula would divide by it.
        let z = 1.0 - 2.0 * u[0];
        z + 1.5 * g * (1.0 - z * z)
    } else {
        let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[0]);
        (1.0 + g * g - s * s) / (2.0 * g)
    };
    let cos = cos.clamp(-1.0, 1.0);
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let (y, x) = sin_cos_tau(u[1]);
    let f = Frame::from_normal(direction);
    f.to_world(vec3a(sin * x, sin * y, cos)).normalize()
}

/// Probability that a path goes on after its event of number `event` (from 0) that still carries `worth`, in units of what it began
/// with.
#[inline]
pub(crate) fn survival(event: u32, worth: f32) -> f32 {
    let by_worth = if event < FREE { 1.0 } else { worth.min(1.0) };
    match event {
        MOST.. => 0.0,
        PATIENCE.. => by_worth * GOES_ON,
        _ => by_worth,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    /// In each lane the unscattered part is exp(−σ x) and the scattered one its complement times the albedo, whatever the path
    /// carries in the others.
    #[test]
    fn the_unscattered_part_falls_exponentially() {
        let extinction = Spectrum([0.5, 2.0, 0.0, 9.0]);
        let scatter = Scatter { albedo: Spectrum([0.9, 0.5, 0.2, 0.7]), anisotropy: 0.0 };
        for carried in [Spectrum::ONE, Spectrum([0.1, 1.0, 0.5, 0.0])] {
            for reach in [0.2, 1.0, 4.0] {
                let (mut through, mut stopped) = ([0.0f64; 3], [0.0f64; 3]);
                let n = 1 << 16;
                for i in 0..n {
                    let [a, b, ..] = Sampler::new(1, 0, 0, i).get4(0);
                    let f = fly(extinction, &scatter, carried, 3, reach, [a, b]).expect("it carries light");
                    let sum = if f.event.is_some() { &mut stopped } else { &mut through };
                    (0..3).for_each(|k| sum[k] += f64::from(f.factor[k]) / f64::from(n));
                    let most = carried.0[..3].iter().sum::<f32>() * 1.0001;
                    (0..3).for_each(|k| assert!(f.factor[k] * carried[k] <= most, "{f:?}"));
                }
                for k in 0..3 {
                    let t = f64::from((-extinction[k] * reach).exp());
                    assert!((through[k] - t).abs() < 3e-3, "{k} {reach}: {} {t}", through[k]);
                    let s = (1.0 - t) * f64::from(scatter.albedo[k]);
                    assert!((stopped[k] - s).abs() < 3e-3, "{k} {reach}: {} {s}", stopped[k]);
                }
            }
        }
    }

    /// Directions follow Henyey and Greenstein's law: the mean cosine is g, and the mean of P₂ is g².
    #[test]
    fn directions_have_their_mean_cosine() {
        let along = Vec3A::new(0.6, 0.0, 0.8);
        for g in [-0.9, -0.5, 0.0, 5e-4, 0.3, 0.7, 0.99] {
            let (mut first, mut second) = (0.0f64, 0.0f64);
            let n = 1 << 14;
            for i in 0..n {
                let [a, b, ..] = Sampler::new(1, 0, 0, i).get4(0);
                let w = scattered(along, g, [a, b]);
                assert!((w.length() - 1.0).abs() < 1e-5);
                let c = f64::from(w.dot(along));
                first += c / f64::from(n);
                second += (1.5 * c * c - 0.5) / f64::from(n);
            }
            let g = f64::from(g);
            assert!((first - g).abs() < 2e-3 && (second - g * g).abs() < 3e-3, "{g}: {first} {second}");
        }
    }
}
