//! Drawn directions against the density: over the polar angle, and cell by cell.

use super::{Subject, in_plane, peaks};
use crate::draw::{Anchor, Axis, Chart, DIVERGING, Drawing, GREY, INK, Item, Series, scale};
use etendue_bxdf::{Bsdf, laws::Rng, model::Closure, quadrature::gauss_legendre};
use glam::vec3a;

const ANGLES: [f64; 3] = [0.0, 45.0, 75.0];
/// Samples for each angle.
const SAMPLES: usize = 400_000;
/// Columns of the map, in azimuth.
const COLUMNS: usize = 72;
/// Rows for each hemisphere, in polar angle.
const ROWS: usize = 45;

/// Counts and expectations over (θ, φ), row by row.
struct Table {
    rows: usize,
    observed: Vec<f64>,
    expected: Vec<f64>,
    /// Parts of the samples that were perfectly specular, or nothing.
    discrete: [f64; 2],
}

pub(super) fn plot(s: &Subject) -> Drawing {
    let closure = s.closure();
    let passes = closure.refraction().is_some();
    let tables: Vec<Table> =
        ANGLES.iter().enumerate().map(|(i, a)| table(&closure, *a, passes, i as u64)).collect();
    let mut d = Drawing::new(1260, 700);
    let caption = format!(
        "{SAMPLES} samples for each wo. Left: dots are samples, lines the density integrated over each 2° of polar angle. \
         Right: (samples − expected) / √expected in cells of 2° × 5° that expect 5 or more, azimuth 0 towards wo; noise of \
         ±2 without pattern is as it should be."
    );
    d.frame(&s.title("samples against density"), &s.caption(&caption));
    let end = if passes { 180.0 } else { 90.0 };
    let bin = 90.0 / ROWS as f64;
    let mut series = Vec::new();
    for (i, t) in tables.iter().enumerate() {
        let sum = |v: &[f64]| -> Vec<[f64; 2]> {
            v.chunks_exact(COLUMNS)
                .enumerate()
                .map(|(row, cells)| {
                    [(row as f64 + 0.5) * bin, cells.iter().sum::<f64>() / SAMPLES as f64 / bin]
                })
                .collect()
        };
        series.push(Series::new(format!("wo at {}°", ANGLES[i]), i, sum(&t.expected)));
        series.push(Series { name: String::new(), ..Series::new("", i, sum(&t.observed)).dots() });
    }
    let chart = Chart {
        title: "over the polar angle of wi".into(),
        x: Axis::linear("angle of wi to the normal, degrees", 0.0, end),
        y: Axis::linear("probability per degree", 0.0, Chart::top(&series) * 1.05),
        series,
    };
    chart.draw(&mut d, [10.0, 52.0], [600.0, 520.0]);

    let height = 470.0 / 3.0;
    for (i, t) in tables.iter().enumerate() {
        let at = [690.0, 84.0 + (height + 16.0) * i as f32];
        let size = [440.0, height - 14.0];
        let pixels = t
            .observed
            .iter()
            .zip(&t.expected)
            .map(|(o, e)| (*e >= 5.0).then(|| scale(&DIVERGING, ((o - e) / e.sqrt() / 8.0 + 0.5) as f32)))
            .collect();
        d.rectangle(at, size, [0xee; 3]);
        d.items.push(Item::Picture { at, size, cells: [COLUMNS, t.rows], pixels });
        let z2: Vec<f64> = t
            .observed
            .iter()
            .zip(&t.expected)
            .filter(|(_, e)| **e >= 5.0)
            .map(|(o, e)| (o - e) * (o - e) / e)
            .collect();
        let rms = if z2.is_empty() { 0.0 } else { (z2.iter().sum::<f64>() / z2.len() as f64).sqrt() };
        let [delta, none] = t.discrete;
        let text = format!(
            "wo at {}°: RMS {rms:.2}; {:.1} % specular, {:.1} % nothing",
            ANGLES[i],
            100.0 * delta,
            100.0 * none
        );
        d.text([at[0], at[1] - 10.0], text, INK, Anchor::Start);
        for (t, label) in [(0.0, "0°".to_string()), (1.0, format!("{end}°"))] {
            d.text([at[0] - 6.0, at[1] + t * size[1]], label, INK, Anchor::End);
        }
        if i == 2 {
            for t in [0.0f32, 0.25, 0.5, 0.75, 1.0] {
                let label = format!("{}°", 360.0 * t);
                d.text([at[0] + t * size[0], at[1] + size[1] + 12.0], label, INK, Anchor::Middle);
            }
            d.text([at[0] + 0.5 * size[0], at[1] + size[1] + 30.0], "azimuth of wi", GREY, Anchor::Middle);
        }
        d.items.push(Item::Text {
            at: [at[0] - 50.0, at[1] + 0.5 * size[1]],
            text: "polar angle".into(),
            large: false,
            color: GREY,
            anchor: Anchor::Middle,
            upright: true,
        });
    }
    d.color_bar(
        [1176.0, 84.0],
        470.0,
        &DIVERGING,
        ["-4".into(), "0".into(), "+4".into()],
        "standard deviations",
    );
    d
}

fn table(closure: &Closure, degrees: f64, passes: bool, seed: u64) -> Table {
    let rows = if passes { 2 * ROWS } else { ROWS };
    let wo = in_plane(degrees);
    let mut observed = vec![0.0; rows * COLUMNS];
    let mut discrete = [0.0; 2];
    let mut rng = Rng::new(seed);
    let one = 1.0 / SAMPLES as f64;
    for _ in 0..SAMPLES {
        match closure.sample(wo, rng.uniform(), rng.square()) {
            None => discrete[1] += one,
            Some(s) if s.delta => discrete[0] += one,
            Some(s) => {
                let w = s.wi.as_dvec3();
                let theta = w.truncate().length().atan2(w.z).to_degrees();
                let phi = w.y.atan2(w.x).to_degrees().rem_euclid(360.0);
                let row = ((theta / 90.0 * ROWS as f64) as usize).min(rows - 1);
                let column = ((phi / 360.0 * COLUMNS as f64) as usize).min(COLUMNS - 1);
                observed[row * COLUMNS + column] += 1.0;
            }
        }
    }

    // The density's integral over each cell, with panels that double away from where a tight lobe may lie.
    let [ax, ay] = closure.narrowest_alpha();
    let width = (ax.min(ay) as f64).to_degrees().max(1e-3);
    let hints = peaks(closure, degrees);
    let thetas: Vec<f64> = hints.iter().map(|p| p.abs()).collect();
    let sines: Vec<f64> = thetas.iter().map(|t| t.to_radians().sin().max(0.02)).collect();
    let nodes = gauss_legendre(4);
    let panels = |low: f64, high: f64, centres: &[(f64, f64)]| {
        let mut out = vec![low, high];
        for &(centre, width) in centres {
            out.push(centre);
            let mut step = 0.5 * width;
            while step < high - low {
                out.extend([centre - step, centre + step]);
                step *= 2.0;
            }
        }
        out.retain(|v| (low..=high).contains(v));
        out.sort_by(f64::total_cmp);
        out.dedup_by(|a, b| *a - *b < 1e-9);
        out
    };
    let mut expected = Vec::with_capacity(observed.len());
    let (step_theta, step_phi) = (90.0 / ROWS as f64, 360.0 / COLUMNS as f64);
    for row in 0..rows {
        let centres: Vec<_> = thetas.iter().map(|t| (*t, width)).collect();
        let theta_panels = panels(row as f64 * step_theta, (row + 1) as f64 * step_theta, &centres);
        for column in 0..COLUMNS {
            let centres: Vec<_> =
                sines.iter().flat_map(|s| [0.0, 180.0, 360.0].map(|at| (at, width / s))).collect();
            let phi_panels = panels(column as f64 * step_phi, (column + 1) as f64 * step_phi, &centres);
            let mut sum = 0.0;
            for t in theta_panels.windows(2) {
                for p in phi_panels.windows(2) {
                    for &(x, wx) in &nodes {
                        let (sin, cos) = (t[0] + (t[1] - t[0]) * x).to_radians().sin_cos();
                        for &(y, wy) in &nodes {
                            let (sp, cp) = (p[0] + (p[1] - p[0]) * y).to_radians().sin_cos();
                            let wi = vec3a((sin * cp) as f32, (sin * sp) as f32, cos as f32);
                            let area = (t[1] - t[0]).to_radians() * (p[1] - p[0]).to_radians() * sin;
                            sum += wx * wy * area * closure.pdf(wo, wi) as f64;
                        }
                    }
                }
            }
            expected.push(SAMPLES as f64 * sum);
        }
    }
    Table { rows, observed, expected, discrete }
}
