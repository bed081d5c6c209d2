//! Fits linearly transformed cosines to the GGX lobe with heights correlated, and writes `src/ltc_table.bin`.
//!
//! For each roughness and angle four numbers (see `etendue_realtime::ltc::Shape`) are sought that make ∫ |f cos / E − D| least (Heitz et
//! al. 2016 take the third power), by the downhill simplex of Nelder and Mead 1965. The first power, rather than the paper's third, because what is
//! off matters for lights that meet a lobe's flank as much as at its peak. The integral is taken over directions drawn from both densities.
//!
//! ```text
//! cargo run --release -p etendue-realtime --example fit_ltc
//! ```

use etendue_bxdf::{Ggx, MIN_COS};
use etendue_realtime::ltc::{Ltc, SIZE, Shape, column_cos, row_roughness};
use glam::{Vec3A, vec3a};
use half::f16;
use rayon::prelude::*;

/// Samples along an axis of the square, from each density.
const SAMPLES: u32 = 28;

/// A lobe to be fitted: x points away from the viewer.
struct Target {
    ggx: Ggx,
    alpha: f32,
    cos: f32,
    wo: Vec3A,
    energy: f32,
    /// Directions drawn from the lobe, f cos / E there, and the density with which they were drawn.
    drawn: Vec<(Vec3A, f32, f32)>,
}

fn squares() -> impl Iterator<Item = [f32; 2]> {
    (0..SAMPLES * SAMPLES)
        .map(|i| [(i % SAMPLES) as f32 + 0.5, (i / SAMPLES) as f32 + 0.5].map(|v| v / SAMPLES as f32))
}

impl Target {
    fn new(roughness: f32, cos: f32) -> Self {
        let alpha = roughness * roughness;
        let ggx = Ggx::new(alpha, alpha);
        let wo = vec3a(-((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos);
        let mut drawn = Vec::new();
        let mut energy = 0.0f64;
        for u in squares() {
            let wi = ggx.sample_reflection(wo, u);
            if wi.z > MIN_COS {
                let pair = ggx.pair(wo, wi);
                let value = pair.value * wi.z;
                energy += f64::from(value / pair.pdf);
                drawn.push((wi, value, pair.pdf));
            }
        }
        let energy = (energy / f64::from(SAMPLES * SAMPLES)) as f32;
        drawn.iter_mut().for_each(|d| d.1 /= energy);
        Self { ggx, alpha, cos, wo, energy, drawn }
    }

    fn value(&self, wi: Vec3A) -> (f32, f32) {
        if wi.z <= MIN_COS {
            return (0.0, 0.0);
        }
        let pair = self.ggx.pair(self.wo, wi);
        (pair.value * wi.z / self.energy, pair.pdf)
    }

    /// ∫ |f cos / E − D|ᵖ over the directions, by both densities.
    fn error(&self, shape: Shape, power: i32) -> f64 {
        if !(shape.m11 > 1e-3 && shape.m22 > 1e-3) {
            return f64::INFINITY;
        }
        let ltc = Ltc::new(shape, self.alpha, self.cos);
        let mut sum = 0.0;
        let mut add = |wi: Vec3A, value: f32, pdf: f32| {
            let d = ltc.density(wi);
            let difference = f64::from((value - d).abs());
            // Drawn from the whole of D, a part of which is below the horizon.
            let all = f64::from(pdf + d / ltc.inv_above());
            if all > 0.0 {
                sum += difference.powi(power) / all;
            }
        };
        for &(wi, value, pdf) in &self.drawn {
            add(wi, value, pdf);
        }
        for u in squares() {
            let local = etendue_bxdf::sampling::cosine_hemisphere(u);
            let wi = ltc.stretch(local).normalize();
            let (value, pdf) = self.value(wi);
            add(wi, value, pdf);
        }
        sum / f64::from(SAMPLES * SAMPLES)
    }
}

fn shape(p: [f64; 4]) -> Shape {
    let [m11, m22, m13, lean] = p.map(|v| v as f32);
    Shape { m11, m22, m13, lean }
}

/// Nelder, Mead 1965, with the usual coefficients.
fn least(mut f: impl FnMut([f64; 4]) -> f64, start: [f64; 4], step: f64) -> ([f64; 4], f64) {
    let mut simplex: Vec<([f64; 4], f64)> = (0..5)
        .map(|i| {
            let mut p = start;
            if i > 0 {
                p[i - 1] += step;
            }
            (p, f(p))
        })
        .collect();
    for _ in 0..300 {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        if (simplex[4].1 - simplex[0].1).abs() < 1e-7 * simplex[0].1.abs() {
            break;
        }
        let middle: [f64; 4] =
            std::array::from_fn(|k| simplex[..4].iter().map(|v| v.0[k]).sum::<f64>() / 4.0);
        let mut towards = |t: f64| {
            let p: [f64; 4] = std::array::from_fn(|k| middle[k] + t * (simplex[4].0[k] - middle[k]));
            (p, f(p))
        };
        let reflected = towards(-1.0);
        if reflected.1 < simplex[0].1 {
            let further = towards(-2.0);
            simplex[4] = if further.1 < reflected.1 { further } else { reflected };
        } else if reflected.1 < simplex[3].1 {
            simplex[4] = reflected;
        } else {
            let nearer = towards(if reflected.1 < simplex[4].1 { -0.5 } else { 0.5 });
            if nearer.1 < simplex[4].1.min(reflected.1) {
                simplex[4] = nearer;
            } else {
                let best = simplex[0].0;
                for v in &mut simplex[1..] {
                    v.0 = std::array::from_fn(|k| best[k] + 0.5 * (v.0[k] - best[k]));
                    v.1 = f(v.0);
                }
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0]
}

fn main() -> std::io::Result<()> {
    let rows: Vec<Vec<([f64; 4], f64)>> = (0..SIZE)
        .into_par_iter()
        .map(|row| {
            // From normal incidence on, each angle starts where the last ended.
            let mut start = [1.0, 1.0, 0.0, 0.0];
            (0..SIZE)
                .map(|column| {
                    let target = Target::new(row_roughness(row), column_cos(column));
                    let straight = column == 0;
                    let error = |mut p: [f64; 4]| {
                        if straight {
                            // A lobe about the normal is round.
                            (p[1], p[2], p[3]) = (p[0], 0.0, 0.0);
                        }
                        target.error(shape(p), 1)
                    };
                    let first = least(error, start, 0.15);
                    let (mut p, _) = least(error, first.0, 0.03);
                    if straight {
                        (p[1], p[2], p[3]) = (p[0], 0.0, 0.0);
                    }
                    start = p;
                    (p, 0.5 * target.error(shape(p), 1))
                })
                .collect()
        })
        .collect();
    let mut bytes = Vec::new();
    println!(
        "part of the lobe's energy that lies elsewhere (½ ∫ |difference|): by roughness, mean and worst over angles"
    );
    for (i, row) in rows.iter().enumerate() {
        for (p, _) in row {
            p.iter().for_each(|v| bytes.extend(f16::from_f64(*v).to_le_bytes()));
        }
        let mean = row.iter().map(|c| c.1).sum::<f64>() / SIZE as f64;
        let worst = row.iter().map(|c| c.1).fold(0.0, f64::max);
        println!("{:.3}  {mean:.4}  {worst:.4}", row_roughness(i));
    }
    std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/src/ltc_table.bin"), bytes)
}
