//! Pictures and maps as colours for a page.

use super::figures::on;
use crate::draw::{DIVERGING, MAGMA, Rgb, scale};
use base64::{Engine, engine::general_purpose::STANDARD};
use etendue_image::{
    Depth, Development, Image, PictureFormat, Pixels, WriteOptions, develop, encode_picture,
};

/// A picture of sRGB bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Painting {
    pub size: [u32; 2],
    pub pixels: Vec<Rgb>,
}

impl Painting {
    /// A picture as a display shows it: light is developed, alpha laid on black.
    pub fn of(image: &Image, development: &Development) -> Self {
        let flat = on(image, 0.0);
        let bytes = match develop(&flat, &Development { depth: Depth::Eight, ..*development }).pixels {
            Pixels::U8(p) => p,
            // Nearest of 256 codes: 65535 = 257 · 255.
            Pixels::U16(p) => p.into_iter().map(|v| ((u32::from(v) + 128) / 257) as u8).collect(),
            Pixels::F32(p) => p.into_iter().map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect(),
        };
        let pixels = bytes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        Self { size: [image.width, image.height], pixels }
    }

    /// A map of FLIP from 0 (black) to `top` (pale yellow).
    pub fn flip(map: &[f32], size: [u32; 2], top: f32) -> Self {
        Self { size, pixels: map.iter().map(|v| scale(&MAGMA, v / top)).collect() }
    }

    /// A map of numbers from −`top` (blue) over 0 (white) to `top` (vermilion).
    pub fn signed(map: &[f32], size: [u32; 2], top: f32) -> Self {
        Self { size, pixels: map.iter().map(|v| scale(&DIVERGING, 0.5 + 0.5 * v / top)).collect() }
    }

    /// The square of at most `side` pixels about a place, moved inside the picture, and its upper left corner.
    pub fn crop(&self, [x, y]: [u32; 2], side: u32) -> (Self, [u32; 2]) {
        let [w, h] = self.size;
        let size = [side.min(w), side.min(h)];
        let from = [x.saturating_sub(side / 2).min(w - size[0]), y.saturating_sub(side / 2).min(h - size[1])];
        let pixels = (0..size[0] * size[1])
            .map(|i| self.pixels[((from[1] + i / size[0]) * w + from[0] + i % size[0]) as usize])
            .collect();
        (Self { size, pixels }, from)
    }

    /// The colour of a place.
    pub fn at(&self, [x, y]: [u32; 2]) -> Rgb {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    /// As a PNG in a data URI.
    pub fn uri(&self) -> String {
        uri(self.size, 3, self.pixels.as_flattened().to_vec())
    }
}

/// Numbers 0..1 as a grey PNG in a data URI, their square roots in 255 steps: finer where they are small.
pub(crate) fn values_uri(map: &[f32], size: [u32; 2]) -> String {
    uri(size, 1, map.iter().map(|v| (v.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8).collect())
}

fn uri([width, height]: [u32; 2], channels: u8, bytes: Vec<u8>) -> String {
    let image = Image { width, height, channels, pixels: Pixels::U8(bytes) };
    let mut png = Vec::new();
    // Into memory, of a sound picture: there is nothing that could fail but the size, which files have passed before.
    let _ = encode_picture(&mut png, PictureFormat::Png, &image, &WriteOptions::default());
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// Difference of the brightness of display values, `test` − `reference`, −1..1 (luma of Rec. 709).
pub(crate) fn brightness_error(reference: &Painting, test: &Painting) -> Vec<f32> {
    let luma = |c: &Rgb| {
        (0.2126 * f32::from(c[0]) + 0.7152 * f32::from(c[1]) + 0.0722 * f32::from(c[2])) * (1.0 / 255.0)
    };
    reference.pixels.iter().zip(&test.pixels).map(|(r, t)| luma(t) - luma(r)).collect()
}

/// The end of a scale that shows nearly all values of a map: the 99.8th percentile of their magnitude, rounded up to
/// 1, 2 or 5 × 10ⁿ, 0.05 to 1.
pub(crate) fn scale_end(map: &[f32]) -> f32 {
    let mut v: Vec<f32> = map.iter().map(|v| v.abs()).collect();
    v.sort_unstable_by(f32::total_cmp);
    let most = v.get(v.len() * 998 / 1000).copied().unwrap_or(0.0);
    [0.05, 0.1, 0.2, 0.5].into_iter().find(|e| most <= *e).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_stay_inside_and_keep_their_place() {
        let p = Painting { size: [5, 4], pixels: (0..20).map(|i| [i, 0, 0]).collect() };
        let (c, from) = p.crop([4, 0], 3);
        assert_eq!((c.size, from), ([3, 3], [2, 0]));
        assert_eq!(c.at([2, 0]), p.at([4, 0]));
        assert_eq!(p.crop([2, 2], 99), (p.clone(), [0, 0]));
    }

    #[test]
    fn scales_hold_what_they_show() {
        assert_eq!(scale_end(&[0.0; 8]), 0.05);
        assert_eq!(scale_end(&[0.0, -0.3]), 0.5);
        let mut many = vec![0.01; 1000];
        many[7] = 0.9;
        assert_eq!(scale_end(&many), 0.05);
    }

    #[test]
    fn light_is_developed_and_values_kept() {
        let image = Image { width: 2, height: 1, channels: 1, pixels: Pixels::F32(vec![0.18, 9.0]) };
        let p = Painting::of(&image, &Development::default());
        assert_eq!(p.pixels, [[118; 3], [255; 3]]);
        let e = brightness_error(&p, &Painting { size: p.size, pixels: vec![[118; 3], [0; 3]] });
        assert!(e[0] == 0.0 && (e[1] + 1.0).abs() < 1e-6);
        assert!(p.uri().starts_with("data:image/png;base64,iVBOR"));
    }
}
