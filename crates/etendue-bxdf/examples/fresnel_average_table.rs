//! Writes the table of [`etendue_bxdf::fresnel_average`]: Gauss rules by the discretised Stieltjes procedure (Gautschi
//! 2004, "Orthogonal Polynomials", section 2.2.3) over the quadrature of the GGX lobe.
//!
//! `cargo run --release -p etendue-bxdf --example fresnel_average_table [FILE]`; default `src/fresnel_average.bin` of
//! the crate.

use etendue_bxdf::{
    Ggx,
    fresnel_average::{COLUMNS, NODES, ROWS, row_roughness},
    quadrature::{HalfVectorMap, gauss_legendre},
};
use glam::vec3a;

/// Monic orthogonal polynomials pₖ₊₁ = (x − aₖ) pₖ − bₖ pₖ₋₁ at `x`: p₀ .. of as many as there are coefficients, plus one.
fn polynomials(x: f64, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut p = vec![1.0];
    for k in 0..a.len() {
        let before = if k > 0 { b[k] * p[k - 1] } else { 0.0 };
        p.push((x - a[k]) * p[k] - before);
    }
    p
}

/// Nodes, ascending, and normalised weights of the half angle's cosine seen from `cos`.
fn rule(roughness: f32, cos: f64) -> [(f64, f64); NODES] {
    let ggx = Ggx::new(roughness * roughness, roughness * roughness);
    let cos = cos.max(2e-6);
    let wo = vec3a((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32);
    let map = HalfVectorMap::new(wo, ggx.alpha());
    let nodes = gauss_legendre(6);
    // ∫ g(µ) over the lobe, for two functions at once.
    let integral = |g: &dyn Fn(f64) -> [f64; 2]| -> [f64; 2] {
        let sum = map.integrate_all(&nodes, |wi| {
            if wi.z <= 1e-6 {
                return [0.0; 4];
            }
            let f = (ggx.pair(wo, wi).value * wi.z) as f64;
            let mu = 0.5 * (wo.as_dvec3() + wi.as_dvec3()).length();
            let [p, q] = g(mu);
            [(f * p) as f32, (f * q) as f32, 0.0, 0.0]
        });
        [sum[0], sum[1]]
    };
    // Centred and scaled, so that the polynomials stay of order one for the narrowest lobe.
    let [mass, first] = integral(&|mu| [1.0, mu]);
    let mean = first / mass;
    let [second, _] = integral(&|mu| [(mu - mean).powi(2), 0.0]);
    let scale = (second / mass).sqrt().max(1e-7);
    let (mut a, mut b) = (Vec::new(), vec![0.0]);
    let mut norm_before = 1.0;
    for k in 0..NODES {
        let [norm, first] = integral(&|mu| {
            let x = (mu - mean) / scale;
            let p = polynomials(x, &a, &b)[k];
            [p * p, x * p * p]
        });
        if k > 0 {
            b.push(norm / norm_before);
        }
        a.push(first / norm);
        norm_before = norm;
    }
    // The zeros of each polynomial lie between those of the one before.
    let bound = 1.0
        + (0..NODES)
            .map(|k| a[k].abs() + b[k].sqrt() + b.get(k + 1).map_or(0.0, |b| b.sqrt()))
            .fold(0.0, f64::max);
    let mut zeros: Vec<f64> = Vec::new();
    for degree in 1..=NODES {
        let mut edges = vec![-bound];
        edges.extend(&zeros);
        edges.push(bound);
        zeros = edges
            .windows(2)
            .map(|w| {
                let value = |x: f64| polynomials(x, &a[..degree], &b)[degree];
                let (mut low, mut high) = (w[0], w[1]);
                let rising = value(high) > value(low);
                for _ in 0..80 {
                    let mid = 0.5 * (low + high);
                    if (value(mid) > 0.0) == rising { high = mid } else { low = mid }
                }
                0.5 * (low + high)
            })
            .collect();
    }
    core::array::from_fn(|j| {
        // Christoffel's number: 1 / Σ pₖ² / ‖pₖ‖², the norms relative to the mass.
        let p = polynomials(zeros[j], &a, &b);
        let (mut norm, mut sum) = (1.0, 0.0);
        for k in 0..NODES {
            if k > 0 {
                norm *= b[k];
            }
            sum += p[k] * p[k] / norm;
        }
        (mean + scale * zeros[j], 1.0 / sum)
    })
}

fn main() -> std::io::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/src/fresnel_average.bin").into());
    let mut bytes = Vec::new();
    for j in 0..ROWS {
        for i in 0..COLUMNS {
            let root = i as f64 / (COLUMNS - 1) as f64;
            let rule = rule(row_roughness(j), root * root);
            let weights = rule[..NODES - 1].iter().map(|r| r.1);
            for v in rule.iter().map(|r| r.0).chain(weights) {
                bytes.extend(((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
            }
        }
    }
    std::fs::write(&path, &bytes)?;
    println!("{path}: {} bytes", bytes.len());
    Ok(())
}
