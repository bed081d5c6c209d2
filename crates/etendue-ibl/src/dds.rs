//! Cube maps as DDS with a DX10 header (Microsoft, "Programming Guide for DDS").

use crate::cube::CubeMap;
use crate::texel_format::TexelFormat;

/// A DDS file of all mips of a cube.
pub fn encode(cube: &CubeMap, format: TexelFormat) -> Vec<u8> {
    let n = cube.size();
    let blocks = n.div_ceil(format.block()) as usize;
    // The pitch of plain formats, the size of the first mip of block-compressed ones.
    let (pitch_flag, pitch) = match format {
        TexelFormat::Bc6h => (0x8_0000, blocks * blocks * format.block_bytes()),
        _ => (0x8, blocks * format.block_bytes()),
    };
    let mut words = vec![
        u32::from_le_bytes(*b"DDS "),
        124,
        // Caps, height, width, pixel format, mip count.
        0x1 | 0x2 | 0x4 | 0x1000 | 0x2_0000 | pitch_flag,
        n,
        n,
        pitch as u32,
        0,
        cube.mip_count() as u32,
    ];
    words.extend([0; 11]);
    // The pixel format: what it is stands in the DX10 header.
    words.extend([32, 0x4, u32::from_le_bytes(*b"DX10"), 0, 0, 0, 0, 0]);
    // Texture, complex, with mips; a cube with all faces.
    words.extend([0x1000 | 0x8 | 0x40_0000, 0x200 | 0xfc00, 0, 0, 0]);
    // DX10: format, two-dimensional, cube, one of them, alpha unknown.
    words.extend([format.dxgi(), 3, 0x4, 1, 0]);
    let mut out: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    for face in 0..6 {
        for mip in 0..cube.mip_count() {
            out.extend(format.encode(cube, mip, face));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_color::Spectrum;

    #[test]
    fn files_read_back() {
        let texels = (0..6 * 64).map(|i| Spectrum::splat(100.0 + 0.1 * i as f32));
        let cube = CubeMap::new(8, texels.collect()).unwrap().with_mips();
        for format in [TexelFormat::Rgba16f, TexelFormat::Rgb9e5, TexelFormat::Bc6h] {
            let b = encode(&cube, format);
            assert_eq!(&b[..4], b"DDS ");
            assert_eq!(&b[84..88], b"DX10");
            assert_eq!(b[128], format.dxgi() as u8);
            let mut at = 148;
            for face in 0..6 {
                for mip in 0..4 {
                    let n = cube.mip_size(mip) as usize;
                    let blocks = n.div_ceil(format.block() as usize);
                    let back = format.decode(&b[at..], n).unwrap();
                    for (x, y) in back.iter().zip(cube.face(mip, face)) {
                        assert!((x[0] - y[0]).abs() <= 0.01 * y[0], "{format} {mip} {face}: {x:?} {y:?}");
                    }
                    at += blocks * blocks * format.block_bytes();
                }
            }
            assert_eq!(at, b.len());
        }
    }
}
