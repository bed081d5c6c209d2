//! Build time and rays per second on a generated mesh: a closed room with bumpy spheres.
//!
//!     cargo run --release -p etendue-trace --example rays [TRIANGLES]
//!
//! Coherent rays are a camera's; incoherent ones start at what the camera sees (bounce) or anywhere (random).

use etendue_scene::{Instance, Mesh, Scene};
use etendue_trace::{Accel, Ray};
use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};
use std::time::Instant;

/// Rays per set.
const RAYS: u64 = 1 << 18;

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Rng(u64);

impl Rng {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
    fn between(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }
    fn direction(&mut self) -> Vec3A {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = self.between(0.0, TAU).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3A::new(r * cos, r * sin, z)
    }
}

/// Adds a surface over the unit square, `n` × `n` quads.
fn grid(m: &mut Mesh, n: u32, f: impl Fn(f32, f32) -> Vec3) {
    let base = m.positions.len() as u32;
    m.positions.extend(
        (0..=n)
            .flat_map(|j| (0..=n).map(move |i| (i, j)))
            .map(|(i, j)| f(i as f32 / n as f32, j as f32 / n as f32)),
    );
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let a = base + j * (n + 1) + i;
        m.indices.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
    }
}

/// A room of 20 × 10 × 20 m with 200 spheres, of about the given number of triangles.
fn room(triangles: u32) -> Mesh {
    let mut m = Mesh::default();
    let mut r = Rng(7);
    let n = ((triangles as f32 / 2.0 / 201.0).sqrt() as u32).max(2);
    let wave = |p: Vec3| (p.x * 3.1 + p.y).sin() * (p.y * 2.7 - p.z).sin() * (p.z * 3.3 + p.x).cos();
    grid(&mut m, n, |u, v| {
        let p = Vec3::new(20.0 * u - 10.0, 0.0, 20.0 * v - 10.0);
        p + Vec3::Y * 0.3 * wave(p)
    });
    let ceiling = |u: f32, v: f32| Vec3::new(20.0 * u - 10.0, 10.0, 20.0 * v - 10.0);
    grid(&mut m, 1, ceiling);
    for s in [-10.0, 10.0] {
        grid(&mut m, 1, |u, v| Vec3::new(s, 11.0 * u - 1.0, 20.0 * v - 10.0));
        grid(&mut m, 1, |u, v| Vec3::new(20.0 * v - 10.0, 11.0 * u - 1.0, s));
    }
    for _ in 0..200 {
        let c = Vec3::new(r.between(-9.0, 9.0), r.between(0.7, 8.2), r.between(-9.0, 9.0));
        let (radius, phase) = (r.between(0.35, 0.95), r.between(0.0, 9.0));
        grid(&mut m, n, |u, v| {
            let d =
                Vec3::new((v * PI).sin() * (u * TAU).cos(), (v * PI).cos(), (v * PI).sin() * (u * TAU).sin());
            c + d * radius * (1.0 + 0.15 * wave(d * 4.0 + phase))
        });
    }
    m
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

fn main() {
    let triangles = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(1_000_000);
    let instance = Instance { name: String::new(), mesh: 0, material: None, transform: Affine3A::IDENTITY };
    let scene = Scene { meshes: vec![room(triangles).into()], instances: vec![instance], ..Scene::default() };
    let all = std::thread::available_parallelism().map_or(1, |n| n.get());
    let count = scene.triangle_count();
    for threads in [1, all] {
        let pool = pool(threads);
        let seconds = |_| {
            let start = Instant::now();
            pool.install(|| Accel::build(&scene));
            start.elapsed().as_secs_f64()
        };
        let best = (0..3).map(seconds).fold(f64::INFINITY, f64::min);
        println!(
            "build, {threads} threads: {best:.3} s, {:.3} s per million triangles",
            best / count as f64 * 1e6
        );
    }
    let accel = Accel::build(&scene);
    println!(
        "{count} triangles, {:.1} bytes each; {:?}",
        accel.bytes() as f64 / count as f64,
        accel.kernel()
    );

    let opaque = |_: u32, _: u32, _: f32, _: f32| true;
    let side = (RAYS as f32).sqrt() as u64;
    let eye = Vec3A::new(-8.5, 6.0, 8.8);
    let forward = (Vec3A::new(2.0, 2.0, -2.0) - eye).normalize();
    let right = forward.cross(Vec3A::Y).normalize();
    let up = right.cross(forward);
    let mut r = Rng(11);
    let [mut camera, mut bounce, mut shadow, mut random] = [const { Vec::<Ray>::new() }; 4];
    for n in 0..side * side {
        let [x, y] = [n % side, n / side].map(|i| (i as f32 + 0.5) / side as f32 * 2.0 - 1.0);
        let ray = Ray::new(eye, (forward + right * x * 0.8 - up * y * 0.8).normalize());
        camera.push(ray);
        if let Some(hit) = accel.closest(&ray, &opaque) {
            let m = &scene.meshes[0];
            let [a, b, c] = m.indices[hit.triangle as usize].map(|i| Vec3A::from(m.positions[i as usize]));
            let n = (b - a).cross(c - a).normalize_or_zero();
            let n = if n.dot(ray.direction) > 0.0 { -n } else { n };
            let from = ray.origin + ray.direction * hit.t + n * 1e-3;
            bounce.push(Ray::new(from, n + r.direction() * 0.999));
            let light = Vec3A::new(r.between(-3.0, 3.0), 9.5, r.between(-3.0, 3.0));
            shadow.push(Ray { t_max: 1.0, ..Ray::new(from, light - from) });
        }
        let from = Vec3A::new(r.between(-9.9, 9.9), r.between(0.4, 9.9), r.between(-9.9, 9.9));
        random.push(Ray::new(from, r.direction()));
    }
    println!("{:<24}{:>12}{:>16}", "Mrays/s", "1 thread", format!("{all} threads"));
    let sets = [("camera", false, &camera), ("bounce", false, &bounce), ("random", false, &random)];
    for (name, any, rays) in sets.into_iter().chain([("shadow", true, &shadow), ("random", true, &random)]) {
        let rate = |threads| {
            let pool = pool(threads);
            let query = |ray: &&Ray| {
                if any { accel.any(ray, &opaque) } else { accel.closest(ray, &opaque).is_some() }
            };
            let seconds = |_| {
                let start = Instant::now();
                pool.install(|| {
                    std::hint::black_box(rays.par_iter().with_min_len(1024).filter(query).count())
                });
                start.elapsed().as_secs_f64()
            };
            rays.len() as f64 / (0..5).map(seconds).fold(f64::INFINITY, f64::min) / 1e6
        };
        let kind = if any { "any" } else { "closest" };
        println!("{:<24}{:>12.2}{:>16.2}", format!("{kind}, {name}"), rate(1), rate(all));
    }
}
