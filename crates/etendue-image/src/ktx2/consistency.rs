//! Whether the parts of a file agree with one another: where they stand, how long mips are, what format and descriptor say.
//!
//! A reader could take many contradictions as they come, and show a picture that nobody meant. What only concerns people (names of writers,
//! numbers of other programs' formats, the order of keys) is let through; `remarks` speaks of it.

use super::container::{Container, Scheme};
use super::descriptor::{Descriptor, Model};
use super::{F, uastc};
use crate::{ImageError, bc6h};

fn bad<T>(cause: impl Into<String>) -> Result<T, ImageError> {
    Err(ImageError::damaged(F, cause.into()))
}

/// What is known of one of Vulkan's plain formats.
struct Plain {
    /// Bytes of a texel.
    bytes: u32,
    /// Bytes of what is swapped between orders of bytes (`typeSize`).
    unit: u32,
    /// Bits of each sample, if they are whole units.
    bits: Option<u32>,
    /// Floats (true) or numbers (false).
    float: bool,
    /// Encoded as sRGB (true), certainly not (false).
    srgb: Option<bool>,
}

/// The plain formats of Vulkan 1.0, in the order of their numbers.
fn plain(format: u32) -> Option<Plain> {
    let packed = |bytes, unit, float| Plain { bytes, unit, bits: None, float, srgb: None };
    Some(match format {
        1 => packed(1, 1, false),
        2..=8 => packed(2, 2, false),
        // Seven kinds of each: UNORM first, SRGB last.
        9..=57 => {
            let (group, kind) = ((format - 9) / 7, (format - 9) % 7);
            let bytes = [1, 2, 3, 3, 4, 4, 4][group as usize];
            let srgb = match kind {
                0 => Some(false),
                6 => Some(true),
                _ => None,
            };
            let unit = if group == 6 { 4 } else { 1 };
            Plain { bytes, unit, bits: Some(8), float: false, srgb }
        }
        58..=69 => packed(4, 4, false),
        // Seven kinds of each: SFLOAT last.
        70..=97 => {
            let bytes = 2 * ((format - 70) / 7 + 1);
            Plain { bytes, unit: 2, bits: Some(16), float: (format - 70) % 7 == 6, srgb: Some(false) }
        }
        // Three kinds of each, the last of which is floats.
        98..=121 => {
            let (unit, first) = if format < 110 { (4, 98) } else { (8, 110) };
            let bytes = unit * ((format - first) / 3 + 1);
            let float = (format - first) % 3 == 2;
            Plain { bytes, unit, bits: Some(8 * unit), float, srgb: Some(false) }
        }
        122 => packed(4, 4, true),
        123 => packed(4, 4, false),
        _ => return None,
    })
}

/// Refuses contradictions.
pub(super) fn check(c: &Container<'_>, d: &Descriptor) -> Result<(), ImageError> {
    places(c, d)?;
    format(c, d)?;
    levels(c, d)?;
    c.check_values()?;
    orientation(c)
}

/// The order and alignment of the parts (KTX 2.0, 3.7 to 3.11).
fn places(c: &Container<'_>, d: &Descriptor) -> Result<(), ImageError> {
    let p = &c.places;
    let mut end = 80 + 24 * c.levels.len() as u64;
    for (name, (offset, length), align) in [
        ("the data format descriptor", p.descriptor, 4),
        ("the key-value data", p.values, 4),
        ("the global data", p.global, 8),
    ] {
        if length == 0 {
            if offset != 0 {
                return bad(format!("{name} has a place but no length"));
            }
            continue;
        }
        if offset < end || offset % align != 0 {
            return bad(format!("{name} stands at byte {offset}, where it cannot"));
        }
        end = offset.saturating_add(length);
    }
    if c.scheme != Scheme::BasisLz && p.global.1 > 0 {
        return bad("global data without a scheme that has some");
    }
    // Texels without supercompression stand at multiples of their own size and of four.
    let align = match d.model {
        _ if c.scheme != Scheme::None => 1,
        Model::Plain => lcm(u64::from(d.texel_bytes.max(1)), 4),
        _ => 16,
    };
    for (mip, level) in c.levels.iter().enumerate().rev() {
        if level.offset < end || level.offset % align != 0 {
            return bad(format!("mip {mip} stands at byte {}, where it cannot", level.offset));
        }
        end = level.offset.saturating_add(level.bytes.len() as u64);
    }
    Ok(())
}

fn lcm(a: u64, b: u64) -> u64 {
    let gcd = |mut a: u64, mut b: u64| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    a / gcd(a, b) * b
}

/// The format against the descriptor.
fn format(c: &Container<'_>, d: &Descriptor) -> Result<(), ImageError> {
    let p = &c.places;
    if c.format > i32::MAX as u32 {
        return bad(format!("{:#x} is no format", c.format));
    }
    // "Prohibited formats" (KTX 2.0, table 1): whole numbers as floats, which no descriptor can say.
    let scaled = match c.format {
        9..=57 => matches!((c.format - 9) % 7, 2 | 3),
        58..=69 => matches!((c.format - 58) % 6, 2 | 3),
        70..=97 => matches!((c.format - 70) % 7, 2 | 3),
        _ => false,
    };
    if scaled {
        return bad(format!("the format {} is not for KTX 2", c.format));
    }
    let blocks = d.model != Model::Plain;
    if blocks && (!p.has_height || !p.has_levels) {
        return bad("blocks of texels without a height or without mips");
    }
    let known = plain(c.format);
    let contradiction = || bad(format!("the descriptor does not describe the format {}", c.format));
    let unit = match (&known, d.model) {
        (Some(f), Model::Plain) => {
            let sizes = f.bits.is_none_or(|bits| {
                d.samples.iter().all(|s| s.bits == bits) && d.samples.len() as u32 * bits == 8 * f.bytes
            });
            let kinds = d.samples.iter().all(|s| s.float == f.float);
            if d.texel_bytes != f.bytes || !sizes || !kinds || f.srgb.is_some_and(|srgb| srgb != d.srgb) {
                return contradiction();
            }
            Some(f.unit)
        }
        (Some(_), _) => return contradiction(),
        (None, Model::Bc6h) if !matches!(c.format, 143 | 144) => return contradiction(),
        (None, Model::Plain) if (124..=184).contains(&c.format) => return contradiction(),
        (None, Model::Plain) if c.format != 0 => match c.format {
            // Samples of ten and twelve bits in words of two bytes; their neighbours are of several planes or half the chroma.
            1_000_156_007..=1_000_156_009 | 1_000_156_017..=1_000_156_019 => Some(2),
            1_000_156_000..=1_000_156_033 => return contradiction(),
            // Sixteen bits with alpha first, and alpha alone.
            1_000_340_000 | 1_000_340_001 | 1_000_470_000 => Some(2),
            1_000_470_001 => Some(1),
            _ => None,
        },
        (None, _) => Some(1),
    };
    match unit {
        Some(unit) if unit != p.type_size => {
            bad(format!("a type size of {} where {unit} belongs", p.type_size))
        }
        _ => Ok(()),
    }
}

/// The lengths of mips, as far as they can be told without unpacking.
fn levels(c: &Container<'_>, d: &Descriptor) -> Result<(), ImageError> {
    for (mip, level) in c.levels.iter().enumerate() {
        let mip = mip as u32;
        if c.scheme == Scheme::BasisLz {
            if level.size != 0 {
                return bad(format!("mip {mip} under BasisLZ has an unpacked size"));
            }
            continue;
        }
        let (w, h) = ((c.width >> mip).max(1), (c.height >> mip).max(1));
        let one = match d.model {
            Model::Uastc => uastc::size(w, h),
            Model::Bc6h => bc6h::size(w, h),
            _ => u64::from(w).saturating_mul(h.into()).saturating_mul(d.texel_bytes.into()),
        };
        let whole = one.saturating_mul(c.images_of(mip));
        let stored = level.bytes.len() as u64;
        if level.size != whole || c.scheme == Scheme::None && stored != whole {
            return bad(format!(
                "mip {mip} of {stored} bytes, {} unpacked, where {whole} belong",
                level.size
            ));
        }
    }
    Ok(())
}

/// The value of `KTXorientation`, which says how rows and columns run: a letter for each dimension.
fn orientation(c: &Container<'_>) -> Result<(), ImageError> {
    let Some(value) = c.value("KTXorientation") else { return Ok(()) };
    let letters = value.strip_suffix(b"\0").unwrap_or(value);
    // Some writers leave the slices of a volume out.
    let dimensions = if c.places.has_height { 2 } else { 1 };
    let known = letters.iter().zip([b"rl", b"du", b"oi"]).all(|(l, pair)| pair.contains(l));
    // A volume of one slice has three letters, too.
    if !known
        || letters.len() < dimensions
        || letters.len() > 3
        || letters.len() > dimensions && dimensions == 1
    {
        return bad("KTXorientation does not say how the picture runs");
    }
    Ok(())
}
