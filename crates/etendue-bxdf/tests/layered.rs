//! The random walk between two interfaces against what is known in closed form, and against itself.

use etendue_bxdf::{
    Bsdf, GgxReflection, Lambert, Schlick,
    dielectric::{Dielectric, GgxDielectric},
    fresnel,
    laws::{Rng, grid::wo_at},
    layered::{Layered, Slab},
    model::Incidence,
    sampling::cosine_hemisphere,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

fn walks(quick: usize) -> usize {
    if std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1") { 50 * quick } else { quick }
}

fn varnish(ior: f32, alpha: f32) -> impl Fn(&Incidence) -> GgxDielectric<Dielectric> {
    move |at| {
        let eta = if at.front { ior } else { 1.0 / ior };
        GgxDielectric::new([alpha; 2], Dielectric::new(eta), at.transport)
    }
}

/// ∫ of `f(µ)` · 2µ dµ.
fn mean(f: impl Fn(f32) -> f32) -> f32 {
    let n = 20_000;
    (0..n)
        .map(|i| {
            let mu = (i as f32 + 0.5) / n as f32;
            (f(mu) * 2.0 * mu) as f64 / n as f64
        })
        .sum::<f64>() as f32
}

/// Smooth varnish over a Lambertian base: F + T ρ Ti / (1 − ρ (1 − Ti)), Ti the mean transmittance from inside (Saunderson 1942).
#[test]
fn varnish_over_chalk_is_saundersons() {
    let mut rng = Rng::new(1);
    let ior = 1.5;
    let inner = mean(|mu| 1.0 - fresnel::dielectric(mu, 1.0 / ior));
    let color = Spectrum([1.0, 0.8, 0.5, 0.1]);
    let stack = Layered::new(varnish(ior, 0.0), Lambert { color }, Slab::EMPTY);
    for angle in [0.0, 45.0, 80.0] {
        let wo = wo_at(angle);
        let f = fresnel::dielectric(wo.z, ior);
        let (got, error) = stack.albedo(wo, walks(40_000), &mut rng);
        for lane in 0..4 {
            let rho = color[lane];
            let want = f + (1.0 - f) * rho * inner / (1.0 - rho * (1.0 - inner));
            assert!(
                (got[lane] - want).abs() < 4.5 * error[lane] + 1e-4,
                "{angle}° {lane}: {} ± {}, {want}",
                got[lane],
                error[lane]
            );
        }
    }
}

/// An absorbing slab without interfaces over chalk: e^{−τ/µ} ρ 2 E₃(τ).
#[test]
fn absorption_is_bouguers() {
    let mut rng = Rng::new(2);
    let tau = 0.4;
    let stack = Layered::new(
        varnish(1.0, 0.0),
        Lambert { color: Spectrum::splat(0.8) },
        Slab::new(tau, Spectrum::ZERO, 0.0),
    );
    let out = mean(|mu| (-tau / mu).exp());
    for angle in [0.0, 60.0] {
        let wo = wo_at(angle);
        let want = (-tau / wo.z).exp() * 0.8 * out;
        let (got, error) = stack.albedo(wo, walks(40_000), &mut rng);
        assert!((got[0] - want).abs() < 4.5 * error[0] + 1e-4, "{angle}°: {got:?} ± {error:?}, {want}");
    }
}

/// Nothing that absorbs: everything comes back, whatever happens in between.
#[test]
fn a_lossless_stack_returns_the_sky() {
    let mut rng = Rng::new(3);
    let slab = Slab::new(1.5, Spectrum::ONE, 0.6);
    let stack = Layered::new(varnish(1.5, 0.0), Lambert { color: Spectrum::ONE }, slab);
    for angle in [0.0, 70.0] {
        let (got, error) = stack.albedo(wo_at(angle), walks(20_000), &mut rng);
        assert!((got[0] - 1.0).abs() < 4.5 * error[0] + 1e-3, "{angle}°: {got:?} ± {error:?}");
    }
}

type Stack<B> = Layered<GgxDielectric<Dielectric>, B>;

/// The mean of the value over directions is the mean weight of walks (less what is perfectly specular), and the value is reciprocal.
fn value_and_walk_agree<B: Bsdf + Copy>(name: &str, stack: &Stack<B>, seed: u64) {
    let mut rng = Rng::new(seed);
    let wo = wo_at(50.0);
    let n = walks(60_000);
    let (mut first, mut second) = (0.0f64, 0.0f64);
    for _ in 0..n {
        let wi = cosine_hemisphere(rng.square());
        let v = (stack.eval(wo, wi, &mut rng)[0] * core::f32::consts::PI) as f64;
        first += v;
        second += v * v;
    }
    let n = n as f64;
    let (value, error) = (first / n, ((second / n - (first / n).powi(2)) / n).sqrt());
    let (walk, walk_error) = stack.albedo(wo, n as usize, &mut rng);
    let both = error.hypot(walk_error[0] as f64);
    println!("{name}: by value {value:.4} ± {error:.4}, by walks {:.4} ± {:.4}", walk[0], walk_error[0]);
    assert!((value - walk[0] as f64).abs() < 4.5 * both, "{name}");
    // Reciprocity.
    let wi = vec3a(-0.5, 0.1, 0.7).normalize();
    let estimate = |a: Vec3A, b: Vec3A, rng: &mut Rng| {
        let (mut first, mut second) = (0.0f64, 0.0f64);
        for _ in 0..n as usize {
            let v = stack.eval(a, b, rng)[0] as f64;
            first += v;
            second += v * v;
        }
        (first / n, ((second / n - (first / n).powi(2)) / n).sqrt())
    };
    let (a, b) = (estimate(wo, wi, &mut rng), estimate(wi, wo, &mut rng));
    println!("{name}: {a:.4?} and back {b:.4?}");
    assert!((a.0 - b.0).abs() < 4.5 * a.1.hypot(b.1) + 1e-6, "{name}: {a:?} {b:?}");
}

#[test]
fn value_and_walks_agree() {
    let chalk = Lambert { color: Spectrum::splat(0.8) };
    let metal = |alpha| {
        let gold = Schlick { f0: Spectrum::splat(0.9), f90: Spectrum::ONE };
        GgxReflection::new(alpha, alpha, gold)
    };
    let fog = Slab::new(0.7, Spectrum::splat(0.9), 0.4);
    value_and_walk_agree("rough over chalk", &Layered::new(varnish(1.5, 0.3), chalk, Slab::EMPTY), 10);
    value_and_walk_agree("rough over metal", &Layered::new(varnish(1.5, 0.3), metal(0.2), Slab::EMPTY), 11);
    value_and_walk_agree("rough over mirror", &Layered::new(varnish(1.5, 0.4), metal(0.0), Slab::EMPTY), 12);
    value_and_walk_agree("rough, fog, chalk", &Layered::new(varnish(1.5, 0.3), chalk, fog), 13);
    value_and_walk_agree("rough, fog, metal", &Layered::new(varnish(1.5, 0.3), metal(0.2), fog), 14);
}

/// A smooth top over a rough base has its value too: only strategies that know the top's direction find it.
#[test]
fn a_smooth_top_shows_a_rough_base() {
    let mut rng = Rng::new(20);
    let (ior, alpha) = (1.5, 0.3);
    let base =
        GgxReflection::new(alpha, alpha, Schlick { f0: Spectrum::splat(0.02), f90: Spectrum::splat(0.02) });
    let stack = Layered::new(varnish(ior, 0.0), base, Slab::EMPTY);
    let (wo, wi) = (wo_at(30.0), wo_at(35.0) * vec3a(-1.0, -1.0, 1.0));
    // A dark base: the first bounce is all but 1 % of the light. T T f(w'o, w'i) / η².
    let bend = |w: Vec3A| {
        let s = w / ior;
        vec3a(s.x, s.y, (1.0 - s.x * s.x - s.y * s.y).sqrt())
    };
    let t = |w: Vec3A| 1.0 - fresnel::dielectric(w.z, ior);
    let want = t(wo) * t(wi) * base.eval(bend(wo), bend(wi))[0] / (ior * ior);
    let n = walks(20_000);
    let got: f64 = (0..n).map(|_| stack.eval(wo, wi, &mut rng)[0] as f64).sum::<f64>() / n as f64;
    assert!((got / want as f64 - 1.0).abs() < 0.02, "{got} {want}");
}
