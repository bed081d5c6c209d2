//! Pictures of scenes that move while the shutter is open, against what their means must be.
mod common;

use common::{add, lambert, lamp, parallel};
use etendue_render::{
    Film, Filter, Moment, MovingRenderer, PathOptions, Renderer, Series, Settings, Shutter, World,
};
use etendue_scene::{Camera, InvalidScene, Light, LightKind, Mesh, Scene};
use glam::{Affine3A, Vec3};

const OPEN: Shutter = Shutter { open: 2.0, close: 4.0, moments: 64 };
const SAMPLES: u32 = 512;

/// A quadrilateral in the plane z = 0.
fn quad(x: [f32; 2], y: [f32; 2]) -> Mesh {
    Mesh {
        positions: [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| Vec3::new(x[i], y[j], 0.0)).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A row of 32 pixels from x = −1.6 to 1.6.
fn row() -> (Camera, Settings) {
    let settings = Settings {
        width: 32,
        height: 1,
        filter: Filter::Box,
        path: PathOptions { bounces: 0, ..PathOptions::default() },
        ..Settings::default()
    };
    (parallel(Vec3::ZERO, Vec3::Z, 0.05), settings)
}

fn film(at: impl Fn(f64) -> Moment, settings: Settings, samples: std::ops::Range<u32>) -> Film {
    let at = |t| Ok::<_, InvalidScene>(at(t));
    let mut series = Series::default();
    let mut r = MovingRenderer::new(at, OPEN, settings, 0, &mut series).expect("sound");
    let mut film = r.film();
    r.render(&mut film, samples.start, samples.end, &Default::default()).expect("sound");
    film
}

/// How long the shutter has been open at `t`, as a part of all.
fn part(t: f64) -> f32 {
    ((t - OPEN.open) / (OPEN.close - OPEN.open)) as f32
}

/// The part of the time during which the point `x` is covered by a strip of half width `half` whose middle goes evenly from
/// `a` to `b`: a trapezoid.
fn trapezoid(x: f64, half: f64, a: f64, b: f64) -> f64 {
    (((x + half).min(b) - (x - half).max(a)) / (b - a)).max(0.0)
}

/// The mean of `f` over each pixel of [`row`] is what the film shows.
fn expect_row(film: &Film, what: &str, f: impl Fn(f64) -> f64) {
    for i in 0..32 {
        let mean =
            (0..100).map(|k| f(-1.6 + 0.1 * (i as f64 + (k as f64 + 0.5) / 100.0))).sum::<f64>() / 100.0;
        let seen = f64::from(film.mean(i, 1));
        // While an edge crosses the pixel, for about a sixth of the samples, chance decides what is seen: σ is 0.0075.
        assert!((seen - mean).abs() < 0.03, "{what}, pixel {i}: {seen}, and {mean} is expected");
    }
}

#[test]
fn a_strip_that_moves_is_a_trapezoid() {
    let (camera, settings) = row();
    let at = |t: f64| {
        let mut scene = Scene::default();
        add(&mut scene, quad([-0.3, 0.3], [-1.0, 1.0]), lamp(1.0));
        scene.instances[0].transform = Affine3A::from_translation(Vec3::new(-0.8 + 1.6 * part(t), 0.0, 0.0));
        Moment { scene, camera: camera.clone() }
    };
    let seen = film(at, settings, 0..SAMPLES);
    expect_row(&seen, "object", |x| trapezoid(x, 0.3, -0.8, 0.8));
}

#[test]
fn a_camera_that_moves_sees_the_same_the_other_way() {
    let (camera, settings) = row();
    let at = |t: f64| {
        let mut scene = Scene::default();
        add(&mut scene, quad([-0.3, 0.3], [-1.0, 1.0]), lamp(1.0));
        let mut camera = camera.clone();
        camera.transform.translation.x += 1.2 * part(t);
        Moment { scene, camera }
    };
    let seen = film(at, settings, 0..SAMPLES);
    expect_row(&seen, "camera", |x| trapezoid(-x, 0.3, 0.0, 1.2));
}

/// A strip whose right edge, and nothing else of it, goes from 0 to 1.6: at x it is there for the part 1 − x / 1.6 of the time.
#[test]
fn a_mesh_that_changes_shape() {
    let (camera, settings) = row();
    let at = |t: f64| {
        let mut scene = Scene::default();
        add(&mut scene, quad([-0.5, 1.6 * part(t)], [-1.0, 1.0]), lamp(1.0));
        Moment { scene, camera: camera.clone() }
    };
    let seen = film(at, settings, 0..SAMPLES);
    let there = |x: f64| if x < -0.5 { 0.0 } else { (1.0 - x / 1.6).clamp(0.0, 1.0) };
    expect_row(&seen, "shape", there);
}

/// A sector of 60° turns by 90°: seen at an angle φ it is there for a part of the time that is a trapezoid in φ, which
/// linear interpolation between the ends would not give.
#[test]
fn what_turns_goes_round() {
    let steps = 12;
    let rim = |k: i32| {
        let (sin, cos) = (60.0 * k as f32 / steps as f32 - 30.0).to_radians().sin_cos();
        Vec3::new(cos, sin, 0.0)
    };
    let fan = Mesh {
        positions: std::iter::once(Vec3::ZERO).chain((0..=steps).map(rim)).collect(),
        indices: (1..=steps as u32).map(|k| [0, k, k + 1]).collect(),
        ..Mesh::default()
    };
    for degrees in [-45.0f64, -20.0, 0.0, 10.0, 30.0, 45.0, 70.0, 100.0, 130.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let point = Vec3::new(0.8 * cos as f32, 0.8 * sin as f32, 0.0);
        let mut camera = parallel(point, Vec3::Z, 1e-4);
        camera.transform.translation = (point + Vec3::Z).into();
        let at = |t: f64| {
            let mut scene = Scene::default();
            add(&mut scene, fan.clone(), lamp(1.0));
            scene.instances[0].transform = Affine3A::from_rotation_z(part(t) * std::f32::consts::FRAC_PI_2);
            Moment { scene, camera: camera.clone() }
        };
        let settings = Settings { width: 1, ..row().1 };
        let seen = f64::from(film(at, settings, 0..SAMPLES).mean(0, 1));
        let expected = trapezoid(degrees, 30.0, 0.0, 90.0);
        assert!((seen - expected).abs() < 0.012, "at {degrees}°: {seen}, and {expected} is expected");
    }
}

/// A point light of intensity 1 goes along (x, 1, 0), x from 0 to 1, over a white floor: the origin gets the mean of
/// 1 / (1 + x²)^{3/2}, which is 1/√2, and sends 1/π of it everywhere.
#[test]
fn a_light_that_moves() {
    let at = |t: f64| {
        let mut scene = Scene::default();
        let mut floor = quad([-1.0, 1.0], [-1.0, 1.0]);
        floor.positions.iter_mut().for_each(|p| *p = Vec3::new(p.x, 0.0, -p.y));
        add(&mut scene, floor, lambert(1.0));
        scene.lights.push(Light {
            name: String::new(),
            kind: LightKind::Point,
            intensity: Vec3::ONE,
            position: Vec3::new(part(t), 1.0, 0.0),
            direction: Vec3::NEG_Y,
            range: None,
        });
        Moment { scene, camera: parallel(Vec3::ZERO, Vec3::new(0.0, 1.0, 3.0), 1e-4) }
    };
    let settings =
        Settings { width: 1, path: PathOptions { bounces: 1, ..PathOptions::default() }, ..row().1 };
    let seen = f64::from(film(at, settings, 0..SAMPLES).mean(0, 1));
    let expected = std::f64::consts::FRAC_1_SQRT_2 * std::f64::consts::FRAC_1_PI;
    assert!((seen / expected - 1.0).abs() < 4e-3, "{seen}, and {expected} is expected");
}

/// Parts of a moving picture add to the whole to the bit; what does not move has the picture of a moment to the bit; the name of
/// the picture depends on the shutter and on how things move.
#[test]
fn parts_stillness_and_names() {
    let (camera, settings) = row();
    let scene = |x: f32| {
        let mut scene = Scene::default();
        add(&mut scene, quad([-0.3 + x, 0.3 + x], [-1.0, 1.0]), lamp(1.0));
        scene
    };
    let at = |t: f64| Moment { scene: scene(part(t)), camera: camera.clone() };
    let whole = film(at, settings.clone(), 0..12);
    let mut parts = film(at, settings.clone(), 5..12);
    parts.merge(&film(at, settings.clone(), 0..5)).expect("they are parts of one picture");
    assert_eq!(whole, parts);

    let world = World::new(scene(0.25)).expect("sound");
    let still = Renderer::new(&world, camera.clone(), settings.clone());
    let mut expected = still.film();
    still.render(&mut expected, 0, 12, &Default::default());
    let frozen = |_| Moment { scene: scene(0.25), camera: camera.clone() };
    assert_eq!(film(frozen, settings.clone(), 0..12), expected);
    assert_ne!(whole, expected);

    let name = |shutter, digest| {
        let at = |t| Ok::<_, InvalidScene>(at(t));
        let mut series = Series::default();
        MovingRenderer::new(at, shutter, settings.clone(), digest, &mut series).expect("sound").picture_id()
    };
    assert_eq!(name(OPEN, 0), name(OPEN, 0));
    let longer = Shutter { close: 4.5, ..OPEN };
    assert_ne!(name(OPEN, 0), name(longer, 0));
    assert_ne!(name(OPEN, 0), name(Shutter { moments: 1, ..OPEN }, 0));
    assert_ne!(name(OPEN, 0), name(OPEN, 1));
    assert_ne!(name(OPEN, 0), still.picture_id());
}
