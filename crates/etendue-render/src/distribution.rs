//! Piecewise-constant densities over an interval and over a square, sampled by inversion.
//!
//! Inversion keeps the stratification of the random numbers (an alias table would not). A guide table (Chen and Asau
//! 1974) leaves little of the interval's search to be done.

/// A density over [0, 1) that is constant on each of n equal intervals.
#[derive(Clone, Debug)]
pub struct Distribution1 {
    /// `cdf[i]` is the probability below interval i; n + 1 entries, the last is 1.
    cdf: Vec<f32>,
    /// `guide[j]` is the interval that holds the quantile j / n.
    guide: Vec<u32>,
    total: f64,
}

impl Distribution1 {
    /// From non-negative finite weights. All zero gives a distribution that is never sampled (`total` is 0).
    pub fn new(weights: impl ExactSizeIterator<Item = f32> + Clone) -> Self {
        let n = weights.len();
        let total: f64 = weights.clone().map(f64::from).sum();
        let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
        let mut cdf = Vec::with_capacity(n + 1);
        let mut sum = 0.0;
        cdf.push(0.0);
        for w in weights {
            sum += f64::from(w);
            cdf.push((sum * scale) as f32);
        }
        // Rounding must not leave a gap that no interval covers: everything after the last weight is 1.
        let top = cdf[n];
        for c in cdf.iter_mut().rev().take_while(|c| **c == top) {
            *c = 1.0;
        }
        let mut guide = Vec::with_capacity(n);
        let mut k = 0;
        for j in 0..n {
            let q = j as f32 / n as f32;
            while k + 1 < n && cdf[k + 1] <= q {
                k += 1;
            }
            guide.push(k as u32);
        }
        Self { cdf, guide, total }
    }

    /// Sum of the weights it was made of.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Number of intervals.
    pub fn len(&self) -> usize {
        self.guide.len()
    }

    /// True if there are no intervals.
    pub fn is_empty(&self) -> bool {
        self.guide.is_empty()
    }

    /// Probability of interval `i`.
    #[inline(always)]
    pub fn probability(&self, i: usize) -> f32 {
        self.cdf[i + 1] - self.cdf[i]
    }

    /// The interval that `u` in [0, 1) falls into, and `u` stretched to [0, 1) within it.
    #[inline(always)]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let n = self.guide.len();
        let j = ((u * n as f32) as usize).min(n - 1);
        let first = self.guide[j] as usize;
        let last = self.guide.get(j + 1).map_or(n - 1, |k| *k as usize);
        // Mostly there is nothing left to search; where little probability lies on many intervals there may be much.
        let i = first + self.cdf[first + 1..=last].partition_point(|c| *c <= u);
        let (lo, hi) = (self.cdf[i], self.cdf[i + 1]);
        (i, if hi > lo { ((u - lo) / (hi - lo)).clamp(0.0, ONE_MINUS_EPSILON) } else { 0.5 })
    }
}

/// The largest float below 1.
pub(crate) const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// A density over the unit square, constant on each cell of a grid.
#[derive(Clone, Debug)]
pub struct Distribution2 {
    rows: Vec<Distribution1>,
    marginal: Distribution1,
    width: usize,
}

impl Distribution2 {
    /// From `width × height` non-negative finite weights, top row first.
    pub fn new(weights: &[f32], width: usize) -> Self {
        let rows: Vec<_> = weights.chunks(width).map(|r| Distribution1::new(r.iter().copied())).collect();
        let totals: Vec<f32> = rows.iter().map(|r| r.total() as f32).collect();
        let marginal = Distribution1::new(totals.iter().copied());
        Self { rows, marginal, width }
    }

    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.marginal.total()
    }

    /// A point of the unit square and the density there.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let (y, fy) = self.marginal.sample(u[1]);
        let (x, fx) = self.rows[y].sample(u[0]);
        let (w, h) = (self.width as f32, self.rows.len() as f32);
        ([(x as f32 + fx) / w, (y as f32 + fy) / h], self.density(x, y))
    }

    /// The density in cell (`x`, `y`).
    #[inline(always)]
    pub fn density(&self, x: usize, y: usize) -> f32 {
        self.rows[y].probability(x) * self.marginal.probability(y) * (self.width * self.rows.len()) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverts_its_cdf() {
        let w = [0.0, 3.0, 0.0, 1.0, 0.0];
        let d = Distribution1::new(w.iter().copied());
        assert_eq!(d.sample(0.0).0, 1);
        assert_eq!(d.sample(0.7499).0, 1);
        assert_eq!(d.sample(0.75).0, 3);
        assert_eq!(d.sample(ONE_MINUS_EPSILON).0, 3);
        let (i, f) = d.sample(0.375);
        assert!(i == 1 && (f - 0.5).abs() < 1e-6);
        assert_eq!((d.probability(1), d.probability(3), d.probability(4)), (0.75, 0.25, 0.0));
    }

    #[test]
    fn square_density_is_weight_over_mean() {
        let d = Distribution2::new(&[1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 6.0, 6.0, 6.0], 3);
        let mut counts = [0.0f32; 9];
        for i in 0..30 {
            for j in 0..30 {
                let (p, pdf) = d.sample([(i as f32 + 0.5) / 30.0, (j as f32 + 0.5) / 30.0]);
                let (x, y) = ((p[0] * 3.0) as usize, (p[1] * 3.0) as usize);
                assert!((pdf - d.density(x, y)).abs() < 1e-6 && pdf > 0.0);
                counts[y * 3 + x] += 1.0 / 900.0;
            }
        }
        for (c, w) in counts.iter().zip([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 6.0, 6.0, 6.0]) {
            assert!((c - w / 24.0).abs() < 0.02, "{counts:?}");
        }
        assert_eq!(d.density(2, 1), 0.0);
        assert!((d.density(2, 0) - 3.0 / 24.0 * 9.0).abs() < 1e-5);
    }
}
