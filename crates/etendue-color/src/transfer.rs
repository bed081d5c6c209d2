//! The sRGB transfer functions.
//!
//! IEC 61966-2-1:1999 with Amendment 1 (2003): linear below a knee, a power of 2.4 above it. The knee is where the standard puts it,
//! 0.0031308 in light and 0.04045 in the encoded value; the two branches miss each other there by less than 3e-8.

use std::sync::LazyLock;

/// Encodes linear light as sRGB: `12.92 x` up to 0.0031308, above that `1.055 x^(1/2.4) − 0.055`.
///
/// Values below 0 and above 1 are continued, not clamped: negative ones as the mirror image. NaN stays NaN.
///
/// ```
/// assert!((etendue_color::srgb_encode(0.18) - 0.46135).abs() < 1e-5);
/// ```
#[inline]
pub fn srgb_encode(x: f32) -> f32 {
    let a = x.abs();
    let v = if a <= 0.003_130_8 { 12.92 * a } else { 1.055 * a.powf(1.0 / 2.4) - 0.055 };
    v.copysign(x)
}

/// Decodes an sRGB value to linear light, the inverse of [`srgb_encode`]: `v / 12.92` up to 0.04045, above that
/// `((v + 0.055) / 1.055)^2.4`.
#[inline]
pub fn srgb_decode(v: f32) -> f32 {
    let a = v.abs();
    let x = if a <= 0.040_45 { a / 12.92 } else { ((a + 0.055) / 1.055).powf(2.4) };
    x.copysign(v)
}

/// [`srgb_decode`] of all 256 bytes.
static DECODE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| decode64(i as f64 / 255.0) as f32));

/// `THRESHOLD[i]` is the light whose code is exactly `i + ½`: from there on it rounds to `i + 1`.
static THRESHOLD: LazyLock<[f32; 255]> =
    LazyLock::new(|| std::array::from_fn(|i| decode64((i as f64 + 0.5) / 255.0) as f32));

fn decode64(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Linear light of an sRGB byte, from a table.
#[inline]
pub fn srgb8_decode(v: u8) -> f32 {
    DECODE[v as usize]
}

/// The sRGB byte nearest to some linear light; clamps, and takes NaN as 0.
///
/// Found among the 255 thresholds rather than by rounding a power, so that the result does not hang on the last bit of
/// the platform's `powf`.
#[inline]
pub fn srgb8_encode(x: f32) -> u8 {
    THRESHOLD.partition_point(|&t| t <= x) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // IEC 61966-2-1: white, black, both sides of the knee; mid grey 0.18 and code 0.5 by hand in 50 digits.
        for (x, v) in
            [(0.0, 0.0), (1.0, 1.0), (0.0031308, 0.0404499), (0.18, 0.461_356_13), (0.214_041_14, 0.5)]
        {
            assert!((srgb_encode(x) - v).abs() < 2e-6, "{x} → {} not {v}", srgb_encode(x));
            assert!((srgb_decode(v) - x).abs() < 2e-6, "{v} → {} not {x}", srgb_decode(v));
        }
    }

    #[test]
    fn decode_inverts_encode() {
        for i in -2000..=4000 {
            let x = i as f32 / 1000.0;
            assert!((srgb_decode(srgb_encode(x)) - x).abs() <= 4e-6 * x.abs().max(0.05), "{x}");
        }
    }

    #[test]
    fn the_byte_tables_agree_with_the_formulas() {
        for i in 0..=255u8 {
            assert!((srgb8_decode(i) - srgb_decode(i as f32 / 255.0)).abs() < 1e-6);
            assert_eq!(srgb8_encode(srgb8_decode(i)), i);
        }
        for i in 0..100_000 {
            let x = i as f32 / 99_999.0;
            let exact = srgb_encode(x) * 255.0;
            assert!((srgb8_encode(x) as f32 - exact).abs() <= 0.5 + 1e-4, "{x}");
        }
        assert_eq!(
            [f32::NAN, -1.0, f32::NEG_INFINITY, 2.0, f32::INFINITY].map(srgb8_encode),
            [0, 0, 0, 255, 255]
        );
    }
}
