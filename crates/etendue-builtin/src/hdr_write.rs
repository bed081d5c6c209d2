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
