//! Names as numbers that a compositor can pick: Cryptomatte.
//!
//! Friedman and Jones 2015, "Fully automatic ID mattes with support for motion blur and transparency"; the file layout is that
//! of the Cryptomatte specification 1.2.0.

use crate::film::Coverage;

/// MurmurHash3 (x86, 32 bits, seed 0; Appleby 2011), with the exponent kept out of the range of NaN, infinity and
/// subnormals, so that the hash survives being stored as a float (Cryptomatte specification, section "ID generation").
pub fn name_hash(name: &str) -> u32 {
    let h = murmur3(name.as_bytes());
    match h >> 23 & 255 {
        0 | 255 => h ^ 1 << 23,
        _ => h,
    }
}

fn murmur3(bytes: &[u8]) -> u32 {
    const C1: u32 = 0xcc9e_2d51;
    const C2: u32 = 0x1b87_3593;
    let scramble = |k: u32| k.wrapping_mul(C1).rotate_left(15).wrapping_mul(C2);
    let mut h = 0u32;
    let mut blocks = bytes.chunks_exact(4);
    for b in &mut blocks {
        h ^= scramble(u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        h = h.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let tail = blocks.remainder().iter().rev().fold(0u32, |k, &b| k << 8 | u32::from(b));
    h ^= scramble(tail);
    h ^= bytes.len() as u32;
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

/// The `n` ids that cover most of a pixel, as (hash read as a float, coverage 0..1) pairs, largest first; zeros where there
/// are fewer.
pub fn ranked(coverage: &Coverage, samples: u64, n: usize) -> Vec<[f32; 2]> {
    let mut all: Vec<_> = coverage.iter().map(|(id, c)| (*c, *id)).collect();
    all.sort_unstable_by(|a, b| b.cmp(a));
    all.resize(n, (0, 0));
    all.iter().map(|(c, id)| [f32::from_bits(*id), (f64::from(*c) / samples.max(1) as f64) as f32]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of MurmurHash3_x86_32 with seed 0.
    #[test]
    fn hashes_as_published() {
        assert_eq!(murmur3(b""), 0);
        assert_eq!(murmur3(b"a"), 0x3c25_69b2);
        assert_eq!(murmur3(b"test"), 0xba6b_d213);
        assert_eq!(murmur3(b"Hello, world!"), 0xc036_3e43);
        assert_eq!(murmur3(b"The quick brown fox jumps over the lazy dog"), 0x2e4f_f723);
    }

    #[test]
    fn hashes_are_ordinary_floats() {
        for i in 0..100_000 {
            assert!(f32::from_bits(name_hash(&format!("object {i}"))).is_normal());
        }
    }

    #[test]
    fn ranks_by_coverage() {
        let c = Coverage::from([(7, 1), (9, 6), (8, 3)]);
        let r = ranked(&c, 10, 4);
        assert_eq!(
            r.iter().map(|p| (p[0].to_bits(), p[1])).collect::<Vec<_>>(),
            [(9, 0.6), (8, 0.3), (7, 0.1), (0, 0.0)]
        );
    }
}
