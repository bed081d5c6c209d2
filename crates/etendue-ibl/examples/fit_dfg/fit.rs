//! Coefficients of a program: least squares (Levenberg 1944, Marquardt 1963), then with weights that grow where the error is largest
//! (Lawson 1961), so that the worst error falls too.

use crate::grid::{F0, Grid, TARGET, What};
use crate::program::Program;

/// Rooms for the values of one program at all points.
#[derive(Default)]
pub struct Scratch {
    values: Vec<f64>,
    adjoint: Vec<f64>,
    scale: Vec<f64>,
    bias: Vec<f64>,
    gram: Vec<f64>,
    error: [Vec<f64>; 2],
}

/// Worst and root mean square error of the albedo at each F0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors(pub [[f64; 2]; 2]);

impl Errors {
    /// The largest in units of the target.
    pub fn score(&self) -> f64 {
        self.0.iter().map(|[w, r]| (w / TARGET[0]).max(r / TARGET[1])).fold(0.0, f64::max)
    }
}

/// Signed errors at the grid's points into `s.error`, and their figures; `None` if one is no number.
pub fn measure(p: &Program, grid: &Grid, s: &mut Scratch) -> Option<Errors> {
    p.evaluate(&grid.r, &grid.m, &mut s.values);
    let n = grid.r.len();
    let (a, b) = (&s.values[p.out[0] as usize * n..][..n], &s.values[p.out[1] as usize * n..][..n]);
    let mut figures = [[0.0; 2]; 2];
    for (k, f0) in F0.into_iter().enumerate() {
        let e = &mut s.error[k];
        e.clear();
        match grid.what {
            What::Both => e.extend((0..n).map(|i| f0 * (a[i] - grid.scale[i]) + b[i] - grid.bias[i])),
            What::Energy => e.extend((0..n).map(|i| a[i] - grid.scale[i] - grid.bias[i])),
            What::Bias => e.extend((0..n).map(|i| a[i] - grid.bias[i])),
        }
        let (mut worst, mut sum) = (0.0f64, 0.0);
        for (e, w) in e.iter().zip(&grid.weight) {
            // Keeps NaN, which `max` would drop.
            worst = if e.abs() <= worst { worst } else { e.abs() };
            sum += w * e * e;
        }
        figures[k] = [worst, sum.sqrt()];
    }
    figures.iter().flatten().all(|v| v.is_finite()).then_some(Errors(figures))
}

/// One Levenberg-Marquardt step for squared errors with weights; `damping` is adapted. True if it went downhill.
fn step(p: &mut Program, grid: &Grid, weights: &[Vec<f64>; 2], s: &mut Scratch, damping: &mut f64) -> bool {
    let (n, k) = (grid.r.len(), p.constants.len());
    let cost = |s: &Scratch| -> f64 {
        (0..if grid.what == What::Both { 2 } else { 1 })
            .map(|f| s.error[f].iter().zip(&weights[f]).map(|(e, w)| w * e * e).sum::<f64>())
            .sum()
    };
    if measure(p, grid, s).is_none() || k == 0 {
        return false;
    }
    let before = cost(s);
    let mut scratch = std::mem::take(&mut s.adjoint);
    let (mut scale, mut bias) = (std::mem::take(&mut s.scale), std::mem::take(&mut s.bias));
    p.derivatives(0, &grid.r, &grid.m, &s.values, &mut scratch, &mut scale);
    p.derivatives(1, &grid.r, &grid.m, &s.values, &mut scratch, &mut bias);
    s.gram.clear();
    s.gram.resize(k * (k + 1), 0.0);
    for (f, f0) in F0.into_iter().enumerate() {
        // Rows of the Jacobian in place of the scale's derivatives, for one F0 after the other.
        let rows: Vec<f64> = match grid.what {
            What::Both => scale.iter().zip(&bias).map(|(a, b)| f0 * a + b).collect(),
            _ if f == 1 => break,
            _ => scale.clone(),
        };
        let mut weighted = vec![0.0; n];
        for i in 0..k {
            let x = &rows[i * n..(i + 1) * n];
            (0..n).for_each(|q| weighted[q] = x[q] * weights[f][q]);
            for j in i..k {
                s.gram[i * (k + 1) + j] += dot(&weighted, &rows[j * n..(j + 1) * n]);
            }
            s.gram[i * (k + 1) + k] -= dot(&weighted, &s.error[f]);
        }
    }
    (s.adjoint, s.scale, s.bias) = (scratch, scale, bias);
    let old = p.constants.clone();
    for _ in 0..6 {
        if let Some(x) = solve(&s.gram, k, *damping) {
            (0..k).for_each(|i| p.constants[i] = old[i] + x[i]);
            if measure(p, grid, s).is_some() && cost(s) < before {
                *damping = (*damping * 0.2).max(1e-12);
                return true;
            }
        }
        *damping = (*damping * 8.0).min(1e9);
    }
    p.constants = old;
    let _ = measure(p, grid, s);
    false
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut part = [0.0; 8];
    let (x, y) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(a, b)| a * b).sum();
    for (x, y) in x.zip(y) {
        (0..8).for_each(|i| part[i] += x[i] * y[i]);
    }
    part.iter().sum::<f64>() + rest
}

/// Solves the damped normal equations, kept as the upper triangle and the right side of each row, by Cholesky's factors.
fn solve(gram: &[f64], k: usize, damping: f64) -> Option<Vec<f64>> {
    let at = |i: usize, j: usize| if i <= j { gram[i * (k + 1) + j] } else { gram[j * (k + 1) + i] };
    let mut l = vec![0.0; k * k];
    for i in 0..k {
        for j in 0..=i {
            let mut v = at(i, j);
            if i == j {
                v = v * (1.0 + damping) + 1e-14;
            }
            v -= (0..j).map(|q| l[i * k + q] * l[j * k + q]).sum::<f64>();
            l[i * k + j] = if i == j {
                if v.is_nan() || v <= 0.0 {
                    return None;
                }
                v.sqrt()
            } else {
                v / l[j * k + j]
            };
        }
    }
    let mut x: Vec<f64> = (0..k).map(|i| at(i, k)).collect();
    // The right side stands in the last column of each row.
    for i in 0..k {
        x[i] = gram[i * (k + 1) + k];
    }
    for i in 0..k {
        let v: f64 = (0..i).map(|q| l[i * k + q] * x[q]).sum();
        x[i] = (x[i] - v) / l[i * k + i];
    }
    for i in (0..k).rev() {
        let v: f64 = (i + 1..k).map(|q| l[q * k + i] * x[q]).sum();
        x[i] = (x[i] - v) / l[i * k + i];
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}

/// Fits a program's coefficients; keeps the best of all rounds. After `settle` steps of plain least squares it is given up if its score
/// is above `hopeless`; then `rounds` of raised weights.
pub fn fit(
    p: &mut Program,
    grid: &Grid,
    settle: usize,
    rounds: usize,
    hopeless: f64,
    s: &mut Scratch,
) -> Option<Errors> {
    let mut weights = [grid.weight.clone(), grid.weight.clone()];
    let mut damping = 1e-3;
    let mut best = (measure(p, grid, s)?, p.constants.clone());
    for i in 0..settle {
        let went = step(p, grid, &weights, s, &mut damping);
        if let Some(e) = measure(p, grid, s)
            && e.score() < best.0.score()
        {
            best = (e, p.constants.clone());
        }
        if !went || (i == settle / 2 && best.0.score() > 1.6 * hopeless) {
            break;
        }
    }
    if best.0.score() <= hopeless {
        for _ in 0..rounds {
            let errors = measure(p, grid, s)?;
            for (f, w) in weights.iter_mut().enumerate() {
                // Weights follow the worst error only where that is what keeps the score up.
                let [worst, rms] = errors.0[f];
                let power = if worst / TARGET[0] > rms / TARGET[1] { 1.0 } else { 0.15 };
                let top = errors.0[0][0].max(errors.0[1][0]).max(1e-12);
                for (w, e) in w.iter_mut().zip(&s.error[f]) {
                    *w *= (0.6 + e.abs() / top).powf(power);
                }
            }
            let sum: f64 = weights.iter().flatten().sum();
            weights.iter_mut().flatten().for_each(|w| *w *= 2.0 / sum);
            damping = damping.max(1e-6);
            step(p, grid, &weights, s, &mut damping);
            if let Some(e) = measure(p, grid, s)
                && e.score() < best.0.score()
            {
                best = (e, p.constants.clone());
            }
        }
    }
    p.constants = best.1;
    Some(best.0)
}
