//! A binary tree over boxes by the surface area heuristic, built top down in parallel.
//!
//! Binned SAH over all three axes (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies").
//! The result is a pure function of the input: minima, maxima and counts do not depend on the order in which threads
//! deliver them, and each subtree has its place in memory before it is built.

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

/// Bins per axis; fewer where there is little to put in them.
const BINS: usize = 16;
/// Up to this many references, a quarter of the bins: they will mostly share a packet.
const FEW: usize = 8;
/// Up to this many references, half the bins.
const SOME: usize = 32;
/// Subtrees with fewer references than this are built by one thread.
const PARALLEL: usize = 4096;
/// Below this depth splits are by count, which bounds the depth for any input: at most 32 more levels.
const SAH_DEPTH: u32 = 40;
/// No leaf lies deeper than this.
pub(crate) const MAX_DEPTH: usize = SAH_DEPTH as usize + 32;

/// A box with a number attached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    /// Smallest corner; `w` holds the number's bits.
    lo: Vec4,
    /// Largest corner; `w` is 0.
    hi: Vec4,
}

impl Reference {
    pub fn new(lo: Vec3A, hi: Vec3A, id: u32) -> Self {
        Self { lo: lo.extend(f32::from_bits(id)), hi: hi.extend(0.0) }
    }
    pub fn id(&self) -> u32 {
        self.lo.w.to_bits()
    }
    pub fn lo(&self) -> Vec3A {
        Vec3A::from_vec4(self.lo)
    }
    pub fn hi(&self) -> Vec3A {
        Vec3A::from_vec4(self.hi)
    }
    /// Twice the centre.
    #[inline(always)]
    fn center(&self) -> Vec3A {
        self.lo() + self.hi()
    }
}

/// Half the surface of a box; 0 for an empty one.
pub(crate) fn half_area(lo: Vec3A, hi: Vec3A) -> f32 {
    let d = (hi - lo).max(Vec3A::ZERO);
    d.x * (d.y + d.z) + d.y * d.z
}

/// A node of the binary tree. Its left child is the next node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub lo: Vec3A,
    pub hi: Vec3A,
    /// Number of references below.
    pub count: u32,
    /// Inner node: distance to the right child. Leaf (`count == 1`): the reference's number.
    pub link: u32,
}

impl Node {
    const UNSET: Self = Self { lo: Vec3A::ZERO, hi: Vec3A::ZERO, count: 0, link: 0 };
    pub fn is_leaf(&self) -> bool {
        self.count == 1
    }
}

/// The tree over `refs`, root first, every leaf a single reference; empty for none. Reorders `refs`.
pub(crate) fn build(refs: &mut [Reference]) -> Vec<Node> {
    if refs.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![Node::UNSET; 2 * refs.len() - 1];
    subtree(refs, &mut nodes, 0);
    nodes
}

fn subtree(refs: &mut [Reference], nodes: &mut [Node], depth: u32) {
    let n = refs.len();
    if n == 1 {
        let r = refs[0];
        nodes[0] = Node { lo: r.lo(), hi: r.hi(), count: 1, link: r.id() };
        return;
    }
    let extent = Extent::of(refs);
    let mid = if n == 2 {
        1
    } else if depth >= SAH_DEPTH {
        split_by_count(refs, &extent)
    } else {
        let mid = if n <= FEW {
            split_by_area::<{ BINS / 4 }>(refs, &extent)
        } else if n <= SOME {
            split_by_area::<{ BINS / 2 }>(refs, &extent)
        } else {
            split_by_area::<BINS>(refs, &extent)
        };
        mid.unwrap_or_else(|| split_by_count(refs, &extent))
    };
    let (left, right) = refs.split_at_mut(mid);
    let (node, below) = nodes.split_first_mut().expect("2 n − 1 ≥ 1 nodes");
    let (left_nodes, right_nodes) = below.split_at_mut(2 * mid - 1);
    *node = Node { lo: extent.lo, hi: extent.hi, count: n as u32, link: 2 * mid as u32 };
    if n >= PARALLEL {
        rayon::join(|| subtree(left, left_nodes, depth + 1), || subtree(right, right_nodes, depth + 1));
    } else {
        subtree(left, left_nodes, depth + 1);
        subtree(right, right_nodes, depth + 1);
    }
}

/// The box around a set of references, and the one around their (doubled) centres.
#[derive(Clone, Copy)]
struct Extent {
    lo: Vec3A,
    hi: Vec3A,
    center_lo: Vec3A,
    center_hi: Vec3A,
}

impl Extent {
    const EMPTY: Self = Self {
        lo: Vec3A::INFINITY,
        hi: Vec3A::NEG_INFINITY,
        center_lo: Vec3A::INFINITY,
        center_hi: Vec3A::NEG_INFINITY,
    };

    fn of(refs: &[Reference]) -> Self {
        if refs.len() >= 4 * PARALLEL {
            return refs.par_chunks(PARALLEL).map(Self::of_few).reduce(|| Self::EMPTY, Self::union);
        }
        Self::of_few(refs)
    }

    fn of_few(refs: &[Reference]) -> Self {
        refs.iter().fold(Self::EMPTY, |e, r| Self {
            lo: e.lo.min(r.lo()),
            hi: e.hi.max(r.hi()),
            center_lo: e.center_lo.min(r.center()),
            center_hi: e.center_hi.max(r.center()),
        })
    }

    fn union(self, o: Self) -> Self {
        Self {
            lo: self.lo.min(o.lo),
            hi: self.hi.max(o.hi),
            center_lo: self.center_lo.min(o.center_lo),
            center_hi: self.center_hi.max(o.center_hi),
        }
    }
}

/// Splits at the median centre along the widest axis; ties by number. Returns the left side's length.
fn split_by_count(refs: &mut [Reference], extent: &Extent) -> usize {
    let d = extent.center_hi - extent.center_lo;
    let axis = if d.x >= d.y && d.x >= d.z {
        0
    } else if d.y >= d.z {
        1
    } else {
        2
    };
    let mid = refs.len() / 2;
    refs.select_nth_unstable_by(mid, |a, b| {
        a.center()[axis].total_cmp(&b.center()[axis]).then(a.id().cmp(&b.id()))
    });
    mid
}

/// What fell into one bin of one axis.
#[derive(Clone, Copy)]
struct Bin {
    lo: Vec3A,
    hi: Vec3A,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { lo: Vec3A::INFINITY, hi: Vec3A::NEG_INFINITY, count: 0 };
    #[inline(always)]
    fn union(self, o: Self) -> Self {
        Self { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi), count: self.count + o.count }
    }
    fn cost(self) -> f32 {
        half_area(self.lo, self.hi) * self.count as f32
    }
}

type Bins<const N: usize> = [[Bin; N]; 3];

/// Maps doubled centres to bins.
#[derive(Clone, Copy)]
struct Binning<const N: usize> {
    origin: Vec3A,
    scale: Vec3A,
}

impl<const N: usize> Binning<N> {
    #[inline(always)]
    fn bins(&self, r: &Reference) -> [usize; 3] {
        // `as` saturates and takes NaN (an axis without extent: 0 · ∞) to 0, so every result is a bin.
        ((r.center() - self.origin) * self.scale)
            .to_array()
            .map(|x| (x as i32).clamp(0, N as i32 - 1) as usize)
    }

    fn fill(&self, refs: &[Reference]) -> Bins<N> {
        if refs.len() >= 4 * PARALLEL {
            let empty = || [[Bin::EMPTY; N]; 3];
            return refs.par_chunks(PARALLEL).map(|c| self.fill_few(c)).reduce(empty, |mut a, b| {
                for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
                    *a = a.union(*b);
                }
                a
            });
        }
        self.fill_few(refs)
    }

    fn fill_few(&self, refs: &[Reference]) -> Bins<N> {
        let mut bins = [[Bin::EMPTY; N]; 3];
        for r in refs {
            let one = Bin { lo: r.lo(), hi: r.hi(), count: 1 };
            for (axis, bin) in self.bins(r).into_iter().enumerate() {
                bins[axis][bin] = bins[axis][bin].union(one);
            }
        }
        bins
    }
}

/// Splits where area × count is least, and returns the left side's length; `None` if all centres coincide.
fn split_by_area<const N: usize>(refs: &mut [Reference], extent: &Extent) -> Option<usize> {
    let d = extent.center_hi - extent.center_lo;
    let binning = Binning::<N> {
        origin: extent.center_lo,
        // A little less than N, so that the last centre lands in the last bin.
        scale: Vec3A::splat(N as f32 * 0.999_99) / d,
    };
    let bins = binning.fill(refs);
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        if !(d[axis] > 0.0 && binning.scale[axis].is_finite()) {
            continue;
        }
        let mut right = [0.0; N];
        let mut sum = Bin::EMPTY;
        for i in (1..N).rev() {
            sum = sum.union(bins[axis][i]);
            right[i] = if sum.count == 0 { f32::INFINITY } else { sum.cost() };
        }
        let mut sum = Bin::EMPTY;
        for i in 1..N {
            sum = sum.union(bins[axis][i - 1]);
            let cost = if sum.count == 0 { f32::INFINITY } else { sum.cost() + right[i] };
            if cost < best.0 {
                best = (cost, axis, i);
            }
        }
    }
    let (cost, axis, bin) = best;
    if cost == f32::INFINITY {
        return None;
    }
    Some(partition(refs, |r| binning.bins(r)[axis] < bin))
}

/// Moves what satisfies `left` to the front and returns how many did.
fn partition(refs: &mut [Reference], left: impl Fn(&Reference) -> bool) -> usize {
    let (mut i, mut j) = (0, refs.len());
    loop {
        while i < j && left(&refs[i]) {
            i += 1;
        }
        while i < j && !left(&refs[j - 1]) {
            j -= 1;
        }
        if i >= j {
            return i;
        }
        refs.swap(i, j - 1);
        i += 1;
        j -= 1;
    }
}
