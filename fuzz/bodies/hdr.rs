//! Radiance pictures: any bytes are a finite sky or an error.

use etendue_image::{DecodeLimits, Pixels, decode_environment};

/// Small, so that a claim beyond them is a finding and not a slow run.
const LIMITS: DecodeLimits = DecodeLimits { max_pixels: 1 << 22, max_bytes: 1 << 26 };

/// One input.
pub fn run(data: &[u8]) {
    // The signature is given: only what follows is searched for.
    let mut bytes = b"#?RADIANCE\n".to_vec();
    bytes.extend_from_slice(data.strip_prefix(b"#?RADIANCE\n").unwrap_or(data));
    if let Ok(e) = decode_environment(&bytes, &LIMITS) {
        let Pixels::F32(p) = &e.image.pixels else { panic!("not floats") };
        assert_eq!(p.len(), e.image.len());
        assert!(p.iter().all(|v| v.is_finite() && *v >= 0.0));
    }
}
