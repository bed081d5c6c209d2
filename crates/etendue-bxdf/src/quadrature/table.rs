//! Integrals over rectangles of a hemisphere's coordinates, all in one pass.
//!
//! Along each ray of constant angle about the peak the integrand is cut at the rectangles' edges and at the curves where
//! it may have a step, and integrated adaptively; what a ray gives, as a vector over the rings, is integrated adaptively
//! over the angle. A step along an unknown curve (the horizon of a tilted coat) costs some twenty halvings on each ray
//! and leaves something smooth over the rays, where halving rectangles would need thousands.
//!
//! What a pair of rules does not see is a step within a fiftieth of an interval's end; over random places this leaves
//! 1.4e-5 of what the step encloses.
//!
//! Nothing here knows how a scattering function is sampled: it is only asked for its value.

use super::{
    HemisphereMap,
    adaptive::{self, Tolerance},
};
use core::f64::consts::{FRAC_PI_4, TAU};
use glam::Vec3A;

/// Sums over rings × sectors of the coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    /// `cells[ring * sectors + sector]`, each lane's integral.
    pub cells: Vec<[f64; N]>,
    /// How often the function was asked.
    pub calls: usize,
}

impl<const N: usize> Table<N> {
    /// The integral over the whole hemisphere.
    pub fn total(&self) -> [f64; N] {
        let mut sum = [0.0; N];
        for cell in &self.cells {
            for (s, v) in sum.iter_mut().zip(cell) {
                *s += v;
            }
        }
        sum
    }
}

/// Along a ray, errors of this part of an interval's integral are let through: what `f32` makes of a smooth function.
const ROUNDING: f64 = 2e-6;
/// Levels of halving of the angle at most.
const DEPTH: u32 = 18;
/// Levels that may bring nothing.
const STALLS: u32 = 2;

/// Integrals of `f(wi)` dωi over the rectangles between radial `edges` (rising, from 0 to ∞) and `sectors` equal angles.
///
/// `tolerance` is the error allowed in a rectangle's integral, as a function of that integral, in each lane. After
/// `budget` calls of `f` intervals are no more halved.
pub(super) fn table<const N: usize>(
    map: &HemisphereMap,
    edges: &[f64],
    sectors: usize,
    tolerance: impl Fn(f64) -> f64,
    budget: usize,
    f: impl Fn(Vec3A) -> [f32; N],
) -> Table<N> {
    let rings = edges.len().max(2) - 1;
    let sectors = sectors.max(1);
    // A tenth of what is allowed, by an interval of less than half a radian.
    let along = Tolerance { absolute: 0.2 * tolerance(0.0), relative: ROUNDING };
    let work = Work { map, edges, rings, along, tolerance, f };
    let mut out = Table { cells: vec![[0.0; N]; rings * sectors], calls: 0 };
    let mut breaks = map.psi_breaks();
    breaks.extend((0..=sectors).map(|i| i as f64 / sectors as f64 * TAU));
    breaks.extend((0..8).map(|i| i as f64 * FRAC_PI_4));
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    breaks.retain(|p| (0.0..=TAU).contains(p));
    let mut scratch = Scratch { breaks: Vec::new(), calls: 0, budget };
    let mut sum = vec![[0.0; N]; rings];
    for w in breaks.windows(2) {
        sum.fill([0.0; N]);
        let whole = work.panel(w[0], w[1], &mut scratch);
        work.refine(w[0], w[1], whole, DEPTH, STALLS, &mut scratch, &mut sum);
        let sector = ((0.5 * (w[0] + w[1]) / TAU * sectors as f64) as usize).min(sectors - 1);
        for (ring, s) in sum.iter().enumerate() {
            for (c, v) in out.cells[ring * sectors + sector].iter_mut().zip(s) {
                *c += v;
            }
        }
    }
    out.calls = scratch.calls;
    out
}

struct Work<'a, const N: usize, T, F> {
    map: &'a HemisphereMap,
    edges: &'a [f64],
    rings: usize,
    along: Tolerance,
    tolerance: T,
    f: F,
}

struct Scratch {
    breaks: Vec<f64>,
    calls: usize,
    budget: usize,
}

/// An interval of angles: the integral by ring, and by what factor it is not good enough.
struct Panel<const N: usize> {
    rings: Vec<[f64; N]>,
    error: f64,
}

impl<const N: usize, T: Fn(f64) -> f64, F: Fn(Vec3A) -> [f32; N]> Work<'_, N, T, F> {
    /// Integrals along one ray, by ring.
    fn along(&self, psi: f64, scratch: &mut Scratch, out: &mut [[f64; N]]) {
        let ray = self.map.ray(psi);
        let breaks = &mut scratch.breaks;
        breaks.clear();
        ray.breaks(breaks);
        let end = ray.end();
        breaks.extend(self.edges.iter().filter(|e| **e < end));
        breaks.push(end);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * end);
        let mut calls = 0;
        let mut at = |t: f64| {
            calls += 1;
            let (wi, weight) = ray.at(t);
            (self.f)(wi).map(|v| weight * v as f64)
        };
        let along = if scratch.calls < scratch.budget {
            self.along
        } else {
            Tolerance { absolute: f64::INFINITY, ..self.along }
        };
        for w in breaks.windows(2) {
            let ring = self.edges.partition_point(|&e| e <= 0.5 * (w[0] + w[1])).clamp(1, self.rings) - 1;
            let (a, b) = (ray.parameter(w[0]), ray.parameter(w[1]));
            let value = adaptive::integrate(&mut at, a.min(b), a.max(b), along);
            for (o, v) in out[ring].iter_mut().zip(value) {
                *o += v;
            }
        }
        scratch.calls += calls;
    }

    fn panel(&self, from: f64, to: f64, scratch: &mut Scratch) -> Panel<N> {
        let nodes = adaptive::nodes(from, to);
        let mut values = vec![[0.0; N]; 7 * self.rings];
        for ((psi, _, _), out) in nodes.iter().zip(values.chunks_mut(self.rings)) {
            self.along(*psi, scratch, out);
        }
        let mut out = Panel { rings: vec![[0.0; N]; self.rings], error: 0.0 };
        let (mut total, mut missing) = ([0.0; N], [0.0; N]);
        for ring in 0..self.rings {
            for lane in 0..N {
                let of = |i: usize| values[i * self.rings + ring][lane];
                let (mut kronrod, mut gauss) = (0.0, 0.0);
                for (i, (_, k, g)) in nodes.iter().enumerate() {
                    kronrod += k * of(i);
                    gauss += g * of(i);
                }
                let mean = kronrod / (to - from);
                let variation: f64 = (0..7).map(|i| nodes[i].1 * (of(i) - mean).abs()).sum();
                let error = adaptive::error(kronrod - gauss, variation);
                out.rings[ring][lane] = kronrod;
                out.error = out.error.max(error / (self.tolerance)(kronrod));
                total[lane] += kronrod;
                // What leaves one ring enters the next: as a part of all, errors are counted with their sign.
                missing[lane] += error.copysign(kronrod - gauss);
            }
        }
        for lane in 0..N {
            // The whole is what rejected samples are set against, often a bin of nothing.
            out.error =
                out.error.max(missing[lane].abs() / (self.tolerance)(0.0).max(ROUNDING * total[lane]));
        }
        out
    }

    fn refine(
        &self,
        from: f64,
        to: f64,
        whole: Panel<N>,
        depth: u32,
        patience: u32,
        scratch: &mut Scratch,
        sum: &mut [[f64; N]],
    ) {
        if !(whole.error > 1.0) || depth == 0 || patience == 0 || scratch.calls > scratch.budget {
            for (s, v) in sum.iter_mut().flatten().zip(whole.rings.iter().flatten()) {
                *s += v;
            }
            return;
        }
        let middle = 0.5 * (from + to);
        let left = self.panel(from, middle, scratch);
        let right = self.panel(middle, to, scratch);
        let patience =
            if adaptive::stalls(whole.error, [left.error, right.error]) { patience - 1 } else { STALLS };
        self.refine(from, middle, left, depth - 1, patience, scratch, sum);
        self.refine(middle, to, right, depth - 1, patience, scratch, sum);
    }
}
