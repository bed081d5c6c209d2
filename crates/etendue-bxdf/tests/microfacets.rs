//! Distributions of normals, masking terms, and the lobes and models made of them, before the laws.
//!
//! By default 5·10⁴ samples per cell of a part of the grid; with `ETENDUE_FULL=1` 10⁶ of the whole.

// `!(p >= level)` also catches NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use core::f64::consts::TAU;
use etendue_bxdf::{
    Bsdf, Conductor, F82Tint, Ggx, Schlick,
    laws::{
        Rng, chi2, furnace,
        gamma::chi2_p_value,
        grid::{ANGLES, Subject, wo_at},
        reciprocity, sampling, sidak,
    },
    microfacet::{
        AnyDistribution, AnyMasking, Beckmann, BlinnPhong, Distribution, Gtr, Masking, Microfacet,
        SchlickGgx, Smith, SmithSeparable, VCavity,
    },
    quadrature::gauss_legendre,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

fn samples() -> usize {
    if full() { 1_000_000 } else { 50_000 }
}

fn angles() -> &'static [f32] {
    if full() { &ANGLES } else { &[0.0, 60.0, 89.0] }
}

/// Distributions over their parameters.
fn distributions() -> Vec<(String, AnyDistribution)> {
    let mut out = Vec::new();
    let alphas: &[[f32; 2]] =
        &[[2e-4, 2e-4], [0.05, 0.4], [0.36, 0.36], [1.0, 1.0], [0.01, 0.01], [0.9, 0.2]];
    for &[x, y] in if full() { alphas } else { &alphas[..4] } {
        out.push((format!("ggx {x} {y}"), AnyDistribution::Ggx(Ggx::new(x, y))));
        out.push((format!("beckmann {x} {y}"), AnyDistribution::Beckmann(Beckmann::new(x, y))));
        if x == y {
            let few: &[f32] = &[0.5, 1.0, 1.5, 10.0];
            for &gamma in if full() { &[0.5, 1.0, 1.0001, 1.5, 2.0, 4.0, 10.0] } else { few } {
                out.push((format!("gtr {x} γ {gamma}"), AnyDistribution::Gtr(Gtr::new(x, gamma))));
            }
            out.push((format!("blinn-phong {x}"), AnyDistribution::BlinnPhong(BlinnPhong::new(x))));
        }
    }
    out
}

/// ∫ f(m) dm over the normals above the surface with stretched slopes `r` × `psi`: slopes αx r cos ψ, αy r sin ψ.
fn over_normals(alpha: [f32; 2], r: (f64, f64), psi: (f64, f64), f: impl Fn(Vec3A) -> f64) -> f64 {
    let nodes = gauss_legendre(6);
    let [ax, ay] = alpha.map(|a| a as f64);
    let mut breaks = vec![r.0];
    let mut b = 0.25;
    // Slopes beyond 10⁶ lie below the horizon's rounding.
    let end = r.1.min(1e6 / ax.min(ay));
    while b < end {
        if b > r.0 {
            breaks.push(b);
        }
        b *= 1.5;
    }
    breaks.push(end);
    let sectors = ((psi.1 - psi.0) / TAU * 40.0).ceil().max(2.0) as usize;
    let mut sum = 0.0;
    for s in 0..sectors {
        for &(x, w) in &nodes {
            let step = (psi.1 - psi.0) / sectors as f64;
            let angle = psi.0 + step * (s as f64 + x);
            for p in breaks.windows(2) {
                for &(y, v) in &nodes {
                    let r = p[0] + (p[1] - p[0]) * y;
                    let (sx, sy) = (ax * r * angle.cos(), ay * r * angle.sin());
                    let len = (1.0 + sx * sx + sy * sy).sqrt();
                    let m = vec3a((sx / len) as f32, (sy / len) as f32, (1.0 / len) as f32);
                    // dm = cos³ dx dy over slopes.
                    sum += f(m) * ax * ay * r / len.powi(3) * w * step * v * (p[1] - p[0]);
                }
            }
        }
    }
    sum
}

#[test]
fn facets_cover_the_surface() {
    for (name, d) in distributions() {
        let area = over_normals(d.alpha(), (0.0, f64::INFINITY), (0.0, TAU), |m| (d.d(m) * m.z) as f64);
        assert!((area - 1.0).abs() < 2e-4, "{name}: ∫ D cos = {area}");
        // The length of the half vector does not matter.
        let h = vec3a(0.3, -0.1, 0.9) * 0.01;
        assert!((d.d(h) - d.d(h.normalize())).abs() <= 1e-4 * d.d(h), "{name}");
    }
}

/// What a direction sees of the facets is its own cross-section, where Λ is exact, and for V-cavities always.
#[test]
fn masking_keeps_the_projected_area() {
    fn check<G: Masking>(name: &str, d: &AnyDistribution, g: G, wo: Vec3A) {
        let area = over_normals(d.alpha(), (0.0, f64::INFINITY), (0.0, TAU), |m| {
            (g.g1(d, wo, m) * d.d(m) * wo.dot(m).max(0.0)) as f64
        });
        let error = (area / wo.z as f64 - 1.0).abs();
        assert!(error < 4e-3, "{name} wo {wo}: {area}, {}", wo.z);
    }
    for (name, d) in distributions() {
        for angle in [0.0, 30.0, 60.0, 80.0, 87.0] {
            let wo = wo_at(angle);
            check(&format!("{name} v-cavity"), &d, VCavity, wo);
            let exact = match d {
                AnyDistribution::Gtr(g) => g.gamma() == 2.0,
                AnyDistribution::BlinnPhong(_) => false,
                _ => true,
            };
            if exact {
                check(&format!("{name} smith"), &d, Smith, wo);
            }
        }
    }
}

/// Drawn normals against their density, in rings of slopes and sectors.
fn normals_fit(
    alpha: [f32; 2],
    seed: u64,
    draw: impl Fn(&mut Rng) -> Vec3A,
    density: impl Fn(Vec3A) -> f64,
) -> f64 {
    const RINGS: usize = 10;
    const SECTORS: usize = 8;
    let n = samples();
    let edge = |i: usize| {
        let u = i as f64 / RINGS as f64;
        if i == RINGS { f64::INFINITY } else { (u / (1.0 - u)).sqrt() }
    };
    let mut observed = [0u64; RINGS * SECTORS];
    let mut rng = Rng::new(seed);
    for _ in 0..n {
        let m = draw(&mut rng).as_dvec3();
        let (x, y) = (m.x / (m.z * alpha[0] as f64), m.y / (m.z * alpha[1] as f64));
        let r2 = x * x + y * y;
        let ring = (r2 / (1.0 + r2) * RINGS as f64) as usize;
        let sector = (y.atan2(x).rem_euclid(TAU) / TAU * SECTORS as f64) as usize;
        observed[ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)] += 1;
    }
    let (mut statistic, mut pools) = (0.0, 0);
    let (mut few, mut few_expected) = (0.0, 0.0);
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let psi = |i: usize| i as f64 / SECTORS as f64 * TAU;
            let part =
                over_normals(alpha, (edge(ring), edge(ring + 1)), (psi(sector), psi(sector + 1)), &density);
            let (seen, expected) = (observed[ring * SECTORS + sector] as f64, part * n as f64);
            if expected >= 10.0 {
                statistic += (seen - expected).powi(2) / expected;
                pools += 1;
            } else {
                few += seen;
                few_expected += expected;
            }
        }
    }
    if few_expected >= 10.0 {
        statistic += (few - few_expected).powi(2) / few_expected;
        pools += 1;
    }
    chi2_p_value(statistic, pools - 1)
}

#[test]
fn normals_follow_their_density() {
    let all = distributions();
    let level = sidak(0.01, all.len() * 4);
    for (i, (name, d)) in all.iter().enumerate() {
        let seed = 0x700 + i as u64;
        let p = normals_fit(d.alpha(), seed, |rng| d.sample(rng.square()), |m| (d.d(m) * m.z) as f64);
        assert!(p >= level, "{name}: D-sampling, p = {p:e}");
        for &angle in if full() { &[0.0f32, 60.0, 87.0][..] } else { &[60.0, 87.0] } {
            let wo = wo_at(angle);
            let p = normals_fit(
                d.alpha(),
                seed ^ 0x5000,
                |rng| d.sample_visible(wo, rng.uniform(), rng.square()),
                |m| (d.visible_g1(wo, m) * d.d(m) * wo.dot(m).max(0.0) / wo.z) as f64,
            );
            assert!(p >= level, "{name} {angle}°: visible normals, p = {p:e}");
        }
    }
    println!("{} cells of {} normals", all.len() * 4, samples());
}

#[test]
fn special_cases_coincide() {
    let mut rng = Rng::new(5);
    for _ in 0..2000 {
        let (alpha, m) = (0.02 + 0.95 * rng.uniform(), wo_at(80.0 * rng.uniform()));
        let near = |a: f32, b: f32, what: &str| {
            assert!((a - b).abs() <= 3e-5 * a.abs().max(b.abs()), "{what} α {alpha} {m}: {a} {b}");
        };
        near(Gtr::new(alpha, 2.0).d(m), Ggx::new(alpha, alpha).d(m), "GTR2 is GGX");
        // Burley's formulas as written, in `f64`.
        let (a2, sin2) = ((alpha as f64).powi(2), (m.x as f64).powi(2) + (m.y as f64).powi(2));
        let t = 1.0 + (a2 - 1.0) * (1.0 - sin2);
        let gtr1 = (a2 - 1.0) / (core::f64::consts::PI * a2.ln() * t);
        near(Gtr::new(alpha, 1.0).d(m), gtr1 as f32, "GTR1");
        for gamma in [0.5, 1.5, 3.0] {
            let c = (gamma - 1.0) * (a2 - 1.0) / (core::f64::consts::PI * (1.0 - a2.powf(1.0 - gamma)));
            near(Gtr::new(alpha, gamma as f32).d(m), (c / t.powf(gamma)) as f32, "GTR");
        }
        let d = BlinnPhong::from_exponent(17.0);
        near(d.d(m), 19.0 / core::f32::consts::TAU * m.z.powi(17), "Blinn-Phong");
        near(d.exponent(), 17.0, "exponent");
    }
    // Walter's rational fit of Beckmann's G1 is within 0.35 % of it.
    for i in 1..100 {
        let a = i as f32 * 0.016;
        let tan = 1.0 / (0.5 * a);
        let w = vec3a(tan, 0.0, 1.0).normalize();
        let g1 = 1.0 / (1.0 + Beckmann::new(0.5, 0.5).lambda(w));
        let fit = (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a);
        assert!((g1 / fit - 1.0).abs() < 5e-3, "a {a}: {g1} {fit}");
    }
    // The notes' two k.
    let v = vec3a(0.8, 0.0, 0.6);
    let d = Ggx::new(0.25, 0.25);
    let g = |k: f32| 0.6 / (0.6 * (1.0 - k) + k);
    assert!((SchlickGgx::direct(0.5).g1(&d, v, Vec3A::Z) - g(2.25 / 8.0)).abs() < 1e-6);
    assert!((SchlickGgx::indirect(0.5).g1(&d, v, Vec3A::Z) - g(0.125)).abs() < 1e-6);
    assert!((SchlickGgx::direct(0.5).g2(&d, v, v, Vec3A::Z) - g(2.25 / 8.0).powi(2)).abs() < 1e-6);
}

/// The generic lobe with GGX and Smith is the fast one.
#[test]
fn the_generic_lobe_is_the_fast_one() {
    let f = Schlick { f0: Spectrum::rgb(1.0, 0.77, 0.34), f90: Spectrum::ONE };
    let mut rng = Rng::new(8);
    for _ in 0..20_000 {
        let [ax, ay] = [0.001 + rng.uniform(), 0.001 + rng.uniform()];
        let slow = Microfacet::new(Ggx::new(ax, ay), Smith, f);
        let fast = etendue_bxdf::GgxReflection::new(ax, ay, f);
        let (wo, wi) = (wo_at(89.9 * rng.uniform()), wo_at(-89.9 * rng.uniform()));
        let (a, b) = (slow.eval(wo, wi), fast.eval(wo, wi));
        assert!(
            (a - b).map(f32::abs).max_element() <= 2e-5 * b.max_element(),
            "α {ax} {ay} {wo} {wi}: {a:?} {b:?}"
        );
    }
}

/// Lobes of every distribution and masking; those that must not make light are marked.
fn lobes() -> Vec<(Subject, bool)> {
    let mut out = Vec::new();
    let copper = Conductor::new(Spectrum::rgb(0.21, 1.04, 1.29), Spectrum::rgb(3.3, 2.62, 2.36));
    let tint = F82Tint::from_tint(Spectrum::rgb(0.9, 0.5, 0.2), Spectrum::rgb(0.7, 0.9, 1.0));
    for (i, (name, d)) in distributions().into_iter().enumerate() {
        let exact = match d {
            AnyDistribution::Gtr(g) => g.gamma() == 2.0,
            AnyDistribution::BlinnPhong(_) => false,
            _ => true,
        };
        let roughness = d.alpha()[0].sqrt();
        let maskings = [
            ("smith", AnyMasking::Smith(Smith), exact),
            ("separable", AnyMasking::SmithSeparable(SmithSeparable), exact),
            ("v-cavity", AnyMasking::VCavity(VCavity), true),
            ("schlick", AnyMasking::SchlickGgx(SchlickGgx::direct(roughness)), false),
        ];
        for (j, (masking, g, conserves)) in maskings.into_iter().enumerate() {
            if !full() && (i + j) % 2 == 1 {
                continue;
            }
            let subject = |fresnel: &str, bsdf: Box<dyn Bsdf>| Subject {
                name: format!("{name} {masking} {fresnel}"),
                bsdf,
            };
            out.push((subject("F=1", Box::new(Microfacet::new(d, g, Schlick::ONE))), conserves));
            if i % 5 == j || full() {
                out.push((subject("copper", Box::new(Microfacet::new(d, g, copper))), conserves));
                out.push((subject("f82", Box::new(Microfacet::new(d, g, tint))), conserves));
            }
        }
    }
    out
}

fn each_cell<T>(subjects: &[T], mut f: impl FnMut(&T, f32, u64)) -> usize {
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
    let subjects = lobes();
    let level = sidak(0.01, subjects.len() * angles().len());
    let mut failures = Vec::new();
    let cells = each_cell(&subjects, |(s, _), angle, seed| {
        let found = chi2::chi2(&*s.bsdf, wo_at(angle), samples(), 0x1000 + seed);
        if !(found.p >= level) {
            failures.push(format!("{} {angle}°: {found:?}", s.name));
        }
    });
    println!("χ²: {cells} cells of {} samples, each at level {level:.1e}", samples());
    assert!(failures.is_empty(), "{} of {cells} cells fail:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn weights_agree_and_nothing_makes_light() {
    let subjects = lobes();
    let mut worst = (0.0f32, String::new());
    let cells = each_cell(&subjects, |(s, conserves), angle, seed| {
        let wo = wo_at(angle);
        let m = sampling::samples(&*s.bsdf, wo, samples() / 20, 0x2000 + seed);
        let at = format!("{} {angle}°: {m:?}", s.name);
        assert!(!m.broken && m.weight_error < 1e-5 && m.pdf_error < 1e-5 && m.split_error < 1e-6, "{at}");
        assert!(m.length_error < 2e-6 && m.z < 4.5 && m.pdf_integral <= 1.0 + 1e-4, "{at}");
        let f = furnace::furnace(&*s.bsdf, wo, samples() / 4, 0x3000 + seed);
        assert!(f.z < 4.7, "{} {angle}°: {f:?}", s.name);
        let brightest = f.albedo.max_element();
        assert!(!conserves || brightest <= 1.001, "{} {angle}°: {f:?}", s.name);
        if !conserves && brightest > worst.0 {
            worst = (brightest, format!("{} {angle}°", s.name));
        }
    });
    println!("{cells} cells; the most that an inexact masking makes: {worst:?}");
}

#[test]
fn light_may_turn_round() {
    for (s, _) in lobes() {
        let found = reciprocity::reciprocity(&*s.bsdf, samples() / 20, 0x4000);
        assert!(found.error <= 1e-4, "{}: {found:?}", s.name);
    }
}

/// Any widths, tails, indices and directions, NaN and infinity among them, give finite values that are not negative.
#[test]
fn no_input_breaks_a_lobe() {
    const ODD: [f32; 11] = [
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
        f32::MIN_POSITIVE,
    ];
    let mut rng = Rng::new(77);
    let ok = |s: Spectrum| s.is_finite() && s.0.iter().all(|&v| v >= 0.0);
    for i in 0..40_000u32 {
        let mut number =
            || if rng.uniform() < 0.25 { ODD[(rng.bits() % 11) as usize] } else { rng.uniform() };
        let (a, b, c) = (number(), number(), number());
        let distribution = match i % 4 {
            0 => AnyDistribution::Ggx(Ggx::new(a, b)),
            1 => AnyDistribution::Beckmann(Beckmann::new(a, b)),
            2 => AnyDistribution::Gtr(Gtr::new(a, 4.0 * b)),
            _ => AnyDistribution::BlinnPhong(BlinnPhong::new(a)),
        };
        let masking = match (i / 4) % 4 {
            0 => AnyMasking::Smith(Smith),
            1 => AnyMasking::SmithSeparable(SmithSeparable),
            2 => AnyMasking::VCavity(VCavity),
            _ => AnyMasking::SchlickGgx(SchlickGgx::new(c)),
        };
        let metal = Conductor::new(Spectrum::splat(number()), Spectrum::splat(number()));
        let mut direction = || {
            let v = vec3a(number() - 0.5, number() - 0.5, number());
            // Every other time a unit vector, as the contract asks; otherwise anything.
            if i % 2 == 0 { v.normalize_or(wo_at(89.9999)) } else { v }
        };
        let (wo, wi) = (direction(), direction());
        let (uc, u) = (number(), [number(), number()]);
        let lobe = Microfacet::new(distribution, masking, metal);
        let e = lobe.eval_pdf(wo, wi);
        let at = format!("{lobe:?} {wo} {wi} {uc} {u:?}: {e:?}");
        assert!(ok(e.specular) && e.pdf.is_finite() && e.pdf >= 0.0 && ok(lobe.albedo(wo)), "{at}");
        if let Some(s) = lobe.sample(wo, uc, u) {
            assert!(ok(s.weight) && s.pdf > 0.0 && s.pdf.is_finite() && s.wi.is_finite(), "{at} {s:?}");
        }
    }
}
