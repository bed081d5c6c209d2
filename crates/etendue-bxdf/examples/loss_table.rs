//! Writes the tables of [`etendue_bxdf::multiscatter::loss`] by quadrature in `f64`.
//!
//! `cargo run --release -p etendue-bxdf --example loss_table [DIRECTORY]`; default `src/multiscatter` of the crate.
//!
//! With the slopes of the microfacets as (α s cos ψ, α s sin ψ) and t = s² / (1 + s²), GGX is even in t and ψ:
//!
//! ```text
//! E(μ) = 1 / 2π ∫dψ ∫₀¹ dt  max(0, wo·h) / μ · G(wo, wi),    h = (α s cos ψ, α s sin ψ, 1)
//! ```

use etendue_bxdf::{
    laws::gamma::ln_gamma,
    multiscatter::loss::{
        AVERAGE_SCALE, AVERAGES, BOUNDARY_AVERAGES, BOUNDARY_COLUMNS, BOUNDARY_ROWS, COLUMNS, INDICES, ROWS,
        boundary_cosine, cosine, node_index, row_roughness,
    },
    quadrature::gauss_legendre,
};
use std::{f64::consts::PI, path::PathBuf};

/// t(w) of GGX: the length of a direction stretched by α.
fn stretched(alpha: f64, z: f64) -> f64 {
    (alpha * alpha * (1.0 - z * z).max(0.0) + z * z).sqrt()
}

/// 1 − E of mirrors.
fn mirror_loss(mu: f64, alpha: f64, nodes: &[(f64, f64)]) -> f64 {
    let x = (1.0 - mu * mu).max(0.0).sqrt();
    let to = stretched(alpha, mu);
    let mut sum = 0.0;
    // ψ over half a turn, dense where the horizon's place changes: about ψ = π/2, by tan.
    let panels = 8;
    for panel in 0..panels {
        for &(u, w) in nodes {
            let psi = PI * (panel as f64 + u) / panels as f64;
            let w_psi = w / panels as f64;
            let a = alpha * x * psi.cos();
            // wi.z > 0 for s below the root of −μ α² s² + 2 a s + μ = 0.
            let root = (a * a + mu * mu * alpha * alpha).sqrt();
            let end = if a > 0.0 { (a + root) / (mu * alpha * alpha) } else { mu / (root - a) };
            let t_end = end * end / (1.0 + end * end);
            let mut inner = 0.0;
            for half in 0..4 {
                for &(v, wv) in nodes {
                    // Squared towards both ends of 0..t_end, where s and wi.z have roots.
                    let v = (half as f64 + v) / 4.0;
                    let t = t_end * v * v * (3.0 - 2.0 * v);
                    let dt = t_end * 6.0 * v * (1.0 - v) * wv / 4.0;
                    let s = (t / (1.0 - t)).sqrt();
                    let dot = a * s + mu;
                    let z = 2.0 * dot / (1.0 + alpha * alpha * s * s) - mu;
                    if dot > 0.0 && z > 0.0 {
                        let g = 2.0 * mu * z / (z * to + mu * stretched(alpha, z));
                        inner += dt * g * dot / mu;
                    }
                }
            }
            sum += w_psi * inner;
        }
    }
    1.0 - sum
}

/// √v of a cosine.
fn root_v(mu: f64, alpha: f64) -> f64 {
    (mu * (1.0 + alpha) / (mu + alpha)).sqrt()
}

/// Euler's beta function.
fn beta(x: f64, y: f64) -> f64 {
    (ln_gamma(x) + ln_gamma(y) - ln_gamma(x + y)).exp()
}

/// Fresnel's reflectance.
fn fresnel(cos: f64, eta: f64) -> f64 {
    let cos2_t = 1.0 - (1.0 - cos * cos) / (eta * eta);
    if cos2_t <= 0.0 {
        return 1.0;
    }
    let t = cos2_t.sqrt();
    let (a, b) = ((eta * cos - t) / (eta * cos + t), (cos - eta * t) / (cos + eta * t));
    0.5 * (a * a + b * b)
}

/// 1 − (reflected + refracted) of a boundary. The facets that are seen are even over the cap of stretched directions
/// (Dupuy, Benyoub 2023): the integral is over its height and azimuth.
fn boundary_loss(mu: f64, alpha: f64, eta: f64, nodes: &[(f64, f64)]) -> f64 {
    let x = (1.0 - mu * mu).max(0.0).sqrt();
    let to = stretched(alpha, mu);
    let (ix, iz) = (alpha * x / to, mu / to);
    let lambda = |z: f64| 0.5 * (stretched(alpha, z) / z - 1.0);
    let (mut sum, panels) = (0.0, 3);
    for panel in 0..2 * panels {
        for &(u, w) in nodes {
            let psi = PI * (panel as f64 + u) / (2 * panels) as f64;
            let mut inner = 0.0;
            for part in 0..panels {
                for &(v, wv) in nodes {
                    // Denser towards the pole.
                    let v = (part as f64 + v) / panels as f64;
                    let (drop, weight) = (v * v * (1.0 + iz), 2.0 * v * wv / panels as f64);
                    let sin = (drop * (2.0 - drop)).max(0.0).sqrt();
                    let (mx, my, mz) =
                        (alpha * (sin * psi.cos() + ix), alpha * sin * psi.sin(), 1.0 - drop + iz);
                    let len = (mx * mx + my * my + mz * mz).sqrt();
                    let cos = (mx * x + mz * mu) / len;
                    if cos <= 0.0 {
                        continue;
                    }
                    let m_z = mz / len;
                    let f = fresnel(cos, eta);
                    let z = 2.0 * cos * m_z - mu;
                    if z > 0.0 {
                        // G2 / G1(wo).
                        let g = z * (mu + to) / (z * to + mu * stretched(alpha, z));
                        inner += weight * f * g;
                    }
                    if f < 1.0 {
                        let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
                        let z = -(m_z * (cos / eta - cos_t) - mu / eta);
                        if z > 0.0 {
                            let g = beta(1.0 + lambda(mu), 1.0 + lambda(z)) * (1.0 + lambda(mu));
                            inner += weight * (1.0 - f) * g;
                        }
                    }
                }
            }
            sum += inner * w / (2 * panels) as f64;
        }
    }
    1.0 - sum
}

/// A fraction as 16 bits.
fn push(bytes: &mut Vec<u8>, v: f64) {
    bytes.extend(((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
}

/// 2 ∫ L μ dμ of interpolated roots; `place` gives the part of the way along the columns at which μ lies.
fn average(roots: &[f64], alpha: f64, place: impl Fn(f64, f64) -> f64, nodes: &[(f64, f64)]) -> f64 {
    // Over ln μ: at small α all columns but the last lie at small μ.
    let cells = (roots.len() - 1) as f64;
    let (low, panels) = ((alpha * 1e-4).ln(), 200);
    let mut sum = 0.0;
    for i in 0..panels {
        for &(t, w) in nodes {
            let mu = (low * (1.0 - (i as f64 + t) / panels as f64)).exp();
            let x = (place(mu, alpha) * cells).min(cells);
            let j = (x as usize).min(roots.len() - 2);
            let root = roots[j] + (roots[j + 1] - roots[j]) * (x - j as f64);
            sum += 2.0 * mu * mu * root * root * -low * w / panels as f64;
        }
    }
    sum
}

/// The table of one kind of loss: rows of roots, then the averages of what lies between them too.
fn table(
    rows: usize,
    columns: usize,
    averages: usize,
    column: impl Fn(usize, f64) -> f64,
    place: impl Fn(f64, f64) -> f64,
    loss: impl Fn(f64, f64) -> f64,
) -> Vec<u8> {
    let nodes = gauss_legendre(24);
    let mut bytes = Vec::new();
    let mut table = Vec::new();
    for j in 0..rows {
        let alpha = row_roughness(j, rows).powi(2);
        let row: Vec<f64> = (0..columns)
            .map(|i| {
                let root = loss(column(i, alpha).max(1e-9), alpha).max(0.0).sqrt();
                push(&mut bytes, root);
                // As the table will have it.
                (root.min(1.0) * 65535.0).round() / 65535.0
            })
            .collect();
        table.push(row);
    }
    for k in 0..averages {
        let x = k as f64 / (averages - 1) as f64 * (rows - 1) as f64;
        let j = (x as usize).min(rows - 2);
        let roots: Vec<f64> =
            table[j].iter().zip(&table[j + 1]).map(|(a, b)| a + (b - a) * (x - j as f64)).collect();
        let alpha = row_roughness(k, averages).powi(2);
        let average = average(&roots, alpha, &place, &nodes) / (alpha * alpha * AVERAGE_SCALE as f64);
        assert!(average < 1.0, "the scale of averages is too small: {average}");
        push(&mut bytes, average);
    }
    bytes
}

fn main() -> std::io::Result<()> {
    let directory: PathBuf = std::env::args()
        .nth(1)
        .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/src/multiscatter").into())
        .into();
    let nodes = gauss_legendre(24);
    let mirror = table(ROWS, COLUMNS, AVERAGES, cosine, root_v, |mu, alpha| mirror_loss(mu, alpha, &nodes));
    let path = directory.join("mirror_loss.bin");
    std::fs::write(&path, &mirror)?;
    println!("{}: {} bytes", path.display(), mirror.len());

    let coarse = gauss_legendre(20);
    let mut boundary = Vec::new();
    for leaving in [false, true] {
        for node in 0..INDICES {
            let index = node_index(node);
            let eta = if leaving { 1.0 / index } else { index };
            boundary.extend(table(
                BOUNDARY_ROWS,
                BOUNDARY_COLUMNS,
                BOUNDARY_AVERAGES,
                boundary_cosine,
                |mu, alpha| 0.5 * (root_v(mu, alpha) + mu),
                |mu, alpha| {
                    // A little on the dark side: between nodes the interpolation is up to 2e-3 off, and must not
                    // make light.
                    let loss = boundary_loss(mu, alpha, eta, &coarse).max(0.0);
                    loss - 8e-4 * loss / (loss + 0.01)
                },
            ));
        }
    }
    let path = directory.join("boundary_loss.bin");
    std::fs::write(&path, &boundary)?;
    println!("{}: {} bytes", path.display(), boundary.len());
    Ok(())
}
