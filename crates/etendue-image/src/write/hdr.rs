//! Radiance HDR out: RGBE with run lengths by channel (Greg Ward Larson, "Radiance File Formats").

use std::io::Write;

use crate::{Image, ImageError, Metadata, Pixels};

/// Writes the first three channels of linear light; metadata become comment lines `# name: value`.
pub(super) fn write(w: &mut dyn Write, image: &Image, metadata: &Metadata) -> Result<(), ImageError> {
    let Pixels::F32(pixels) = &image.pixels else {
        return Err(ImageError::unwritable("Radiance HDR", "integer samples"));
    };
    let (n, width) = (image.channels as usize, image.width as usize);
    let mut head = String::from("#?RADIANCE\n");
    for (name, value) in &metadata.entries {
        // One line each, short of what readers with a fixed buffer take.
        let one_line = |s: &str| s.split(['\n', '\r', '\0']).collect::<Vec<_>>().join(" ");
        let mut line = format!("# {}: {}", one_line(name), one_line(value));
        while line.len() > 2000 {
            line.pop();
        }
        head += &line;
        head.push('\n');
    }
    head += &format!("FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height, image.width);
    w.write_all(head.as_bytes())?;

    let mut line = Vec::with_capacity(width);
    let mut out = Vec::new();
    for row in pixels.chunks_exact(width * n) {
        line.clear();
        line.extend(row.chunks_exact(n).map(|p| to_rgbe([p[0], p[1], p[2]])));
        out.clear();
        if (8..=0x7fff).contains(&width) {
            out.extend_from_slice(&[2, 2, (width >> 8) as u8, width as u8]);
            (0..4).for_each(|c| run_lengths(&line, c, &mut out));
        } else {
            // Beyond these widths there is only the flat form. A mantissa triple of (1, 1, 1) would read as a run, but
            // normalised pixels have a mantissa of 128 or more.
            line.iter().for_each(|p| out.extend_from_slice(p));
        }
        w.write_all(&out)?;
    }
    Ok(())
}

/// The pixel whose decoded value `m · 2^(e − 136)` is nearest; NaN and negative become 0, what is too bright the
/// brightest.
fn to_rgbe(c: [f32; 3]) -> [u8; 4] {
    let c = c.map(|v| if v > 0.0 { f64::from(v.min(1.7e38)) } else { 0.0 });
    let peak = c[0].max(c[1]).max(c[2]);
    if peak < 1e-38 {
        return [0; 4];
    }
    // peak = f · 2^e with ½ ≤ f < 1.
    let mut e = peak.log2().floor() as i32 + 1;
    if peak >= 2f64.powi(e) {
        e += 1;
    }
    // Rounding may carry into a ninth bit.
    if (peak * 2f64.powi(8 - e)).round() >= 256.0 {
        e += 1;
    }
    let e = e.clamp(-127, 127);
    let scale = 2f64.powi(8 - e);
    let m = c.map(|v| (v * scale).round().min(255.0) as u8);
    [m[0], m[1], m[2], (e + 128) as u8]
}

/// Codes one channel: runs of four and more equal bytes as (128 + n, byte), the rest as (n, bytes).
fn run_lengths(line: &[[u8; 4]], c: usize, out: &mut Vec<u8>) {
    let run_at = |i: usize| line[i..].iter().take(127).take_while(|p| p[c] == line[i][c]).count();
    let mut i = 0;
    while i < line.len() {
        let run = run_at(i);
        if run >= 4 {
            out.extend_from_slice(&[128 + run as u8, line[i][c]]);
            i += run;
            continue;
        }
        let start = i;
        while i < line.len() && i - start < 128 && run_at(i) < 4 {
            i += 1;
        }
        out.push((i - start) as u8);
        out.extend(line[start..i].iter().map(|p| p[c]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mantissas_are_rounded_to_nearest() {
        assert_eq!(to_rgbe([1.0, 0.5, 0.25]), [128, 64, 32, 129]);
        assert_eq!(to_rgbe([0.0; 3]), [0; 4]);
        // 255.6/256 carries: the exponent goes up.
        assert_eq!(to_rgbe([0.9985, 0.0, 0.0]), [128, 0, 0, 129]);
        assert_eq!(to_rgbe([f32::NAN, -1.0, f32::INFINITY]), [0, 0, 255, 255]);
        for i in 1..4000 {
            let v = i as f32 * 0.013;
            let [r, _, _, e] = to_rgbe([v, 0.0, 0.0]);
            let back = f64::from(r) * 2f64.powi(i32::from(e) - 136);
            assert!((back / f64::from(v) - 1.0).abs() <= 0.5 / 128.0, "{v} → {back}");
        }
    }
}
