//! The default's direct light is the reference's closure.

use etendue_bxdf::laws::Rng;
use etendue_bxdf::sampling::{Frame, uniform_sphere};
use etendue_bxdf::{Bsdf, GltfParams, MetalRough, multiscatter};
use etendue_color::Spectrum;
use etendue_realtime::choices::{Compensation, Coupling};
use etendue_realtime::{Choices, Inputs, Lighting, shade};
use etendue_scene::{Light, LightKind, LightProfile, Scene, Web};
use glam::{Vec3, Vec3A};

/// A scene with one light of this kind; directions are unit.
fn lit(kind: LightKind, direction: Vec3, position: Vec3) -> Lighting {
    let light = Light {
        name: String::new(),
        kind,
        intensity: Vec3::new(3.0, 2.0, 1.0),
        position,
        direction,
        range: Some(9.0),
    };
    let scene = Scene { lights: vec![light], ..Scene::default() };
    Lighting::new(&scene, &Choices::default()).expect("no sky")
}

fn random_point(rng: &mut Rng) -> Inputs {
    let normal = uniform_sphere(rng.square());
    let view = uniform_sphere(rng.square());
    let view = if view.dot(normal) < 0.0 { -view } else { view };
    let mut point = Inputs::new(Vec3A::ZERO, view, normal);
    point.frame = Frame::from_normal_tangent(normal, uniform_sphere(rng.square()));
    let mut colour = || Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform());
    point.surface = GltfParams { base_color: colour(), specular_color: colour(), ..GltfParams::default() };
    point.surface.metallic = rng.uniform();
    point.surface.roughness = 0.05 + 0.95 * rng.uniform();
    point.surface.ior = 1.0 + rng.uniform();
    point.surface.specular = rng.uniform();
    point
}

#[test]
fn a_directional_light_is_the_closure_times_cosine() {
    let mut rng = Rng::new(5);
    let mut compared = 0;
    for i in 0..3000 {
        let mut point = random_point(&mut rng);
        let (realtime, reference) = [
            (Compensation::None, multiscatter::Compensation::None),
            (Compensation::KullaConty, multiscatter::Compensation::KullaConty),
            (Compensation::Turquin, multiscatter::Compensation::Turquin),
        ][i % 3];
        let choices = Choices { compensation: realtime, ..Choices::default() };
        point.surface.compensation = reference;
        let to = uniform_sphere(rng.square());
        let lighting = lit(LightKind::Directional, (-to).into(), Vec3::ZERO);
        let f = &point.frame;
        let (wo, wi) = (f.to_local(point.view), f.to_local(to));
        if wo.z < 1e-3 {
            continue;
        }
        let want = MetalRough::new(&point.surface.metal_rough()).eval_pdf(wo, wi);
        let got = shade(&point, &lighting, &choices, &()).terms;
        let light = Spectrum::rgb(3.0, 2.0, 1.0) * wi.z.max(0.0);
        for (got, want) in
            [(got.direct_diffuse, want.diffuse * light), (got.direct_specular, want.specular * light)]
        {
            for lane in 0..3 {
                let tolerance = 2e-4 * want[lane] + 1e-6;
                assert!((got[lane] - want[lane]).abs() < tolerance, "{got:?} {want:?} at {wo} {wi}");
                compared += usize::from(want[lane] > 0.0);
            }
        }
    }
    assert!(compared > 6000, "{compared}");
}

/// Point and spot lights as the extension's formulas have them.
#[test]
fn lights_that_stand_somewhere() {
    let mut point = Inputs::new(Vec3A::ZERO, Vec3A::Y, Vec3A::Y);
    point.surface.specular = 0.0;
    let choices = Choices { coupling: Coupling::Whole, ..Choices::default() };
    let red =
        |lighting: &Lighting| shade(&point, lighting, &choices, &()).terms.sum()[0] * std::f32::consts::PI;
    // At distance 2 above: 3 / 4, windowed at range 9 by 1 − (2/9)⁴.
    let at = Vec3::new(0.0, 2.0, 0.0);
    let window = 1.0 - (2.0f32 / 9.0).powi(4);
    let e = red(&lit(LightKind::Point, Vec3::X, at));
    assert!((e - 0.75 * window).abs() < 1e-5, "{e}");
    // A cone whose axis leans by half of what lies between the cones.
    let spot = LightKind::Spot { inner: 0.2, outer: 0.6 };
    let lean = |a: f32| Vec3::new(a.sin(), -a.cos(), 0.0);
    assert!((red(&lit(spot, lean(0.1), at)) - 0.75 * window).abs() < 1e-5);
    let t = ((0.4f32).cos() - (0.6f32).cos()) / ((0.2f32).cos() - (0.6f32).cos());
    let e = red(&lit(spot, lean(0.4), at));
    assert!((e - 0.75 * window * t * t).abs() < 1e-5, "{e}");
    assert_eq!(red(&lit(spot, lean(0.7), at)), 0.0);
    // A lamp that was measured: 8 cd downwards, 4 cd at a right angle, as many times as its intensity says.
    let angles = vec![0.0, 90.0];
    let profile = LightProfile::new(Web::C, angles, vec![0.0], vec![8.0, 4.0]).expect("a profile");
    let measured = |direction| {
        let kind = LightKind::Profile { profile: 0, side: Vec3::Z };
        let light = Light {
            name: String::new(),
            kind,
            intensity: Vec3::new(3.0, 2.0, 1.0),
            position: at,
            direction,
            range: None,
        };
        let profiles = vec![std::sync::Arc::new(profile.clone())];
        let scene = Scene { lights: vec![light], profiles, ..Scene::default() };
        red(&Lighting::new(&scene, &Choices::default()).expect("no sky"))
    };
    for (direction, candela) in [(Vec3::NEG_Y, 8.0), (Vec3::X, 4.0), (Vec3::Y, 0.0)] {
        let e = measured(direction);
        assert!((e - 0.75 * candela).abs() < 1e-3, "{direction}: {e}");
    }
    // Beyond the range there is nothing.
    assert_eq!(red(&lit(LightKind::Point, Vec3::X, Vec3::new(0.0, 9.5, 0.0))), 0.0);
}
