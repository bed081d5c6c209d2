//! Powers and logarithms, near one too.

use super::{polynomial, round_small};

/// 2ˣ. Relative error < 2e-7 where the result is a normal number; overflows to infinity, underflows to zero.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    const C: [f32; 7] = [
        1.0,
        0.6931472067028329,
        0.24022650922289554,
        0.05550327226669895,
        0.00961805667843204,
        0.0013400428177711937,
        0.00015461444724808513,
    ];
    if x >= 128.0 {
        return f32::INFINITY;
    }
    // Also taken by numbers whose power would be subnormal.
    if x < -126.0 {
        return 0.0;
    }
    let (rounded, n) = round_small(x);
    // n is in −126..=128, and 128 needs two steps. A NaN stays in the polynomial, whatever n it gives.
    let n = n.clamp(-126, 128);
    let half = n >> 1;
    polynomial(x - rounded, &C) * power_of_two(half) * power_of_two(n - half)
}

/// eˣ. Relative error < 2e-7 + 1e-7·|x|, from the rounding of x·log₂e; see [`exp2`].
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    exp2(x * core::f32::consts::LOG2_E)
}

/// The natural logarithm of a positive number. Absolute error < 2e-7 + 1.2e-7·|ln x|. Zero gives −∞, negative NaN.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    const C: [f32; 4] = [1.999999998631318, 0.6666681533814921, 0.3997485051797189, 0.29924390466272843];
    // Also taken by NaN and infinity, which are their own logarithms.
    if !(x > 0.0 && x < f32::INFINITY) {
        return if x == 0.0 {
            f32::NEG_INFINITY
        } else if x < 0.0 {
            f32::NAN
        } else {
            x
        };
    }
    // Subnormal numbers are scaled into the normal range first.
    let (x, bias) = if x < f32::MIN_POSITIVE { (x * 16777216.0, -24) } else { (x, 0) };
    // x = 2ⁿ·m with m in √½..√2: the offset is the bit pattern of √½.
    let bits = x.to_bits();
    let n = ((bits.wrapping_sub(0x3f35_04f3)) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((n as u32) << 23));
    let z = (m - 1.0) / (m + 1.0);
    (n + bias) as f32 * core::f32::consts::LN_2 + z * polynomial(z * z, &C)
}

/// ln(1 + x) for x ≥ −1, with its digits kept for small x. Relative error < 4e-7. −1 gives −∞, less NaN.
#[inline(always)]
pub fn ln_1p(x: f32) -> f32 {
    let u = 1.0 + x;
    if u == 1.0 {
        return x;
    }
    // `ln u` belongs to the rounded sum; the ratio x / (u − 1) takes the rounding out again (Kahan; Higham 2002, "Accuracy
    // and Stability of Numerical Algorithms", section 1.14.1). Where the sum is 0 or infinite nothing is to be mended.
    let l = ln(u);
    if l.is_finite() { l * (x / (u - 1.0)) } else { l }
}

/// 1 − e⁻ˣ, with the digits of a small x kept. Relative error < 4e-7 for x > −20; beyond as of [`exp`].
#[inline(always)]
pub fn one_minus_exp_neg(x: f32) -> f32 {
    if x.abs() < 0.5 {
        // Taylor: the first term left out is x⁷/8! of the first, < 2e-7.
        let c = [1.0, -1.0 / 2.0, 1.0 / 6.0, -1.0 / 24.0, 1.0 / 120.0, -1.0 / 720.0, 1.0 / 5040.0];
        return x * polynomial(x, &c);
    }
    1.0 - exp(-x)
}

/// 2ⁿ for n in −126..=127.
#[inline(always)]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tests::worst;

    #[test]
    fn small_numbers_keep_their_digits() {
        let n = 200_000;
        // Logarithmic inputs, both signs: small numbers keep their digits.
        let small = |t: f32| (t as f64).exp2() as f32;
        for sign in [1.0, -1.0] {
            let e = worst((-40.0, -1.3), n, |t| {
                let x = sign * small(t);
                (ln_1p(x) as f64 / (x as f64).ln_1p() - 1.0).abs()
            });
            println!("ln_1p {e:.2e}");
            assert!(e < 4e-7);
            let e = worst((-40.0, 4.3), n, |t| {
                let x = sign * small(t);
                (one_minus_exp_neg(x) as f64 / -(-(x as f64)).exp_m1() - 1.0).abs()
                    / (4e-7 + 1e-7 * x.abs() as f64)
            });
            println!("1 − exp(−x) {e:.2} of the bound");
            assert!(e < 1.0);
        }
    }

    #[test]
    fn ln_1p_keeps_small_digits() {
        let e = worst((-30.0, 20.0), 1_000_000, |t| {
            // Both signs, from 1e-9 to 1e6.
            let x =
                if t < 0.0 { -((t as f64).exp2() as f32) } else { ((1.5 * t - 30.0) as f64).exp2() as f32 };
            let x = if t < -0.001 && x > -1.0 { x } else { x.abs() };
            (ln_1p(x) as f64 / (x as f64).ln_1p() - 1.0).abs()
        });
        println!("ln_1p {e:.2e}");
        assert!(e < 4e-7);
        assert_eq!((ln_1p(0.0), ln_1p(-1.0), ln_1p(f32::INFINITY)), (0.0, f32::NEG_INFINITY, f32::INFINITY));
        assert!(ln_1p(-1.5).is_nan() && ln_1p(f32::NAN).is_nan());
    }
}
