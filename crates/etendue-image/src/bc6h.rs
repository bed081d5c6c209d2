//! BC6H, the block compression of light: 4 × 4 texels of three half floats in 16 bytes, all fourteen modes.
//!
//! A block holds one or two segments in the space of the half floats' bit patterns, and for each texel a place on one of
//! them (Khronos, "Khronos Data Format Specification" 1.3, section 20.2 "BPTC"; Microsoft, "BC6H Format").

use half::f16;

/// How a block is laid out. Fields are written as the specification's table writes them: `gy0-3` are bits 0 to 3 of green of y, where
/// w and x end the first segment, y and z the second.
struct Mode {
    /// What the first two or five bits say.
    number: u8,
    /// Bits of the first endpoint.
    bits: u32,
    /// Bits of the others, red, green, blue.
    rest: [u32; 3],
    /// Whether the others are differences to the first.
    delta: bool,
    fields: &'static str,
}

#[rustfmt::skip]
const MODES: [Mode; 14] = [
    Mode { number: 0b00000, bits: 10, rest: [5, 5, 5], delta: true, fields:
        "gy4 by4 bz4 rw0-9 gw0-9 bw0-9 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3" },
    Mode { number: 0b00001, bits: 7, rest: [6, 6, 6], delta: true, fields:
        "gy5 gz4 gz5 rw0-6 bz0 bz1 by4 gw0-6 by5 bz2 gy4 bw0-6 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5" },
    Mode { number: 0b00010, bits: 11, rest: [5, 4, 4], delta: true, fields:
        "rw0-9 gw0-9 bw0-9 rx0-4 rw10 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-4 bz2 rz0-4 bz3" },
    Mode { number: 0b00110, bits: 11, rest: [4, 5, 4], delta: true, fields:
        "rw0-9 gw0-9 bw0-9 rx0-3 rw10 gz4 gy0-3 gx0-4 gw10 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-3 bz0 bz2 rz0-3 gy4 bz3" },
    Mode { number: 0b01010, bits: 11, rest: [4, 4, 5], delta: true, fields:
        "rw0-9 gw0-9 bw0-9 rx0-3 rw10 by4 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-4 bw10 by0-3 ry0-3 bz1 bz2 rz0-3 bz4 bz3" },
    Mode { number: 0b01110, bits: 9, rest: [5, 5, 5], delta: true, fields:
        "rw0-8 by4 gw0-8 gy4 bw0-8 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3" },
    Mode { number: 0b10010, bits: 8, rest: [6, 5, 5], delta: true, fields:
        "rw0-7 gz4 by4 gw0-7 bz2 gy4 bw0-7 bz3 bz4 rx0-5 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-5 rz0-5" },
    Mode { number: 0b10110, bits: 8, rest: [5, 6, 5], delta: true, fields:
        "rw0-7 bz0 by4 gw0-7 gy5 gy4 bw0-7 gz5 bz4 rx0-4 gz4 gy0-3 gx0-5 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3" },
    Mode { number: 0b11010, bits: 8, rest: [5, 5, 6], delta: true, fields:
        "rw0-7 bz1 by4 gw0-7 by5 gy4 bw0-7 bz5 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-5 by0-3 ry0-4 bz2 rz0-4 bz3" },
    Mode { number: 0b11110, bits: 6, rest: [6, 6, 6], delta: false, fields:
        "rw0-5 gz4 bz0 bz1 by4 gw0-5 gy5 by5 bz2 gy4 bw0-5 gz5 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5" },
    Mode { number: 0b00011, bits: 10, rest: [10, 10, 10], delta: false, fields:
        "rw0-9 gw0-9 bw0-9 rx0-9 gx0-9 bx0-9" },
    Mode { number: 0b00111, bits: 11, rest: [9, 9, 9], delta: true, fields:
        "rw0-9 gw0-9 bw0-9 rx0-8 rw10 gx0-8 gw10 bx0-8 bw10" },
    Mode { number: 0b01011, bits: 12, rest: [8, 8, 8], delta: true, fields:
        "rw0-9 gw0-9 bw0-9 rx0-7 rw11 rw10 gx0-7 gw11 gw10 bx0-7 bw11 bw10" },
    Mode { number: 0b01111, bits: 16, rest: [4, 4, 4], delta: true, fields:
        "rw0-9 gw0-9 bw0-9 rx0-3 rw15 rw14 rw13 rw12 rw11 rw10 gx0-3 gw15 gw14 gw13 gw12 gw11 gw10 bx0-3 bw15 bw14 bw13 bw12 bw11 bw10" },
];

/// Modes before this one have two segments.
const ONE_SEGMENT: usize = 10;

/// Which texels belong to the second segment, a bit each, for the 32 partitions.
const PARTITIONS: [u16; 32] = [
    0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80, 0xe800, 0xffe8,
    0xff00, 0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310, 0x3100, 0x8cce, 0x088c, 0x3110,
    0x6666, 0x366c, 0x17e8, 0x0ff0, 0x718e, 0x399c,
];

/// The texel of the second segment whose place has a bit less.
const ANCHORS: [u8; 32] = [
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2, 8, 2, 2, 8, 8, 15, 2, 8, 2, 2, 8,
    8, 2, 2,
];

/// Weights of the places, in 64ths.
const EIGHT: [i32; 8] = [0, 9, 18, 27, 37, 46, 55, 64];
const SIXTEEN: [i32; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];

/// A run of bits of an endpoint.
#[derive(Clone, Copy)]
struct Run {
    endpoint: usize,
    channel: usize,
    low: u32,
    count: u32,
}

/// Decodes blocks; the fields of all modes are laid out once.
pub(crate) struct Bc6h {
    runs: [Vec<Run>; 14],
    signed: bool,
}

/// The bits of a block from the lowest on.
struct Bits(u128);

impl Bits {
    fn take(&mut self, n: u32) -> i32 {
        let v = (self.0 & ((1 << n) - 1)) as i32;
        self.0 >>= n;
        v
    }
}

fn sign_extend(v: i32, bits: u32) -> i32 {
    (v << (32 - bits)) >> (32 - bits)
}

impl Bc6h {
    pub fn new(signed: bool) -> Self {
        let runs = MODES.map(|m| m.fields.split(' ').map(run).collect());
        Self { runs, signed }
    }

    /// Sixteen texels, rows from the top. A reserved mode is black, as the specification has it.
    pub fn block(&self, block: &[u8; 16]) -> [[f16; 3]; 16] {
        let mut bits = Bits(u128::from_le_bytes(*block));
        let low = block[0] & 31;
        let (number, used) = if low & 3 < 2 { (low & 3, 2) } else { (low, 5) };
        let Some(at) = MODES.iter().position(|m| m.number == number) else {
            return [[f16::ZERO; 3]; 16];
        };
        let mode = &MODES[at];
        bits.take(used);
        let mut ends = [[0i32; 3]; 4];
        for r in &self.runs[at] {
            ends[r.endpoint][r.channel] |= bits.take(r.count) << r.low;
        }
        let two = at < ONE_SEGMENT;
        let partition = if two { bits.take(5) as usize } else { 0 };
        for c in 0..3 {
            if self.signed {
                ends[0][c] = sign_extend(ends[0][c], mode.bits);
            }
            for e in 1..4 {
                if mode.delta {
                    let sum = ends[0][c] + sign_extend(ends[e][c], mode.rest[c]);
                    ends[e][c] = sum & ((1 << mode.bits) - 1);
                }
                if self.signed {
                    ends[e][c] = sign_extend(ends[e][c], mode.bits);
                }
            }
        }
        let ends = ends.map(|e| e.map(|v| self.unquantize(v, mode.bits)));
        std::array::from_fn(|i| {
            let second = usize::from(two && PARTITIONS[partition] >> i & 1 == 1);
            let anchor = i == 0 || two && i == usize::from(ANCHORS[partition]);
            let w = if two {
                EIGHT[bits.take(if anchor { 2 } else { 3 }) as usize]
            } else {
                SIXTEEN[bits.take(if anchor { 3 } else { 4 }) as usize]
            };
            let (a, b) = (ends[2 * second], ends[2 * second + 1]);
            std::array::from_fn(|c| self.finish((a[c] * (64 - w) + b[c] * w + 32) >> 6))
        })
    }

    /// An endpoint of `bits` bits as 16 bits.
    fn unquantize(&self, v: i32, bits: u32) -> i32 {
        if self.signed {
            if bits >= 16 || v == 0 {
                return v;
            }
            let (sign, v) = (v.signum(), v.abs());
            let full = if v >= (1 << (bits - 1)) - 1 { 0x7fff } else { ((v << 15) + 0x4000) >> (bits - 1) };
            return sign * full;
        }
        match v {
            _ if bits >= 15 => v,
            0 => 0,
            v if v == (1 << bits) - 1 => 0xffff,
            v => ((v << 16) + 0x8000) >> bits,
        }
    }

    /// The half float of an interpolated value.
    fn finish(&self, v: i32) -> f16 {
        if self.signed {
            let bits = (v.abs() * 31) >> 5;
            return f16::from_bits(bits as u16 | if v < 0 { 0x8000 } else { 0 });
        }
        f16::from_bits(((v * 31) >> 6) as u16)
    }
}

/// Bytes of a picture.
pub(crate) fn size(width: u32, height: u32) -> u64 {
    u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4)) * 16
}

/// The three floats of each texel of a picture whose blocks are `bytes`, rows from the top.
pub(crate) fn image(bytes: &[u8], width: u32, height: u32, signed: bool) -> Vec<f32> {
    let decoder = Bc6h::new(signed);
    let (w, h, across) = (width as usize, height as usize, width.div_ceil(4) as usize);
    let mut out = vec![0.0; 3 * w * h];
    for (i, block) in bytes.as_chunks::<16>().0.iter().enumerate() {
        let (x0, y0) = (i % across * 4, i / across * 4);
        for (k, texel) in decoder.block(block).iter().enumerate() {
            let (x, y) = (x0 + k % 4, y0 + k / 4);
            if x < w && y < h {
                out[3 * (y * w + x)..][..3].copy_from_slice(&texel.map(f16::to_f32));
            }
        }
    }
    out
}

/// `gy0-3` as a run; the strings are constants.
fn run(text: &str) -> Run {
    let b = text.as_bytes();
    let place = |letters: &[u8], l: u8| letters.iter().position(|x| *x == l).unwrap_or(0);
    let mut ends = text[2..].split('-').map(|n| n.parse().unwrap_or(0));
    let low = ends.next().unwrap_or(0);
    let high: u32 = ends.next().unwrap_or(low);
    Run { endpoint: place(b"wxyz", b[1]), channel: place(b"rgb", b[0]), low, count: high - low + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three random blocks of every mode, unsigned and signed, as another decoder (bcdec, by way of imagecodecs 2026.3.6) has them.
    #[test]
    fn every_mode_decodes_as_elsewhere() {
        let data = include_str!("../tests/data/bc6h.txt");
        let hex = |s: &str, n: usize| -> Vec<u16> {
            let digits = |i: usize| u16::from_str_radix(&s[i..i + n], 16).unwrap();
            (0..s.len()).step_by(n).map(digits).collect()
        };
        let mut count = 0;
        for line in data.lines() {
            let [block, kind, texels] = line.split(' ').collect::<Vec<_>>().try_into().unwrap();
            let block: Vec<u8> = hex(block, 2).iter().map(|v| *v as u8).collect();
            let got = Bc6h::new(kind == "s").block(&block.try_into().unwrap());
            let want = hex(texels, 4);
            // Zeros may have either sign.
            let same = |a: f16, b: u16| a.to_bits() == b || (a.to_bits() | b) & 0x7fff == 0;
            assert!(got.iter().flatten().zip(&want).all(|(a, b)| same(*a, *b)), "{line}\n{got:?}");
            count += 1;
        }
        assert_eq!(count, 84);
        assert_eq!(Bc6h::new(false).block(&[0x13; 16]), [[f16::ZERO; 3]; 16]);
    }

    #[test]
    fn fields_fill_their_blocks() {
        for (i, (m, runs)) in MODES.iter().zip(Bc6h::new(false).runs).enumerate() {
            let used = if m.number < 2 { 2 } else { 5 };
            let sum: u32 = runs.iter().map(|r| r.count).sum();
            assert_eq!(used + sum, if i < ONE_SEGMENT { 77 } else { 65 });
        }
    }
}
