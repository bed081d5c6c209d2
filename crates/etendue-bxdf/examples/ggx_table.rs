//! Writes the table of [`etendue_bxdf::energy`] by quadrature.
//!
//! `cargo run --release -p etendue-bxdf --example ggx_table [FILE]`; default `src/ggx_table.bin` of the crate.

use etendue_bxdf::{
    GgxReflection, Schlick,
    energy::{COLUMNS, ROWS},
    quadrature::{directional_albedo, gauss_legendre},
};
use etendue_color::Spectrum;
use glam::vec3a;

/// (E, W) of the GGX lobe by quadrature; cos 0 stands for its limit.
fn albedo(roughness: f64, cos: f64) -> [f64; 2] {
    let fresnel = Schlick { f0: Spectrum([1.0, 0.0, 0.0, 0.0]), f90: Spectrum::ONE };
    let alpha = (roughness * roughness) as f32;
    let cos = cos.max(2e-6);
    let wo = vec3a((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32);
    let e = directional_albedo(&GgxReflection::new(alpha, alpha, fresnel), wo);
    [e[0] as f64, e[1] as f64 / e[0] as f64]
}

fn main() -> std::io::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/src/ggx_table.bin").into());
    let mut bytes = Vec::new();
    let mut push = |pair: [f64; 2]| {
        for v in pair {
            bytes.extend(((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
        }
    };
    let nodes = gauss_legendre(24);
    for j in 0..ROWS {
        let root = j as f64 / (ROWS - 1) as f64;
        let roughness = root * root;
        for i in 0..COLUMNS {
            let root = i as f64 / (COLUMNS - 1) as f64;
            push(albedo(roughness, root * root));
        }
        // ∫ f(µ) 2µ dµ with µ = x²: the integrand is smooth in x.
        let mut average = [0.0; 2];
        for &(x, w) in &nodes {
            let v = albedo(roughness, x * x);
            for k in 0..2 {
                average[k] += w * 4.0 * x * x * x * v[k];
            }
        }
        push(average);
    }
    std::fs::write(&path, &bytes)?;
    println!("{path}: {} bytes", bytes.len());
    Ok(())
}
