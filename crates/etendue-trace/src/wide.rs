//! The tree as it is traversed: nodes of eight boxes, and leaves of one [`Packet`] of up to eight triangles.
//!
//! A binary tree becomes a wide one at least cost by the surface area heuristic, exactly, by dynamic programming
//! (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
//! section 3.1).

use crate::build::{self, half_area};
use crate::emit::{Emit, Place, measure};
use crate::lanes::F32x8;
use crate::pages::Pages;
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
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Node {
    /// By axis: smallest, then largest.
    pub bounds: [[F32x8; 2]; 3],
    /// Best first for any-hit: by descending half area per primitive.
    pub children: [Child; WIDTH],
    /// Fills the last cache line.
    unused: [u32; 8],
}

impl Node {
    pub const EMPTY: Self = Self {
        bounds: [[F32x8([f32::INFINITY; 8]), F32x8([f32::NEG_INFINITY; 8])]; 3],
        children: [LEAF; WIDTH],
        unused: [0; 8],
    };
}

/// A tree of triangles and, at the top level, instances.
pub(crate) struct Tree {
    pub nodes: Pages<Node>,
    pub packets: Pages<Packet>,
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
pub(crate) struct Plan {
    cost: [f32; WIDTH - 1],
    /// Roots given to the left child out of `i + 1` (0: the subtree is one root; 255: the same as with one root less).
    pub left: [u8; WIDTH - 1],
    /// The same for eight: how the subtree's own node is filled, if it becomes one.
    pub own: u8,
    /// As one root, the subtree is a packet or an instance, not a node.
    pub leaf: bool,
    /// If the subtree becomes a wide node: how many nodes and packets it and all below it are.
    pub size: Size,
}

/// Numbers of nodes and packets.
#[derive(Clone, Copy, Default)]
pub(crate) struct Size {
    pub nodes: u32,
    pub packets: u32,
}

const ONE: u8 = 0;
pub(crate) const FEWER: u8 = 255;

impl Tree {
    pub const EMPTY: Self = Self {
        nodes: Pages::Heap(Vec::new()),
        packets: Pages::Heap(Vec::new()),
        bounds: Bounds::EMPTY,
        triangles: 0,
        stack: 1,
    };

    /// Builds the tree over the boxes `refs`; `primitive` says what their numbers stand for, and numbers from
    /// `first_instance` on are instances.
    pub fn build(
        mut refs: Vec<build::Reference>,
        first_instance: u32,
        primitive: &(impl Fn(u32) -> Primitive + Sync),
    ) -> Self {
        let binary = build::build(&mut refs);
        drop(refs);
        let mut tree = Self::EMPTY;
        let Some(root) = binary.first() else { return tree };
        tree.bounds = Bounds { min: root.lo, max: root.hi };
        let unplanned = Plan { cost: [0.0; 7], left: [0; 7], own: 0, leaf: true, size: Size::default() };
        let mut plans = vec![unplanned; binary.len()];
        plan(&binary, &mut plans, first_instance);
        let mut depth = 1;
        let size = measure(&binary, &mut plans, first_instance, 0, 1, &mut depth);
        // Each level leaves at most seven siblings waiting, the last one eight.
        tree.stack = depth * (WIDTH - 1) + 1;
        tree.nodes = Pages::zeroed(size.nodes as usize);
        tree.packets = Pages::zeroed(size.packets as usize);
        let emit = Emit { binary: &binary, plans: &plans, first_instance, primitive };
        emit.node(0, Place { nodes: &mut tree.nodes, packets: &mut tree.packets, node: 0, packet: 0 });
        tree
    }

    /// Memory that the tree holds.
    pub fn bytes(&self) -> usize {
        self.nodes.bytes() + self.packets.bytes()
    }
}

/// Fills in the plan of the subtree whose nodes are `nodes`, root first; returns whether it holds an instance.
fn plan(nodes: &[build::Node], plans: &mut [Plan], first_instance: u32) -> bool {
    let root = &nodes[0];
    let area = half_area(root.lo, root.hi);
    let (own_plan, below) = plans.split_first_mut().expect("as many plans as nodes");
    if root.is_leaf() {
        *own_plan = Plan {
            cost: [area * PACKET_COST; 7],
            left: [FEWER; 7],
            own: 0,
            leaf: true,
            size: Size::default(),
        };
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
    let has_instance = a || b;
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
    let mut p = Plan { cost: [one; 7], left: [FEWER; 7], own, leaf, size: Size::default() };
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

/// The box around three points.
pub(crate) fn triangle_bounds(p: &[Vec3A; 3]) -> (Vec3A, Vec3A) {
    (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]))
}
