//! Rectangles, disks and spheres against the sum over their points.

use etendue_bxdf::laws::Rng;
use etendue_bxdf::sampling::uniform_sphere;
use etendue_bxdf::{Bsdf, GltfParams, MetalRough};
use etendue_color::Spectrum;
use etendue_realtime::choices::Area;
use etendue_realtime::{AreaLight, AreaShape, Choices, Inputs, Lighting, shade};
use glam::{Vec3, Vec3A};

/// Diffuse and specular light from points all over the light.
fn sum(light: &AreaLight, point: &Inputs) -> [Spectrum; 2] {
    let closure = MetalRough::new(&point.surface.metal_rough());
    let wo = point.frame.to_local(point.view);
    let n = 1 << 14;
    let (mut diffuse, mut specular) = (Spectrum::ZERO, Spectrum::ZERO);
    for i in 0..n {
        let u = (f64::from(i) * 0.754_877_666_246_693).fract() as f32;
        let v = (f64::from(i) * 0.569_840_290_998_053).fract() as f32;
        let (at, normal, area) = match light.shape {
            AreaShape::Rectangle { x, y } => {
                let at = x * (2.0 * u - 1.0) + y * (2.0 * v - 1.0);
                (at, x.cross(y).normalize(), 4.0 * x.length() * y.length())
            }
            AreaShape::Disk { x, y } => {
                let (r, phi) = (u.sqrt(), std::f32::consts::TAU * v);
                let area = std::f32::consts::PI * x.length() * y.length();
                (x * (r * phi.cos()) + y * (r * phi.sin()), x.cross(y).normalize(), area)
            }
            AreaShape::Sphere { radius } => {
                let d = Vec3::from(uniform_sphere([u, v]));
                (d * radius, d, 4.0 * std::f32::consts::PI * radius * radius)
            }
        };
        let to = Vec3A::from(light.center + at) - point.position;
        let d2 = to.length_squared();
        let wi = to / d2.sqrt();
        let cos = -wi.dot(normal.into());
        if cos <= 0.0 {
            continue;
        }
        let local = point.frame.to_local(wi);
        let e = closure.eval_pdf(wo, local);
        let weight = local.z.max(0.0) * cos * area / d2;
        diffuse += e.diffuse * weight;
        specular += e.specular * weight;
    }
    [diffuse * light.radiance / n as f32, specular * light.radiance / n as f32]
}

#[test]
fn ltc_meets_the_sum() {
    let mut rng = Rng::new(8);
    let radiance = Spectrum::rgb(2.0, 1.0, 0.5);
    for name in ["rectangle", "disk", "sphere"] {
        // Sums of |difference| and of light, by [LTC, representative point].
        let (mut off, mut all, mut count) = ([[0.0f64; 2]; 2], [0.0f64; 2], 0);
        while count < 60 {
            let normal = Vec3A::Y;
            let view = uniform_sphere(rng.square());
            if view.y < 0.1 {
                continue;
            }
            let center =
                Vec3::new(4.0 * rng.uniform() - 2.0, 0.6 + 2.0 * rng.uniform(), 4.0 * rng.uniform() - 2.0);
            // Faces the point, leaning somewhat.
            let lean = Vec3::from(uniform_sphere(rng.square())) * 0.5;
            let n = (lean - center.normalize()).normalize();
            let (x, y) = n.any_orthonormal_pair();
            let (x, y) = (x * (0.2 + rng.uniform()), y * (0.2 + rng.uniform()));
            let shape = match name {
                "rectangle" => AreaShape::Rectangle { x, y },
                "disk" => AreaShape::Disk { x, y },
                _ => AreaShape::Sphere { radius: 0.1 + 0.4 * rng.uniform() },
            };
            let light = AreaLight { shape, center, radiance, two_sided: false };
            let mut point = Inputs::new(Vec3A::ZERO, view, normal);
            point.surface = GltfParams {
                base_color: Spectrum::rgb(0.8, 0.6, 0.4),
                metallic: 0.5,
                roughness: 0.2 + 0.8 * rng.uniform(),
                ..GltfParams::default()
            };
            let want = sum(&light, &point);
            for (k, area) in [Area::Ltc, Area::Representative].into_iter().enumerate() {
                let choices = Choices { area, ..Choices::default() };
                let lighting = Lighting { areas: vec![light], ..Lighting::default() };
                let got = shade(&point, &lighting, &choices, &()).terms;
                for (part, got) in [got.direct_diffuse, got.direct_specular].into_iter().enumerate() {
                    off[k][part] += f64::from((got[0] - want[part][0]).abs());
                }
            }
            all[0] += f64::from(want[0][0]);
            all[1] += f64::from(want[1][0]);
            count += 1;
        }
        let part = |k: usize, p: usize| off[k][p] / all[p];
        println!(
            "{name}: mean |difference| over mean light: diffuse {:.4}, specular by LTC {:.4}, by a point {:.4}",
            part(0, 0),
            part(0, 1),
            part(1, 1)
        );
        assert!(part(0, 0) < 0.015 && part(0, 1) < 0.12, "{name}");
        assert!(part(0, 1) < part(1, 1), "{name}");
    }
}

/// A light that shines away, or that surrounds the point, gives nothing; a two-sided one the same from both sides.
#[test]
fn sides() {
    let mut point = Inputs::new(Vec3A::ZERO, Vec3A::new(0.3, 0.9, 0.1).normalize(), Vec3A::Y);
    point.surface.roughness = 0.4;
    let light = |x: Vec3, y: Vec3, two_sided: bool| AreaLight {
        shape: AreaShape::Rectangle { x, y },
        center: Vec3::new(0.2, 1.5, -0.3),
        radiance: Spectrum::rgb(1.0, 1.0, 1.0),
        two_sided,
    };
    let seen = |l: AreaLight| {
        let lighting = Lighting { areas: vec![l], ..Lighting::default() };
        shade(&point, &lighting, &Choices::default(), &()).terms.sum()[0]
    };
    // X × Z points down, to the point.
    let towards = seen(light(Vec3::X, Vec3::Z, false));
    assert!(towards > 0.01, "{towards}");
    assert_eq!(seen(light(Vec3::Z, Vec3::X, false)), 0.0);
    let both = [seen(light(Vec3::Z, Vec3::X, true)), seen(light(Vec3::X, Vec3::Z, true))];
    assert!((both[0] - towards).abs() < 1e-5 && (both[1] - towards).abs() < 1e-5, "{both:?} {towards}");
    let around = AreaLight { shape: AreaShape::Sphere { radius: 9.0 }, ..light(Vec3::X, Vec3::Z, false) };
    assert_eq!(seen(around), 0.0);
}
