//! BC6H, the block compression of light: 4 × 4 texels of three unsigned half floats in 16 bytes.
//!
//! A block holds a segment in the space of the half floats' bit patterns, which grow with the logarithm of light, and a
//! place of sixteen on it for each texel ("BC6H Format", Microsoft Direct3D 11; "Khronos Data Format Specification" 1.3,
//! section 20.2). Of the fourteen modes this encoder uses the four without partition: endpoints of 10 bits each, or
//! of 11, 12 and 16 bits for one end with 9, 8 and 4 bits of difference to the other. They differ in precision and reach; each block
//! takes the one with the least error. Two-segment modes would help blocks in which two hues meet; prefiltered skies have few.

/// Weights of the sixteen places, in 64ths.
const WEIGHTS: [i32; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];

/// The largest finite half float.
const LARGEST: i32 = 0x7bff;

/// A mode without partition.
struct Mode {
    /// Its number in the first five bits.
    bits: u32,
    /// Bits of an endpoint.
    endpoint: u32,
    /// Bits of the difference to the other; 0 if both stand as they are.
    delta: u32,
}

const MODES: [Mode; 4] = [
    Mode { bits: 0b00011, endpoint: 10, delta: 0 },
    Mode { bits: 0b00111, endpoint: 11, delta: 9 },
    Mode { bits: 0b01011, endpoint: 12, delta: 8 },
    Mode { bits: 0b01111, endpoint: 16, delta: 4 },
];

/// An endpoint of `bits` bits as 16 bits.
fn unquantize(v: i32, bits: u32) -> i32 {
    if bits >= 15 || v == 0 {
        v
    } else if v == (1 << bits) - 1 {
        0xffff
    } else {
        ((v << 16) + 0x8000) >> bits
    }
}

/// The nearest endpoint of `bits` bits to a 16-bit value.
fn quantize(v: f64, bits: u32) -> i32 {
    let top = (1 << bits) - 1;
    if bits >= 15 {
        return (v.round() as i32).clamp(0, top);
    }
    // Values stand for the middles of their intervals, save the first and the last.
    let near = (v / f64::from(1 << (16 - bits)) - 0.5).round() as i32;
    (near - 1..=near + 1)
        .map(|q| q.clamp(0, top))
        .min_by_key(|q| (f64::from(unquantize(*q, bits)) - v).abs() as i64)
        .unwrap_or(0)
}

/// Half-float bits of place `w` of the segment between two 16-bit values.
fn interpolate(a: i32, b: i32, w: i32) -> i32 {
    (((a * (64 - w) + b * w + 32) >> 6) * 31) >> 6
}

/// A block as found: quantised endpoints and places.
struct Packed {
    ends: [[i32; 3]; 2],
    places: [usize; 16],
    error: i64,
}

/// Compresses sixteen texels, rows from the top, of three half floats as bits; negative, infinite and NaN ones count as 0,
/// the largest and 0.
pub fn encode(texels: &[[u16; 3]; 16]) -> [u8; 16] {
    let bits = texels.map(|t| {
        t.map(|h| match h {
            0..=0x7bff => i32::from(h),
            0x7c00 => LARGEST,
            _ => 0,
        })
    });
    // In the 16-bit space of the endpoints: a half's bits are 31/64 of it.
    let points = bits.map(|t| t.map(|v| (f64::from(v) + 0.5) * 64.0 / 31.0));
    let (a, b) = segment(&points);
    let best = MODES
        .iter()
        .filter_map(|m| pack(&bits, &points, a, b, m).map(|p| (m, p)))
        .min_by_key(|(_, p)| p.error);
    match best {
        Some((mode, packed)) => write(mode, packed),
        None => [0; 16],
    }
}

/// The ends of a segment through points: along the axis of their greatest spread.
fn segment(points: &[[f64; 3]; 16]) -> ([f64; 3], [f64; 3]) {
    let mean: [f64; 3] = std::array::from_fn(|c| points.iter().map(|p| p[c]).sum::<f64>() / 16.0);
    let mut cov = [[0.0f64; 3]; 3];
    for p in points {
        for i in 0..3 {
            for j in 0..3 {
                cov[i][j] += (p[i] - mean[i]) * (p[j] - mean[j]);
            }
        }
    }
    // Power iteration from the diagonal's largest row.
    let start = (0..3).max_by(|i, j| cov[*i][*i].total_cmp(&cov[*j][*j])).unwrap_or(0);
    let mut axis = cov[start];
    for _ in 0..8 {
        let next: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| cov[i][j] * axis[j]).sum());
        let length = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !(length > 0.0) {
            return (mean, mean);
        }
        axis = next.map(|v| v / length);
    }
    let along = |p: &[f64; 3]| (0..3).map(|i| (p[i] - mean[i]) * axis[i]).sum::<f64>();
    let (low, high) =
        points.iter().map(along).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    let at = |t: f64| std::array::from_fn(|i| (mean[i] + t * axis[i]).clamp(0.0, 65535.0));
    (at(low), at(high))
}

/// Quantises a segment in a mode, gives each texel its place, fits the ends to the places by least squares, and again; `None` if
/// the ends are too far apart for the mode.
fn pack(
    bits: &[[i32; 3]; 16],
    points: &[[f64; 3]; 16],
    a: [f64; 3],
    b: [f64; 3],
    mode: &Mode,
) -> Option<Packed> {
    let (mut ends, mut best): ([[f64; 3]; 2], Option<Packed>) = ([a, b], None);
    for _ in 0..3 {
        let Some(packed) = places(bits, ends, mode) else { break };
        // Least squares: each texel is (1 − w) a + w b.
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
        let (mut pa, mut pb) = ([0.0; 3], [0.0; 3]);
        for (place, p) in packed.places.iter().zip(points) {
            let w = f64::from(WEIGHTS[*place]) / 64.0;
            aa += (1.0 - w) * (1.0 - w);
            ab += (1.0 - w) * w;
            bb += w * w;
            for c in 0..3 {
                pa[c] += (1.0 - w) * p[c];
                pb[c] += w * p[c];
            }
        }
        if best.as_ref().is_none_or(|b| packed.error < b.error) {
            best = Some(packed);
        }
        let det = aa * bb - ab * ab;
        if !(det > 1e-9) {
            break;
        }
        ends = [
            std::array::from_fn(|c| ((bb * pa[c] - ab * pb[c]) / det).clamp(0.0, 65535.0)),
            std::array::from_fn(|c| ((aa * pb[c] - ab * pa[c]) / det).clamp(0.0, 65535.0)),
        ];
    }
    best
}

fn places(bits: &[[i32; 3]; 16], ends: [[f64; 3]; 2], mode: &Mode) -> Option<Packed> {
    let mut q = ends.map(|e| e.map(|v| quantize(v, mode.endpoint)));
    if mode.delta > 0 {
        let half = 1 << (mode.delta - 1);
        // Symmetric, because the ends may change places below.
        if (0..3).any(|c| (q[1][c] - q[0][c]).abs() >= half) {
            return None;
        }
    }
    let full = q.map(|e| e.map(|v| unquantize(v, mode.endpoint)));
    let palette: [[i32; 3]; 16] =
        std::array::from_fn(|i| std::array::from_fn(|c| interpolate(full[0][c], full[1][c], WEIGHTS[i])));
    let mut error = 0i64;
    let mut places = bits.map(|t| {
        let distance = |p: &[i32; 3]| (0..3).map(|c| i64::from(p[c] - t[c]).pow(2)).sum::<i64>();
        let (i, d) = palette.iter().map(distance).enumerate().min_by_key(|(_, d)| *d).unwrap_or((0, 0));
        error += d;
        i
    });
    // The first texel's place is stored without its highest bit.
    if places[0] >= 8 {
        q.swap(0, 1);
        places = places.map(|p| 15 - p);
    }
    Some(Packed { ends: q, places, error })
}

/// A block's bits, from the lowest on.
struct Bits(u128, u32);

impl Bits {
    fn push(&mut self, value: u32, count: u32) {
        self.0 |= u128::from(value & ((1u64 << count) - 1) as u32) << self.1;
        self.1 += count;
    }

    fn take(&mut self, count: u32) -> i32 {
        let v = (self.0 >> self.1) as u32 & ((1u64 << count) - 1) as u32;
        self.1 += count;
        v as i32
    }
}

fn write(mode: &Mode, p: Packed) -> [u8; 16] {
    let mut out = Bits(0, 0);
    out.push(mode.bits, 5);
    for c in 0..3 {
        out.push(p.ends[0][c] as u32, 10);
    }
    let extra = mode.endpoint - 10;
    for c in 0..3 {
        if mode.delta == 0 {
            out.push(p.ends[1][c] as u32, 10);
            continue;
        }
        out.push((p.ends[1][c] - p.ends[0][c]) as u32, mode.delta);
        // The bits of the first end above the tenth, the highest first.
        for k in (0..extra).rev() {
            out.push(p.ends[0][c] as u32 >> (10 + k), 1);
        }
    }
    for (i, place) in p.places.iter().enumerate() {
        out.push(*place as u32, if i == 0 { 3 } else { 4 });
    }
    out.0.to_le_bytes()
}

/// Sixteen texels of three half floats as bits from a block in one of the modes that [`encode`] writes; `None` for other modes.
pub fn decode(block: &[u8; 16]) -> Option<[[u16; 3]; 16]> {
    let mut bits = Bits(u128::from_le_bytes(*block), 0);
    let number = bits.take(5) as u32;
    let mode = MODES.iter().find(|m| m.bits == number)?;
    let mut ends = [[0i32; 3]; 2];
    for c in 0..3 {
        ends[0][c] = bits.take(10);
    }
    for c in 0..3 {
        if mode.delta == 0 {
            ends[1][c] = bits.take(10);
            continue;
        }
        let delta = bits.take(mode.delta);
        let delta = if delta >> (mode.delta - 1) == 1 { delta - (1 << mode.delta) } else { delta };
        for k in (0..mode.endpoint - 10).rev() {
            ends[0][c] |= bits.take(1) << (10 + k);
        }
        ends[1][c] = (ends[0][c] + delta) & ((1 << mode.endpoint) - 1);
    }
    let full = ends.map(|e| e.map(|v| unquantize(v, mode.endpoint)));
    Some(std::array::from_fn(|i| {
        let w = WEIGHTS[bits.take(if i == 0 { 3 } else { 4 }) as usize];
        std::array::from_fn(|c| interpolate(full[0][c], full[1][c], w) as u16)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;
    use half::f16;

    fn halves(f: impl FnMut(usize) -> [f32; 3]) -> [[u16; 3]; 16] {
        let mut f = f;
        std::array::from_fn(|i| f(i).map(|v| f16::from_f32(v).to_bits()))
    }

    fn worst(texels: &[[u16; 3]; 16]) -> f32 {
        let back = decode(&encode(texels)).unwrap();
        let mut worst = 0.0f32;
        for (a, b) in back.iter().zip(texels) {
            for c in 0..3 {
                let (a, b) = (f16::from_bits(a[c]).to_f32(), f16::from_bits(b[c]).to_f32());
                worst = worst.max((a - b).abs() / b.max(1e-3));
            }
        }
        worst
    }

    #[test]
    fn flat_blocks_are_exact_to_a_step() {
        for v in [0.0, 1e-4, 0.03, 1.0, 17.3, 6e4, 65504.0] {
            let e = worst(&halves(|_| [v, 0.7 * v, 0.1 * v]));
            assert!(e < 2e-3, "{v}: {e}");
        }
    }

    #[test]
    fn smooth_blocks_are_good_and_steep_ones_fair() {
        let mut rng = Rng::new(6);
        for round in 0..500 {
            let base: [f32; 3] = std::array::from_fn(|_| f32::exp2(8.0 * rng.uniform() - 4.0));
            let steep = if round % 2 == 0 { 0.05 } else { 3.0 };
            let (gx, gy) = (steep * (rng.uniform() - 0.5), steep * (rng.uniform() - 0.5));
            let texels = halves(|i| {
                let t = gx * (i % 4) as f32 + gy * (i / 4) as f32;
                base.map(|b| b * t.exp2())
            });
            let e = worst(&texels);
            assert!(e < if round % 2 == 0 { 1.2e-2 } else { 0.5 }, "{round}: {e}");
        }
    }

    #[test]
    fn any_bits_are_encoded() {
        let mut rng = Rng::new(7);
        for _ in 0..500 {
            let texels: [[u16; 3]; 16] =
                std::array::from_fn(|_| std::array::from_fn(|_| (rng.uniform() * 65536.0) as u16));
            let back = decode(&encode(&texels)).unwrap();
            assert!(back.iter().flatten().all(|h| *h <= 0x7bff));
        }
    }
}
