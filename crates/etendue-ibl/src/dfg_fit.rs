//! The reflectance table as formulas, for machines where a texture costs more than arithmetic.
//!
//! All approximate [`crate::Dfg`]: albedo = F0 · scale + F90 · bias of height-correlated Smith GGX. Errors of that albedo, over
//! the middles of 64 × 64 cells of roughness 0..1 × N·V 0..1 (`cargo run --release -p etendue-ibl --example fit_dfg` prints them):
//!
//! | formula | F0 = 0.04 worst | RMS | F0 = 1 worst | RMS | operations |
//! |---|---|---|---|---|---|
//! | [`lazarov`] | 0.465 | 0.0507 | 0.436 | 0.124 | 11 |
//! | [`karis`] | 0.084 | 0.0228 | 0.508 | 0.135 | 11 |
//! | [`ours`] | 0.0086 | 0.0028 | 0.0094 | 0.0030 | 33 |
//!
//! An operation is a multiplication, addition or both at once, a minimum, a power of two, or a division.

use crate::dfg::Dfg;

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

/// Our fit to height-correlated Smith GGX.
///
/// With m = N·V, raised to 1/128, and r = roughness,
///
/// ```text
/// 1 − E = m r³ (c₀ + c₁ r⁴ + c₂ m r³) / (r⁵ (1 + c₃ m) + m (c₄ + m (c₅ + c₆ m + c₇ r²)))
/// B = (1 − m)⁵ (m (d₀ m + d₁ r) + r² (d₂ + d₃ r + d₄ r²)) / (m² + r³ (d₅ + d₆ r + d₇ r²))
/// ```
///
/// Both are exact for a mirror (E = 1) or nearly so (B). For small r and m the reflection depends on how m compares with r² alone, and
/// has no limit at (0, 0): a rational function of both can follow that, sums of products cannot. Which powers serve was searched for by
/// exchange of terms, and their coefficients were found by iterated linear least squares with weights raised where the error is
/// largest (Sanathanan, Koerner 1963; Lawson 1961): the example `fit_dfg` does both. Within half a degree of the horizon (m < 1/128)
/// the value at 1/128 stands, which is up to 0.1 off for roughness below 0.1.
pub fn ours(roughness: f32, cos: f32) -> Dfg {
    const C: [f32; 8] = [0.19234, 3.77207, 1.95373, 7.04718, -0.00044, 0.10865, 0.86027, -0.62335];
    const D: [f32; 8] = [0.98694, 0.01090, 0.00250, 0.84379, -0.52136, 1.00877, -0.58293, 8.64341];
    let (r, m) = inputs(roughness, cos);
    let m = m.max(1.0 / 128.0);
    let (m2, r2) = (m * m, r * r);
    let r3 = r2 * r;
    let t = m * r3;
    let loss = t * (C[0] + C[1] * (r2 * r2) + C[2] * t)
        / (r2 * r3 * (1.0 + C[3] * m) + m * (C[4] + m * (C[5] + C[6] * m + C[7] * r2)));
    let n = 1.0 - m;
    let n2 = n * n;
    let bias = n2 * n2 * n * (m * (D[0] * m + D[1] * r) + r2 * (D[2] + r * (D[3] + D[4] * r)))
        / (m2 + r3 * (D[5] + r * (D[6] + D[7] * r)));
    Dfg { scale: 1.0 - loss - bias, bias }
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
            let e = errors(f0, &[ours, karis, lazarov]);
            println!("F0 {f0}: ours {:?}, Karis {:?}, Lazarov {:?}", e[0], e[1], e[2]);
            assert!(e[0].0 < 0.01 && e[0].1 < 0.003, "F0 {f0}: {:?}", e[0]);
            assert!((e[1].1 - known).abs() < 0.1 * known, "Karis' RMS {}", e[1].1);
        }
    }

    #[test]
    fn any_input_gives_a_number() {
        for v in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e-5, 0.5, 1.0, 2.0] {
            for w in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e-5, 0.5, 1.0, 2.0] {
                for fit in [ours, karis, lazarov] {
                    let d = fit(v, w);
                    assert!(d.scale.is_finite() && d.bias.is_finite());
                }
                let d = ours(v, w);
                assert!(d.scale > -0.01 && d.bias >= 0.0 && d.energy() < 1.01, "{v} {w}: {d:?}");
            }
        }
    }
}
