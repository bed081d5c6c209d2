//! Appendix B: what is done to decoded attributes.

use super::Filter;
use std::f32::consts::FRAC_1_SQRT_2;

/// Applies `filter` to elements of `stride` bytes, which goes with it.
pub(super) fn apply(filter: Filter, bytes: &mut [u8], stride: usize) {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => {
            each(bytes, |b: [u8; 4]| octahedral(b.map(|v| (v as i8).into()), 127.0).map(|v| v as i8 as u8));
        }
        (Filter::Octahedral, _) => {
            each(bytes, |b: [u8; 8]| from_words(octahedral(words(b), 32767.0).map(|v| v as i16 as u16)));
        }
        (Filter::Quaternion, _) => {
            each(bytes, |b: [u8; 8]| from_words(quaternion(words(b)).map(|v| v as i16 as u16)));
        }
        (Filter::Exponential, _) => {
            each(bytes, |b: [u8; 4]| exponential(i32::from_le_bytes(b)).to_le_bytes())
        }
        (Filter::Color, 4) => {
            each(bytes, |[y, co, cg, a]: [u8; 4]| {
                color(y.into(), (co as i8).into(), (cg as i8).into(), a.into(), 255.0).map(|v| v as u8)
            });
        }
        (Filter::Color, _) => {
            each(bytes, |b: [u8; 8]| {
                let [y, co, cg, a] = words(b);
                let unsigned = |v: i32| v & 0xffff;
                from_words(color(unsigned(y), co, cg, unsigned(a), 65535.0).map(|v| v as u16))
            });
        }
    }
}

fn each<const N: usize>(bytes: &mut [u8], f: impl Fn([u8; N]) -> [u8; N]) {
    for chunk in bytes.as_chunks_mut::<N>().0 {
        *chunk = f(*chunk);
    }
}

/// Four signed numbers of 16 bits.
fn words(b: [u8; 8]) -> [i32; 4] {
    std::array::from_fn(|i| i16::from_le_bytes([b[2 * i], b[2 * i + 1]]).into())
}

fn from_words(v: [u16; 4]) -> [u8; 8] {
    let mut out = [0; 8];
    for (o, v) in out.chunks_exact_mut(2).zip(v) {
        o.copy_from_slice(&v.to_le_bytes());
    }
    out
}

/// Filter 1. The third component says what 1 is; the fourth is left alone. What the text leaves open (a third component
/// that is no 1) gives numbers in range.
fn octahedral([x, y, one, last]: [i32; 4], max: f32) -> [f32; 4] {
    let one = one as f32;
    let (mut x, mut y) = (x as f32 / one, y as f32 / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded over.
    let t = z.min(0.0);
    x -= t.copysign(x);
    y -= t.copysign(y);
    let scale = max / (x * x + y * y + z * z).sqrt();
    [(x * scale).round(), (y * scale).round(), (z * scale).round(), last as f32]
}

/// Filter 2. The fourth number says what 1 is, and in its lowest bits which component is missing.
fn quaternion(v: [i32; 4]) -> [f32; 4] {
    let scale = FRAC_1_SQRT_2 / (v[3] | 3) as f32;
    let [x, y, z] = [0, 1, 2].map(|i| v[i] as f32 * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let missing = (v[3] & 3) as usize;
    let mut out = [0.0; 4];
    for (i, c) in [w, x, y, z].into_iter().enumerate() {
        out[(missing + i) % 4] = (c * 32767.0).round();
    }
    out
}

/// Filter 3: eight bits of exponent and 24 of mantissa, both signed; exact where the result is a normal float.
fn exponential(v: i32) -> f32 {
    let power = f64::from_bits(((i64::from(v >> 24) + 1023) << 52) as u64);
    (f64::from(v << 8 >> 8) * power) as f32
}

/// Filter 4. The highest bit of alpha says how many bits the numbers have.
fn color(y: i32, co: i32, cg: i32, a: i32, max: f32) -> [f32; 4] {
    let all = (1 << (32 - a.leading_zeros())) - 1;
    let alpha = a & all >> 1;
    let scale = max / all.max(1) as f32;
    let scaled = |v: i32| (v as f32 * scale).round();
    [y + co - cg, y + cg, y - co - cg, alpha << 1 | alpha & 1].map(scaled)
}
