//! Irradiance by cosine convolution: exactly, for a direction or into a cube.

use crate::cube::{CubeMap, face_direction, texel_centre, texel_solid_angle};
use crate::sky::SkyMap;
use etendue_color::Spectrum;
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// A sky as first moments over a grid of cells, from which irradiance is one sum.
///
/// A cell keeps m = ∫ L ω dω, a vector for each lane. A cell wholly above a surface gives n·m, with nothing lost; only
/// cells that the horizon cuts are approximated, by max(0, n·m), where the cosine is nearly zero anyway.
#[derive(Clone, Debug)]
pub struct ExactIrradiance {
    /// x, y and z of the moments of lanes 0, 1, 2.
    cells: Vec<[Spectrum; 3]>,
}

impl ExactIrradiance {
    /// A grid of 512 × 256 cells: 0.7° each. Under radiance 1 the error is about 1e-5 of π.
    pub fn new(sky: &SkyMap) -> Self {
        Self::with_rows(sky, 256)
    }

    /// A grid of `rows` × 2 `rows` cells, `rows` raised to 4 at least. Each cell sees every texel of its part of the picture.
    pub fn with_rows(sky: &SkyMap, rows: usize) -> Self {
        let (rows, columns) = (rows.max(4), 2 * rows.max(4));
        // Lookups per cell: two for each texel that it holds (the mean of a bilinear picture over half a texel is its
        // value in the middle), and two at least.
        let across = 2 * sky.width().div_ceil(columns);
        let down = 2 * sky.height().div_ceil(rows);
        let angles: Vec<(f64, f64)> = (0..columns * across)
            .map(|i| (TAU * ((i as f64 + 0.5) / (columns * across) as f64 - 0.5)).sin_cos())
            .collect();
        let cells = (0..rows)
            .into_par_iter()
            .flat_map_iter(|row| {
                let mut moments = vec![[[0.0f64; 3]; 3]; columns];
                for k in 0..down {
                    let at = |f: f64| PI * ((row * down + k) as f64 + f) / (rows * down) as f64;
                    let (low, mid, high) = (at(0.0), at(0.5), at(1.0));
                    let solid_angle = (low.cos() - high.cos()) * TAU / (columns * across) as f64;
                    let (sin, cos) = mid.sin_cos();
                    let v = (mid / PI) as f32;
                    for (i, (sin_phi, cos_phi)) in angles.iter().enumerate() {
                        let u = (i as f32 + 0.5) / angles.len() as f32 + sky.turn();
                        let l = sky.bilinear(u, v);
                        let d = [sin * cos_phi, cos, sin * sin_phi];
                        for (axis, d) in moments[i / across].iter_mut().zip(d) {
                            (0..3).for_each(|c| axis[c] += f64::from(l[c]) * solid_angle * d);
                        }
                    }
                }
                moments.into_iter().map(|m| m.map(|axis| Spectrum::from_rgb(axis.map(|v| v as f32))))
            })
            .collect();
        Self { cells }
    }

    /// Of a cube's largest mip, brought to 64² texels per face at most by taking means: a texel's first moment is its radiance times its solid
    /// angle along its middle.
    pub fn of_cube(cube: &CubeMap) -> Self {
        let reduced;
        let cube = if cube.size() > 64 {
            reduced = cube.clone().with_mips();
            &reduced
        } else {
            cube
        };
        let mip = (0..cube.mip_count()).find(|m| cube.mip_size(*m) <= 64).unwrap_or(cube.mip_count() - 1);
        let n = cube.mip_size(mip);
        let cells = cube.mip(mip).iter().enumerate().map(|(i, l)| {
            let (face, i) = ((i as u32 / (n * n)) as usize, i as u32 % (n * n));
            let (x, y) = (i % n, i / n);
            let d = face_direction(face, texel_centre(x, n), texel_centre(y, n)).normalize();
            let l = *l * texel_solid_angle(x, y, n) as f32;
            [l * d.x, l * d.y, l * d.z]
        });
        Self { cells: cells.collect() }
    }

    /// Irradiance on a surface of unit normal `n`: ∫ L max(0, n·ω) dω.
    pub fn at(&self, n: Vec3) -> Spectrum {
        // Partial sums by rows of cells keep the rounding of long sums in `f32` small.
        let mut total = [0.0f64; 3];
        for part in self.cells.chunks(256) {
            let mut sum = Spectrum::ZERO;
            for m in part {
                sum += (m[0] * n.x + m[1] * n.y + m[2] * n.z).max(Spectrum::ZERO);
            }
            (0..3).for_each(|i| total[i] += f64::from(sum[i]));
        }
        Spectrum::from_rgb(total.map(|v| v as f32))
    }

    /// The irradiance at each texel's direction, as a cube of `size`² faces without mips.
    pub fn cube(&self, size: u32) -> CubeMap {
        CubeMap::from_fn(size, |d| self.at(d.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::tests_support::lat_long;

    #[test]
    fn white_sky_gives_pi_everywhere() {
        for (w, h) in [(1, 1), (5, 3), (700, 350)] {
            let e = ExactIrradiance::new(&lat_long(w, h, 0.7, |_, _| [1.0; 3]));
            for n in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.36, 0.48, -0.8), Vec3::new(0.0, 0.6, 0.8)] {
                let v = e.at(n)[0];
                assert!((v / std::f32::consts::PI - 1.0).abs() < 5e-5, "{w} × {h} {n}: {v}");
            }
        }
    }

    /// A small light gives its power times the cosine, and nothing behind.
    #[test]
    fn a_small_light_follows_the_cosine() {
        let (w, h) = (512, 256);
        let sky = lat_long(w, h, 0.0, |x, y| if (x, y) == (300, 90) { [1e4; 3] } else { [0.0; 3] });
        let e = ExactIrradiance::new(&sky);
        let theta = std::f32::consts::PI * 90.5 / h as f32;
        let phi = std::f32::consts::TAU * (300.5 / w as f32 - 0.5);
        let sun = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        let power = e.at(sun)[0];
        let side = sun.any_orthonormal_vector();
        for cos in [0.9f32, 0.5, 0.1, -0.1, -1.0] {
            let n = sun * cos + side * (1.0 - cos * cos).sqrt();
            assert!((e.at(n)[0] - power * cos.max(0.0)).abs() < 2e-4 * power, "{cos}");
        }
    }
}
