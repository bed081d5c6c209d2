//! OpenEXR: any bytes are a finite sky, layers, or an error.

use etendue_image::{DecodeLimits, Pixels, decode_environment, read_exr_layers};

/// Small, so that a claim beyond them is a finding and not a slow run.
const LIMITS: DecodeLimits = DecodeLimits { max_pixels: 1 << 22, max_bytes: 1 << 26 };

/// One input.
pub fn run(data: &[u8]) {
    // The magic number is given: only what follows is searched for.
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01];
    bytes.extend_from_slice(data.strip_prefix(&[0x76, 0x2f, 0x31, 0x01]).unwrap_or(data));
    if let Ok(e) = decode_environment(&bytes, &LIMITS) {
        let Pixels::F32(p) = &e.image.pixels else { panic!("not floats") };
        assert_eq!(p.len(), e.image.len());
        assert!(p.iter().all(|v| v.is_finite() && *v >= 0.0));
    }
    let _ = read_exr_layers(&bytes, &LIMITS);
}
