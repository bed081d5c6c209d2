//! The fixed scenes of `etendue bench`, made from nothing but numbers.

use crate::builtin;
use crate::scene::{Camera, Environment, Instance, Material, Mesh, Scene};
use glam::{Affine3A, Quat, Vec3, Vec3A};
use std::f32::consts::{PI, TAU};

/// A scene to measure on.
pub(crate) struct BenchScene {
    pub name: &'static str,
    pub what: &'static str,
    pub scene: Scene,
    pub camera: Camera,
}

/// All scenes whose name contains `filter`.
pub(crate) fn all(filter: &str) -> Result<Vec<BenchScene>, super::CliError> {
    type Make = fn() -> Result<BenchScene, super::CliError>;
    let makers: [(&str, Make); 5] = [
        ("helmet", helmet),
        ("room", || Ok(room())),
        ("soup", || Ok(soup())),
        ("lights", || Ok(lights())),
        ("forest", forest),
    ];
    makers.into_iter().filter(|m| m.0.contains(filter)).map(|m| m.1()).collect()
}

/// A fixed sequence of numbers in 0..1 (PCG, O'Neill 2014).
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (x.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / 16_777_216.0
    }
    fn vec(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
    fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next();
        let phi = TAU * self.next();
        let s = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(s * phi.cos(), s * phi.sin(), z)
    }
}

fn helmet() -> Result<BenchScene, super::CliError> {
    let scene = builtin::helmet().map_err(|e| super::CliError::Other(e.to_string()))?;
    let camera = Camera::framing(&scene, 1.0, 35f32.to_radians());
    Ok(BenchScene { name: "helmet", what: "the built-in helmet and studio", scene, camera })
}

fn grid(mesh: &mut Mesh, nu: u32, nv: u32, f: impl Fn(f32, f32) -> Vec3) {
    let base = mesh.positions.len() as u32;
    for j in 0..=nv {
        mesh.positions.extend((0..=nu).map(|i| f(i as f32 / nu as f32, j as f32 / nv as f32)));
    }
    for j in 0..nv {
        for i in 0..nu {
            let a = base + j * (nu + 1) + i;
            mesh.indices.extend([[a, a + nu + 1, a + 1], [a + 1, a + nu + 1, a + nu + 2]]);
        }
    }
}

fn ripple(p: Vec3) -> f32 {
    (p.x * 3.3 + p.y.cos()).sin() * (p.y * 2.9 + p.z.cos()).sin() * (p.z * 3.1 + p.x.cos()).sin()
}

fn ball(mesh: &mut Mesh, center: Vec3, radius: f32, phase: Vec3, n: u32) {
    grid(mesh, 2 * n, n, |u, v| {
        let (theta, phi) = (v * PI, -u * TAU);
        let d = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        center + d * radius * (1.0 + 0.12 * ripple(d * 4.0 + phase))
    });
}

fn grey() -> Material {
    Material {
        base_color: Vec3::splat(0.6),
        metallic: 0.0,
        roughness: 0.6,
        double_sided: true,
        ..Material::default()
    }
}

fn placed(scene: &mut Scene, mesh: Mesh, material: u32, transform: Affine3A) {
    scene.meshes.push(mesh.into());
    let mesh = scene.meshes.len() as u32 - 1;
    scene.instances.push(Instance {
        name: format!("mesh {mesh}"),
        mesh,
        material: Some(material),
        transform,
    });
}

/// A closed room with rippled floor and 200 rippled balls under a lamp: a million triangles, much interreflection.
fn room() -> BenchScene {
    let mut s = Sequence(17);
    let mut mesh = Mesh::default();
    let corner = |i: u32| {
        Vec3::new(
            if i & 1 == 0 { -10.0 } else { 10.0 },
            if i & 2 == 0 { -1.0 } else { 10.0 },
            if i & 4 == 0 { -10.0 } else { 10.0 },
        )
    };
    mesh.positions.extend((0..8).map(corner));
    for q in [[2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3], [0, 1, 3, 2], [4, 6, 7, 5]] {
        mesh.indices.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
    }
    grid(&mut mesh, 250, 250, |u, v| {
        let p = Vec3::new(-10.0 + 20.0 * u, 0.0, -10.0 + 20.0 * v);
        p + Vec3::Y * 0.3 * ripple(p * 0.6)
    });
    for _ in 0..200 {
        let center = Vec3::new(-9.0, 0.8, -9.0) + s.vec() * Vec3::new(18.0, 7.0, 18.0);
        let (radius, phase) = (0.35 + 0.6 * s.next(), s.vec() * 9.0);
        ball(&mut mesh, center, radius, phase, 33);
    }
    let mut scene = Scene { materials: vec![grey(), lamp(30.0)], ..Scene::default() };
    placed(&mut scene, mesh, 0, Affine3A::IDENTITY);
    placed(&mut scene, quad(3.0), 1, Affine3A::from_translation(Vec3::new(0.0, 9.5, 0.0)));
    let camera =
        Camera::look_at(Vec3::new(-8.5, 6.0, 8.8), Vec3::new(2.0, 2.0, -2.0), Vec3::Y, 75f32.to_radians());
    BenchScene { name: "room", what: "closed room, one lamp", scene, camera }
}

fn lamp(radiance: f32) -> Material {
    Material { base_color: Vec3::ZERO, emissive: Vec3::splat(radiance), metallic: 0.0, ..Material::default() }
}

/// A square that faces down, `2 · half` wide.
fn quad(half: f32) -> Mesh {
    let c = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    Mesh {
        positions: vec![c(-1.0, -1.0), c(1.0, -1.0), c(1.0, 1.0), c(-1.0, 1.0)],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// 200,000 long thin triangles in all directions: the worst that a bounding-volume hierarchy meets.
fn soup() -> BenchScene {
    let mut s = Sequence(5);
    let mut mesh = Mesh::default();
    for _ in 0..200_000u32 {
        let c = (s.vec() - 0.5) * 20.0;
        let (d, e) = (s.direction() * (0.1 + 1.2 * s.next()), s.direction() * 0.04);
        let k = mesh.positions.len() as u32;
        mesh.positions.extend([c, c + d, c + e]);
        mesh.indices.push([k, k + 1, k + 2]);
    }
    let mut scene =
        Scene { materials: vec![grey()], environment: Environment::Constant(Vec3::ONE), ..Scene::default() };
    placed(&mut scene, mesh, 0, Affine3A::IDENTITY);
    let camera = Camera::look_at(Vec3::new(0.0, 4.0, 26.0), Vec3::ZERO, Vec3::Y, 45f32.to_radians());
    BenchScene { name: "soup", what: "long thin triangles, constant sky", scene, camera }
}

/// A plain with 10,000 small lamps of different colours.
fn lights() -> BenchScene {
    let mut s = Sequence(23);
    let mut scene = Scene { materials: vec![grey()], ..Scene::default() };
    let mut floor = Mesh::default();
    grid(&mut floor, 200, 200, |u, v| {
        let p = Vec3::new(u - 0.5, 0.0, v - 0.5) * 40.0;
        p + Vec3::Y * 0.4 * ripple(p * 0.5)
    });
    placed(&mut scene, floor, 0, Affine3A::IDENTITY);
    for c in 0..8u32 {
        let tint = |bit: u32| if c >> bit & 1 == 1 { 1.0 } else { 0.15 };
        scene.materials.push(Material { emissive: Vec3::new(tint(0), tint(1), tint(2)) * 60.0, ..lamp(0.0) });
        let mut mesh = Mesh::default();
        for _ in 0..1250 {
            let at = Vec3::new(s.next() - 0.5, 0.0, s.next() - 0.5) * 38.0 + Vec3::Y * (0.6 + 0.8 * s.next());
            let k = mesh.positions.len() as u32;
            let (d, e) = (s.direction() * 0.06, s.direction() * 0.06);
            mesh.positions.extend([at, at + d, at + e]);
            mesh.indices.push([k, k + 1, k + 2]);
        }
        placed(&mut scene, mesh, c + 1, Affine3A::IDENTITY);
    }
    let camera =
        Camera::look_at(Vec3::new(0.0, 7.0, 22.0), Vec3::new(0.0, 0.0, 2.0), Vec3::Y, 45f32.to_radians());
    BenchScene { name: "lights", what: "10,000 lamps over a plain", scene, camera }
}

/// 2,000 instances of the helmet: two levels.
fn forest() -> Result<BenchScene, super::CliError> {
    let mut s = Sequence(31);
    let mut b = helmet()?;
    let one = std::mem::take(&mut b.scene.instances);
    for _ in 0..2000 {
        let at = (Vec3::new(s.next(), s.next(), s.next()) - 0.5) * Vec3::new(24.0, 6.0, 24.0);
        let turn = Quat::from_axis_angle(s.direction(), TAU * s.next());
        let place = Affine3A::from_rotation_translation(turn, at);
        b.scene
            .instances
            .extend(one.iter().map(|i| Instance { transform: place * i.transform, ..i.clone() }));
    }
    // The middle of the crowd, not all of it.
    let corners = (0..8).map(|i| Vec3A::from([0, 1, 2].map(|a| if i >> a & 1 == 0 { -8.0 } else { 8.0 })));
    let camera = Camera::framing_points(corners, 1.0, 35f32.to_radians());
    Ok(BenchScene { name: "forest", what: "2,000 helmets, two levels of instances", camera, scene: b.scene })
}
