//! Cube maps of OpenEXR files: six faces below one another, into a latitude-longitude picture.

use crate::{Image, Pixels};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Points per pixel and axis: a texel of a face's corner, which is smallest, still meets one.
const POINTS: usize = 3;

/// The face that a direction meets, and the column and row there, −1..1 to the right and down (OpenEXR's `ImfEnvmap.h`: the faces
/// are +X, −X, +Y, −Y, +Z, −Z, as seen from inside, those of the sides with +Y up).
fn face_of([x, y, z]: [f32; 3]) -> (usize, f32, f32) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        if x > 0.0 { (0, z / ax, -y / ax) } else { (1, -z / ax, -y / ax) }
    } else if ay >= az {
        if y > 0.0 { (2, x / ay, -z / ay) } else { (3, x / ay, z / ay) }
    } else if z > 0.0 {
        (4, -x / az, -y / az)
    } else {
        (5, x / az, -y / az)
    }
}

/// The radiance in a direction: bilinear within the face.
///
/// A texel's value belongs to its middle, as graphics processors have it. OpenEXR's own tools put the outermost ones on the cube's edges,
/// half a texel further out, which few programs that write such files do.
fn lookup(strip: &[f32], n: usize, d: [f32; 3]) -> [f32; 3] {
    let (face, s, t) = face_of(d);
    let at = |v: f32| ((0.5 * v + 0.5) * n as f32 - 0.5).clamp(0.0, (n - 1) as f32);
    let (x, y) = (at(s), at(t));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(n - 1), (y0 + 1).min(n - 1));
    let (tx, ty) = (x - x0 as f32, y - y0 as f32);
    let texel = |x: usize, y: usize, c: usize| strip[((face * n + y) * n + x) * 3 + c];
    std::array::from_fn(|c| {
        let row = |y: usize| texel(x0, y, c) * (1.0 - tx) + texel(x1, y, c) * tx;
        row(y0) * (1.0 - ty) + row(y1) * ty
    })
}

/// A picture of 4 `n` × 2 `n` pixels of what six faces of `n`² pixels show, three floats each; its middle is +X, as that of every sky.
pub(crate) fn to_lat_long(strip: &[f32], n: usize) -> Image {
    let (w, h) = (4 * n, 2 * n);
    let turn: Vec<[f32; 2]> = (0..w * POINTS)
        .map(|i| {
            let (s, c) = (TAU * ((i as f64 + 0.5) / (w * POINTS) as f64 - 0.5)).sin_cos();
            [c as f32, s as f32]
        })
        .collect();
    let pixels = (0..h)
        .into_par_iter()
        .flat_map_iter(|y| {
            let rows: [[f32; 2]; POINTS] = std::array::from_fn(|k| {
                let (s, c) = (PI * ((y * POINTS + k) as f64 + 0.5) / (h * POINTS) as f64).sin_cos();
                [c as f32, s as f32]
            });
            let turn = &turn;
            (0..w).flat_map(move |x| {
                let mut sum = [0.0; 3];
                for [cos, sin] in rows {
                    for [c, s] in &turn[x * POINTS..(x + 1) * POINTS] {
                        let l = lookup(strip, n, [sin * c, cos, sin * s]);
                        (0..3).for_each(|i| sum[i] += l[i]);
                    }
                }
                sum.map(|v| v / (POINTS * POINTS) as f32)
            })
        })
        .collect();
    Image { width: w as u32, height: h as u32, channels: 3, pixels: Pixels::F32(pixels) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces whose light is their direction, by the positions that `ImfEnvmap.cpp` gives, come out at their directions.
    #[test]
    fn directions_are_kept() {
        let n = 32;
        let mut strip = Vec::new();
        for face in 0..6 {
            for y in 0..n {
                for x in 0..n {
                    let (s, t) = ((2 * x + 1) as f32 / n as f32 - 1.0, (2 * y + 1) as f32 / n as f32 - 1.0);
                    // Columns and rows of OpenEXR's `pixelPosition`, solved for the direction.
                    let d = match face {
                        0 => [1.0, -t, s],
                        1 => [-1.0, -t, -s],
                        2 => [s, 1.0, -t],
                        3 => [s, -1.0, t],
                        4 => [-s, -t, 1.0],
                        _ => [s, -t, -1.0],
                    };
                    let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
                    strip.extend(d.map(|v| v / length + 2.0));
                }
            }
        }
        let image = to_lat_long(&strip, n);
        assert_eq!((image.width, image.height), (128, 64));
        let mut worst = 0.0f32;
        for y in 0..64 {
            for x in 0..128 {
                let (phi, theta) = (TAU * ((x as f64 + 0.5) / 128.0 - 0.5), PI * (y as f64 + 0.5) / 64.0);
                let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
                for (c, d) in d.iter().enumerate() {
                    worst = worst.max((image.sample(x, y, c as u8) - 2.0 - *d as f32).abs());
                }
            }
        }
        // Half a texel at the edges of faces, where the neighbour is not asked.
        assert!(worst < 0.035, "{worst}");
    }

    #[test]
    fn one_texel_each() {
        let strip: Vec<f32> = (0..6).flat_map(|f| [f as f32; 3]).collect();
        let image = to_lat_long(&strip, 1);
        // The middle of the four columns of the upper row: −X, −Z, +X, +Z begin at the left.
        assert_eq!((image.width, image.height), (4, 2));
        assert!((0..4).all(|x| image.sample(x, 0, 0) <= 5.0));
    }
}
