//! Cubes into latitude-longitude pictures.
//!
//! Faces are +X, −X, +Y, −Y, +Z, −Z, oriented as graphics processors take them (Khronos, "OpenGL 4.6 Specification", table 8.19): with s to
//! the right and t down, each −1..1, they look along (1, −t, −s), (−1, −t, s), (s, 1, t), (s, −1, −t), (s, −t, 1), (−s, −t, −1).

use crate::{Image, Pixels};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Points per pixel and axis: a texel of a face's corner, which is smallest, still meets one.
const POINTS: usize = 3;

/// The face that a direction meets, and the column and row there, −1..1 to the right and down.
fn face_of([x, y, z]: [f32; 3]) -> (usize, f32, f32) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        if x > 0.0 { (0, -z / ax, -y / ax) } else { (1, z / ax, -y / ax) }
    } else if ay >= az {
        if y > 0.0 { (2, x / ay, z / ay) } else { (3, x / ay, -z / ay) }
    } else if z > 0.0 {
        (4, x / az, -y / az)
    } else {
        (5, -x / az, -y / az)
    }
}

fn direction(face: usize, s: f32, t: f32) -> [f32; 3] {
    match face {
        0 => [1.0, -t, -s],
        1 => [-1.0, -t, s],
        2 => [s, 1.0, t],
        3 => [s, -1.0, -t],
        4 => [s, -t, 1.0],
        _ => [-s, -t, -1.0],
    }
}

/// Faces of `n`² texels with a border of one texel from their neighbours, so that a lookup need not know of edges.
struct Faces {
    n: usize,
    texels: Vec<[f32; 3]>,
}

impl Faces {
    fn new(faces: &[Image]) -> Self {
        let n = faces.first().map_or(1, |f| f.width as usize).max(1);
        let side = n + 2;
        let texel = |face: usize, x: usize, y: usize| {
            faces.get(face).map_or([0.0; 3], |f| [0, 1, 2].map(|c| f.sample(x as u32, y as u32, c)))
        };
        let texels = (0..6 * side * side).map(|i| {
            let (face, y, x) = (i / (side * side), i / side % side, i % side);
            if (1..=n).contains(&x) && (1..=n).contains(&y) {
                return texel(face, x - 1, y - 1);
            }
            let c = |i: usize| (2 * i) as f32 / n as f32 - 1.0 - 1.0 / n as f32;
            let (face, s, t) = face_of(direction(face, c(x), c(y)));
            let at = |v: f32| (((0.5 * v + 0.5) * n as f32) as usize).min(n - 1);
            texel(face, at(s), at(t))
        });
        Self { n, texels: texels.collect() }
    }

    /// The radiance in a direction, bilinear. A texel's value belongs to its middle, as graphics processors have it. (OpenEXR's own tools put
    /// the outermost ones on the cube's edges, half a texel further out, which few programs that write such files do.)
    fn lookup(&self, d: [f32; 3]) -> [f32; 3] {
        let (face, s, t) = face_of(d);
        let side = self.n + 2;
        // The border's first texel has its middle at 0.
        let at = |v: f32| ((0.5 * v + 0.5) * self.n as f32 + 0.5).max(0.0);
        let (x, y) = (at(s), at(t));
        let (x0, y0) = ((x as usize).min(side - 2), (y as usize).min(side - 2));
        let (tx, ty) = (x - x0 as f32, y - y0 as f32);
        let row = |y: usize| {
            let i = (face * side + y) * side + x0;
            let (a, b) = (self.texels[i], self.texels[i + 1]);
            std::array::from_fn::<f32, 3, _>(|c| a[c] * (1.0 - tx) + b[c] * tx)
        };
        let (a, b) = (row(y0), row(y0 + 1));
        std::array::from_fn(|c| a[c] * (1.0 - ty) + b[c] * ty)
    }
}

/// A picture four faces wide and two high of what six faces (+X, −X, +Y, −Y, +Z, −Z, squares of one size, oriented as OpenGL takes them) show,
/// three floats each; its middle is +X, as that of every sky. `turn` says for a
/// direction of the world in which direction of the cube to look.
pub fn lat_long_of_cube(faces: &[Image], turn: impl Fn([f32; 3]) -> [f32; 3] + Sync) -> Image {
    let cube = Faces::new(faces);
    let (w, h) = (4 * cube.n, 2 * cube.n);
    let around: Vec<[f32; 2]> = (0..w * POINTS)
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
            let (around, cube, turn) = (&around, &cube, &turn);
            (0..w).flat_map(move |x| {
                let mut sum = [0.0f64; 3];
                for [cos, sin] in rows {
                    for [c, s] in &around[x * POINTS..(x + 1) * POINTS] {
                        let l = cube.lookup(turn([sin * c, cos, sin * s]));
                        (0..3).for_each(|i| sum[i] += f64::from(l[i]));
                    }
                }
                // Of light as bright as a float can say the rounding could make more than that.
                sum.map(|v| (v / (POINTS * POINTS) as f64).min(f32::MAX.into()) as f32)
            })
        })
        .collect();
    Image { width: w as u32, height: h as u32, channels: 3, pixels: Pixels::F32(pixels) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(n: usize, texel: impl Fn(f32, f32) -> [f32; 3]) -> Image {
        let c = |i: usize| (2 * i + 1) as f32 / n as f32 - 1.0;
        let pixels = (0..n * n).flat_map(|i| texel(c(i % n), c(i / n))).collect();
        Image { width: n as u32, height: n as u32, channels: 3, pixels: Pixels::F32(pixels) }
    }

    /// Faces whose light is their direction come out at their directions, across edges too.
    #[test]
    fn directions_are_kept() {
        let n = 32;
        let faces: Vec<Image> = (0..6)
            .map(|f| {
                face(n, |s, t| {
                    let d = direction(f, s, t);
                    let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
                    d.map(|v| v / length + 2.0)
                })
            })
            .collect();
        let image = lat_long_of_cube(&faces, |d| d);
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
        println!("worst {worst}");
        assert!(worst < 0.012, "{worst}");
    }

    #[test]
    fn one_texel_each() {
        let faces: Vec<Image> = (0..6).map(|f| face(1, |_, _| [f as f32; 3])).collect();
        let image = lat_long_of_cube(&faces, |d| d);
        assert_eq!((image.width, image.height), (4, 2));
        assert!((0..4).all(|x| image.sample(x, 0, 0) <= 5.0));
    }

    #[test]
    fn the_brightest_light_stays_finite() {
        let faces: Vec<Image> = (0..6).map(|_| face(2, |_, _| [f32::MAX; 3])).collect();
        let image = lat_long_of_cube(&faces, |d| d);
        let Pixels::F32(p) = &image.pixels else { panic!("not floats") };
        assert!(p.iter().all(|v| v.is_finite() && *v > 0.99 * f32::MAX));
    }
}
