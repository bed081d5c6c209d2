//! The same bits, however the samples are divided.
mod common;
use common::*;
use etendue_render::{Counters, Film, FilmInfo, Pass, PassSet, Renderer, SampleRanges, Settings, World};
use etendue_scene::{AlphaMode, Camera, Light, LightKind, Material, Scene};
use glam::Vec3;

/// A scene with everything that draws random numbers: blend, lamps, glossy metal, a point light.
fn world() -> World {
    let mut s = Scene { environment: sky(0.3), ..Scene::default() };
    add(&mut s, rectangle(Vec3::ZERO, 5.0, 5.0), lambert(0.7));
    add(&mut s, rectangle(Vec3::new(0.0, 3.0, 0.0), 0.5, 0.5), lamp(9.0));
    let gold = Material { base_color: Vec3::new(1.0, 0.7, 0.3), roughness: 0.2, ..Material::default() };
    add(&mut s, sphere(Vec3::new(0.4, 0.8, 0.0), 0.8, 24, true), gold);
    let veil = Material { alpha: 0.4, alpha_mode: AlphaMode::Blend, ..lambert(0.5) };
    add(&mut s, sphere(Vec3::new(-1.0, 0.5, 0.5), 0.5, 12, true), veil);
    s.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point,
        intensity: Vec3::splat(2.0),
        position: Vec3::new(-2.0, 2.0, 2.0),
        direction: Vec3::NEG_Y,
        range: None,
    });
    World::new(s).expect("a sound scene")
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 2.0, 5.0), Vec3::new(0.0, 0.6, 0.0), Vec3::Y, 0.7)
}

fn all_settings() -> Settings {
    Settings { width: 40, height: 30, passes: PassSet::all(), ..settings(0, 5) }
}

fn take(r: &Renderer, ranges: &[(u32, u32)]) -> Film {
    let mut film = r.film();
    for &(a, b) in ranges {
        r.render(&mut film, a, b, &Counters::default());
    }
    film
}

#[test]
fn one_two_and_seven_threads_give_the_same_bits() {
    let w = world();
    let r = Renderer::new(&w, camera(), all_settings());
    let films: Vec<Film> = [1, 2, 7]
        .map(|n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| take(&r, &[(0, 24)]))
        })
        .into();
    assert!(films[0].beauty().iter().any(|p| p[0] > 0.0));
    assert!(films[0] == films[1] && films[0] == films[2]);
}

#[test]
fn any_partition_merges_to_the_same_bits() {
    let w = world();
    let r = Renderer::new(&w, camera(), all_settings());
    let whole = take(&r, &[(0, 24)]);
    for cuts in [&[1u32, 2, 7][..], &[12], &[3, 9, 20, 23]] {
        let mut edges = vec![0];
        edges.extend(cuts);
        edges.push(24);
        let mut parts: Vec<Film> = edges.windows(2).map(|e| take(&r, &[(e[0], e[1])])).collect();
        parts.reverse();
        let mut sum = parts.remove(0);
        parts.iter().for_each(|p| sum.merge(p).unwrap());
        assert!(sum == whole, "cut at {cuts:?}");
    }
    // Breaks if a sample is counted twice or lost.
    assert!(take(&r, &[(0, 23)]) != whole);
}

#[test]
fn a_saved_and_continued_film_is_the_uninterrupted_one() {
    let w = world();
    let r = Renderer::new(&w, camera(), all_settings());
    let bytes = take(&r, &[(0, 5)]).to_bytes(&FilmInfo::default());
    let (mut film, _) = Film::from_bytes(&bytes).unwrap();
    r.render(&mut film, 5, 24, &Counters::default());
    assert!(film == take(&r, &[(0, 24)]));
    assert_eq!(film.ranges, SampleRanges::new([(0, 24)]).unwrap());
}

#[test]
fn another_seed_scene_camera_or_setting_is_another_picture() {
    let w = world();
    let id = |s: Settings, c: Camera| Renderer::new(&w, c, s).picture_id();
    let base = id(all_settings(), camera());
    assert_eq!(base, id(all_settings(), camera()));
    assert_ne!(base, id(Settings { seed: 1, ..all_settings() }, camera()));
    assert_ne!(base, id(Settings { width: 41, ..all_settings() }, camera()));
    let mut moved = camera();
    moved.transform.translation.x += 1e-4;
    assert_ne!(base, id(all_settings(), moved));
    let mut s = Scene::default();
    add(&mut s, rectangle(Vec3::ZERO, 5.0, 5.0), lambert(0.7));
    let other = World::new(s).unwrap();
    assert_ne!(base, Renderer::new(&other, camera(), all_settings()).picture_id());
}

/// Passes are parts of the beauty picture: emission, sky, direct and indirect add up to it, and so do emission, sky, diffuse
/// and specular.
#[test]
fn passes_add_up_to_the_beauty_picture() {
    let w = world();
    let r = Renderer::new(&w, camera(), all_settings());
    let film = take(&r, &[(0, 16)]);
    let names = etendue_render::id_names(w.scene());
    let (layers, _) = film.layers(false, &names);
    let plane = |layer: &str, c: usize| {
        let l = layers.iter().find(|l| l.name == layer).unwrap();
        match &l.channels[c].1 {
            etendue_image::ChannelData::Color(v) | etendue_image::ChannelData::F32(v) => v.clone(),
            _ => panic!("{layer} holds integers"),
        }
    };
    let mut seen = [false; 4];
    for c in 0..3 {
        let get = |l: &str| plane(l, c);
        let (all, emission, sky) = (get(""), get(Pass::Emission.name()), get(Pass::Environment.name()));
        let (direct, indirect, diffuse, specular) =
            (get("direct"), get("indirect"), get("diffuse"), get("specular"));
        for i in 0..all.len() {
            let rest = all[i] - emission[i] - sky[i];
            assert!((rest - direct[i] - indirect[i]).abs() < 1e-4 * all[i].max(1.0), "pixel {i}");
            assert!((rest - diffuse[i] - specular[i]).abs() < 1e-4 * all[i].max(1.0), "pixel {i}");
            for (s, v) in seen.iter_mut().zip([direct[i], indirect[i], diffuse[i], specular[i]]) {
                *s |= v > 0.01;
            }
        }
    }
    assert_eq!(seen, [true; 4]);
    let normal = plane("normal", 1);
    assert!(normal.iter().all(|n| n.is_finite() && n.abs() <= 1.001));
}

/// The walk is compiled for pictures with and without passes, and for scenes of core materials and others: each gives the
/// same picture, and single samples are what the film adds.
#[test]
fn passes_and_single_samples_are_of_the_same_picture() {
    let w = world();
    let with = Renderer::new(&w, camera(), all_settings());
    let without = Renderer::new(&w, camera(), Settings { passes: PassSet::default(), ..all_settings() });
    let (a, b) = (take(&with, &[(0, 4)]), take(&without, &[(0, 4)]));
    assert!(a.beauty() == b.beauty());
    for (x, y) in [(3, 4), (20, 15), (22, 11), (39, 29)] {
        let mean = (0..4).map(|i| f64::from(without.sample(x, y, i).0.0[0])).sum::<f64>() / 4.0;
        let film = f64::from(b.beauty()[(y * 40 + x) as usize][0]);
        assert!((mean - film).abs() <= 1e-6 * mean.abs(), "{x} {y}: {mean} {film}");
    }
}
