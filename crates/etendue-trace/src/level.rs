//! A tree in world space over some of a scene's instances.

use crate::build::Reference;
use crate::instance::Placement;
use crate::refit::Shape;
use crate::triangle::ALPHA;
use crate::wide::{Primitive, Tree, triangle_bounds};
use etendue_scene::{Bounds, Mesh, Scene};
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

/// Instances of meshes that stand in one place, by their triangles, and instances of others.
pub(crate) struct Level {
    pub tree: Tree,
    pub placements: Vec<Placement>,
    /// Instances whose triangles are in the tree.
    baked: Vec<u32>,
    /// The box around those triangles.
    triangle_bounds: Bounds,
    /// Coordinates up to which the boxes of instances allow for errors.
    covered: f32,
    shape: Shape,
}

/// Positions of a mesh's triangle.
pub(crate) fn corners(mesh: &Mesh, triangle: u32) -> [Vec3A; 3] {
    mesh.indices[triangle as usize].map(|i| mesh.positions[i as usize].into())
}

/// True if a triangle has an area worth the name: its edges are not parallel to within `f64` rounding, and its
/// normal does not vanish in `f32`. Others are left out of the trees.
pub(crate) fn has_area(p: &[Vec3A; 3]) -> bool {
    if !p.iter().all(|p| p.is_finite()) {
        return false;
    }
    let [a, b, c] = p.map(|p| DVec3::new(p.x as f64, p.y as f64, p.z as f64));
    let (e, f) = (b - a, c - a);
    let area = e.cross(f).length();
    area > 4.0 * f64::EPSILON * e.length() * f.length() && area >= f32::MIN_POSITIVE as f64
}

/// True if there is a triangle of that number, and all its vertices are there.
fn is_there(mesh: &Mesh, triangle: u32) -> bool {
    mesh.indices
        .get(triangle as usize)
        .is_some_and(|t| t.iter().all(|&i| (i as usize) < mesh.positions.len()))
}

/// A scene's triangles in world space.
#[derive(Clone, Copy)]
pub(crate) struct Places<'s>(pub &'s Scene);

impl Places<'_> {
    fn mesh(&self, instance: u32) -> &Mesh {
        &self.0.meshes[self.0.instances[instance as usize].mesh as usize]
    }

    fn corners(&self, instance: u32, triangle: u32) -> [Vec3A; 3] {
        let i = &self.0.instances[instance as usize];
        corners(self.mesh(instance), triangle).map(|p| i.transform.transform_point3a(p))
    }

    /// The corners, if the triangle can be hit.
    pub fn valid(&self, instance: u32, triangle: u32) -> Option<[Vec3A; 3]> {
        let mesh = self.mesh(instance);
        is_there(mesh, triangle).then(|| self.corners(instance, triangle)).filter(has_area)
    }

    /// The triangles of an instance that can be hit.
    fn triangles(self, instance: u32) -> impl ParallelIterator<Item = u32> {
        let n = self.mesh(instance).indices.len() as u32;
        (0..n).into_par_iter().filter(move |&t| self.valid(instance, t).is_some())
    }

    /// Whether the material of an instance has alpha.
    pub fn has_alpha(&self, instance: u32) -> bool {
        let material = self.0.instances[instance as usize].material;
        material.and_then(|m| self.0.materials.get(m as usize)).is_some_and(|m| m.has_alpha())
    }

    /// What a packet remembers of an instance.
    pub fn tag(&self, instance: u32) -> u32 {
        instance | if self.has_alpha(instance) { ALPHA } else { 0 }
    }
}

impl Level {
    pub const EMPTY: Self = Self {
        tree: Tree::EMPTY,
        placements: Vec::new(),
        baked: Vec::new(),
        triangle_bounds: Bounds::EMPTY,
        covered: 0.0,
        shape: Shape::EMPTY,
    };

    /// The tree over the instances `baked`, by their triangles, and over `placements` in the space that rays with coordinates
    /// up to `covered(b)` may come from, where `b` is the box around the triangles. `boxes` are those of the placements' trees.
    pub fn build(
        scene: &Scene,
        baked: Vec<u32>,
        placements: Vec<Placement>,
        boxes: &[Bounds],
        covered: impl FnOnce(&Bounds) -> f32,
    ) -> Self {
        let places = Places(scene);
        let mut triangles: Vec<(u32, u32)> = Vec::new();
        for &instance in &baked {
            triangles.par_extend(places.triangles(instance).map(|t| (instance, t)));
        }
        let mut refs: Vec<Reference> = triangles
            .par_iter()
            .enumerate()
            .map(|(n, &(i, t))| {
                let (lo, hi) = triangle_bounds(&places.corners(i, t));
                Reference::new(lo, hi, n as u32)
            })
            .collect();
        let first = triangles.len() as u32;
        let around =
            refs.iter().fold(Bounds::EMPTY, |b, r| Bounds { min: b.min.min(r.lo()), max: b.max.max(r.hi()) });
        let covered = covered(&around);
        for (n, p) in placements.iter().enumerate() {
            if let Some((lo, hi)) = p.world_bounds(&boxes[p.tree as usize], covered) {
                refs.push(Reference::new(lo, hi, first + n as u32));
            }
        }
        let mut tree = Tree::build(refs, first, &|id| {
            if id >= first {
                return Primitive::Instance(id - first);
            }
            let (instance, triangle) = triangles[id as usize];
            let vertices = places.corners(instance, triangle).map(|p| p.to_array());
            Primitive::Triangle { vertices, instance: places.tag(instance), triangle }
        });
        tree.triangles = u64::from(first);
        Self { tree, placements, baked, triangle_bounds: around, covered, shape: Shape::EMPTY }
    }

    /// Moves everything to where it is in `scene`, if the tree can keep its shape; returns whether it could. `placements`,
    /// `boxes` and `covered` as in [`Self::build`]. Afterwards the level holds what one that is built holds.
    pub fn refit(
        &mut self,
        scene: &Scene,
        baked: &[u32],
        placements: Vec<Placement>,
        boxes: &[Bounds],
        covered: impl FnOnce(&Bounds) -> f32,
    ) -> bool {
        let instances = |p: &Placement| p.instance;
        if self.baked != baked || !self.placements.iter().map(instances).eq(placements.iter().map(instances))
        {
            return false;
        }
        let places = Places(scene);
        // With as many triangles that can be hit as before, and those of the tree among them, they are the same.
        let count: u64 = baked.iter().map(|&i| places.triangles(i).count() as u64).sum();
        if count != self.tree.triangles {
            return false;
        }
        if self.shape.is_empty() {
            self.shape = Shape::of(&self.tree);
        }
        let Some(leaves) = self.tree.move_triangles(&places) else { return false };
        let around = leaves.iter().fold(Bounds::EMPTY, |b, l| b.union(*l));
        let covered = covered(&around);
        let place = |n: u32| {
            let p = &placements[n as usize];
            p.world_bounds(&boxes[p.tree as usize], covered).map(|(min, max)| Bounds { min, max })
        };
        let placed = (0..placements.len() as u32).filter(|&n| place(n).is_some()).count();
        if placed != self.shape.instances || !self.tree.refit(&leaves, &self.shape, place) {
            return false;
        }
        (self.placements, self.triangle_bounds, self.covered) = (placements, around, covered);
        true
    }

    /// Takes over placements that differ from those here in the numbers of their trees only. False if the level cannot stay: its
    /// boxes allow for errors of rays with coordinates up to less than `covered`.
    pub fn renumber(&mut self, placements: Vec<Placement>, covered: f32) -> bool {
        let fits = placements.is_empty() || covered <= self.covered;
        self.placements = placements;
        fits
    }

    /// The box around the triangles of instances that are not placed.
    pub fn triangle_bounds(&self) -> Bounds {
        self.triangle_bounds
    }

    pub fn bytes(&self) -> usize {
        self.tree.bytes() + self.placements.capacity() * size_of::<Placement>()
    }
}
