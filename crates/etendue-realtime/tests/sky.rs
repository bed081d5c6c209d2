//! The sky's light against integrals of the reference's closure.

use etendue_bxdf::laws::Rng;
use etendue_bxdf::sampling::uniform_sphere;
use etendue_bxdf::{Bsdf, GltfParams, MetalRough, multiscatter};
use etendue_color::Spectrum;
use etendue_image::{Image, Pixels};
use etendue_realtime::choices::{Compensation, Occlusion, Specular};
use etendue_realtime::{Choices, Inputs, Lighting, Terms, shade};
use etendue_scene::{Environment, Scene};
use glam::{Vec3, Vec3A};
use std::sync::Arc;

fn lighting(environment: Environment, choices: &Choices) -> Lighting {
    Lighting::new(&Scene { environment, ..Scene::default() }, choices).expect("a sky")
}

fn shade_at(lighting: &Lighting, choices: &Choices, surface: GltfParams, cos: f32) -> Terms {
    let view = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut point = Inputs::new(Vec3A::ZERO, view, Vec3A::Z);
    point.surface = surface;
    shade(&point, lighting, choices, &()).terms
}

fn surfaces() -> Vec<GltfParams> {
    let mut out = Vec::new();
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        for metallic in [0.0, 0.5, 1.0] {
            let base_color = Spectrum::rgb(0.9, 0.5, 0.2);
            out.push(GltfParams { base_color, metallic, roughness, ..GltfParams::default() });
        }
    }
    out
}

/// Under a white sky each surface returns its albedo.
#[test]
fn white_furnace() {
    for (compensation, reference) in [
        (Compensation::None, multiscatter::Compensation::None),
        (Compensation::KullaConty, multiscatter::Compensation::KullaConty),
        (Compensation::Turquin, multiscatter::Compensation::Turquin),
    ] {
        let choices = Choices { compensation, ..Choices::default() };
        let white = lighting(Environment::Constant(Vec3::ONE), &choices);
        let mut worst = 0.0f32;
        for mut surface in surfaces() {
            surface.compensation = reference;
            for cos in [1.0, 0.7, 0.3, 0.1] {
                let got = shade_at(&white, &choices, surface, cos).sum();
                let wo = Vec3A::new((1.0f32 - cos * cos).sqrt(), 0.0, cos);
                let want = MetalRough::new(&surface.metal_rough()).albedo(wo);
                for c in 0..3 {
                    let error = (got[c] - want[c]).abs();
                    assert!(error < 0.005, "{surface:?} at {cos}: {got:?} {want:?}");
                    worst = worst.max(error);
                }
            }
        }
        println!("{compensation}: worst error of the albedo {worst:.4}");
    }
}

/// A smooth sky: a gradient with a bright, wide spot.
fn smooth(d: Vec3A) -> [f32; 3] {
    let spot = (8.0 * (d.dot(Vec3A::new(0.6, 0.64, 0.48)) - 1.0)).exp();
    [1.0 + 0.5 * d.y + 3.0 * spot, 1.0 + 0.3 * d.x + 2.0 * spot, 0.8 - 0.4 * d.z + spot]
}

fn picture(f: impl Fn(Vec3A) -> [f32; 3]) -> Environment {
    let (w, h) = (256u32, 128u32);
    let pixels = (0..w * h).flat_map(|i| {
        let phi = std::f32::consts::TAU * (((i % w) as f32 + 0.5) / w as f32 - 0.5);
        let theta = std::f32::consts::PI * ((i / w) as f32 + 0.5) / h as f32;
        f(Vec3A::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()))
    });
    let image = Arc::new(Image { width: w, height: h, channels: 3, pixels: Pixels::F32(pixels.collect()) });
    Environment::LatLong { image, rotation: 0.0, intensity: 1.0 }
}

/// Diffuse and specular light of the sky `l` by sampling the closure itself, seen from `view` about `normal`.
fn integral(point: &Inputs, l: impl Fn(Vec3A) -> [f32; 3]) -> [Spectrum; 2] {
    let closure = MetalRough::new(&point.surface.metal_rough());
    let (f, n) = (&point.frame, 1 << 14_i32);
    let wo = f.to_local(point.view);
    let (mut diffuse, mut specular) = (Spectrum::ZERO, Spectrum::ZERO);
    for i in 0..n {
        // Powers of one over the root of x⁴ = x + 1: a lattice that is even in three dimensions.
        let part = |k: f64| (f64::from(i) * k).fract() as f32;
        let (u, uc) =
            ([part(0.819_172_513_396_164_4), part(0.671_043_606_703_789_2)], part(0.549_700_477_901_970_3));
        if let Some(s) = closure.sample(wo, uc, u) {
            let light = Spectrum::from_rgb(l(f.to_world(s.wi)));
            diffuse += s.weight_diffuse * light;
            specular += s.weight_specular * light;
        }
    }
    [diffuse / n as f32, specular / n as f32]
}

#[test]
fn a_smooth_sky_meets_the_integral() {
    for (specular, bound) in [(Specular::Sampled, 0.05), (Specular::Exact, 0.015)] {
        let choices = Choices { specular, occlusion: Occlusion::None, ..Choices::default() };
        let sky = lighting(picture(smooth), &choices);
        let mut rng = Rng::new(3);
        let (mut worst, mut count) = ([0.0f32; 2], 0);
        for surface in surfaces() {
            for _ in 0..6 {
                let normal = uniform_sphere(rng.square());
                let view = uniform_sphere(rng.square());
                let view = if view.dot(normal) < 0.0 { -view } else { view };
                if view.dot(normal) < 0.05 {
                    continue;
                }
                let mut point = Inputs::new(Vec3A::ZERO, view, normal);
                point.surface = surface;
                let want = integral(&point, smooth);
                let got = shade(&point, &sky, &choices, &()).terms;
                for (k, got) in [got.indirect_diffuse, got.indirect_specular].into_iter().enumerate() {
                    for c in 0..3 {
                        let error = (got[c] - want[k][c]).abs() / (want[k][c] + 0.05);
                        worst[k] = worst[k].max(error);
                        count += 1;
                    }
                }
            }
        }
        println!(
            "{specular}: worst relative error, diffuse {:.4}, specular {:.4} of {count}",
            worst[0], worst[1]
        );
        assert!(worst[0] < 0.02 && worst[1] < bound, "{specular}: {worst:?}");
    }
}
