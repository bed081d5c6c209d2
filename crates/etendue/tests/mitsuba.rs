//! Spheres of several materials against converged pictures by Mitsuba 3, pixel by pixel, where the models are the same.
//!
//! The references (`reference/mitsuba/bsdf_spheres`, means and variances per sample) lie outside the project; without them
//! the test says that it skips. Mitsuba's own sphere mesh is not among them: only pixels well inside a sphere are compared.
#![allow(missing_docs)]

use etendue::bxdf::model::Model;
use etendue::image::{Image, read_environment};
use etendue::render::{Filter, PathOptions, Renderer, Settings, World};
use etendue::scene::{Camera, Environment, Instance, Light, LightKind, Material, Mesh, Scene, Substitute};
use glam::{Affine3A, Vec3};
use std::path::{Path, PathBuf};

const SIZE: u32 = 48;
/// Samples of each pixel of ours.
const SAMPLES: u32 = 4096;
/// Mitsuba's field of view of a square picture, degrees, if a scene says none: 50 mm before the diagonal of 36 × 24 mm.
const FOV: f32 = 34.0221;

fn folder() -> Option<PathBuf> {
    let p = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/assets/reference/mitsuba/bsdf_spheres/refs");
    p.is_dir().then_some(p)
}

fn read(path: &Path) -> Image {
    read_environment(path).expect("a reference picture").image
}

fn sphere() -> Mesh {
    const N: u32 = 96;
    let mut m = Mesh::default();
    for j in 0..=N {
        for i in 0..=2 * N {
            let (t, p) = [j, i].map(|k| std::f32::consts::PI * k as f32 / N as f32).into();
            let d = Vec3::new(f32::sin(t) * f32::cos(p), f32::cos(t), -f32::sin(t) * f32::sin(p));
            m.positions.push(d);
            m.normals.push(d.normalize());
        }
    }
    let w = 2 * N + 1;
    for (j, i) in (0..N).flat_map(|j| (0..2 * N).map(move |i| (j, i))) {
        let a = j * w + i;
        m.indices.extend([[a, a + w, a + 1], [a + 1, a + w, a + w + 1]]);
    }
    m
}

/// Where each material's sphere stands in the scene's plane (y, z), and what it is here.
const SPHERES: [(f32, f32, &str); 4] = [
    (-6.0, 0.0, "lambert:base_color=0.2,0.5,0.3"),
    (0.0, 0.0, "dielectric:ior=2.41833"),
    (6.0, 3.0, "dielectric:ior=1.50418:roughness=0.3162278"),
    (-3.0, 3.0, "conductor:eta=0.789:k=6.15:roughness=0"),
];

/// Spheres that are not compared, but hide the sky from those that are.
const OTHERS: [(f32, f32); 6] = [(-3.0, 0.0), (3.0, 0.0), (6.0, 0.0), (3.0, 3.0), (0.0, 3.0), (-6.0, 3.0)];

fn scene() -> Scene {
    let mut s = Scene { meshes: vec![sphere().into()], ..Scene::default() };
    let others = OTHERS.map(|(y, z)| (y, z, "lambert:base_color=0"));
    for (i, (y, z, model)) in SPHERES.into_iter().chain(others).enumerate() {
        let model: Model = model.parse().expect("a model");
        s.materials
            .push(Material { substitute: Some(Substitute::Model(Box::new(model))), ..Material::default() });
        s.instances.push(Instance {
            name: model.name().into(),
            mesh: 0,
            material: Some(i as u32),
            transform: Affine3A::from_translation(Vec3::new(0.0, y, z)),
        });
    }
    s
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(-24.0, 0.0, 0.0), Vec3::ZERO, Vec3::Z, FOV.to_radians())
}

/// Centre of a sphere on the picture and its radius, pixels.
fn on_picture(y: f32, z: f32) -> ([f32; 2], f32) {
    let scale = SIZE as f32 / 2.0 / ((FOV.to_radians() / 2.0).tan() * 24.0);
    let middle = SIZE as f32 / 2.0;
    // Seen along +x with z up, y grows to the left.
    ([middle - y * scale, middle - z * scale], scale)
}

/// Compares the spheres in `which` with Mitsuba's picture `name`.
fn compare(name: &str, scene: Scene, which: &[usize]) {
    let Some(folder) = folder() else {
        println!("skipped: the references are not there");
        return;
    };
    let mean = read(&folder.join(format!("test_{name}_ref_rgb.exr")));
    let variance = read(&folder.join(format!("test_{name}_ref_rgb_var.exr")));
    let world = World::new(scene).expect("a sound scene");
    let settings = Settings {
        width: SIZE,
        height: SIZE,
        filter: Filter::Box,
        // One scattering between camera and light: Mitsuba's `max_depth` 2.
        path: PathOptions { bounces: 1, ..PathOptions::default() },
        ..Settings::default()
    };
    let renderer = Renderer::new(&world, camera(), settings);
    let mut film = renderer.film();
    renderer.render(&mut film, 0, SAMPLES, &Default::default());
    let ours = film.beauty();
    let mut tests = 0;
    for &i in which {
        let (y, z, model) = SPHERES[i];
        let ([cx, cy], radius) = on_picture(y, z);
        let (mut largest, mut relative) = (0.0f32, 0.0f32);
        for (py, px) in (0..SIZE).flat_map(|py| (0..SIZE).map(move |px| (py, px))) {
            let (dx, dy) = (px as f32 + 0.5 - cx, py as f32 + 0.5 - cy);
            if (dx * dx + dy * dy).sqrt() > 0.6 * radius {
                continue;
            }
            for c in 0..3 {
                let (a, b) = (ours[(py * SIZE + px) as usize][c as usize], mean.sample(px, py, c));
                // Ours has about the variance that theirs has, which is per sample; a floor for what the mesh differs.
                let error = (variance.sample(px, py, c).max(1e-4) / SAMPLES as f32).sqrt() + 2e-3 * b;
                largest = largest.max((a - b).abs() / error);
                relative = relative.max((a - b).abs() / b.max(1e-3));
                tests += 1;
            }
        }
        println!("{name}, {model}: largest z {largest:.2}, largest relative difference {relative:.4}");
        // 3·10² values, one in a thousand such pictures beyond by chance.
        assert!(largest < 4.8, "{name}, {model}: z {largest}");
    }
    assert!(tests > 20 * which.len(), "{tests} values are too few");
}

#[test]
fn under_an_even_sky() {
    // The diffuse sphere has leaves below it that are not here.
    compare("constant", Scene { environment: Environment::Constant(Vec3::ONE), ..scene() }, &[1, 2, 3]);
}

#[test]
fn under_a_lamp_without_extent() {
    let lamp = Light {
        name: String::new(),
        kind: LightKind::Point,
        position: Vec3::new(-4.0, 0.0, 6.0),
        direction: Vec3::NEG_Z,
        intensity: Vec3::splat(300.0),
        range: None,
    };
    compare("pointlight", Scene { lights: vec![lamp], ..scene() }, &[0, 2]);
}
