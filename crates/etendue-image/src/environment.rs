//! Skies: pictures of all directions, read so that no pixel can spoil a render.

use std::io::Read;
use std::path::Path;

use etendue_color::{
    Matrix3, Primaries, REC709, bradford, matrix_apply, matrix_mul, rgb_to_xyz, srgb_decode, srgb8_decode,
    xyz_to_rgb,
};
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;

use crate::cube_strip::to_lat_long;
use crate::decode::{DecodeLimits, decode, unknown_format};
use crate::exr_read::{F as EXR, check_part, decode_rows, read_headers};
use crate::hdr::{decode_hdr, is_hdr};
use crate::{Image, ImageError, Pixels};

/// A picture of the surroundings, fit to be a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Linear Rec.709, three floats per pixel, all finite and not negative. Alpha, where the file has it, is left out.
    pub image: Image,
    /// Pixels that had a NaN, an infinity or a negative value in the file.
    pub repaired: u64,
    /// What was done to the picture beyond decoding it, or left undone, each a sentence for the user.
    pub notes: Vec<String>,
}

/// Reads a sky from a `.hdr`, `.exr`, PNG, JPEG or WebP file; see [`decode_environment`].
///
/// # Errors
/// Those of [`decode_environment`] and of the operating system, naming the file.
pub fn read_environment(path: &Path) -> Result<Environment, ImageError> {
    let limits = DecodeLimits::default();
    let mut bytes = Vec::new();
    // Bounded, because a path may name a device that never ends.
    let read = std::fs::File::open(path).and_then(|f| f.take(limits.max_bytes).read_to_end(&mut bytes));
    read.map_err(|e| ImageError::from(e).in_file(path))?;
    decode_environment(&bytes, &limits).map_err(|e| e.in_file(path))
}

/// Decodes a sky, the format being told by the first bytes.
///
/// - Radiance: see the format's orientations, `EXPOSURE`, `COLORCORR` and XYZE, all honoured.
/// - OpenEXR: the first flat part that has R, G, B or Y channels (those without a layer name first); data outside the display window are cut off,
///   a smaller data window is surrounded by black; other `chromaticities` are converted to Rec.709. A cube map (`envmap` says so: six faces
///   below one another) becomes a latitude-longitude picture four faces wide.
/// - PNG, JPEG, WebP: taken as sRGB and decoded to linear light, which clips at 1.
///
/// Then it is repaired: NaN becomes 0, a negative value 0, +∞ the largest finite value of the picture (65504 if it has none
/// above 0).
///
/// # Errors
/// [`ImageError::UnknownFormat`], [`ImageError::Damaged`], [`ImageError::Unsupported`] (deep data,
/// subsampled luminance-chroma), [`ImageError::TooLarge`].
pub fn decode_environment(bytes: &[u8], limits: &DecodeLimits) -> Result<Environment, ImageError> {
    let (mut image, mut notes, before) = if is_hdr(bytes) {
        let h = decode_hdr(bytes, limits)?;
        (h.image, h.notes, 0)
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        decode_exr(bytes, limits)?
    } else {
        let known = "Radiance HDR, OpenEXR, PNG, JPEG, WebP";
        let image = match decode(bytes, limits) {
            Err(ImageError::UnknownFormat { .. }) => return Err(unknown_format(bytes, known)),
            r => r?,
        };
        let note = "decoded from sRGB: its light ends at 1".to_string();
        (linear_rgb(&image), vec![note], 0)
    };
    let repaired = before
        + match &mut image.pixels {
            Pixels::F32(p) => repair(p),
            _ => 0,
        };
    if repaired > 0 {
        notes.push(format!("{repaired} pixels were not finite or negative and were repaired"));
    }
    Ok(Environment { image, repaired, notes })
}

/// Makes all samples finite and not negative; returns the number of pixels touched.
fn repair(rgb: &mut [f32]) -> u64 {
    let largest = rgb.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
    let bright = if largest > 0.0 { largest } else { 65504.0 };
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

/// A low-range picture as linear RGB floats; alpha multiplies, because what is not there shines not.
fn linear_rgb(image: &Image) -> Image {
    let (n, grey) = (image.channels as usize, image.channels < 3);
    let value = |i: usize| match &image.pixels {
        Pixels::U8(p) => srgb8_decode(p[i]),
        Pixels::U16(p) => srgb_decode(f32::from(p[i]) / 65535.0),
        Pixels::F32(p) => p[i],
    };
    let alpha = |i: usize| match &image.pixels {
        Pixels::U8(p) => f32::from(p[i]) / 255.0,
        Pixels::U16(p) => f32::from(p[i]) / 65535.0,
        Pixels::F32(p) => p[i],
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

/// Channels of a header by index, each with the lanes (0, 1, 2) of the picture that it fills.
type Channels = Vec<(usize, &'static [usize])>;

/// Which channels of a header make the picture, and the layer that they are in.
fn pick_channels(header: &Header) -> Option<(Channels, String)> {
    let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    let mut prefixes: Vec<&str> = vec![""];
    for n in &names {
        let p = n.rfind('.').map_or("", |i| &n[..=i]);
        if !prefixes.contains(&p) {
            prefixes.push(p);
        }
    }
    for p in prefixes {
        let find =
            |c: &str| names.iter().position(|n| n.strip_prefix(p).is_some_and(|n| n.eq_ignore_ascii_case(c)));
        if let (Some(r), Some(g), Some(b)) = (find("R"), find("G"), find("B")) {
            return Some((vec![(r, &[0]), (g, &[1]), (b, &[2])], p.trim_end_matches('.').into()));
        }
        if let Some(y) = find("Y") {
            return Some((vec![(y, &[0, 1, 2])], p.trim_end_matches('.').into()));
        }
    }
    None
}

/// The picture, notes, and pixels that were repaired already.
fn decode_exr(bytes: &[u8], limits: &DecodeLimits) -> Result<(Image, Vec<String>, u64), ImageError> {
    let meta = read_headers(bytes)?;
    let flat = |h: &&Header| !h.deep;
    // A part with plain R, G, B comes before one whose colours belong to some named layer.
    let picked = meta
        .headers
        .iter()
        .enumerate()
        .filter(|(_, h)| flat(h))
        .filter_map(|(i, h)| pick_channels(h).map(|(c, layer)| (i, c, layer)))
        .min_by_key(|(i, _, layer)| (!layer.is_empty(), *i));
    let Some((part, channels, layer)) = picked else {
        if !meta.headers.iter().any(|h| flat(&h)) {
            return Err(ImageError::unsupported(EXR, "deep data alone"));
        }
        return Err(ImageError::unsupported(EXR, "no channels R, G, B or Y"));
    };
    let header = &meta.headers[part];
    check_part(header, bytes, limits)?;

    let display = header.shared_attributes.display_window;
    let (width, height) = (display.size.width(), display.size.height());
    let data_pixels = header.layer_size.width() as u64 * header.layer_size.height() as u64;
    let size = (width as u64, height as u64);
    let pixels = size.0.saturating_mul(size.1);
    limits.check(EXR, size, pixels.saturating_mul(12), usize::MAX, 1)?;
    // The frame around a small picture costs the file nothing, so the picture bounds it.
    if pixels > data_pixels.saturating_mul(64).max(1 << 22) {
        let cause = format!("the display window is far larger than the data window of {}", pair(header));
        return Err(ImageError::TooLarge { format: EXR, width: size.0, height: size.1, cause });
    }

    let cube = header.own_attributes.environment_map == Some(EnvironmentMap::Cube);
    if cube {
        if height != width.saturating_mul(6) {
            let cause = format!(
                "a cube map of {width} × {height} pixels: six square faces below one another are wanted"
            );
            return Err(ImageError::damaged(EXR, cause));
        }
        let (w, h) = (4 * size.0, 2 * size.0);
        limits.check(EXR, (w, h), w.saturating_mul(h).saturating_mul(12), usize::MAX, 1)?;
    }

    let mut notes = Vec::new();
    if meta.headers.len() > 1 || !layer.is_empty() {
        let name = header.own_attributes.layer_name.as_ref().map_or(String::new(), |n| format!(" ({n})"));
        notes.push(format!("read part {part}{name} of {}, layer {layer:?}", meta.headers.len()));
    }
    // From the data window to the display window.
    let (dx, dy) = (
        i64::from(header.own_attributes.layer_position.x()) - i64::from(display.position.x()),
        i64::from(header.own_attributes.layer_position.y()) - i64::from(display.position.y()),
    );
    if (dx, dy) != (0, 0) || header.layer_size != display.size {
        notes.push(format!("data window of {} placed at ({dx}, {dy}) in the picture", pair(header)));
    }
    // Made when the first chunks have been decompressed: a damaged file that fails there has cost nothing.
    let mut out = Vec::new();
    decode_rows(
        bytes,
        |p| p == part,
        |_, row| {
            let Some((_, lanes)) = channels.iter().find(|c| c.0 == row.channel) else {
                return;
            };
            if out.is_empty() {
                out = vec![0f32; width * height * 3];
            }
            let y = row.y as i64 + dy;
            if !(0..height as i64).contains(&y) {
                return;
            }
            for (i, v) in row.floats().enumerate() {
                let x = (row.x + i) as i64 + dx;
                if (0..width as i64).contains(&x) {
                    let at = (y as usize * width + x as usize) * 3;
                    lanes.iter().for_each(|l| out[at + l] = v);
                }
            }
        },
    )?;
    if out.is_empty() {
        return Err(ImageError::damaged(EXR, "it has no pixels"));
    }
    if let Some((m, note)) = color_matrix(header) {
        notes.push(note);
        for c in out.chunks_exact_mut(3) {
            let v = matrix_apply(&m, [c[0], c[1], c[2]].map(f64::from));
            (0..3).for_each(|i| c[i] = v[i] as f32);
        }
    }
    if cube {
        notes.push(format!(
            "a cube map of {width} × {width} pixels, made into {} × {}",
            4 * width,
            2 * width
        ));
        // Before the faces are mixed, so that a bad pixel spoils none but itself.
        let repaired = repair(&mut out);
        return Ok((to_lat_long(&out, width), notes, repaired));
    }
    let image = Image { width: width as u32, height: height as u32, channels: 3, pixels: Pixels::F32(out) };
    Ok((image, notes, 0))
}

fn pair(h: &Header) -> String {
    format!("{} × {}", h.layer_size.width(), h.layer_size.height())
}

/// The matrix to Rec.709 when the file says that its primaries are others.
fn color_matrix(header: &Header) -> Option<(Matrix3, String)> {
    let c = header.shared_attributes.chromaticities?;
    let xy = |v: exr::math::Vec2<f32>| [f64::from(v.x()), f64::from(v.y())];
    let from = Primaries { red: xy(c.red), green: xy(c.green), blue: xy(c.blue), white: xy(c.white) };
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-3 && (a[1] - b[1]).abs() < 1e-3;
    if near(from.red, REC709.red)
        && near(from.green, REC709.green)
        && near(from.blue, REC709.blue)
        && near(from.white, REC709.white)
    {
        return None;
    }
    let name = format!("chromaticities R {:?} G {:?} B {:?} W {:?}", c.red, c.green, c.blue, c.white);
    // Channels that are CIE XYZ itself carry no white of their own: no adaptation. Otherwise white stays white, the
    // file's adopted neutral being its white where it names one.
    let is_xyz = near(from.red, [1.0, 0.0]) && near(from.green, [0.0, 1.0]) && near(from.blue, [0.0, 0.0]);
    let neutral = header.own_attributes.adopted_neutral.map_or(from.white, xy);
    let matrix = if is_xyz {
        xyz_to_rgb(&REC709)
    } else {
        rgb_to_xyz(&from)
            .zip(bradford(neutral, REC709.white))
            .zip(xyz_to_rgb(&REC709))
            .map(|((a, b), c)| matrix_mul(&c, &matrix_mul(&b, &a)))
    };
    match matrix {
        Some(m) => Some((m, format!("converted to Rec.709 from {name}"))),
        None => {
            Some(([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], format!("ignored degenerate {name}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repair_counts_pixels_and_keeps_the_rest() {
        let mut p = vec![1.0, 2.0, 3.0, f32::NAN, -1.0, 5.0, f32::INFINITY, 0.0, f32::NEG_INFINITY];
        assert_eq!(repair(&mut p), 2);
        assert_eq!(p, [1.0, 2.0, 3.0, 0.0, 0.0, 5.0, 5.0, 0.0, 0.0]);
        let mut p = vec![f32::INFINITY; 3];
        assert_eq!(repair(&mut p), 1);
        assert_eq!(p, [65504.0; 3]);
    }
}
