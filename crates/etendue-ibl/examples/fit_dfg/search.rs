//! The search for formulas: a population of programs for each cost, changed at random, fitted, and kept if better than what is there.

use crate::fit::{Errors, Scratch, fit, measure};
use crate::grid::{Grid, What};
use crate::program::{Arg, Node, OPS, Op, Program};
use rayon::prelude::*;

/// A fitted program.
#[derive(Clone, Debug)]
pub struct Found {
    pub program: Program,
    pub errors: Errors,
}

/// How programs are put into shelves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// By operations.
    Operations,
    /// By issue slots.
    Slots,
}

impl Cost {
    pub fn of(self, p: &Program) -> usize {
        match self {
            Self::Operations => p.operations(),
            Self::Slots => p.slots(),
        }
    }
}

/// Most that a program may cost.
pub const MOST: usize = 45;
/// Programs that are kept for each cost.
const KEPT: usize = 16;

/// The best programs by cost.
pub struct Archive {
    pub cost: Cost,
    pub shelves: Vec<Vec<Found>>,
}

impl Archive {
    pub fn new(cost: Cost) -> Self {
        Self { cost, shelves: vec![Vec::new(); MOST + 1] }
    }

    /// The score below which a program of this cost is worth a place.
    fn bar(&self, cost: usize) -> f64 {
        match self.shelves.get(cost) {
            Some(s) if s.len() >= KEPT => s[KEPT - 1].errors.score(),
            Some(_) => 50.0,
            None => 0.0,
        }
    }

    pub fn insert(&mut self, found: &Found) {
        let cost = self.cost.of(&found.program);
        let score = found.errors.score();
        if score >= self.bar(cost) {
            return;
        }
        let shelf = &mut self.shelves[cost];
        // Nearly the same score is nearly always the same formula in other words.
        if let Some(twin) = shelf.iter_mut().find(|f| (f.errors.score() / score - 1.0).abs() < 2e-3) {
            if score < twin.errors.score() {
                *twin = found.clone();
            }
        } else {
            shelf.push(found.clone());
        }
        shelf.sort_by(|a, b| a.errors.score().total_cmp(&b.errors.score()));
        shelf.truncate(KEPT);
    }

    /// The best of each cost that no cheaper one is better than.
    pub fn frontier(&self) -> Vec<&Found> {
        let mut out: Vec<&Found> = Vec::new();
        for f in self.shelves.iter().filter_map(|s| s.first()) {
            if out.last().is_none_or(|l| f.errors.score() < l.errors.score()) {
                out.push(f);
            }
        }
        out
    }
}

/// A generator of pseudo-random numbers (SplitMix64): the search is the same each time.
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (((self.next() >> 33) * n as u64) >> 31) as usize
    }

    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn random_arg(rng: &mut Rng, before: usize, constants: &mut Vec<f64>) -> Arg {
    match rng.below(8) {
        0 => Arg::Roughness,
        1 => Arg::Cos,
        2 | 3 => {
            constants.push(4.0 * rng.uniform() - 2.0);
            Arg::Constant((constants.len() - 1) as u8)
        }
        _ if before > 0 => Arg::Node(rng.below(before) as u8),
        n => [Arg::Roughness, Arg::Cos][n % 2],
    }
}

/// Inserts a node at `at`; later ones move up.
fn insert(p: &mut Program, at: usize, node: Node) {
    let shift = |k: &mut u8| *k += u8::from(*k as usize >= at);
    for n in &mut p.nodes {
        for a in &mut n.args {
            if let Arg::Node(k) = a {
                shift(k);
            }
        }
    }
    p.out.iter_mut().for_each(shift);
    p.nodes.insert(at, node);
}

fn change(p: &mut Program, rng: &mut Rng) {
    let n = p.nodes.len();
    if n == 0 || n + 4 > crate::program::MOST_NODES || p.constants.len() + 6 > 90 {
        return;
    }
    let i = rng.below(n);
    match rng.below(12) {
        // Another operation, or other operands in another order.
        0 => {
            let op = OPS[rng.below(OPS.len())];
            for k in p.nodes[i].op.arity()..op.arity() {
                p.nodes[i].args[k] = random_arg(rng, i, &mut p.constants);
            }
            p.nodes[i].op = op;
        }
        1 | 2 => {
            let k = rng.below(p.nodes[i].op.arity());
            p.nodes[i].args[k] = random_arg(rng, i, &mut p.constants);
        }
        3 => {
            let (a, b) = (rng.below(3), rng.below(3));
            p.nodes[i].args.swap(a, b);
        }
        // Something is added to an operand that is nothing at first: x + 0 · y, or x · y.
        4..=6 => {
            let k = rng.below(p.nodes[i].op.arity());
            let old = p.nodes[i].args[k];
            p.constants.push(0.02 * (rng.uniform() - 0.5));
            let zero = Arg::Constant((p.constants.len() - 1) as u8);
            let y = random_arg(rng, i, &mut p.constants);
            let node = match rng.below(5) {
                0 => Node { op: Op::Mul, args: [old, y, old] },
                1 => Node { op: [Op::Min, Op::Max][rng.below(2)], args: [old, y, old] },
                2 => Node { op: Op::Fma, args: [old, y, old] },
                _ => Node { op: Op::Fma, args: [zero, y, old] },
            };
            insert(p, i, node);
            p.nodes[i + 1].args[k] = Arg::Node(i as u8);
        }
        // A node gives way to one of its operands.
        7 | 8 => {
            let Arg::Node(k) = p.nodes[i].args[rng.below(p.nodes[i].op.arity())] else {
                // Whoever read it reads something else.
                let with = random_arg(rng, i, &mut p.constants);
                for n in &mut p.nodes[i + 1..] {
                    for a in &mut n.args {
                        if *a == Arg::Node(i as u8) {
                            *a = with;
                        }
                    }
                }
                return;
            };
            for n in &mut p.nodes[i + 1..] {
                for a in &mut n.args {
                    if *a == Arg::Node(i as u8) {
                        *a = Arg::Node(k);
                    }
                }
            }
            p.out.iter_mut().filter(|o| **o as usize == i).for_each(|o| *o = k);
        }
        // A coefficient gives way to something that is there.
        9 => {
            let slots: Vec<usize> = (0..p.nodes[i].op.arity())
                .filter(|k| matches!(p.nodes[i].args[*k], Arg::Constant(_)))
                .collect();
            if let Some(k) = slots.get(rng.below(slots.len().max(1))) {
                p.nodes[i].args[*k] = random_arg(rng, i, &mut p.constants);
            }
        }
        // Coefficients elsewhere.
        10 => {
            for c in &mut p.constants {
                if rng.below(3) == 0 {
                    *c *= (2.0 * rng.uniform() - 1.0).exp() * if rng.below(8) == 0 { -1.0 } else { 1.0 };
                }
            }
        }
        _ => p.out[rng.below(2)] = rng.below(n) as u8,
    }
}

/// The scale's program of one and the bias' of another.
fn cross(a: &Program, b: &Program) -> Program {
    let (n, c) = (a.nodes.len() as u8, a.constants.len() as u8);
    let mut p = a.clone();
    for node in &b.nodes {
        let args = node.args.map(|x| match x {
            Arg::Node(k) => Arg::Node(k + n),
            Arg::Constant(k) => Arg::Constant(k + c),
            x => x,
        });
        p.nodes.push(Node { op: node.op, args });
    }
    p.constants.extend(&b.constants);
    p.out[1] = b.out[1] + n;
    p
}

/// Programs for the energy and the bias joined into programs for both: scale = E − B.
pub fn joined(energy: &[Found], bias: &[Found], grid: &Grid) -> Vec<Found> {
    let mut s = Scratch::default();
    let pairs = energy.iter().flat_map(|e| bias.iter().map(move |b| (e, b)));
    pairs
        .filter_map(|(e, b)| {
            let mut p = cross(&e.program, &b.program);
            // The bias' program gives it as its first output.
            let bias = b.program.out[0] + e.program.nodes.len() as u8;
            let args = [Arg::Node(e.program.out[0]), Arg::Node(bias), Arg::Node(bias)];
            p.nodes.push(Node { op: Op::Sub, args });
            p.out = [(p.nodes.len() - 1) as u8, bias];
            let program = p.tidy()?;
            let errors = measure(&program, grid, &mut s)?;
            Some(Found { program, errors })
        })
        .collect()
}

/// Whether a program stays sensible off the grid, too: at the edges, where shaders come, and between.
pub fn behaves(p: &Program, what: What, values: &mut Vec<f64>) -> bool {
    const LINE: [f64; 12] = [0.0, 1e-4, 1e-3, 0.004, 0.01, 0.02, 0.05, 0.11, 0.3, 0.55, 0.8, 1.0];
    let r: Vec<f64> = (0..144).map(|i| LINE[i / 12]).collect();
    let m: Vec<f64> = (0..144).map(|i| LINE[i % 12]).collect();
    p.evaluate(&r, &m, values);
    let of = |k: usize| &values[p.out[k] as usize * 144..][..144];
    of(0).iter().zip(of(1)).enumerate().all(|(i, (a, b))| {
        // At (0, 0) there is no limit, and shaders keep away from it.
        (r[i] == 0.0 && m[i] == 0.0)
            || ((-0.03..=1.03).contains(a)
                && (-0.02..=1.03).contains(b)
                && (what != What::Both || (-0.02..=1.02).contains(&(a + b))))
    })
}

/// Searches for `generations` of `size` candidates each; `told` hears of progress.
pub fn search(
    archives: &mut [Archive],
    grid: &Grid,
    generations: std::ops::Range<u64>,
    size: u64,
    mut told: impl FnMut(u64, &[Archive]),
) {
    let coarse = grid.coarse();
    for generation in generations {
        let snapshot = &*archives;
        let found: Vec<Found> = (0..size)
            .into_par_iter()
            .map_init(Scratch::default, |s, i| {
                let rng = &mut Rng::new(generation * size + i + 1);
                candidate(snapshot, grid, &coarse, rng, s)
            })
            .flatten()
            .collect();
        for f in &found {
            archives.iter_mut().for_each(|a| a.insert(f));
        }
        told(generation, archives);
    }
}

fn pick<'a>(a: &'a Archive, rng: &mut Rng, focus: usize) -> Option<&'a Found> {
    for _ in 0..40 {
        // Half of the time around the cost that matters most.
        let cost = if rng.below(2) == 0 { focus + rng.below(9) } else { 4 + rng.below(MOST - 4) };
        if let Some(s) = a.shelves.get(cost)
            && !s.is_empty()
        {
            return s.get(rng.below(s.len()).min(rng.below(s.len())));
        }
    }
    None
}

fn candidate(
    archives: &[Archive],
    grid: &Grid,
    coarse: &Grid,
    rng: &mut Rng,
    s: &mut Scratch,
) -> Option<Found> {
    let a = &archives[rng.below(archives.len())];
    let focus = match grid.what {
        What::Both => 17,
        _ => 8,
    } + if a.cost == Cost::Operations { 0 } else { 6 };
    let parent = pick(a, rng, focus)?;
    let mut p = parent.program.clone();
    if rng.below(8) == 0 {
        let other = pick(a, rng, focus)?;
        if p.nodes.len() + other.program.nodes.len() < 60 {
            p = cross(&p, &other.program);
        }
    }
    for _ in 0..1 + rng.below(3).min(rng.below(4)) {
        change(&mut p, rng);
    }
    let mut p = p.tidy()?;
    let bar = archives.iter().map(|a| a.bar(a.cost.of(&p))).fold(0.0, f64::max);
    if bar == 0.0 {
        return None;
    }
    let coarse_score = fit(&mut p, coarse, 14, 12, 1.5 * bar, s)?;
    if coarse_score.score() >= bar {
        return None;
    }
    // Those of the first rank deserve more.
    let first = archives.iter().any(|a| {
        a.shelves
            .get(a.cost.of(&p))
            .and_then(|s| s.first())
            .is_none_or(|f| coarse_score.score() < 1.05 * f.errors.score())
    });
    if first {
        fit(&mut p, coarse, 30, 60, f64::INFINITY, s)?;
    }
    let errors = measure(&p, grid, s)?;
    let mut values = Vec::new();
    behaves(&p, grid.what, &mut values).then_some(Found { program: p, errors })
}
