//! KTX2: any bytes are whole pictures of every mip, or an error.

use etendue_image::{DecodeLimits, Ktx2, Pixels};

/// Small, so that a claim beyond them is a finding and not a slow run.
const LIMITS: DecodeLimits = DecodeLimits { max_pixels: 1 << 18, max_bytes: 1 << 22 };

/// One input.
pub fn run(data: &[u8]) {
    let Ok(k) = Ktx2::new(data, &LIMITS) else { return };
    for mip in 0..k.mips() {
        for i in k.mip(mip).into_iter().flatten() {
            let samples = match &i.pixels {
                Pixels::U8(p) => p.len(),
                Pixels::U16(p) => p.len(),
                Pixels::F32(p) => p.len(),
            };
            assert_eq!(samples, i.len());
        }
    }
}
