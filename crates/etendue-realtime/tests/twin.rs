//! The twin's pictures: on the same rays as the path tracer's, in order of depth, the same bits from any number of threads.

use etendue_image::Development;
use etendue_realtime::passes::{Display, Pass, PassSet};
use etendue_realtime::{Choices, Frame, Lighting, Twin, TwinSettings};
use etendue_render::{Counters, Renderer, Settings, World};
use etendue_scene::{
    AlphaMode, Camera, Environment, Extensions, Instance, Light, LightKind, Material, Mesh, Scene,
    Transmission,
};
use glam::{Affine3A, Vec3, Vec4};

fn add(scene: &mut Scene, mesh: Mesh, material: Material) {
    scene.materials.push(material);
    scene.meshes.push(mesh.into());
    scene.instances.push(Instance {
        name: String::new(),
        mesh: scene.meshes.len() as u32 - 1,
        material: Some(scene.materials.len() as u32 - 1),
        transform: Affine3A::IDENTITY,
    });
}

/// A square of side 2 at height `z`, which faces the camera.
fn sheet(z: f32) -> Mesh {
    let p = |x: f32, y: f32| Vec3::new(x, y, z);
    Mesh {
        positions: vec![p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn sphere(n: u32) -> Mesh {
    let mut m = Mesh::default();
    for j in 0..=n {
        for i in 0..=2 * n {
            let (t, p) = (j as f32, i as f32);
            let (t, p) = (t * std::f32::consts::PI / n as f32, p * std::f32::consts::PI / n as f32);
            let d = Vec3::new(t.sin() * p.cos(), t.cos(), -t.sin() * p.sin());
            m.positions.push(d);
            m.normals.push(d.normalize());
        }
    }
    let w = 2 * n + 1;
    for j in 0..n {
        for i in 0..2 * n {
            let a = j * w + i;
            m.indices.push([a, a + w, a + w + 1]);
            m.indices.push([a, a + w + 1, a + 1]);
        }
    }
    m
}

fn unlit(color: Vec3) -> Material {
    Material { base_color: color, unlit: true, ..Material::default() }
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 0.7)
}

fn settings(width: u32, height: u32, samples: u32) -> TwinSettings {
    TwinSettings { width, height, samples, ..TwinSettings::default() }
}

fn draw(scene: Scene, choices: Choices, settings: TwinSettings) -> Frame {
    let world = World::new(scene).expect("a sound scene");
    let lighting = Lighting::new(world.scene(), &choices).expect("a sound sky");
    let frame = Twin::new(&world, &camera(), &lighting, choices, settings).render(&Counters::default());
    assert_eq!(frame.rejected, 0);
    frame
}

/// A scene with something of everything: a glossy sphere, a veil before it, a light, a sky.
fn still() -> Scene {
    let mut s = Scene { environment: Environment::Constant(Vec3::new(0.4, 0.5, 0.6)), ..Scene::default() };
    let gold = Material { base_color: Vec3::new(1.0, 0.7, 0.3), roughness: 0.3, ..Material::default() };
    add(&mut s, sphere(24), gold);
    let blend = AlphaMode::Blend;
    add(&mut s, sheet(1.5), Material { alpha: 0.3, alpha_mode: blend, metallic: 0.0, ..Material::default() });
    s.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point,
        intensity: Vec3::splat(4.0),
        position: Vec3::new(-2.0, 2.0, 3.0),
        direction: Vec3::NEG_Y,
        range: None,
    });
    s
}

#[test]
fn the_bits_do_not_depend_on_threads() {
    let frames = [1, 2, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let settings = TwinSettings { passes: PassSet::all(), ..settings(40, 27, 3) };
        pool.install(|| draw(still(), Choices::default(), settings))
    });
    assert!(frames[0] == frames[1] && frames[0] == frames[2]);
    // What is recorded beside it does not change the picture.
    let plain = draw(still(), Choices::default(), settings(40, 27, 3));
    assert!(plain.beauty().eq(frames[0].beauty()));
}

#[test]
fn terms_add_up_to_the_picture() {
    let settings = TwinSettings { passes: PassSet::all(), ..settings(40, 27, 3) };
    let frame = draw(still(), Choices::default(), settings);
    let develop = Development::default();
    let terms = Pass::TERMS.map(|p| frame.pass(p, &develop).expect("recorded"));
    let picture = frame.pass(Pass::Linear, &develop).expect("recorded");
    for (i, whole) in picture.iter().enumerate() {
        let sum: f32 = terms.iter().map(|t| t[i]).sum();
        assert!((sum - whole).abs() <= 1e-5 * whole.max(1.0), "{i}: {sum} of {whole}");
    }
    // Each term is there in the middle, but those that the scene has nothing of.
    let middle = (13 * 40 + 20) * 3;
    for (pass, values) in Pass::TERMS.iter().zip(&terms) {
        let there = !matches!(pass, Pass::Transmission | Pass::Emission);
        assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0), "{pass}");
        let somewhere = values.iter().any(|v| *v > 0.0);
        assert_eq!(somewhere, there, "{pass}: {}", values[middle]);
    }
    // Values are means over the surfaces that are seen: unit vectors, shares.
    let normal = frame.pass(Pass::Normal, &develop).expect("recorded");
    let n = Vec3::from_slice(&normal[middle..middle + 3]);
    assert!((n.length() - 1.0).abs() < 0.02, "{n}");
    for pass in frame.passes.iter().filter(|p| p.display() == Display::Share) {
        let values = frame.pass(pass, &develop).expect("recorded");
        assert!(values.iter().all(|v| (0.0..1.001).contains(v)), "{pass} is a share");
        assert_eq!(values[0], 0.0, "{pass} where there is no surface");
    }
    for pass in frame.passes.iter() {
        let (shown, _) = frame.display(pass, &develop).expect("recorded");
        assert_eq!((shown.width, shown.height), (40, 27), "{pass}");
        assert!(shown.channels == 1 || shown.channels == 3, "{pass}");
    }
    assert!(frame.pass(Pass::Linear, &develop).is_some() && frame.layers(true, &develop).len() > 30);
}

/// Where there is nothing to shade the twin's picture is the path tracer's: the same rays, the same colours.
#[test]
fn pictures_lie_over_the_path_tracers() {
    let mut s = Scene { environment: Environment::Constant(Vec3::new(0.1, 0.2, 0.3)), ..Scene::default() };
    let mut colorful = sheet(0.0);
    colorful.colors =
        [Vec4::X, Vec4::Y, Vec4::Z, Vec4::ONE].iter().map(|c| c.truncate().extend(1.0)).collect();
    add(&mut s, colorful, unlit(Vec3::new(0.9, 0.5, 0.7)));
    s.instances[0].transform = Affine3A::from_rotation_z(0.3);
    let world = World::new(s.clone()).expect("sound");
    let renderer =
        Renderer::new(&world, camera(), Settings { width: 33, height: 20, seed: 5, ..Settings::default() });
    let mut film = renderer.film();
    renderer.render(&mut film, 0, 4, &Counters::default());
    let twin = draw(s, Choices::default(), TwinSettings { seed: 5, ..settings(33, 20, 4) });
    for (i, (a, b)) in film.beauty().iter().zip(twin.beauty()).enumerate() {
        (0..4).for_each(|c| assert!((a[c] - b[c]).abs() < 1e-6, "{i}: {a:?} {b:?}"));
    }
    let edges = twin.beauty().filter(|p| p[3] > 0.0 && p[3] < 1.0).count();
    assert!(edges > 20, "{edges} pixels of edges");
}

#[test]
fn blended_surfaces_lie_over_each_other_in_order_of_distance() {
    let veil = |color: Vec3, alpha: f32| Material { alpha, alpha_mode: AlphaMode::Blend, ..unlit(color) };
    // Not in order in the file.
    let mut s = Scene { environment: Environment::Constant(Vec3::splat(0.5)), ..Scene::default() };
    add(&mut s, sheet(0.2), veil(Vec3::Y, 0.5));
    add(&mut s, sheet(0.4), veil(Vec3::X, 0.25));
    add(&mut s, sheet(0.3), Material { alpha: 0.4, alpha_mode: AlphaMode::Mask(0.5), ..unlit(Vec3::ONE) });
    add(&mut s, sheet(0.0), veil(Vec3::Z, 0.5));
    let frame = draw(s.clone(), Choices::default(), settings(5, 5, 4));
    let [r, g, b, a] = frame.beauty().nth(12).expect("the middle");
    let behind = 0.75 * 0.5 * 0.5;
    let expected = [0.25 + 0.5 * behind, 0.375 + 0.5 * behind, 0.75 * 0.25 + 0.5 * behind];
    for (v, e) in [r, g, b].into_iter().zip(expected) {
        assert!((v - e).abs() < 1e-5, "{v} {e}");
    }
    assert!((a - (1.0 - behind)).abs() < 1e-5, "{a}");
    // Without the sky the picture has its alpha, and nothing of the sky.
    let frame = draw(s, Choices::default(), TwinSettings { sky_visible: false, ..settings(5, 5, 4) });
    let [r, _, _, transparent] = frame.beauty().nth(12).expect("the middle");
    assert!((r - 0.25).abs() < 1e-5 && (transparent - a).abs() < 1e-6);
}

#[test]
fn backs_are_seen_of_two_sided_surfaces_only() {
    for (double_sided, there) in [(false, 0.0), (true, 1.0)] {
        let mut s = Scene::default();
        let mut back = sheet(0.0);
        back.indices.iter_mut().for_each(|t| t.swap(0, 1));
        add(&mut s, back, Material { double_sided, ..unlit(Vec3::ONE) });
        let frame = draw(s, Choices::default(), settings(5, 5, 1));
        assert_eq!(frame.beauty().nth(12), Some([there; 4]));
    }
}

/// A light behind a sheet: with shadow rays nothing, without them all, with a veil in its way what the veil leaves.
#[test]
fn shadows_are_rays_or_none() {
    let lit = |alpha: f32, choice: &str| {
        let mut s = Scene::default();
        let matte = Material { metallic: 0.0, specular: 0.0, ..Material::default() };
        add(&mut s, sheet(0.0), matte.clone());
        // Beside the camera's way to the middle, across the light's.
        let mut shade = sheet(0.0);
        shade.positions.iter_mut().for_each(|p| *p = Vec3::new(p.x * 0.2 + 1.0, p.y * 0.2, 1.0));
        add(&mut s, shade, Material { alpha, alpha_mode: AlphaMode::Blend, double_sided: true, ..matte });
        s.lights.push(Light {
            name: String::new(),
            kind: LightKind::Point,
            intensity: Vec3::splat(8.0),
            position: Vec3::new(2.0, 0.0, 2.0),
            direction: Vec3::NEG_Y,
            range: None,
        });
        let choices: Choices = choice.parse().expect("a choice");
        draw(s, choices, settings(5, 5, 1)).beauty().nth(12).expect("the middle")[0]
    };
    let open = lit(1.0, "shadows=none");
    assert!(open > 0.1);
    assert_eq!(lit(1.0, "shadows=rays"), 0.0);
    let veiled = lit(0.25, "shadows=rays");
    assert!((veiled / open - 0.75).abs() < 1e-3, "{veiled} of {open}");
}

#[test]
fn a_white_sphere_under_a_white_sky_nearly_vanishes() {
    for (metallic, roughness, most) in
        [(0.0, 1.0, 0.03), (0.0, 0.4, 0.03), (1.0, 0.2, 0.03), (1.0, 0.9, 0.03)]
    {
        let mut s = Scene { environment: Environment::Constant(Vec3::ONE), ..Scene::default() };
        add(&mut s, sphere(24), Material { metallic, roughness, ..Material::default() });
        let frame = draw(s, Choices::default(), settings(24, 24, 4));
        let worst = frame.beauty().map(|p| (p[1] - 1.0).abs()).fold(0.0, f32::max);
        assert!(worst < most, "metal {metallic}, roughness {roughness}: {worst}");
    }
}

/// Clear glass before a red sheet: red, less what the glass reflects; and a second pane is not seen through the first.
#[test]
fn what_is_behind_is_seen_through() {
    let seen = |panes: usize, refraction: &str| {
        let mut s = Scene::default();
        add(&mut s, sheet(0.0), unlit(Vec3::new(0.8, 0.1, 0.1)));
        for i in 0..panes {
            let extensions = Extensions {
                transmission: Some(Transmission { factor: 1.0, texture: None }),
                ..Extensions::default()
            };
            let pane = Material {
                metallic: 0.0,
                roughness: 0.0,
                extensions: Some(Box::new(extensions)),
                ..Material::default()
            };
            add(&mut s, sheet(0.5 + 0.2 * i as f32), pane);
        }
        let choices: Choices = refraction.parse().expect("a choice");
        draw(s, choices, settings(5, 5, 2)).beauty().nth(12).expect("the middle")
    };
    for panes in [1, 2] {
        let [r, g, _, a] = seen(panes, "refraction=scene");
        assert!((r - 0.8 * 0.96).abs() < 2e-3 && (g - 0.1 * 0.96).abs() < 1e-3 && a == 1.0, "{r} {g} {a}");
    }
    // There is no sky to be seen instead.
    assert_eq!(seen(1, "refraction=sky")[0], 0.0);
}
