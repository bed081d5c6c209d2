//! DDS: the largest mip of a picture or a cube of light (Microsoft, "Programming Guide for DDS").
//!
//! Read: half, single and packed floats, BC6H, and whole numbers of 8, 10 and 16 bits, with a DX10 header; without one, what the older
//! header says of masks and of the numbers of Direct3D 9. Not read: other block compressions, volumes.

use crate::ktx2::{PlainSample, plain_picture};
use crate::{DecodeLimits, Image, ImageError, Pixels, bc6h};

const F: &str = "DDS";

/// What a file shows.
pub(crate) struct Dds {
    /// One picture, or six faces: +X, −X, +Y, −Y, +Z, −Z.
    pub faces: Vec<Image>,
    /// Whether colours are encoded.
    pub srgb: bool,
}

/// What a texel is.
enum Texel {
    /// So many bytes, with these samples.
    Plain(u32, Vec<PlainSample>),
    Bc6h {
        signed: bool,
    },
}

pub(crate) fn is_dds(bytes: &[u8]) -> bool {
    bytes.starts_with(b"DDS ")
}

fn word(b: &[u8], at: usize) -> u32 {
    b.get(at..at + 4).map_or(0, |w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]))
}

/// Reads the largest mip; of an array the first picture or cube.
pub(crate) fn decode_dds(bytes: &[u8], limits: &DecodeLimits) -> Result<Dds, ImageError> {
    let bad = |cause: String| Err(ImageError::damaged(F, cause));
    if bytes.len() < 128 || word(bytes, 4) != 124 || word(bytes, 76) != 32 {
        return bad("the header is cut off or has not its size".into());
    }
    let (height, width, mips) = (word(bytes, 12), word(bytes, 16), word(bytes, 28).max(1));
    let flags = word(bytes, 80);
    let four = &bytes[84..88];
    let is_new = flags & 0x4 != 0 && four == b"DX10";
    if is_new && bytes.len() < 148 {
        return bad("the DX10 header is cut off".into());
    }
    let caps = word(bytes, 112);
    // Direct3D 10 says it in one flag; the older header has a flag for each face.
    let cube = if is_new { word(bytes, 136) & 0x4 != 0 } else { caps & 0x200 != 0 };
    if cube && !is_new && caps & 0xfc00 != 0xfc00 {
        return Err(ImageError::unsupported(F, "a cube that lacks faces"));
    }
    if caps & 0x20_0000 != 0 || is_new && word(bytes, 132) == 4 {
        return Err(ImageError::unsupported(F, "a volume"));
    }
    if cube && width != height {
        return bad(format!("a cube whose faces are {width} × {height}"));
    }
    if mips > 32 - width.max(height).leading_zeros() {
        return bad(format!("{mips} mips of {width} × {height}"));
    }
    let (texel, srgb) = match is_new {
        true => direct3d10(word(bytes, 128))?,
        false if flags & 0x4 != 0 => direct3d9(word(bytes, 84))?,
        false => masks(flags, word(bytes, 88), std::array::from_fn(|i| word(bytes, 92 + 4 * i)))?,
    };
    let count = if cube { 6 } else { 1 };
    let pixels = u64::from(width) * u64::from(height);
    // Within the limits, so that sizes fit.
    limits.check(F, (width.into(), height.into()), pixels.saturating_mul(16 * count), usize::MAX, 1)?;
    let size = |mip: u32| {
        let (w, h) = ((width >> mip).max(1), (height >> mip).max(1));
        match &texel {
            Texel::Plain(n, _) => u64::from(w) * u64::from(h) * u64::from(*n),
            Texel::Bc6h { .. } => bc6h::size(w, h),
        }
    };
    let whole: u64 = (0..mips).map(size).sum();
    let start = if is_new { 148u64 } else { 128 };
    let mut faces = Vec::new();
    for face in 0..count {
        let at = start + face * whole;
        let Some(part) = bytes.get(at as usize..(at + size(0)) as usize) else {
            return bad(format!("{} bytes, which end within picture {face}", bytes.len()));
        };
        faces.push(match &texel {
            Texel::Plain(n, samples) => plain_picture(part, (width, height), *n, samples)?,
            Texel::Bc6h { signed } => {
                let pixels = Pixels::F32(bc6h::image(part, width, height, *signed));
                Image { width, height, channels: 3, pixels }
            }
        });
    }
    Ok(Dds { faces, srgb })
}

/// Samples of equal width one after another, of the channels in `order`.
fn row(bits: u32, order: &[u8], float: bool) -> Texel {
    let sample = |(i, c): (usize, &u8)| PlainSample {
        bit: bits * i as u32,
        bits,
        channel: if *c == 3 { 15 } else { *c },
        float,
        // Floats of these widths have a sign.
        signed: float,
        exponent: false,
    };
    Texel::Plain(bits / 8 * order.len() as u32, order.iter().enumerate().map(sample).collect())
}

/// Samples of the given widths from the lowest bit on, of a word of 32 bits.
fn packed(widths: &[u32], float: bool) -> Texel {
    let mut bit = 0;
    let sample = |(i, &bits): (usize, &u32)| {
        bit += bits;
        let channel = if i == 3 { 15 } else { i as u8 };
        PlainSample { bit: bit - bits, bits, channel, float, signed: false, exponent: false }
    };
    Texel::Plain(4, widths.iter().enumerate().map(sample).collect())
}

/// Three mantissas of nine bits and their exponent.
fn shared_exponent() -> Texel {
    let mut texel = packed(&[9, 9, 9, 5], false);
    if let Texel::Plain(_, samples) = &mut texel {
        samples[3].exponent = true;
    }
    texel
}

/// A format of DXGI, and whether it is sRGB.
fn direct3d10(format: u32) -> Result<(Texel, bool), ImageError> {
    let texel = match format {
        2 => row(32, &[0, 1, 2, 3], true),
        6 => row(32, &[0, 1, 2], true),
        10 => row(16, &[0, 1, 2, 3], true),
        11 => row(16, &[0, 1, 2, 3], false),
        24 => packed(&[10, 10, 10, 2], false),
        26 => packed(&[11, 11, 10], true),
        28 | 29 => row(8, &[0, 1, 2, 3], false),
        67 => shared_exponent(),
        87 | 91 => row(8, &[2, 1, 0, 3], false),
        // The fourth byte is nothing.
        88 | 93 => match row(8, &[2, 1, 0], false) {
            Texel::Plain(_, samples) => Texel::Plain(4, samples),
            other => other,
        },
        95 => Texel::Bc6h { signed: false },
        96 => Texel::Bc6h { signed: true },
        n => return Err(ImageError::unsupported(F, format!("texels of DXGI format {n}"))),
    };
    Ok((texel, matches!(format, 29 | 91 | 93)))
}

/// The number of a format of Direct3D 9 in place of four letters.
fn direct3d9(code: u32) -> Result<(Texel, bool), ImageError> {
    match code {
        36 => Ok((row(16, &[0, 1, 2, 3], false), false)),
        113 => Ok((row(16, &[0, 1, 2, 3], true), false)),
        116 => Ok((row(32, &[0, 1, 2, 3], true), false)),
        n => {
            let letters = n.to_le_bytes();
            let name = match std::str::from_utf8(&letters) {
                Ok(s) if s.chars().all(|c| c.is_ascii_graphic()) => s.to_owned(),
                _ => format!("Direct3D 9 format {n}"),
            };
            Err(ImageError::unsupported(F, format!("texels of {name}")))
        }
    }
}

/// Red, green, blue and alpha by masks. Such files do not say how colours are encoded; they were made to be shown: sRGB.
fn masks(flags: u32, bits: u32, masks: [u32; 4]) -> Result<(Texel, bool), ImageError> {
    let strange = || ImageError::unsupported(F, "texels without colours");
    if flags & 0x40 == 0 || !matches!(bits, 16 | 24 | 32) {
        return Err(strange());
    }
    let mut samples = Vec::new();
    for (i, &m) in masks.iter().enumerate() {
        let (bit, width) = (m.trailing_zeros(), m.count_ones());
        if m == 0 || i == 3 && flags & 0x1 == 0 {
            continue;
        }
        if m != ((1u64 << (bit + width)) - (1u64 << bit)) as u32 || bit + width > bits {
            return Err(strange());
        }
        let channel = if i == 3 { 15 } else { i as u8 };
        samples.push(PlainSample { bit, bits: width, channel, float: false, signed: false, exponent: false });
    }
    if samples.iter().filter(|s| s.channel < 3).count() != 3 {
        return Err(strange());
    }
    Ok((Texel::Plain(bits / 8, samples), true))
}
