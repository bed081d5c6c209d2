//! Every closure of the grid before every law.
//!
//! By default a part of the grid with 2·10⁵ samples per cell; with `ETENDUE_FULL=1` the whole grid with 10⁶.

// `!(p >= level)` also catches NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use core::f32::consts::LN_2;
use etendue_bxdf::{
    Bsdf, GgxReflection, LobeKind, MetalRough, MetalRoughParams, Schlick,
    ggx::ALPHA_DELTA,
    laws::{
        Rng, chi2, furnace,
        grid::{self, ANGLES, Subject, wo_at},
        reciprocity, sampling, sidak,
    },
    multiscatter::Compensation,
    quadrature::{average_albedo, directional_albedo},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

fn samples() -> usize {
    if full() { 1_000_000 } else { 200_000 }
}

fn angles() -> &'static [f32] {
    if full() { &ANGLES } else { &[0.0, 60.0, 89.0] }
}

/// All closures whose diffuse and specular parts together keep energy, or the telling ones.
fn conserving() -> Vec<Subject> {
    let all = grid::lobes().into_iter().chain(grid::metal_rough());
    let telling = |s: &Subject| ["lambert", "F=1", "white", "red"].iter().any(|n| s.name.contains(n));
    all.filter(|s| full() || telling(s)).collect()
}

fn everything() -> Vec<Subject> {
    conserving().into_iter().chain(grid::metal_rough_half_vector()).collect()
}

/// Each closure at each angle, with a number of its own for a seed.
fn each_cell(subjects: &[Subject], mut f: impl FnMut(&Subject, f32, u64)) -> usize {
    let mut cell = 0;
    for s in subjects {
        for &angle in angles() {
            cell += 1;
            f(s, angle, cell as u64);
        }
    }
    cell
}

#[test]
fn samples_follow_their_density() {
    let subjects = everything();
    let cells = subjects.len() * angles().len();
    let level = sidak(0.01, cells);
    let mut failures = Vec::new();
    each_cell(&subjects, |s, angle, seed| {
        let found = chi2::chi2(&*s.bsdf, wo_at(angle), samples(), 0x1000 + seed);
        if !(found.p >= level) {
            failures.push(format!("{} {angle}°: {found:?}", s.name));
        }
    });
    println!("χ²: {cells} cells of {} samples, each at level {level:.1e}", samples());
    assert!(failures.is_empty(), "{} of {cells} cells fail:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn weights_and_densities_agree_with_eval() {
    let subjects = everything();
    let n = samples() / 10;
    let cells = subjects.len() * angles().len();
    each_cell(&subjects, |s, angle, seed| {
        let m = sampling::samples(&*s.bsdf, wo_at(angle), n, 0x2000 + seed);
        let at = format!("{} {angle}°: {m:?}", s.name);
        assert!(!m.broken, "{at}");
        assert!(m.weight_error < 2e-6 && m.pdf_error < 2e-6 && m.split_error < 1e-6, "{at}");
        assert!(m.length_error < 2e-6, "{at}");
        assert!(m.pdf_integral <= 1.0 + 2e-5, "{at}");
        // 1 % over the cells, generously.
        assert!(m.p > 7e-6, "{at}");
        // Bounded by one over the smaller lobe's share; a loss of digits would show as a far larger one.
        assert!(m.largest_weight < 20.0, "{at}");
    });
    println!("{cells} cells of {n} samples");
}

#[test]
fn nothing_makes_light() {
    let subjects = conserving();
    let mut brightest = (0.0, String::new());
    let cells = each_cell(&subjects, |s, angle, seed| {
        let f = furnace::furnace(&*s.bsdf, wo_at(angle), samples() / 4, 0x3000 + seed);
        let at = format!("{} {angle}°: {f:?}", s.name);
        assert!(f.albedo.max_element() <= 1.0 + 1e-3, "{at}");
        // Sampling and quadrature agree: 4.5 σ is 7e-6 per lane and cell.
        assert!(f.z < 4.5, "{at}");
        if f.albedo.max_element() > brightest.0 {
            brightest = (f.albedo.max_element(), s.name.clone());
        }
    });
    println!("{cells} cells, brightest {brightest:?}");
}

#[test]
fn light_may_turn_round() {
    for s in everything() {
        let r = reciprocity::reciprocity(&*s.bsdf, samples() / 10, 0x4000);
        assert!(r.error <= 1e-4, "{}: {r:?}", s.name);
    }
}

/// F = 1 GGX loses what would bounce between microfacets; the amounts are known.
#[test]
fn single_scattering_loses_what_is_known() {
    // Roughness; albedo at normal incidence, at cos θ = 0.5, and on average.
    let known = [(0.5, 0.916, 0.857, 0.882), (0.75, 0.627, 0.663, 0.656), (1.0, 1.0 - LN_2, 0.451, 0.409)];
    for (roughness, normal, half, average) in known {
        let alpha = roughness * roughness;
        let lobe = GgxReflection::new(alpha, alpha, Schlick::ONE);
        let got = directional_albedo(&lobe, Vec3A::Z)[0];
        assert!((got - normal).abs() < 1e-3, "roughness {roughness}: {got}, {normal}");
        let got = directional_albedo(&lobe, vec3a(0.75f32.sqrt(), 0.0, 0.5))[0];
        assert!((got - half).abs() < 1e-3, "roughness {roughness}: {got}, {half}");
        let got = average_albedo(&lobe)[0];
        assert!((got - average).abs() < 1e-3, "roughness {roughness}: {got}, {average}");
    }
    // Exactly 1 − ln 2 at roughness 1.
    let lobe = GgxReflection::new(1.0, 1.0, Schlick::ONE);
    assert!((directional_albedo(&lobe, Vec3A::Z)[0] - (1.0 - LN_2)).abs() < 1e-5);
}

/// A white dielectric reflects what it does not let in, and gives back all that it lets in: only the light that
/// single scattering loses between microfacets is missing.
#[test]
fn a_white_dielectric_returns_the_sky() {
    for roughness in [0.0, 0.05, 0.2, 0.5, 1.0] {
        for ior in [1.0, 1.33, 1.5, 2.42] {
            let compensation = Compensation::None;
            let p = MetalRoughParams { roughness, ior, compensation, ..Default::default() };
            let f0 = etendue_bxdf::fresnel::f0_from_ior(ior);
            for angle in [0.0, 45.0, 75.0, 85.0] {
                let wo = wo_at(angle);
                let lobe = |fresnel| {
                    let alpha = roughness * roughness;
                    directional_albedo(&GgxReflection::new(alpha, alpha, fresnel), wo)[0]
                };
                let e = lobe(Schlick::ONE);
                let reflected = lobe(Schlick { f0: Spectrum::splat(f0), f90: Spectrum::ONE });
                let lost = reflected / e - reflected;
                let a = directional_albedo(&MetalRough::new(&p), wo)[0];
                assert!(
                    (a + lost - 1.0).abs() < 1e-3,
                    "roughness {roughness} ior {ior} {angle}°: {a}, {lost}"
                );
            }
        }
    }
}

/// `albedo` is close to the integral where it claims to be.
#[test]
fn claimed_albedo_is_near_the_integral() {
    for s in grid::metal_rough() {
        for &angle in angles() {
            let (claimed, exact) = (s.bsdf.albedo(wo_at(angle)), directional_albedo(&*s.bsdf, wo_at(angle)));
            let error = (claimed - exact).map(f32::abs).to_rgb().into_iter().fold(0.0, f32::max);
            assert!(error < 4e-3, "{} {angle}°: {claimed:?}, {exact:?}", s.name);
        }
    }
}

/// The mirror takes over from the narrowest lobe without a step in energy, and does what a mirror does.
#[test]
fn roughness_goes_to_zero_smoothly() {
    for angle in [0.0, 30.0, 60.0, 80.0] {
        let wo = wo_at(angle);
        let at = |roughness: f32, metallic: f32| {
            let base_color = Spectrum::rgb(0.9, 0.5, 0.1);
            MetalRough::new(&MetalRoughParams { roughness, metallic, base_color, ..Default::default() })
        };
        let edge = ALPHA_DELTA.sqrt();
        for metallic in [0.0, 0.5, 1.0] {
            let mirror = at(0.999 * edge, metallic);
            let lobe = at(1.001 * edge, metallic);
            assert!(mirror.deltas(wo)[0].is_some() && lobe.deltas(wo)[0].is_none());
            let (a, b) = (directional_albedo(&mirror, wo), directional_albedo(&lobe, wo));
            assert!((a - b).map(f32::abs).max_element() < 1e-4, "{angle}°: {a:?} {b:?}");
        }
        let s = at(0.0, 1.0).sample(wo, 0.3, [0.2, 0.9]).expect("a mirror reflects");
        assert!(s.delta && s.lobe == LobeKind::Specular && s.pdf == 1.0);
        assert_eq!(s.wi, vec3a(-wo.x, -wo.y, wo.z));
        assert_eq!(at(0.0, 1.0).eval(wo, s.wi), Spectrum::ZERO);
    }
}

/// glTF's numbers, straight from the formulas of Appendix B and the two extensions.
#[test]
fn parameters_mean_what_gltf_says() {
    let (wo, wi) = (wo_at(40.0), wo_at(25.0));
    let rough = |p: MetalRoughParams| MetalRough::new(&p).with_coupling(etendue_bxdf::Coupling::HalfVector);
    let h = (wo + wi).normalize();
    let w = (1.0 - wo.dot(h)).powi(5);
    let alpha = 0.25f32;
    let lobe = GgxReflection::new(alpha, alpha, Schlick::ONE).eval(wo, wi)[0];
    // The lobe itself, from the specification's D and V.
    let (a2, nh) = (alpha * alpha, h.z);
    let d = a2 / (core::f32::consts::PI * (nh * nh * (a2 - 1.0) + 1.0).powi(2));
    let smith = |a: Vec3A, b: Vec3A| a.z * (a2 + (1.0 - a2) * b.z * b.z).sqrt();
    let v = 0.5 / (smith(wo, wi) + smith(wi, wo));
    assert!((lobe - d * v).abs() < 1e-5 * lobe);

    let base_color = Spectrum::rgb(0.8, 0.4, 0.2);
    let specular_color = Spectrum::rgb(30.0, 1.0, 0.0);
    let p = MetalRoughParams {
        base_color,
        metallic: 0.25,
        roughness: 0.5,
        ior: 2.0,
        specular: 0.6,
        specular_color,
        compensation: Compensation::None,
    };
    let e = rough(p).eval_pdf(wo, wi);
    let f0_ior = (1.0f32 / 3.0).powi(2);
    let fresnel: [f32; 3] = core::array::from_fn(|i| {
        let f0 = (f0_ior * specular_color[i]).min(1.0);
        0.6 * (f0 + (1.0 - f0) * w)
    });
    let max = fresnel.into_iter().fold(0.0, f32::max);
    for i in 0..3 {
        let metal = base_color[i] + (1.0 - base_color[i]) * w;
        let specular = (0.75 * fresnel[i] + 0.25 * metal) * d * v;
        let diffuse = 0.75 * (1.0 - max) * base_color[i] / core::f32::consts::PI;
        assert!((e.specular[i] - specular).abs() < 2e-5 * specular, "{i}: {e:?} {specular}");
        assert!((e.diffuse[i] - diffuse).abs() < 2e-5 * diffuse + 1e-7, "{i}: {e:?} {diffuse}");
    }
    // ior 0: all is reflected, nothing reaches the base.
    let e = MetalRough::new(&MetalRoughParams { ior: 0.0, ..MetalRoughParams::default() }).eval_pdf(wo, wi);
    assert!(e.diffuse.is_black() && e.specular.max_element() > 0.0);
    // specular 0: Lambert.
    let e = MetalRough::new(&MetalRoughParams { specular: 0.0, ..MetalRoughParams::default() });
    assert!((e.eval(wo, wi)[0] - core::f32::consts::FRAC_1_PI).abs() < 1e-6);
}

/// Any parameters and directions, NaN and infinity among them, give finite values that are not negative.
#[test]
fn no_input_breaks_anything() {
    const ODD: [f32; 12] = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        0.0,
        -0.0,
        1.0,
        -1.0,
        1e-30,
        1e30,
        0.01,
        0.5,
        f32::MIN_POSITIVE,
    ];
    let mut rng = Rng::new(99);
    let ok = |s: Spectrum| s.is_finite() && s.0.iter().all(|&v| v >= 0.0);
    for i in 0..200_000u32 {
        let number = |rng: &mut Rng| {
            if rng.uniform() < 0.3 { ODD[(rng.bits() % 12) as usize] } else { rng.uniform() }
        };
        let four = |rng: &mut Rng| Spectrum(core::array::from_fn(|_| number(rng)));
        let (base_color, specular_color) = (four(&mut rng), four(&mut rng));
        let [metallic, roughness, ior, specular] = four(&mut rng).0;
        let p = MetalRoughParams {
            base_color,
            metallic,
            roughness,
            ior,
            specular,
            specular_color,
            ..Default::default()
        };
        let [ax, ay, _, _] = four(&mut rng).0;
        let direction = |rng: &mut Rng| {
            let v = four(rng);
            // Every other time a unit vector, as the contract asks; otherwise anything.
            let v = vec3a(v[0], v[1], v[2]);
            if i % 2 == 0 { v.normalize_or(wo_at(89.9999)) } else { v }
        };
        let (wo, wi) = (direction(&mut rng), direction(&mut rng));
        let u = four(&mut rng).0;
        let lobe = GgxReflection::new(ax, ay, Schlick::ONE);
        let closures: [&dyn Bsdf; 3] = [
            &MetalRough::new(&p),
            &MetalRough::new(&p).with_coupling(etendue_bxdf::Coupling::HalfVector),
            &lobe,
        ];
        for bsdf in closures {
            let e = bsdf.eval_pdf(wo, wi);
            let at = format!("{p:?} α {ax} {ay} {wo} {wi} {u:?}: {e:?}");
            assert!(ok(e.diffuse) && ok(e.specular) && e.pdf.is_finite() && e.pdf >= 0.0, "{at}");
            assert!(ok(bsdf.albedo(wo)), "{at}");
            if let Some(s) = bsdf.sample(wo, u[0], [u[1], u[2]]) {
                assert!(ok(s.weight) && s.pdf > 0.0 && s.pdf.is_finite() && s.wi.is_finite(), "{at} {s:?}");
            }
        }
    }
}
