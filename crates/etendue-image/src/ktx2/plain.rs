//! Plain samples: read bit by bit as the descriptor says, so that no list of formats is needed.

use super::descriptor::{Descriptor, Sample};
use super::{Channel, F, Texels};
use crate::{ImageError, Pixels};
use half::f16;

/// `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`, three mantissas and a common exponent.
const E5B9G9R9: u32 = 123;

/// What the samples are made into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Whole numbers of up to 8 bits, 0..1.
    Bits8,
    /// Whole numbers of up to 16 bits, 0..1.
    Bits16,
    Float,
}

/// Refuses what is no picture of colours.
pub(super) fn check(d: &Descriptor, format: u32) -> Result<(), ImageError> {
    if shared_exponent(d) {
        return if format == E5B9G9R9 && d.texel_bytes == 4 {
            Ok(())
        } else {
            Err(ImageError::unsupported(F, "exponents in samples of their own"))
        };
    }
    let mut seen = [false; 16];
    for s in &d.samples {
        match s.channel {
            0..3 | 15 => {}
            13 | 14 => return Err(ImageError::unsupported(F, "depth or stencil")),
            n => return Err(ImageError::unsupported(F, format!("a channel of kind {n}"))),
        }
        if std::mem::replace(&mut seen[usize::from(s.channel)], true) {
            return Err(ImageError::unsupported(F, "a channel in several samples"));
        }
        if s.float && !matches!((s.bits, s.signed), (16 | 32 | 64, true) | (10 | 11, false)) {
            return Err(ImageError::unsupported(F, format!("floats of {} bits", s.bits)));
        }
        if !s.float {
            if s.bits > 32 {
                return Err(ImageError::unsupported(F, format!("integers of {} bits", s.bits)));
            }
            // Integers that mean themselves have 1 for 1.
            let mask = u32::MAX >> (32 - s.bits);
            let full = if s.signed { mask >> 1 } else { mask };
            if s.upper != full || full == 0 || !s.signed && s.lower != 0 {
                return Err(ImageError::unsupported(F, "integers"));
            }
        }
    }
    Ok(())
}

fn shared_exponent(d: &Descriptor) -> bool {
    d.samples.iter().any(|s| s.exponent)
}

fn kind(d: &Descriptor) -> Kind {
    let widest = d.samples.iter().map(|s| s.bits).max().unwrap_or(0);
    if d.samples.iter().any(|s| s.float || s.signed) || widest > 16 {
        Kind::Float
    } else if widest > 8 {
        Kind::Bits16
    } else {
        Kind::Bits8
    }
}

/// Bytes of a decoded texel.
pub(super) fn bytes_per_texel(d: &Descriptor) -> u64 {
    let channels = d.samples.len() as u64;
    match kind(d) {
        _ if shared_exponent(d) => 12,
        Kind::Bits8 => channels,
        Kind::Bits16 => 2 * channels,
        Kind::Float => 4 * channels,
    }
}

/// One picture; `bytes` are those of its texels.
pub(super) fn image(bytes: &[u8], width: u32, height: u32, d: &Descriptor) -> Result<Texels, ImageError> {
    let texels = |channels, pixels, map| Ok(Texels { width, height, channels, pixels, map });
    let size = d.texel_bytes as usize;
    if shared_exponent(d) {
        let pixels = bytes.as_chunks::<4>().0.iter().flat_map(|b| {
            let v = u32::from_le_bytes(*b);
            // "EXT_texture_shared_exponent": nine bits each, a bias of 15.
            let scale = f32::exp2((v >> 27) as f32 - 24.0);
            [v, v >> 9, v >> 18].map(|m| (m & 511) as f32 * scale)
        });
        let map = [Channel::From(0), Channel::From(1), Channel::From(2), Channel::One];
        return texels(3, Pixels::F32(pixels.collect()), map);
    }
    // Samples in the order of their channels, red first.
    let mut samples = d.samples.clone();
    samples.sort_by_key(|s| s.channel);
    let mut map = [Channel::Zero, Channel::Zero, Channel::Zero, Channel::One];
    for (i, s) in samples.iter().enumerate() {
        map[usize::from(s.channel.min(3))] = Channel::From(i as u8);
    }
    let channels = samples.len() as u8;
    let each = || bytes.chunks_exact(size).flat_map(|t| samples.iter().map(move |s| (t, s)));
    let unit = |t: &[u8], s: &Sample, max: u64| {
        let range = u64::from(s.upper);
        (bits(t, s) * max + range / 2) / range
    };
    let pixels = match kind(d) {
        Kind::Bits8 => {
            let whole = samples.iter().enumerate().all(|(i, s)| s.bits == 8 && s.bit == 8 * i as u32);
            if whole && samples.len() == size {
                Pixels::U8(bytes.to_vec())
            } else {
                Pixels::U8(each().map(|(t, s)| unit(t, s, 255) as u8).collect())
            }
        }
        Kind::Bits16 => Pixels::U16(each().map(|(t, s)| unit(t, s, 65535) as u16).collect()),
        Kind::Float => Pixels::F32(each().map(|(t, s)| float(t, s)).collect()),
    };
    texels(channels, pixels, map)
}

/// The bits of a sample, which lie within the texel.
#[inline]
fn bits(texel: &[u8], s: &Sample) -> u64 {
    let first = (s.bit / 8) as usize;
    let mut window = [0; 16];
    let part = &texel[first..texel.len().min(first + 16)];
    window[..part.len()].copy_from_slice(part);
    let v = (u128::from_le_bytes(window) >> (s.bit % 8)) as u64;
    if s.bits < 64 { v & ((1 << s.bits) - 1) } else { v }
}

fn float(texel: &[u8], s: &Sample) -> f32 {
    let v = bits(texel, s);
    match (s.float, s.bits) {
        (true, 10) => small(v as u32, 5),
        (true, 11) => small(v as u32, 6),
        (true, 16) => f16::from_bits(v as u16).to_f32(),
        (true, 32) => f32::from_bits(v as u32),
        (true, _) => f64::from_bits(v) as f32,
        (false, n) if s.signed => {
            let v = (v << (64 - n)) as i64 >> (64 - n);
            (v as f32 / s.upper as f32).max(-1.0)
        }
        (false, _) => (v as f64 / f64::from(s.upper)) as f32,
    }
}

/// A float without a sign: five bits of exponent over `mantissa` bits (Vulkan, "Unsigned 11-Bit Floating-Point Numbers").
fn small(v: u32, mantissa: u32) -> f32 {
    f16::from_bits((v << (10 - mantissa)) as u16).to_f32()
}
