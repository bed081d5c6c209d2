//! Elementary functions with the same bits on each platform.
//!
//! The standard library's `sin`, `atan2`, `exp` and their like call whatever mathematics library the platform has, and
//! differ between platforms in the last bits; a picture that must come out bit-identical everywhere cannot use them.
//! These are made of IEEE additions, multiplications, divisions and square roots only, never fused, and are faster
//! than the libraries' because they promise less: the errors stated here are measured over dense sets of inputs by
//! the tests below. The polynomials are Taylor series or Chebyshev interpolants made for this file.

/// sin and cos of 2π·`turns`, in that order.
///
/// Absolute error < 1.2e-7 for `turns` in −1..1, the argument's own rounding aside. For ±2²⁰ turns
/// or less; beyond, the result means nothing and may be NaN.
#[inline(always)]
pub fn sin_cos_tau(turns: f32) -> (f32, f32) {
    // Reduce to an eighth of a turn around the nearest quarter; `turns − q/4` is exact.
    let (q, quarter) = round_small(4.0 * turns);
    let x = (turns - 0.25 * q) * core::f32::consts::TAU;
    let x2 = x * x;
    // Taylor, |x| ≤ π/4: the first terms left out are x¹¹/11! < 1.8e-9 and x¹⁰/10! < 2.5e-8.
    let s = x + x * x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0))));
    let c = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    // Turn back by q quarters.
    let (a, b) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
    let flip_sin = (quarter & 2) != 0;
    let flip_cos = ((quarter + 1) & 2) != 0;
    (if flip_sin { -a } else { a }, if flip_cos { -b } else { b })
}

/// The angle of the point (`x`, `y`) in turns, −½..½: `atan2(y, x) / 2π`.
///
/// Absolute error < 4e-8 turns. The signs of zeros are honoured as by `f32::atan2`; (0, 0) gives 0 or ±½.
#[inline(always)]
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (lo, hi) = if ay > ax { (ax, ay) } else { (ay, ax) };
    // Both infinite stand for a diagonal.
    let r = if hi == 0.0 {
        0.0
    } else if lo == f32::INFINITY {
        1.0
    } else {
        lo / hi
    };
    const C: [f32; 9] = [
        0.15915494019346965,
        -0.05305117560544708,
        0.03181805255060914,
        -0.022596496997066638,
        0.01689966173539779,
        -0.01186795303565866,
        0.006706411061980181,
        -0.0025037060450704275,
        0.0004402676898618641,
    ];
    let a = r * polynomial(r * r, &C);
    let a = if ay > ax { 0.25 - a } else { a };
    let a = if x.is_sign_negative() { 0.5 - a } else { a };
    a.copysign(y)
}

/// The arc sine in radians, for `x` clamped to −1..1. Absolute error < 2.5e-7.
#[inline(always)]
pub fn asin(x: f32) -> f32 {
    const C: [f32; 6] = [
        0.9999999959837371,
        0.1666678200578292,
        0.07494696687290091,
        0.045520635640071326,
        0.02399399963663503,
        0.04241737376044815,
    ];
    let a = x.abs().min(1.0);
    // asin a = π/2 − 2 asin √((1−a)/2) brings the upper half into the range of the polynomial.
    let upper = a > 0.5;
    let t = if upper { 0.5 * (1.0 - a) } else { a * a };
    let r = if upper { t.sqrt() } else { a };
    let p = r * polynomial(t, &C);
    let p = if upper { core::f32::consts::FRAC_PI_2 - 2.0 * p } else { p };
    p.copysign(x)
}

/// The arc cosine in radians, for `x` clamped to −1..1. Absolute error < 4e-7.
#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let a = x.abs().min(1.0);
    let p = if a > 0.5 {
        // Directly from the half angle: keeps its digits near x = 1.
        2.0 * asin((0.5 * (1.0 - a)).sqrt())
    } else {
        core::f32::consts::FRAC_PI_2 - asin(a)
    };
    if x.is_sign_negative() { core::f32::consts::PI - p } else { p }
}

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

/// Euler's beta function B(x, y) = Γ(x) Γ(y) / Γ(x + y) for x, y ≥ 1 (raised to 1 otherwise, NaN too).
///
/// Stirling's formula with its remainder as a polynomial, and the powers as (x/(x+y))ˣ, so that nothing cancels for
/// large arguments. Relative error < 2e-6 · (1 + |ln B|) wherever B > 1e-30.
#[inline(always)]
pub fn beta(x: f32, y: f32) -> f32 {
    // ln Γ(x) − ((x − ½) ln x − x + ½ ln 2π) as a function of 1/x.
    #[inline(always)]
    fn remainder(inv: f32) -> f32 {
        const C: [f32; 7] = [
            0.083_333_336,
            -1.822_395_6e-7,
            -0.002_772_524_6,
            -5.343_459_4e-5,
            0.001_049_638_1,
            -0.000_633_678_7,
            0.000_138_317_74,
        ];
        inv * polynomial(inv, &C)
    }
    let (x, y) = (x.max(1.0).min(1e30), y.max(1.0).min(1e30));
    let (inv_x, inv_y) = (1.0 / x, 1.0 / y);
    let inv_sum = 1.0 / (x + y);
    let powers = x * ln_1p(y * inv_x) + y * ln_1p(x * inv_y);
    let rest = remainder(inv_x) + remainder(inv_y) - remainder(inv_sum);
    // √(2π (x + y) / (x y)).
    (core::f32::consts::TAU * (inv_x + inv_y)).sqrt() * exp(rest - powers)
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

/// e^{−x} I0(x) for x ≥ 0, I0 the modified Bessel function of order zero. Relative error < 8e-7.
///
/// Abramowitz, Stegun 1964, 9.8.1 and 9.8.2.
#[inline(always)]
pub fn bessel_i0_scaled(x: f32) -> f32 {
    const LOW: [f32; 7] = [1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813];
    const HIGH: [f32; 9] = [
        0.39894228,
        0.01328592,
        0.00225319,
        -0.00157565,
        0.00916281,
        -0.02057706,
        0.02635537,
        -0.01647633,
        0.00392377,
    ];
    if x < 3.75 {
        let t = x * (1.0 / 3.75);
        polynomial(t * t, &LOW) * exp(-x)
    } else {
        polynomial(3.75 / x, &HIGH) / x.sqrt()
    }
}

/// The nearest integer to |x| < 2²².
#[inline(always)]
pub(crate) fn nearest_integer(x: f32) -> f32 {
    round_small(x).0
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

/// The scaled complement of the error function, e^(x²) erfc(x), for x ≥ 0: 1 at 0, and 1/(x√π) far out.
///
/// Relative error < 5e-7. Negative x count as 0.
#[inline(always)]
pub fn erfcx(x: f32) -> f32 {
    const C: [f32; 10] = [
        0.19746634463238044,
        0.19746869313182458,
        0.18527779348473533,
        0.16262284486680012,
        0.11601026452945021,
        0.136111564976872,
        -0.07730707233381154,
        0.21088941385239449,
        -0.16791976285329904,
        0.039379868231328115,
    ];
    let t = 1.0 / (1.0 + 0.35 * x.max(0.0));
    t * polynomial(t, &C)
}

/// The error function, 2/√π ∫₀ˣ exp(−t²) dt. Absolute error < 2e-7.
#[inline(always)]
pub fn erf(x: f32) -> f32 {
    const C: [f32; 6] = [
        1.1283791225448065,
        -0.37612326283475295,
        0.11280180633098805,
        -0.026711322828066403,
        0.004917562601036485,
        -0.0005631461739232374,
    ];
    let a = x.abs();
    let r = if a < 1.0 { a * polynomial(a * a, &C) } else { 1.0 - exp(-a * a) * erfcx(a) };
    r.copysign(x)
}

/// The inverse of [`erf`] on −1..1; ±1 and beyond give ±3.96 (the inverse of the largest `f32` below 1), NaN stays.
///
/// Relative error < 1e-6.
#[inline(always)]
pub fn erf_inv(x: f32) -> f32 {
    const LOW: [f32; 9] = [
        1.5014094215766653,
        0.24664072611445392,
        -0.00417770774586077,
        -0.0012537075073659038,
        0.00021860219390217386,
        -4.3967835935705e-06,
        -3.5288591842541628e-06,
        3.437272537709646e-07,
        2.853472860775419e-08,
    ];
    const HIGH: [f32; 8] = [
        2.832977454496,
        1.0016798627873316,
        0.009421282138946996,
        -0.007697932258445367,
        0.005846143629182787,
        -0.003437277080653032,
        0.0011027458458029438,
        -0.00010899886331226794,
    ];
    let x = x.clamp(-1.0 + 0.5 * f32::EPSILON, 1.0 - 0.5 * f32::EPSILON);
    // In w = −ln(1 − x²) the function is nearly straight at first, in √w far out (Giles 2010, "Approximating the erfinv
    // function"; the polynomials are made for this file).
    let w = -ln_1p(-x * x).min(0.0);
    let w = if x.abs() > 0.9 { -ln((1.0 - x) * (1.0 + x)) } else { w };
    if w < 5.0 { x * polynomial(w - 2.5, &LOW) } else { x * polynomial(w.sqrt() - 3.0, &HIGH) }
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

/// 2ⁿ for n in −126..=127.
#[inline(always)]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) as u32) << 23)
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
    fn worst(range: (f64, f64), n: usize, error: impl Fn(f32) -> f64) -> f64 {
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
    fn errors_of_the_error_functions_are_as_documented() {
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
        // erf by its Taylor series in f64, erfcx by the continued fraction (Abramowitz, Stegun 7.1.14) beyond 2.
        let erf64 = |x: f64| {
            let (mut term, mut sum) = (x, x);
            for k in 1..200 {
                term *= -x * x / k as f64;
                sum += term / (2 * k + 1) as f64;
            }
            sum * core::f64::consts::FRAC_2_SQRT_PI
        };
        let erfcx64 = |x: f64| {
            if x < 2.0 {
                return (x * x).exp() * (1.0 - erf64(x));
            }
            let mut f = x;
            for k in (1..200).rev() {
                f = x + 0.5 * k as f64 / f;
            }
            0.5 * core::f64::consts::FRAC_2_SQRT_PI / f
        };
        let e = worst((-10.0, 14.0), 20_000, |t| {
            let x = small(t);
            (erfcx(x) as f64 / erfcx64(x as f64) - 1.0).abs()
        });
        println!("erfcx {e:.2e}");
        assert!(e < 5e-7);
        let e = worst((-3.5, 3.5), 20_000, |x| (erf(x) as f64 - erf64(x as f64)).abs());
        println!("erf {e:.2e}");
        assert!(e < 2e-7);
        let e = worst((-3.5, 3.5), 20_000, |x| {
            let y = erf64(x as f64) as f32;
            // What the rounding of y itself does to its inverse is not this function's error.
            let slope = core::f64::consts::FRAC_2_SQRT_PI * (-(x as f64).powi(2)).exp();
            let mut want = x as f64;
            for _ in 0..3 {
                want += (y as f64 - erf64(want)) / slope;
            }
            if want == 0.0 { 0.0 } else { (erf_inv(y) as f64 / want - 1.0).abs() }
        });
        println!("erf_inv {e:.2e}");
        assert!(e < 1e-6);
        assert!(erf_inv(1.0) < 4.0 && erf_inv(-7.0) > -4.0 && erf_inv(f32::NAN).is_nan());
        assert!(erf(f32::INFINITY) == 1.0 && erfcx(f32::INFINITY) == 0.0);
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

    #[test]
    fn beta_meets_the_gamma_function() {
        let mut worst = 0.0f64;
        for i in 0..200 {
            for j in 0..200 {
                // 1 .. 1e6, denser near 1.
                let x = (1.0 + (0.07 * i as f64).exp_m1()) as f32;
                let y = (1.0 + (0.07 * j as f64).exp_m1()) as f32;
                let (a, b) = (x as f64, y as f64);
                use crate::laws::gamma::ln_gamma;
                let want = ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
                if want > -69.0 {
                    let error = (beta(x, y) as f64 / want.exp() - 1.0).abs() / (1.0 - want);
                    worst = worst.max(error);
                }
            }
        }
        println!("beta {worst:.2e}");
        assert!(worst < 2e-6);
        assert!((beta(1.0, 1.0) - 1.0).abs() < 1e-6 && (beta(2.0, 2.0) - 1.0 / 6.0).abs() < 1e-6);
        assert_eq!(beta(f32::NAN, 0.0), beta(1.0, 1.0));
        assert_eq!(beta(1e20, 1e20), 0.0);
    }

    #[test]
    fn bessel_meets_its_series() {
        let e = worst((0.0, 1.0), 20_000, |t| {
            // 0 to 400, denser below; I0 = Σ (x²/4)ᵏ / k!², all terms positive.
            let x = 400.0 * t * t;
            let (q, mut term, mut sum) = (0.25 * x as f64 * x as f64, 1.0f64, 1.0f64);
            for k in 1..600 {
                term *= q / (k * k) as f64;
                sum += term;
            }
            (bessel_i0_scaled(x) as f64 / (sum * (-x as f64).exp()) - 1.0).abs()
        });
        println!("I0 {e:.2e}");
        assert!(e < 8e-7);
        assert!(bessel_i0_scaled(f32::MAX) > 0.0 && bessel_i0_scaled(f32::NAN).is_nan());
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
