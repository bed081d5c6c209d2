//! Fits formulas to the reflectance of height-correlated Smith GGX, and says how good others are.
//!
//! `cargo run --release -p etendue-ibl --example fit_dfg [-- --search TRIALS] [-- --svg FILE]`
//!
//! Without options: the errors of the formulas of `etendue_ibl::dfg_fit`, and their coefficients fitted anew. With `--search`, for each number of terms, the
//! best of so many rational functions found by exchange of terms (the same for the same TRIALS): the frontier of cost against error, as a table, and
//! as a plot with `--svg`. Deterministic.

use etendue_ibl::Dfg;
use etendue_ibl::dfg_fit::{karis, lazarov, ours};
use rayon::prelude::*;
use std::fmt::Write;

/// Cells of the grid along an edge; values belong to their middles, as in a table.
const N: usize = 64;
/// What is asked for: worst error and root of the mean square.
const TARGET: (f64, f64) = (0.01, 0.003);

/// A formula for the reflectance by roughness and cosine.
type Formula = fn(f32, f32) -> Dfg;
/// A term mⁱ rʲ.
type Term = (u32, u32);

/// The grid: roughness, cosine, E, B.
struct Grid(Vec<[f64; 4]>);

impl Grid {
    fn new() -> Self {
        let at = |i: usize| (i as f32 + 0.5) / N as f32;
        let cells: Vec<usize> = (0..N * N).collect();
        let rows = cells.par_iter().map(|i| {
            let (r, m) = (at(i / N), at(i % N));
            let d = Dfg::exact(r, m);
            [r, m, d.energy(), d.bias].map(f64::from)
        });
        Self(rows.collect())
    }

    /// Every second row and column: enough to compare forms.
    fn coarse(&self) -> Self {
        let keep = |i: &usize| (i / N).is_multiple_of(2) && (i % N).is_multiple_of(2);
        Self((0..self.0.len()).filter(keep).map(|i| self.0[i]).collect())
    }
}

/// A rational function base · Σ p mⁱ rʲ / Σ q mⁱ rʲ whose first denominator coefficient is 1.
#[derive(Clone)]
struct Fit {
    numerator: Vec<Term>,
    denominator: Vec<Term>,
    p: Vec<f64>,
    q: Vec<f64>,
    worst: f64,
    rms: f64,
}

impl Fit {
    /// The larger of the errors in units of the target.
    fn score(&self) -> f64 {
        (self.worst / TARGET.0).max(self.rms / TARGET.1)
    }

    /// Operations of a plain evaluation: each power once, each product of powers, a multiplication and addition for each coefficient, the division.
    fn operations(&self, base: usize) -> usize {
        let terms = || self.numerator.iter().chain(&self.denominator);
        // Terms may be divided by their common part.
        let low = (terms().map(|t| t.0).min().unwrap_or(0), terms().map(|t| t.1).min().unwrap_or(0));
        let powers = |of: &dyn Fn(&Term) -> u32| {
            let mut seen: Vec<u32> = terms().map(of).filter(|e| *e > 1).collect();
            seen.sort_unstable();
            seen.dedup();
            // Even ones without their halves need another step; two at most for 5, 6 and 7.
            seen.iter().map(|e| if *e == 2 || seen.contains(&(e - 1)) { 1 } else { 2 }).sum::<usize>()
        };
        let products = terms().filter(|t| t.0 > low.0 && t.1 > low.1).count();
        powers(&|t| t.0 - low.0)
            + powers(&|t| t.1 - low.1)
            + products
            + self.p.len()
            + self.q.len()
            + 1
            + base
    }
}

/// What is fitted: the loss 1 − E, or B over a power of 1 − m.
#[derive(Clone, Copy)]
enum Target {
    Loss,
    Bias(i32),
}

impl Target {
    fn value(self, g: &[f64; 4]) -> f64 {
        match self {
            Self::Loss => 1.0 - g[2],
            Self::Bias(_) => g[3],
        }
    }

    fn base(self, g: &[f64; 4]) -> f64 {
        match self {
            Self::Loss => 1.0,
            Self::Bias(k) => (1.0 - g[1]).powi(k),
        }
    }

    /// Operations of the base.
    fn cost(self) -> usize {
        match self {
            Self::Loss => 1,
            Self::Bias(4) => 4,
            Self::Bias(_) => 5,
        }
    }
}

/// Gauss's elimination with pivots; `None` for a singular matrix.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for i in 0..n {
        let p = (i..n).max_by(|x, y| a[*x][i].abs().total_cmp(&a[*y][i].abs()))?;
        if a[p][i].abs() <= 1e-300 || a[p][i].is_nan() {
            return None;
        }
        a.swap(i, p);
        b.swap(i, p);
        for k in i + 1..n {
            let f = a[k][i] / a[i][i];
            for j in i..n {
                a[k][j] -= f * a[i][j];
            }
            b[k] -= f * b[i];
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let rest: f64 = (i + 1..n).map(|j| a[i][j] * x[j]).sum();
        x[i] = (b[i] - rest) / a[i][i];
    }
    Some(x)
}

/// Coefficients by linear least squares in P − t Q = 0, the equations divided by the last Q (Sanathanan, Koerner 1963); after `settle` rounds the
/// weights grow where the error is largest (Lawson 1961). The best of all rounds.
fn fit(
    grid: &Grid,
    target: Target,
    numerator: &[Term],
    denominator: &[Term],
    settle: usize,
    lawson: usize,
) -> Option<Fit> {
    let (np, n) = (numerator.len(), grid.0.len());
    let k = np + denominator.len() - 1;
    let rows: Vec<(f64, Vec<f64>, Vec<f64>)> = grid
        .0
        .iter()
        .map(|g| {
            let term = |t: &Term| g[1].powi(t.0 as i32) * g[0].powi(t.1 as i32);
            let base = target.base(g);
            let p = numerator.iter().map(|t| base * term(t)).collect();
            (target.value(g), p, denominator.iter().map(term).collect())
        })
        .collect();
    let (mut q_last, mut weight) = (vec![1.0f64; n], vec![1.0f64; n]);
    let mut best: Option<Fit> = None;
    let mut row = vec![0.0f64; k];
    for round in 0..settle + lawson {
        let (mut a, mut b) = (vec![vec![0.0; k]; k], vec![0.0; k]);
        for (i, (t, p, q)) in rows.iter().enumerate() {
            let s = (weight[i] / q_last[i].abs().max(1e-5)).powi(2);
            row[..np].copy_from_slice(p);
            for j in 1..q.len() {
                row[np + j - 1] = -t * q[j];
            }
            for j in 0..k {
                b[j] += row[j] * t * q[0] * s;
                for l in j..k {
                    a[j][l] += row[j] * row[l] * s;
                }
            }
        }
        for j in 0..k {
            a[j][j] *= 1.0 + 1e-13;
            for l in 0..j {
                a[j][l] = a[l][j];
            }
        }
        let x = solve(a, b)?;
        let (mut worst, mut square) = (0.0f64, 0.0);
        let mut errors = vec![0.0f64; n];
        for (i, (t, p, q)) in rows.iter().enumerate() {
            let top: f64 = p.iter().zip(&x).map(|(p, x)| p * x).sum();
            let bottom = q[0] + q[1..].iter().zip(&x[np..]).map(|(q, x)| q * x).sum::<f64>();
            q_last[i] = bottom;
            let e = if bottom > 1e-9 { (top / bottom - t).abs() } else { 10.0 };
            errors[i] = if e < 10.0 { e } else { 10.0 };
            worst = worst.max(errors[i]);
            square += errors[i] * errors[i];
        }
        let now = Fit {
            numerator: numerator.to_vec(),
            denominator: denominator.to_vec(),
            p: x[..np].to_vec(),
            q: x[np..].to_vec(),
            worst,
            rms: (square / n as f64).sqrt(),
        };
        if best.as_ref().is_none_or(|b| now.score() < b.score()) {
            best = Some(now);
        }
        if round >= settle {
            let mut most = 0.0f64;
            for (w, e) in weight.iter_mut().zip(&errors) {
                *w *= 0.5 + e / worst.max(1e-12);
                most = most.max(*w);
            }
            weight.iter_mut().for_each(|w| *w /= most);
        } else if round > 4 && best.as_ref().is_some_and(|b| b.score() > 200.0) {
            break;
        }
    }
    best
}

/// A multiplicative generator: the search is the same each time.
struct Rng(u64);

impl Rng {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % n as u64) as usize
    }
}

/// The best form with so many terms that `trials` exchanges find, from one start after another.
fn search(grid: &Grid, target: Target, np: usize, nq: usize, trials: usize) -> Option<Fit> {
    let all: Vec<Term> =
        (0..=4).flat_map(|i| (0..=7).map(move |j| (i, j))).filter(|t| t.0 + t.1 <= 8).collect();
    let mut rng = Rng(np as u64 * 1000 + nq as u64);
    let distinct = |s: &[Term]| (1..s.len()).all(|i| !s[..i].contains(&s[i]));
    let (mut best, mut left): (Option<Fit>, usize) = (None, trials);
    while left > 0 {
        let mut terms: Vec<Term> = (0..np + nq).map(|_| all[rng.below(all.len())]).collect();
        let (mut current, mut failures): (Option<Fit>, usize) = (None, 0);
        while failures < 120 && left > 0 {
            let mut next = terms.clone();
            if current.is_some() {
                for _ in 0..1 + rng.below(2) {
                    next[rng.below(np + nq)] = all[rng.below(all.len())];
                }
            }
            left -= 1;
            let (p, q) = next.split_at(np);
            let found = if distinct(p) && distinct(q) { fit(grid, target, p, q, 9, 8) } else { None };
            match found {
                Some(f) if current.as_ref().is_none_or(|c| f.score() < c.score()) => {
                    (current, terms, failures) = (Some(f), next, 0);
                }
                _ => failures += 1,
            }
        }
        if let Some(c) = current
            && best.as_ref().is_none_or(|b| c.score() < b.score())
        {
            best = Some(c);
        }
    }
    best
}

fn name(terms: &[Term], coefficients: &[f64]) -> String {
    let power = |v: &str, e: u32| match e {
        0 => String::new(),
        1 => format!(" {v}"),
        _ => format!(" {v}^{e}"),
    };
    let mut out = String::new();
    for ((i, j), c) in terms.iter().zip(coefficients) {
        let _ = write!(out, " {c:+.6}{}{}", power("m", *i), power("r", *j));
    }
    out.trim().to_string()
}

fn describe(f: &Fit) -> String {
    let q: Vec<f64> = std::iter::once(1.0).chain(f.q.iter().copied()).collect();
    format!("({}) / ({})", name(&f.numerator, &f.p), name(&f.denominator, &q))
}

/// Worst and root mean square error of the albedo at an F0.
fn errors(grid: &Grid, f0: f64, fit: fn(f32, f32) -> Dfg) -> (f64, f64) {
    let (mut worst, mut square) = (0.0f64, 0.0);
    for g in &grid.0 {
        let d = fit(g[0] as f32, g[1] as f32);
        let want = f0 * (g[2] - g[3]) + g[3];
        let e = (f0 * f64::from(d.scale) + f64::from(d.bias) - want).abs();
        worst = worst.max(e);
        square += e * e;
    }
    (worst, (square / grid.0.len() as f64).sqrt())
}

fn svg(points: &[(String, usize, f64, &str)]) -> String {
    let (w, h) = (720.0, 440.0);
    let x = |ops: usize| 70.0 + (w - 100.0) * ops as f64 / 40.0;
    let y = |e: f64| 30.0 + (h - 80.0) * (0.5f64.log10() - e.log10()) / (0.5f64.log10() - 0.003f64.log10());
    let mut s = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>\n"
    );
    for e in [0.003, 0.01, 0.03, 0.1, 0.3] {
        let dash = if e == 0.01 { "" } else { " stroke-dasharray=\"2 4\"" };
        let _ = writeln!(
            s,
            "<line x1=\"70\" x2=\"{}\" y1=\"{:.1}\" y2=\"{:.1}\" stroke=\"#999\"{dash}/><text x=\"62\" y=\"{:.1}\" text-anchor=\"end\">{e}</text>",
            w - 30.0,
            y(e),
            y(e),
            y(e) + 4.0
        );
    }
    for ops in [0, 10, 20, 30, 40] {
        let _ =
            writeln!(s, "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{ops}</text>", x(ops), h - 32.0);
    }
    let _ =
        writeln!(s, "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">operations</text>", w / 2.0, h - 10.0);
    let _ = writeln!(
        s,
        "<text x=\"70\" y=\"18\">worst error of a fit over roughness and N·V, logarithmic; the line is the target</text>"
    );
    for (label, ops, e, colour) in points {
        let _ = writeln!(
            s,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{colour}\"/><text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{label}</text>",
            x(*ops),
            y(*e),
            x(*ops) + 7.0,
            y(*e) + 4.0
        );
    }
    s + "</svg>\n"
}

fn main() -> std::io::Result<()> {
    let args: Vec<String> = std::env::args().collect();
    let option = |name: &str| args.iter().position(|a| a == name).and_then(|i| args.get(i + 1));
    let grid = Grid::new();
    println!("formula      F0 = 0.04: worst, RMS      F0 = 1: worst, RMS");
    let known: [(&str, Formula); 3] = [("lazarov", lazarov), ("karis", karis), ("ours", ours)];
    let mut points = Vec::new();
    for (name, f) in known {
        let (a, b) = (errors(&grid, 0.04, f), errors(&grid, 1.0, f));
        println!("{name:<12} {:>10.5} {:>10.5}      {:>10.5} {:>10.5}", a.0, a.1, b.0, b.1);
        points.push((name.to_string(), if name == "ours" { 33 } else { 11 }, a.0.max(b.0), "#c00"));
    }
    println!("\nthe coefficients of `ours`, fitted anew");
    let loss = [(1, 3), (1, 7), (2, 6)];
    let loss = fit(&grid, Target::Loss, &loss, &[(0, 5), (1, 5), (1, 0), (2, 0), (3, 0), (2, 2)], 12, 200);
    let bias = [(2, 0), (1, 1), (0, 2), (0, 3), (0, 4)];
    let bias = fit(&grid, Target::Bias(5), &bias, &[(2, 0), (0, 3), (0, 4), (0, 5)], 12, 200);
    for (name, f) in [("1 − E", &loss), ("B / (1 − m)^5", &bias)] {
        if let Some(f) = f {
            println!("{name} = {}\n    worst {:.5}, RMS {:.5}", describe(f), f.worst, f.rms);
        }
    }
    if let Some(trials) = option("--search").and_then(|v| v.parse::<usize>().ok()) {
        let coarse = grid.coarse();
        println!("\nfrontier, {trials} exchanges for each form");
        let forms: Vec<(&str, Target, usize, usize)> = [(1, 3), (2, 3), (2, 4), (3, 4), (3, 5), (4, 5)]
            .iter()
            .flat_map(|&(p, q)| [("1 − E", Target::Loss, p, q), ("B", Target::Bias(5), p, q)])
            .collect();
        let found: Vec<_> = forms.par_iter().map(|&(_, t, p, q)| search(&coarse, t, p, q, trials)).collect();
        for ((name, target, p, q), f) in forms.iter().zip(found) {
            let refined = f.and_then(|f| fit(&grid, *target, &f.numerator, &f.denominator, 12, 200));
            if let Some(f) = refined {
                let ops = f.operations(target.cost());
                println!(
                    "{name} {p}/{q}: worst {:.5}, RMS {:.5}, {ops} operations: {}",
                    f.worst,
                    f.rms,
                    describe(&f)
                );
                let colour = if matches!(target, Target::Loss) { "#06c" } else { "#080" };
                points.push((format!("{name} {p}/{q}"), ops, f.worst, colour));
            }
        }
    }
    if let Some(file) = option("--svg") {
        std::fs::write(file, svg(&points))?;
        println!("{file}");
    }
    Ok(())
}
