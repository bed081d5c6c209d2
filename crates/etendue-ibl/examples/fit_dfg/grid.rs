//! What is fitted: the reflectance of height-correlated Smith GGX.

use etendue_ibl::Dfg;
use rayon::prelude::*;

/// Cells of the grid along an edge; values belong to their middles, as in a table.
pub const N: usize = 64;
/// What is asked for: worst error and root of the mean square.
pub const TARGET: [f64; 2] = [0.01, 0.003];
/// The F0 at which the albedo is compared.
pub const F0: [f64; 2] = [0.04, 1.0];

/// What a program is to give.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum What {
    /// Scale and bias.
    #[default]
    Both,
    /// Their sum, as the first output.
    Energy,
    /// The bias, as the first output.
    Bias,
}

impl What {
    /// The word for it in lists of programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::Energy => "energy",
            Self::Bias => "bias",
        }
    }
}

/// Points, what is there, and each point's share of the mean.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    pub r: Vec<f64>,
    pub m: Vec<f64>,
    pub scale: Vec<f64>,
    pub bias: Vec<f64>,
    pub weight: Vec<f64>,
    pub what: What,
}

impl Grid {
    /// The middles of `n`² cells.
    pub fn new(n: usize) -> Self {
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        let cells: Vec<Dfg> = (0..n * n).into_par_iter().map(|i| Dfg::exact(at(i / n), at(i % n))).collect();
        let mut grid = Self::default();
        for (i, d) in cells.iter().enumerate() {
            grid.push([at(i / n), at(i % n), d.scale, d.bias].map(f64::from), 1.0 / (n * n) as f64);
        }
        grid
    }

    fn push(&mut self, [r, m, scale, bias]: [f64; 4], weight: f64) {
        self.r.push(r);
        self.m.push(m);
        self.scale.push(scale);
        self.bias.push(bias);
        self.weight.push(weight);
    }

    /// Some rows and columns of a grid of [`N`]², dense where the reflectance is steep, each standing for those around it.
    pub fn coarse(&self) -> Self {
        const LINES: [usize; 20] = [0, 1, 2, 3, 4, 5, 7, 9, 12, 15, 19, 24, 29, 35, 41, 47, 52, 57, 61, 63];
        let share = |k: usize| {
            let at = |k: usize| LINES[k] as f64;
            let low = if k == 0 { -0.5 } else { 0.5 * (at(k - 1) + at(k)) };
            let high = if k + 1 == LINES.len() { N as f64 - 0.5 } else { 0.5 * (at(k) + at(k + 1)) };
            (high - low) / N as f64
        };
        let mut grid = Self { what: self.what, ..Self::default() };
        for (j, y) in LINES.iter().enumerate() {
            for (i, x) in LINES.iter().enumerate() {
                let at = y * N + x;
                grid.push([self.r[at], self.m[at], self.scale[at], self.bias[at]], share(i) * share(j));
            }
        }
        grid
    }
}
