//! Sine and cosine, and their inverses.

use super::{polynomial, round_small};

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
