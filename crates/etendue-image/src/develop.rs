//! From scene light to what a display is sent.

use etendue_color::{ToneCurve, srgb_encode, srgb8_encode};

use crate::{Image, Pixels};

/// Bits per channel of a developed picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Depth {
    /// Eight.
    #[default]
    Eight,
    /// Sixteen; where a format has no more than eight, eight is written.
    Sixteen,
}

/// How scene light becomes a picture: exposure, tone curve, encoding, depth, in this order.
///
/// ```
/// use etendue_image::{Development, Image, Pixels, develop};
/// let grey = Image { width: 1, height: 1, channels: 3, pixels: Pixels::F32(vec![0.18; 3]) };
/// let png = develop(&grey, &Development::default());
/// assert_eq!(png.pixels, Pixels::U8(vec![118; 3]));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Development {
    /// Light is multiplied by 2 to this power, in EV (stops).
    pub exposure_ev: f32,
    /// Brings light into 0..1.
    pub curve: ToneCurve,
    /// Leaves out the sRGB encoding: samples are proportional to light.
    pub linear: bool,
    /// Bits per channel of the result.
    pub depth: Depth,
    /// Adds an 8 × 8 ordered pattern of half a step before rounding, so that smooth gradients show no bands. The
    /// pattern is fixed: the same picture gives the same bits.
    pub dither: bool,
}

/// Develops a float picture of 1 to 4 channels; the result has the same channels.
///
/// Colour is taken as premultiplied with alpha (channel 2 of 2, 4 of 4): it is divided out before the curve, so that the
/// result has straight alpha, as PNG and WebP want it. Where alpha is 0 the result is black. Grey goes through the
/// curve as three equal channels. NaN becomes black. An integer picture is taken as developed already and returned as it is.
pub fn develop(image: &Image, development: &Development) -> Image {
    let Pixels::F32(pixels) = &image.pixels else {
        return image.clone();
    };
    let n = image.channels as usize;
    let (colors, has_alpha) = if n.is_multiple_of(2) { (n - 1, true) } else { (n, false) };
    let gain = development.exposure_ev.exp2();
    let width = image.width as usize;
    // Calls `store` with each channel's display value in 0..1 and the offset of its rounding, in steps.
    let each = |store: &mut dyn FnMut(f32, bool, f32)| {
        for (i, p) in pixels.chunks_exact(n).enumerate() {
            let alpha = if has_alpha { p[n - 1].clamp(0.0, 1.0) } else { 1.0 };
            let alpha = if alpha.is_nan() { 0.0 } else { alpha };
            let scale = if alpha > 0.0 { gain / alpha } else { 0.0 };
            let scene = if colors == 1 { [p[0]; 3] } else { [p[0], p[1], p[2]] };
            let display = development.curve.apply(scene.map(|v| v * scale));
            let offset = if development.dither { bayer8(i % width, i / width) } else { 0.0 };
            for v in display.iter().take(colors) {
                store(*v, development.linear, offset);
            }
            if has_alpha {
                // Alpha is a share, never encoded.
                store(alpha, true, 0.0);
            }
        }
    };
    let quantise = |v: f32, linear: bool, offset: f32, steps: f32| {
        let v = if linear { v } else { srgb_encode(v) };
        (v * steps + 0.5 + offset).clamp(0.0, steps)
    };
    let pixels = match development.depth {
        Depth::Eight => {
            let mut out = Vec::with_capacity(pixels.len());
            each(&mut |v, linear, offset| {
                // Without dither the table decides, which is exact on every platform.
                let exact = !linear && offset == 0.0;
                out.push(if exact { srgb8_encode(v) } else { quantise(v, linear, offset, 255.0) as u8 });
            });
            Pixels::U8(out)
        }
        Depth::Sixteen => {
            let mut out = Vec::with_capacity(pixels.len());
            each(&mut |v, linear, offset| out.push(quantise(v, linear, offset, 65535.0) as u16));
            Pixels::U16(out)
        }
    };
    Image { width: image.width, height: image.height, channels: image.channels, pixels }
}

/// The 8 × 8 ordered pattern of Bayer (1973), "An optimum method for two-level rendition of continuous-tone pictures",
/// centred: −½ to ½ of a step, each of 64 values once.
fn bayer8(x: usize, y: usize) -> f32 {
    let (mut v, x, y) = (0, x & 7, y & 7);
    for bit in 0..3 {
        let (a, b) = (x >> bit & 1, y >> bit & 1);
        // The finest bit of the position is the coarsest of the rank.
        v |= ((a ^ b) << 1 | b) << (2 * (2 - bit));
    }
    (v as f32 + 0.5) / 64.0 - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(channels: u8, p: &[f32]) -> Image {
        Image { width: 1, height: 1, channels, pixels: Pixels::F32(p.to_vec()) }
    }

    #[test]
    fn exposure_curve_encoding_depth() {
        let d = Development { exposure_ev: 1.0, ..Default::default() };
        assert_eq!(develop(&one(3, &[0.09, 0.5, 0.0]), &d).pixels, Pixels::U8(vec![118, 255, 0]));
        let d = Development { linear: true, depth: Depth::Sixteen, ..Default::default() };
        assert_eq!(develop(&one(3, &[0.5, 1.0, f32::NAN]), &d).pixels, Pixels::U16(vec![32768, 65535, 0]));
        let d = Development { curve: ToneCurve::Reinhard, linear: true, ..Default::default() };
        assert_eq!(develop(&one(1, &[1.0]), &d).pixels, Pixels::U8(vec![128]));
    }

    #[test]
    fn alpha_is_divided_out_and_never_encoded() {
        let d = Development::default();
        assert_eq!(develop(&one(4, &[0.09, 0.5, 0.0, 0.5]), &d).pixels, Pixels::U8(vec![118, 255, 0, 128]));
        assert_eq!(develop(&one(4, &[1.0, 1.0, 1.0, 0.0]), &d).pixels, Pixels::U8(vec![0, 0, 0, 0]));
        assert_eq!(develop(&one(2, &[0.18, 1.0]), &d).pixels, Pixels::U8(vec![118, 255]));
    }

    #[test]
    fn dither_keeps_the_mean_between_two_codes() {
        let grey =
            Image { width: 64, height: 64, channels: 1, pixels: Pixels::F32(vec![100.3 / 255.0; 4096]) };
        let d = Development { linear: true, dither: true, ..Default::default() };
        let Pixels::U8(p) = develop(&grey, &d).pixels else { panic!() };
        let mean = p.iter().map(|v| f64::from(*v)).sum::<f64>() / 4096.0;
        assert!((mean - 100.3).abs() < 0.01, "{mean}");
        let mut seen: Vec<u32> = (0..64).map(|i| ((bayer8(i % 8, i / 8) + 0.5) * 64.0) as u32).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..64).collect::<Vec<_>>());
    }
}
