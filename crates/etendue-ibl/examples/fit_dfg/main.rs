//! Fits formulas to the reflectance of height-correlated Smith GGX, and says how good others are for what they cost.
//!
//! `cargo run --release -p etendue-ibl --example fit_dfg [-- --plot FILE.svg] [-- --refit] [-- --search GENERATIONS --out FILE]`
//!
//! A formula is a straight-line program of operations that graphics processors have. Its cost is their number, a fused multiplication and addition being one;
//! a power of two, root or reciprocal is one operation too, but takes four issue slots, which is printed beside. A division is a reciprocal and a
//! multiplication. Negating, and clamping a result to 0..1, are free; clamping of the inputs is the caller's.
//!
//! Without options: errors of the formulas of `etendue_ibl::dfg_fit`, and the frontier of cost against error that is kept in `frontier.txt`. `--refit` fits the
//! frontier's coefficients anew. `--plot` draws both. `--search` makes the frontier: programs for the energy E and the bias B alone, then both together, first from
//! joined ones, are changed at random, fitted and kept by cost, so many generations of 256 each. Deterministic, and it goes on from `frontier.txt`.

mod fit;
mod grid;
mod plot;
mod program;
mod search;

use etendue_ibl::Dfg;
use etendue_ibl::dfg_fit::{self, karis, lazarov, ours, ours_cheap};
use fit::{Errors, Scratch};
use grid::{F0, Grid, N, What};
use program::Program;
use search::{Archive, Cost, Found};
use std::fmt::Write;

/// A formula for the reflectance by roughness and cosine, its name, operations and issue slots.
type Formula = (&'static str, fn(f32, f32) -> Dfg, [usize; 2]);

const FORMULAS: [Formula; 4] = [
    ("Lazarov", lazarov, dfg_fit::LAZAROV_COST),
    ("Karis", karis, dfg_fit::KARIS_COST),
    ("ours_cheap", ours_cheap, dfg_fit::OURS_CHEAP_COST),
    ("ours", ours, dfg_fit::OURS_COST),
];

/// What the search found, one program a line: what it gives, and the program.
const FRONTIER: &str = include_str!("frontier.txt");

/// What the search starts from where there is no frontier yet: a product with a power of two, a rational function.
const SEEDS: &str = "\
energy t0=mul(r,r) t1=mul(t0,m) t2=mul(m,m) t3=mul(t0,t0) t4=fma(t3,1.5,t2) t5=rcp(t4) t6=mul(t1,t5) t7=fma(t6,-0.2,1) -> t7 t7
energy t0=mul(r,r) t1=fma(m,0.5,0.2) t2=fnma(t0,t1,1) -> t2 t2
bias t0=fma(-7.2,m,-0.13) t1=mul(r,r) t2=fma(t1,-8.7,t0) t3=exp2(t2) -> t3 t3
bias t0=sub(1,m) t1=mul(t0,t0) t2=mul(t1,t1) t3=mul(t2,t0) t4=mul(r,r) t5=mul(t4,t4) t6=fma(t5,9,m) t7=rcp(t6) t8=mul(t7,m) t9=mul(t8,t3) -> t9 t9
both t0=fma(-7.2,m,-0.13) t1=mul(r,r) t2=fma(t1,-8.7,t0) t3=exp2(t2) t4=fma(m,0.5,0.2) t5=fnma(t1,t4,1) t6=sub(t5,t3) -> t6 t3
";

/// Worst and root mean square error of the albedo at each F0, over a grid.
fn errors(grid: &Grid, formula: fn(f32, f32) -> Dfg) -> Errors {
    let mut figures = [[0.0f64; 2]; 2];
    for i in 0..grid.r.len() {
        let d = formula(grid.r[i] as f32, grid.m[i] as f32);
        for (f, f0) in figures.iter_mut().zip(F0) {
            let e = f0 * (f64::from(d.scale) - grid.scale[i]) + f64::from(d.bias) - grid.bias[i];
            f[0] = f[0].max(e.abs());
            f[1] += grid.weight[i] * e * e;
        }
    }
    Errors(figures.map(|[w, s]| [w, s.sqrt()]))
}

fn figures(e: &Errors) -> String {
    let [a, b] = e.0;
    format!("{:>8.4} {:>8.4}    {:>8.4} {:>8.4}", a[0], a[1], b[0], b[1])
}

/// Programs of one kind in a list of them.
fn read(text: &str, what: What, grid: &Grid) -> Result<Vec<Found>, String> {
    let mut s = Scratch::default();
    let lines = text.lines().filter_map(|l| l.split_once(' ')).filter(|l| l.0 == what.name());
    lines
        .map(|(_, line)| {
            let program: Program = line.parse()?;
            let errors = fit::measure(&program, grid, &mut s).ok_or(format!("{line}: no number"))?;
            Ok(Found { program, errors })
        })
        .collect()
}

/// Searches; the frontier as `frontier.txt` has it.
fn search(grid: &Grid, generations: u64) -> Result<String, String> {
    let mut out = String::new();
    let mut parts: Vec<Vec<Found>> = Vec::new();
    for (stage, what) in [What::Energy, What::Bias, What::Both].into_iter().enumerate() {
        let grid = Grid { what, ..grid.clone() };
        let mut archives = [Archive::new(Cost::Operations), Archive::new(Cost::Slots)];
        let mut start = read(SEEDS, what, &grid)?;
        start.extend(read(FRONTIER, what, &grid)?);
        if let [energy, bias] = &parts[..] {
            start.extend(search::joined(energy, bias, &grid));
        }
        for f in &start {
            archives.iter_mut().for_each(|a| a.insert(f));
        }
        let first = stage as u64 * 1_000_000;
        search::search(&mut archives, &grid, first..first + generations, 256, |g, a| {
            if (g - first + 1).is_multiple_of(50) {
                let line: Vec<String> = a[0]
                    .frontier()
                    .iter()
                    .map(|f| format!("{}:{:.2}", f.program.operations(), f.errors.score()))
                    .collect();
                eprintln!("{} {}: {}", what.name(), g - first + 1, line.join(" "));
            }
        });
        let frontier: Vec<Found> = archives[0].frontier().into_iter().cloned().collect();
        for f in &frontier {
            let _ = writeln!(out, "{} {}", what.name(), f.program);
        }
        parts.push(frontier);
    }
    Ok(out)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let option = |name: &str| args.iter().position(|a| a == name).and_then(|i| args.get(i + 1));
    let (grid, fine) = (Grid::new(N), Grid::new(2 * N + 1));
    println!(
        "errors of the albedo           F0 = 0.04: worst, RMS  F0 = 1: worst, RMS    F0 = 1 over {}² cells: worst",
        2 * N + 1
    );
    let mut points = Vec::new();
    for (name, f, [operations, slots]) in FORMULAS {
        let e = errors(&grid, f);
        let [_, [worst, _]] = errors(&fine, f).0;
        println!("{name:<11} {operations:>3} ops {slots:>3} slots {}    {worst:.4}", figures(&e));
        points.push(plot::Point { label: Some(name), operations, score: e.score() });
    }
    if let Some(n) = option("--search").and_then(|n| n.parse().ok()) {
        let found = search(&grid, n)?;
        match option("--out") {
            Some(file) => std::fs::write(file, found)?,
            None => print!("{found}"),
        }
        return Ok(());
    }
    println!("\nthe frontier of the search, in operations and issue slots");
    for mut f in read(FRONTIER, What::Both, &grid)? {
        if args.iter().any(|a| a == "--refit") {
            let coarse = grid.coarse();
            fit::fit(&mut f.program, &coarse, 60, 200, f64::INFINITY, &mut Scratch::default());
            f.errors = fit::measure(&f.program, &grid, &mut Scratch::default()).unwrap_or(f.errors);
        }
        let (ops, slots) = (f.program.operations(), f.program.slots());
        println!("            {ops:>3} ops {slots:>3} slots {}    {}", figures(&f.errors), f.program);
        points.push(plot::Point { label: None, operations: ops, score: f.errors.score() });
    }
    if let Some(file) = option("--plot") {
        std::fs::write(file, plot::svg(&points))?;
        println!("{file}");
    }
    Ok(())
}
