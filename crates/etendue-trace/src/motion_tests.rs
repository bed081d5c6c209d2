//! Trees made of those of another moment, against trees that are built anew, to the bit.

use crate::accel::Accel;
use crate::tests::{Rng, accept, bits, rays, scene};
use etendue_scene::{Mesh, Scene};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// What happens between two scenes.
type Step = fn(&mut Scene, &mut Rng);

fn wave(mesh: &mut Mesh, r: &mut Rng) {
    let phase = r.unit();
    mesh.positions
        .iter_mut()
        .for_each(|p| *p += Vec3::splat(0.05) * (p.yzx() * 2.0 + phase * 6.0).map(f32::sin));
}

trait Swizzle {
    fn yzx(self) -> Self;
}

impl Swizzle for Vec3 {
    fn yzx(self) -> Self {
        Self::new(self.y, self.z, self.x)
    }
}

/// Instance 0 stands by its triangles, the last one too; those between are placed.
const STEPS: [(&str, Step); 12] = [
    ("nothing", |_, _| ()),
    ("the last mesh is moved", |s, r| shift(s, usize::MAX, r)),
    ("and again", |s, r| shift(s, usize::MAX, r)),
    ("a placed one is moved", |s, r| shift(s, 2, r)),
    ("both are", |s, r| {
        shift(s, 2, r);
        shift(s, usize::MAX, r);
    }),
    ("the last mesh changes its shape", |s, r| wave(Arc::make_mut(&mut s.meshes[2]), r)),
    ("it loses a triangle's area", |s, _| {
        let m = Arc::make_mut(&mut s.meshes[2]);
        let [a, b, _] = m.indices[0];
        m.positions[b as usize] = m.positions[a as usize];
    }),
    ("it is blown up beyond what its tree can bear", |s, r| {
        let m = Arc::make_mut(&mut s.meshes[2]);
        m.positions.iter_mut().for_each(|p| *p = r.vec() * 4.0);
    }),
    ("a placed one goes far away", |s, _| s.instances[3].transform.translation.x += 900.0),
    ("its material gets alpha", |s, _| s.instances[2].material = Some(1)),
    ("it is flat", |s, _| s.instances[2].transform *= Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0))),
    ("one is gone", |s, _| drop(s.instances.remove(1))),
];

fn shift(s: &mut Scene, instance: usize, r: &mut Rng) {
    let instance = instance.min(s.instances.len() - 1);
    let turn = Affine3A::from_rotation_y(0.3 * r.unit());
    s.instances[instance].transform = turn * s.instances[instance].transform;
    s.instances[instance].transform.translation += glam::Vec3A::from(r.vec() * 0.3);
}

#[test]
fn scenes_that_follow_have_the_hits_of_their_own() {
    for (seed, triangles) in [(1u64, 12_000), (2, 900)] {
        let mut r = Rng(seed);
        let mut s = scene(seed, triangles, 4);
        let mut accel = Accel::build(&s);
        let mut split = 0;
        for (what, step) in STEPS {
            step(&mut s, &mut r);
            accel = accel.again(&s);
            let anew = Accel::build(&s);
            split += u32::from(accel.still_triangles() > 0);
            assert_eq!(accel.bounds(), anew.bounds(), "{what}");
            assert_eq!(accel.triangle_count(), anew.triangle_count(), "{what}");
            let mut hits = 0;
            for ray in rays(&mut Rng(seed ^ 7), 4000, &s) {
                let (a, b) = (accel.closest(&ray, &accept), anew.closest(&ray, &accept));
                assert_eq!(bits(a), bits(b), "{what}: {ray:?}");
                assert_eq!(accel.any(&ray, &accept), b.is_some(), "{what}: {ray:?}");
                hits += u32::from(b.is_some());
            }
            assert!(hits > 1000, "{what}: only {hits} hits");
        }
        assert_eq!(split > 5, triangles > 4096, "{split} of {} scenes had a tree at rest", STEPS.len());
    }
}

/// What stands still is the same memory from scene to scene, and what moves keeps its nodes.
#[test]
fn trees_are_kept() {
    let mut r = Rng(4);
    let mut s = scene(4, 12_000, 0);
    // Slivers lose and regain their area by rounding, and the tree is built anew then.
    let corners = (0..5000).flat_map(|_| [r.vec() * 4.0, r.vec() * 4.0, r.vec() * 4.0]);
    let mesh = Mesh { positions: corners.collect(), ..Mesh::default() };
    let indices = (0..5000).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    s.meshes[2] = Mesh { indices, ..mesh }.into();
    let mut accel = Accel::build(&s);
    let mut seen = Vec::new();
    for _ in 0..3 {
        shift(&mut s, 1, &mut r);
        accel = accel.again(&s);
        let still = accel.still_level().expect("there is something at rest");
        seen.push((still.tree.nodes.as_ptr(), still.tree.packets.as_ptr(), accel.own.tree.nodes.as_ptr()));
    }
    assert!(seen.windows(2).all(|w| w[0] == w[1]), "{seen:?}");
}
