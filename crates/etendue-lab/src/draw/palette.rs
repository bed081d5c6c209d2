//! Colours that people tell apart whatever their colour vision.

/// sRGB bytes.
pub type Rgb = [u8; 3];

/// For lines and symbols: Okabe, Ito 2008 ("Color Universal Design"), without the yellow that white swallows.
pub const LINES: [Rgb; 7] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
    [0x22, 0x22, 0x22],
];

/// For magnitudes, dark to bright: viridis (van der Walt, Smith 2015) at nine points.
pub const HEAT: [Rgb; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];

/// For errors, black to pale: magma (van der Walt, Smith 2015) at nine points, the colours of FLIP's authors.
pub const MAGMA: [Rgb; 9] = [
    [0x00, 0x00, 0x04],
    [0x1c, 0x10, 0x44],
    [0x4f, 0x12, 0x7b],
    [0x81, 0x25, 0x81],
    [0xb5, 0x36, 0x7a],
    [0xe5, 0x50, 0x64],
    [0xfb, 0x87, 0x61],
    [0xfe, 0xc2, 0x87],
    [0xfc, 0xfd, 0xbf],
];

/// For differences: blue below, white at zero, vermilion above.
pub const DIVERGING: [Rgb; 5] =
    [[0x00, 0x4a, 0x80], [0x66, 0xaa, 0xd0], [0xf7, 0xf7, 0xf7], [0xe9, 0x9a, 0x60], [0x9c, 0x3c, 0x00]];

/// The colour at `t` in 0..1 along evenly spaced `stops`; values outside are clamped, NaN to the first.
pub fn scale(stops: &[Rgb], t: f32) -> Rgb {
    let last = stops.len() - 1;
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let x = t * last as f32;
    let i = (x as usize).min(last.saturating_sub(1));
    let f = x - i as f32;
    let j = (i + 1).min(last);
    core::array::from_fn(|k| (stops[i][k] as f32 * (1.0 - f) + stops[j][k] as f32 * f).round() as u8)
}
