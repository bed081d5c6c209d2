//! Euler's beta function and a Bessel function.

use super::{exp, ln_1p, polynomial};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tests::worst;

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
}
