//! Fits the density that the sheen lobe is sampled by, and writes its table (`src/sheen/charlie_sampling.bin`).
//!
//! `cargo run --release -p etendue-bxdf --example sheen_sampling [FILE]`. For each angle and roughness the parameters of the
//! transformed cosine are found that give sample weights the least variance: the minimum of ∫ (f cos θi)² / pdf dωi, by the
//! simplex method of Nelder, Mead 1965. To be run after `sheen_table`.

use etendue_bxdf::{
    Bsdf, Sheen,
    sheen::sampler::{COLUMNS, Lobe, ROWS, column_cos, pack, row_roughness},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// A direction, f cos θi, and its share of solid angle.
struct Node {
    wi: Vec3A,
    value: f64,
    weight: f64,
}

/// Nodes over the half of the hemisphere on one side of the plane of incidence, dense near the horizon.
fn nodes(sheen: &Sheen, wo: Vec3A) -> Vec<Node> {
    const Z: usize = 56;
    const PHI: usize = 40;
    let mut out = Vec::new();
    for i in 0..Z {
        let t = (i as f64 + 0.5) / Z as f64;
        let z = t * t * t;
        for j in 0..PHI {
            let phi = (j as f64 + 0.5) / PHI as f64 * std::f64::consts::PI;
            let s = (1.0 - z * z).sqrt();
            let wi = vec3a((s * phi.cos()) as f32, (s * phi.sin()) as f32, z as f32);
            let weight = 3.0 * t * t / Z as f64 * (2.0 * std::f64::consts::PI / PHI as f64);
            out.push(Node { wi, value: (sheen.eval(wo, wi)[0] * wi.z) as f64, weight });
        }
    }
    out
}

/// Second moment of the weight over its squared mean: 1 is perfect.
fn cost(nodes: &[Node], p: [f64; 3]) -> f64 {
    let lobe = lobe(p);
    let (mut first, mut second) = (0.0, 0.0);
    for n in nodes {
        first += n.weight * n.value;
        second += n.weight * n.value * n.value / lobe.pdf(n.wi) as f64;
    }
    second / (first * first)
}

/// The parameters are ln a, b, ln c.
fn lobe(p: [f64; 3]) -> Lobe {
    Lobe { a: p[0].exp() as f32, b: p[1] as f32, c: p[2].exp() as f32, x: [1.0, 0.0] }.clamped()
}

/// The minimum of `f` near `start`.
fn nelder_mead(start: [f64; 3], f: impl Fn([f64; 3]) -> f64) -> ([f64; 3], f64) {
    let add =
        |a: [f64; 3], b: [f64; 3], t: f64| -> [f64; 3] { core::array::from_fn(|i| a[i] + t * (b[i] - a[i])) };
    let mut simplex: Vec<([f64; 3], f64)> = (0..4)
        .map(|k| {
            let mut p = start;
            if k > 0 {
                p[k - 1] += 0.3;
            }
            (p, f(p))
        })
        .collect();
    for _ in 0..120 {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        if simplex[3].1 - simplex[0].1 < 1e-7 * simplex[0].1 {
            break;
        }
        let centre: [f64; 3] = core::array::from_fn(|i| (0..3).map(|k| simplex[k].0[i]).sum::<f64>() / 3.0);
        let at = |t: f64| {
            let p = add(centre, simplex[3].0, t);
            (p, f(p))
        };
        let reflected = at(-1.0);
        if reflected.1 < simplex[0].1 {
            let further = at(-2.0);
            simplex[3] = if further.1 < reflected.1 { further } else { reflected };
        } else if reflected.1 < simplex[2].1 {
            simplex[3] = reflected;
        } else {
            let nearer = if reflected.1 < simplex[3].1 { at(-0.5) } else { at(0.5) };
            if nearer.1 < simplex[3].1.min(reflected.1) {
                simplex[3] = nearer;
            } else {
                for k in 1..4 {
                    let p = add(simplex[0].0, simplex[k].0, 0.5);
                    simplex[k] = (p, f(p));
                }
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0]
}

fn main() -> std::io::Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/src/sheen/charlie_sampling.bin").into());
    let mut table = vec![[0u8; 6]; ROWS * COLUMNS];
    // From the smoothest lobe to the sharpest, each fit starting from its neighbours'.
    let mut last = vec![[0.0f64; 3]; COLUMNS];
    for j in (0..ROWS).rev() {
        let sheen = Sheen::new(Spectrum::ONE, row_roughness(j));
        let mut worst = 0.0f64;
        let mut here = [0.0, 0.0, 0.0];
        for i in (0..COLUMNS).rev() {
            let mu = column_cos(i).max(1e-4);
            let nodes = nodes(&sheen, vec3a((1.0 - mu * mu).sqrt(), 0.0, mu));
            let starts = [here, last[i], [0.0, 0.0, 0.0], [-1.0, 0.0, -1.0]];
            let (p, c) = starts
                .into_iter()
                .map(|s| nelder_mead(s, |p| cost(&nodes, p)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((here, f64::INFINITY));
            worst = worst.max(c - 1.0);
            here = p;
            last[i] = p;
            table[j * COLUMNS + i] = pack(&lobe(p));
        }
        println!("roughness {:.4}: largest relative variance of a weight {worst:.3}", row_roughness(j));
    }
    let bytes = table.concat();
    std::fs::write(&path, &bytes)?;
    println!("{path}: {} bytes", bytes.len());
    Ok(())
}
