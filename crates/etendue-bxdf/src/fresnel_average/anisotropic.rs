//! The rules of lobes with two widths, and how much light such lobes return.
//!
//! The table's four axes: √cos θ; the in-plane width relative to the larger, u = (αφ/αmax − b) / (1 − b) with αφ² = αx² cos²φ +
//! αy² sin²φ; the aspect b = αmin/αmax as (1 − x)²; and the root of the roughness that the mean square width has, r⁴ =
//! (αx² + αy²) / 2. Linear between nodes on all of them. Each entry is a rule and √(1 − E).

use super::{NODES, Rule};
use glam::Vec3A;

/// Nodes by √cos θ: at (i / (COSINES − 1))².
pub const COSINES: usize = 20;
/// Nodes by u.
pub const WIDTHS: usize = 6;
/// Nodes by x.
pub const ASPECTS: usize = 6;
/// Nodes by roughness: [`roughness`].
pub const ROWS: usize = 12;
/// Numbers of each entry: the nodes, all weights but the last, √(1 − E).
pub const STRIDE: usize = 2 * NODES;

const ENTRIES: usize = COSINES * WIDTHS * ASPECTS * ROWS;

/// The table's file: entries by roughness, aspect, width, cosine, each number a little-endian 16-bit fraction of 65535.
static BYTES: &[u8; ENTRIES * STRIDE * 2] = include_bytes!("anisotropic.bin");

/// The square root of the first row's roughness.
const FIRST_ROOT: f32 = 0.1;

/// Roughness of row `j`.
pub fn roughness(j: usize) -> f32 {
    let root = FIRST_ROOT + (1.0 - FIRST_ROOT) * j as f32 / (ROWS - 1) as f32;
    root * root
}

/// αmin / αmax of aspect node `k`.
pub fn aspect(k: usize) -> f32 {
    let x = k as f32 / (ASPECTS - 1) as f32;
    (1.0 - x) * (1.0 - x)
}

/// The node below a position on an axis of `n` nodes, and the fraction to the next; `x` in 0..1, NaN as 0.
#[inline(always)]
fn place(x: f32, n: usize) -> (usize, f32) {
    let x = x.max(0.0).min(1.0) * (n - 1) as f32;
    let i = (x as usize).min(n - 2);
    (i, x - i as f32)
}

/// The rules of a lobe: found once for a closure, then asked for directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnisotropicRules {
    ax2: f32,
    ay2: f32,
    inv_max: f32,
    b: f32,
    row: (u16, f32),
    aspect: (u16, f32),
}

impl AnisotropicRules {
    /// α along x and y, clamped to 1e-4..1 (NaN to the lower end).
    #[inline]
    pub fn new(alpha: [f32; 2]) -> Self {
        let [ax, ay] = alpha.map(|a| a.max(1e-4).min(1.0));
        let max = ax.max(ay);
        let b = ax.min(ay) / max;
        let root = (0.5 * (ax * ax + ay * ay)).sqrt().sqrt().sqrt();
        let (j, row) = place((root - FIRST_ROOT) / (1.0 - FIRST_ROOT), ROWS);
        let (k, aspect) = place(1.0 - b.sqrt(), ASPECTS);
        Self {
            ax2: ax * ax,
            ay2: ay * ay,
            inv_max: 1.0 / max,
            b,
            row: (j as u16, row),
            aspect: (k as u16, aspect),
        }
    }

    /// The rule seen from a direction above the surface, and the albedo E of the lobe for F = 1.
    ///
    /// E and averages of dielectric and metallic reflectances are within 1.2e-2 of the integral for cos θ ≥ 0.05 (over
    /// random lobes 8e-3 to 1e-2 at worst, 1e-3 in the mean).
    #[inline]
    pub fn directional(&self, wo: Vec3A) -> (Rule, f32) {
        let sin2 = wo.x * wo.x + wo.y * wo.y;
        let across = if sin2 > 0.0 {
            ((self.ax2 * wo.x * wo.x + self.ay2 * wo.y * wo.y) / sin2).sqrt() * self.inv_max
        } else {
            1.0
        };
        let (u, width) = place((across - self.b) / (1.0 - self.b).max(1e-3), WIDTHS);
        let (i, cosine) = place(wo.z.max(0.0).sqrt(), COSINES);
        let mut out = [0.0f32; STRIDE];
        let weights = |f: f32| [1.0 - f, f];
        for (dr, wr) in weights(self.row.1).into_iter().enumerate() {
            for (da, wa) in weights(self.aspect.1).into_iter().enumerate() {
                for (du, wu) in weights(width).into_iter().enumerate() {
                    let line = ((self.row.0 as usize + dr) * ASPECTS + self.aspect.0 as usize + da) * WIDTHS
                        + u
                        + du;
                    for (dc, wc) in weights(cosine).into_iter().enumerate() {
                        let weight = wr * wa * wu * wc * (1.0 / 65535.0);
                        let at = (line * COSINES + i + dc) * STRIDE * 2;
                        for (k, v) in out.iter_mut().enumerate() {
                            *v += weight
                                * u16::from_le_bytes([BYTES[at + 2 * k], BYTES[at + 2 * k + 1]]) as f32;
                        }
                    }
                }
            }
        }
        let lost = out[STRIDE - 1];
        (Rule::unpacked(|k| out[k]), 1.0 - lost * lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Ggx,
        fresnel::{dielectric, pow5},
        laws::Rng,
        quadrature::{HalfVectorMap, gauss_legendre},
    };
    use glam::vec3a;

    #[test]
    fn rules_meet_the_integral() {
        let mut rng = Rng::new(5);
        let nodes = gauss_legendre(6);
        let mut worst = [0.0f32; 3];
        let (mut sum, mut count) = ([0.0f32; 3], 0.0);
        for _ in 0..150 {
            let (r, a) = (rng.uniform(), rng.uniform());
            let b = 1.0 - 0.95 * a;
            let ax = (r * r * (2.0 / (1.0 + b * b)).sqrt()).min(1.0);
            let ggx = Ggx::new(ax, b * ax);
            let cos = 0.05 + 0.95 * rng.uniform();
            let (s, c) = (core::f32::consts::TAU * rng.uniform()).sin_cos();
            let sin = (1.0 - cos * cos).sqrt();
            let wo = vec3a(sin * c, sin * s, cos);
            let sums = HalfVectorMap::new(wo, ggx.alpha()).integrate_all(&nodes, |wi| {
                if wi.z <= 1e-6 {
                    return [0.0; 4];
                }
                let pair = ggx.pair(wo, wi);
                let f = pair.value * wi.z;
                [f, f * pow5(1.0 - pair.cos_half), f * dielectric(pair.cos_half, 1.5), 0.0]
            });
            let want = [sums[0], sums[1] / sums[0], sums[2] / sums[0]].map(|v| v as f32);
            let (rule, e) = AnisotropicRules::new(ggx.alpha()).directional(wo);
            let mean =
                |f: &dyn Fn(f32) -> f32| -> f32 { (0..NODES).map(|k| rule.weight[k] * f(rule.cos[k])).sum() };
            let got = [e, mean(&|mu| pow5(1.0 - mu)), mean(&|mu| dielectric(mu, 1.5))];
            for k in 0..3 {
                let error = (got[k] - want[k]).abs();
                assert!(error < BOUND, "α {:?} {wo}: {got:?}, {want:?}", ggx.alpha());
                worst[k] = worst[k].max(error);
                sum[k] += error;
            }
            count += 1.0;
        }
        println!("errors of E, W and a dielectric: worst {worst:?}, mean {:?}", sum.map(|s| s / count));
    }

    /// What the documentation of [`AnisotropicRules::directional`] promises.
    const BOUND: f32 = 0.012;

    #[test]
    fn any_input_gives_a_rule() {
        for a in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-3, 1.0] {
            for b in [f32::NAN, -1.0, 0.5, 2.0] {
                for wo in [Vec3A::NAN, Vec3A::Z, Vec3A::X, Vec3A::ZERO, vec3a(0.0, 2.0, -1.0)] {
                    let (rule, e) = AnisotropicRules::new([a, b]).directional(wo);
                    assert!(
                        (0.0..=1.0).contains(&e) && rule.weight.iter().all(|w| (0.0..=1.0).contains(w)),
                        "{a} {b} {wo}"
                    );
                    assert!(rule.cos.iter().all(|c| (0.0..=1.0).contains(c)), "{rule:?}");
                }
            }
        }
    }
}
