//! BMP and TGA: written by another encoder's rules by hand, read as they stand.
use etendue_image::{DecodeLimits, Image, Pixels, decode, is_tga};

/// A TGA file of `kind` and `depth` bits, from the lowest row on unless `descriptor` says otherwise.
fn tga(kind: u8, (w, h): (u16, u16), depth: u8, descriptor: u8, data: &[u8]) -> Vec<u8> {
    let mut out = vec![0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    out.extend([w.to_le_bytes(), h.to_le_bytes()].concat());
    out.extend([depth, descriptor]);
    out.extend(data);
    out
}

fn read(file: &[u8]) -> Image {
    decode(file, &DecodeLimits::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn tga_is_read() {
    // Two rows of two pixels, blue first.
    let data = [3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10];
    let down = read(&tga(2, (2, 2), 24, 0x20, &data));
    assert_eq!((down.channels, &down.pixels), (3, &Pixels::U8((1..=12).collect())));
    let up = read(&tga(2, (2, 2), 24, 0, &data));
    assert_eq!(up.pixels, Pixels::U8(vec![7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6]));
    let alpha = read(&tga(2, (1, 1), 32, 0x28, &[3, 2, 1, 128]));
    assert_eq!((alpha.channels, alpha.pixels), (4, Pixels::U8(vec![1, 2, 3, 128])));
    let grey = read(&tga(3, (2, 1), 8, 0x20, &[7, 9]));
    assert_eq!((grey.channels, grey.pixels), (1, Pixels::U8(vec![7, 9])));
    // A run of three, then two as they stand.
    let packed = read(&tga(11, (5, 1), 8, 0x20, &[0x82, 7, 0x01, 8, 9]));
    assert_eq!(packed.pixels, Pixels::U8(vec![7, 7, 7, 8, 9]));

    let limits = DecodeLimits::default();
    let cut = tga(2, (2, 2), 24, 0, &data[..7]);
    assert!(decode(&cut, &limits).is_err());
    let large = tga(10, (16_000, 16_000), 32, 0, &[0xff, 1, 2, 3, 4]);
    assert!(decode(&large, &limits).unwrap_err().to_string().contains("cannot hold"));
    assert!(!is_tga(&[0; 18]) && !is_tga(b"solid something else entirely"));
    let good = tga(10, (3, 1), 24, 0x20, &[0x82, 1, 2, 3]);
    for at in 0..good.len() {
        for value in 0..=255 {
            let mut bad = good.clone();
            bad[at] = value;
            let _ = decode(&bad, &DecodeLimits { max_pixels: 1 << 16, max_bytes: 1 << 20 });
        }
    }
}

#[test]
fn bmp_is_read() {
    let bmp = |w: i32, h: i32, bits: u16, compression: u32, data: &[u8]| {
        let mut out = b"BM".to_vec();
        for v in [54 + data.len() as u32, 0, 54, 40, w as u32, h as u32] {
            out.extend(v.to_le_bytes());
        }
        out.extend([1u16.to_le_bytes(), bits.to_le_bytes()].concat());
        for v in [compression, data.len() as u32, 2835, 2835, 0, 0] {
            out.extend(v.to_le_bytes());
        }
        out.extend(data);
        out
    };
    // Rows of two pixels, filled up to four bytes, from the lowest on.
    let data = [3, 2, 1, 6, 5, 4, 0, 0, 9, 8, 7, 12, 11, 10, 0, 0];
    let image = read(&bmp(2, 2, 24, 0, &data));
    let rows = vec![7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6];
    assert_eq!((image.channels, image.pixels), (3, Pixels::U8(rows)));
    assert_eq!(read(&bmp(2, -2, 24, 0, &data)).pixels, Pixels::U8((1..=12).collect()));
    let limits = DecodeLimits { max_pixels: 1 << 16, max_bytes: 1 << 20 };
    assert!(decode(&bmp(2, 2, 24, 0, &data[..9]), &limits).is_err());
    assert!(decode(&bmp(60_000, 60_000, 24, 0, &data), &limits).is_err());
    let good = bmp(2, 2, 24, 0, &data);
    for at in 0..good.len() {
        for value in [0, 1, 4, 0x7f, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[at] = value;
            let _ = decode(&bad, &limits);
        }
    }
}
