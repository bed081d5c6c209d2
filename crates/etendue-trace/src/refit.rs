//! A tree over triangles that have moved: the same tree, other boxes.
//!
//! What a ray hits does not depend on the tree (see the crate's documentation), so one that keeps its shape gives the same hits
//! as one that is built anew, at a tenth of the time. It gets slower to walk as its boxes overlap more, which [`Shape`] measures.

use crate::build::half_area;
use crate::level::Places;
use crate::triangle::{ALPHA, Packet};
use crate::wide::{INDEX, INSTANCE, KIND, LEAF, Node, Tree, WIDTH, triangle_bounds};
use etendue_scene::Bounds;
use glam::Vec3A;
use rayon::prelude::*;

/// A tree is built anew when walking it has become this much more expensive by the surface area heuristic.
const WORST: f32 = 1.5;

/// What is known of a tree when it was built.
pub(crate) struct Shape {
    /// Its cost by the surface area heuristic, in tests of the root's size; below 0 if it has not been measured.
    cost: f32,
    /// Instances in it.
    pub instances: usize,
}

impl Shape {
    pub const EMPTY: Self = Self { cost: -1.0, instances: 0 };

    pub fn is_empty(&self) -> bool {
        self.cost < 0.0
    }

    pub fn of(tree: &Tree) -> Self {
        let is_instance = |c: &&u32| **c & KIND == INSTANCE;
        let instances = tree.nodes.iter().map(|n| n.children.iter().filter(is_instance).count()).sum();
        Self { cost: cost(tree), instances }
    }
}

/// The box of a child; `None` if there is no child in that lane.
fn child(node: &Node, lane: usize) -> Option<Bounds> {
    let at = |side: usize| {
        Vec3A::new(node.bounds[0][side].0[lane], node.bounds[1][side].0[lane], node.bounds[2][side].0[lane])
    };
    let b = Bounds { min: at(0), max: at(1) };
    (b.min.x <= b.max.x).then_some(b)
}

/// The sum of the children's surfaces over the root's.
fn cost(tree: &Tree) -> f32 {
    let of = |n: &Node| (0..WIDTH).filter_map(|l| child(n, l)).map(|b| half_area(b.min, b.max)).sum::<f32>();
    let all: f32 = tree.nodes.iter().map(of).sum();
    let root = half_area(tree.bounds.min, tree.bounds.max);
    if root > 0.0 { all / root } else { 0.0 }
}

impl Tree {
    /// Moves the triangles of all packets to where `places` has them, and returns each packet's box; `None`, and the tree is of no
    /// use any more, if one of them cannot be hit there.
    pub fn move_triangles(&mut self, places: &Places<'_>) -> Option<Vec<Bounds>> {
        let packets: &mut [Packet] = &mut self.packets;
        packets
            .par_iter_mut()
            .map(|packet| {
                let mut all = Bounds::EMPTY;
                for lane in 0..WIDTH {
                    let (instance, triangle) = (packet.instance[lane] & !ALPHA, packet.triangle[lane]);
                    if triangle == u32::MAX {
                        continue;
                    }
                    let p = places.valid(instance, triangle)?;
                    let (min, max) = triangle_bounds(&p);
                    all = all.union(Bounds { min, max });
                    packet.set(lane, p.map(|p| p.to_array()), places.tag(instance), triangle);
                }
                Some(all)
            })
            .collect()
    }

    /// Fits the boxes to packets with the boxes `leaves` and to instances where `place` says. False, and the tree is of no use
    /// any more, if an instance is nowhere, or if the tree should be built anew.
    pub fn refit(&mut self, leaves: &[Bounds], shape: &Shape, place: impl Fn(u32) -> Option<Bounds>) -> bool {
        let nodes: &mut [Node] = &mut self.nodes;
        let mut boxes = vec![Bounds::EMPTY; nodes.len()];
        // Children come after their parents.
        for at in (0..nodes.len()).rev() {
            let node = &mut nodes[at];
            for lane in 0..WIDTH {
                if child(node, lane).is_none() {
                    continue;
                }
                let c = node.children[lane];
                let number = (c & INDEX) as usize;
                let b = match c & KIND {
                    LEAF => leaves[number],
                    INSTANCE => match place(number as u32) {
                        Some(b) => b,
                        None => return false,
                    },
                    _ => boxes[number],
                };
                for axis in 0..3 {
                    node.bounds[axis][0].0[lane] = b.min[axis];
                    node.bounds[axis][1].0[lane] = b.max[axis];
                }
                boxes[at] = boxes[at].union(b);
            }
        }
        self.bounds = boxes.first().copied().unwrap_or(Bounds::EMPTY);
        cost(self) <= WORST * shape.cost
    }
}
