//! The hue of a colour, which Disney's tints take from the base colour.

use etendue_color::Spectrum;

/// The colour divided by its luminance as Burley approximates it, 0.3 R + 0.6 G + 0.1 B; white if that is not above zero.
///
/// The one place in these models that knows what the lanes are: the first three count as red, green and blue. With
/// wavelengths in the lanes it is still a hue, but of other weights.
#[inline]
pub fn hue(color: Spectrum) -> Spectrum {
    let luminance = 0.3 * color[0] + 0.6 * color[1] + 0.1 * color[2];
    if luminance > 1e-6 { color * (1.0 / luminance) } else { Spectrum::ONE }
}

/// From white to the hue of `color` by `tint` 0..1.
#[inline]
pub fn tinted(color: Spectrum, tint: f32) -> Spectrum {
    Spectrum::ONE + (hue(color) - Spectrum::ONE) * tint
}

/// 0..1, NaN to 0.
#[inline(always)]
pub(super) fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

/// Sum over lanes.
#[inline(always)]
pub(super) fn sum(s: Spectrum) -> f32 {
    let [a, b, c, d] = s.0;
    (a + b) + (c + d)
}
