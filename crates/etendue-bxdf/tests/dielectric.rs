//! Boundaries that light passes, before every law.

use etendue_bxdf::{
    Bsdf, GgxDielectric, ThinGgx,
    dielectric::{Dielectric, Sheet},
    laws::{
        Rng,
        grid::{ROUGHNESS, anisotropic_alpha, wo_at},
    },
    model::Transport,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Integrals over the whole sphere by sampling, with the closure's own density mixed with an even one: value, its
/// standard error, and the integral of the density with its error.
fn estimate<B: Bsdf>(bsdf: &B, wo: Vec3A, n: usize, seed: u64) -> [f64; 4] {
    let mut rng = Rng::new(seed);
    let mut sums = [0.0f64; 4];
    for _ in 0..n {
        let wi = if rng.uniform() < 0.5 {
            etendue_bxdf::sampling::uniform_sphere(rng.square())
        } else {
            match bsdf.sample(wo, rng.uniform(), rng.square()) {
                Some(s) if !s.delta => s.wi,
                _ => continue,
            }
        };
        let e = bsdf.eval_pdf(wo, wi);
        let density = 0.5 * e.pdf as f64 + 0.5 / (4.0 * std::f64::consts::PI);
        let v = e.value()[0] as f64 * wi.z.abs() as f64 / density;
        let p = e.pdf as f64 / density;
        for (s, x) in sums.iter_mut().zip([v, v * v, p, p * p]) {
            *s += x;
        }
    }
    let n = n as f64;
    let [v, v2, p, p2] = sums.map(|s| s / n);
    [v, ((v2 - v * v) / n).sqrt(), p, ((p2 - p * p) / n).sqrt()]
}

/// The mean weight and number of drawn samples agree with integrals of value and density; nothing makes light.
#[test]
fn samples_agree_with_integrals() {
    for eta in [1.33f32, 1.5, 2.4, 1.0 / 1.33, 1.0 / 1.5, 1.0 / 2.4, 1.0] {
        for roughness in ROUGHNESS {
            for anisotropy in [0.0, 0.9] {
                for angle in [0.0, 60.0, 89.0] {
                    let at = format!("eta {eta} roughness {roughness} anisotropy {anisotropy} {angle}°");
                    let alpha = anisotropic_alpha(roughness, anisotropy);
                    let face = Dielectric::new(eta);
                    agree(&GgxDielectric::new(alpha, face, Transport::Importance), wo_at(angle), 1.0001, &at);
                    let sheet = Sheet::new(face, Spectrum::splat(0.9));
                    agree(&ThinGgx::new(alpha, sheet), wo_at(angle), 50.0, &format!("thin {at}"));
                }
            }
        }
    }
}

fn agree<B: Bsdf>(bsdf: &B, wo: Vec3A, largest: f64, at: &str) {
    let n = 5000;
    let [value, value_error, density, density_error] = estimate(bsdf, wo, n, 1);
    let mut rng = Rng::new(5);
    let (mut mean, mut square, mut drawn, mut all) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for _ in 0..n {
        let Some(s) = bsdf.sample(wo, rng.uniform(), rng.square()) else { continue };
        let weight = s.weight[0] as f64;
        assert!((0.0..=largest).contains(&weight), "{at}: {s:?}");
        all += weight;
        if !s.delta {
            mean += weight;
            square += weight * weight;
            drawn += 1.0;
        }
    }
    let n = n as f64;
    (mean, square, drawn, all) = (mean / n, square / n, drawn / n, all / n);
    let mean_error = ((square - mean * mean).max(0.0) / n).sqrt();
    let drawn_error = (drawn * (1.0 - drawn) / n).sqrt();
    assert!((value - mean).abs() <= 4.5 * value_error.hypot(mean_error) + 1e-4, "{at}: {value} {mean}");
    assert!(
        (density - drawn).abs() <= 4.5 * density_error.hypot(drawn_error) + 1e-4,
        "{at}: {density} {drawn}"
    );
    assert!(all <= 1.0 + 4.5 * mean_error + 1e-3, "{at}: {all}");
}
