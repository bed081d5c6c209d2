//! IES profiles: any bytes are a lamp that shines finitely everywhere and is read again as it is written, or an error.

use etendue_import::{parse_ies, write_ies};

/// One input.
pub fn run(data: &[u8]) {
    let Ok(file) = parse_ies(data) else { return };
    let p = &file.profile;
    assert!(p.lumens() >= 0.0 && p.peak() <= 1e30);
    for d in [[0.0, 0.0, 1.0], [0.6, -0.8, 0.0], [-0.48, 0.6, -0.64]] {
        let candela = p.candela(d.into());
        assert!(candela >= 0.0 && candela <= p.peak() * 1.001);
    }
    let again = parse_ies(write_ies(p).as_bytes()).map(|f| f.profile);
    assert_eq!(again.as_ref(), Ok(p));
}
