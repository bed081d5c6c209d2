//! Two levels: one tree in world space, and one for each mesh that stands in several places.

use crate::build::{MAX_DEPTH, Reference};
#[cfg(test)]
use crate::instance::Placement;
use crate::instance::placements;
use crate::lanes::{Array, Lanes};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Avx2, Sse2};
use crate::level::{Level, Places, corners, has_area};
use crate::motion::{self, Levels, State};
use crate::query::{Best, NONE, Query};
use crate::ray::{Hit, Prepared, Ray, Slack};
use crate::traverse::{STACK, walk};
use crate::wide::{Primitive, Tree, WIDTH, triangle_bounds};
use etendue_scene::{Bounds, Mesh, Scene};
use rayon::prelude::*;
use std::sync::{Arc, Weak};

const _: () = assert!(MAX_DEPTH * (WIDTH - 1) < STACK);

/// Which implementation of the kernels to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kernel {
    /// Plain arrays: every machine.
    Array,
    /// SSE2: every x86-64.
    #[cfg(target_arch = "x86_64")]
    Sse2,
    /// AVX2 and FMA: x86-64 where the processor has it.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Kernel {
    /// The kernels that this machine can run, the fastest first.
    pub fn available() -> Vec<Kernel> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            if crate::wide_work::has_avx2() {
                all.push(Kernel::Avx2);
            }
            all.push(Kernel::Sse2);
        }
        all.push(Kernel::Array);
        all
    }
}

/// The scene's triangles, ready to be hit by rays. See the crate's documentation for how it is laid out.
pub struct Accel {
    /// What moves; everything, if nothing is known of that.
    pub(crate) own: Level,
    /// What has stood still from scene to scene.
    still: Option<Level>,
    /// Trees in mesh space, of the meshes that stand in several places.
    pub(crate) meshes: Vec<Tree>,
    /// What they are of.
    sources: Vec<Weak<Mesh>>,
    /// Per instance.
    states: Vec<State>,
    bounds: Bounds,
    slack: Slack,
    triangles: u64,
    kernel: Kernel,
}

impl std::fmt::Debug for Accel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Accel")
            .field("triangles", &self.triangles)
            .field("bytes", &self.bytes())
            .field("kernel", &self.kernel)
            .finish_non_exhaustive()
    }
}

impl Accel {
    /// Builds the trees, with rayon's threads. The result does not depend on how many there are.
    ///
    /// A mesh used by one instance goes into the world's tree; one used by several gets a tree of its own. Triangles
    /// without area, with a vertex that is not finite or an index out of range, and instances with a singular
    /// transform are left out.
    pub fn build(scene: &Scene) -> Accel {
        let empty = Accel {
            own: Level::EMPTY,
            still: None,
            meshes: Vec::new(),
            sources: Vec::new(),
            states: Vec::new(),
            bounds: Bounds::EMPTY,
            slack: Slack::NONE,
            triangles: 0,
            kernel: Kernel::available()[0],
        };
        empty.again(scene)
    }

    /// The trees of `scene`, made of those of another moment: what did not move stays in a tree that is not touched, what did
    /// has one of its own, which keeps its shape where that will do. Meshes are the same if they are the same [`std::sync::Arc`].
    /// The hits are those of [`Accel::build`], to the bit.
    pub fn again(self, scene: &Scene) -> Accel {
        let Accel { own, still, mut meshes, mut sources, states: before, kernel, .. } = self;
        let mut users = vec![0u32; scene.meshes.len()];
        for i in &scene.instances {
            if let Some(n) = users.get_mut(i.mesh as usize) {
                *n += 1;
            }
        }
        let (mut placements, baked, shared) = placements(scene, &users);
        placements.iter_mut().for_each(|p| p.alpha = Places(scene).has_alpha(p.instance));
        let mut known: Vec<Option<Tree>> = meshes.drain(..).map(Some).collect();
        let kept = |m: &u32| {
            let same = |w: &Weak<Mesh>| std::ptr::eq(w.as_ptr(), Arc::as_ptr(&scene.meshes[*m as usize]));
            sources.iter().position(same).and_then(|n| known[n].take())
        };
        let kept: Vec<Option<Tree>> = shared.iter().map(kept).collect();
        meshes = shared
            .par_iter()
            .zip(kept)
            .map(|(&m, kept)| kept.unwrap_or_else(|| mesh_tree(&scene.meshes[m as usize])))
            .collect();
        sources = shared.iter().map(|&m| Arc::downgrade(&scene.meshes[m as usize])).collect();
        let boxes: Vec<Bounds> = meshes.iter().map(|m| m.bounds).collect();

        let states = motion::states(scene, &users, &before);
        let levels = Levels { scene, baked, placements, boxes: &boxes };
        let (own, still) = levels.make(own, still, &before, &states);
        let placements = &levels.placements;
        let around =
            own.triangle_bounds().union(still.as_ref().map_or(Bounds::EMPTY, Level::triangle_bounds));
        let slack = levels.slack(&around);
        let mut bounds = around;
        let mut triangles = own.tree.triangles + still.as_ref().map_or(0, |s| s.tree.triangles);
        for p in placements {
            let tree = &meshes[p.tree as usize];
            if let Some((min, max)) = p.world_bounds(&tree.bounds, slack.covered) {
                bounds = bounds.union(Bounds { min, max });
                triangles += tree.triangles;
            }
        }
        let trees = meshes.iter().chain([&own.tree]).chain(still.as_ref().map(|s| &s.tree));
        assert!(trees.map(|t| t.stack).all(|s| s <= STACK), "bounded by MAX_DEPTH");
        Accel { own, still, meshes, sources, states, bounds, slack, triangles, kernel }
    }

    /// The same trees with a chosen kernel, for tests and measurements; the hits are the same to the bit.
    /// A kernel that this machine cannot run is replaced by the best it can.
    pub fn with_kernel(mut self, kernel: Kernel) -> Self {
        let all = Kernel::available();
        self.kernel = if all.contains(&kernel) { kernel } else { all[0] };
        self
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// World-space box around everything that can be hit; empty if nothing can.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    #[cfg(test)]
    pub(crate) fn still_level(&self) -> Option<&Level> {
        self.still.as_ref()
    }

    #[cfg(test)]
    pub(crate) fn mesh_bounds(&self, p: &Placement) -> Bounds {
        self.meshes[p.tree as usize].bounds
    }

    /// Memory held by trees, triangles and instances.
    pub fn bytes(&self) -> usize {
        let levels = self.own.bytes() + self.still.as_ref().map_or(0, Level::bytes);
        levels + self.meshes.iter().map(Tree::bytes).sum::<usize>()
    }

    /// Triangles that stood still, and are in a tree of their own; see [`Accel::again`].
    pub fn still_triangles(&self) -> u64 {
        self.still.as_ref().map_or(0, |s| s.tree.triangles)
    }

    /// Triangles that can be hit; each instance counts its mesh's.
    pub fn triangle_count(&self) -> u64 {
        self.triangles
    }

    /// The nearest hit; of several at the same `t` the one with the lowest (instance, triangle).
    ///
    /// Triangles of instances whose material has alpha count only if `accept(instance, triangle, u, v)` says so; it
    /// must be a pure function. Others are never asked about.
    #[inline]
    pub fn closest(&self, ray: &Ray, accept: &impl Fn(u32, u32, f32, f32) -> bool) -> Option<Hit> {
        match self.kernel {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Kernel::available` has found the features.
            Kernel::Avx2 => unsafe { self.closest_avx2(ray, accept) },
            #[cfg(target_arch = "x86_64")]
            Kernel::Sse2 => self.closest_with::<Sse2>(ray, accept),
            Kernel::Array => self.closest_with::<Array>(ray, accept),
        }
    }

    /// True if there is any hit. `accept` as in [`Accel::closest`].
    #[inline]
    pub fn any(&self, ray: &Ray, accept: &impl Fn(u32, u32, f32, f32) -> bool) -> bool {
        match self.kernel {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Kernel::available` has found the features.
            Kernel::Avx2 => unsafe { self.any_avx2(ray, accept) },
            #[cfg(target_arch = "x86_64")]
            Kernel::Sse2 => self.any_with::<Sse2>(ray, accept),
            Kernel::Array => self.any_with::<Array>(ray, accept),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn closest_avx2(&self, ray: &Ray, accept: &impl Fn(u32, u32, f32, f32) -> bool) -> Option<Hit> {
        self.closest_with::<Avx2>(ray, accept)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn any_avx2(&self, ray: &Ray, accept: &impl Fn(u32, u32, f32, f32) -> bool) -> bool {
        self.any_with::<Avx2>(ray, accept)
    }

    #[inline(always)]
    fn closest_with<S: Lanes>(&self, ray: &Ray, accept: &impl Fn(u32, u32, f32, f32) -> bool) -> Option<Hit> {
        let best = self.search::<S, false>(ray, accept)?;
        (best.key != NONE).then_some(Hit {
            t: best.t,
            u: best.u,
            v: best.v,
            instance: (best.key >> 32) as u32,
            triangle: best.key as u32,
        })
    }

    #[inline(always)]
    fn any_with<S: Lanes>(&self, ray: &Ray, accept: &impl Fn(u32, u32, f32, f32) -> bool) -> bool {
        self.search::<S, true>(ray, accept).is_some_and(|b| b.key != NONE)
    }

    #[inline(always)]
    fn search<S: Lanes, const ANY: bool>(
        &self,
        ray: &Ray,
        accept: &impl Fn(u32, u32, f32, f32) -> bool,
    ) -> Option<Best> {
        let prepared = Prepared::new(ray, &self.bounds, &self.slack)?;
        let best = Best { t: ray.t_max, u: 0.0, v: 0.0, key: NONE };
        let mut query = Query::<_, ANY> { accel: self, level: &self.own, ray, prepared, accept, best };
        let mut next = self.still.as_ref();
        loop {
            walk::<S, ANY>(&query.level.tree, &prepared, query.best.t, &mut query);
            match next.take() {
                Some(still) if !(ANY && query.best.key != NONE) => query.level = still,
                _ => break,
            }
        }
        Some(query.best)
    }
}

/// The tree of a mesh in its own space.
fn mesh_tree(mesh: &Mesh) -> Tree {
    let valid: Vec<u32> = (0..mesh.indices.len() as u32)
        .into_par_iter()
        .filter(|&t| {
            mesh.indices[t as usize].iter().all(|&i| (i as usize) < mesh.positions.len())
                && has_area(&corners(mesh, t))
        })
        .collect();
    let refs = valid
        .par_iter()
        .map(|&t| {
            let (lo, hi) = triangle_bounds(&corners(mesh, t));
            Reference::new(lo, hi, t)
        })
        .collect();
    let mut tree = Tree::build(refs, u32::MAX, &|t| Primitive::Triangle {
        vertices: corners(mesh, t).map(|p| p.to_array()),
        instance: 0,
        triangle: t,
    });
    tree.triangles = valid.len() as u64;
    tree
}
