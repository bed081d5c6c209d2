//! Scenes whose picture is known in closed form or by quadrature.
mod common;
use common::*;
use etendue_bxdf::{MetalRough, MetalRoughParams};
use etendue_color::Spectrum;
use etendue_image::{Image, Pixels};
use etendue_render::World;
use etendue_scene::{
    AlphaMode, Camera, Environment, Light, LightKind, LightProfile, Material, Sampler, Scene, Texture,
    TextureRef, Web,
};
use glam::{Vec3, Vec3A};
use std::f64::consts::PI;
use std::sync::Arc;

fn world(scene: Scene) -> World {
    World::new(scene).expect("a sound scene")
}

#[test]
fn white_sphere_under_a_white_sky_vanishes() {
    for smooth in [false, true] {
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, sphere(Vec3::ZERO, 1.0, 48, smooth), lambert(1.0));
        let w = world(s);
        let film = render(&w, &parallel(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), 0.65), &settings(24, 16), 64);
        // Smooth normals lean over their facets, which takes away what they would see below them.
        expect("white sphere", &film, 1.0, if smooth { 5e-3 } else { 0.0 });
    }
}

#[test]
fn furnace_holds_the_partial_sum_of_bounces() {
    let (le, rho) = (0.7, 0.8f32);
    let mut s = Scene::default();
    add(&mut s, sphere(Vec3::ZERO, 1.0, 16, false), Material { emissive: Vec3::splat(le), ..lambert(rho) });
    let w = world(s);
    let camera = Camera::look_at(Vec3::new(0.1, -0.2, 0.3), Vec3::X, Vec3::Y, 1.2);
    for bounces in [0, 1, 2, 3, 4, 8, 16, 32, 64] {
        let film = render(&w, &camera, &settings(16, bounces), 64);
        let rho = f64::from(rho);
        let expected = f64::from(le) * (1.0 - rho.powi(bounces as i32 + 1)) / (1.0 - rho);
        expect(&format!("furnace, {bounces} bounces"), &film, expected, 0.0);
    }
}

/// A plane seen at a fixed angle under a white sky shows its directional albedo.
#[test]
fn metal_rough_shows_its_directional_albedo() {
    for metallic in [0.0f32, 0.5, 1.0] {
        for roughness in [0.0f32, 0.05, 0.1, 0.3, 0.5, 0.75, 1.0] {
            let base = 0.8f32;
            let m = Material { base_color: Vec3::splat(base), metallic, roughness, ..Material::default() };
            let mut s = Scene { environment: sky(1.0), ..Scene::default() };
            add(&mut s, rectangle(Vec3::ZERO, 10.0, 10.0), m);
            let w = world(s);
            let closure = MetalRough::new(&MetalRoughParams {
                base_color: Spectrum::rgb(base, base, base),
                metallic,
                roughness,
                ..MetalRoughParams::default()
            });
            for cos in [1.0f32, 0.6, 0.2] {
                let sin = (1.0 - cos * cos).sqrt();
                let film =
                    render(&w, &parallel(Vec3::ZERO, Vec3::new(sin, cos, 0.0), 0.1), &settings(16, 4), 64);
                let expected =
                    etendue_bxdf::quadrature::directional_albedo(&closure, Vec3A::new(sin, 0.0, cos));
                expect(
                    &format!("metallic {metallic}, roughness {roughness}, cos {cos}"),
                    &film,
                    f64::from(expected[1]),
                    1e-3,
                );
            }
        }
    }
}

/// The same on a sphere: the picture's mean is the albedo's mean over the disk.
#[test]
fn metal_rough_sphere_shows_the_albedo_of_all_angles() {
    for roughness in [0.2f32, 0.6, 1.0] {
        let m = Material { base_color: Vec3::ONE, metallic: 1.0, roughness, ..Material::default() };
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, sphere(Vec3::ZERO, 1.0, 200, true), m);
        let w = world(s);
        let closure = MetalRough::new(&MetalRoughParams {
            base_color: Spectrum::rgb(1.0, 1.0, 1.0),
            metallic: 1.0,
            roughness,
            ..MetalRoughParams::default()
        });
        // A square of half side 0.5 within the disk.
        let film = render(&w, &parallel(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.5), 0.5), &settings(24, 4), 64);
        let n = 24;
        let mut expected = 0.0;
        for i in 0..n * n {
            let at = |k: i32| (k as f32 + 0.5) / n as f32 - 0.5;
            let r2 = at(i % n).powi(2) + at(i / n).powi(2);
            let wo = Vec3A::new(r2.sqrt(), 0.0, (1.0 - r2).sqrt());
            let a = etendue_bxdf::quadrature::directional_albedo(&closure, wo);
            expected += f64::from(a[1]) / f64::from(n * n);
        }
        expect(&format!("sphere, roughness {roughness}"), &film, expected, 4e-3);
    }
}

/// Radiance of a white floor at the origin, seen from low at the side, under whatever `make` adds.
fn floor(make: impl FnOnce(&mut Scene)) -> (World, Camera) {
    let mut s = Scene::default();
    add(&mut s, rectangle(Vec3::ZERO, 50.0, 50.0), lambert(1.0));
    make(&mut s);
    (world(s), parallel(Vec3::ZERO, Vec3::new(3.0, 0.3, 0.0), 1e-3))
}

fn light(kind: LightKind) -> Light {
    Light {
        name: String::new(),
        kind,
        intensity: Vec3::splat(5.0),
        position: Vec3::new(1.0, 2.0, 0.0),
        direction: Vec3::new(-1.0, -2.0, 0.0).normalize(),
        range: None,
    }
}

#[test]
fn punctual_lights_follow_their_laws() {
    // Towards the light at (1, 2, 0): distance² 5, cosine 2/√5; Lambert's 1/π.
    let cos = 2.0 / 5f64.sqrt();
    let point = 5.0 / 5.0 * cos / PI;
    let at = |l: Light| {
        let (w, c) = floor(|s| s.lights.push(l));
        render(&w, &c, &settings(4, 1), 4)
    };
    expect("point", &at(light(LightKind::Point)), point, 1e-4);
    expect("directional", &at(light(LightKind::Directional)), 5.0 * cos / PI, 1e-5);
    let range = Some(4.0);
    // (d/r)⁴ = (5/16)².
    let window = 1.0 - (5.0f64 / 16.0).powi(2);
    expect("range", &at(Light { range, ..light(LightKind::Point) }), point * window, 1e-4);
    let spot = LightKind::Spot { inner: 0.3, outer: 0.6 };
    expect("spot, axis", &at(light(spot)), point, 1e-4);
    // Turned aside by 0.45 rad: between inner and outer, squared.
    let (s, c) = 0.45f32.sin_cos();
    let d = light(spot).direction;
    let aside = Vec3::new(d.x * c - d.y * s, d.x * s + d.y * c, 0.0);
    let fall = ((0.45f64.cos() - 0.6f64.cos()) / (0.3f64.cos() - 0.6f64.cos())).powi(2);
    expect("spot, aside", &at(Light { direction: aside, ..light(spot) }), point * fall, 1e-4);
    let off = Light { direction: Vec3::Y, ..light(spot) };
    assert_eq!(mean(&at(off)).0, 0.0);
}

/// A lamp that shines more to one side than to the other, among others that are as strong.
#[test]
fn measured_lamps_shine_as_they_were_measured() {
    // 10 + angle from the aim + a tenth of the angle about it.
    let vertical: Vec<f32> = (0..=18).map(|k| 10.0 * k as f32).collect();
    let horizontal: Vec<f32> = (0..=12).map(|k| 30.0 * k as f32).collect();
    let value = |v: f64, h: f64| 10.0 + v + 0.1 * h;
    let candela =
        horizontal.iter().flat_map(|h| vertical.iter().map(|v| value((*v).into(), (*h).into()) as f32));
    let profile = LightProfile::new(Web::C, vertical.clone(), horizontal.clone(), candela.collect());
    let profile = Arc::new(profile.expect("a profile"));
    // At (1, 2, 0), aimed along −X; the origin is at 63.43° from that, downwards. Horizontal angle 0 is up (+Y), 90° is side × aim = +Z,
    // so that down is 180°.
    let lamp = Light {
        direction: Vec3::NEG_X,
        intensity: Vec3::splat(0.5),
        ..light(LightKind::Profile { profile: 0, side: Vec3::Y })
    };
    let cos = 2.0 / 5f64.sqrt();
    let expected = 0.5 * value(2f64.atan2(1.0).to_degrees(), 180.0) / 5.0 * cos / PI;
    let (w, c) = floor(|s| {
        s.profiles.push(profile.clone());
        s.lights.push(lamp.clone());
    });
    expect("profile", &render(&w, &c, &settings(4, 1), 4), expected, 1e-4);
    // Beside a point light, one of the two is drawn at a time.
    let point = 5.0 / 5.0 * cos / PI;
    let (w, c) = floor(|s| {
        s.profiles.push(profile.clone());
        s.lights.extend([light(LightKind::Point), lamp.clone()]);
    });
    expect("profile and point", &render(&w, &c, &settings(16, 1), 1024), expected + point, 3e-3);
    // Turned about its aim by a quarter: 90° is side × aim = −Y, where the origin is.
    let side = Vec3::Z;
    let (w, c) = floor(|s| {
        s.profiles.push(profile.clone());
        s.lights.push(Light { kind: LightKind::Profile { profile: 0, side }, ..lamp.clone() });
    });
    let turned = 0.5 * value(2f64.atan2(1.0).to_degrees(), 90.0) / 5.0 * cos / PI;
    expect("profile, turned", &render(&w, &c, &settings(4, 1), 4), turned, 1e-4);
}

#[test]
fn many_punctual_lights_add_up() {
    let n = 300;
    let place = |i: u32| {
        let a = i as f32 * 2.399_963;
        let r = 0.3 + 0.02 * i as f32;
        Vec3::new(r * a.cos(), 0.5 + (i % 7) as f32 * 0.4, r * a.sin())
    };
    let (w, c) = floor(|s| {
        for i in 0..n {
            s.lights.push(Light {
                position: place(i),
                intensity: Vec3::splat(0.1 + (i % 5) as f32),
                ..light(LightKind::Point)
            });
        }
    });
    let expected: f64 = (0..n)
        .map(|i| {
            let p = place(i).as_dvec3();
            (0.1 + f64::from(i % 5)) * p.y / p.length().powi(3) / PI
        })
        .sum();
    expect("300 lights", &render(&w, &c, &settings(16, 1), 256), expected, 1e-4);
}

/// Irradiance from a parallel rectangle of half sides a, b at height h over the point below its centre: four times the corner
/// formula (Siegel and Howell 2001, configuration factor C-11).
fn rectangle_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    4.0 / (2.0 * PI) * (x / p * (y / p).atan() + y / q * (x / q).atan())
}

#[test]
fn area_lights_match_form_factors() {
    for h in [4.0f32, 1.0, 0.5, 0.2] {
        let (w, c) = floor(|s| add(s, rectangle(Vec3::new(0.0, h, 0.0), 1.0, 0.5), lamp(3.0)));
        let film = render(&w, &c, &settings(16, 1), 256);
        expect(&format!("rectangle at {h}"), &film, 3.0 * rectangle_factor(1.0, 0.5, f64::from(h)), 1e-4);
    }
    for (r, d) in [(0.5f32, 2.0f32), (0.9, 1.0), (0.05, 3.0)] {
        let (w, c) = floor(|s| add(s, sphere(Vec3::new(0.0, d, 0.0), r, 96, false), lamp(3.0)));
        let film = render(&w, &c, &settings(16, 1), 256);
        expect(&format!("sphere {r} at {d}"), &film, 3.0 * f64::from(r / d).powi(2), 1.5e-3);
    }
}

/// Half of the lamp's texture is black: half of a small far lamp's light arrives, and nothing is lost or doubled between
/// light sampling and scattering.
#[test]
fn textured_emission_is_sampled_without_bias() {
    let mut p = vec![0u8; 64 * 64 * 3];
    for (i, v) in p.iter_mut().enumerate() {
        *v = if (i / 3 % 64) < 32 { 255 } else { 0 };
    }
    let (w, c) = floor(|s| {
        s.images.push(Arc::new(Image { width: 64, height: 64, channels: 3, pixels: Pixels::U8(p) }));
        s.textures.push(Texture { image: 0, sampler: Sampler::default() });
        let m = Material { emissive_texture: Some(TextureRef::new(0)), ..lamp(3.0) };
        add(s, rectangle(Vec3::new(0.0, 1.0, 0.0), 1.0, 1.0), m);
    });
    // Symmetric about the middle: exactly half the full rectangle (the filtered edges cancel).
    expect(
        "half-lit lamp",
        &render(&w, &c, &settings(16, 1), 512),
        1.5 * rectangle_factor(1.0, 1.0, 1.0),
        1e-3,
    );
}

/// A sky with a sun: light sampling and scattering together give the irradiance by quadrature.
#[test]
fn sky_light_matches_quadrature() {
    let (width, height) = (64u32, 32u32);
    let texel = |x: u32, y: u32| {
        if (40..42).contains(&x) && (5..7).contains(&y) {
            300.0
        } else {
            0.2 + 0.6 * (y < 16) as u32 as f32 + 0.01 * x as f32
        }
    };
    let pixels: Vec<f32> = (0..width * height).flat_map(|i| [texel(i % width, i / width); 3]).collect();
    let image = Arc::new(Image { width, height, channels: 3, pixels: Pixels::F32(pixels) });
    for rotation in [0.0f32, 2.0] {
        let (w, c) = floor(|s| {
            s.environment = Environment::LatLong { image: image.clone(), rotation, intensity: 0.5 }
        });
        let sky = etendue_render::Sky::new(&w.scene().environment);
        let (n, mut e) = (1024, 0.0);
        for j in 0..n {
            let cos = (f64::from(j) + 0.5) / f64::from(n);
            let sin = (1.0 - cos * cos).sqrt();
            for i in 0..2 * n {
                let phi = PI * (f64::from(i) + 0.5) / f64::from(n);
                let d = Vec3A::new((sin * phi.cos()) as f32, cos as f32, (sin * phi.sin()) as f32);
                e += f64::from(sky.radiance(d)[1]) * cos;
            }
        }
        let irradiance = e * 2.0 * PI / f64::from(2 * n * n);
        expect("sun and sky", &render(&w, &c, &settings(16, 1), 256), irradiance / PI, 2e-3);
    }
}

/// Coverage: three sheets of alpha 0.25 over a white sky; and a mask that keeps or drops whole surfaces.
#[test]
fn alpha_lets_light_through() {
    let sheet = |alpha: f32, mode: AlphaMode| Material { alpha, alpha_mode: mode, ..lambert(0.0) };
    let at = |m: Material, count: u32| {
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        for k in 0..count {
            add(&mut s, rectangle(Vec3::new(0.0, k as f32, 0.0), 100.0, 100.0), m.clone());
        }
        render(&world(s), &parallel(Vec3::ZERO, Vec3::new(1.0, 9.0, 0.0), 0.1), &settings(16, 2), 256)
    };
    expect("three sheets", &at(sheet(0.25, AlphaMode::Blend), 3), 0.75f64.powi(3), 0.0);
    expect("mask below", &at(sheet(0.25, AlphaMode::Mask(0.5)), 2), 1.0, 0.0);
    assert_eq!(mean(&at(sheet(0.5, AlphaMode::Mask(0.5)), 1)).0, 0.0);
    // Light through the sheet to a floor: shadow rays are let through in the same share.
    let (w, c) = floor(|s| {
        s.lights.push(light(LightKind::Directional));
        add(s, rectangle(Vec3::new(0.0, 0.4, 0.0), 50.0, 50.0), sheet(0.25, AlphaMode::Blend));
    });
    // The camera itself stands below the sheet.
    let expected = 0.75 * 5.0 * 2.0 / 5f64.sqrt() / PI;
    expect("shadow of a sheet", &render(&w, &c, &settings(16, 1), 1024), expected, 1e-4);
}

/// Unlit shows its colour; a one-sided surface is looked through from behind.
#[test]
fn unlit_and_single_sided() {
    let m = Material { unlit: true, base_color: Vec3::splat(0.37), ..Material::default() };
    let mut s = Scene { environment: sky(2.0), ..Scene::default() };
    add(&mut s, rectangle(Vec3::ZERO, 10.0, 10.0), m);
    let w = world(s);
    expect("unlit", &render(&w, &parallel(Vec3::ZERO, Vec3::Y, 0.1), &settings(4, 3), 4), 0.37, 0.0);
    expect("from behind", &render(&w, &parallel(Vec3::ZERO, Vec3::NEG_Y, 0.1), &settings(4, 3), 4), 2.0, 0.0);
}
