//! Scenes with known answers, and how to ask whether a picture gives them.
#![allow(dead_code, missing_docs)]

use etendue_render::{Counters, Film, PathOptions, Renderer, Settings, World};
use etendue_scene::{Camera, Environment, Instance, Material, Mesh, Projection, Scene};
use glam::{Affine3A, Vec3};

/// A purely diffuse surface.
pub fn lambert(albedo: f32) -> Material {
    Material {
        base_color: Vec3::splat(albedo),
        metallic: 0.0,
        specular: 0.0,
        double_sided: true,
        ..Material::default()
    }
}

/// A black surface that emits on both sides.
pub fn lamp(radiance: f32) -> Material {
    Material { emissive: Vec3::splat(radiance), ..lambert(0.0) }
}

pub fn add(scene: &mut Scene, mesh: Mesh, material: Material) {
    scene.materials.push(material);
    scene.meshes.push(mesh.into());
    scene.instances.push(Instance {
        name: String::new(),
        mesh: scene.meshes.len() as u32 - 1,
        material: Some(scene.materials.len() as u32 - 1),
        transform: Affine3A::IDENTITY,
    });
}

/// A horizontal rectangle about `center`, facing up.
pub fn rectangle(center: Vec3, half_x: f32, half_z: f32) -> Mesh {
    let p = |x: f32, z: f32| center + Vec3::new(x * half_x, 0.0, z * half_z);
    Mesh {
        positions: vec![p(-1.0, 1.0), p(1.0, 1.0), p(1.0, -1.0), p(-1.0, -1.0)],
        uvs: vec![vec![[0.0, 1.0].into(), [1.0, 1.0].into(), [1.0, 0.0].into(), [0.0, 0.0].into()]],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A sphere of `2 n²` quads; normals only if `smooth`. Scaled so that its facets have the sphere's area seen from far.
pub fn sphere(center: Vec3, radius: f32, n: u32, smooth: bool) -> Mesh {
    let mut m = Mesh::default();
    for j in 0..=n {
        for i in 0..=2 * n {
            let (t, p) =
                (std::f32::consts::PI * j as f32 / n as f32, std::f32::consts::PI * i as f32 / n as f32);
            let d = Vec3::new(t.sin() * p.cos(), t.cos(), -t.sin() * p.sin());
            m.positions.push(center + d * radius);
            if smooth {
                m.normals.push(d.normalize());
            }
        }
    }
    let w = 2 * n + 1;
    for j in 0..n {
        for i in 0..2 * n {
            let a = j * w + i;
            if j > 0 {
                m.indices.push([a, a + w, a + 1]);
            }
            if j + 1 < n {
                m.indices.push([a + 1, a + w, a + w + 1]);
            }
        }
    }
    m
}

/// A camera with parallel rays, half as high as `ymag`, that looks at `target` from `direction`.
pub fn parallel(target: Vec3, direction: Vec3, ymag: f32) -> Camera {
    let up = if direction.normalize().y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
    let mut c = Camera::look_at(target + direction, target, up, 1.0);
    c.projection = Projection::Orthographic { ymag };
    c
}

pub fn settings(size: u32, bounces: u32) -> Settings {
    Settings {
        width: size,
        height: size,
        filter: etendue_render::Filter::Box,
        path: PathOptions { bounces, ..PathOptions::default() },
        ..Settings::default()
    }
}

pub fn render(world: &World, camera: &Camera, settings: &Settings, samples: u32) -> Film {
    let r = Renderer::new(world, camera.clone(), settings.clone());
    let mut film = r.film();
    r.render(&mut film, 0, samples, &Counters::default());
    assert_eq!(film.rejected, 0, "a sample was not a number");
    film
}

pub fn sky(radiance: f32) -> Environment {
    Environment::Constant(Vec3::splat(radiance))
}

/// Mean of the green channel over the picture, and its standard error (upper estimate: samples taken as independent).
pub fn mean(film: &Film) -> (f64, f64) {
    let n = film.pixels() as f64;
    let mean = film.beauty().iter().map(|p| f64::from(p[1])).sum::<f64>() / n;
    let variance: f64 = film.standard_error().iter().map(|e| f64::from(*e).powi(2)).sum();
    (mean, variance.sqrt() / n)
}

/// Asserts that the picture's mean is `expected` within four standard errors and `slack` of relative error in the model (such as
/// facets for a sphere). Four errors: one of 16,000 honest tests fails.
#[track_caller]
pub fn expect(what: &str, film: &Film, expected: f64, slack: f64) {
    let (mean, error) = mean(film);
    let off = (mean - expected).abs();
    println!("{what}: {mean:.6} ± {error:.6}, expected {expected:.6}");
    assert!(
        off <= 4.0 * error + expected.abs() * (slack + 2e-6),
        "{what}: {mean} ± {error} instead of {expected}"
    );
    assert!(error <= 0.02 * expected.abs().max(1e-9), "{what}: error {error} is too large to tell");
}
