//! Probes of scenes whose light is known.

use etendue::color::Spectrum;
use etendue::ibl::{BakeOptions, PrefilterOptions, ProbeFile, Sh9, bake_cube};
use etendue::image::{Image, Pixels};
use etendue::probe::{ProbeSettings, Volume, backs, cube_probe, light_probes};
use etendue::render::World;
use etendue::scene::{Environment, Instance, Material, Mesh, Scene};
use glam::{Affine3A, Vec3, Vec3A};
use std::f32::consts::PI;
use std::sync::Arc;

/// A rectangle from `corner` along `u` and `v`; its front is where u × v points.
fn rectangle(corner: Vec3, u: Vec3, v: Vec3) -> Mesh {
    let positions = vec![corner, corner + u, corner + u + v, corner + v];
    Mesh { positions, indices: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

fn add(scene: &mut Scene, mesh: Mesh, material: Material) {
    let (m, k) = (scene.meshes.len() as u32, scene.materials.len() as u32);
    scene.meshes.push(mesh.into());
    scene.materials.push(material);
    let transform = Affine3A::IDENTITY;
    scene.instances.push(Instance { name: String::new(), mesh: m, material: Some(k), transform });
}

/// A box with walls of one material, their fronts inside (or outside).
fn room(scene: &mut Scene, half: f32, material: &Material, inside: bool) {
    for (axis, side) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0f32)] {
        let unit = |k: usize| Vec3::AXES[k % 3] * half;
        let (n, u, v) = (unit(axis) * side, unit(axis + 1) * 2.0, unit(axis + 2) * 2.0);
        let corner = n - (u + v) * 0.5;
        // u × v points along +axis.
        let towards = (side > 0.0) != inside;
        let mesh = if towards { rectangle(corner, u, v) } else { rectangle(corner, v, u) };
        add(scene, mesh, material.clone());
    }
}

fn unlit(colour: f32) -> Material {
    Material { base_color: Vec3::splat(colour), unlit: true, ..Material::default() }
}

fn quick(size: u32, samples: u32) -> ProbeSettings {
    ProbeSettings { size, samples, ..ProbeSettings::default() }
}

/// An even sky is 1, and so is a closed room whose walls shine with ½ and reflect ½, found by paths of many bounces.
#[test]
fn a_furnace_is_one() {
    let mut scene = Scene { environment: Environment::Constant(Vec3::ONE), ..Scene::default() };
    let world = World::new(scene.clone()).unwrap();
    let cube = cube_probe(&world, Vec3A::new(1.0, 2.0, 3.0), &quick(8, 4), &|_| ());
    assert!(cube.mip(0).iter().all(|l| l.to_rgb() == [1.0; 3]));

    // Lambert's surface with albedo ½ that shines with ½.
    let base_color = Vec3::splat(0.5);
    let material =
        Material { base_color, emissive: base_color, metallic: 0.0, specular: 0.0, ..Material::default() };
    room(&mut scene, 2.0, &material, true);
    scene.environment = Environment::Constant(Vec3::ZERO);
    let world = World::new(scene).unwrap();
    let settings = ProbeSettings { bounces: 40, ..quick(8, 64) };
    let cube = cube_probe(&world, Vec3A::new(0.5, -0.3, 0.2), &settings, &|_| ());
    let mean = cube.mean(0)[0];
    assert!((mean - 1.0).abs() < 5e-3, "{mean}");
    let prefilter = PrefilterOptions { size: 8, steps: 2, samples: 64, ..Default::default() };
    let baked =
        bake_cube(&cube, &BakeOptions { prefilter, irradiance_size: 4, ..Default::default() }, &|_| ());
    assert!(baked.irradiance.mip(0).iter().all(|e| (e[0] / PI - 1.0).abs() < 0.02));
    assert!(baked.specular.mip(2).iter().all(|l| (l[0] - 1.0).abs() < 0.03));
}

/// A probe of a picture sky without a scene is that sky, face for face.
#[test]
fn an_empty_scene_is_its_sky() {
    let (w, h) = (64, 32);
    let pixels = (0..w * h).flat_map(|i| [(i % w) as f32, (i / w) as f32, 1.0]).collect();
    let image = Arc::new(Image { width: w, height: h, channels: 3, pixels: Pixels::F32(pixels) });
    let environment = Environment::LatLong { image, rotation: 0.7, intensity: 0.5 };
    let sky = etendue::ibl::SkyMap::new(&environment).unwrap();
    let want = etendue::ibl::to_cube(&sky, 16);
    let world = World::new(Scene { environment, ..Scene::default() }).unwrap();
    let got = cube_probe(&world, Vec3A::ZERO, &quick(16, 256), &|_| ());
    let mut close = 0;
    for (a, b) in got.mip(0).iter().zip(want.mip(0)) {
        // The seam of the ramp from 63 to 0 is within some texels.
        close += usize::from((*a - *b).map(f32::abs).max_element() < 0.4);
    }
    assert!(close > 6 * 256 * 96 / 100, "{close} of {}", 6 * 256);
}

/// Half of all directions sky of 1, half floor of 0.3: E(n) = π ((1 + n.y)/2 + 0.3 (1 − n.y)/2), which nine harmonics hold exactly, because a
/// step has no even bands. Inside of a closed body, the probe is flagged and lookups leave it out.
#[test]
fn probes_over_a_floor_meet_the_integral() {
    let mut scene = Scene { environment: Environment::Constant(Vec3::ONE), ..Scene::default() };
    let far = 1e5;
    add(
        &mut scene,
        rectangle(Vec3::new(-far, 0.0, -far), Vec3::Z * 2.0 * far, Vec3::X * 2.0 * far),
        unlit(0.3),
    );
    let open = World::new(scene.clone()).unwrap();
    let volume =
        Volume { first: Vec3::new(-3.0, 1.0, 0.0), last: Vec3::new(3.0, 2.0, 0.0), counts: [3, 2, 1] };
    let file = light_probes(&open, "floor", &volume, &quick(0, 384 * 32), &|_| ()).unwrap();
    for p in [Vec3::new(0.2, 1.4, 0.0), Vec3::new(-3.0, 1.0, 0.0)] {
        for n in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.0, -0.8), Vec3::new(0.0, 0.6, 0.8)] {
            let want = PI * (0.5 * (1.0 + n.y) + 0.3 * 0.5 * (1.0 - n.y));
            for sh in [file.grid.trilinear(p), file.grid.tetrahedral(p)] {
                let got = sh.irradiance(n)[0];
                assert!((got / want - 1.0).abs() < 2e-3, "{p} {n}: {got} {want}");
            }
        }
    }
    assert!(file.backs.iter().all(|b| *b == 0.0));

    // A closed box about the origin (its walls shine with 1), which the probe in the middle of the lower row is inside of.
    let mut inner = Scene::default();
    room(&mut inner, 0.4, &unlit(1.0), false);
    for (mesh, material) in inner.meshes.iter_mut().zip(inner.materials) {
        let mut mesh = std::mem::take(std::sync::Arc::make_mut(mesh));
        mesh.positions.iter_mut().for_each(|p| *p += Vec3::Y);
        add(&mut scene, mesh, material);
    }
    let world = World::new(scene).unwrap();
    assert_eq!(backs(&world, Vec3A::Y), 1.0);
    let file = light_probes(&world, "floor", &volume, &quick(0, 384 * 4), &|_| ()).unwrap();
    assert_eq!(
        file.backs.iter().map(|b| *b > 0.25).collect::<Vec<_>>(),
        [false, true, false, false, false, false]
    );
    assert!(file.grid.is_hidden([1, 0, 0]));
    let back = ProbeFile::from_json(&file.to_json()).unwrap();
    assert_eq!(back, file);
}

/// A panel that shines, from several places, against its harmonics by quadrature over its area.
#[test]
fn a_panel_meets_its_quadrature() {
    let mut scene = Scene::default();
    let (corner, u, v) = (Vec3::new(-0.5, 2.0, -1.0), Vec3::X, Vec3::Z * 2.0);
    add(&mut scene, rectangle(corner, u, v), unlit(0.6));
    let world = World::new(scene).unwrap();
    let volume = Volume { first: Vec3::ZERO, last: Vec3::new(1.0, 0.5, 0.5), counts: [2, 2, 2] };
    let file = light_probes(&world, "panel", &volume, &quick(0, 384 * 64), &|_| ()).unwrap();
    for index in 0..8u32 {
        let index = [index & 1, index >> 1 & 1, index >> 2];
        let p = file.grid.position(index);
        let n = 64;
        let want = Sh9::from_samples((0..n * n).map(|i| {
            let at = |k: i32| (k as f32 + 0.5) / n as f32;
            let to = corner + u * at(i % n) + v * at(i / n) - p;
            let d = to.normalize();
            let solid_angle = f64::from(2.0 / (n * n) as f32 * d.y / to.length_squared());
            (d, Spectrum::splat(0.6), solid_angle)
        }));
        for normal in [Vec3::Y, Vec3::X, Vec3::NEG_X, Vec3::new(0.0, 0.8, -0.6)] {
            let (a, b) = (file.grid.probe(index).irradiance(normal)[0], want.irradiance(normal)[0]);
            assert!((a - b).abs() < 0.015 * want.irradiance(Vec3::Y)[0], "{p} {normal}: {a} {b}");
        }
    }
}

/// The result does not depend on threads.
#[test]
fn threads_do_not_matter() {
    let model = etendue::builtin::helmet().unwrap();
    let world = World::new(Scene { environment: Environment::Constant(Vec3::ONE), ..model }).unwrap();
    let volume = Volume::cells([Vec3::splat(-1.0), Vec3::splat(1.0)], [2, 2, 1]).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let cube = cube_probe(&world, Vec3A::new(0.0, 0.2, 2.0), &quick(8, 2), &|_| ());
            (cube, light_probes(&world, "", &volume, &quick(0, 384), &|_| ()).unwrap().to_json())
        })
    };
    assert_eq!(run(1), run(3));
}
