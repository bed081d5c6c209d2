//! FLIP: the difference that a viewer sees when flipping between two pictures.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images" (2020), called LDR here, and Andersson, Nilsson, Shirley, Akenine-Möller, "Visualizing Errors in Rendered High Dynamic
//! Range Images" (2021), called HDR here. Both pictures are blurred as the eye does at some distance (contrast sensitivity, section 4.1.1), compared in a
//! colour space where large distances make sense (HyAB in L*a*b* with Hunt's correction, 4.1.2-4.1.3), and the result is amplified where edges
//! or points differ (4.2). 0 is no difference, 1 the largest.

use etendue_color::{srgb_decode, srgb8_decode};
use rayon::prelude::*;

use super::{color, comparable};
use crate::{Image, ImageError, Pixels};

/// Pixels per degree of a viewer 0.7 m from a screen 0.7 m and 3840 pixels wide, the paper's default: 67.0206.
pub const DEFAULT_PPD: f32 = 67.020_64;

// Parameters of the paper, in its names: 4.1.3 and 4.2.
const QC: f32 = 0.7;
const PC: f32 = 0.4;
const PT: f32 = 0.95;
const W: f32 = 0.082;
const QF: f32 = 0.5;

/// A FLIP comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Error of each pixel, 0..1, row by row.
    pub map: Vec<f32>,
    /// Mean of the map.
    pub mean: f64,
}

impl Flip {
    fn of(map: Vec<f32>) -> Self {
        let mean = map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64;
        Self { map, mean }
    }
}

/// FLIP of two pictures as a display shows them: integer samples are sRGB, float samples linear light, clipped to 0..1.
/// Alpha is not looked at.
///
/// # Errors
/// When the pictures differ in size.
pub fn ldr_flip(reference: &Image, test: &Image, pixels_per_degree: f32) -> Result<Flip, ImageError> {
    comparable(reference, test)?;
    let ppd = sane_ppd(pixels_per_degree);
    let size = (reference.width as usize, reference.height as usize);
    Ok(Flip::of(flip(&display_light(reference), &display_light(test), size, ppd)))
}

/// HDR-FLIP of two pictures in linear light: the largest LDR-FLIP of each pixel over a range of exposures.
///
/// The exposures follow from the reference (2021, section 3.2): the brightest pixel, then the median one, is brought to 0.85 by the
/// tone curve (Narkowicz' fit of ACES at 0.6), in steps of at most one stop. NaN and infinite samples count as 0.
///
/// # Errors
/// When the pictures differ in size.
pub fn hdr_flip(reference: &Image, test: &Image, pixels_per_degree: f32) -> Result<Flip, ImageError> {
    comparable(reference, test)?;
    let ppd = sane_ppd(pixels_per_degree);
    let size = (reference.width as usize, reference.height as usize);
    let (r, t) = (scene_light(reference), scene_light(test));
    let (start, stop) = exposure_range(&r);
    let count = ((stop - start).ceil() as usize).clamp(2, 64);
    let mut map = vec![0f32; r.len()];
    for i in 0..count {
        let gain = (start + (stop - start) * i as f32 / (count - 1) as f32).exp2();
        let map_one = |p: &[[f32; 3]]| p.par_iter().map(|c| c.map(|v| aces06(v * gain))).collect::<Vec<_>>();
        let step = flip(&map_one(&r), &map_one(&t), size, ppd);
        map.iter_mut().zip(step).for_each(|(m, s)| *m = m.max(s));
    }
    Ok(Flip::of(map))
}

fn sane_ppd(ppd: f32) -> f32 {
    // Kernels grow with it; 2000 is far beyond any display.
    if ppd.is_finite() { ppd.clamp(1.0, 2000.0) } else { DEFAULT_PPD }
}

fn display_light(image: &Image) -> Vec<[f32; 3]> {
    pixels(image, |i, x, y| {
        let c = match &i.pixels {
            // Exact bytes again: samples are n / 255.
            Pixels::U8(_) => color(i, x, y).map(|v| srgb8_decode((v * 255.0).round() as u8)),
            Pixels::U16(_) => color(i, x, y).map(srgb_decode),
            Pixels::F32(_) => color(i, x, y),
        };
        c.map(clip)
    })
}

fn scene_light(image: &Image) -> Vec<[f32; 3]> {
    pixels(image, |i, x, y| {
        let c = match &i.pixels {
            Pixels::F32(_) => color(i, x, y),
            _ => color(i, x, y).map(srgb_decode),
        };
        c.map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 })
    })
}

fn pixels(image: &Image, f: impl Fn(&Image, u32, u32) -> [f32; 3] + Sync) -> Vec<[f32; 3]> {
    let f = &f;
    (0..image.height)
        .into_par_iter()
        .flat_map_iter(|y| (0..image.width).map(move |x| f(image, x, y)))
        .collect()
}

/// 0..1, NaN becoming 0.
fn clip(v: f32) -> f32 {
    if v > 0.0 { v.min(1.0) } else { 0.0 }
}

/// Narkowicz' curve of 0.6 x, the default of HDR-FLIP.
fn aces06(x: f32) -> f32 {
    let x = 0.6 * x.min(1e9);
    clip((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14))
}

/// Exposures at which the brightest and the median luminance reach 0.85 on the display.
fn exposure_range(light: &[[f32; 3]]) -> (f32, f32) {
    // The larger root of 0.36 (2.51 − 0.85 · 2.43) x² + 0.6 (0.03 − 0.85 · 0.59) x − 0.85 · 0.14 = 0.
    let (a, b, c) = (0.36 * (2.51 - 0.85 * 2.43), 0.6 * (0.03 - 0.85 * 0.59), -0.85 * 0.14f64);
    let x = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let mut y: Vec<f32> = light.iter().map(|c| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]).collect();
    y.sort_unstable_by(f32::total_cmp);
    let n = y.len();
    // Of an even number the upper one of the middle two, as in the authors' evaluator.
    let median = y[n / 2];
    let ev = |y: f32| (x / f64::from(y.max(1e-5))).log2() as f32;
    (ev(y[n - 1]), ev(median))
}

// Colour spaces. The matrix has the digits of the paper's code, white is what it makes of (1, 1, 1).
const TO_XYZ: [[f32; 3]; 3] = [
    [(10135552.0 / 24577794.0) as f32, (8788810.0 / 24577794.0) as f32, (4435075.0 / 24577794.0) as f32],
    [(2613072.0 / 12288897.0) as f32, (8788810.0 / 12288897.0) as f32, (887015.0 / 12288897.0) as f32],
    [(1425312.0 / 73733382.0) as f32, (8788810.0 / 73733382.0) as f32, (70074185.0 / 73733382.0) as f32],
];
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_2, -1.537_399, -0.498_615_88],
    [-0.969_224_3, 1.875_93, 0.041_554_224],
    [0.055_639_42, -0.204_011_21, 1.057_149],
];
const WHITE: [f32; 3] = [0.950_428_5, 1.0, 1.088_900_4];

fn mul(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// Linear light relative to white, as X, Y, Z each 1 for white.
fn relative_xyz(c: [f32; 3]) -> [f32; 3] {
    let v = mul(&TO_XYZ, c);
    [v[0] / WHITE[0], v[1] / WHITE[1], v[2] / WHITE[2]]
}

/// The linear opponent space in which the eye's blur is applied (Zhang and Wandell 1997, as in 4.1.1).
fn to_ycxcz(c: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(c);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_ycxcz([l, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (l + 16.0) / 116.0;
    mul(&FROM_XYZ, [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]])
}

/// CIE L*a*b* with Hunt's effect: colours of dark pixels count less (equation 6).
fn hunt_lab(c: [f32; 3]) -> [f32; 3] {
    const D: f32 = 6.0 / 29.0;
    let f = |t: f32| if t > D * D * D { t.cbrt() } else { t / (3.0 * D * D) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(c).map(f);
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// The distance that stays meaningful for large differences (Abasi, Tehran, Fairchild 2019; equation 5).
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Both pictures in linear display light, to the error of each pixel (equation 1: `ΔE_c^(1 − ΔE_f)`).
fn flip(reference: &[[f32; 3]], test: &[[f32; 3]], size: (usize, usize), ppd: f32) -> Vec<f32> {
    let (r, t) = (to_planes(reference), to_planes(test));
    let (lab_r, lab_t) = (seen(&r, size, ppd), seen(&t, size, ppd));
    let (feature_r, feature_t) = (features(&r[0], size, ppd), features(&t[0], size, ppd));
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC);
    (0..reference.len())
        .into_par_iter()
        .map(|i| {
            let c = redistribute(hyab(lab_r[i], lab_t[i]).powf(QC), largest);
            let ([er, pr], [et, pt]) = (feature_r[i], feature_t[i]);
            let f = ((er - et).abs().max((pr - pt).abs()) / std::f32::consts::SQRT_2).powf(QF).min(1.0);
            c.powf(1.0 - f)
        })
        .collect()
}

/// Equation 8: the lower 40 % of the colour errors get 95 % of the range.
fn redistribute(e: f32, largest: f32) -> f32 {
    let knee = PC * largest;
    if e < knee { PT / knee * e } else { PT + (e - knee) / (largest - knee) * (1.0 - PT) }
}

fn to_planes(light: &[[f32; 3]]) -> [Vec<f32>; 3] {
    let c: Vec<[f32; 3]> = light.par_iter().map(|c| to_ycxcz(*c)).collect();
    std::array::from_fn(|i| c.iter().map(|c| c[i]).collect())
}

/// The picture as the eye passes it on: blurred per channel by the contrast sensitivity functions, in [`hunt_lab`].
fn seen(planes: &[Vec<f32>; 3], size: (usize, usize), ppd: f32) -> Vec<[f32; 3]> {
    use std::f32::consts::PI;
    // Table 1: two Gaussians a √(π/b) exp(−π² x² / b) per channel, x in degrees.
    const CSF: [&[(f32, f32)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
    // Three standard deviations of the widest of all; b = 2 π² σ².
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * ppd).ceil() as isize;
    let blurred: [Vec<f32>; 3] = std::array::from_fn(|c| {
        let gaussians: Vec<(f32, Vec<f32>)> = CSF[c]
            .iter()
            .map(|&(a, b)| {
                let g = kernel(radius, |x| (-PI * PI * (x / ppd) * (x / ppd) / b).exp());
                let sum: f32 = g.iter().sum();
                // Weight of this Gaussian in the two-dimensional kernel, which is normalised as a whole.
                (a * (PI / b).sqrt() * sum * sum, g.iter().map(|v| v / sum).collect())
            })
            .collect();
        let total: f32 = gaussians.iter().map(|g| g.0).sum();
        let mut out = vec![0f32; planes[c].len()];
        for (weight, g) in &gaussians {
            let part = convolve(&planes[c], size, g, g);
            out.iter_mut().zip(part).for_each(|(o, p)| *o += weight / total * p);
        }
        out
    });
    (0..planes[0].len())
        .into_par_iter()
        .map(|i| hunt_lab(from_ycxcz([blurred[0][i], blurred[1][i], blurred[2][i]]).map(clip)))
        .collect()
}

/// Strength of edges and of points in the unblurred luminance (section 4.2): lengths of the gradient and of the second
/// derivatives, each by a Gaussian of the width of an edge that is just seen.
fn features(y: &[f32], size: (usize, usize), ppd: f32) -> Vec<[f32; 2]> {
    let luminance: Vec<f32> = y.iter().map(|v| (v + 16.0) / 116.0).collect();
    let sd = 0.5 * W * ppd;
    let radius = (3.0 * sd).ceil() as isize;
    let gauss = |x: f32| (-x * x / (2.0 * sd * sd)).exp();
    // Positive and negative weights sum to 1 and −1, so that the strengths do not depend on the resolution.
    let signed = |k: Vec<f32>| {
        let (plus, minus) = k.iter().fold((0.0, 0.0), |(p, m), &v: &f32| (p + v.max(0.0), m - v.min(0.0)));
        k.iter().map(|v| if *v > 0.0 { v / plus } else { v / minus }).collect::<Vec<f32>>()
    };
    let g = kernel(radius, gauss);
    let sum: f32 = g.iter().sum();
    let g: Vec<f32> = g.iter().map(|v| v / sum).collect();
    let edge = signed(kernel(radius, |x| -x * gauss(x)));
    let point = signed(kernel(radius, |x| (x * x / (sd * sd) - 1.0) * gauss(x)));
    let [ex, ey, px, py] =
        [(&edge, &g), (&g, &edge), (&point, &g), (&g, &point)].map(|(h, v)| convolve(&luminance, size, h, v));
    (0..y.len()).map(|i| [ex[i].hypot(ey[i]), px[i].hypot(py[i])]).collect()
}

fn kernel(radius: isize, f: impl Fn(f32) -> f32) -> Vec<f32> {
    (-radius..=radius).map(|x| f(x as f32)).collect()
}

/// Convolution by `horizontal` along rows, then `vertical` along columns; pixels beyond the border repeat it.
fn convolve(plane: &[f32], (w, h): (usize, usize), horizontal: &[f32], vertical: &[f32]) -> Vec<f32> {
    let at = |i: usize, k: usize, len: usize, n: usize| {
        (i as isize + k as isize - (len / 2) as isize).clamp(0, n as isize - 1) as usize
    };
    let mut rows = vec![0f32; w * h];
    rows.par_chunks_exact_mut(w).zip(plane.par_chunks_exact(w)).for_each(|(out, row)| {
        for (x, o) in out.iter_mut().enumerate() {
            *o = horizontal.iter().enumerate().map(|(k, g)| g * row[at(x, k, horizontal.len(), w)]).sum();
        }
    });
    let mut out = vec![0f32; w * h];
    out.par_chunks_exact_mut(w).enumerate().for_each(|(y, out)| {
        for (k, g) in vertical.iter().enumerate() {
            let row = &rows[at(y, k, vertical.len(), h) * w..][..w];
            out.iter_mut().zip(row).for_each(|(o, v)| *o += g * v);
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const W48: u32 = 48;
    const H40: u32 = 40;

    /// Sharp patterns that differ in every pixel.
    fn busy(k: u32) -> Image {
        let mut p = Vec::new();
        for y in 0..H40 {
            for x in 0..W48 {
                let c = [
                    f64::from((x * 7 + y * 13 + k * 5) % 64) / 63.0,
                    f64::from((x * 3 + y * y + k * 11) % 50) / 49.0,
                    f64::from((x * x + y * 5 + k * 3) % 37) / 36.0,
                ];
                p.extend(c.map(|v| (v * 255.0 + 0.5).floor() as u8));
            }
        }
        Image { width: W48, height: H40, channels: 3, pixels: Pixels::U8(p) }
    }

    fn ramp(k: u32, x: u32, y: u32) -> [f64; 3] {
        let (x, y, k) = (f64::from(x), f64::from(y), f64::from(k));
        [(x + k * 3.0) / 60.0, (y + k * 2.0) / 48.0, (x + y + k) / 92.0]
    }

    fn smooth(k: u32, hdr: bool) -> Image {
        let all: Vec<f64> = (0..H40 * W48).flat_map(|i| ramp(k, i % W48, i / W48)).collect();
        let pixels = if hdr {
            Pixels::F32(all.iter().map(|v| (v.powi(3) * 20.0) as f32).collect())
        } else {
            Pixels::U8(all.iter().map(|v| (v * 255.0 + 0.5).floor() as u8).collect())
        };
        Image { width: W48, height: H40, channels: 3, pixels }
    }

    /// Mean, and the pixels (0, 0), (17, 20) and (39, 7), as the authors' package gives them for the same arrays
    /// (8-bit values as n / 255): `pip install flip-evaluator==1.7`, `flip.evaluate(a, b, "LDR" or "HDR", applyMagma=False)`.
    fn check(got: &Flip, mean: f64, at: [f32; 3], eps: f32) {
        assert!((got.mean - mean).abs() < f64::from(eps), "mean {} not {mean}", got.mean);
        for ((x, y), want) in [(0, 0), (17, 20), (39, 7)].into_iter().zip(at) {
            let v = got.map[y * W48 as usize + x];
            assert!((v - want).abs() < eps, "({x}, {y}): {v} not {want}");
        }
    }

    #[test]
    fn as_the_authors_evaluator() {
        let f = ldr_flip(&busy(0), &busy(1), DEFAULT_PPD).unwrap();
        check(&f, 0.494_507_0, [0.600_707, 0.617_475, 0.389_565], 2e-5);
        let f = ldr_flip(&smooth(0, false), &smooth(4, false), DEFAULT_PPD).unwrap();
        check(&f, 0.636_111_1, [0.545_168, 0.637_045, 0.602_215], 2e-5);
        let f = hdr_flip(&smooth(0, true), &smooth(4, true), DEFAULT_PPD).unwrap();
        check(&f, 0.758_612_4, [0.954_257, 0.818_835, 0.967_597], 2e-5);
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        assert!(ldr_flip(&busy(0), &busy(0), DEFAULT_PPD).unwrap().map.iter().all(|v| *v == 0.0));
        assert!(
            hdr_flip(&smooth(0, true), &smooth(0, true), DEFAULT_PPD).unwrap().map.iter().all(|v| *v == 0.0)
        );
    }

    #[test]
    fn extremes_stay_in_range() {
        let one = |v: f32| Image { width: 3, height: 2, channels: 3, pixels: Pixels::F32(vec![v; 18]) };
        for a in [0.0, 1.0, f32::NAN, f32::INFINITY, -1.0, 1e30] {
            for b in [0.0, 1.0, f32::NAN, f32::INFINITY, -1.0, 1e30] {
                for f in
                    [ldr_flip(&one(a), &one(b), f32::NAN).unwrap(), hdr_flip(&one(a), &one(b), 67.0).unwrap()]
                {
                    assert!(f.map.iter().all(|v| (0.0..=1.0).contains(v)), "{a} {b} {:?}", f.map);
                }
            }
        }
        assert!(ldr_flip(&one(0.0), &busy(0), 67.0).is_err());
    }
}
