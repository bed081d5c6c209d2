//! Spherical harmonics at the points of a grid: diffuse light that changes from place to place.

use crate::sh::Sh9;
use glam::Vec3;

/// A regular grid of light probes along the world's axes.
///
/// ```
/// use etendue_ibl::{Sh9, probe_grid::ProbeGrid};
/// use etendue_color::Spectrum;
/// use glam::Vec3;
///
/// let grid = ProbeGrid::bake(Vec3::ZERO, Vec3::ONE, [2, 2, 2], |p| {
///     let mut c = [Spectrum::ZERO; 9];
///     c[0] = Spectrum::splat(p.x);
///     c
/// })
/// .unwrap();
/// assert_eq!(grid.trilinear(Vec3::splat(0.25)).0[0][0], 0.25);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeGrid {
    min: Vec3,
    max: Vec3,
    step: Vec3,
    counts: [u32; 3],
    probes: Vec<Sh9>,
    /// Probes that lookups leave out; empty if there are none.
    hidden: Vec<bool>,
}

impl ProbeGrid {
    /// Most probes of a grid: 144 bytes each.
    pub const MOST: u64 = 1 << 26;

    /// Asks `at` for the harmonics of radiance at each point, x fastest, then y, then z.
    ///
    /// `min` and `max` are the first and the last point; an axis with one point lies at `min`. `None` if a count is 0, the corners are not finite or
    /// not in order, or there are more than [`ProbeGrid::MOST`] points.
    pub fn bake<C: Into<Sh9>>(
        min: Vec3,
        max: Vec3,
        counts: [u32; 3],
        mut at: impl FnMut(Vec3) -> C,
    ) -> Option<Self> {
        let mut grid = Self::places(min, max, counts)?;
        let probes = (0..grid.len()).map(|i| at(grid.position(grid.index(i))).into()).collect();
        grid.probes = probes;
        Some(grid)
    }

    /// A grid of probes that are there already, x fastest, then y, then z; `hidden` says for each whether lookups leave it out (it stands inside of
    /// something), and may be empty. `None` as in [`ProbeGrid::bake`], or if the lengths do not fit.
    pub fn from_probes(
        min: Vec3,
        max: Vec3,
        counts: [u32; 3],
        probes: Vec<Sh9>,
        hidden: Vec<bool>,
    ) -> Option<Self> {
        let grid = Self::places(min, max, counts)?;
        let fits = probes.len() == grid.len() && (hidden.is_empty() || hidden.len() == grid.len());
        fits.then_some(Self { probes, hidden, ..grid })
    }

    /// Places without probes.
    fn places(min: Vec3, max: Vec3, counts: [u32; 3]) -> Option<Self> {
        let total: u64 = counts.iter().try_fold(1u64, |n, c| n.checked_mul(u64::from(*c)))?;
        if total == 0 || total > Self::MOST || !min.is_finite() || !max.is_finite() || !min.cmple(max).all() {
            return None;
        }
        let spans = Vec3::from(counts.map(|c| (c - 1).max(1) as f32));
        let step = (max - min) / spans;
        step.is_finite().then_some(Self { min, max, step, counts, probes: Vec::new(), hidden: Vec::new() })
    }

    fn index(&self, i: usize) -> [u32; 3] {
        let [nx, ny, _] = self.counts.map(|c| c as usize);
        [i % nx, i / nx % ny, i / (nx * ny)].map(|k| k as u32)
    }

    /// Number of points, at least 1.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.counts.iter().map(|c| *c as usize).product()
    }

    /// The probes in order, x fastest, then y, then z.
    pub fn probes(&self) -> &[Sh9] {
        &self.probes
    }

    /// True if lookups leave the probe at a point out; indices beyond the last are the last.
    pub fn is_hidden(&self, index: [u32; 3]) -> bool {
        self.hidden.get(self.at(index)).copied().unwrap_or(false)
    }

    /// The first and the last point, as they were given.
    pub fn corners(&self) -> [Vec3; 2] {
        [self.min, self.max]
    }

    fn at(&self, index: [u32; 3]) -> usize {
        let [x, y, z]: [u32; 3] = std::array::from_fn(|k| index[k].min(self.counts[k] - 1));
        ((z as usize * self.counts[1] as usize) + y as usize) * self.counts[0] as usize + x as usize
    }

    /// Points along x, y, z.
    pub fn counts(&self) -> [u32; 3] {
        self.counts
    }

    /// The place of a point.
    pub fn position(&self, index: [u32; 3]) -> Vec3 {
        self.min + self.step * Vec3::from(index.map(|i| i as f32))
    }

    /// The probe at a point; indices beyond the last are the last.
    pub fn probe(&self, index: [u32; 3]) -> &Sh9 {
        &self.probes[self.at(index)]
    }

    /// The mixture of some probes: hidden ones are left out and the others' weights raised to make up for them, unless all are hidden.
    fn mix(&self, parts: &[([u32; 3], f32)]) -> Sh9 {
        let seen: f32 = parts.iter().filter(|p| !self.is_hidden(p.0)).map(|p| p.1).sum();
        let mut out = Sh9::ZERO;
        for (index, weight) in parts {
            if seen > 0.0 && self.is_hidden(*index) || *weight == 0.0 {
                continue;
            }
            let weight = if seen > 0.0 && !self.hidden.is_empty() { weight / seen } else { *weight };
            add(&mut out, self.probe(*index), weight);
        }
        out
    }

    /// The lower corner of the cell that holds `p`, and the place in it, 0..1; places outside, and NaN, are brought to the nearest.
    fn cell(&self, p: Vec3) -> ([u32; 3], [f32; 3]) {
        let mut index = [0; 3];
        let mut fraction = [0.0; 3];
        for k in 0..3 {
            let last = (self.counts[k] - 1) as f32;
            let step = self.step[k];
            let x = if step > 0.0 { ((p[k] - self.min[k]) / step).max(0.0).min(last) } else { 0.0 };
            index[k] = (x as u32).min(self.counts[k].saturating_sub(2));
            fraction[k] = x - index[k] as f32;
        }
        (index, fraction)
    }

    /// The mixture of the eight probes about `p`, by trilinear weights. Hidden ones do not count.
    pub fn trilinear(&self, p: Vec3) -> Sh9 {
        let (i, f) = self.cell(p);
        let parts: [_; 8] = std::array::from_fn(|corner| {
            let bit = |k: usize| (corner >> k & 1) as u32;
            let weight: f32 = (0..3).map(|k| if bit(k) == 1 { f[k] } else { 1.0 - f[k] }).product();
            (std::array::from_fn(|k| i[k] + bit(k)), weight)
        });
        self.mix(&parts)
    }

    /// The mixture of the four probes of the tetrahedron that holds `p`: half the reads of the trilinear one, continuous too. Hidden ones do not
    /// count.
    ///
    /// A cell is cut into six tetrahedra that share its diagonal (Kuhn 1960); which one holds `p` is the order of its coordinates, and
    /// the weights are their differences.
    pub fn tetrahedral(&self, p: Vec3) -> Sh9 {
        let (i, f) = self.cell(p);
        let mut order = [0usize, 1, 2];
        order.sort_by(|a, b| f[*b].total_cmp(&f[*a]));
        let mut corner = i;
        let mut parts = [(corner, 1.0 - f[order[0]]); 4];
        for k in 0..3 {
            corner[order[k]] += 1;
            let below = if k < 2 { f[order[k + 1]] } else { 0.0 };
            parts[k + 1] = (corner, f[order[k]] - below);
        }
        self.mix(&parts)
    }
}

impl From<[etendue_color::Spectrum; 9]> for Sh9 {
    fn from(c: [etendue_color::Spectrum; 9]) -> Self {
        Self(c)
    }
}

fn add(sum: &mut Sh9, sh: &Sh9, weight: f32) {
    for (s, c) in sum.0.iter_mut().zip(&sh.0) {
        *s += *c * weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;
    use etendue_color::Spectrum;

    fn coefficients(f: f32) -> [Spectrum; 9] {
        std::array::from_fn(|i| Spectrum::splat(f * (i as f32 - 4.0)))
    }

    /// Light that grows linearly is kept by both lookups; both are continuous and give the probes at their points.
    #[test]
    fn linear_light_is_kept() {
        let light = |p: Vec3| 1.0 + 2.0 * p.x - 0.5 * p.y + p.z;
        let (min, max) = (Vec3::new(-1.0, 0.0, 2.0), Vec3::new(3.0, 1.0, 2.5));
        let grid = ProbeGrid::bake(min, max, [5, 2, 3], |p| coefficients(light(p))).unwrap();
        let mut rng = Rng::new(1);
        for _ in 0..500 {
            let p = min + (max - min) * Vec3::new(rng.uniform(), rng.uniform(), rng.uniform());
            for sh in [grid.trilinear(p), grid.tetrahedral(p)] {
                assert!((sh.0[8][0] - 4.0 * light(p)).abs() < 1e-4, "{p}");
            }
        }
        // Outside: the nearest place inside.
        let far = grid.tetrahedral(Vec3::new(99.0, -7.0, 2.0)).0[8][0];
        assert!((far - 4.0 * light(Vec3::new(3.0, 0.0, 2.0))).abs() < 1e-4);
    }

    #[test]
    fn lookups_are_continuous_and_meet_the_probes() {
        let mut rng = Rng::new(6);
        let grid =
            ProbeGrid::bake(Vec3::ZERO, Vec3::splat(3.0), [4; 3], |_| coefficients(rng.uniform())).unwrap();
        for i in 0..64 {
            let index = [i % 4, i / 4 % 4, i / 16];
            let p = grid.position(index);
            for sh in [grid.trilinear(p), grid.tetrahedral(p)] {
                assert!((sh.0[0][0] - grid.probe(index).0[0][0]).abs() < 1e-5);
            }
        }
        let mut rng = Rng::new(7);
        for _ in 0..500 {
            // Across the planes where one tetrahedron or cell gives way to the next.
            let (a, b) = (3.0 * rng.uniform(), 3.0 * rng.uniform());
            let e = 1e-4;
            for (p, q) in [
                (Vec3::new(a, a + e, b), Vec3::new(a, a - e, b)),
                (Vec3::new(1.0 - e, a, b), Vec3::new(1.0 + e, a, b)),
            ] {
                let d = grid.tetrahedral(p).0[0][0] - grid.tetrahedral(q).0[0][0];
                assert!(d.abs() < 5e-3, "{p} {q}: {d}");
            }
        }
    }

    /// Between a hidden probe and a seen one only the seen one counts; where all are hidden, they are mixed as ever.
    #[test]
    fn hidden_probes_do_not_count() {
        let probes: Vec<Sh9> = [9.0, 1.0, 2.0].map(|v| coefficients(v).into()).to_vec();
        let end = Vec3::new(2.0, 0.0, 0.0);
        let grid =
            |hidden: Vec<bool>| ProbeGrid::from_probes(Vec3::ZERO, end, [3, 1, 1], probes.clone(), hidden);
        let g = grid(vec![true, false, false]).unwrap();
        for (x, want) in [(0.0, 9.0), (0.25, 1.0), (0.9, 1.0), (1.5, 1.5)] {
            for sh in [g.trilinear(Vec3::X * x), g.tetrahedral(Vec3::X * x)] {
                assert!((sh.0[8][0] - 4.0 * want).abs() < 1e-5, "{x}: {}", sh.0[8][0] / 4.0);
            }
        }
        assert!(g.is_hidden([0, 0, 0]) && !g.is_hidden([1, 0, 0]));
        let dark = grid(vec![true; 3]).unwrap();
        assert!((dark.trilinear(Vec3::X * 0.5).0[8][0] - 20.0).abs() < 1e-5);
        assert!(grid(vec![true]).is_none());
    }

    #[test]
    fn bad_grids_are_none_and_thin_ones_work() {
        let bake = |min: Vec3, max: Vec3, counts| ProbeGrid::bake(min, max, counts, |_| coefficients(1.0));
        assert!(bake(Vec3::ZERO, Vec3::ONE, [0, 1, 1]).is_none());
        assert!(bake(Vec3::ONE, Vec3::ZERO, [2; 3]).is_none());
        assert!(bake(Vec3::ZERO, Vec3::NAN, [2; 3]).is_none());
        assert!(bake(Vec3::ZERO, Vec3::ONE, [u32::MAX; 3]).is_none());
        let thin = bake(Vec3::ZERO, Vec3::ZERO, [1, 1, 1]).unwrap();
        for p in [Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::INFINITY)] {
            assert_eq!(thin.trilinear(p), thin.tetrahedral(p));
            assert_eq!(thin.trilinear(p).0[8][0], 4.0);
        }
    }
}
