//! Latitude-longitude pictures into cubes, without losing light.

use crate::cube::{CubeMap, face_direction, texel_centre};
use crate::sky::SkyMap;
use etendue_bxdf::math::{acos, atan2_turns};
use etendue_color::Spectrum;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Points per texel and axis that are taken at most.
const MOST_POINTS: u32 = 64;

/// The sky as a cube of `size`² faces (1 at least): each texel the mean radiance over its solid angle.
///
/// The mean is taken over a grid of points, weighted by solid angle, that is finer than the picture's texels, so that each of
/// these counts in proportion to its area (bilinear weights one texel apart add up to one). Near the poles, where columns
/// are narrow, a point takes the mean of the columns that its share of the texel spans.
pub fn to_cube(sky: &SkyMap, size: u32) -> CubeMap {
    let size = size.max(1);
    // A texel in the middle of a face spans 2/size radians, a row of the picture π/height.
    // In large pictures even a sun covers many texels, and points need not be as dense.
    let spacing = if sky.height() > 2048 { 0.7 } else { 0.35 };
    let fine = 2.0 / size as f32 / (spacing * PI / sky.height() as f32);
    let k = if sky.height() == 1 { 1 } else { (fine.ceil() as u32).clamp(2, MOST_POINTS) };
    // Around a pole the rows shrink to nothing, and a share of the light is left to chance unless the points are dense.
    let cap = (2.5 * PI / sky.height() as f32 + 1.5 / size as f32).min(0.5 * PI).cos();
    let texels = (0..6 * size)
        .into_par_iter()
        .flat_map_iter(|row| {
            let (face, y) = ((row / size) as usize, row % size);
            (0..size).map(move |x| {
                let centre = face_direction(face, texel_centre(x, size), texel_centre(y, size)).normalize();
                let k = if k > 1 && centre.y.abs() > cap { (4 * k).min(MOST_POINTS) } else { k };
                let points = size * k;
                let (mut sum, mut total) = (Spectrum::ZERO, 0.0);
                for j in 0..k {
                    let t = texel_centre(y * k + j, points);
                    for i in 0..k {
                        let s = texel_centre(x * k + i, points);
                        let d = face_direction(face, s, t);
                        let inv = 1.0 / d.length();
                        let weight = inv * inv * inv;
                        sum += point(sky, d * inv, 2.0 / points as f32 * inv) * weight;
                        total += weight;
                    }
                }
                sum / total
            })
        })
        .collect();
    // The texels are those of a cube of this size by construction.
    CubeMap::new(size, texels).unwrap_or_else(|| CubeMap::from_fn(1, |_| Spectrum::ZERO))
}

/// The radiance about `d`, averaged over `width` radians of azimuth.
fn point(sky: &SkyMap, d: glam::Vec3A, width: f32) -> Spectrum {
    let v = acos(d.y) * FRAC_1_PI;
    let u = atan2_turns(d.z, d.x) + 0.5 + sky.turn();
    let sin = (d.x * d.x + d.z * d.z).sqrt();
    let turns = (width / (TAU * sin.max(1e-6))).min(1.0);
    let n = (turns * sky.width() as f32 * 1.4).ceil().max(1.0);
    if n <= 1.0 {
        return sky.bilinear(u, v);
    }
    let mut sum = Spectrum::ZERO;
    for i in 0..n as u32 {
        let offset = turns * ((i as f32 + 0.5) / n - 0.5);
        sum += sky.bilinear((u + offset + 1.0) % 2.0, v);
    }
    sum / n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::irradiance::ExactIrradiance;
    use crate::sh::Sh9;
    use crate::sky::tests_support::lat_long;
    use glam::Vec3;

    #[test]
    fn a_white_sky_stays_white() {
        for (w, h) in [(1, 1), (8, 4), (64, 32)] {
            let cube = to_cube(&lat_long(w, h, 0.4, |_, _| [1.0, 2.0, 3.0]), 16);
            for l in cube.mip(0) {
                assert!((*l - Spectrum::rgb(1.0, 2.0, 3.0)).map(f32::abs).max_element() < 2e-5, "{l:?}");
            }
        }
    }

    /// One bright texel, at the pole, near it, and anywhere else, keeps its power whether the cube is coarser or finer than the picture.
    #[test]
    fn a_small_sun_keeps_its_power() {
        let (w, h) = (128, 64);
        for row in [0, 1, 5, 30, 63] {
            let sky = lat_long(w, h, 0.0, |x, y| if (x, y) == (37, row) { [1e5; 3] } else { [0.0; 3] });
            // The mean over the sphere from the first coefficient: c00 = mean · √(4π).
            let want = Sh9::project(&sky).0[0][0] / (4.0 * PI).sqrt();
            for size in [8, 32, 128] {
                let got = to_cube(&sky, size).mean(0)[0];
                assert!((got / want - 1.0).abs() < 0.02, "row {row}, {size}²: {got} {want}");
            }
        }
    }

    #[test]
    fn irradiance_of_the_cube_is_that_of_the_sky() {
        let sky = lat_long(96, 48, 2.0, |x, y| {
            [(x % 7) as f32, if (x, y) == (20, 9) { 900.0 } else { 0.3 }, y as f32 / 48.0]
        });
        let cube = to_cube(&sky, 64);
        let exact = ExactIrradiance::new(&sky);
        for n in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(-0.6, 0.48, 0.64)] {
            let mut sum = [0.0f64; 3];
            for (i, l) in cube.mip(0).iter().enumerate() {
                let (face, i) = (i / 4096, i as u32 % 4096);
                let (x, y) = (i % 64, i / 64);
                let c = |v| crate::cube::texel_centre(v, 64);
                let cos = face_direction(face, c(x), c(y)).normalize().dot(n.into()).max(0.0);
                let w = crate::cube::texel_solid_angle(x, y, 64) * f64::from(cos);
                (0..3).for_each(|c| sum[c] += w * f64::from(l[c]));
            }
            let want = exact.at(n).to_rgb();
            for c in 0..3 {
                assert!((sum[c] as f32 / want[c] - 1.0).abs() < 5e-3, "{n}: {sum:?} {want:?}");
            }
        }
    }
}
