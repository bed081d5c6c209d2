//! Skies of OpenEXR files: which part and channels make the picture, and where it lies in its frame.

use super::{Raw, SkyLayout};
use crate::decode::DecodeLimits;
use crate::exr_read::{F as EXR, check_part, decode_rows, read_headers};
use crate::{Image, ImageError, Pixels};
use etendue_color::{Matrix3, Primaries, REC709, bradford, matrix_apply, matrix_mul, rgb_to_xyz, xyz_to_rgb};
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;

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

/// The picture; a cube if the file says that it is one.
pub(super) fn decode_exr(bytes: &[u8], limits: &DecodeLimits) -> Result<Raw, ImageError> {
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
    if cube && height != width.saturating_mul(6) {
        let cause =
            format!("a cube map of {width} × {height} pixels: six square faces below one another are wanted");
        return Err(ImageError::damaged(EXR, cause));
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
    let layout = cube.then_some(SkyLayout::StripExr);
    let image = Image { width: width as u32, height: height as u32, channels: 3, pixels: Pixels::F32(out) };
    Ok(Raw { pictures: vec![image], layout, notes })
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
