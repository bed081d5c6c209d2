//! A picture in memory, in the bit depth that its file had.

/// The samples of an [`Image`], interleaved by pixel, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Eight bits per channel, normalised: 255 is 1.
    U8(Vec<u8>),
    /// Sixteen bits per channel, normalised: 65535 is 1.
    U16(Vec<u16>),
    /// Floats as they stand.
    F32(Vec<f32>),
}

/// A picture: `width × height` pixels of 1 to 4 channels. What the numbers mean (sRGB-encoded colour, linear light,
/// data) is said by who refers to it, because one file may serve both as colour and as data.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Channels per pixel: 1 grey, 2 grey + alpha, 3 RGB, 4 RGBA.
    pub channels: u8,
    /// `width × height × channels` samples.
    pub pixels: Pixels,
}

impl Image {
    /// Number of samples, `width × height × channels`.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize * self.channels as usize
    }

    /// An image is never empty; this is here because `len` is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sample `c` of pixel (`x`, `y`) as a float: integers normalised to 0..1.
    #[inline]
    pub fn sample(&self, x: u32, y: u32, c: u8) -> f32 {
        let i = (y as usize * self.width as usize + x as usize) * self.channels as usize + c as usize;
        match &self.pixels {
            Pixels::U8(p) => p[i] as f32 * (1.0 / 255.0),
            Pixels::U16(p) => p[i] as f32 * (1.0 / 65535.0),
            Pixels::F32(p) => p[i],
        }
    }

    /// Bytes that the samples take in memory.
    pub fn bytes(&self) -> usize {
        self.len()
            * match self.pixels {
                Pixels::U8(_) => 1,
                Pixels::U16(_) => 2,
                Pixels::F32(_) => 4,
            }
    }
}
