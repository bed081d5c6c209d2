//! A writer of Radiance pictures (RGBE, Ward 1991) with the adaptive run-length encoding of its scanlines.

/// The file of a picture of linear RGB, row by row from the top; `width` is 8..32767.
pub fn radiance_file(width: usize, height: usize, pixels: &[[f32; 3]]) -> Vec<u8> {
    let mut out = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in pixels.chunks_exact(width) {
        let encoded: Vec<[u8; 4]> = row.iter().map(|p| rgbe(*p)).collect();
        out.extend_from_slice(&[2, 2, (width >> 8) as u8, (width & 255) as u8]);
        for channel in 0..4 {
            let line: Vec<u8> = encoded.iter().map(|p| p[channel]).collect();
            run_lengths(&line, &mut out);
        }
    }
    out
}

/// Three mantissas and the exponent of the largest (of 2, biased by 128), rounded to nearest.
pub fn rgbe(p: [f32; 3]) -> [u8; 4] {
    let max = p[0].max(p[1]).max(p[2]);
    if max < 1e-32 {
        return [0; 4];
    }
    // max = m · 2^e with m in ½..1, read from the float's bits; one more where rounding would overflow the byte.
    let mut e = ((max.to_bits() >> 23) & 255) as i32 - 126;
    if max * 2f32.powi(8 - e) >= 255.5 {
        e += 1;
    }
    let scale = 2f32.powi(8 - e);
    let q = p.map(|c| (c.max(0.0) * scale + 0.5).min(255.0) as u8);
    [q[0], q[1], q[2], (e + 128) as u8]
}

/// Runs of 4 to 127 equal bytes as (128 + length, byte), everything else as (length, bytes) of up to 128.
fn run_lengths(line: &[u8], out: &mut Vec<u8>) {
    let run_at = |i: usize| line[i..].iter().take(127).take_while(|b| **b == line[i]).count();
    let mut i = 0;
    while i < line.len() {
        let run = run_at(i);
        if run >= 4 {
            out.extend_from_slice(&[128 + run as u8, line[i]]);
            i += run;
            continue;
        }
        let start = i;
        while i < line.len() && i - start < 128 && run_at(i) < 4 {
            i += 1;
        }
        out.push((i - start) as u8);
        out.extend_from_slice(&line[start..i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_channel_keeps_eight_bits() {
        for i in 0..4000 {
            let v = 1e-4 * 1.004f32.powi(i);
            let q = rgbe([v, 0.5 * v, 0.0]);
            let back = q[0] as f32 * 2f32.powi(q[3] as i32 - 136);
            assert!((back - v).abs() <= v / 255.0, "{v} came back as {back}");
            assert!(q[0] >= 127, "{v}: the mantissa {} is not normalised", q[0]);
        }
        assert_eq!(rgbe([0.0; 3]), [0; 4]);
        assert_eq!(rgbe([1.0, 1.0, 1.0]), [128, 128, 128, 129]);
    }

    #[test]
    fn runs_decode_to_the_line() {
        let line: Vec<u8> = (0..600u32).map(|i| if i % 97 < 40 { 7 } else { (i * 31 % 251) as u8 }).collect();
        let mut code = Vec::new();
        run_lengths(&line, &mut code);
        let (mut out, mut at) = (Vec::new(), 0);
        while at < code.len() {
            let n = code[at] as usize;
            if n > 128 {
                out.extend(std::iter::repeat_n(code[at + 1], n - 128));
                at += 2;
            } else {
                out.extend_from_slice(&code[at + 1..at + 1 + n]);
                at += 1 + n;
            }
        }
        assert_eq!(out, line);
        assert!(code.len() < line.len());
    }
}
