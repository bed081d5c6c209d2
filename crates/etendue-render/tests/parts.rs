//! The picture split by where its light comes from, and the picture of lights alone.
mod common;
use common::*;
use etendue_bxdf::dielectric::ThinSheetParams;
use etendue_bxdf::model::Model;
use etendue_image::{Image, Pixels};
use etendue_render::{Film, Pass, PassSet, PathOptions, Settings, World};
use etendue_scene::{Camera, Light, LightKind, Material, Scene, Substitute};
use glam::Vec3;

fn sun(irradiance: f32) -> Light {
    Light {
        name: String::new(),
        kind: LightKind::Directional,
        position: Vec3::ZERO,
        direction: Vec3::NEG_Y,
        intensity: Vec3::splat(irradiance),
        range: None,
    }
}

fn floats(image: &Image) -> &[f32] {
    let Pixels::F32(p) = &image.pixels else { panic!("not floats") };
    p
}

/// Mean of the green channel of a pass.
fn level(film: &Film, pass: Pass) -> f64 {
    let image = film.pass(pass).expect("recorded");
    floats(&image).chunks_exact(3).map(|c| f64::from(c[1])).sum::<f64>() / film.pixels() as f64
}

fn parts(light_only: bool) -> Settings {
    let base = settings(24, 4);
    Settings { passes: PassSet::parts(), path: PathOptions { light_only, ..base.path }, ..base }
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.3, 2.0, 5.0), Vec3::new(0.0, 0.6, 0.0), Vec3::Y, 0.8)
}

/// A floor, a shiny ball, a lamp, a pane: sky, sun, emission, transmission all take part.
fn room() -> World {
    let mut s = Scene { environment: sky(0.5), ..Scene::default() };
    s.lights.push(sun(1.0));
    add(
        &mut s,
        rectangle(Vec3::ZERO, 3.0, 3.0),
        Material { roughness: 0.5, metallic: 0.0, ..Material::default() },
    );
    let gold = Material { base_color: Vec3::new(0.9, 0.7, 0.3), roughness: 0.3, ..Material::default() };
    add(&mut s, sphere(Vec3::new(-0.6, 0.7, 0.0), 0.6, 24, true), gold);
    add(&mut s, sphere(Vec3::new(0.9, 0.5, 0.6), 0.3, 12, true), lamp(2.0));
    let pane = Substitute::Model(Box::new(Model::ThinSheet(ThinSheetParams::default())));
    let pane = Material { substitute: Some(pane), double_sided: true, ..Material::default() };
    add(&mut s, sphere(Vec3::new(0.2, 1.2, 1.4), 0.25, 16, true), pane);
    World::new(s).expect("a sound scene")
}

#[test]
fn parts_add_up_to_the_picture() {
    let w = room();
    for light_only in [false, true] {
        let film = render(&w, &camera(), &parts(light_only), 16);
        let whole = film.picture(false);
        let mut sum = vec![0f32; floats(&whole).len()];
        for pass in Pass::PARTS {
            let image = film.pass(pass).expect("recorded");
            assert!(floats(&image).iter().all(|v| *v >= -1e-6), "{pass:?} is negative");
            sum.iter_mut().zip(floats(&image)).for_each(|(s, v)| *s += v);
        }
        for (s, v) in sum.iter().zip(floats(&whole)) {
            assert!((s - v).abs() <= 1e-5 * v.max(1.0), "{s} {v}");
        }
        for pass in [
            Pass::LightDiffuse,
            Pass::LightSpecular,
            Pass::SkyDiffuse,
            Pass::SkySpecular,
            Pass::Transmission,
            Pass::Emission,
            Pass::Environment,
        ] {
            assert!(level(&film, pass) > 1e-4, "{pass:?} takes no part");
        }
        for pass in [Pass::BounceDiffuse, Pass::BounceSpecular] {
            assert_eq!(level(&film, pass) > 1e-3, !light_only, "{pass:?}");
        }
    }
}

/// A floor under a roof: dark in truth, and lit as if the roof were not there when nothing stands in the way of light.
#[test]
fn lights_alone_know_no_shadow() {
    let albedo = 0.6;
    let mut s = Scene { environment: sky(1.0), ..Scene::default() };
    s.lights.push(sun(2.0));
    add(&mut s, rectangle(Vec3::ZERO, 1.0, 1.0), lambert(albedo));
    add(&mut s, rectangle(Vec3::new(0.0, 0.01, 0.0), 50.0, 50.0), lambert(0.0));
    let w = World::new(s).expect("a sound scene");
    let mut view = parallel(Vec3::new(0.0, 0.005, 0.0), Vec3::new(0.0, 1.0, 0.0), 0.4);
    // Between the two.
    view.transform.translation = Vec3::new(0.0, 0.008, 0.0).into();
    let dark = render(&w, &view, &parts(false), 64);
    let lit = render(&w, &view, &parts(true), 64);
    let albedo = f64::from(albedo);
    assert!(mean(&dark).0 < 0.02, "{}", mean(&dark).0);
    let (sky, light) = (level(&lit, Pass::SkyDiffuse), level(&lit, Pass::LightDiffuse));
    assert!((sky - albedo).abs() < 2e-3, "{sky}");
    assert!((light - albedo * 2.0 / std::f64::consts::PI).abs() < 1e-4, "{light}");
}

/// A convex body hides nothing from itself: both pictures agree.
#[test]
fn lights_alone_are_the_truth_for_a_ball() {
    let mut s = Scene { environment: sky(0.7), ..Scene::default() };
    s.lights.push(sun(1.5));
    let m = Material { base_color: Vec3::splat(0.8), metallic: 0.4, roughness: 0.35, ..Material::default() };
    add(&mut s, sphere(Vec3::ZERO, 1.0, 64, true), m);
    let w = World::new(s).expect("a sound scene");
    let view = parallel(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), 0.65);
    let [truth, alone] = [false, true].map(|a| render(&w, &view, &parts(a), 64));
    for pass in [Pass::LightDiffuse, Pass::LightSpecular, Pass::SkyDiffuse, Pass::SkySpecular] {
        let (a, b) = (level(&truth, pass), level(&alone, pass));
        println!("{pass:?}: {a:.5} {b:.5}");
        // Facets see a little of what lies below the smooth surface's horizon, and lose it.
        assert!((a - b).abs() < 5e-3 * a, "{pass:?}: {a} {b}");
    }
}
