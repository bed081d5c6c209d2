//! Images as the renderer reads them: what lies close in the picture lies close in memory.
//!
//! A path looks up four texels, two rows of two, in each of a material's textures, and each path elsewhere. Row by row in
//! memory that is two cache lines and two pages a texture; in blocks of 4 × 4 texels of four bytes it is mostly one line. The
//! blocks lie in huge pages where the system gives them.

use etendue_color::srgb8_decode;
use etendue_image::{Image, Pixels};
use etendue_scene::Footprint;
use etendue_trace::Pages;
use glam::Vec4;
use std::sync::{Arc, LazyLock};

/// An image ready for lookups.
pub(crate) enum Texels {
    /// Eight bits per channel, expanded to four channels.
    Blocks(Blocks),
    /// Any other depth, as it was read.
    Plain(Arc<Image>),
}

pub(crate) struct Blocks {
    texels: Pages<[u8; 4]>,
    /// Blocks in a row.
    across: usize,
    width: u32,
    height: u32,
}

/// [`srgb8_decode`] of all bytes.
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| srgb8_decode(i as u8)));

impl Texels {
    pub fn new(image: Arc<Image>) -> Self {
        let Pixels::U8(p) = &image.pixels else { return Self::Plain(image) };
        let (w, h, n) = (image.width as usize, image.height as usize, image.channels as usize);
        let across = w.div_ceil(4);
        let mut pages = Pages::zeroed(across * h.div_ceil(4) * 16);
        let texels: &mut [[u8; 4]] = &mut pages;
        for y in 0..h {
            for (x, p) in p[y * w * n..][..w * n].chunks_exact(n).enumerate() {
                texels[index(across, x as u32, y as u32)] = match *p {
                    [g] => [g, g, g, 255],
                    [g, a] => [g, g, g, a],
                    [r, g, b] => [r, g, b, 255],
                    _ => [p[0], p[1], p[2], p[3]],
                };
            }
        }
        Self::Blocks(Blocks { texels: pages, across, width: image.width, height: image.height })
    }

    /// Width and height, pixels.
    #[inline(always)]
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Blocks(b) => [b.width, b.height],
            Self::Plain(i) => [i.width, i.height],
        }
    }

    /// RGBA, colour decoded from sRGB.
    #[inline(always)]
    pub fn srgb(&self, f: &Footprint) -> Vec4 {
        match self {
            Self::Blocks(b) => {
                let (texels, table): (&[[u8; 4]], _) = (&b.texels, &*SRGB);
                f.gather(|x, y| {
                    let [r, g, blue, a] = texels[index(b.across, x, y)].map(usize::from);
                    Vec4::new(table[r], table[g], table[blue], a as f32 * (1.0 / 255.0))
                })
            }
            Self::Plain(image) => f.srgb(image),
        }
    }

    /// RGBA as stored.
    #[inline(always)]
    pub fn linear(&self, f: &Footprint) -> Vec4 {
        match self {
            Self::Blocks(b) => {
                let texels: &[[u8; 4]] = &b.texels;
                let sum = f.gather(|x, y| {
                    let [r, g, blue, a] = texels[index(b.across, x, y)].map(f32::from);
                    Vec4::new(r, g, blue, a)
                });
                sum * (1.0 / 255.0)
            }
            Self::Plain(image) => f.linear(image),
        }
    }
}

#[inline(always)]
fn index(across: usize, x: u32, y: u32) -> usize {
    ((y as usize >> 2) * across + (x as usize >> 2)) * 16 + ((y as usize & 3) << 2 | (x as usize & 3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_scene::Sampler;
    use glam::Vec2;

    /// Blocks hold what the image holds, for every number of channels and sizes that do not divide by four.
    #[test]
    fn blocks_are_the_image() {
        for channels in 1..=4u8 {
            let (width, height) = (13, 7);
            let n = width as usize * height as usize * channels as usize;
            let pixels = Pixels::U8((0..n).map(|i| (i * 37 % 256) as u8).collect());
            let image = Arc::new(Image { width, height, channels, pixels });
            let texels = Texels::new(image.clone());
            assert_eq!(texels.size(), [width, height]);
            for i in 0..400 {
                let uv = Vec2::new(i as f32 * 0.137, i as f32 * 0.0713);
                let f = Footprint::new(&Sampler::default(), width, height, uv);
                assert!(texels.srgb(&f).abs_diff_eq(f.srgb(&image), 1e-6));
                assert!(texels.linear(&f).abs_diff_eq(f.linear(&image), 1e-6));
            }
        }
    }
}
