//! Elementary functions with the same bits on each platform.
//!
//! The standard library's `sin`, `atan2`, `exp` and their like call whatever mathematics library the platform has, and
//! differ between platforms in the last bits; a picture that must come out bit-identical everywhere cannot use them.
//! These are made of IEEE additions, multiplications, divisions and square roots only, never fused, and are faster
//! than the libraries' because they promise less: the errors stated here are measured over dense sets of inputs by
//! the tests. The polynomials are Taylor series or Chebyshev interpolants made for this crate.

mod error_function;
mod exponential;
mod special;
mod trigonometric;

pub use error_function::{erf, erf_inv, erfcx};
pub use exponential::{exp, exp2, ln, ln_1p, one_minus_exp_neg};
pub use special::{bessel_i0_scaled, beta};
pub use trigonometric::{acos, asin, atan2_turns, sin_cos_tau};

/// The nearest integer to |x| < 2²².
#[inline(always)]
pub(crate) fn nearest_integer(x: f32) -> f32 {
    round_small(x).0
}

/// The nearest integer to |x| < 2²², as a number and as an integer. (`floor` and `round` are calls into a library where
/// the processor's baseline has no instruction for them.)
#[inline(always)]
fn round_small(x: f32) -> (f32, i32) {
    // Above 2²³ the last bit of an `f32` is one: adding 1.5·2²³ rounds, and leaves the integer in the low bits.
    const MAGIC: f32 = 12582912.0;
    let shifted = x + MAGIC;
    (shifted - MAGIC, shifted.to_bits().wrapping_sub(MAGIC.to_bits()) as i32)
}

/// Horner's scheme, lowest coefficient first.
#[inline(always)]
fn polynomial<const N: usize>(x: f32, c: &[f32; N]) -> f32 {
    let mut p = c[N - 1];
    for i in (0..N - 1).rev() {
        p = p * x + c[i];
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest value of `error` over `n` points of `range`.
    pub(super) fn worst(range: (f64, f64), n: usize, error: impl Fn(f32) -> f64) -> f64 {
        (0..=n)
            .map(|i| error((range.0 + (range.1 - range.0) * i as f64 / n as f64) as f32))
            .fold(0.0, |a, b| if b.is_nan() { f64::NAN } else { f64::max(a, b) })
    }

    #[test]
    fn errors_are_as_documented() {
        let n = 1_000_000;
        let turn = |x: f32| x as f64 * core::f64::consts::TAU;
        let sin = worst((-1.0, 1.0), n, |x| (sin_cos_tau(x).0 as f64 - turn(x).sin()).abs());
        let cos = worst((-1.0, 1.0), n, |x| (sin_cos_tau(x).1 as f64 - turn(x).cos()).abs());
        println!("sin {sin:.2e} cos {cos:.2e}");
        assert!(sin < 1.2e-7 && cos < 1.2e-7);
        let atan = worst((-4.0, 4.0), n, |t| {
            let (s, c) = ((t as f64).sin() as f32, (t as f64).cos() as f32);
            (atan2_turns(s, c) as f64 - (s as f64).atan2(c as f64) / core::f64::consts::TAU).abs()
        });
        println!("atan2 {atan:.2e} turns");
        assert!(atan < 4e-8);
        let asin_error = worst((-1.0, 1.0), n, |x| (asin(x) as f64 - (x as f64).asin()).abs());
        let acos_error = worst((-1.0, 1.0), n, |x| (acos(x) as f64 - (x as f64).acos()).abs());
        println!("asin {asin_error:.2e} acos {acos_error:.2e}");
        assert!(asin_error < 2.5e-7 && acos_error < 4e-7);
        let e = worst((-126.0, 127.99), n, |x| (exp2(x) as f64 / (x as f64).exp2() - 1.0).abs());
        println!("exp2 {e:.2e}");
        assert!(e < 2e-7);
        let e = worst((-80.0, 80.0), n, |x| {
            (exp(x) as f64 / (x as f64).exp() - 1.0).abs() / (2e-7 + 1e-7 * x.abs() as f64)
        });
        assert!(e < 1.0);
        let e = worst((-140.0, 127.9), n, |t| {
            let x = (t as f64).exp2() as f32;
            let l = (x as f64).ln();
            (ln(x) as f64 - l).abs() / (2e-7 + 1.2e-7 * l.abs())
        });
        println!("ln {e:.2} of the bound");
        assert!(e < 1.0);
    }

    #[test]
    fn special_values() {
        assert_eq!(sin_cos_tau(0.0), (0.0, 1.0));
        assert_eq!(sin_cos_tau(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_tau(0.5), (0.0, -1.0));
        assert_eq!(sin_cos_tau(-0.25), (-1.0, 0.0));
        assert!(sin_cos_tau(f32::NAN).0.is_nan() && sin_cos_tau(f32::INFINITY).0.is_nan());
        assert_eq!(sin_cos_tau(1e6), (0.0, 1.0));
        assert_eq!(sin_cos_tau(-1048575.75), (1.0, 0.0));
        for (y, x) in
            [(0.0, 1.0), (0.0, -1.0), (-0.0, -1.0), (1.0, 0.0), (-1.0, -0.0), (0.0, 0.0), (-0.0, -0.0)]
        {
            let want = f32::atan2(y, x) / core::f32::consts::TAU;
            assert!((atan2_turns(y, x) - want).abs() < 1e-8, "{y} {x}");
        }
        assert_eq!(atan2_turns(f32::INFINITY, f32::INFINITY), atan2_turns(1.0, 1.0));
        assert_eq!(asin(2.0), asin(1.0));
        assert_eq!(acos(1.0), 0.0);
        assert_eq!((exp2(0.0), exp2(10.0), exp2(-300.0), exp2(500.0)), (1.0, 1024.0, 0.0, f32::INFINITY));
        assert!(exp2(f32::NAN).is_nan() && ln(-1.0).is_nan() && ln(f32::NAN).is_nan());
        assert_eq!((ln(1.0), ln(0.0), ln(f32::INFINITY)), (0.0, f32::NEG_INFINITY, f32::INFINITY));
    }

    /// The bits are part of the promise: a change of a formula is a change of every picture.
    #[test]
    fn bits_are_pinned() {
        let mut hash = 0xcbf2_9ce4_8422_2325u64;
        let mut add = |v: f32| hash = (hash ^ v.to_bits() as u64).wrapping_mul(0x0100_0000_01b3);
        for i in 0..4096 {
            let x = i as f32 / 4096.0;
            let (s, c) = sin_cos_tau(x);
            for v in [s, c, atan2_turns(s, c), asin(s), acos(c), exp2(20.0 * x - 10.0), ln(x + 1e-3)] {
                add(v);
            }
        }
        assert_eq!(hash, 0x0527_ca3e_3156_7a9b, "{hash:#x}");
    }
}
