//! Helmholtz reciprocity: light that travels a path backwards is scattered as much.
//!
//! For reflection f(a, b) = f(b, a). Across an interface radiance is reciprocal only after division by the squared index
//! of the side that it goes to (Veach 1997, "Robust Monte Carlo Methods for Light Transport Simulation", eq. 5.14):
//!
//! ```text
//! f(wi → wo) / n_o² = f(wo → wi) / n_i²      so      f_near(wo, wi) η² = f_far(wi, wo),   η = n_far / n_near
//! ```
//!
//! and for the adjoint (power, [`crate::model::Transport::Importance`]) by that of the side that it comes from, which
//! turns η² into 1/η².

use super::Rng;
use crate::{bsdf::Bsdf, model::Transport, reflectance::from_behind, sampling::uniform_hemisphere};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The largest violation, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reciprocity {
    /// |f(a, b) − f(b, a)| / (larger of the two + 1e-6), the largest over pairs and lanes. The 1e-6 per steradian is for
    /// pairs at borders, where rounding decides whether a vanishing value is there at all.
    pub error: f64,
    /// The two directions, both in the frame of the near side.
    pub pair: [Vec3A; 2],
}

/// Compares `pairs` pairs of directions on the side of `wo`.
///
/// Half the pairs are even over the hemisphere; half are a direction and a sample from it, which is where tight lobes are.
pub fn reciprocity<B: Bsdf + ?Sized>(bsdf: &B, pairs: usize, seed: u64) -> Reciprocity {
    over(bsdf, pairs, seed, |_, b| b.z > 0.0, |b| b, |a, b| (bsdf.eval(a, b), bsdf.eval(b, a)))
}

/// The same for light that passes: `near` and `far` are closures of the same point for `wo` on either side, both made for
/// `transport`. Nothing is compared if [`Bsdf::refraction`] of `near` is `None`.
///
/// Pairs within 0.02 of the border of total reflection, wo·wi = −min(η, 1/η), are left out: the transmittance there is
/// proportional to a cosine that `f32` gives from the one side exactly and from the other as √(1 − sin²), 4e-4 of itself
/// off at that distance.
pub fn reciprocity_through<B: Bsdf + ?Sized>(
    near: &B,
    far: &B,
    transport: Transport,
    pairs: usize,
    seed: u64,
) -> Reciprocity {
    let Some(eta) = near.refraction() else { return Reciprocity { error: 0.0, pair: [Vec3A::Z; 2] } };
    let scale = match transport {
        Transport::Radiance => eta * eta,
        Transport::Importance => 1.0 / (eta * eta),
    };
    over(
        near,
        pairs,
        seed,
        |a, b| b.z < 0.0 && (eta == 1.0 || (a.dot(b) + eta.min(1.0 / eta)).abs() > 0.02),
        |b| -b,
        |a, b| (near.eval(a, b) * scale, far.eval(from_behind(b), from_behind(a))),
    )
}

/// `counts` says whether a pair is to be compared and `turn` brings an upper direction to the side in question.
fn over<B: Bsdf + ?Sized>(
    bsdf: &B,
    pairs: usize,
    seed: u64,
    counts: impl Fn(Vec3A, Vec3A) -> bool,
    turn: impl Fn(Vec3A) -> Vec3A,
    values: impl Fn(Vec3A, Vec3A) -> (Spectrum, Spectrum),
) -> Reciprocity {
    let mut rng = Rng::new(seed);
    let mut worst = Reciprocity { error: 0.0, pair: [Vec3A::Z; 2] };
    for i in 0..pairs {
        let a = uniform_hemisphere(rng.square());
        let b = if i % 2 == 0 {
            turn(uniform_hemisphere(rng.square()))
        } else {
            match bsdf.sample(a, rng.uniform(), rng.square()) {
                Some(s) if !s.delta => s.wi,
                _ => continue,
            }
        };
        if !counts(a, b) {
            continue;
        }
        let (f, g) = values(a, b);
        for lane in 0..4 {
            let (f, g) = (f[lane] as f64, g[lane] as f64);
            let larger = f.abs().max(g.abs());
            let error = (f - g).abs() / (larger + 1e-6);
            // Not a number counts as the worst.
            if !(error <= worst.error) {
                worst = Reciprocity { error, pair: [a, b] };
            }
        }
    }
    worst
}
