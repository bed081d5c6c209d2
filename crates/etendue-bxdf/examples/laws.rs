//! Runs every law over the whole grid and prints what each cell measured.
//!
//! `cargo run --release -p etendue-bxdf --example laws [SAMPLES]`

use etendue_bxdf::laws::{chi2, furnace, grid, reciprocity, sampling, sidak};

fn main() {
    let samples: usize = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(100_000);
    let subjects: Vec<_> =
        grid::lobes().into_iter().chain(grid::metal_rough()).chain(grid::metal_rough_half_vector()).collect();
    let level = sidak(0.01, subjects.len() * grid::ANGLES.len());
    let mut seed = 0;
    for s in &subjects {
        let asymmetry = reciprocity::reciprocity(&*s.bsdf, 20_000, 1).error;
        for angle in grid::ANGLES {
            seed += 3;
            let wo = grid::wo_at(angle);
            let f = furnace::furnace(&*s.bsdf, wo, samples, seed);
            let c = chi2::chi2(&*s.bsdf, wo, samples, seed + 1);
            let m = sampling::samples(&*s.bsdf, wo, samples.min(50_000), seed + 2);
            println!(
                "{:48} {angle:3}°  albedo {:.5} (sampled {:.5}, {:.1}σ, said {:.3}) variance {:.4} max weight {:.2}  \
                 χ² {:.0}/{} p {:.1e}{}  ∫pdf {:.6} ({:.1}σ)  weight {:.0e} pdf {:.0e} length {:.0e} reciprocity {:.0e}{}",
                s.name,
                f.albedo.max_element(),
                f.sampled.max_element(),
                f.z,
                f.claimed.max_element(),
                f.variance.max_element(),
                m.largest_weight,
                c.statistic,
                c.dof,
                c.p,
                if c.p < level { " FAILS" } else { "" },
                m.pdf_integral,
                m.z,
                m.weight_error,
                m.pdf_error,
                m.length_error,
                asymmetry,
                if m.broken { " BROKEN" } else { "" },
            );
        }
    }
}
