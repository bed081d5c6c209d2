//! Writes the table of [`etendue_bxdf::sheen::albedo`] by quadrature.
//!
//! `cargo run --release -p etendue-bxdf --example sheen_table [FILE]`; default `src/sheen/charlie_table.bin` of the crate.

use etendue_bxdf::{
    Bsdf, BsdfSample, Eval, Sheen,
    quadrature::{directional_albedo, gauss_legendre},
    sheen::albedo::{COLUMNS, LARGEST, ROWS, row_roughness},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// The conserving lobe at a row's roughness, from literal albedos just computed rather than from the table that is to be
/// written.
struct Conserving {
    literal: Sheen,
    /// Over ⁴√cos θ.
    albedo: Vec<f64>,
}

impl Conserving {
    fn excess(&self, cos: f32) -> f32 {
        let x = (cos as f64).clamp(0.0, 1.0).sqrt().sqrt() * (COLUMNS - 1) as f64;
        let i = (x as usize).min(COLUMNS - 2);
        let (p, q) = (self.albedo[i], self.albedo[i + 1]);
        (p + (q - p) * (x - i as f64)).max(1.0) as f32
    }
}

impl Bsdf for Conserving {
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        let mut e = self.literal.eval_pdf(wo, wi);
        e.diffuse *= 1.0 / self.excess(wo.z).max(self.excess(wi.z));
        e
    }
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        self.literal.sample(wo, uc, u)
    }
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        self.literal.albedo(wo)
    }
}

/// Albedo by quadrature; cos 0 stands for its limit.
fn albedo(bsdf: &impl Bsdf, cos: f64) -> f64 {
    let cos = cos.max(2e-6);
    directional_albedo(bsdf, vec3a((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32))[0] as f64
}

/// The columns and the average: ∫ f(µ) 2µ dµ with µ = x², whose integrand is smooth in x.
fn row(bsdf: &impl Bsdf) -> Vec<f64> {
    let root = |i: usize| i as f64 / (COLUMNS - 1) as f64;
    let mut out: Vec<f64> = (0..COLUMNS).map(|i| albedo(bsdf, root(i).powi(4))).collect();
    out.push(gauss_legendre(24).iter().map(|&(x, w)| w * 4.0 * x * x * x * albedo(bsdf, x * x)).sum());
    out
}

fn main() -> std::io::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/src/sheen/charlie_table.bin").into());
    let mut bytes = Vec::new();
    for j in 0..ROWS {
        let roughness = row_roughness(j);
        let literal = Sheen::new(Spectrum::ONE, roughness as f32).literal();
        let literal_row = row(&literal);
        let largest = literal_row.iter().copied().fold(0.0, f64::max);
        let conserving = row(&Conserving { literal, albedo: literal_row.clone() });
        println!("roughness {roughness:.4}: largest literal albedo {largest:.4}");
        for (e, e0) in conserving.into_iter().zip(literal_row) {
            for v in [e, e0 / LARGEST as f64] {
                bytes.extend(((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
            }
        }
    }
    std::fs::write(&path, &bytes)?;
    println!("{path}: {} bytes", bytes.len());
    Ok(())
}
