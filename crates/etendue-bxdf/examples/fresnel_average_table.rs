//! Writes the tables of [`etendue_bxdf::fresnel_average`]: Gauss rules by the discretised Stieltjes procedure (Gautschi
//! 2004, "Orthogonal Polynomials", section 2.2.3) over the quadrature of the GGX lobe.
//!
//! `cargo run --release -p etendue-bxdf --example fresnel_average_table [DIRECTORY]`; default `src/fresnel_average` of the
//! crate. Some minutes.

use etendue_bxdf::{
    fresnel_average::{COLUMNS, NODES, ROWS, anisotropic, row_roughness},
    quadrature::{HalfVectorMap, gauss_legendre},
};
use glam::{DVec3, Vec3A, vec3a};
use std::f64::consts::PI;

/// D G2 / (4 cos θo cos θi) · cos θi for two widths, which may exceed 1 here (corners of the table that no lobe reaches).
fn lobe(alpha: [f64; 2], wo: DVec3, wi: DVec3) -> f64 {
    let [ax, ay] = alpha;
    let h = wo + wi;
    let q = (h.x / ax).powi(2) + (h.y / ay).powi(2) + h.z * h.z;
    let r = h.length_squared() / q;
    let t = |w: DVec3| ((ax * w.x).powi(2) + (ay * w.y).powi(2) + w.z * w.z).sqrt();
    r * r / (PI * ax * ay) * 0.5 / (wi.z * t(wo) + wo.z * t(wi)) * wi.z
}

/// Monic orthogonal polynomials pₖ₊₁ = (x − aₖ) pₖ − bₖ pₖ₋₁ at `x`: p₀ .. of as many as there are coefficients, plus one.
fn polynomials(x: f64, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut p = vec![1.0];
    for k in 0..a.len() {
        let before = if k > 0 { b[k] * p[k - 1] } else { 0.0 };
        p.push((x - a[k]) * p[k] - before);
    }
    p
}

/// Nodes, ascending, and normalised weights of the half angle's cosine seen from `wo`; and the lobe's albedo.
fn rule(alpha: [f32; 2], wo: Vec3A) -> ([(f64, f64); NODES], f64) {
    let map = HalfVectorMap::new(wo, alpha);
    let widths = alpha.map(f64::from);
    let nodes = gauss_legendre(6);
    // ∫ g(µ) over the lobe, for two functions at once.
    let integral = |g: &dyn Fn(f64) -> [f64; 2]| -> [f64; 2] {
        let sum = map.integrate_all(&nodes, |wi| {
            if wi.z <= 1e-6 {
                return [0.0; 4];
            }
            let f = lobe(widths, wo.as_dvec3(), wi.as_dvec3());
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
    let rule = core::array::from_fn(|j| {
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
    });
    (rule, mass)
}

/// The direction at √cos θ = `root` and azimuth `phi`.
fn direction(root: f64, phi: f64) -> Vec3A {
    let cos = (root * root).max(2e-6);
    let sin = (1.0 - cos * cos).sqrt();
    vec3a((sin * phi.cos()) as f32, (sin * phi.sin()) as f32, cos as f32)
}

/// Nodes and all weights but the last.
fn numbers(rule: &[(f64, f64); NODES]) -> Vec<f64> {
    rule.iter().map(|r| r.0).chain(rule[..NODES - 1].iter().map(|r| r.1)).collect()
}

fn isotropic() -> Vec<f64> {
    let mut out = Vec::new();
    for j in 0..ROWS {
        let alpha = row_roughness(j).powi(2);
        for i in 0..COLUMNS {
            let wo = direction(i as f64 / (COLUMNS - 1) as f64, 0.0);
            out.extend(numbers(&rule([alpha; 2], wo).0));
        }
    }
    out
}

/// One roughness of the anisotropic table.
fn anisotropic_row(j: usize) -> Vec<f64> {
    use anisotropic::{ASPECTS, COSINES, WIDTHS, aspect, roughness};
    let mut out = Vec::new();
    for k in 0..ASPECTS {
        // αx² + αy² = 2 r⁴; no lobe is narrower than 1e-4.
        let b = aspect(k) as f64;
        let max = roughness(j).powi(2) as f64 * (2.0 / (1.0 + b * b)).sqrt();
        let min = (b * max).max(1e-4);
        for u in 0..WIDTHS {
            let u = u as f64 / (WIDTHS - 1) as f64;
            let across = min + (max - min) * u;
            let cos2 = if max > 1.001 * min {
                ((across * across - min * min) / (max * max - min * min)).clamp(0.0, 1.0)
            } else {
                1.0
            };
            let phi = cos2.sqrt().acos();
            for i in 0..COSINES {
                let wo = direction(i as f64 / (COSINES - 1) as f64, phi);
                let (rule, mass) = rule([max as f32, min as f32], wo);
                out.extend(numbers(&rule));
                out.push((1.0 - mass).max(0.0).sqrt());
            }
        }
    }
    out
}

fn write(path: &str, numbers: &[f64]) -> std::io::Result<()> {
    let bytes: Vec<u8> =
        numbers.iter().flat_map(|v| ((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes()).collect();
    std::fs::write(path, &bytes)?;
    println!("{path}: {} bytes", bytes.len());
    Ok(())
}

fn main() -> std::io::Result<()> {
    let directory = std::env::args()
        .nth(1)
        .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/src/fresnel_average").into());
    write(&format!("{directory}/isotropic.bin"), &isotropic())?;
    let rows: Vec<Vec<f64>> = std::thread::scope(|scope| {
        let work: Vec<_> = (0..anisotropic::ROWS).map(|j| scope.spawn(move || anisotropic_row(j))).collect();
        work.into_iter().map(|w| w.join().expect("a row is computed without a panic")).collect()
    });
    write(&format!("{directory}/anisotropic.bin"), &rows.concat())
}
