//! Walking a tree with one ray, once in generic code over [`Lanes`].

use crate::lanes::{F32x8, Lanes};
use crate::ray::Prepared;
use crate::triangle::Packet;
use crate::wide::{Child, INDEX, KIND, LEAF, Node, Tree};
use std::mem::MaybeUninit;

/// Entries of the traversal stack; [`crate::Accel::build`] checks that no tree needs more.
pub(crate) const STACK: usize = 512;

/// A child that waits: its entry distance's bits above its [`Child`]. Distances are not negative, so entries sort
/// as integers.
type Entry = u64;

#[inline(always)]
fn entry(distance: f32, child: Child) -> Entry {
    (distance.to_bits() as u64) << 32 | child as u64
}

#[inline(always)]
fn distance(e: Entry) -> f32 {
    f32::from_bits((e >> 32) as u32)
}

/// The waiting children. A fixed array, left uninitialised because clearing it would cost as much as several nodes.
struct Stack {
    entries: [MaybeUninit<Entry>; STACK],
    len: usize,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; STACK], len: 0 }
    }
    #[inline(always)]
    fn push(&mut self, e: Entry) {
        self.entries[self.len].write(e);
        self.len += 1;
    }
    #[inline(always)]
    fn pop(&mut self) -> Option<Entry> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: `push` has written every entry below the length it left behind, and only it raises the length.
        Some(unsafe { self.entries[self.len].assume_init() })
    }
    /// Sorts the entries from `from` on, the nearest last.
    #[inline(always)]
    fn sort(&mut self, from: usize) {
        for i in from + 1..self.len {
            // SAFETY: entries below the length are initialised; see `pop`.
            let e = unsafe { self.entries[i].assume_init() };
            let mut j = i;
            while j > from {
                // SAFETY: as above.
                let before = unsafe { self.entries[j - 1].assume_init() };
                if before >= e {
                    break;
                }
                self.entries[j].write(before);
                j -= 1;
            }
            self.entries[j].write(e);
        }
    }
}

/// What to do where a walk ends.
///
/// A trait and not a closure: closures do not inherit the features of the kernel they are called in, and cannot be
/// told to be inlined.
pub(crate) trait Visitor {
    /// Looks into a leaf or an instance whose box the ray meets no later than `t_max`. May lower `t_max`; ends the
    /// walk by returning true.
    fn visit<S: Lanes>(&mut self, child: Child, t_max: &mut f32) -> bool;
}

/// Where the ray meets planes across one axis. `origin` is already multiplied by `inverse`.
#[inline(always)]
fn slab<S: Lanes>(plane: &F32x8, inverse: S, origin: S) -> S {
    S::load(plane).loose_mul_sub(inverse, origin)
}

/// Visits the leaves and instances whose boxes the ray meets: near ones first for closest-hit, promising ones first
/// for `ANY`.
#[inline(always)]
pub(crate) fn walk<S: Lanes, const ANY: bool>(
    tree: &Tree,
    ray: &Prepared,
    mut t_max: f32,
    visitor: &mut impl Visitor,
) {
    let (nodes, packets): (&[Node], &[Packet]) = (&tree.nodes, &tree.packets);
    if nodes.is_empty() {
        return;
    }
    let inverse = [S::splat(ray.inverse[0]), S::splat(ray.inverse[1]), S::splat(ray.inverse[2])];
    let near = [S::splat(ray.near[0]), S::splat(ray.near[1]), S::splat(ray.near[2])];
    let far = [S::splat(ray.far[0]), S::splat(ray.far[1]), S::splat(ray.far[2])];
    let t_min = S::splat(ray.t_min);
    let sign = ray.sign;
    let mut stack = Stack::new();
    let mut current: Child = 0;
    loop {
        // Down, as long as there is a node.
        while current & KIND == 0 {
            let node = &nodes[current as usize];
            let (x, y, z) = (&node.bounds[0], &node.bounds[1], &node.bounds[2]);
            let [i, j, k] = [sign[0] & 1, sign[1] & 1, sign[2] & 1];
            let first = slab(&x[i], inverse[0], near[0])
                .max(slab(&y[j], inverse[1], near[1]))
                .max(slab(&z[k], inverse[2], near[2]).max(t_min));
            let last = slab(&x[i ^ 1], inverse[0], far[0])
                .min(slab(&y[j ^ 1], inverse[1], far[1]))
                .min(slab(&z[k ^ 1], inverse[2], far[2]).min(S::splat(t_max)));
            let mut lanes = first.le(last).signs();
            if lanes == 0 {
                break;
            }
            let first = first.store().0;
            let mut next = || {
                let lane = lanes.trailing_zeros() as usize & 7;
                lanes &= lanes - 1;
                let child = node.children[lane];
                if child & KIND == 0 {
                    S::prefetch(&nodes[index(child)]);
                } else if child & KIND == LEAF {
                    S::prefetch(&packets[index(child)]);
                }
                (entry(first[lane], child), lanes == 0)
            };
            let (a, end) = next();
            if end {
                current = a as Child;
                continue;
            }
            if ANY {
                // Lanes are sorted by promise: take the first, and leave the rest so that the second pops first.
                let from = stack.len;
                loop {
                    let (b, end) = next();
                    stack.push(b);
                    if end {
                        break;
                    }
                }
                let (mut i, mut j) = (from, stack.len - 1);
                while i < j {
                    stack.entries.swap(i, j);
                    i += 1;
                    j -= 1;
                }
                current = a as Child;
                continue;
            }
            let (b, end) = next();
            if end {
                stack.push(a.max(b));
                current = a.min(b) as Child;
                continue;
            }
            let from = stack.len;
            stack.push(a);
            stack.push(b);
            loop {
                let (c, end) = next();
                stack.push(c);
                if end {
                    break;
                }
            }
            stack.sort(from);
            current = stack.pop().unwrap_or(0) as Child;
        }
        if current & KIND != 0 && visitor.visit::<S>(current, &mut t_max) {
            return;
        }
        current = loop {
            let Some(e) = stack.pop() else { return };
            if distance(e) <= t_max {
                break e as Child;
            }
        };
    }
}

/// The index in a child reference.
#[inline(always)]
pub(crate) fn index(child: Child) -> usize {
    (child & INDEX) as usize
}
