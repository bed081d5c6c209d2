//! Rays against the triangles of a scene: build an [`Accel`] from a [`Scene`](etendue_scene::Scene), then ask it for
//! the nearest hit ([`Accel::closest`]) or for any ([`Accel::any`]).
//!
//! ```
//! use etendue_scene::{Instance, Mesh, Scene};
//! use etendue_trace::{Accel, Ray};
//! use glam::{Affine3A, Vec3, Vec3A};
//!
//! let mesh = Mesh {
//!     positions: vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(3.0, -1.0, 0.0), Vec3::new(-1.0, 3.0, 0.0)],
//!     indices: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! };
//! let instance = Instance { name: String::new(), mesh: 0, material: None, transform: Affine3A::IDENTITY };
//! let scene = Scene { meshes: vec![mesh.into()], instances: vec![instance], ..Scene::default() };
//! let accel = Accel::build(&scene);
//! let hit = accel.closest(&Ray::new(Vec3A::Z * 2.0, Vec3A::NEG_Z), &|_, _, _, _| true).unwrap();
//! assert_eq!((hit.t, hit.u, hit.v, hit.triangle), (2.0, 0.25, 0.25, 0));
//! ```
//!
//! # What is promised
//!
//! - **Watertight.** A ray through a shared edge or vertex of a closed mesh hits one of its triangles.
//! - **One answer.** The hit is a function of scene and ray: to the bit the same from the array, SSE2 and AVX2
//!   kernels, for any number of threads that built the tree, and from a loop over all triangles without any tree. Of
//!   equal distances the lowest (instance, triangle) wins.
//! - **No surprise.** Odd rays (NaN, zero, infinite) hit nothing; triangles without area and singular instances are
//!   not there; the traversal stack has a fixed size, which the depth limit of the builder makes enough.
//!
//! # How it is laid out
//!
//! Meshes that stand in one place are moved to world space into one tree, so that ordinary models pay nothing for
//! instancing; meshes that stand in several get a tree each, and the world's tree holds their instances beside the
//! triangles, so that one walk in order of distance meets both.
//!
//! | module | what |
//! |---|---|
//! | `build` | binary tree over boxes, binned SAH over three axes, parallel (Wald 2007) |
//! | `wide` | eight-wide tree of least SAH cost, by dynamic programming (Ylitie, Karras, Laine 2017, section 3.1) |
//! | `emit` | writes it out: nodes of 256 bytes (eight boxes in `f32`, component by component), packets of 384 bytes (up to eight triangles, their nine coordinates) |
//! | `triangle` | eight triangles at once: Woop, Benthin, Wald 2013, with their `f64` fallback |
//! | `traverse`, `query` | one ray, one stack; generic over `lanes`, instantiated inside `#[target_feature]` functions |
//! | `level`, `motion`, `refit` | trees in world space: of all instances, or from scene to scene of those that move and those that do not |
//! | `instance` | which meshes are shared, and rays into their space, in `f64` |
//! | `pages` | memory in huge pages where Linux gives them |
//!
//! # Why it is watertight, and why the tree does not matter
//!
//! The triangle test moves and shears vertices into the ray's frame in `f32` and then decides by the signs of edge
//! functions, which are exact for those moved vertices (an `f32` sign may collapse to zero but not turn; zeros are
//! decided in `f64`, where products of `f32` are exact). So it is an exact test of a slightly displaced mesh, whose
//! triangles still share their vertices; a closed mesh stays closed.
//!
//! A box test must not lose such a hit. With u = 2⁻²⁴ and R the largest coordinate in play (of origin, or box corner
//! minus origin), displacement is at most 6 u R, rounding in the box test 4 u R. The distance `t` carries 5 u R, and
//! where slivers or grazing rays could add more than 4 u R (the edge functions' rounding over the determinant, see
//! `triangle`), it is computed again in `f64`. All that is length along the axis at hand. Boxes are therefore grown by
//! 32 u R per ray, at no cost per box, by moving the origin that entry and exit planes are measured from. Hence
//! every box above a hit is entered before and left after the hit's computed `t`, whatever the tree, and culling by
//! distance, which keeps equal distances, cannot change the answer. (Ize 2013, "Robust BVH Ray Traversal", bounds
//! the box test's own rounding; the displacement is what it leaves out.)
//!
//! A ray's way into an instance and back multiplies these errors by at most the transform's condition number;
//! instances' boxes are grown by that much (up to a factor of 65,536; beyond it an instance's hits may depend on the
//! tree).
//!
//! # Measured
//!
//! Beside Embree 4.4, loaded at run time from the PyPI wheel `embreex` 4.4.0.post1, same meshes and rays, one thread, thread
//! CPU time, interleaved by chunks of 16k rays, the best of three repetitions, no `target-cpu`; AMD EPYC Zen 5, AVX2 kernels.
//! Mrays/s, and ratio to Embree's robust and plain mode at medium quality:
//!
//! | mesh | rays | here | Embree robust | ratio | Embree plain | ratio |
//! |---|---|---|---|---|---|---|
//! | room, 985,610 triangles | camera | 5.08 | 4.10 | 1.24 | 4.93 | 1.03 |
//! | | bounce | 2.88 | 2.47 | 1.17 | 2.91 | 0.99 |
//! | | random | 2.30 | 1.95 | 1.18 | 2.21 | 1.04 |
//! | | any: shadow | 4.31 | 3.42 | 1.26 | 4.21 | 1.02 |
//! | | any: random | 6.28 | 5.10 | 1.23 | 5.75 | 1.09 |
//! | soup, 200,000 thin triangles | camera | 1.24 | 0.84 | 1.48 | 1.17 | 1.06 |
//! | | bounce | 0.94 | 0.75 | 1.25 | 1.00 | 0.94 |
//! | | random | 0.80 | 0.65 | 1.23 | 0.88 | 0.91 |
//! | | any: shadow | 1.66 | 1.07 | 1.55 | 1.53 | 1.08 |
//! | | any: random | 1.04 | 0.74 | 1.41 | 1.08 | 0.96 |
//!
//! The room takes 81 bytes per triangle, the soup 99; while building, by count of its arrays, about 200 more. One thread
//! builds the room in 0.73 s, Embree in 0.41 s. Before prefetching, SSE2 kernels reached 0.9 of AVX2's
//! rate, arrays 0.7. For figures of one's own machine, on a generated mesh of the same kind, with build times:
//!
//! ```text
//! cargo run --release -p etendue-trace --example rays
//! ```
//!
//! What made a difference: prefetching every child that is hit (+15 % on incoherent rays), huge pages (+10 to 25 %
//! on the soup), fused box tests (+5 %), children sorted by half area per primitive for any-hit. Tried and not
//! kept: 32 bins (same rates, slower build); packets at 0.7 or 1.5 of a node's cost (same rates within noise);
//! closures in kernels (they do not inherit target features: half the rate). Not tried yet: spatial splits or
//! pre-splitting, which the soup would gain from, reinsertion, quantised boxes, AVX-512.

mod accel;
mod build;
mod emit;
mod instance;
mod lanes;
mod level;
mod motion;
#[cfg(test)]
mod motion_tests;
mod pages;
mod query;
mod ray;
mod refit;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;
mod wide;
mod wide_work;

pub use accel::{Accel, Kernel};
pub use pages::Pages;
pub use ray::{Hit, Ray};
pub use wide_work::{Work, run_wide};
