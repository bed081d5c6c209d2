//! From one scene to the next: what stands still, and what moves.

use crate::instance::Placement;
use crate::level::{Level, Places};
use crate::ray::Slack;
use etendue_scene::{Bounds, Mesh, Scene};
use glam::Affine3A;
use std::sync::{Arc, Weak};

/// Below this many triangles two trees cost rays more than one tree costs a moment.
const FEW: u64 = 4096;

/// Rays' errors are allowed for so many times farther out than the scene that the tree was built for needs, so that things
/// may move outwards.
const ROOM: f32 = 2.0;

/// All of an instance that its level depends on.
#[derive(Clone)]
pub(crate) struct State {
    mesh: Weak<Mesh>,
    transform: Affine3A,
    alpha: bool,
    /// The mesh stands in several places.
    shared: bool,
    /// It has been seen to move.
    moves: bool,
}

impl State {
    fn is(&self, o: &Self) -> bool {
        self.mesh.ptr_eq(&o.mesh)
            && self.transform == o.transform
            && (self.alpha, self.shared) == (o.alpha, o.shared)
    }
}

/// The instances of `scene`, whose meshes have so many `users`; they are the ones that were `before` if they are as many.
pub(crate) fn states(scene: &Scene, users: &[u32], before: &[State]) -> Vec<State> {
    let comparable = before.len() == scene.instances.len();
    let state = |(n, i): (usize, &etendue_scene::Instance)| {
        let mut now = State {
            mesh: scene.meshes.get(i.mesh as usize).map_or_else(Weak::new, Arc::downgrade),
            transform: i.transform,
            alpha: Places(scene).has_alpha(n as u32),
            shared: users.get(i.mesh as usize).is_some_and(|u| *u > 1),
            moves: false,
        };
        now.moves = comparable && (before[n].moves || !before[n].is(&now));
        now
    };
    scene.instances.iter().enumerate().map(state).collect()
}

/// What levels are made of.
pub(crate) struct Levels<'a> {
    pub scene: &'a Scene,
    /// Instances that are there by their triangles.
    pub baked: Vec<u32>,
    /// The others.
    pub placements: Vec<Placement>,
    /// Per tree of a mesh.
    pub boxes: &'a [Bounds],
}

impl Levels<'_> {
    /// What rays are to be allowed in a world with the box `around` the triangles that are not placed.
    pub fn slack(&self, around: &Bounds) -> Slack {
        let largest = |b: &Bounds| b.min.abs().max(b.max.abs()).max_element();
        let mut reach = if around.is_empty() { 0.0 } else { largest(around) };
        for p in &self.placements {
            if let Some((min, max)) = p.world_bounds(&self.boxes[p.tree as usize], 0.0) {
                reach = reach.max(largest(&Bounds { min, max }));
            }
        }
        Slack::new(&self.placements, reach)
    }

    /// The instances of one level.
    fn part(&self, which: impl Fn(u32) -> bool) -> (Vec<u32>, Vec<Placement>) {
        let baked = self.baked.iter().copied().filter(|&i| which(i)).collect();
        (baked, self.placements.iter().filter(|p| which(p.instance)).cloned().collect())
    }

    fn triangles(&self, instances: &[u32]) -> u64 {
        let of = |&i: &u32| {
            let mesh = self.scene.instances[i as usize].mesh;
            self.scene.meshes[mesh as usize].indices.len() as u64
        };
        instances.iter().map(of).sum()
    }

    /// A box around the vertices of instances.
    fn around(&self, instances: &[u32]) -> Bounds {
        let mut all = Bounds::EMPTY;
        for &i in instances {
            let i = &self.scene.instances[i as usize];
            let points = self.scene.meshes[i.mesh as usize].positions.iter();
            let points = points.map(|p| i.transform.transform_point3a((*p).into()));
            points.filter(|p| p.is_finite()).for_each(|p| all.include(p));
        }
        all
    }

    /// The level of some instances beside others in the box `beside`, made of what it was before if that will do.
    fn level(&self, before: Option<Level>, which: impl Fn(u32) -> bool, beside: Bounds) -> Level {
        let (baked, placements) = self.part(which);
        let covered = |b: &Bounds| self.slack(&b.union(beside)).covered;
        if let Some(mut level) = before
            && level.refit(self.scene, &baked, placements.clone(), self.boxes, covered)
        {
            return level;
        }
        Level::build(self.scene, baked, placements, self.boxes, covered)
    }

    /// The level of what moves, and that of what does not, made of those of the scene `before`.
    pub fn make(
        &self,
        own: Level,
        still: Option<Level>,
        before: &[State],
        now: &[State],
    ) -> (Level, Option<Level>) {
        if before.len() != now.len() || before.is_empty() {
            return (self.level(None, |_| true, Bounds::EMPTY), None);
        }
        if now.iter().zip(before).all(|(a, b)| a.is(b)) {
            return (own, still);
        }
        let moves = |i: u32| now[i as usize].moves;
        let (moving, _) = self.part(moves);
        let (resting, placed) = self.part(|i| !moves(i));
        let count = self.triangles(&resting) + FEW / 8 * placed.len() as u64;
        if count < FEW || count < self.triangles(&moving) / 4 {
            return (self.level(Some(own), |_| true, Bounds::EMPTY), None);
        }
        let same = now.iter().zip(before).all(|(a, b)| a.moves == b.moves);
        let mut still = still.filter(|_| same).unwrap_or_else(|| {
            let beside = self.around(&moving);
            let covered = |b: &Bounds| ROOM * self.slack(&b.union(beside)).covered;
            Level::build(self.scene, resting.clone(), placed.clone(), self.boxes, covered)
        });
        let own = self.level(Some(own), moves, still.triangle_bounds());
        let covered = self.slack(&own.triangle_bounds().union(still.triangle_bounds())).covered;
        if !still.renumber(placed.clone(), covered) {
            still = Level::build(self.scene, resting, placed, self.boxes, |_| ROOM * covered);
        }
        (own, Some(still))
    }
}
