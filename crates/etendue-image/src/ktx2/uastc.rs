//! UASTC: blocks of 4 × 4 texels in 16 bytes, a part of ASTC with codes of its own (Khronos Data Format 1.3, section 24).
//!
//! A block has a mode, hints for encoders of other formats (not needed), up to three pairs of colours, and a weight per texel
//! (two in dual-plane modes) that says where between a pair's colours the texel lies.

use super::descriptor::Descriptor;
use super::{Channel, F, Texels};
use crate::{ImageError, Pixels};

/// What a mode fixes.
struct Mode {
    /// The code at the start of the block and its bits.
    code: (u8, u32),
    hints: u32,
    subsets: usize,
    channels: usize,
    planes: usize,
    weight_bits: u32,
    /// How a colour's component is coded: plain bits, and whether a factor of 3 or 5 goes with them.
    endpoint: Range,
}

/// Plain bits and a digit to base 1, 3 or 5.
#[derive(Clone, Copy)]
struct Range {
    bits: u32,
    base: u32,
}

const fn mode(
    code: (u8, u32),
    hints: u32,
    subsets: usize,
    channels: usize,
    planes: usize,
    weight_bits: u32,
    (bits, base): (u32, u32),
) -> Mode {
    Mode { code, hints, subsets, channels, planes, weight_bits, endpoint: Range { bits, base } }
}

/// The mode of one colour.
const SOLID: usize = 8;

/// Tables 24.2 to 24.5.
const MODES: [Mode; 19] = [
    mode((0x01, 4), 15, 1, 3, 1, 4, (6, 3)),
    mode((0x35, 6), 15, 1, 3, 1, 2, (8, 1)),
    mode((0x1d, 5), 15, 2, 3, 1, 3, (4, 1)),
    mode((0x03, 5), 15, 3, 3, 1, 2, (2, 3)),
    mode((0x13, 5), 15, 2, 3, 1, 2, (3, 5)),
    mode((0x0b, 5), 15, 1, 3, 1, 3, (8, 1)),
    mode((0x1b, 5), 15, 1, 3, 2, 2, (5, 5)),
    mode((0x07, 5), 15, 2, 3, 1, 2, (3, 5)),
    mode((0x17, 5), 0, 1, 4, 1, 0, (8, 1)),
    mode((0x0f, 5), 23, 2, 4, 1, 2, (4, 1)),
    mode((0x02, 3), 17, 1, 4, 1, 4, (4, 3)),
    mode((0x00, 2), 17, 1, 4, 2, 2, (4, 3)),
    mode((0x06, 3), 17, 1, 4, 1, 3, (6, 3)),
    mode((0x1f, 5), 23, 1, 4, 2, 1, (8, 1)),
    mode((0x0d, 5), 23, 1, 4, 1, 2, (8, 1)),
    mode((0x05, 7), 23, 1, 2, 1, 4, (8, 1)),
    mode((0x15, 6), 23, 2, 2, 1, 2, (8, 1)),
    mode((0x25, 6), 23, 1, 2, 2, 2, (8, 1)),
    mode((0x09, 4), 15, 1, 3, 1, 5, (5, 1)),
];

/// ASTC's numbers of the patterns of two subsets.
const PATTERNS_2: [u16; 30] = [
    28, 20, 16, 29, 91, 9, 107, 72, 149, 204, 50, 114, 496, 17, 78, 39, 252, 828, 43, 156, 116, 210, 476,
    273, 684, 359, 246, 195, 694, 524,
];

/// Of three.
const PATTERNS_3: [u16; 11] = [260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254];

/// Of two in mode 7.
const PATTERNS_7: [u16; 19] =
    [36, 48, 61, 137, 161, 183, 226, 281, 302, 307, 479, 495, 593, 594, 605, 799, 812, 988, 993];

type Rgba = [u8; 4];

/// Bytes of a picture.
pub(super) fn size(width: u32, height: u32) -> u64 {
    16 * u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4))
}

/// Decodes a picture from its [`size`] bytes.
pub(super) fn image(bytes: &[u8], width: u32, height: u32, d: &Descriptor) -> Result<Texels, ImageError> {
    let (w, h) = (width as usize, height as usize);
    let across = w.div_ceil(4);
    let mut out = vec![0; w * h * 4];
    for (i, b) in bytes.as_chunks::<16>().0.iter().enumerate() {
        let texels = block(*b).ok_or_else(|| ImageError::damaged(F, "a block of no mode or pattern"))?;
        let (x, y) = (i % across * 4, i / across * 4);
        for (row, line) in texels.as_chunks::<4>().0.iter().enumerate().take(h.saturating_sub(y)) {
            let n = 4.min(w - x);
            out[((y + row) * w + x) * 4..][..4 * n].copy_from_slice(&line.as_flattened()[..4 * n]);
        }
    }
    let c = Channel::From;
    // What the four channels hold (table 5.30): RGB, RGBA, and one or two channels in one of several places.
    let map = match d.samples[0].channel {
        0 => [c(0), c(1), c(2), Channel::One],
        3 => [c(0), c(1), c(2), c(3)],
        4 => [c(0), c(0), c(0), Channel::One],
        5 => [c(0), c(3), Channel::Zero, Channel::One],
        6 => [c(0), c(1), Channel::Zero, Channel::One],
        n => return Err(ImageError::damaged(F, format!("UASTC has no channels of kind {n}"))),
    };
    Ok(Texels { width, height, channels: 4, pixels: Pixels::U8(out), map })
}

/// Reads a block from its lowest bit up.
struct Bits {
    block: u128,
    at: u32,
}

impl Bits {
    fn take(&mut self, n: u32) -> u32 {
        let v = self.block.checked_shr(self.at).unwrap_or(0) as u32;
        self.at += n;
        v & ((1 << n) - 1)
    }
}

/// The texels of a block, row by row; `None` if its mode or pattern does not exist.
fn block(bytes: [u8; 16]) -> Option<[Rgba; 16]> {
    let mut bits = Bits { block: u128::from_le_bytes(bytes), at: 0 };
    let start = bytes[0];
    let number = MODES.iter().position(|m| start & ((1u16 << m.code.1) - 1) as u8 == m.code.0)?;
    let m = &MODES[number];
    bits.take(m.code.1);
    if number == SOLID {
        return Some([[0; 4].map(|_: u8| bits.take(8) as u8); 16]);
    }
    bits.take(m.hints);
    let pattern = match m.subsets {
        1 => None,
        3 => Some(*PATTERNS_3.get(bits.take(4) as usize)?),
        _ if number == 7 => Some(*PATTERNS_7.get(bits.take(5) as usize)?),
        _ => Some(*PATTERNS_2.get(bits.take(5) as usize)?),
    };
    // The channel that the second plane weighs.
    let second = match (m.planes, m.channels) {
        (1, _) => None,
        (_, 2) => Some(3),
        _ => Some(bits.take(2) as usize),
    };
    let ends = endpoints(&mut bits, m);
    let subset: [usize; 16] = pattern.map_or([0; 16], |p| subsets(p, m.subsets));

    let mut out = [[0; 4]; 16];
    let mut started = [false; 3];
    for (texel, &s) in out.iter_mut().zip(&subset) {
        // The highest bit of the first weight of a subset is 0 and left out.
        let anchor = !std::mem::replace(&mut started[s], true);
        let n = m.weight_bits - u32::from(anchor);
        let first = weight(bits.take(n), m.weight_bits);
        let other = if m.planes == 2 { weight(bits.take(n), m.weight_bits) } else { first };
        for (c, v) in texel.iter_mut().enumerate() {
            let w = if second == Some(c) { other } else { first };
            *v = between(ends[s][0][c], ends[s][1][c], w);
        }
    }
    Some(out)
}

/// The pairs of colours: bounded integers as in ASTC (Khronos Data Format 1.3, 23.12), but all digits before all bits.
fn endpoints(bits: &mut Bits, m: &Mode) -> [[Rgba; 2]; 3] {
    let Range { bits: low, base } = m.endpoint;
    let count = 2 * m.channels * m.subsets;
    let mut digits = [0; 18];
    // Five digits to base 3 share eight bits, three to base 5 seven; fewer digits share fewer.
    let widths: &[u32] = match base {
        3 => &[0, 2, 4, 5, 7, 8],
        5 => &[0, 3, 5, 7],
        _ => &[0],
    };
    if base > 1 {
        for group in digits[..count].chunks_mut(widths.len() - 1) {
            let mut v = bits.take(widths[group.len()]);
            for d in group {
                *d = v % base;
                v /= base;
            }
        }
    }
    let mut values = [0; 18];
    for (v, d) in values[..count].iter_mut().zip(digits) {
        *v = unquantised(bits.take(low), d, m.endpoint);
    }
    let mut out = [[[255; 4]; 2]; 3];
    for (pair, v) in out.iter_mut().zip(values.chunks_exact(2 * m.channels)).take(m.subsets) {
        for (end, colour) in pair.iter_mut().enumerate() {
            *colour = match m.channels {
                2 => [v[end], v[end], v[end], v[2 + end]],
                3 => [v[end], v[2 + end], v[4 + end], 255],
                _ => [v[end], v[2 + end], v[4 + end], v[6 + end]],
            };
        }
    }
    out
}

/// A component from its low bits and its digit (Khronos Data Format 1.3, 23.13, tables 140 and 141).
fn unquantised(low: u32, digit: u32, range: Range) -> u8 {
    let bit = |i: u32| low >> i & 1;
    // Bits b, c, d, e, f of the low part, spread as the tables' strings say, the factor of the digit.
    let (spread, factor) = match (range.base, range.bits) {
        (1, n) => {
            let mut v = low << (8 - n);
            let mut have = n;
            while have < 8 {
                v |= v >> have;
                have *= 2;
            }
            return v as u8;
        }
        // b000b0bb0
        (3, 2) => (bit(1) * 0b1_0001_0110, 93),
        // dcb000dcb
        (3, 4) => ((low >> 1) * 0b0_0100_0001, 22),
        // fedcb000f
        (3, 6) => ((low >> 1) << 4 | bit(5), 5),
        // cb0000cbc
        (5, 3) => ((low >> 1) << 7 | (low >> 1) << 1 | bit(2), 26),
        // edcb0000e
        (_, _) => ((low >> 1) << 5 | bit(4), 6),
    };
    let all = bit(0) * 0x1ff;
    let t = (digit * factor + spread) ^ all;
    (all & 0x80 | t >> 2) as u8
}

/// A weight of `bits` bits as 0..64.
fn weight(v: u32, bits: u32) -> u32 {
    // Repeated to six bits.
    let v = match bits {
        1 => v * 63,
        2 => v * 21,
        3 => v * 9,
        4 => v << 2 | v >> 2,
        _ => v << 1 | v >> 4,
    };
    v + u32::from(v > 32)
}

/// Interpolates in 16 bits, as ASTC does for linear colours; for sRGB too, as transcoders do (ASTC itself would add half a
/// step to sRGB, which can change the last bit).
fn between(a: u8, b: u8, weight: u32) -> u8 {
    let [a, b] = [a, b].map(|v| u32::from(v) * 257);
    ((a * (64 - weight) + b * weight + 32) >> 6 >> 8) as u8
}

/// The subset of each texel of ASTC's pattern `seed` for small blocks (Khronos Data Format 1.3, 23.16).
fn subsets(seed: u16, count: usize) -> [usize; 16] {
    let seed = u32::from(seed) + (count as u32 - 1) * 1024;
    let r = hash(seed);
    let square = |shift: u32| {
        let v = r.rotate_right(shift) & 15;
        v * v
    };
    let third = count == 3;
    let (mut one, mut two) = (if seed & 2 != 0 { 4 } else { 5 }, if third { 6 } else { 5 });
    if seed & 1 == 0 {
        (one, two) = (two, one);
    }
    let factor = |i: u32, shift: u32| square(4 * i) >> shift;
    let line = |i: u32, x: u32, y: u32, offset: u32| {
        (factor(i, one) * x + factor(i + 1, two) * y + (r >> offset)) & 63
    };
    std::array::from_fn(|i| {
        // A block of few texels is taken for one of twice the size.
        let (x, y) = (2 * (i as u32 % 4), 2 * (i as u32 / 4));
        let (a, b) = (line(0, x, y, 14), line(2, x, y, 10));
        let c = if third { line(4, x, y, 6) } else { 0 };
        if a >= b && a >= c {
            0
        } else if b >= c {
            1
        } else {
            2
        }
    })
}

/// The hash that patterns are drawn from (`hash52` of the specification).
fn hash(mut p: u32) -> u32 {
    p ^= p >> 15;
    p = p.wrapping_sub(p << 17);
    p = p.wrapping_add(p << 7);
    p = p.wrapping_add(p << 4);
    p ^= p >> 5;
    p = p.wrapping_add(p << 16);
    p ^= p >> 7;
    p ^= p >> 3;
    p ^= p << 6;
    p ^ p >> 17
}
