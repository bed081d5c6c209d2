//! Radiance pictures in: RGBE and XYZE, both run-length codings, all eight orientations.
//!
//! Greg Ward Larson, "Radiance File Formats" and "Real Pixels" (Graphics Gems II, 1991). A pixel is three mantissas and a common
//! exponent: `c = m · 2^(e − 136)`, black where e is 0. Radiance itself adds one half to a mantissa because it truncates when
//! writing; other programs write rounded mantissas and add nothing, and so does this reader.

use etendue_color::{REC709, matrix_apply, xyz_to_rgb};

use crate::decode::DecodeLimits;
use crate::{Image, ImageError, Pixels};

const F: &str = "Radiance HDR";

/// Most pixels that one byte can stand for: a row of old run-length coding of 32767 pixels in 8 bytes.
const PIXELS_PER_BYTE: u64 = 4096;

/// A decoded picture and what its header did to it.
pub(crate) struct Hdr {
    pub image: Image,
    pub notes: Vec<String>,
}

/// How the rows of the file lie in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    /// Pixels in a scan line of the file, and scan lines.
    len: usize,
    lines: usize,
    /// Scan lines are columns.
    columns: bool,
    /// The picture's x runs against the file's, or its y (down) does.
    flip_x: bool,
    flip_y: bool,
}

struct Header {
    xyz: bool,
    /// What each channel has to be divided by.
    divide: [f64; 3],
    layout: Layout,
    notes: Vec<String>,
}

pub(crate) fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Decodes a Radiance picture into linear Rec.709 RGB floats, as they stand: not yet checked for infinities.
pub(crate) fn decode_hdr(bytes: &[u8], limits: &DecodeLimits) -> Result<Hdr, ImageError> {
    let mut at = 0;
    let header = parse_header(bytes, &mut at)?;
    let l = header.layout;
    let (width, height) = if l.columns { (l.lines, l.len) } else { (l.len, l.lines) };
    let pixels = width as u64 * height as u64;
    limits.check(
        F,
        (width as u64, height as u64),
        pixels.saturating_mul(12),
        bytes.len(),
        12 * PIXELS_PER_BYTE,
    )?;

    // The coded form grows as lines arrive, so that a header alone allocates nothing.
    let mut coded: Vec<[u8; 4]> = Vec::new();
    for line in 0..l.lines {
        let start = coded.len();
        coded.resize(start + l.len, [0; 4]);
        read_line(bytes, &mut at, &mut coded[start..])
            .map_err(|cause| ImageError::damaged(F, format!("{cause} in scan line {line} of {}", l.lines)))?;
    }

    // Not even XYZE can fail here: the primaries are constants.
    let matrix = if header.xyz { xyz_to_rgb(&REC709) } else { None };
    let scale = header.divide.map(|d| 1.0 / d);
    let mut out = vec![0f32; width * height * 3];
    for y in 0..height {
        for x in 0..width {
            let (u, v) =
                (if l.flip_x { width - 1 - x } else { x }, if l.flip_y { height - 1 - y } else { y });
            let c = coded[if l.columns { u * l.len + v } else { v * l.len + u }];
            let mut c = rgbe(c);
            if scale != [1.0; 3] || matrix.is_some() {
                let mut wide: [f64; 3] = std::array::from_fn(|i| f64::from(c[i]) * scale[i]);
                if let Some(m) = &matrix {
                    wide = matrix_apply(m, wide);
                }
                c = wide.map(|v| v as f32);
            }
            out[(y * width + x) * 3..][..3].copy_from_slice(&c);
        }
    }
    let image = Image { width: width as u32, height: height as u32, channels: 3, pixels: Pixels::F32(out) };
    Ok(Hdr { image, notes: header.notes })
}

/// `m · 2^(e − 136)`; exact, since a float holds both the mantissa and every such power.
fn rgbe([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    let scale = 2f64.powi(i32::from(e) - 136);
    [r, g, b].map(|m| (f64::from(m) * scale) as f32)
}

fn parse_header(bytes: &[u8], at: &mut usize) -> Result<Header, ImageError> {
    let first = next_line(bytes, at)?;
    if !first.starts_with("#?") {
        return Err(ImageError::damaged(F, "the signature \"#?\" is missing"));
    }
    let (mut xyz, mut exposure, mut correction) = (false, 1.0, [1.0; 3]);
    let mut notes = Vec::new();
    loop {
        let line = next_line(bytes, at)?;
        let line = line.trim();
        if line.is_empty() {
            break;
        }
        let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with('#')) else {
            continue; // a comment, or a command that made the picture
        };
        let value = value.trim();
        let number = |s: &str| {
            s.parse::<f64>()
                .ok()
                .filter(|v| v.is_finite() && *v > 0.0)
                .ok_or_else(|| ImageError::damaged(F, format!("{key}={value:.40} is not a positive number")))
        };
        match key.trim() {
            "FORMAT" => {
                xyz = match value {
                    "32-bit_rle_rgbe" => false,
                    "32-bit_rle_xyze" => true,
                    other => return Err(ImageError::unsupported(F, format!("FORMAT={other:.40}"))),
                }
            }
            // Both lines may come several times; they multiply.
            "EXPOSURE" => exposure *= number(value)?,
            "COLORCORR" => {
                let v = value.split_whitespace().map(number).collect::<Result<Vec<_>, _>>()?;
                let [r, g, b] = v[..] else {
                    return Err(ImageError::damaged(
                        F,
                        format!("COLORCORR={value:.40} is not three numbers"),
                    ));
                };
                correction = [correction[0] * r, correction[1] * g, correction[2] * b];
            }
            "PRIMARIES" => {
                // Some programs write zeros for "not known".
                let v: Vec<f64> = value.split_whitespace().filter_map(|s| s.parse().ok()).collect();
                let rec709 = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
                let same = v.len() == 8 && v.iter().zip(rec709).all(|(a, b)| (a - b).abs() < 2e-3);
                if !same && v.iter().any(|v| *v != 0.0) {
                    notes.push(format!("PRIMARIES={value:.80} ignored: taken as Rec.709"));
                }
            }
            _ => {}
        }
    }
    if exposure != 1.0 {
        notes.push(format!("EXPOSURE={exposure} divided out"));
    }
    if correction != [1.0; 3] {
        notes.push(format!("COLORCORR={correction:?} divided out"));
    }
    let divide = correction.map(|c| c * exposure);
    if !divide.iter().all(|d| d.is_finite() && *d > 1e-30) {
        return Err(ImageError::damaged(F, "EXPOSURE and COLORCORR multiply to something absurd"));
    }
    let layout = parse_resolution(&next_line(bytes, at)?)?;
    Ok(Header { xyz, divide, layout, notes })
}

/// The next line of the header, without its end; at most 2048 bytes, as in Radiance's own reader.
fn next_line(bytes: &[u8], at: &mut usize) -> Result<String, ImageError> {
    let rest = &bytes[*at..];
    let end = rest
        .iter()
        .take(2048)
        .position(|&b| b == b'\n')
        .ok_or_else(|| ImageError::damaged(F, "the header does not end"))?;
    *at += end + 1;
    Ok(String::from_utf8_lossy(&rest[..end]).into_owned())
}

/// The resolution line: two axes with signs, the slower one first. `-Y 512 +X 1024` is the usual: rows from the top, each from the left.
fn parse_resolution(line: &str) -> Result<Layout, ImageError> {
    let bad = || ImageError::damaged(F, format!("the resolution line is {line:.60?}"));
    let words: Vec<&str> = line.split_whitespace().collect();
    let [slow, lines, fast, len] = words[..] else {
        return Err(bad());
    };
    let count = |s: &str| s.parse::<u32>().ok().filter(|v| *v <= i32::MAX as u32).map(|v| v as usize);
    let (lines, len) = (count(lines).ok_or_else(bad)?, count(len).ok_or_else(bad)?);
    let columns = match (slow, fast) {
        ("+Y" | "-Y", "+X" | "-X") => false,
        ("+X" | "-X", "+Y" | "-Y") => true,
        _ => return Err(bad()),
    };
    let (x, y) = if columns { (slow, fast) } else { (fast, slow) };
    Ok(Layout { len, lines, columns, flip_x: x == "-X", flip_y: y == "+Y" })
}

/// Reads one scan line in whichever of the three codings it is.
fn read_line(bytes: &[u8], at: &mut usize, line: &mut [[u8; 4]]) -> Result<(), &'static str> {
    let head = take(bytes, at, 4)?;
    // The new coding starts with two twos and the length, which only fits for 8 to 32767 pixels.
    let new = head[0] == 2 && head[1] == 2 && head[2] < 128 && (8..=0x7fff).contains(&line.len());
    if new {
        if usize::from(head[2]) << 8 | usize::from(head[3]) != line.len() {
            return Err("a length that is not the picture's");
        }
        for channel in 0..4 {
            let mut x = 0;
            while x < line.len() {
                let code = usize::from(take(bytes, at, 1)?[0]);
                let count = if code > 128 { code - 128 } else { code };
                if count == 0 || x + count > line.len() {
                    return Err("a run that does not fit");
                }
                if code > 128 {
                    let value = take(bytes, at, 1)?[0];
                    line[x..x + count].iter_mut().for_each(|p| p[channel] = value);
                } else {
                    let values = take(bytes, at, count)?;
                    line[x..x + count].iter_mut().zip(values).for_each(|(p, v)| p[channel] = *v);
                }
                x += count;
            }
        }
        return Ok(());
    }
    // Flat pixels, and the old coding: (1, 1, 1, n) repeats the last pixel n times, n being shifted by eight bits for
    // each such code that directly follows another.
    *at -= 4;
    let (mut x, mut shift) = (0, 0);
    while x < line.len() {
        let p = take(bytes, at, 4)?;
        let p = [p[0], p[1], p[2], p[3]];
        if p[..3] == [1, 1, 1] {
            if x == 0 {
                return Err("a run before the first pixel");
            }
            let count = if shift < 32 { usize::from(p[3]) << shift } else { usize::MAX };
            if count > line.len() - x {
                return Err("a run that does not fit");
            }
            let last = line[x - 1];
            line[x..x + count].fill(last);
            x += count;
            shift += 8;
        } else {
            line[x] = p;
            x += 1;
            shift = 0;
        }
    }
    Ok(())
}

fn take<'a>(bytes: &'a [u8], at: &mut usize, n: usize) -> Result<&'a [u8], &'static str> {
    let slice = bytes.get(*at..).and_then(|b| b.get(..n)).ok_or("the data end")?;
    *at += n;
    Ok(slice)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(header: &str, data: &[u8]) -> Result<Hdr, ImageError> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.extend_from_slice(data);
        decode_hdr(&bytes, &DecodeLimits::default())
    }

    fn floats(h: &Hdr) -> &[f32] {
        match &h.image.pixels {
            Pixels::F32(p) => p,
            _ => unreachable!(),
        }
    }

    /// Six flat pixels whose red is 1 to 6 (mantissa · 2^(136 − 136)).
    const SIX: [u8; 24] =
        [1, 0, 0, 136, 2, 0, 0, 136, 3, 0, 0, 136, 4, 0, 0, 136, 5, 0, 0, 136, 6, 0, 0, 136];

    #[test]
    fn every_orientation() {
        // Rows of the picture from the top, as the resolution line says the pixels 1 to 6 arrive.
        for (line, size, red) in [
            ("-Y 2 +X 3", (3, 2), [1, 2, 3, 4, 5, 6]),
            ("-Y 2 -X 3", (3, 2), [3, 2, 1, 6, 5, 4]),
            ("+Y 2 +X 3", (3, 2), [4, 5, 6, 1, 2, 3]),
            ("+Y 2 -X 3", (3, 2), [6, 5, 4, 3, 2, 1]),
            ("+X 3 -Y 2", (3, 2), [1, 3, 5, 2, 4, 6]),
            ("+X 3 +Y 2", (3, 2), [2, 4, 6, 1, 3, 5]),
            ("-X 3 -Y 2", (3, 2), [5, 3, 1, 6, 4, 2]),
            ("-X 3 +Y 2", (3, 2), [6, 4, 2, 5, 3, 1]),
        ] {
            let h = read(&format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n"), &SIX).unwrap();
            assert_eq!((h.image.width, h.image.height), size, "{line}");
            let got: Vec<i32> = floats(&h).iter().step_by(3).map(|v| *v as i32).collect();
            assert_eq!(got, red, "{line}");
        }
    }

    #[test]
    fn exposure_and_colour_correction_are_divided_out() {
        let h =
            read("#?RADIANCE\nEXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR=1 2 4\n\n-Y 1 +X 1\n", &[16, 32, 64, 136]);
        let h = h.unwrap();
        assert_eq!(floats(&h), [2.0, 2.0, 2.0]);
        assert_eq!(h.notes.len(), 2);
        assert!(read("#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n", &SIX).is_err());
        assert!(read("#?RADIANCE\nEXPOSURE=nan\n\n-Y 1 +X 1\n", &SIX).is_err());
    }

    #[test]
    fn xyze_becomes_rec709() {
        // The white of D65 at Y = 1 in 1/128ths: (0.9505, 1, 1.0888) → (122, 128, 139).
        let h = read("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", &[122, 128, 139, 129]).unwrap();
        assert!(floats(&h).iter().all(|v| (v - 1.0).abs() < 0.015), "{:?}", floats(&h));
    }

    #[test]
    fn old_runs_multiply() {
        // One pixel, then a run of 3 + 1·256, in a line of 260.
        let h = read("#?RGBE\n\n-Y 1 +X 260\n", &[7, 0, 0, 136, 1, 1, 1, 3, 1, 1, 1, 1]).unwrap();
        assert!(floats(&h).iter().step_by(3).all(|v| *v == 7.0));
        assert!(read("#?RGBE\n\n-Y 1 +X 259\n", &[7, 0, 0, 136, 1, 1, 1, 3, 1, 1, 1, 1]).is_err());
        assert!(read("#?RGBE\n\n-Y 1 +X 4\n", &[1, 1, 1, 4]).is_err());
    }

    #[test]
    fn new_runs_by_channel() {
        // Eight pixels: red a run, green literal, blue run, exponent run.
        let data = [2, 2, 0, 8, 136, 9, 8, 1, 2, 3, 4, 5, 6, 7, 8, 136, 0, 136, 136];
        let h = read("#?RADIANCE\n\n-Y 1 +X 8\n", &data).unwrap();
        assert_eq!(floats(&h)[3..6], [9.0, 2.0, 0.0]);
        for cut in 0..data.len() {
            assert!(read("#?RADIANCE\n\n-Y 1 +X 8\n", &data[..cut]).is_err(), "cut at {cut}");
        }
        // A count of zero would never end.
        assert!(read("#?RADIANCE\n\n-Y 1 +X 8\n", &[2, 2, 0, 8, 0, 0, 0, 0]).is_err());
    }

    #[test]
    fn absurd_headers_are_refused() {
        for line in [
            "-Y 0 +X 5",
            "-Y 40000 +X 40000",
            "-Y 2147483647 +X 2147483647",
            "-Y 99999999999 +X 1",
            "-Y -1 +X 1",
            "+Y 1 +Y 1",
            "",
            "-Y 1 +X",
        ] {
            assert!(read(&format!("#?RADIANCE\n\n{line}\n"), &SIX).is_err(), "{line}");
        }
        assert!(decode_hdr(b"#?RADIANCE\nno end", &DecodeLimits::default()).is_err());
    }
}
