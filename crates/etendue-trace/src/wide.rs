//! The tree as it is traversed: nodes of eight boxes, and leaves of one [`Packet`] of up to eight triangles.
//!
//! A binary tree becomes a wide one at least cost by the surface area heuristic, exactly, by dynamic programming
//! (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
//! section 3.1).

use crate::build::{self, half_area};
use crate::lanes::F32x8;
use crate::triangle::Packet;
use etendue_scene::Bounds;
use glam::Vec3A;

/// Children per node, and triangles per leaf at most.
pub(crate) const WIDTH: usize = 8;

/// Cost of testing one node's boxes; a packet of triangles costs [`PACKET_COST`].
const NODE_COST: f32 = 1.0;
const PACKET_COST: f32 = 1.0;

/// A child: an index, and in the two highest bits what it indexes.
pub(crate) type Child = u32;
pub(crate) const INDEX: u32 = (1 << 30) - 1;
/// The kind bits: none for a node.
pub(crate) const KIND: u32 = !INDEX;
pub(crate) const LEAF: u32 = 1 << 30;
pub(crate) const INSTANCE: u32 = 2 << 30;

/// Eight boxes and what is in them. Unused lanes have an inverted infinite box, which no ray meets.
#[repr(C, align(64))]
#[derive(Clone)]
pub(crate) struct Node {
    /// By axis: smallest, then largest.
    pub bounds: [[F32x8; 2]; 3],
    /// Best first for any-hit: by descending half area per primitive.
    pub children: [Child; WIDTH],
}

impl Node {
    const EMPTY: Self = Self {
        bounds: [[F32x8([f32::INFINITY; 8]), F32x8([f32::NEG_INFINITY; 8])]; 3],
        children: [LEAF; WIDTH],
    };
}

/// A tree of triangles and, at the top level, instances.
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
    pub packets: Vec<Packet>,
    pub bounds: Bounds,
    /// Triangles in it, without those of instances.
    pub triangles: u64,
    /// Most entries that traversal ever has on its stack.
    pub stack: usize,
}

/// What a reference's number stands for.
pub(crate) enum Primitive {
    Triangle { vertices: [[f32; 3]; 3], instance: u32, triangle: u32 },
    Instance(u32),
}

/// How a subtree is best represented by at most `i` children of one wide node, for i = 1 to 7.
#[derive(Clone, Copy)]
struct Plan {
    cost: [f32; WIDTH - 1],
    /// Roots given to the left child out of `i + 1` (0: the subtree is one root; 255: the same as with one root less).
    left: [u8; WIDTH - 1],
    /// The same for eight: how the subtree's own node is filled, if it becomes one.
    own: u8,
    leaf: bool,
}

const ONE: u8 = 0;
const FEWER: u8 = 255;

impl Tree {
    /// Builds the tree over the boxes `refs`; `primitive` says what their numbers stand for, and numbers from
    /// `first_instance` on are instances.
    pub fn build(
        mut refs: Vec<build::Reference>,
        first_instance: u32,
        primitive: &(impl Fn(u32) -> Primitive + Sync),
    ) -> Self {
        let binary = build::build(&mut refs);
        drop(refs);
        let mut tree =
            Self { nodes: Vec::new(), packets: Vec::new(), bounds: Bounds::EMPTY, triangles: 0, stack: 1 };
        let Some(root) = binary.first() else { return tree };
        tree.bounds = Bounds { min: root.lo, max: root.hi };
        let mut plans = vec![Plan { cost: [0.0; 7], left: [0; 7], own: 0, leaf: true }; binary.len()];
        plan(&binary, &mut plans, first_instance);
        let mut emit = Emit { binary: &binary, plans: &plans, first_instance, primitive, tree: &mut tree };
        if plans[0].leaf {
            // Traversal starts at a node: give the lone leaf one.
            let mut node = Node::EMPTY;
            emit.tree.nodes.push(node.clone());
            emit.fill(&mut node, 0, 0, 1);
            emit.tree.nodes[0] = node;
            emit.tree.stack = WIDTH;
        } else {
            emit.node(0, 1);
        }
        tree
    }

    /// Memory that the tree holds.
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.packets.capacity() * size_of::<Packet>()
    }
}

/// Fills in the plan of the subtree whose nodes are `nodes`, root first; returns whether it holds an instance.
fn plan(nodes: &[build::Node], plans: &mut [Plan], first_instance: u32) -> bool {
    let root = &nodes[0];
    let area = half_area(root.lo, root.hi);
    let (own_plan, below) = plans.split_first_mut().expect("as many plans as nodes");
    if root.is_leaf() {
        *own_plan = Plan { cost: [area * PACKET_COST; 7], left: [FEWER; 7], own: 0, leaf: true };
        own_plan.left[0] = ONE;
        return root.link >= first_instance;
    }
    let right = root.link as usize;
    let (left_plans, right_plans) = below.split_at_mut(right - 1);
    let (a, b) = if root.count > 4096 {
        rayon::join(
            || plan(&nodes[1..right], left_plans, first_instance),
            || plan(&nodes[right..], right_plans, first_instance),
        )
    } else {
        (
            plan(&nodes[1..right], left_plans, first_instance),
            plan(&nodes[right..], right_plans, first_instance),
        )
    };
    let has_instance = a | b;
    let (l, r) = (&left_plans[0].cost, &right_plans[0].cost);
    // The cheapest way to make `i` roots of the two children's.
    let distribute = |i: usize| {
        let mut best = (f32::INFINITY, 1u8);
        for k in i.saturating_sub(WIDTH - 1).max(1)..=(i - 1).min(WIDTH - 1) {
            let cost = l[k - 1] + r[i - k - 1];
            if cost < best.0 {
                best = (cost, k as u8);
            }
        }
        best
    };
    let (below, own) = distribute(WIDTH);
    let inner = below + area * NODE_COST;
    let fits = root.count as usize <= WIDTH && !has_instance;
    // Written so that the leaf is also taken where areas overflow.
    let leaf = fits && (inner >= area * PACKET_COST || inner.is_nan());
    let one = if leaf { area * PACKET_COST } else { inner };
    let mut p = Plan { cost: [one; 7], left: [FEWER; 7], own, leaf };
    p.left[0] = ONE;
    for i in 2..WIDTH {
        let (cost, k) = distribute(i);
        if cost < p.cost[i - 2] {
            (p.cost[i - 1], p.left[i - 1]) = (cost, k);
        } else {
            p.cost[i - 1] = p.cost[i - 2];
        }
    }
    *own_plan = p;
    has_instance
}

/// Writes a planned tree out, depth first.
struct Emit<'a, P> {
    binary: &'a [build::Node],
    plans: &'a [Plan],
    first_instance: u32,
    primitive: &'a P,
    tree: &'a mut Tree,
}

impl<P: Fn(u32) -> Primitive> Emit<'_, P> {
    /// Emits the subtree at binary node `at` as a wide node `depth` levels down, and returns its index.
    fn node(&mut self, at: usize, depth: usize) -> u32 {
        // Each level leaves at most seven siblings waiting, the last one eight.
        self.tree.stack = self.tree.stack.max(depth * (WIDTH - 1) + 1);
        let mut roots = [0usize; WIDTH];
        let mut n = 0;
        let k = self.plans[at].own as usize;
        self.roots(at + 1, k, &mut roots, &mut n);
        self.roots(at + self.binary[at].link as usize, WIDTH - k, &mut roots, &mut n);
        let priority = |&i: &usize| {
            let b = &self.binary[i];
            half_area(b.lo, b.hi) / b.count as f32
        };
        roots[..n].sort_by(|a, b| priority(b).total_cmp(&priority(a)).then(a.cmp(b)));

        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::EMPTY);
        let mut node = Node::EMPTY;
        for (lane, &root) in roots[..n].iter().enumerate() {
            self.fill(&mut node, lane, root, depth + 1);
        }
        self.tree.nodes[index] = node;
        index as u32
    }

    /// Collects the at most `i` roots that represent the subtree at `at`.
    fn roots(&self, at: usize, mut i: usize, roots: &mut [usize; WIDTH], n: &mut usize) {
        while i > 1 && self.plans[at].left[i - 1] == FEWER {
            i -= 1;
        }
        let k = self.plans[at].left[i - 1] as usize;
        if i == 1 {
            roots[*n] = at;
            *n += 1;
        } else {
            self.roots(at + 1, k, roots, n);
            self.roots(at + self.binary[at].link as usize, i - k, roots, n);
        }
    }

    /// Makes binary node `at` the child `lane` of `node`.
    fn fill(&mut self, node: &mut Node, lane: usize, at: usize, depth: usize) {
        let b = self.binary[at];
        for axis in 0..3 {
            node.bounds[axis][0].0[lane] = b.lo[axis];
            node.bounds[axis][1].0[lane] = b.hi[axis];
        }
        node.children[lane] = if !self.plans[at].leaf {
            self.node(at, depth)
        } else if b.is_leaf() && b.link >= self.first_instance {
            let Primitive::Instance(i) = (self.primitive)(b.link) else {
                unreachable!("numbered as an instance")
            };
            INSTANCE | i
        } else {
            LEAF | self.packet(at)
        };
    }

    /// Emits the triangles below `at` as one packet, in their order of number, and returns its index.
    fn packet(&mut self, at: usize) -> u32 {
        let nodes = &self.binary[at..at + 2 * self.binary[at].count as usize - 1];
        let mut packet = Packet::empty();
        let mut ids = [u32::MAX; WIDTH];
        let leaves = nodes.iter().filter(|n| n.is_leaf());
        let n = leaves.zip(&mut ids).map(|(leaf, id)| *id = leaf.link).count();
        ids[..n].sort_unstable();
        for (lane, &id) in ids[..n].iter().enumerate() {
            if let Primitive::Triangle { vertices, instance, triangle } = (self.primitive)(id) {
                packet.set(lane, vertices, instance, triangle);
            }
        }
        self.tree.packets.push(packet);
        (self.tree.packets.len() - 1) as u32
    }
}

/// The box around three points.
pub(crate) fn triangle_bounds(p: &[Vec3A; 3]) -> (Vec3A, Vec3A) {
    (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]))
}
