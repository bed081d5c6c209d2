//! Light inside of things: skin, glass, absorption, overlapping bodies, against what must come out.
mod common;
use common::*;
use etendue_bxdf::bssrdf::SubsurfaceParams;
use etendue_bxdf::model::{Incidence, Model, ModelParams};
use etendue_bxdf::{Bsdf, quadrature::directional_albedo};
use etendue_color::Spectrum;
use etendue_render::World;
use etendue_scene::{Material, Scene};
use glam::{Vec3, Vec3A};

fn world(scene: Scene) -> World {
    World::new(scene).expect("a sound scene")
}

fn of(model: Model) -> Material {
    Material { model: Some(Box::new(model)), ..Material::default() }
}

fn skin(albedo: f32, radius: f32) -> SubsurfaceParams {
    SubsurfaceParams {
        color: Spectrum::splat(albedo),
        radius: Spectrum::splat(radius),
        ..SubsurfaceParams::default()
    }
}

/// What a plane of skin returns of an even sky: its gloss, and of the rest the albedo.
fn plane_of_skin(p: &SubsurfaceParams, cos: f32) -> f64 {
    let wo = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let gloss = p.gloss();
    let white = SubsurfaceParams { color: Spectrum::ONE, ..*p }.closure(&Incidence::default());
    let through = white.albedo(wo)[1] - gloss.albedo(wo)[1];
    f64::from(directional_albedo(&gloss, wo)[1] + through * p.color[1])
}

/// A plane is as bright as its albedo says however far light travels in it.
#[test]
fn skin_on_a_plane_has_its_albedo() {
    for (albedo, radius, cos) in
        [(0.8, 0.01, 1.0), (0.8, 1.0, 0.7), (0.3, 0.3, 0.3), (0.99, 0.05, 0.9), (0.6, 0.0, 0.5)]
    {
        let p = skin(albedo, radius);
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, rectangle(Vec3::ZERO, 100.0, 100.0), of(Model::Subsurface(p)));
        let w = world(s);
        let direction = Vec3::new((1.0f32 - cos * cos).sqrt(), cos, 0.0);
        let film = render(&w, &parallel(Vec3::ZERO, direction, 0.1), &settings(16, 4), 256);
        expect(&format!("skin {albedo} {radius} {cos}"), &film, plane_of_skin(&p, cos), 2e-3);
    }
}

/// Light that travels much less far than the body is large looks like light that does not travel.
#[test]
fn short_paths_under_the_skin_are_lamberts() {
    let lights = |p: SubsurfaceParams| {
        let mut s = Scene::default();
        add(&mut s, sphere(Vec3::ZERO, 1.0, 64, true), of(Model::Subsurface(p)));
        add(&mut s, rectangle(Vec3::new(0.0, 3.0, 0.0), 1.0, 1.0), lamp(5.0));
        let w = world(s);
        mean(&render(&w, &parallel(Vec3::ZERO, Vec3::new(1.0, 1.0, 1.0), 1.1), &settings(32, 3), 256))
    };
    let ((a, ea), (b, eb)) = (lights(skin(0.7, 0.0)), lights(skin(0.7, 0.004)));
    println!("stays {a} ± {ea}, travels 4 mm {b} ± {eb}");
    assert!((a - b).abs() < 4.0 * (ea + eb) + 0.01 * a, "{a} {b}");
    // A body that is as small as the paths loses light and is lit on its dark side.
    let (c, _) = lights(skin(0.7, 1.0));
    assert!((a - c).abs() > 0.05 * a, "{a} {c}");
}
