//! The reflectance table as formulas, for machines where a texture costs more than arithmetic.
//!
//! All approximate [`crate::Dfg`]: albedo = F0 · scale + F90 · bias of height-correlated Smith GGX. Errors of that albedo, over
//! the middles of 64 × 64 cells of roughness 0..1 × N·V 0..1 (`cargo run --release -p etendue-ibl --example fit_dfg` prints them):
//!
//! | formula | F0 = 0.04 worst | RMS | F0 = 1 worst | RMS | operations | issue slots |
//! |---|---|---|---|---|---|---|
//! | [`lazarov`] | 0.465 | 0.0507 | 0.436 | 0.124 | 10 | 13 |
//! | [`karis`] | 0.084 | 0.0228 | 0.508 | 0.135 | 11 | 14 |
//! | [`ours_cheap`] | 0.054 | 0.0158 | 0.050 | 0.0160 | 11 | 14 |
//! | [`ours`] | 0.0085 | 0.0019 | 0.0090 | 0.0027 | 30 | 36 |
//!
//! An operation is a multiplication, addition or both at once, a minimum, a power of two, root or reciprocal (a division is a reciprocal and a
//! multiplication); the latter three take four issue slots. Clamping the inputs is not counted.
//!
//! Both of ours lie on the frontier of cost against error in `fit_dfg/frontier.txt` (`--plot` draws it), which the example's search made in
//! several runs; programs of 29 and 30 operations were shortened by hand between them. A search from nothing need not end there. Worst errors below 0.01
//! with RMS below 0.003 at both F0 take 30 operations there, nearly three times Karis'; at twice his, 22, the best that was found has 0.016
//! and 0.005.

use crate::dfg::Dfg;

/// Operations and issue slots of [`lazarov`].
pub const LAZAROV_COST: [usize; 2] = [10, 13];
/// Operations and issue slots of [`karis`].
pub const KARIS_COST: [usize; 2] = [11, 14];
/// Operations and issue slots of [`ours_cheap`].
pub const OURS_CHEAP_COST: [usize; 2] = [11, 14];
/// Operations and issue slots of [`ours`].
pub const OURS_COST: [usize; 2] = [30, 36];

/// Lazarov 2013, "Getting More Physical in Call of Duty: Black Ops II" (course notes "Physically Based Shading in Theory and Practice"), with
/// gloss = 1 − roughness as shaders that quote it have it.
///
/// It was fitted to normalised Blinn-Phong with another visibility term and another scale of gloss, and at F0 = 1 it is the reflection of a surface
/// that loses up to a quarter of the light; for a GGX surface it is a historical form.
pub fn lazarov(roughness: f32, cos: f32) -> Dfg {
    let (r, cos) = inputs(roughness, cos);
    let g = 1.0 - r;
    let x = g / 0.96;
    let z = g * (0.0275 - 0.25 * 0.04) / 0.96 + (0.015 - 0.75 * 0.04) / 0.96;
    let bias = x * (0.475 * g).min(f32::exp2(-9.28 * cos)) + z;
    Dfg { scale: 0.25 * g + 0.75 - bias, bias }
}

/// Karis 2014, "Physically Based Shading on Mobile": Lazarov's form fitted to Unreal's GGX.
pub fn karis(roughness: f32, cos: f32) -> Dfg {
    let (r, cos) = inputs(roughness, cos);
    let [x, y, z, w] = [1.0 - r, 0.0425 - 0.0275 * r, 1.04 - 0.572 * r, 0.022 * r - 0.04];
    let a = (x * x).min(f32::exp2(-9.28 * cos)) * x + y;
    Dfg { scale: z - 1.04 * a, bias: w + 1.04 * a }
}

/// Our fit to height-correlated Smith GGX at Karis' price: for machines that count every operation.
///
/// With m = N·V and s = r − 0.286066 m,
///
/// ```text
/// B = 2^(s² (c₀ s + c₁) + c₂ m + c₃)
/// E = c₄ + c₅ s − s² (m (c₆ B + c₇) + c₈) − (c₉ − 1) B
/// ```
///
/// A search over programs of operations found it, as [`ours`].
pub fn ours_cheap(roughness: f32, cos: f32) -> Dfg {
    let (r, m) = inputs(roughness, cos);
    let s = r - 0.286066 * m;
    let s2 = s * s;
    let bias = f32::exp2(s2 * (12.9953 * s - 16.2604) - 7.42158 * m - 0.0734779);
    let energy = 1.01258 - 0.180536 * s - s2 * (m * (18.8088 * bias + 1.3659) - 0.156549);
    Dfg { scale: energy - 1.06597 * bias, bias }
}

/// Our fit to height-correlated Smith GGX.
///
/// With m = N·V, r = roughness and α = r²,
///
/// ```text
/// E = c₀ − x f / (m² + y (c₁ + c₂ (m + α (c₃ f − c₄))))
///     x = m (α − c₅ m)      y = (α − c₅ m) (α − c₆ m)      f = c₇ + c₈ x + c₉ y
/// B = b / (m² + α (g² + d₀ b + r (g + d₁ (r + d₂ g²))))
///     g = d₃ α              b = (d₄ − m)⁴ ((d₄ − m) m² + g²)
/// ```
///
/// For small r and m the reflection depends on how m compares with α alone, and has no limit at (0, 0): a rational function of both can follow
/// that, sums of products cannot. For a mirror B is Schlick's (1 − m)⁵ within 1e-2 and E is 1 within 1e-2.
///
/// The example `fit_dfg` found it: programs of operations are changed at random, for E and B apart and then joined, so that they share what they can; their
/// coefficients are fitted by least squares (Levenberg 1944, Marquardt 1963) with weights raised where the error is largest (Lawson 1961), and the best of each
/// cost are kept.
pub fn ours(roughness: f32, cos: f32) -> Dfg {
    let (r, m) = inputs(roughness, cos);
    let (alpha, m2) = (r * r, m * m);
    let a = alpha - 0.0941341 * m;
    let (x, y) = (m * a, a * (alpha - 0.330316 * m));
    let f = 0.194341 + 1.58 * x + 2.10609 * y;
    let energy = 0.990187 - x * f / (m2 + y * (1.23913 + 3.86172 * (m + alpha * (0.0375373 * f - 0.239217))));
    let n = 1.00164 - m;
    let n2 = n * n;
    let g = 2.35558 * alpha;
    let g2 = g * g;
    let b = n2 * n2 * (n * m2 + g2);
    let bias = b / (m2 + alpha * (g2 + 4.96719 * b + r * (g + 6.52417 * (r + 2.8985 * g2))));
    Dfg { scale: energy - bias, bias }
}

/// Clamped to 0..1, NaN to 0; the cosine is kept from the horizon, where 0/0 would stand.
fn inputs(roughness: f32, cos: f32) -> (f32, f32) {
    (roughness.max(0.0).min(1.0), cos.max(1e-4).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;

    /// (worst, RMS) of the albedo at an F0 over random cells, of several formulas.
    fn errors(f0: f32, fits: &[fn(f32, f32) -> Dfg]) -> Vec<(f32, f32)> {
        let mut rng = Rng::new(11);
        let mut sums = vec![(0.0f32, 0.0f32); fits.len()];
        let n = 1500;
        for _ in 0..n {
            // Middles of the cells for which the figures are stated.
            let mut cell = || ((rng.uniform() * 64.0).floor().min(63.0) + 0.5) / 64.0;
            let (r, m) = (cell(), cell());
            let want = Dfg::exact(r, m);
            for (s, fit) in sums.iter_mut().zip(fits) {
                let got = fit(r, m);
                let error = (f0 * (got.scale - want.scale) + got.bias - want.bias).abs();
                *s = (s.0.max(error), s.1 + error * error);
            }
        }
        sums.iter().map(|s| (s.0, (s.1 / n as f32).sqrt())).collect()
    }

    #[test]
    fn ours_is_close_and_karis_is_as_known() {
        for (f0, known) in [(0.04, 0.0228), (1.0, 0.135)] {
            let e = errors(f0, &[ours, karis, lazarov, ours_cheap]);
            println!(
                "F0 {f0}: ours {:?}, Karis {:?}, Lazarov {:?}, ours, cheap {:?}",
                e[0], e[1], e[2], e[3]
            );
            assert!(e[3].0 < 0.056 && e[3].1 < 0.0165, "F0 {f0}: {:?}", e[3]);
            assert!(e[0].0 < 0.01 && e[0].1 < 0.003, "F0 {f0}: {:?}", e[0]);
            assert!((e[1].1 - known).abs() < 0.1 * known, "Karis' RMS {}", e[1].1);
        }
    }

    #[test]
    fn any_input_gives_a_number() {
        for v in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e-5, 0.5, 1.0, 2.0] {
            for w in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e-5, 0.5, 1.0, 2.0] {
                for fit in [ours, ours_cheap, karis, lazarov] {
                    let d = fit(v, w);
                    assert!(d.scale.is_finite() && d.bias.is_finite());
                }
                for d in [ours(v, w), ours_cheap(v, w)] {
                    assert!(d.scale > -0.01 && d.bias >= 0.0 && d.energy() < 1.02, "{v} {w}: {d:?}");
                }
            }
        }
    }
}
