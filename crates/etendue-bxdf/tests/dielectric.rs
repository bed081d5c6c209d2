//! Boundaries that light passes, before every law.
//!
//! By default a part of the grid with 5·10⁴ samples per cell; with `ETENDUE_FULL=1` the whole grid with 10⁶.

// `!(p >= level)` also catches NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use etendue_bxdf::{
    Bsdf, GgxDielectric, MIN_COS, Schlick, ThinGgx,
    dielectric::{
        Dielectric, DielectricParams, DiffuseTransmission, Interface, SchlickInterface, Sheet,
        ThinSheetParams,
    },
    laws::{
        Rng, chi2, furnace,
        grid::{ANGLES, ANISOTROPY, ROUGHNESS, Subject, anisotropic_alpha, wo_at},
        reciprocity::{reciprocity, reciprocity_through},
        sampling, sidak,
    },
    model::{Incidence, ModelParams, Transport},
    multiscatter::Compensation,
    quadrature::directional_albedo,
    reflectance::{from_behind, hemispherical_directional},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

fn samples() -> usize {
    if full() { 1_000_000 } else { 50_000 }
}

/// Enough for the finer order of the quadrature, which refraction at grazing angles needs.
fn chi2_samples() -> usize {
    if full() { 1_000_000 } else { 400_000 }
}

fn angles() -> &'static [f32] {
    if full() { &ANGLES } else { &[0.0, 60.0, 89.0] }
}

/// Indices of the grid, entering; leaving is their inverse.
const IORS: [f32; 4] = [1.0, 1.33, 1.5, 2.4];

fn subject(name: String, bsdf: impl Bsdf + 'static) -> Subject {
    Subject { name, bsdf: Box::new(bsdf) }
}

/// The lobes over roughness × anisotropy × index, entering and leaving, counting power.
fn subjects() -> Vec<Subject> {
    let mut out = Vec::new();
    let gold = Schlick { f0: Spectrum::rgb(0.9, 0.5, 0.1), f90: Spectrum::ONE };
    for (i, roughness) in ROUGHNESS.into_iter().enumerate() {
        for (j, anisotropy) in ANISOTROPY.into_iter().enumerate() {
            let alpha = anisotropic_alpha(roughness, anisotropy);
            for (k, ior) in IORS.into_iter().enumerate() {
                // By default each roughness and each index, in turn with anisotropy.
                if !full() && (i + 2 * j + k) % 12 != 0 {
                    continue;
                }
                for (eta, way) in [(ior, "in"), (1.0 / ior, "out")] {
                    let at = format!("{way} {ior} roughness {roughness} anisotropy {anisotropy}");
                    let face = Dielectric::new(eta);
                    let power = Transport::Importance;
                    out.push(subject(format!("dielectric {at}"), GgxDielectric::new(alpha, face, power)));
                    let tinted = GgxDielectric::new(alpha, SchlickInterface::new(gold, eta), power)
                        .tinted(Spectrum::rgb(1.0, 0.5, 1.0), Spectrum::rgb(0.2, 0.4, 1.0));
                    out.push(subject(format!("tinted {at}"), tinted));
                }
                let face = Dielectric::new(ior);
                let at = format!("{ior} roughness {roughness} anisotropy {anisotropy}");
                let sheet = Sheet::new(face, Spectrum::rgb(1.0, 0.5, 0.1));
                out.push(subject(format!("thin {at}"), ThinGgx::new(alpha, sheet)));
                let p = ThinSheetParams { ior, roughness, anisotropy, fibers: 0.4, ..Default::default() };
                out.push(subject(format!("thin-sheet {at}"), p.closure(&Incidence::default())));
            }
        }
    }
    let rough = ThinGgx::new([0.3, 0.3], Dielectric::new(1.5)).with_transmission_alpha([0.05, 0.05]);
    out.push(subject("thin, two widths".into(), rough));
    let half = ThinGgx::new([0.3, 0.3], Dielectric::new(1.5)).with_transmission_alpha([0.0, 0.0]);
    out.push(subject("thin, smooth behind".into(), half));
    let leaf = DiffuseTransmission::new(Spectrum::rgb(0.1, 0.3, 0.1), Spectrum::rgb(0.5, 0.6, 0.2));
    out.push(subject("diffuse transmission".into(), leaf));
    out
}

#[test]
fn samples_follow_their_density() {
    let subjects = subjects();
    let cells = subjects.len() * angles().len();
    let level = sidak(0.01, cells);
    let mut failures = Vec::new();
    for (i, s) in subjects.iter().enumerate() {
        for &angle in angles() {
            let found = chi2::chi2(&*s.bsdf, wo_at(angle), chi2_samples(), 0x1000 + i as u64);
            if !(found.p >= level) {
                failures.push(format!("{} {angle}°: {found:?}", s.name));
            }
        }
    }
    println!("χ²: {cells} cells of {} samples, each at level {level:.1e}", chi2_samples());
    assert!(failures.is_empty(), "{} of {cells} cells fail:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn weights_agree_with_eval_and_nothing_makes_light() {
    let n = samples() / 10;
    for (i, s) in subjects().iter().enumerate() {
        for &angle in angles() {
            let m = sampling::samples(&*s.bsdf, wo_at(angle), n, 0x2000 + i as u64);
            let at = format!("{} {angle}°: {m:?}", s.name);
            assert!(!m.broken, "{at}");
            assert!(m.weight_error < 2e-6 && m.pdf_error < 2e-6 && m.split_error < 1e-6, "{at}");
            assert!(m.length_error < 2e-6 && m.pdf_integral <= 1.0 + 1e-4 && m.z < 4.5, "{at}");
            // A boundary's weights are at most 1; a sheet's two lobes are picked by their means, at least 2 % each.
            assert!(m.largest_weight <= if s.name.starts_with("dielectric") { 1.0001 } else { 60.0 }, "{at}");
            let f = furnace::furnace(&*s.bsdf, wo_at(angle), n, 0x3000 + i as u64);
            let at = format!("{} {angle}°: {f:?}", s.name);
            assert!(f.albedo.max_element() <= 1.0 + 1e-3, "{at}");
            // The quadrature of anisotropic lobes near total reflection is off by up to 3e-4.
            let off = (f.sampled - f.albedo).map(f32::abs);
            assert!((0..4).all(|i| off[i] <= 4.5 * f.error[i] + 3e-4), "{at}");
        }
    }
}

/// Both sides of one boundary, in both modes, with both interfaces.
#[test]
fn light_may_turn_round() {
    let n = samples() / 20;
    let check = |near: &dyn Bsdf, far: &dyn Bsdf, mode: Transport, at: &str| {
        let r = reciprocity(near, n, 0x4000);
        assert!(r.error <= 1e-4, "{at}: {r:?}");
        let r = reciprocity_through(near, far, mode, n, 0x5000);
        assert!(r.error <= 1e-4, "through {at}: {r:?}");
    };
    for roughness in [0.1, 0.3, 0.6, 1.0] {
        for anisotropy in ANISOTROPY {
            let alpha = anisotropic_alpha(roughness, anisotropy);
            for ior in [1.33, 1.5, 2.4] {
                for mode in [Transport::Radiance, Transport::Importance] {
                    let at = format!("{ior} roughness {roughness} anisotropy {anisotropy} {mode:?}");
                    let exact = |eta: f32| GgxDielectric::new(alpha, Dielectric::new(eta), mode);
                    check(&exact(ior), &exact(1.0 / ior), mode, &at);
                    check(&exact(1.0 / ior), &exact(ior), mode, &at);
                    let schlick = Schlick { f0: Spectrum::rgb(0.04, 0.3, 0.9), f90: Spectrum::splat(0.8) };
                    let side =
                        |eta: f32| GgxDielectric::new(alpha, SchlickInterface::new(schlick, eta), mode);
                    check(&side(ior), &side(1.0 / ior), mode, &format!("schlick {at}"));
                }
                let sheet = ThinSheetParams { ior, roughness, anisotropy, fibers: 0.3, ..Default::default() };
                let (front, back) = (Incidence::default(), Incidence { front: false, ..Default::default() });
                let at = format!("sheet {ior} {roughness} {anisotropy}");
                check(&sheet.closure(&front), &sheet.closure(&back), Transport::Radiance, &at);
            }
        }
    }
}

/// Radiance is compressed by η²; power is not.
#[test]
fn radiance_and_power_differ_by_the_squared_index() {
    let (wo, eta) = (wo_at(40.0), 1.5);
    for alpha in [0.0, 0.2] {
        let at = |mode| GgxDielectric::new([alpha, alpha], Dielectric::new(eta), mode);
        let radiance = hemispherical_directional(&at(Transport::Radiance), wo);
        let power = hemispherical_directional(&at(Transport::Importance), wo);
        assert!((radiance.reflection[0] - power.reflection[0]).abs() < 1e-6);
        assert!(
            (radiance.transmission[0] * eta * eta - power.transmission[0]).abs() < 1e-4,
            "{radiance:?} {power:?}"
        );
        assert!(power.transmission[0] > 0.9);
    }
}

/// As roughness goes to zero the lobes become the perfectly specular parts, in both directions and beyond the critical angle.
#[test]
fn roughness_goes_to_zero_smoothly() {
    for eta in [1.33, 1.5, 2.4, 1.0 / 1.5, 1.0 / 2.4] {
        for angle in [0.0, 30.0, 50.0, 80.0] {
            let wo = wo_at(angle);
            let at =
                |alpha: f32| GgxDielectric::new([alpha, alpha], Dielectric::new(eta), Transport::Radiance);
            let (rough, smooth) = (at(1.01e-4), at(0.0));
            assert!(smooth.is_smooth() && !rough.is_smooth());
            let (a, b) = (hemispherical_directional(&rough, wo), hemispherical_directional(&smooth, wo));
            assert!(
                (a.reflection - b.reflection).map(f32::abs).max_element() < 2e-4,
                "{eta} {angle}: {a:?} {b:?}"
            );
            assert!(
                (a.transmission - b.transmission).map(f32::abs).max_element() < 2e-4,
                "{eta} {angle}: {a:?} {b:?}"
            );
            if let Some(d) = smooth.deltas(wo)[1] {
                // Snell: η sin θt = sin θo, in one plane.
                let sin = |w: Vec3A| (w.x * w.x + w.y * w.y).sqrt();
                assert!((eta * sin(d.wi) - sin(wo)).abs() < 1e-6);
                assert!((wo.x * d.wi.y - wo.y * d.wi.x).abs() < 1e-6 && d.wi.x * wo.x <= 0.0);
                assert!((rough.refraction().expect("passes") - eta).abs() < 1e-6);
            } else {
                assert!(sin_beyond(wo, eta), "{eta} {angle}");
                assert!((smooth.deltas(wo)[0].expect("all is reflected").reflectance[0] - 1.0).abs() < 1e-6);
            }
        }
    }
}

fn sin_beyond(wo: Vec3A, eta: f32) -> bool {
    (wo.x * wo.x + wo.y * wo.y).sqrt() >= eta
}

/// Without a difference of indices there is nothing to see, at any roughness; with a reflectance of its own a matched
/// boundary passes the rest straight on.
#[test]
fn matched_media_pass_light_straight() {
    for roughness in [0.0, 0.3, 1.0] {
        let p = DielectricParams { ior: 1.5, roughness, ..Default::default() };
        let closure = p.closure(&Incidence { exterior_ior: 1.5, ..Default::default() });
        let wo = wo_at(70.0);
        let [mirrored, passed] = closure.deltas(wo);
        assert!(mirrored.is_none() && closure.refraction() == Some(1.0));
        let passed = passed.expect("passes");
        assert!(
            (passed.wi + wo).length() < 1e-6
                && passed.reflectance == Spectrum::ONE
                && passed.probability == 1.0
        );
        assert_eq!(closure.eval(wo, -wo), Spectrum::ZERO);
    }
    let coat = Schlick { f0: Spectrum::splat(0.1), f90: Spectrum::ONE };
    let face = SchlickInterface::new(coat, 1.0);
    for angle in ANGLES {
        let closure = GgxDielectric::new([0.25, 0.25], face, Transport::Radiance);
        let r = hemispherical_directional(&closure, wo_at(angle));
        assert!(r.total()[0] <= 1.001 && r.transmission[0] > 0.0 && r.reflection[0] > 0.05, "{angle}: {r:?}");
    }
}

/// A clear smooth pane: Stokes's sums, exactly, and all energy.
#[test]
fn a_pane_keeps_all_light() {
    for angle in ANGLES {
        let wo = wo_at(angle);
        let pane = ThinSheetParams::default().closure(&Incidence::default());
        let [r, t] = pane.deltas(wo).map(|d| d.expect("both").reflectance[0]);
        let face = Dielectric::new(1.5).reflect(wo.z)[0];
        assert!(
            (r - 2.0 * face / (1.0 + face)).abs() < 1e-5 && (r + t - 1.0).abs() < 1e-5,
            "{angle}: {r} {t}"
        );
        assert!((directional_albedo(&pane, wo)[0] - 1.0).abs() < 1e-5);
    }
}

#[test]
fn parameters_mean_what_they_say() {
    // Dispersion: Abbe number 20 / dispersion, from red to blue (n − 1) / V.
    let flint = DielectricParams { ior: 1.62, dispersion: 20.0 / 36.0, ..Default::default() };
    let spread = flint.ior_of(Some(2)) - flint.ior_of(Some(0));
    assert!(
        (spread - 0.62 / 36.0).abs() < 1e-6 && flint.ior_of(Some(1)) == 1.62 && flint.ior_of(None) == 1.62
    );
    let inside = flint.interior().expect("a body");
    assert!(inside.dispersive && inside.ior == 1.62 && inside.absorption == Spectrum::ZERO);
    let lane = Incidence { lane: Some(2), ..Default::default() };
    assert!((flint.closure(&lane).refraction().expect("passes") - flint.ior_of(Some(2))).abs() < 1e-6);
    // From inside, in water.
    let inverse = Incidence { front: false, exterior_ior: 1.33, ..Default::default() };
    assert!((flint.closure(&inverse).refraction().expect("passes") - 1.33 / 1.62).abs() < 1e-6);
    let wine = DielectricParams {
        absorption_color: Spectrum::rgb(0.5, 0.1, 0.1),
        absorption_distance: 0.02,
        priority: 2.0,
        ..Default::default()
    };
    let inside = wine.interior().expect("a body");
    assert_eq!(inside.priority, 2);
    assert!((inside.absorption[0] - 0.5f32.ln().abs() / 0.02).abs() < 1e-3);
}

#[test]
fn no_input_breaks_anything() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-30, 1e-3, 0.5, 1.0, 1e30];
    let mut rng = Rng::new(99);
    let n = if full() { 400_000 } else { 40_000 };
    for _ in 0..n {
        let mut number = || {
            if rng.uniform() < 0.3 {
                odd[(rng.bits() % odd.len() as u64) as usize]
            } else {
                3.0 * rng.uniform()
            }
        };
        let color = |f: &mut dyn FnMut() -> f32| Spectrum([f(), f(), f(), f()]);
        let at = Incidence {
            front: number() > 1.0,
            exterior_ior: number(),
            transport: if number() > 1.0 { Transport::Radiance } else { Transport::Importance },
            lane: if number() > 1.0 { None } else { Some(number() as u8) },
        };
        let glass = DielectricParams {
            ior: number(),
            roughness: number(),
            anisotropy: number(),
            transmission_color: color(&mut number),
            absorption_color: color(&mut number),
            absorption_distance: number(),
            dispersion: number(),
            priority: number(),
            compensation: Compensation::KullaConty,
        };
        let sheet = ThinSheetParams {
            ior: number(),
            roughness: number(),
            anisotropy: number(),
            crossing_color: color(&mut number),
            fibers: number(),
            reflect_color: color(&mut number),
            transmit_color: color(&mut number),
        };
        let face =
            SchlickInterface::new(Schlick { f0: color(&mut number), f90: color(&mut number) }, number());
        let lobe = GgxDielectric::new([number(), number()], face, at.transport)
            .tinted(color(&mut number), color(&mut number));
        let thin = ThinGgx::new([number(), number()], Sheet::new(face, color(&mut number)))
            .with_transmission_alpha([number(), number()])
            .tinted(color(&mut number), color(&mut number));
        let (u, v, w) = (number(), number(), number());
        let mut direction = || {
            let d = vec3a(number() - 1.0, number() - 1.0, number() - 1.0);
            match (number() * 2.0) as u32 {
                0 => d,
                1 => Vec3A::Z,
                2 => vec3a(1.0, 0.0, MIN_COS * 1.5),
                3 => vec3a(-0.6, 0.0, -0.8),
                _ => d.normalize_or(Vec3A::Z),
            }
        };
        let (wo, wi) = (direction(), direction());
        let interior = glass.interior().expect("a body");
        assert!(interior.absorption.is_finite() && interior.ior.is_finite());
        sound(&glass.closure(&at), wo, wi, [u, v, w]);
        sound(&sheet.closure(&at), wo, wi, [u, v, w]);
        sound(&lobe, wo, wi, [u, v, w]);
        sound(&thin, wo, wi, [u, v, w]);
    }
}

fn sound<B: Bsdf + std::fmt::Debug>(bsdf: &B, wo: Vec3A, wi: Vec3A, u: [f32; 3]) {
    let ok = |s: Spectrum| s.is_finite() && s.0.iter().all(|&v| v >= 0.0);
    let at = format!("{bsdf:?} {wo:?} {wi:?} {u:?}");
    let e = bsdf.eval_pdf(wo, wi);
    assert!(ok(e.diffuse) && ok(e.specular) && e.pdf.is_finite() && e.pdf >= 0.0, "{e:?} {at}");
    assert!(ok(bsdf.albedo(wo)), "{at}");
    for w in [wi, from_behind(wi), -wo] {
        assert!(ok(bsdf.eval(wo, w)), "{at}");
    }
    if let Some(s) = bsdf.sample(wo, u[0], [u[1], u[2]]) {
        assert!(ok(s.weight) && s.pdf > 0.0 && s.pdf.is_finite() && s.wi.is_finite(), "{s:?} {at}");
        assert!(wo.z > MIN_COS && s.wi.z.abs() > MIN_COS, "{s:?} {at}");
    }
    for d in bsdf.deltas(wo).into_iter().flatten() {
        assert!(ok(d.reflectance) && (0.0..=1.0).contains(&d.probability) && d.wi.is_finite(), "{d:?} {at}");
    }
}
