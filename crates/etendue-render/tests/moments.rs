//! Moments of a picture that share what does not move, against worlds of their own; and how moments are shared out.
mod common;

use common::{add, lambert, lamp, parallel, rectangle, sphere};
use etendue_image::{Image, Pixels};
use etendue_render::{
    Film, Filter, Fixed, Moment, MovingRenderer, PathOptions, Renderer, Series, Settings, Shutter, World,
};
use etendue_scene::{
    AlphaMode, Camera, Environment, InvalidScene, Light, LightKind, Mesh, Sampler, Scene, Texture, TextureRef,
};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// A picture of `n` × `n` coloured squares.
fn squares(n: u32, scale: f32) -> Arc<Image> {
    let value = |k: u32| scale * ((k * 7 + k / n * 3) % 5) as f32 / 4.0;
    let pixels = Pixels::F32((0..n * n * 3).map(value).collect());
    Arc::new(Image { width: n, height: n, channels: 3, pixels })
}

/// Things of all kinds, some at rest, some not.
struct Stage {
    rest: Scene,
    sky: Arc<Image>,
    /// Nothing moves but a light.
    dark: bool,
}

impl Stage {
    fn new() -> Self {
        let mut rest = Scene::default();
        // Enough triangles at rest for a tree of their own.
        add(&mut rest, sphere(Vec3::new(-1.2, 0.0, 0.0), 0.8, 40, true), lambert(0.7));
        add(&mut rest, rectangle(Vec3::new(0.0, -1.0, 0.0), 4.0, 4.0), lambert(0.5));
        add(&mut rest, rectangle(Vec3::new(1.0, 1.8, 0.0), 0.4, 0.4), lamp(3.0));
        add(&mut rest, rectangle(Vec3::ZERO, 0.3, 0.3), lamp(5.0));
        add(&mut rest, sphere(Vec3::ZERO, 0.4, 12, false), lambert(0.9));
        add(&mut rest, sphere(Vec3::ZERO, 0.3, 10, true), lambert(0.4));
        // A glowing thing with a texture, which another at rest has too.
        rest.images = vec![squares(8, 1.0)];
        rest.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
        rest.materials[2].emissive_texture = Some(TextureRef::new(0));
        rest.materials[3].emissive_texture = Some(TextureRef::new(0));
        rest.materials[5].alpha_mode = AlphaMode::Blend;
        rest.materials[5].alpha = 0.6;
        // The last mesh stands in several places.
        let mut again = rest.instances[5].clone();
        again.transform = Affine3A::from_translation(Vec3::new(0.6, -0.6, 0.5));
        rest.instances.push(again);
        for position in [Vec3::Y, Vec3::new(-1.0, 2.0, 1.0)] {
            rest.lights.push(Light {
                name: String::new(),
                kind: LightKind::Point,
                intensity: Vec3::splat(2.0),
                position,
                direction: Vec3::NEG_Y,
                range: None,
            });
        }
        Self { rest, sky: squares(16, 2.0), dark: false }
    }

    fn at(&self, t: f64) -> Moment {
        let mut scene = self.rest.clone();
        let x = t as f32;
        if self.dark {
            scene.lights[0].position.x = x;
            return Moment { scene, camera: Camera::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 0.8) };
        }
        scene.instances[3].transform = Affine3A::from_translation(Vec3::new(x - 1.0, 1.5, 0.6));
        scene.instances[5].transform = Affine3A::from_rotation_y(x)
            * Affine3A::from_scale_rotation_translation(
                Vec3::new(1.0, 0.5, 1.0),
                glam::Quat::from_rotation_x(x),
                Vec3::new(0.5 * x, 0.3, 0.8),
            );
        let wave = |p: &Vec3| *p + Vec3::new(1.0, 0.2 * (6.0 * p.x + 3.0 * x).sin(), 0.3 * x);
        let shape: &Mesh = &self.rest.meshes[4];
        let positions = shape.positions.iter().map(wave).collect();
        scene.meshes[4] = Mesh { positions, ..shape.clone() }.into();
        scene.materials[4].base_color.x = x;
        scene.lights[0].position.x = x;
        scene.environment =
            Environment::LatLong { image: self.sky.clone(), rotation: 0.2 * x, intensity: 0.4 };
        let mut camera = Camera::look_at(Vec3::new(0.2 * x, 0.6, 5.0), Vec3::ZERO, Vec3::Y, 0.8);
        camera.transform.translation.y += 0.1 * x;
        Moment { scene, camera }
    }
}

const SIZE: [u32; 2] = [20, 14];

fn settings() -> Settings {
    let path = PathOptions { bounces: 3, ..PathOptions::default() };
    Settings { width: SIZE[0], height: SIZE[1], seed: 5, path, ..Settings::default() }
}

fn film(stage: &Stage, shutter: Shutter, parts: &[(u32, u32)]) -> Film {
    let at = |t| Ok::<_, InvalidScene>(stage.at(t));
    let mut series = Series::default();
    let mut r = MovingRenderer::new(at, shutter, settings(), 0, &mut series).expect("sound");
    let mut film = r.film();
    for &(from, to) in parts {
        r.render(&mut film, from, to, &Default::default()).expect("sound");
    }
    film
}

/// The mean over samples, each of a world that was made for its moment alone.
#[test]
fn moments_are_worlds_of_their_own_to_the_bit() {
    for (dark, moments) in [(false, 1), (false, 16), (true, 16)] {
        let stage = Stage { dark, ..Stage::new() };
        let shutter = Shutter { open: 0.25, close: 1.0, moments };
        let seen = film(&stage, shutter, &[(0, 6)]);
        let mut sums = vec![[Fixed::default(); 4]; (SIZE[0] * SIZE[1]) as usize];
        let mut times: Vec<(f64, u32, u32, u32)> = Vec::new();
        for i in 0..6 {
            let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
            times.extend(pixels.map(|(x, y)| (shutter.time(5, x, y, i), x, y, i)));
        }
        times.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        let distinct = times.chunk_by(|a, b| a.0 == b.0);
        assert_eq!(distinct.clone().count(), if moments == 1 { 6 } else { 16 });
        for same in distinct {
            let Moment { scene, camera } = stage.at(same[0].0);
            let world = World::new(scene).expect("sound");
            let renderer = Renderer::new(&world, camera, settings());
            for &(_, x, y, i) in same {
                let (radiance, alpha) = renderer.sample(x, y, i);
                let [r, g, b, _] = radiance.0;
                let sum = &mut sums[(y * SIZE[0] + x) as usize];
                sum.iter_mut().zip([r, g, b, alpha]).for_each(|(s, v)| s.add(Fixed::from_f32(v)));
            }
        }
        for (k, sum) in sums.iter().enumerate() {
            let expected = sum.map(|s| (s.to_f64() / 6.0) as f32);
            let got: [f32; 4] = std::array::from_fn(|p| seen.mean(k, p));
            assert_eq!(got, expected, "{moments} moments, pixel {k}");
        }
        assert_eq!(film(&stage, shutter, &[(3, 5), (0, 3), (5, 6)]), seen, "in parts");
    }
}

/// What a world takes over from the one before: everything that did not move is the same memory.
#[test]
fn worlds_share_what_stands_still() {
    let stage = Stage::new();
    let mut series = Series::default();
    let mut still = Vec::new();
    for k in 0..4 {
        let world = series.world(stage.at(0.2 * f64::from(k)).scene).expect("sound");
        still.push(world.accel().still_triangles());
    }
    // The large sphere, the floor and the lamp that hangs still; a placed sphere counts apart.
    assert_eq!(still, [0, 6244, 6244, 6244]);
    let alone = World::new(stage.at(0.6).scene).expect("sound");
    let camera = stage.at(0.6).camera;
    let name = |w: &World| Renderer::new(w, camera.clone(), settings()).picture_id();
    assert_eq!(name(series.last().expect("made")), name(&alone));
    let scene = stage.at(0.6).scene;
    assert_eq!(series.picture_id(&scene, &camera, &settings()), name(&alone));
}

/// An edge crosses the picture while the shutter is open: four samples a pixel see it at 64 moments together, so that rows have a
/// ramp on the average, where four moments for all would give four steps.
#[test]
fn few_samples_show_noise_and_no_steps() {
    let (w, h) = (64u32, 64u32);
    let at = |t: f64| {
        let mut scene = Scene::default();
        let mut m = rectangle(Vec3::ZERO, 4.0, 4.0);
        m.positions.iter_mut().for_each(|p| *p = Vec3::new(p.x - 5.0 + 2.0 * t as f32, p.z, 0.0));
        add(&mut scene, m, lamp(1.0));
        Ok::<_, InvalidScene>(Moment { scene, camera: parallel(Vec3::ZERO, Vec3::Z, 1.0) })
    };
    let settings = Settings {
        width: w,
        height: h,
        filter: Filter::Box,
        path: PathOptions { bounces: 0, ..PathOptions::default() },
        ..Settings::default()
    };
    let worst = |moments| {
        let mut series = Series::default();
        let shutter = Shutter { open: 0.0, close: 1.0, moments };
        let mut r = MovingRenderer::new(at, shutter, settings.clone(), 0, &mut series).expect("sound");
        let mut film = r.film();
        r.render(&mut film, 0, 4, &Default::default()).expect("sound");
        let column = |x: u32| (0..h).map(|y| film.mean((y * w + x) as usize, 0)).sum::<f32>() / h as f32;
        // At time t all left of −1 + 2 t is bright.
        (0..w).map(|x| (column(x) - (1.0 - (x as f32 + 0.5) / w as f32)).abs()).fold(0.0, f32::max)
    };
    let (smooth, stepped) = (worst(64), worst(1));
    assert!(smooth < 0.04, "{smooth}");
    assert!(stepped > 0.1, "{stepped}: four moments make steps of a quarter");
}
