//! The error function, its complement and its inverse.

use super::{exp, ln, ln_1p, polynomial};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tests::worst;

    #[test]
    fn errors_of_the_error_functions_are_as_documented() {
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
            let x = (t as f64).exp2() as f32;
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
}
