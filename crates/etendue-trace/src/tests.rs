//! Trees against a loop over all triangles, kernels against each other, to the bit.

use crate::accel::{Accel, Kernel};
use crate::instance::placements;
use crate::lanes::Array;
use crate::ray::{Hit, Prepared, Ray, Slack};
use crate::triangle::Packet;
use etendue_scene::{AlphaMode, Instance, Material, Mesh, Scene};
use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Rng(pub u64);

impl Rng {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    /// In the cube from −1 to 1.
    pub fn vec(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// Small and large triangles, slivers, degenerate ones, a lattice (many equal `t`), coincident copies.
fn mesh(r: &mut Rng, n: usize) -> Mesh {
    let mut m = Mesh::default();
    for i in 0..n {
        let c = r.vec() * 4.0;
        let corners = match i % 8 {
            0 => [c, c + r.vec() * 0.3, c + r.vec() * 0.3],
            1 => [c, c + r.vec() * 4.0, c + r.vec() * 4.0],
            2 => [c, c + r.vec() * 3.0, c + r.vec() * 1e-3],
            3 => {
                let d = r.vec() * 3.0;
                [c, c + d, c + d * 0.5 + r.vec() * 1e-5]
            }
            4 => [c.round(), (c + r.vec() * 2.0).round(), (c + r.vec() * 2.0).round()],
            5 => [c.round(), c.round() + Vec3::X, c.round() + Vec3::Z],
            6 if i > 40 => m.indices[r.below(i - 1)].map(|k| m.positions[k as usize]),
            _ => [c, c, c + r.vec()],
        };
        let k = m.positions.len() as u32;
        m.positions.extend(corners);
        m.indices.push([k, k + 1, k + 2]);
    }
    m
}

fn transform(r: &mut Rng, kind: usize) -> Affine3A {
    let q = Quat::from_euler(glam::EulerRot::XYZ, r.unit() * 6.0, r.unit() * 6.0, r.unit() * 6.0);
    let scale = match kind % 5 {
        0 => Vec3::ONE,
        1 => Vec3::new(-0.5, 0.5, 0.5),
        2 => Vec3::new(0.2, 1.5, 0.7),
        3 => Vec3::new(0.01, 1.0, 0.4),
        _ => Vec3::new(1.0, 0.0, 1.0),
    };
    let mut a = Affine3A::from_scale_rotation_translation(scale, q, r.vec() * 5.0);
    if kind % 7 == 3 {
        // Shear, as a parent's uneven scale gives.
        a.matrix3 = Mat3A::from_diagonal(Vec3::new(1.0, 3.0, 1.0)) * a.matrix3;
    }
    a
}

pub(crate) fn scene(seed: u64, triangles: usize, instances: usize) -> Scene {
    let mut r = Rng(seed);
    let mut s = Scene::default();
    let glass = Material { alpha_mode: AlphaMode::Blend, ..Material::default() };
    s.materials = vec![Material::default(), glass];
    for k in 0..3 {
        s.meshes.push(mesh(&mut r, triangles / (k + 1)).into());
    }
    let mut place = |mesh, transform, material| {
        s.instances.push(Instance { name: String::new(), mesh, material, transform });
    };
    place(0, Affine3A::IDENTITY, None);
    for i in 0..instances {
        let t = transform(&mut r, i);
        place(1, t, Some((i % 3 == 0) as u32));
    }
    let t = transform(&mut r, 2);
    place(2, t, Some(1));
    s
}

pub(crate) fn rays(r: &mut Rng, n: usize, scene: &Scene) -> Vec<Ray> {
    (0..n)
        .map(|i| {
            let origin = match i % 5 {
                0 => r.vec() * 20.0,
                1 => r.vec().round() * 4.0,
                _ => r.vec() * 5.0,
            };
            let m = &scene.meshes[0];
            let target = m.positions[r.below(m.positions.len())];
            let direction = match i % 4 {
                0 => r.vec(),
                1 => target - origin,
                2 => r.vec().round(),
                _ => (target.lerp(m.positions[r.below(m.positions.len())], r.unit())) - origin,
            };
            let t_min = if i % 3 == 0 { r.unit() } else { 0.0 };
            let t_max = if i % 7 == 0 { r.unit() * 9.0 } else { f32::INFINITY };
            Ray { origin: origin.into(), direction: direction.into(), t_min, t_max }
        })
        .collect()
}

pub(crate) fn accept(_: u32, triangle: u32, u: f32, _: f32) -> bool {
    triangle.is_multiple_of(2) || u < 0.5
}

/// Every triangle of every instance, one after the other, with the same test and no tree.
fn brute(scene: &Scene, accel: &Accel, ray: &Ray) -> Option<Hit> {
    let mut users = vec![0; scene.meshes.len()];
    scene.instances.iter().for_each(|i| users[i.mesh as usize] += 1);
    let (placed, baked, _) = placements(scene, &users);
    let world = Prepared::new(ray, &accel.bounds(), &Slack::NONE)?;
    let mut best: Option<Hit> = None;
    for (n, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let placement = placed.iter().find(|p| p.instance == n as u32);
        if placement.is_none() && !baked.contains(&(n as u32)) {
            continue;
        }
        let prepared = match placement {
            None => world,
            Some(p) => match Prepared::new(&p.to_mesh(ray, ray.t_max), &accel.mesh_bounds(p), &Slack::NONE) {
                Some(prepared) => prepared,
                None => continue,
            },
        };
        for (t, corners) in mesh.indices.iter().enumerate() {
            let corners = corners.map(|i| Vec3A::from(mesh.positions[i as usize]));
            let corners = if placement.is_some() {
                corners
            } else {
                corners.map(|p| instance.transform.transform_point3a(p))
            };
            if !crate::level::has_area(&corners) {
                continue;
            }
            let mut packet = Packet::empty();
            packet.set(5, corners.map(|p| p.to_array()), 0, 0);
            let Some(mut candidates) = packet.intersect::<Array>(&prepared, ray.t_max) else { continue };
            while let Some((_, at, u, v)) = candidates.next(&packet, &prepared, ray.t_max) {
                let hit = Hit { t: at, u, v, instance: n as u32, triangle: t as u32 };
                let alpha = instance.material == Some(1);
                let nearer = best.is_none_or(|b| at < b.t);
                if nearer && (!alpha || accept(n as u32, t as u32, u, v)) {
                    best = Some(hit);
                }
            }
        }
    }
    best
}

pub(crate) fn bits(h: Option<Hit>) -> Option<(u32, u32, u32, u32, u32)> {
    h.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.instance, h.triangle))
}

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

#[test]
fn trees_agree_with_a_loop_over_all_triangles() {
    let (scenes, n) = if full() { (60, 20_000) } else { (12, 1500) };
    let mut hits = 0;
    for seed in 0..scenes {
        let s = scene(seed, [40, 150, 400][seed as usize % 3], [0, 2, 7, 30][seed as usize % 4]);
        let accel = Accel::build(&s);
        for (i, ray) in rays(&mut Rng(seed ^ 99), n, &s).iter().enumerate() {
            let (a, b) = (accel.closest(ray, &accept), brute(&s, &accel, ray));
            assert_eq!(bits(a), bits(b), "scene {seed}, ray {i}: {ray:?}: {a:?} against {b:?}");
            assert_eq!(accel.any(ray, &accept), b.is_some(), "any-hit: scene {seed}, ray {i}: {ray:?}");
            hits += b.is_some() as usize;
        }
    }
    assert!(hits * 4 > n * scenes as usize, "only {hits} hits: the rays test nothing");
}

#[test]
fn kernels_agree_to_the_bit() {
    let (scenes, n) = if full() { (40, 400_000) } else { (6, 30_000) };
    for seed in 0..scenes {
        let s = scene(1000 + seed, 6000, [0, 50][seed as usize % 2]);
        let rays = rays(&mut Rng(seed), n, &s);
        let mut accel = Accel::build(&s);
        let mut expected: Vec<(Option<Hit>, bool)> = Vec::new();
        for kernel in Kernel::available() {
            accel = accel.with_kernel(kernel);
            assert_eq!(accel.kernel(), kernel);
            let found = rays.iter().map(|r| (accel.closest(r, &accept), accel.any(r, &accept)));
            if expected.is_empty() {
                expected = found.collect();
                continue;
            }
            for ((a, e), r) in found.zip(&expected).zip(&rays) {
                assert_eq!((bits(a.0), a.1), (bits(e.0), e.1), "{kernel:?}: {r:?}");
            }
        }
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let s = scene(5, 40_000, 60);
    let tree = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let accel = pool.install(|| Accel::build(&s));
        // Bytes, since unused lanes hold NaN.
        let bytes = |t: &crate::wide::Tree| {
            let nodes: &[u8] = bytemuck::cast_slice(&t.nodes);
            let packets: &[u8] = bytemuck::cast_slice(&t.packets);
            [nodes, packets].concat()
        };
        std::iter::once(&accel.own.tree).chain(&accel.meshes).map(bytes).collect::<Vec<_>>()
    };
    let one = tree(1);
    assert!(one.iter().all(|t| !t.is_empty()));
    for threads in [2, 7] {
        assert!(tree(threads) == one, "{threads} threads");
    }
}
