//! Adaptive quadrature against plain sums over even grids of the sphere, bin by bin, where steps, kinks and lobes beside the
//! map's centre are.

use core::f64::consts::PI;
use etendue_bxdf::{
    Bsdf,
    laws::{Rng, expected::Expected, grid::wo_at},
    model::{Closure, Incidence, Model, Transport},
    quadrature::{HemisphereMap, directional_albedo, pdf_integral},
};
use glam::{DVec3, dvec3};

fn closure(model: &str, parameters: &[(&str, &str)], front: bool) -> Closure {
    let mut m = Model::by_name(model).expect("listed");
    for (name, value) in parameters {
        m.set_text(name, value).expect("a parameter of it");
    }
    m.closure(&Incidence { front, transport: Transport::Importance, ..Default::default() })
}

/// Σ over 2n turns about x × n steps of x, which have equal solid angles, a point at random in each:
/// `f(direction, solid angle)`. No lobe lies at the poles, where steps of x are wide angles.
fn over_the_sphere(n: usize, mut f: impl FnMut(DVec3, f64)) {
    let mut rng = Rng::new(n as u64);
    let area = 2.0 * PI / (n * n) as f64;
    for i in 0..n {
        for j in 0..2 * n {
            let [u, v] = rng.square().map(|u| u as f64);
            let z = (i as f64 + u) / n as f64 * 2.0 - 1.0;
            let sin = (1.0 - z * z).sqrt();
            let (y, x) = ((j as f64 + v) / n as f64 * PI).sin_cos();
            f(dvec3(z, sin * x, sin * y), area);
        }
    }
}

type Subject = (&'static str, &'static [(&'static str, &'static str)], bool, f32);

/// Closures whose densities have a step at the end of refraction, roots at total reflection, ridges, or lobes with a
/// frame of their own; all wide enough for an even grid.
const SUBJECTS: [Subject; 8] = [
    ("dielectric", &[("roughness", "0.3"), ("anisotropy", "0.5"), ("ior", "4")], false, 0.0),
    ("dielectric", &[("roughness", "1"), ("anisotropy", "0.5")], false, 89.0),
    ("dielectric", &[("roughness", "1"), ("anisotropy", "0.5")], false, 0.0),
    ("dielectric", &[("roughness", "1")], true, 89.0),
    ("gltf", &[("transmission", "1"), ("thickness", "1"), ("roughness", "1")], false, 60.0),
    ("hair", &[("beta_m", "0.6")], true, 89.0),
    ("hair", &[("beta_m", "1"), ("h", "-1")], true, 80.0),
    (
        "openpbr",
        &[
            ("specular_roughness", "0.9"),
            ("coat_weight", "1"),
            ("coat_roughness", "0.5"),
            ("coat_roughness_anisotropy", "0.5"),
            ("geometry_coat_normal", "0.4,0.2,1"),
            ("geometry_coat_tangent", "1,1,0"),
        ],
        true,
        60.0,
    ),
];

#[test]
fn every_bin_is_the_sum_over_an_even_grid() {
    const N: usize = 1024;
    for (model, parameters, front, angle) in SUBJECTS {
        let (c, wo) = (closure(model, parameters, front), wo_at(angle));
        let mut worst = 0.0f64;
        let expected = Expected::new(&c, wo, 1_000_000);
        let mut bins = vec![0.0; expected.bins.len()];
        let (mut points, mut whole, mut albedo) = (vec![0u32; bins.len()], 0.0, 0.0);
        over_the_sphere(N, |wi, area| {
            let e = c.eval_pdf(wo, wi.as_vec3a());
            if let Some(bin) = expected.bin(wi) {
                bins[bin] += e.pdf as f64 * area;
                points[bin] += 1;
            }
            whole += e.pdf as f64 * area;
            albedo += (e.value()[0] as f64) * wi.z.abs() * area;
        });
        let at = format!("{model} {parameters:?} {angle}°");
        println!(
            "{at}: {:.6} for {whole:.6}, {:.6} for {albedo:.6}",
            expected.pdf_integral, expected.albedo[0]
        );
        assert!((expected.pdf_integral - whole).abs() < 1e-4, "{at}: {} for {whole}", expected.pdf_integral);
        assert!(
            (expected.albedo[0] as f64 - albedo).abs() < 1e-4,
            "{at}: {} for {albedo}",
            expected.albedo[0]
        );
        assert!((expected.albedo - directional_albedo(&c, wo)).map(f32::abs).max_element() < 2e-5, "{at}");
        for (i, ((&got, want), points)) in expected.bins.iter().zip(bins).zip(points).enumerate() {
            // Cells of the grid that a border crosses, some root of those inside, are counted on either side of it by chance.
            let border = want * (points.max(1) as f64).powf(-0.6);
            worst = worst.max((got - want).abs() / (2e-5 + border));
            assert!(
                (got - want).abs() < 2.0 * (2e-5 + border),
                "{at}, bin {i}: {got} for {want}, {points} points"
            );
        }
        assert!((expected.pdf_integral - pdf_integral(&c, wo)).abs() < 2e-5, "{at}");
        println!("  the worst bin is off by {worst:.2} of what the grid may be");
    }
}

/// A narrow lobe away from the map's centre, against a sum in polar coordinates about it, whose steps grow with the angle.
#[test]
fn a_tilted_narrow_lobe_is_found() {
    const N: usize = 512;
    const GROWTH: f64 = 14.0;
    let wo = wo_at(30.0);
    for tilt in ["0.1,0,1", "0.4,0.2,1", "-0.3,0.5,1"] {
        let axis: Vec<f64> = tilt.split(',').map(|v| v.parse().expect("a number")).collect();
        let axis = dvec3(axis[0], axis[1], axis[2]).normalize();
        let peak = axis * (2.0 * axis.dot(wo.as_dvec3())) - wo.as_dvec3();
        let (t, b) = peak.any_orthonormal_pair();
        for roughness in ["0.03", "0.1", "0.2"] {
            let parameters = [
                ("specular_roughness", "0.9"),
                ("coat_weight", "1"),
                ("coat_roughness", roughness),
                ("geometry_coat_normal", tilt),
            ];
            let c = closure("openpbr", &parameters, true);
            let mut want = 0.0;
            for i in 0..N {
                let grown = GROWTH.exp() - 1.0;
                let at = |i: f64| PI * ((GROWTH * i / N as f64).exp() - 1.0) / grown;
                let theta = at(i as f64 + 0.5);
                let ring = (at(i as f64).cos() - at(i as f64 + 1.0).cos()) * 2.0 * PI / N as f64;
                for j in 0..N {
                    let (y, x) = ((j as f64 + 0.5) / N as f64 * 2.0 * PI).sin_cos();
                    let wi = peak * theta.cos() + (t * x + b * y) * theta.sin();
                    want += ring * c.pdf(wo, wi.as_vec3a()) as f64;
                }
            }
            let got = pdf_integral(&c, wo);
            println!("tilt {tilt}, roughness {roughness}: {got:.6} for {want:.6}");
            assert!((got - want).abs() < 3e-4, "tilt {tilt}, roughness {roughness}: {got} for {want}");
        }
    }
}

/// A step across the bins, at a plane that no coordinate knows.
#[test]
fn a_step_anywhere_is_resolved() {
    let normal = dvec3(0.5, -0.3, 0.4).normalize();
    for alpha in [[1.0f32, 1.0], [0.3, 0.05]] {
        let map = HemisphereMap::Upper(etendue_bxdf::quadrature::HalfVectorMap::new(wo_at(70.0), alpha));
        let lit = |wi: glam::Vec3A| if wi.as_dvec3().dot(normal) > 0.0 { 1.0f32 } else { 0.0 };
        // A lune between two planes has twice their angle.
        let got = map.integrate_all(1e-6, |wi| [lit(wi)])[0];
        let want = 2.0 * (PI - normal.z.acos());
        assert!((got - want).abs() < 2e-4, "{got} for {want}");
    }
}
