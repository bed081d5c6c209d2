//! Writing a planned tree out: a node, the packets among its children, then its children's subtrees, in parallel.

use crate::build::{self, half_area};
use crate::triangle::Packet;
use crate::wide::{FEWER, INSTANCE, LEAF, Node, Plan, Primitive, Size, WIDTH};
use rayon::prelude::*;

/// Subtrees with fewer references than this are written by one thread.
const PARALLEL: u32 = 4096;

/// A binary tree and the plan to make a wide one of it.
pub(crate) struct Emit<'a, P> {
    pub binary: &'a [build::Node],
    pub plans: &'a [Plan],
    /// Numbers from here on are instances.
    pub first_instance: u32,
    pub primitive: &'a P,
}

/// Where a subtree goes: its slices, and where they begin in the tree's.
pub(crate) struct Place<'a> {
    pub nodes: &'a mut [Node],
    pub packets: &'a mut [Packet],
    pub node: u32,
    pub packet: u32,
}

impl<'a> Place<'a> {
    /// Cuts a part of the given size off the front.
    fn take(&mut self, size: Size) -> Place<'a> {
        let (nodes, packets) = (std::mem::take(&mut self.nodes), std::mem::take(&mut self.packets));
        let (nodes, other_nodes) = nodes.split_at_mut(size.nodes as usize);
        let (packets, other_packets) = packets.split_at_mut(size.packets as usize);
        let taken = Place { nodes, packets, node: self.node, packet: self.packet };
        *self = Place {
            nodes: other_nodes,
            packets: other_packets,
            node: self.node + size.nodes,
            packet: self.packet + size.packets,
        };
        taken
    }
}

/// The roots that fill the wide node made of the subtree at `at`, and how many they are.
fn roots_of(binary: &[build::Node], plans: &[Plan], at: usize) -> ([usize; WIDTH], usize) {
    let (mut roots, mut n) = ([0; WIDTH], 0);
    if plans[at].leaf {
        // Traversal starts at a node: a lone leaf is given one.
        roots[0] = at;
        return (roots, 1);
    }
    let k = plans[at].own as usize;
    collect(binary, plans, at + 1, k, &mut roots, &mut n);
    collect(binary, plans, at + binary[at].link as usize, WIDTH - k, &mut roots, &mut n);
    (roots, n)
}

/// Collects the at most `i` roots that represent the subtree at `at`.
fn collect(
    binary: &[build::Node],
    plans: &[Plan],
    at: usize,
    mut i: usize,
    roots: &mut [usize; WIDTH],
    n: &mut usize,
) {
    while i > 1 && plans[at].left[i - 1] == FEWER {
        i -= 1;
    }
    if i == 1 {
        roots[*n] = at;
        *n += 1;
    } else {
        let k = plans[at].left[i - 1] as usize;
        collect(binary, plans, at + 1, k, roots, n);
        collect(binary, plans, at + binary[at].link as usize, i - k, roots, n);
    }
}

/// Notes in the plans how large each wide node's subtree is, and in `deepest` how many levels there are.
pub(crate) fn measure(
    binary: &[build::Node],
    plans: &mut [Plan],
    first_instance: u32,
    at: usize,
    depth: usize,
    deepest: &mut usize,
) -> Size {
    *deepest = depth.max(*deepest);
    let (roots, n) = roots_of(binary, plans, at);
    let mut size = Size { nodes: 1, packets: 0 };
    for &root in &roots[..n] {
        if !plans[root].leaf {
            let below = measure(binary, plans, first_instance, root, depth + 1, deepest);
            size.nodes += below.nodes;
            size.packets += below.packets;
        } else if !is_instance(&binary[root], first_instance) {
            size.packets += 1;
        }
    }
    plans[at].size = size;
    size
}

fn is_instance(node: &build::Node, first_instance: u32) -> bool {
    node.is_leaf() && node.link >= first_instance
}

impl<P: Fn(u32) -> Primitive + Sync> Emit<'_, P> {
    /// Emits the subtree at binary node `at` as a wide node.
    pub fn node(&self, at: usize, mut place: Place) {
        let (mut roots, n) = roots_of(self.binary, self.plans, at);
        let priority = |&i: &usize| {
            let b = &self.binary[i];
            half_area(b.lo, b.hi) / b.count as f32
        };
        roots[..n].sort_by(|a, b| priority(b).total_cmp(&priority(a)).then(a.cmp(b)));

        let own = place.take(Size { nodes: 1, packets: 0 });
        let node = &mut own.nodes[0];
        *node = Node::EMPTY;
        for (lane, &root) in roots[..n].iter().enumerate() {
            let b = &self.binary[root];
            for axis in 0..3 {
                node.bounds[axis][0].0[lane] = b.lo[axis];
                node.bounds[axis][1].0[lane] = b.hi[axis];
            }
            if !self.plans[root].leaf {
                continue;
            }
            node.children[lane] = if is_instance(b, self.first_instance) {
                let Primitive::Instance(i) = (self.primitive)(b.link) else {
                    unreachable!("numbered as one")
                };
                INSTANCE | i
            } else {
                let place = place.take(Size { nodes: 0, packets: 1 });
                self.packet(root, &mut place.packets[0]);
                LEAF | place.packet
            };
        }
        let parallel = self.binary[at].count > PARALLEL;
        let mut below = Vec::new();
        for (lane, &root) in roots[..n].iter().enumerate() {
            if self.plans[root].leaf {
                continue;
            }
            let part = place.take(self.plans[root].size);
            node.children[lane] = part.node;
            if parallel {
                below.push((root, part));
            } else {
                self.node(root, part);
            }
        }
        below.into_par_iter().for_each(|(root, part)| self.node(root, part));
    }

    /// Emits the triangles below `at` in their order of number.
    fn packet(&self, at: usize, packet: &mut Packet) {
        let nodes = &self.binary[at..at + 2 * self.binary[at].count as usize - 1];
        let mut ids = [u32::MAX; WIDTH];
        let leaves = nodes.iter().filter(|n| n.is_leaf());
        let n = leaves.zip(&mut ids).map(|(leaf, id)| *id = leaf.link).count();
        ids[..n].sort_unstable();
        *packet = Packet::empty();
        for (lane, &id) in ids[..n].iter().enumerate() {
            if let Primitive::Triangle { vertices, instance, triangle } = (self.primitive)(id) {
                packet.set(lane, vertices, instance, triangle);
            }
        }
    }
}
