//! PNG, JPEG and WebP: any bytes are a whole picture or an error.

use etendue_image::{DecodeLimits, Pixels, decode};

/// Small, so that a claim beyond them is a finding and not a slow run.
const LIMITS: DecodeLimits = DecodeLimits { max_pixels: 1 << 20, max_bytes: 1 << 24 };

/// One input.
pub fn run(data: &[u8]) {
    if let Ok(i) = decode(data, &LIMITS) {
        let samples = match &i.pixels {
            Pixels::U8(p) => p.len(),
            Pixels::U16(p) => p.len(),
            Pixels::F32(_) => panic!("floats from a texture"),
        };
        assert_eq!(samples, i.len());
    }
}
