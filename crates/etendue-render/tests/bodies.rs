//! Light inside of things: skin, glass, absorption, overlapping bodies, against what must come out.
mod common;
use common::*;
use etendue_bxdf::bssrdf::SubsurfaceParams;
use etendue_bxdf::dielectric::{DielectricParams, ThinSheetParams};
use etendue_bxdf::fresnel::dielectric;
use etendue_bxdf::model::{Incidence, Model, ModelParams};
use etendue_bxdf::{Bsdf, quadrature::directional_albedo};
use etendue_color::Spectrum;
use etendue_render::World;
use etendue_scene::{Material, Scene, Substitute};
use glam::{Vec3, Vec3A};

fn world(scene: Scene) -> World {
    World::new(scene).expect("a sound scene")
}

fn of(model: Model) -> Material {
    Material {
        substitute: Some(Substitute::Model(Box::new(model))),
        double_sided: true,
        ..Material::default()
    }
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

/// Glass that absorbs nothing is not seen under an even sky, whatever its form and index; what refraction compresses on the
/// way in it gives back on the way out.
#[test]
fn clear_glass_under_a_white_sky_vanishes() {
    for (ior, dispersion, smooth) in
        [(1.5, 0.0, false), (2.4, 0.0, false), (1.33, 0.0, true), (1.5, 1.0, false)]
    {
        let glass = DielectricParams { ior, dispersion, ..DielectricParams::default() };
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, sphere(Vec3::ZERO, 1.0, 24, smooth), of(Model::Dielectric(glass)));
        let w = world(s);
        let film = render(&w, &parallel(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), 1.2), &settings(32, 4096), 64);
        // Smooth normals lean over their facets, which takes away what they would see below them.
        expect(&format!("glass {ior} {dispersion} {smooth}"), &film, 1.0, if smooth { 5e-3 } else { 0.0 });
    }
}

/// A slab of a medium between two parallel planes, `thickness` thick.
fn slab(scene: &mut Scene, top: f32, thickness: f32, material: Material) {
    add(scene, rectangle(Vec3::new(0.0, top, 0.0), 50.0, 50.0), material.clone());
    let mut below = rectangle(Vec3::new(0.0, top - thickness, 0.0), 50.0, 50.0);
    below.indices.iter_mut().for_each(|t| t.swap(1, 2));
    let m = scene.materials.len() as u32 - 1;
    add(scene, below, material);
    // Both faces bound one body.
    if let Some(i) = scene.instances.last_mut() {
        i.material = Some(m);
    }
}

/// What a slab returns and lets through at normal incidence: the sum over all reflections between its faces.
fn slab_sum(ior: f64, passes: f64) -> f64 {
    let r = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let through = (1.0 - r).powi(2) * passes / (1.0 - (r * passes).powi(2));
    r + (1.0 - r).powi(2) * r * passes * passes / (1.0 - (r * passes).powi(2)) + through
}

#[test]
fn a_slab_absorbs_by_the_way_that_light_goes_in_it() {
    for (ior, passes) in [(1.5, 0.5f32), (2.0, 0.1), (1.0, 0.7)] {
        let p = DielectricParams {
            ior,
            absorption_color: Spectrum::splat(passes),
            absorption_distance: 0.25,
            ..DielectricParams::default()
        };
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        slab(&mut s, 0.0, 0.25, of(Model::Dielectric(p)));
        let film = render(&world(s), &parallel(Vec3::ZERO, Vec3::Y, 0.5), &settings(16, 64), 1024);
        expect(&format!("slab {ior}"), &film, slab_sum(f64::from(ior), f64::from(passes)), 2e-4);
    }
}

/// Two media of the same index overlap: the one that goes first fills the overlap, and no border is seen.
#[test]
fn where_bodies_overlap_the_first_one_absorbs() {
    let medium = |passes: f32, priority: f32| {
        let p = DielectricParams {
            ior: 1.0,
            absorption_color: Spectrum::splat(passes),
            absorption_distance: 1.0,
            priority,
            ..DielectricParams::default()
        };
        of(Model::Dielectric(p))
    };
    // Two metres each; one metre is in both.
    for (first, second) in [(1.0, 0.0), (0.0, 1.0)] {
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        slab(&mut s, 2.0, 2.0, medium(0.8, first));
        slab(&mut s, 1.0, 2.0, medium(0.5, second));
        let film = render(&world(s), &parallel(Vec3::Y * 5.0, Vec3::Y, 0.5), &settings(8, 64), 4096);
        let expected = if first > second { 0.8 * 0.8 * 0.5 } else { 0.8 * 0.5 * 0.5 };
        expect("overlap", &film, expected, 1e-5);
    }
}

/// A pane: reflection and transmission of both faces together, at an angle.
#[test]
fn a_pane_reflects_as_two_faces_do() {
    let (ior, cos) = (1.5f32, 0.4f32);
    let pane = ThinSheetParams { ior, ..ThinSheetParams::default() };
    let mut s = Scene::default();
    add(&mut s, rectangle(Vec3::ZERO, 100.0, 100.0), of(Model::ThinSheet(pane)));
    // What lies above shines with 1, what lies below with 0.
    let mut dome = rectangle(Vec3::new(0.0, 200.0, 0.0), 5000.0, 5000.0);
    dome.indices.iter_mut().for_each(|t| t.swap(1, 2));
    add(&mut s, dome, lamp(1.0));
    let direction = Vec3::new((1.0 - cos * cos).sqrt(), cos, 0.0);
    let film = render(&world(s), &parallel(Vec3::ZERO, direction, 0.2), &settings(16, 4), 1024);
    let r = f64::from(dielectric(cos, ior));
    expect("pane", &film, 2.0 * r / (1.0 + r), 0.0);
}

/// A sheet that scatters what it lets through is as bright below as its colour says, and finds its light by asking for it.
#[test]
fn paper_lit_from_behind_glows() {
    let paper = ThinSheetParams {
        fibers: 1.0,
        reflect_color: Spectrum::splat(0.3),
        transmit_color: Spectrum::splat(0.4),
        ..ThinSheetParams::default()
    };
    for (from, share) in [(Vec3::NEG_Y, 0.4), (Vec3::Y, 0.3)] {
        let mut s = Scene::default();
        add(&mut s, rectangle(Vec3::ZERO, 100.0, 100.0), of(Model::ThinSheet(paper)));
        add(&mut s, sphere(Vec3::new(0.0, 10.0, 0.0), 0.5, 24, false), lamp(100.0));
        let film = render(&world(s), &parallel(Vec3::ZERO, from, 0.05), &settings(8, 3), 512);
        // Irradiance from a sphere: π L (radius / distance)², straight above.
        expect("paper", &film, share * 100.0 * (0.5f64 / 10.0).powi(2), 0.01);
    }
}
