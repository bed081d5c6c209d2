//! Matte, fibrous and Disney surfaces before the laws.
//!
//! By default a part of the grid with 2·10⁴ samples per cell; with `ETENDUE_FULL=1` the whole grid with 10⁶.

// `!(p >= level)` also catches NaN.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use etendue_bxdf::{
    Bsdf, DisneyDiffuse, Eon, Fuzz, OrenNayar, Sheen, SheenRow,
    diffuse::{
        disney::DisneyPair,
        eon::{fon_albedo, fon_albedo_fit},
        oren_nayar::OrenNayarForm,
    },
    laws::{
        Rng, chi2, furnace,
        grid::{ANGLES, ROUGHNESS, Subject, wo_at},
        reciprocity, sampling, sidak,
    },
    quadrature::{average_albedo, directional_albedo},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

const WHITE: Spectrum = Spectrum::ONE;

const FORMS: [(&str, OrenNayarForm); 3] = [
    ("qualitative", OrenNayarForm::Qualitative),
    ("fujii", OrenNayarForm::Fujii),
    ("fujii-scaled", OrenNayarForm::FujiiScaled),
];

/// The largest albedo that a lobe claims.
fn most(name: &str) -> f32 {
    match name {
        n if n.starts_with("disney-diffuse") => 1.56,
        n if n.starts_with("oren-nayar qualitative") => 1.015,
        n if n.starts_with("oren-nayar fujii ") => 1.029,
        _ => 1.0 + 1e-3,
    }
}

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

fn samples() -> usize {
    if full() { 1_000_000 } else { 20_000 }
}

fn angles() -> &'static [f32] {
    if full() { &ANGLES } else { &[60.0, 89.0] }
}

fn roughness() -> &'static [f32] {
    if full() { &ROUGHNESS } else { &[0.0, 0.1, 1.0] }
}

fn colour() -> Spectrum {
    Spectrum::rgb(0.9, 0.4, 0.05)
}

/// Lobes that claim to be reciprocal.
fn reciprocal() -> Vec<Subject> {
    let mut out = Vec::new();
    let mut push = |name: String, bsdf: Box<dyn Bsdf>| out.push(Subject { name, bsdf });
    for &r in roughness() {
        for (c, color) in [("white", WHITE), ("coloured", colour())] {
            push(format!("eon {c} roughness {r}"), Box::new(Eon::new(color, r)));
        }
        push(format!("sheen roughness {r}"), Box::new(Sheen::new(WHITE, r)));
        for (name, form) in FORMS {
            push(format!("oren-nayar {name} roughness {r}"), Box::new(OrenNayar::new(WHITE, r, form)));
        }
        for flat in [0.0, 0.5, 1.0] {
            let name = format!("disney-diffuse roughness {r} subsurface {flat}");
            push(name, Box::new(DisneyDiffuse::new(WHITE, r, flat)));
        }
    }
    out
}

fn everything() -> Vec<Subject> {
    let mut out = reciprocal();
    for &r in roughness() {
        out.push(Subject { name: format!("fuzz roughness {r}"), bsdf: Box::new(Fuzz::new(colour(), r)) });
    }
    out
}

#[test]
fn samples_follow_their_density() {
    let subjects = everything();
    let cells = subjects.len() * angles().len();
    let level = sidak(0.01, cells);
    let mut failures = Vec::new();
    for (i, s) in subjects.iter().enumerate() {
        for (j, &angle) in angles().iter().enumerate() {
            let seed = 0x1000 + (i * angles().len() + j) as u64;
            let found = chi2::chi2(&*s.bsdf, wo_at(angle), samples(), seed);
            if !(found.p >= level) {
                failures.push(format!("{} {angle}°: {found:?}", s.name));
            }
        }
    }
    println!("χ²: {cells} cells of {} samples, each at level {level:.1e}", samples());
    assert!(failures.is_empty(), "{} of {cells} cells fail:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn weights_densities_and_furnaces_agree() {
    let mut brightest = (0.0, String::new());
    let mut noisiest = (0.0, String::new());
    for (i, s) in everything().iter().enumerate() {
        for &angle in angles() {
            let wo = wo_at(angle);
            let m = sampling::samples(&*s.bsdf, wo, samples() / 4, 0x2000 + i as u64);
            let at = format!("{} {angle}°: {m:?}", s.name);
            assert!(!m.broken && m.length_error < 2e-6 && m.split_error < 1e-6, "{at}");
            // The fuzz lobe's weight is its reflectance, exactly; its value and density are rounded apart.
            assert!(m.weight_error < 5e-6 && m.pdf_error < 2e-6, "{at}");
            assert!(m.pdf_integral <= 1.0 + 2e-4 && m.z < 4.5, "{at}");
            let f = furnace::furnace(&*s.bsdf, wo, samples() / 4, 0x3000 + i as u64);
            let at = format!("{} {angle}°: {f:?}", s.name);
            assert!(f.albedo.max_element() <= most(&s.name) && f.z < 4.5, "{at}");
            let error = (f.claimed - f.albedo).map(f32::abs).max_element();
            let near =
                if s.name.starts_with("disney") && !s.name.ends_with("subsurface 0") { 0.05 } else { 4e-3 };
            assert!(error < near, "{at}");
            if f.albedo.max_element() > brightest.0 {
                brightest = (f.albedo.max_element(), s.name.clone());
            }
            let noise = f.variance[0].sqrt() / f.albedo[0].max(1e-3);
            if noise > noisiest.0 {
                noisiest = (noise, format!("{} {angle}°", s.name));
            }
        }
    }
    println!("brightest {brightest:?}; largest standard deviation of a weight over its mean {noisiest:?}");
}

#[test]
fn light_may_turn_round() {
    for s in reciprocal() {
        let found = reciprocity::reciprocity(&*s.bsdf, samples() / 4, 0x4000);
        assert!(found.error <= 1e-4, "{}: {found:?}", s.name);
    }
}

/// White EON returns all that comes in, at each roughness and angle.
#[test]
fn white_eon_keeps_all_energy() {
    for r in [0.0, 0.01, 0.2, 0.5, 0.8, 1.0] {
        for angle in [0.0, 20.0, 45.0, 70.0, 85.0, 89.0, 89.9] {
            let got = directional_albedo(&Eon::new(WHITE, r), wo_at(angle))[0];
            assert!((got - 1.0).abs() < 3e-4, "roughness {r} {angle}°: {got}");
        }
        // Without its multiple scattering, it is Fujii's form, whose albedo is known.
        for cos in [0.02f32, 0.3, 0.7, 1.0] {
            let dark = Eon::new(Spectrum::splat(1e-4), r);
            let got = directional_albedo(&dark, vec3a((1.0 - cos * cos).sqrt(), 0.0, cos))[0] * 1e4;
            assert!((got - fon_albedo(cos, r)).abs() < 2e-4, "roughness {r} cos {cos}: {got}");
            assert!((got - fon_albedo_fit(cos, r)).abs() < 6e-4, "roughness {r} cos {cos}: {got}");
        }
    }
}

/// The two ways to write Disney's diffuse surface are one; the fifth power that retellings lose is there.
#[test]
fn disney_diffuse_is_burleys() {
    let mut rng = Rng::new(3);
    for _ in 0..2000 {
        let wo = etendue_bxdf::sampling::uniform_hemisphere(rng.square());
        let wi = etendue_bxdf::sampling::uniform_hemisphere(rng.square());
        if wo.z < 1e-3 || wi.z < 1e-3 {
            continue;
        }
        let r = rng.uniform();
        let pair = DisneyPair::new(wo, wi);
        let split = pair.lambert() + pair.retro(r);
        assert!((split - pair.base(r)).abs() < 1e-5 * pair.base(r).max(1.0), "{wo} {wi} {r}");
        // The formulas in f64, from angles.
        let (o, i) = (wo.as_dvec3(), wi.as_dvec3());
        let cos2_d = o.dot((o + i).normalize()).powi(2);
        let product =
            |f90: f64| (1.0 + (f90 - 1.0) * (1.0 - i.z).powi(5)) * (1.0 + (f90 - 1.0) * (1.0 - o.z).powi(5));
        let base = product(0.5 + 2.0 * r as f64 * cos2_d);
        let flat = 1.25 * (product(r as f64 * cos2_d) * (1.0 / (o.z + i.z) - 0.5) + 0.5);
        for (subsurface, want) in [(0.0, base), (1.0, flat)] {
            let got = DisneyDiffuse::new(WHITE, r, subsurface).eval(wo, wi)[0] as f64 * core::f64::consts::PI;
            assert!((got - want).abs() < 2e-5 * want.max(1.0), "{wo} {wi} {r}: {got} for {want}");
        }
    }
    // Rough and seen at 45°, light from 45° behind the eye: FD90 = 2.5 moves a hundredth only with the fifth power.
    let w = vec3a(0.5f32.sqrt(), 0.0, 0.5f32.sqrt());
    let got = DisneyPair::new(w, w).base(1.0);
    assert!((got - 1.006_49).abs() < 1e-4, "{got}");
}

/// Oren and Nayar's own formula, from angles.
#[test]
fn oren_nayar_is_theirs() {
    let mut rng = Rng::new(4);
    for _ in 0..2000 {
        let [a, b] = rng.square().map(|u| 0.01 + 1.55 * u as f64);
        let phi = rng.uniform() as f64 * core::f64::consts::TAU;
        let r = rng.uniform();
        let wo = vec3a(a.sin() as f32, 0.0, a.cos() as f32);
        let wi = vec3a((b.sin() * phi.cos()) as f32, (b.sin() * phi.sin()) as f32, b.cos() as f32);
        let s2 = (r as f64 * core::f64::consts::FRAC_PI_2).powi(2);
        let ca = 1.0 - 0.5 * s2 / (s2 + 0.33);
        let cb = 0.45 * s2 / (s2 + 0.09);
        let want =
            (ca + cb * phi.cos().max(0.0) * a.max(b).sin() * a.min(b).tan()) * core::f64::consts::FRAC_1_PI;
        let got = OrenNayar::new(WHITE, r, OrenNayarForm::Qualitative).eval(wo, wi)[0] as f64;
        assert!((got - want).abs() < 1e-5, "{a} {b} {phi} {r}: {got} for {want}");
        // Where all light is single scattering, EON is Fujii's scaled form.
        let (dark, colour) = (1e-4, Spectrum::splat(1e-4));
        let single = OrenNayar::new(colour, r, OrenNayarForm::FujiiScaled).eval(wo, wi)[0];
        let eon = Eon::new(colour, r).eval(wo, wi)[0];
        assert!((single - eon).abs() < 2.0 * dark * dark, "{single} {eon}");
    }
}

/// The most that each form returns of a white sky, at grazing angles, is what its documentation says.
#[test]
fn oren_nayar_makes_as_much_light_as_it_says() {
    let wo = vec3a((1.0f32 - 1e-8).sqrt(), 0.0, 1e-4);
    for ((name, form), most) in FORMS.into_iter().zip([1.015, 1.029, 1.0]) {
        let largest = (0..=1000)
            .map(|i| OrenNayar::new(WHITE, i as f32 / 1000.0, form).albedo(wo)[0])
            .fold(0.0, f32::max);
        assert!((largest - most).abs() < 1e-3, "{name}: {largest}");
        let r = 0.15;
        let (claimed, exact) = (OrenNayar::new(WHITE, r, form).albedo(wo), OrenNayar::new(WHITE, r, form));
        assert!((claimed - directional_albedo(&exact, wo)).map(f32::abs).max_element() < 1e-3);
    }
}

/// The sheen table against the integral, and the scaling of what lies below.
#[test]
fn the_sheen_table_meets_the_integral() {
    let mut rng = Rng::new(5);
    let mut worst = 0.0f32;
    for i in 0..150 {
        let r = rng.uniform();
        let cos = 0.005 + 0.995 * rng.uniform().powi(1 + i % 3);
        let sheen = Sheen::new(WHITE, r);
        let want = directional_albedo(&sheen, vec3a((1.0 - cos * cos).sqrt(), 0.0, cos))[0];
        let got = sheen.row().directional(cos);
        let error = (want - got).abs();
        worst = worst.max(error);
        assert!(error < if r < 0.1 { 1e-2 } else { 3e-3 }, "roughness {r} cos {cos}: {got} for {want}");
    }
    println!("worst error of E {worst:.1e}");
    for r in [0.1, 0.5, 1.0] {
        let (want, row) = (average_albedo(&Sheen::new(WHITE, r))[0], SheenRow::new(r));
        assert!((row.average() - want).abs() < 3e-3, "{r}: {} for {want}", row.average());
        let below = row.below(0.7, 0.2, 0.6);
        assert!((below - (1.0 - 0.7 * row.directional(0.2))).abs() < 1e-6);
        assert!(below <= row.below_view(0.7, 0.6));
    }
}

/// The fitted sampling keeps the weights of the sheen lobe near their mean; an even hemisphere does several times worse.
#[test]
fn sheen_is_sampled_well() {
    let mut rng = Rng::new(8);
    let mut worst = (0.0, 0.0, 0.0);
    let mut even_worst = 0.0f64;
    for r in [0.2, 0.3, 0.5, 0.75, 1.0] {
        for angle in [0.0, 40.0, 60.0, 75.0, 85.0] {
            let (wo, sheen) = (wo_at(angle), Sheen::new(WHITE, r));
            let n = 20_000;
            let mut sums = [0.0f64; 4];
            for _ in 0..n {
                let w = sheen.sample(wo, rng.uniform(), rng.square()).map_or(0.0, |s| s.weight[0] as f64);
                let wi = etendue_bxdf::sampling::uniform_hemisphere(rng.square());
                let even = (sheen.eval(wo, wi)[0] * wi.z) as f64 * core::f64::consts::TAU;
                for (sum, v) in sums.iter_mut().zip([w, w * w, even, even * even]) {
                    *sum += v / n as f64;
                }
            }
            let [m, m2, e, e2] = sums;
            let (ours, even) = (m2 / (m * m) - 1.0, e2 / (e * e) - 1.0);
            even_worst = even_worst.max(even);
            assert!(ours < 0.6, "roughness {r} {angle}°: relative variance {ours}");
            if ours > worst.0 {
                worst = (ours, r, angle);
            }
        }
    }
    println!("largest relative variance of a weight {worst:?}, of an even hemisphere {even_worst}");
    assert!(even_worst > 2.0 * worst.0);
}

/// The formulas of `KHR_materials_sheen`, written out in `f64`.
#[test]
fn sheen_is_the_extensions() {
    fn l(x: f64, t: f64) -> f64 {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        mix(21.5473, 25.3245) / (1.0 + mix(3.82987, 3.32435) * x.powf(mix(0.19823, 0.16801)))
            + mix(-1.97760, -1.27393) * x
            + mix(-4.32054, -4.85967)
    }
    let mut rng = Rng::new(11);
    for _ in 0..2000 {
        let r = 0.05 + 0.95 * rng.uniform();
        let alpha = (r as f64) * (r as f64);
        let t = (1.0 - alpha) * (1.0 - alpha);
        let lambda = |c: f64| if c < 0.5 { l(c, t).exp() } else { (2.0 * l(0.5, t) - l(1.0 - c, t)).exp() };
        let draw = |rng: &mut Rng| {
            let [a, b] = rng.square();
            let z = 0.01 + 0.98 * a;
            let s = (1.0 - z * z).sqrt();
            let (y, x) = (b * core::f32::consts::TAU).sin_cos();
            vec3a(s * x, s * y, z)
        };
        let (wo, wi) = (draw(&mut rng), draw(&mut rng));
        let h = (wo.as_dvec3() + wi.as_dvec3()).normalize();
        let d = (2.0 + 1.0 / alpha) * (1.0 - h.z * h.z).powf(0.5 / alpha) / core::f64::consts::TAU;
        let (zo, zi) = (wo.z as f64, wi.z as f64);
        let want = d / ((1.0 + lambda(zo) + lambda(zi)) * 4.0 * zo * zi);
        let got = Sheen::new(WHITE, r).literal().eval(wo, wi)[0] as f64;
        assert!((got - want).abs() <= 2e-4 * want + 1e-9, "roughness {r} {wo} {wi}: {got} for {want}");
    }
}

/// Any parameters and directions, NaN and infinity among them, give finite values that are not negative.
#[test]
fn no_input_breaks_anything() {
    const ODD: [f32; 10] =
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, 1.0, -1.0, 1e-30, 1e30, 1e-6];
    let mut rng = Rng::new(99);
    let ok = |s: Spectrum| s.is_finite() && s.0.iter().all(|&v| v >= 0.0);
    for i in 0..if full() { 200_000 } else { 30_000u32 } {
        let number = |rng: &mut Rng| {
            if rng.uniform() < 0.3 { ODD[(rng.bits() % 10) as usize] } else { rng.uniform() }
        };
        let four = |rng: &mut Rng| Spectrum(core::array::from_fn(|_| number(rng)));
        let (color, roughness) = (four(&mut rng), number(&mut rng));
        let direction = |rng: &mut Rng| {
            let v = four(rng);
            let v = vec3a(v[0], v[1], v[2]);
            // Every other time a unit vector, as the contract asks; otherwise anything.
            if i % 2 == 0 { v.normalize_or(wo_at(89.9999)) } else { v }
        };
        let (wo, wi): (Vec3A, Vec3A) = (direction(&mut rng), direction(&mut rng));
        let u = four(&mut rng).0;
        let u_extra = number(&mut rng);
        let closures: [&dyn Bsdf; 8] = [
            &OrenNayar::new(color, roughness, OrenNayarForm::Qualitative),
            &OrenNayar::new(color, roughness, OrenNayarForm::Fujii),
            &OrenNayar::new(color, roughness, OrenNayarForm::FujiiScaled),
            &DisneyDiffuse::new(color, roughness, u_extra),
            &Eon::new(color, roughness),
            &Sheen::new(color, roughness),
            &Sheen::new(color, roughness).literal(),
            &Fuzz::new(color, roughness),
        ];
        for (k, bsdf) in closures.into_iter().enumerate() {
            let e = bsdf.eval_pdf(wo, wi);
            let at = format!("{k}: {color:?} {roughness} {wo} {wi} {u:?}: {e:?}");
            assert!(ok(e.diffuse) && ok(e.specular) && e.pdf.is_finite() && e.pdf >= 0.0, "{at}");
            assert!(ok(bsdf.albedo(wo)), "{at}");
            if let Some(s) = bsdf.sample(wo, u[0], [u[1], u[2]]) {
                assert!(ok(s.weight) && s.pdf > 0.0 && s.pdf.is_finite() && s.wi.is_finite(), "{at} {s:?}");
            }
        }
    }
}
