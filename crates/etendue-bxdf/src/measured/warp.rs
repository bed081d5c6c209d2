//! Densities over the unit square that are given at the nodes of a grid and depend on two parameters.
//!
//! Between nodes a density is bilinear, between the parameters' places linear; each place's density is normalised by itself.
//! A sample takes the second coordinate from the marginal and then the first from the row that lies there, both exactly, by
//! the piecewise quadratic distribution functions, which mix linearly as the densities do.

/// The four places around a pair of parameters, as indices of slices, with their weights.
pub(super) type Corners = [(usize, f32); 4];

/// Places of the parameters; slices are numbered with the second parameter fastest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Places {
    pub first: Vec<f32>,
    pub second: Vec<f32>,
}

impl Places {
    /// The places around a pair; parameters beyond the ends are held there.
    pub fn around(&self, first: f32, second: f32) -> Corners {
        let (i, s) = interval(&self.first, first);
        let (j, t) = interval(&self.second, second);
        let n = self.second.len();
        let (i1, j1) = ((i + 1).min(self.first.len() - 1), (j + 1).min(n - 1));
        [
            (i * n + j, (1.0 - s) * (1.0 - t)),
            (i * n + j1, (1.0 - s) * t),
            (i1 * n + j, s * (1.0 - t)),
            (i1 * n + j1, s * t),
        ]
    }
}

/// The interval of an increasing, not empty list in which `x` lies, and how far along it, 0..1; NaN lies at the start.
pub(super) fn interval(places: &[f32], x: f32) -> (usize, f32) {
    if places.len() < 2 {
        return (0, 0.0);
    }
    let i = places.partition_point(|&p| p <= x).clamp(1, places.len() - 1) - 1;
    let t = (x - places[i]) / (places[i + 1] - places[i]);
    (i, t.max(0.0).min(1.0))
}

/// The cell of `n` ≥ 2 even nodes over 0..1 in which `x` lies, and how far along it.
#[inline(always)]
pub(super) fn cell(n: usize, x: f32) -> (usize, f32) {
    let at = x.max(0.0).min(1.0) * (n - 1) as f32;
    let i = (at as usize).min(n - 2);
    (i, at - i as f32)
}

/// Bilinear interpolation in a grid of `width` × n nodes that `node` reads by index.
#[inline(always)]
pub(super) fn bilinear(width: usize, height: usize, at: [f32; 2], node: impl Fn(usize) -> f32) -> f32 {
    let ((i, s), (j, t)) = (cell(width, at[0]), cell(height, at[1]));
    let k = j * width + i;
    let low = node(k) * (1.0 - s) + node(k + 1) * s;
    let high = node(k + width) * (1.0 - s) + node(k + width + 1) * s;
    low * (1.0 - t) + high * t
}

/// Densities over the square, one per slice, with their distribution functions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Warp {
    width: usize,
    height: usize,
    /// Densities, row by row.
    density: Vec<f32>,
    /// Per row the integral from 0 to each node; the last is the row's own.
    rows: Vec<f32>,
    /// Per slice the integral of the rows from 0 to each row.
    marginal: Vec<f32>,
}

impl Warp {
    /// From values ≥ 0 (less counts as 0), `width` and `height` ≥ 2; `values` holds whole slices. A slice of zeros becomes even.
    pub fn new(width: usize, height: usize, values: &[f32]) -> Self {
        let area = width * height;
        let mut out = Self { width, height, density: Vec::new(), rows: Vec::new(), marginal: Vec::new() };
        let (dx, dy) = (1.0 / (width - 1) as f64, 1.0 / (height - 1) as f64);
        for slice in values.chunks_exact(area) {
            let mut values: Vec<f64> = slice.iter().map(|&v| v.max(0.0) as f64).collect();
            let row_of = |row: &[f64]| row.windows(2).map(|w| 0.5 * (w[0] + w[1]) * dx).sum::<f64>();
            let totals: Vec<f64> = values.chunks_exact(width).map(row_of).collect();
            let total: f64 = totals.windows(2).map(|w| 0.5 * (w[0] + w[1]) * dy).sum();
            if total > 0.0 && total.is_finite() {
                values.iter_mut().for_each(|v| *v /= total);
            } else {
                values.iter_mut().for_each(|v| *v = 1.0);
            }
            let (mut marginal, mut last) = (0.0, None);
            for row in values.chunks_exact(width) {
                let mut sum = 0.0;
                out.rows.push(0.0);
                for w in row.windows(2) {
                    sum += 0.5 * (w[0] + w[1]) * dx;
                    out.rows.push(sum as f32);
                }
                if let Some(last) = last {
                    marginal += 0.5 * (last + sum) * dy;
                }
                last = Some(sum);
                out.marginal.push(marginal as f32);
            }
            out.density.extend(values.iter().map(|&v| v as f32));
        }
        out
    }

    #[inline(always)]
    fn mix(table: &[f32], stride: usize, corners: &Corners, index: usize) -> f32 {
        corners.iter().map(|&(slice, w)| table[slice * stride + index] * w).sum()
    }

    #[inline(always)]
    fn node(&self, corners: &Corners, index: usize) -> f32 {
        Self::mix(&self.density, self.width * self.height, corners, index)
    }

    #[inline(always)]
    fn row(&self, corners: &Corners, row: usize, node: usize) -> f32 {
        Self::mix(&self.rows, self.width * self.height, corners, row * self.width + node)
    }

    #[inline(always)]
    fn marginal(&self, corners: &Corners, row: usize) -> f32 {
        Self::mix(&self.marginal, self.height, corners, row)
    }

    /// The density at a point.
    pub fn density(&self, corners: &Corners, at: [f32; 2]) -> f32 {
        bilinear(self.width, self.height, at, |k| self.node(corners, k))
    }

    /// A point with that density.
    pub fn sample(&self, corners: &Corners, u: [f32; 2]) -> [f32; 2] {
        let u = u.map(|u| u.max(0.0).min(1.0));
        let last = self.width - 1;
        let j = search(self.height, |j| self.marginal(corners, j) <= u[1]);
        let left = (u[1] - self.marginal(corners, j)) * (self.height - 1) as f32;
        let t = solve(self.row(corners, j, last), self.row(corners, j + 1, last), left);
        let along = |i: usize| self.row(corners, j, i) * (1.0 - t) + self.row(corners, j + 1, i) * t;
        let target = u[0] * along(last);
        let i = search(self.width, |i| along(i) <= target);
        let value = |i: usize| {
            self.node(corners, j * self.width + i) * (1.0 - t)
                + self.node(corners, (j + 1) * self.width + i) * t
        };
        let s = solve(value(i), value(i + 1), (target - along(i)) * last as f32);
        [(i as f32 + s) / last as f32, (j as f32 + t) / (self.height - 1) as f32]
    }

    /// The `u` from which [`Warp::sample`] makes this point.
    pub fn invert(&self, corners: &Corners, at: [f32; 2]) -> [f32; 2] {
        let last = self.width - 1;
        let ((i, s), (j, t)) = (cell(self.width, at[0]), cell(self.height, at[1]));
        let (r0, r1) = (self.row(corners, j, last), self.row(corners, j + 1, last));
        let v = self.marginal(corners, j) + t * (r0 + 0.5 * t * (r1 - r0)) / (self.height - 1) as f32;
        let along = |i: usize| self.row(corners, j, i) * (1.0 - t) + self.row(corners, j + 1, i) * t;
        let value = |i: usize| {
            self.node(corners, j * self.width + i) * (1.0 - t)
                + self.node(corners, (j + 1) * self.width + i) * t
        };
        let (v0, v1) = (value(i), value(i + 1));
        let part = along(i) + s * (v0 + 0.5 * s * (v1 - v0)) / last as f32;
        let all = along(last);
        // A row without any density is never drawn from.
        let u = if all > 0.0 { part / all } else { at[0] };
        [u.max(0.0).min(1.0), v.max(0.0).min(1.0)]
    }
}

/// The largest i in 0..=n − 2 for which `below(i)` still holds, by bisection; 0 if none does.
fn search(n: usize, below: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, n - 1);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if below(middle) { low = middle } else { high = middle }
    }
    low
}

/// t in 0..1 with ∫₀ᵗ a + (b − a) x dx = `area`, for a, b ≥ 0: the root of the quadratic that does not cancel.
fn solve(a: f32, b: f32, area: f32) -> f32 {
    let divisor = a + (a * a + 2.0 * (b - a) * area).max(0.0).sqrt();
    // Also taken by NaN.
    if divisor > 0.0 { (2.0 * area / divisor).max(0.0).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::{Rng, gamma::chi2_p_value};

    /// Two places along each parameter, with bumps, an empty row, an empty slice and zeros at the edges.
    fn warp() -> (Places, Warp) {
        let places = Places { first: vec![-1.0, 2.0], second: vec![0.0, 1.0] };
        let (width, height) = (7, 5);
        let mut values = Vec::new();
        for slice in 0..4 {
            for j in 0..height {
                for i in 0..width {
                    let bump = (i as f32 * 1.7 + slice as f32).sin().powi(2)
                        * (j as f32 + 0.3 * slice as f32).cos().powi(2);
                    values.push(if slice == 3 || j == 2 || i == 0 { 0.0 } else { bump * 9.0 });
                }
            }
        }
        (places, Warp::new(width, height, &values))
    }

    #[test]
    fn sampling_is_undone_by_inversion_and_follows_the_density() {
        let (places, warp) = warp();
        for (case, at) in
            [[-1.0, 0.0], [0.5, 0.3], [2.0, 1.0], [-9.0, 0.99], [f32::NAN, 0.5]].into_iter().enumerate()
        {
            let corners = places.around(at[0], at[1]);
            assert!((corners.iter().map(|c| c.1).sum::<f32>() - 1.0).abs() < 1e-6);
            const SIDE: usize = 12;
            let n = 100_000;
            let (mut observed, mut expected) = ([0.0f64; SIDE * SIDE], [0.0f64; SIDE * SIDE]);
            let mut rng = Rng::new(case as u64);
            for _ in 0..n {
                let u = rng.square();
                let x = warp.sample(&corners, u);
                let back = warp.invert(&corners, x);
                // Where the density is small a step of u moves far, and the way back has few digits.
                let tolerance = 3e-5;
                assert!((back[1] - u[1]).abs() < tolerance, "{case} {u:?} {x:?} {back:?}");
                assert!((back[0] - u[0]).abs() < 2e-3, "{case} {u:?} {x:?} {back:?}");
                let [i, j] = x.map(|x| ((x * SIDE as f32) as usize).min(SIDE - 1));
                observed[j * SIDE + i] += 1.0;
            }
            // Midpoints finer than the nodes, which fall on their edges: 12 · 10 cells over 6 and 4.
            const FINE: usize = SIDE * 10;
            for k in 0..FINE * FINE {
                let x = [(k % FINE) as f32 + 0.5, (k / FINE) as f32 + 0.5].map(|v| v / FINE as f32);
                let bin = k / FINE / 10 * SIDE + k % FINE / 10;
                expected[bin] += n as f64 * warp.density(&corners, x) as f64 / (FINE * FINE) as f64;
            }
            let total: f64 = expected.iter().sum();
            assert!((total / n as f64 - 1.0).abs() < 1e-4, "the density integrates to {}", total / n as f64);
            let (mut statistic, mut dof) = (0.0, 0usize);
            for (o, e) in observed.iter().zip(expected) {
                if e > 5.0 {
                    statistic += (o - e).powi(2) / e;
                    dof += 1;
                }
            }
            let p = chi2_p_value(statistic, dof - 1);
            assert!(p > 0.002, "{case}: χ² {statistic} of {dof}");
        }
    }
}
