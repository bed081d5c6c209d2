//! Two levels: one tree in world space, and one for each mesh that stands in several places.

use crate::build::{MAX_DEPTH, Reference};
use crate::instance::{Placement, placements};
use crate::lanes::{Array, Lanes};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Avx2, Sse2};
use crate::query::{Best, NONE, Query};
use crate::ray::{Hit, Prepared, Ray, Slack};
use crate::traverse::{STACK, walk};
use crate::triangle::ALPHA;
use crate::wide::{Primitive, Tree, WIDTH, triangle_bounds};
use etendue_scene::{Bounds, Mesh, Scene};
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

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
    pub(crate) world: Tree,
    /// Trees in mesh space, of the meshes that stand in several places.
    pub(crate) meshes: Vec<Tree>,
    pub(crate) placements: Vec<Placement>,
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

/// Positions of a mesh's triangle.
fn corners(mesh: &Mesh, triangle: u32) -> [Vec3A; 3] {
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

impl Accel {
    /// Builds the trees, with rayon's threads. The result does not depend on how many there are.
    ///
    /// A mesh used by one instance goes into the world's tree; one used by several gets a tree of its own. Triangles
    /// without area, with a vertex that is not finite or an index out of range, and instances with a singular
    /// transform are left out.
    pub fn build(scene: &Scene) -> Accel {
        let mut users = vec![0u32; scene.meshes.len()];
        for i in &scene.instances {
            if let Some(n) = users.get_mut(i.mesh as usize) {
                *n += 1;
            }
        }
        let (mut placements, baked, shared) = placements(scene, &users);

        let meshes: Vec<Tree> = shared.par_iter().map(|&m| mesh_tree(&scene.meshes[m as usize])).collect();
        let has_alpha = |instance: usize| {
            scene.instances[instance]
                .material
                .and_then(|m| scene.materials.get(m as usize))
                .is_some_and(|m| m.has_alpha())
        };

        // World references: the baked triangles by running number, then the placed instances.
        let world_corners = |instance: u32, triangle: u32| {
            let i = &scene.instances[instance as usize];
            corners(&scene.meshes[i.mesh as usize], triangle).map(|p| i.transform.transform_point3a(p))
        };
        let mut triangles: Vec<(u32, u32)> = Vec::new();
        for &instance in &baked {
            let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
            triangles.par_extend((0..mesh.indices.len() as u32).into_par_iter().filter_map(|t| {
                let valid = mesh.indices[t as usize].iter().all(|&i| (i as usize) < mesh.positions.len());
                (valid && has_area(&world_corners(instance, t))).then_some((instance, t))
            }));
        }
        let mut refs: Vec<Reference> = triangles
            .par_iter()
            .enumerate()
            .map(|(n, &(i, t))| {
                let (lo, hi) = triangle_bounds(&world_corners(i, t));
                Reference::new(lo, hi, n as u32)
            })
            .collect();
        let first = triangles.len() as u32;
        let mut count = triangles.len() as u64;
        let mut reach = refs.iter().fold(0f32, |m, r| m.max(r.lo().abs().max(r.hi().abs()).max_element()));
        for p in &placements {
            if let Some((lo, hi)) = p.world_bounds(&meshes[p.tree as usize].bounds, 0.0) {
                reach = reach.max(lo.abs().max(hi.abs()).max_element());
            }
        }
        let slack = Slack::new(&placements, reach);
        for (n, p) in placements.iter_mut().enumerate() {
            let tree = &meshes[p.tree as usize];
            p.alpha = has_alpha(p.instance as usize);
            if let Some((lo, hi)) = p.world_bounds(&tree.bounds, slack.covered) {
                refs.push(Reference::new(lo, hi, first + n as u32));
                count += tree.triangles;
            }
        }
        let world = Tree::build(refs, first, &|id| {
            if id >= first {
                return Primitive::Instance(id - first);
            }
            let (instance, triangle) = triangles[id as usize];
            let alpha = if has_alpha(instance as usize) { ALPHA } else { 0 };
            let vertices = world_corners(instance, triangle).map(|p| p.to_array());
            Primitive::Triangle { vertices, instance: instance | alpha, triangle }
        });
        assert!(world.stack <= STACK && meshes.iter().all(|m| m.stack <= STACK), "bounded by MAX_DEPTH");
        Accel { world, meshes, placements, slack, triangles: count, kernel: Kernel::available()[0] }
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
        self.world.bounds
    }

    #[cfg(test)]
    pub(crate) fn mesh_bounds(&self, p: &Placement) -> Bounds {
        self.meshes[p.tree as usize].bounds
    }

    /// Memory held by trees, triangles and instances.
    pub fn bytes(&self) -> usize {
        self.world.bytes()
            + self.meshes.iter().map(Tree::bytes).sum::<usize>()
            + self.placements.capacity() * size_of::<Placement>()
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
        let prepared = Prepared::new(ray, &self.world.bounds, &self.slack)?;
        let best = Best { t: ray.t_max, u: 0.0, v: 0.0, key: NONE };
        let mut query =
            Query::<_, ANY> { accel: self, packets: &self.world.packets, ray, prepared, accept, best };
        walk::<S, ANY>(&self.world, &prepared, ray.t_max, &mut query);
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
