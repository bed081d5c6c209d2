//! Cube maps as KTX2, Khronos' container of textures ("KTX File Format Specification", version 2.0).

use crate::cube::CubeMap;
use crate::texel_format::TexelFormat;
use etendue_image::Metadata;

/// The first twelve bytes.
const IDENTIFIER: [u8; 12] = [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'];

/// A KTX2 file of all mips of a cube, uncompressed beyond its texel format.
///
/// `metadata` become entries of the key/value data, beside `KTXorientation` (`rd`) and `KTXwriter`.
pub fn encode(cube: &CubeMap, format: TexelFormat, metadata: &Metadata) -> Vec<u8> {
    let levels = cube.mip_count();
    let descriptor = descriptor(format);
    let pairs = key_values(metadata);
    let head = IDENTIFIER.len() + 9 * 4 + 4 * 4 + 2 * 8 + levels * 24;
    let pairs_at = head + descriptor.len();
    // Mips stand from the smallest to the largest, each at a multiple of the block's bytes and of 4.
    let align = format.block_bytes().max(4);
    let (mut offsets, mut data) = (vec![(0u64, 0u64); levels], Vec::new());
    let start = (pairs_at + pairs.len()).next_multiple_of(align);
    for mip in (0..levels).rev() {
        data.resize(data.len().next_multiple_of(align), 0);
        let begin = data.len();
        for face in 0..6 {
            data.extend(format.encode(cube, mip, face));
        }
        offsets[mip] = ((start + begin) as u64, (data.len() - begin) as u64);
    }

    let mut out = IDENTIFIER.to_vec();
    let mut word = |v: u32| out.extend(v.to_le_bytes());
    let type_size = match format {
        TexelFormat::Rgba16f => 2,
        TexelFormat::Rgb9e5 => 4,
        TexelFormat::Bc6h => 1,
    };
    // Format, size of a scalar, width, height, depth, layers, faces, levels, supercompression.
    for v in [format.vulkan(), type_size, cube.size(), cube.size(), 0, 0, 6, levels as u32, 0] {
        word(v);
    }
    for v in [head, descriptor.len(), pairs_at, pairs.len()] {
        word(v as u32);
    }
    // No data for supercompression.
    out.extend([0; 16]);
    for (offset, length) in &offsets {
        for v in [offset, length, length] {
            out.extend(v.to_le_bytes());
        }
    }
    out.extend(descriptor);
    out.extend(pairs);
    out.resize(start, 0);
    out.extend(data);
    out
}

/// The data format descriptor ("Khronos Data Format Specification" 1.3): one basic block, Rec.709 primaries, linear.
fn descriptor(format: TexelFormat) -> Vec<u8> {
    const RGBSDA: u32 = 1;
    const BC6H: u32 = 133;
    // What a sample is: the channel, and the flags for floats (0x80), signs (0x40) and exponents (0x20).
    let one = 1.0f32.to_bits();
    let (model, block, samples): (u32, u32, Vec<[u32; 5]>) = match format {
        TexelFormat::Rgba16f => {
            let channel = |i: u32, id: u32| [16 * i, 15, id | 0xc0, (-1.0f32).to_bits(), one];
            (RGBSDA, 0, vec![channel(0, 0), channel(1, 1), channel(2, 2), channel(3, 15)])
        }
        TexelFormat::Rgb9e5 => {
            // Each colour is a mantissa of its own and the exponent of all; 8448 stands for 1 at exponent 15.
            let channel = |i: u32| [[9 * i, 8, i, 0, 8448], [27, 4, i | 0x20, 15, 31]];
            (RGBSDA, 0, (0..3).flat_map(channel).collect())
        }
        TexelFormat::Bc6h => (BC6H, 3 | 3 << 8, vec![[0, 127, 0x80, 0, one]]),
    };
    let block_size = 24 + 16 * samples.len() as u32;
    let mut words = vec![4 + block_size, 0, 2 | block_size << 16, model | 1 << 8 | 1 << 16, block];
    words.extend([format.block_bytes() as u32, 0]);
    for [offset, length, channel, lower, upper] in samples {
        words.extend([offset | length << 16 | channel << 24, 0, lower, upper]);
    }
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

/// The key/value data: sorted by key, each entry padded to four bytes.
fn key_values(metadata: &Metadata) -> Vec<u8> {
    let mut pairs: Vec<(String, String)> = metadata
        .entries
        .iter()
        // Keys that begin so are the format's own.
        .filter(|(k, _)| !k.is_empty() && !k.contains('\0') && !k.to_ascii_lowercase().starts_with("ktx"))
        .cloned()
        .collect();
    pairs.push(("KTXorientation".into(), "rd".into()));
    pairs.push(("KTXwriter".into(), concat!("etendue ", env!("CARGO_PKG_VERSION")).into()));
    pairs.sort();
    let mut out = Vec::new();
    for (key, value) in pairs {
        let value = value.replace('\0', " ");
        out.extend(((key.len() + value.len() + 2) as u32).to_le_bytes());
        out.extend([key.as_bytes(), &[0], value.as_bytes(), &[0]].concat());
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;
    use etendue_color::Spectrum;

    fn word(b: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(b[at..at + 4].try_into().unwrap())
    }

    fn long(b: &[u8], at: usize) -> u64 {
        u64::from_le_bytes(b[at..at + 8].try_into().unwrap())
    }

    pub(crate) fn noise(n: u32) -> CubeMap {
        let mut rng = Rng::new(3);
        let texels = (0..6 * n * n).map(|_| {
            let v = 1.0 + 0.1 * rng.uniform();
            Spectrum::rgb(v, 0.5 * v, 2.0 * v)
        });
        CubeMap::new(n, texels.collect()).unwrap().with_mips()
    }

    /// Reads the file as the specification says and finds every texel again.
    #[test]
    fn files_read_back() {
        let cube = noise(16);
        for (format, tolerance) in
            [(TexelFormat::Rgba16f, 1e-3), (TexelFormat::Rgb9e5, 6e-3), (TexelFormat::Bc6h, 0.15)]
        {
            let mut metadata = Metadata::default();
            metadata.set("roughness", "mirror 0.5 1");
            metadata.set("KTXwriter", "somebody else");
            let b = encode(&cube, format, &metadata);
            assert_eq!(b[..12], IDENTIFIER);
            let header: Vec<u32> = (0..9).map(|i| word(&b, 12 + 4 * i)).collect();
            assert_eq!(header[0], format.vulkan());
            assert_eq!(header[2..], [16, 16, 0, 0, 6, 5, 0]);
            let (dfd, dfd_len, kvd, kvd_len) =
                (word(&b, 48) as usize, word(&b, 52) as usize, word(&b, 56) as usize, word(&b, 60) as usize);
            assert_eq!((dfd, kvd), (80 + 24 * 5, dfd + dfd_len));
            assert_eq!(word(&b, dfd) as usize, dfd_len);
            let text = String::from_utf8_lossy(&b[kvd..kvd + kvd_len]);
            assert!(
                text.contains("KTXorientation\0rd\0") && text.contains("roughness\0mirror 0.5 1\0"),
                "{text}"
            );
            assert!(text.contains("KTXwriter\0etendue") && !text.contains("somebody"));
            let mut end = kvd + kvd_len;
            for mip in (0..5).rev() {
                let (at, len) = (long(&b, 80 + 24 * mip) as usize, long(&b, 88 + 24 * mip) as usize);
                assert_eq!(at % format.block_bytes().max(4), 0);
                assert!(at >= end && len.is_multiple_of(6));
                end = at + len;
                let n = cube.mip_size(mip) as usize;
                for face in 0..6 {
                    let part = &b[at + face * len / 6..at + (face + 1) * len / 6];
                    for (x, y) in format.decode(part, n).unwrap().iter().zip(cube.face(mip, face)) {
                        let error = (*x - *y).map(f32::abs).max_element();
                        assert!(error <= tolerance * y.max_element(), "{format} {x:?} {y:?}");
                    }
                }
            }
            assert_eq!(end, b.len());
        }
    }

    /// The descriptor is byte for byte that of the same format in Khronos' conformance suite.
    #[test]
    fn descriptors_are_those_of_the_conformance_suite() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/images-valid/ktx2-cts");
        let Ok(files) = std::fs::read_dir(root) else {
            println!("skipped: {root} is not there");
            return;
        };
        let mut seen = 0;
        for file in files {
            let b = std::fs::read(file.unwrap().path()).unwrap();
            for format in [TexelFormat::Rgba16f, TexelFormat::Rgb9e5, TexelFormat::Bc6h] {
                if word(&b, 12) == format.vulkan() && word(&b, 44) == 0 {
                    let (at, len) = (word(&b, 48) as usize, word(&b, 52) as usize);
                    assert_eq!(descriptor(format), b[at..at + len], "{format}");
                    seen += 1;
                }
            }
        }
        println!("{seen} descriptors compared");
        assert!(seen > 0);
    }
}
