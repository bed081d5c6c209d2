//! What a ray looks for in the leaves: the nearest hit, or any.

use crate::accel::Accel;
use crate::instance::Placement;
use crate::lanes::Lanes;
use crate::level::Level;
use crate::ray::{Prepared, Ray, Slack};
use crate::traverse::{Visitor, index, walk};
use crate::triangle::{ALPHA, Packet};
use crate::wide::{Child, KIND, LEAF};

/// No hit yet: greater than every key.
pub(crate) const NONE: u64 = u64::MAX;

/// The best hit so far. `key` is (instance, triangle) as one number, so that ties go to the lower.
pub(crate) struct Best {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub key: u64,
}

impl Best {
    /// Tests one packet. Returns true when the search is over.
    #[inline(always)]
    fn test<S: Lanes, const ANY: bool>(
        &mut self,
        packet: &Packet,
        ray: &Prepared,
        tag: impl Tag,
        accept: &impl Fn(u32, u32, f32, f32) -> bool,
    ) -> bool {
        let Some(mut candidates) = packet.intersect::<S>(ray, self.t) else { return false };
        while let Some((lane, t, u, v)) = candidates.next(packet, ray, self.t) {
            let tag = tag.of(packet, lane);
            let (instance, triangle) = (tag & !ALPHA, packet.triangle[lane]);
            let key = (instance as u64) << 32 | triangle as u64;
            let nearer = ANY || t < self.t || key < self.key;
            if nearer && (tag & ALPHA == 0 || accept(instance, triangle, u, v)) {
                *self = Best { t, u, v, key };
                if ANY {
                    return true;
                }
            }
        }
        false
    }
}

/// Where a triangle's instance and alpha flag come from.
trait Tag: Copy {
    fn of(self, packet: &Packet, lane: usize) -> u32;
}

/// World tree: from the packet.
#[derive(Clone, Copy)]
struct OwnTag;

impl Tag for OwnTag {
    #[inline(always)]
    fn of(self, packet: &Packet, lane: usize) -> u32 {
        packet.instance[lane]
    }
}

/// Mesh tree: from the instance that the ray went into.
impl Tag for u32 {
    #[inline(always)]
    fn of(self, _: &Packet, _: usize) -> u32 {
        self
    }
}

/// A search in a tree in world space.
pub(crate) struct Query<'a, F, const ANY: bool> {
    pub accel: &'a Accel,
    pub level: &'a Level,
    pub ray: &'a Ray,
    pub prepared: Prepared,
    pub accept: &'a F,
    pub best: Best,
}

impl<F: Fn(u32, u32, f32, f32) -> bool, const ANY: bool> Visitor for Query<'_, F, ANY> {
    #[inline(always)]
    fn visit<S: Lanes>(&mut self, child: Child, t_max: &mut f32) -> bool {
        let done = if child & KIND == LEAF {
            let packet = &self.level.tree.packets[index(child)];
            self.best.test::<S, ANY>(packet, &self.prepared, OwnTag, self.accept)
        } else {
            self.enter::<S>(&self.level.placements[index(child)])
        };
        *t_max = self.best.t;
        done
    }
}

impl<F: Fn(u32, u32, f32, f32) -> bool, const ANY: bool> Query<'_, F, ANY> {
    /// Goes into an instance. Returns true when the search is over.
    #[inline(always)]
    fn enter<S: Lanes>(&mut self, placement: &Placement) -> bool {
        let tree = &self.accel.meshes[placement.tree as usize];
        let local = placement.to_mesh(self.ray, self.best.t);
        let Some(prepared) = Prepared::new(&local, &tree.bounds, &Slack::NONE) else { return false };
        let tag = placement.instance | if placement.alpha { ALPHA } else { 0 };
        let t_max = self.best.t;
        let mut inside = Inside::<_, ANY> {
            packets: &tree.packets,
            prepared: &prepared,
            tag,
            accept: self.accept,
            best: &mut self.best,
            done: false,
        };
        walk::<S, ANY>(tree, &prepared, t_max, &mut inside);
        inside.done
    }
}

/// A search in a mesh's tree.
struct Inside<'a, F, const ANY: bool> {
    packets: &'a [Packet],
    prepared: &'a Prepared,
    tag: u32,
    accept: &'a F,
    best: &'a mut Best,
    done: bool,
}

impl<F: Fn(u32, u32, f32, f32) -> bool, const ANY: bool> Visitor for Inside<'_, F, ANY> {
    #[inline(always)]
    fn visit<S: Lanes>(&mut self, child: Child, t_max: &mut f32) -> bool {
        let packet = &self.packets[index(child)];
        self.done = self.best.test::<S, ANY>(packet, self.prepared, self.tag, self.accept);
        *t_max = self.best.t;
        self.done
    }
}
