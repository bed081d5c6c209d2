//! Laws of the fibre: nothing is lost without absorption, samples are drawn from the density that is said, and the values
//! are those of the paper's formulas, written down again in `f64`.

use core::f64::consts::{PI, TAU};
use etendue_bxdf::{
    Bsdf,
    hair::{Hair, HairParams, Pigment, absorption_from_color, absorption_from_melanin},
    laws::{Rng, chi2::chi2, gamma::chi2_p_value, grid::wo_at, sidak},
    sampling::uniform_sphere,
};
use etendue_color::Spectrum;
use glam::{DVec3, Vec3A, vec3a};

fn params(beta_m: f32, beta_n: f32, h: f32, absorption: [f32; 3]) -> HairParams {
    HairParams {
        pigment: Pigment::Absorption,
        absorption: Spectrum([absorption[0], absorption[1], absorption[2], absorption[1]]),
        beta_m,
        beta_n,
        h,
        ..Default::default()
    }
}

fn views() -> [Vec3A; 5] {
    [
        Vec3A::Z,
        vec3a(0.5, 0.3, 0.8).normalize(),
        vec3a(-0.9, 0.1, 0.4).normalize(),
        vec3a(0.2, -0.95, 0.1).normalize(),
        vec3a(0.999, 0.0, 0.0447).normalize(),
    ]
}

/// A direction from the sine to the normal plane and the angle around the fibre.
fn direction(sin: f64, phi: f64) -> Vec3A {
    let cos = (1.0 - sin * sin).sqrt();
    DVec3::new(sin, cos * phi.cos(), cos * phi.sin()).as_vec3a()
}

/// A grid of cells over the sphere, even in the sine and in φ, so of equal solid angle: the midpoint of each.
fn cells(n: usize, m: usize) -> impl Iterator<Item = (usize, usize, Vec3A)> {
    (0..n * m).map(move |i| {
        let (a, b) = (i / m, i % m);
        let sin = 2.0 * (a as f64 + 0.5) / n as f64 - 1.0;
        (a, b, direction(sin, (b as f64 + 0.37) / m as f64 * TAU))
    })
}

/// The formulas as the paper has them, in `f64`, in another arrangement: with sinh, a series for I0, and ratios of sums.
mod paper {
    use super::*;

    pub fn bessel_i0(x: f64) -> f64 {
        let (q, mut term, mut sum) = (0.25 * x * x, 1.0, 1.0);
        for k in 1..400 {
            term *= q / (k * k) as f64;
            sum += term;
        }
        sum
    }

    fn mp(si: f64, ci: f64, so: f64, co: f64, v: f64) -> f64 {
        (-si * so / v).exp() * bessel_i0(ci * co / v) / (2.0 * v * (1.0 / v).sinh())
    }

    fn np(x: f64, s: f64) -> f64 {
        let x = (x + PI).rem_euclid(TAU) - PI;
        let cdf = |x: f64| 1.0 / (1.0 + (-x / s).exp());
        (-x / s).exp() / (s * (1.0 + (-x / s).exp()).powi(2)) / (cdf(PI) - cdf(-PI))
    }

    fn fresnel(c: f64, eta: f64) -> f64 {
        let t = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
        0.5 * (((eta * c - t) / (eta * c + t)).powi(2) + ((c - eta * t) / (c + eta * t)).powi(2))
    }

    /// F, without any cosine.
    pub fn scatter(p: &HairParams, wo: DVec3, wi: DVec3) -> [f64; 3] {
        let (bm, bn, eta, h) = (p.beta_m as f64, p.beta_n as f64, p.eta as f64, p.h as f64);
        let v = (0.726 * bm + 0.812 * bm * bm + 3.7 * bm.powi(20)).powi(2);
        let s = (PI / 8.0).sqrt() * (0.265 * bn + 1.194 * bn * bn + 5.372 * bn.powi(22));
        let (to, ti) = (wo.x.asin(), wi.x.asin());
        let phi = wi.z.atan2(wi.y) - wo.z.atan2(wo.y);
        let gamma_o = h.asin();
        let eta_p = (eta * eta - to.sin().powi(2)).sqrt() / to.cos();
        let gamma_t = (h / eta_p).asin();
        let cos_tt = (1.0 - (to.sin() / eta).powi(2)).sqrt();
        let f = fresnel(to.cos() * gamma_o.cos(), eta);
        let alpha = (p.alpha as f64).to_radians();
        let turned = [to - 2.0 * alpha, to + alpha, to + 4.0 * alpha, to];
        let variance = [v, v / 4.0, 4.0 * v, 4.0 * v];
        core::array::from_fn(|lane| {
            let t = (-(p.absorption[lane] as f64) * 2.0 * gamma_t.cos() / cos_tt).exp();
            let mut a = [f, (1.0 - f).powi(2) * t, 0.0, 0.0];
            a[2] = a[1] * t * f;
            a[3] = a[2] * t * f / (1.0 - t * f);
            (0..4)
                .map(|k| {
                    let m = mp(ti.sin(), ti.cos(), turned[k].sin(), turned[k].cos().abs(), variance[k]);
                    let exit = 2.0 * k as f64 * gamma_t - 2.0 * gamma_o + k as f64 * PI;
                    let n = if k < 3 { np(phi - exit, s) } else { 1.0 / TAU };
                    a[k] * m * n
                })
                .sum()
        })
    }
}

#[test]
fn values_are_those_of_the_paper() {
    let mut rng = Rng::new(2);
    let mut worst: f64 = 0.0;
    for _ in 0..4000 {
        let p = HairParams {
            alpha: 6.0 * rng.uniform() - 1.0,
            eta: 1.2 + rng.uniform(),
            ..params(
                0.15 + 0.85 * rng.uniform(),
                0.15 + 0.85 * rng.uniform(),
                1.98 * rng.uniform() - 0.99,
                [0.0, 0.3 * rng.uniform(), 2.0 * rng.uniform()],
            )
        };
        let mut wo = uniform_sphere(rng.square());
        wo.z = wo.z.abs();
        let wi = uniform_sphere(rng.square());
        // The reference takes arc sines, which lose their digits towards the fibre.
        if wo.z < 1e-3 || wi.z.abs() < 1e-3 || wo.x.abs() > 0.995 || wi.x.abs() > 0.995 {
            continue;
        }
        let got = Hair::new(&p).eval(wo, wi) * wi.z.abs();
        let want = paper::scatter(&p, wo.as_dvec3().normalize(), wi.as_dvec3().normalize());
        for lane in 0..3 {
            // Far tails of narrow lobes: exponents of some hundreds have 1e-5 of relative error.
            let error = (got[lane] as f64 - want[lane]).abs() / (want[lane] + 1e-4);
            worst = worst.max(error);
            assert!(error < 1e-3, "{p:?} {wo} {wi} lane {lane}: {} for {}", got[lane], want[lane]);
        }
    }
    println!("largest relative difference {worst:.1e}");
}

/// Integral over the sphere of f |z| and of the pdf, by midpoints even in θ and φ: where a lobe is narrow in θ, it is so evenly.
fn integrate(hair: &Hair, wo: Vec3A, n: usize, m: usize) -> ([f64; 4], f64) {
    let (mut light, mut density) = ([0.0f64; 4], 0.0);
    for k in 0..n * m {
        let theta = ((k / m) as f64 + 0.5) / n as f64 * PI - 0.5 * PI;
        let wi = direction(theta.sin(), ((k % m) as f64 + 0.37) / m as f64 * TAU);
        let cell = theta.cos() * PI * TAU / (n * m) as f64;
        let e = hair.eval_pdf(wo, wi);
        for (sum, v) in light.iter_mut().zip((e.value() * wi.z.abs()).0) {
            *sum += v as f64 * cell;
        }
        density += e.pdf as f64 * cell;
    }
    (light, density)
}

#[test]
fn a_fibre_without_absorption_loses_nothing_and_one_with_keeps_what_it_says() {
    let full = std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1");
    let betas: &[f32] = if full { &[0.1, 0.2, 0.4, 0.6, 0.8, 1.0] } else { &[0.15, 0.4, 1.0] };
    let mut worst: f64 = 0.0;
    for &beta_m in betas {
        for &beta_n in betas {
            for h in [-0.7, 0.0, 0.95] {
                for wo in [views()[0], views()[1], views()[4]] {
                    let white = Hair::new(&params(beta_m, beta_n, h, [0.0, 0.2, 1.0]));
                    let n = if beta_m < 0.3 { 400 } else { 160 };
                    let m = if beta_n < 0.3 { 320 } else { 100 };
                    let (light, density) = integrate(&white, wo, n, m);
                    let claimed = white.albedo(wo);
                    let what = format!("βM {beta_m} βN {beta_n} h {h} wo {wo}");
                    worst = worst.max((light[0] - 1.0).abs());
                    assert!((light[0] - 1.0).abs() < 1e-3, "{what}: {light:?}");
                    assert!((density - 1.0).abs() < 1e-3, "{what}: density {density}");
                    for lane in 0..3 {
                        let error = (light[lane] - claimed[lane] as f64).abs();
                        assert!(error < 1e-3, "{what}: {light:?} {claimed:?}");
                    }
                    assert!(claimed[2] < claimed[1] && claimed[1] < claimed[0]);
                }
            }
        }
    }
    println!("white furnace within {worst:.1e}");
}

#[test]
fn samples_are_what_they_say() {
    let mut rng = Rng::new(4);
    for beta in [0.01, 0.05, 0.3, 1.0] {
        for h in [-1.0, -0.5, 0.0, 0.9, 1.0] {
            let white = Hair::new(&params(beta, beta, h, [0.0; 3]));
            let brown = Hair::new(&params(beta, beta, h, [0.2, 0.4, 0.9]));
            for wo in views() {
                let (mut mean, mut n) = (0.0, 0.0);
                for _ in 0..2000 {
                    let (uc, u) = (rng.uniform(), rng.square());
                    n += 1.0;
                    if let Some(s) = white.sample(wo, uc, u) {
                        // All lobes are drawn by what they keep: the weight is their sum, one.
                        assert!((s.weight.max_element() - 1.0).abs() < 1e-4, "{beta} {h} {wo}: {s:?}");
                    }
                    let Some(s) = brown.sample(wo, uc, u) else { continue };
                    assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0);
                    let e = brown.eval_pdf(wo, s.wi);
                    assert!((e.pdf - s.pdf).abs() <= 1e-5 * s.pdf);
                    let w = e.value() * (s.wi.z.abs() / e.pdf);
                    assert!(
                        (w - s.weight).map(f32::abs).max_element() < 1e-4 * s.weight.max_element().max(1.0)
                    );
                    assert_eq!(s.weight, s.weight_diffuse + s.weight_specular);
                    assert!(s.weight.max_element() < 4.0, "{s:?}");
                    mean += s.weight[1] as f64;
                }
                let albedo = brown.albedo(wo)[1] as f64;
                assert!((mean / n - albedo).abs() < 0.05, "{beta} {h} {wo}: {} {albedo}", mean / n);
            }
        }
    }
}

/// χ² over cells of the whole sphere, each integrated by a grid of its own.
#[test]
fn samples_are_drawn_from_the_density() {
    const ROWS: usize = 40;
    const COLUMNS: usize = 36;
    let full = std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1");
    let n = if full { 1_000_000 } else { 60_000 };
    let mut cases = Vec::new();
    for (bm, bn) in [(0.15, 0.15), (0.15, 1.0), (0.3, 0.3), (0.6, 0.2), (1.0, 0.6)] {
        for h in [-0.8, 0.1, 0.99] {
            cases.extend(views().map(|wo| (bm, bn, h, wo)));
        }
    }
    if !full {
        // Every fourth meets each pair of roughness, each h and each view.
        cases = cases.into_iter().step_by(4).collect();
    }
    let level = sidak(0.01, cases.len());
    let mut least: f64 = 1.0;
    for (case, (bm, bn, h, wo)) in cases.iter().copied().enumerate() {
        let hair = Hair::new(&HairParams { alpha: 5.0, ..params(bm, bn, h, [0.05, 0.3, 1.0]) });
        let (sub_rows, sub_columns) = (if bm < 0.3 { 24 } else { 10 }, if bn < 0.3 { 10 } else { 5 });
        let mut expected = vec![0.0f64; ROWS * COLUMNS];
        for (a, b, wi) in cells(ROWS * sub_rows, COLUMNS * sub_columns) {
            let cell = 2.0 * TAU / (ROWS * sub_rows * COLUMNS * sub_columns) as f64;
            expected[a / sub_rows * COLUMNS + b / sub_columns] += hair.pdf(wo, wi) as f64 * cell * n as f64;
        }
        let mut observed = vec![0.0f64; ROWS * COLUMNS];
        let mut rng = Rng::new(100 + case as u64);
        // The midpoints of `cells` are set off by 0.13 of a column of the fine grid.
        let offset = -0.13 / (COLUMNS * sub_columns) as f64;
        for _ in 0..n {
            let Some(s) = hair.sample(wo, rng.uniform(), rng.square()) else { continue };
            let row = ((0.5 * (s.wi.x as f64 + 1.0) * ROWS as f64) as usize).min(ROWS - 1);
            let turn = ((s.wi.z as f64).atan2(s.wi.y as f64) / TAU - offset).rem_euclid(1.0);
            let column = ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1);
            observed[row * COLUMNS + column] += 1.0;
        }
        // Cells that expect too little are one.
        let (mut statistic, mut dof) = (0.0, 0usize);
        let (mut few_observed, mut few_expected) = (0.0, 0.0);
        for (o, e) in observed.iter().zip(&expected) {
            if *e < 10.0 {
                few_observed += o;
                few_expected += e;
            } else {
                statistic += (o - e).powi(2) / e;
                dof += 1;
            }
        }
        if few_expected > 5.0 {
            statistic += (few_observed - few_expected).powi(2) / few_expected;
            dof += 1;
        }
        let p = chi2_p_value(statistic, dof - 1);
        least = least.min(p);
        assert!(p > level, "βM {bm} βN {bn} h {h} wo {wo}: χ² {statistic:.1} of {dof}, p {p:.2e}");
    }
    println!("{} cases, least p {least:.2e}, level {level:.2e}", cases.len());
}

/// A narrow fibre's first reflection is that of a mirror with the cylinder's normal: fixes the signs of h and φ.
#[test]
fn the_first_reflection_mirrors_at_the_cylinder() {
    for wo in [vec3a(0.3, 0.5, 0.8).normalize(), vec3a(-0.2, -0.6, 0.3).normalize(), Vec3A::Z] {
        let h = Hair::offset_at(wo);
        let hair = Hair::new(&HairParams { alpha: 0.0, ..params(0.02, 0.02, h, [1e4; 3]) });
        let mirrored = vec3a(-wo.x, -wo.y, wo.z);
        let mut rng = Rng::new(6);
        for _ in 0..200 {
            let s = hair.sample(wo, rng.uniform(), rng.square()).expect("everything is absorbed but R");
            assert!((s.wi - mirrored).length() < 0.15, "{wo}: {}", s.wi);
        }
    }
    // Through the axis of a clear fibre light goes straight on.
    let clear = Hair::new(&HairParams { eta: 1.0, alpha: 0.0, ..params(0.02, 0.02, 0.0, [0.0; 3]) });
    let wo = vec3a(0.3, 0.2, 0.9).normalize();
    let s = clear.sample(wo, 0.3, [0.5, 0.5]).expect("no absorption");
    assert!((s.wi + wo).length() < 0.05, "{}", s.wi);
}

#[test]
fn pigments_darken() {
    let white = absorption_from_color(Spectrum::ONE, 0.3);
    assert_eq!(white.max_element(), 0.0);
    let [r, g, b] = absorption_from_color(Spectrum::rgb(0.6, 0.3, 0.1), 0.3).to_rgb();
    assert!(r < g && g < b);
    // Equation 9 at β = 1: the coefficients' sum 3.375.
    let at_one = absorption_from_color(Spectrum::splat(0.5), 1.0)[0] as f64;
    assert!((at_one - (0.5f64.ln() / 3.375).powi(2)).abs() < 1e-5);
    assert_eq!(absorption_from_melanin(1.0, 0.0).to_rgb(), [0.419, 0.697, 1.37]);
    assert_eq!(absorption_from_melanin(0.0, 1.0).to_rgb(), [0.187, 0.4, 1.05]);
    let albedo = |eumelanin| {
        let p = HairParams { pigment: Pigment::Melanin, eumelanin, ..Default::default() };
        Hair::new(&p).albedo(Vec3A::Z)[1]
    };
    assert!(albedo(0.3) > albedo(1.3) && albedo(1.3) > albedo(8.0));
}

#[test]
fn nonsense_gives_something_finite() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-30, 1e30, 0.01, 0.5, 1.0];
    let mut rng = Rng::new(9);
    let mut own = Rng::new(10);
    let mut pick = move || odd[(rng.bits() % odd.len() as u64) as usize];
    let pigments = [Pigment::Color, Pigment::Melanin, Pigment::Absorption];
    for i in 0..30_000 {
        let hair = Hair::new(&HairParams {
            pigment: pigments[i % 3],
            color: Spectrum([pick(), pick(), pick(), pick()]),
            eumelanin: pick(),
            pheomelanin: pick(),
            absorption: Spectrum([pick(), pick(), pick(), pick()]),
            beta_m: pick(),
            beta_n: pick(),
            alpha: pick(),
            eta: pick(),
            h: pick(),
        });
        let wo = match i % 4 {
            0 => vec3a(pick(), pick(), pick()),
            1 => vec3a(1.0, 0.0, 2e-6),
            2 => vec3a(0.0, 1.0, 2e-6),
            _ => uniform_sphere(own.square()),
        };
        let wi = if i % 5 == 0 { vec3a(pick(), pick(), pick()) } else { uniform_sphere(own.square()) };
        let e = hair.eval_pdf(wo, wi);
        assert!(e.specular.is_finite() && e.pdf.is_finite() && e.pdf >= 0.0, "{hair:?} {wo} {wi} {e:?}");
        assert!(e.specular.0.iter().all(|v| *v >= 0.0));
        assert!(hair.albedo(wo).is_finite() && hair.albedo(wo).max_element() <= 1.001, "{hair:?} {wo}");
        if let Some(s) = hair.sample(wo, pick(), [pick(), pick()]) {
            assert!(s.weight.is_finite() && s.pdf > 0.0 && s.pdf.is_finite() && s.wi.is_finite(), "{s:?}");
        }
    }
}

/// The lobe lies across the horizon, where the contract allows no samples: the law must know how many are missing there.
#[test]
fn samples_that_the_horizon_takes_are_expected() {
    let hair = Hair::new(&HairParams { beta_n: 0.1, ..Default::default() });
    let got = chi2(&hair, wo_at(89.0), 1_000_000, 0);
    assert!(got.p > 1e-3, "{got:?}");
}
