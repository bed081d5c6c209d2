//! Skies: pictures of all directions, read so that no pixel can spoil a render.

mod cube;
mod exr;
mod layout;

use std::io::Read;
use std::path::Path;

use etendue_color::{srgb_decode, srgb8_decode};

use crate::dds::{decode_dds, is_dds};
use crate::decode::{DecodeLimits, decode, unknown_format};
use crate::hdr::{decode_hdr, is_hdr};
use crate::{Image, ImageError, Ktx2, Pixels};
pub use cube::lat_long_of_cube;
pub use layout::SkyLayout;

/// A picture of the surroundings, fit to be a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Linear Rec.709, three floats per pixel, all finite and not negative, latitude-longitude. Alpha, where the file has it, is left
    /// out.
    pub image: Image,
    /// Pixels that had a NaN, an infinity or a negative value in the file.
    pub repaired: u64,
    /// What was done to the picture beyond decoding it, or left undone, each a sentence for the user.
    pub notes: Vec<String>,
}

/// What a file holds.
struct Raw {
    /// One picture, or the six faces of a cube as [`cube`] has them; linear, three floats per pixel.
    pictures: Vec<Image>,
    /// What the file says of its layout.
    layout: Option<SkyLayout>,
    notes: Vec<String>,
}

/// Reads a sky from a file; see [`decode_environment`].
///
/// # Errors
/// Those of [`decode_environment`] and of the operating system, naming the file.
pub fn read_environment(path: &Path) -> Result<Environment, ImageError> {
    read_environment_as(path, None)
}

/// Reads a sky from a file; see [`decode_environment_as`].
///
/// # Errors
/// Those of [`decode_environment`] and of the operating system, naming the file.
pub fn read_environment_as(path: &Path, layout: Option<SkyLayout>) -> Result<Environment, ImageError> {
    let limits = DecodeLimits::default();
    let mut bytes = Vec::new();
    // Bounded, because a path may name a device that never ends.
    let read = std::fs::File::open(path).and_then(|f| f.take(limits.max_bytes).read_to_end(&mut bytes));
    read.map_err(|e| ImageError::from(e).in_file(path))?;
    decode_environment_as(&bytes, &limits, layout).map_err(|e| e.in_file(path))
}

/// Decodes a sky, the format being told by the first bytes, the layout by what the file says, its size, and empty corners.
///
/// - Radiance: see the format's orientations, `EXPOSURE`, `COLORCORR` and XYZE, all honoured.
/// - OpenEXR: the first flat part that has R, G, B or Y channels (those without a layer name first); data outside the display window are cut off,
///   a smaller data window is surrounded by black; other `chromaticities` are converted to Rec.709.
/// - PNG, JPEG, WebP: taken as sRGB and decoded to linear light, which clips at 1.
/// - KTX2 and DDS: the largest mip of the first cube, or of the first picture; linear or sRGB as they say.
///
/// A cube, in whatever [`SkyLayout`], becomes a latitude-longitude picture four faces wide.
///
/// Before that it is repaired: NaN becomes 0, a negative value 0, +∞ the largest finite value of the picture (65504 if it has none
/// above 0).
///
/// # Errors
/// [`ImageError::UnknownFormat`], [`ImageError::Damaged`], [`ImageError::Unsupported`] (deep data,
/// subsampled luminance-chroma), [`ImageError::TooLarge`].
pub fn decode_environment(bytes: &[u8], limits: &DecodeLimits) -> Result<Environment, ImageError> {
    decode_environment_as(bytes, limits, None)
}

/// The same for a layout that is known: what the file says or looks like does not count then.
///
/// # Errors
/// As [`decode_environment`]; [`ImageError::Unsupported`] if the picture's size is not one of that layout.
pub fn decode_environment_as(
    bytes: &[u8],
    limits: &DecodeLimits,
    layout: Option<SkyLayout>,
) -> Result<Environment, ImageError> {
    let Raw { mut pictures, layout: said, mut notes } = raw(bytes, limits)?;
    // Before pixels are mixed, so that a bad one spoils none but itself.
    let repaired = repair(&mut pictures);
    if repaired > 0 {
        notes.push(format!("{repaired} pixels were not finite or negative and were repaired"));
    }
    let (size, given) = ((pictures[0].width, pictures[0].height), pictures.len());
    let faces = match (layout, given) {
        (None | Some(SkyLayout::Strip), 6) => Some(pictures),
        (Some(SkyLayout::StripExr), 6) => Some(layout::turned(pictures)),
        (Some(other), 6) => return Err(ImageError::unsupported("a cube", format!("the layout {other}"))),
        (wanted, _) => {
            let picture = pictures.swap_remove(0);
            let layout = wanted.or(said).unwrap_or_else(|| layout::detect(&picture));
            if layout == SkyLayout::LatLong {
                return Ok(Environment { image: picture, repaired, notes });
            }
            if wanted.is_none() && said.is_none() {
                notes.push(format!("{} × {} pixels: taken as {layout}", size.0, size.1));
            }
            Some(layout::faces(&picture, layout)?)
        }
    };
    let faces = faces.unwrap_or_default();
    let n = faces.first().map_or(0, |f| f.width);
    let (w, h) = (4 * u64::from(n), 2 * u64::from(n));
    limits.check("a cube's", (w, h), w.saturating_mul(h).saturating_mul(12), usize::MAX, 1)?;
    notes.push(format!("a cube map of {n} × {n} pixels, made into {w} × {h}"));
    Ok(Environment { image: lat_long_of_cube(&faces, |d| d), repaired, notes })
}

/// The pictures of a file as linear floats.
fn raw(bytes: &[u8], limits: &DecodeLimits) -> Result<Raw, ImageError> {
    let plain = |pictures| Raw { pictures, layout: None, notes: Vec::new() };
    if is_hdr(bytes) {
        let h = decode_hdr(bytes, limits)?;
        return Ok(Raw { pictures: vec![h.image], layout: None, notes: h.notes });
    }
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return exr::decode_exr(bytes, limits);
    }
    if is_dds(bytes) {
        let dds = decode_dds(bytes, limits)?;
        return Ok(plain(dds.faces.iter().map(|f| linear_rgb(f, dds.srgb)).collect()));
    }
    if bytes.starts_with(b"\xabKTX 2") {
        let file = Ktx2::new(bytes, limits)?;
        if file.depth() > 1 {
            return Err(ImageError::unsupported("KTX2", "a volume as a sky"));
        }
        let mut pictures = file.mip(0)?;
        pictures.truncate(file.faces() as usize);
        return Ok(plain(pictures.iter().map(|f| linear_rgb(f, file.is_srgb())).collect()));
    }
    let image = match decode(bytes, limits) {
        Err(ImageError::UnknownFormat { .. }) => {
            return Err(unknown_format(bytes, "Radiance HDR, OpenEXR, KTX2, DDS, PNG, JPEG, WebP"));
        }
        r => r?,
    };
    let note = "decoded from sRGB: its light ends at 1".to_string();
    Ok(Raw { pictures: vec![linear_rgb(&image, true)], layout: None, notes: vec![note] })
}

/// Makes all samples finite and not negative; returns the number of pixels touched.
fn repair(pictures: &mut [Image]) -> u64 {
    let samples = |i: &Image| match &i.pixels {
        Pixels::F32(p) => p.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max),
        _ => 0.0,
    };
    let largest = pictures.iter().map(samples).fold(0.0, f32::max);
    let bright = if largest > 0.0 { largest } else { 65504.0 };
    let mut count = 0;
    for picture in pictures {
        if let Pixels::F32(p) = &mut picture.pixels {
            count += repair_samples(p, bright);
        }
    }
    count
}

fn repair_samples(rgb: &mut [f32], bright: f32) -> u64 {
    let mut count = 0;
    for pixel in rgb.chunks_exact_mut(3) {
        let mut touched = false;
        for v in pixel {
            let good = if v.is_nan() || *v < 0.0 {
                0.0
            } else if v.is_infinite() {
                bright
            } else {
                continue;
            };
            *v = good;
            touched = true;
        }
        count += u64::from(touched);
    }
    count
}

/// A picture as linear RGB floats. Alpha of whole numbers multiplies, because what is not there shines not; that of floats is left
/// out.
fn linear_rgb(image: &Image, srgb: bool) -> Image {
    let (n, grey) = (image.channels as usize, image.channels < 3);
    let value = |i: usize| match &image.pixels {
        Pixels::U8(p) if srgb => srgb8_decode(p[i]),
        Pixels::U8(p) => f32::from(p[i]) / 255.0,
        Pixels::U16(p) if srgb => srgb_decode(f32::from(p[i]) / 65535.0),
        Pixels::U16(p) => f32::from(p[i]) / 65535.0,
        Pixels::F32(p) => p[i],
    };
    let alpha = |i: usize| match &image.pixels {
        Pixels::U8(p) => f32::from(p[i]) / 255.0,
        Pixels::U16(p) => f32::from(p[i]) / 65535.0,
        Pixels::F32(_) => 1.0,
    };
    let mut out = Vec::with_capacity(image.width as usize * image.height as usize * 3);
    for i in (0..image.len()).step_by(n) {
        let a = if n.is_multiple_of(2) { alpha(i + n - 1) } else { 1.0 };
        for c in 0..3 {
            out.push(value(i + if grey { 0 } else { c }) * a);
        }
    }
    Image { width: image.width, height: image.height, channels: 3, pixels: Pixels::F32(out) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(p: Vec<f32>) -> [Image; 1] {
        [Image { width: p.len() as u32 / 3, height: 1, channels: 3, pixels: Pixels::F32(p) }]
    }

    #[test]
    fn repair_counts_pixels_and_keeps_the_rest() {
        let mut p = row(vec![1.0, 2.0, 3.0, f32::NAN, -1.0, 5.0, f32::INFINITY, 0.0, f32::NEG_INFINITY]);
        assert_eq!(repair(&mut p), 2);
        assert_eq!(p, row(vec![1.0, 2.0, 3.0, 0.0, 0.0, 5.0, 5.0, 0.0, 0.0]));
        let mut p = row(vec![f32::INFINITY; 3]);
        assert_eq!(repair(&mut p), 1);
        assert_eq!(p, row(vec![65504.0; 3]));
    }
}
