//! Kernels about a normal that are no cosine, against spherical harmonics.
//!
//! A kernel k(n·ω) over the upper hemisphere damps band l of a sky by
//!
//! ```text
//! K_l = 2π ∫₀¹ k(μ) P_l(μ) dμ            ∫ L(ω) k(n·ω) dω = Σ K_l c_lm Y_lm(n)
//! ```
//!
//! (Ramamoorthi, Hanrahan 2001, eq. 9 and 13; for the cosine K is [`etendue_ibl::sh::COSINE`]). Two such kernels are here, by
//! roughness: the cosine times the mean Schlick weight of the facets seen from ω, which is what a specular layer takes away from
//! diffuse light, and the cosine times what single scattering loses, which is the lobe that gives it back.

use etendue_bxdf::{energy::Row, multiscatter::loss::MirrorLoss, quadrature::gauss_legendre};
use std::f64::consts::TAU;

/// Rows of the table, even steps of roughness.
const ROWS: usize = 65;

/// K_0, K_1, K_2 of a kernel.
pub type Bands = [f32; 3];

/// Bands of both kernels by roughness.
#[derive(Clone, Debug, PartialEq)]
pub struct ZonalTable(Vec<[Bands; 2]>);

impl Default for ZonalTable {
    fn default() -> Self {
        Self::new()
    }
}

impl ZonalTable {
    /// Integrates both; takes about a millisecond.
    pub fn new() -> Self {
        let nodes = gauss_legendre(48);
        let row = |i: usize| {
            let roughness = i as f32 / (ROWS - 1) as f32;
            let (row, loss) = (Row::new(roughness), MirrorLoss::new(roughness * roughness));
            let mut sum = [[0.0f64; 3]; 2];
            for &(x, weight) in &nodes {
                // μ = x²: nodes crowd towards the horizon, where both kernels live.
                let mu = x * x;
                let measure = TAU * weight * 2.0 * x * mu;
                let values = [row.directional(mu as f32).w, loss.directional(mu as f32)];
                for (sum, value) in sum.iter_mut().zip(values) {
                    let legendre = [1.0, mu, 1.5 * mu * mu - 0.5];
                    (0..3).for_each(|l| sum[l] += measure * f64::from(value) * legendre[l]);
                }
            }
            sum.map(|bands| bands.map(|v| v as f32))
        };
        Self((0..ROWS).map(row).collect())
    }

    #[inline]
    fn at(&self, roughness: f32, kernel: usize) -> Bands {
        let x = roughness.max(0.0).min(1.0) * (ROWS - 1) as f32;
        let i = (x as usize).min(ROWS - 2);
        let t = x - i as f32;
        let (a, b) = (self.0[i][kernel], self.0[i + 1][kernel]);
        std::array::from_fn(|l| a[l] + (b[l] - a[l]) * t)
    }

    /// Bands of cos · W, W the mean Schlick weight of [`etendue_bxdf::energy`].
    #[inline]
    pub fn schlick(&self, roughness: f32) -> Bands {
        self.at(roughness, 0)
    }

    /// Bands of cos · (1 − E), E the albedo of single scattering for F = 1.
    #[inline]
    pub fn loss(&self, roughness: f32) -> Bands {
        self.at(roughness, 1)
    }
}

/// Bands of cos · k(cos) for any k, by six Gauss-Legendre nodes in the cosine.
#[inline]
pub(crate) fn quadrature_bands(k: impl Fn(f32) -> f32) -> Bands {
    const NODES: [[f32; 2]; 6] = [
        [0.033_765_24, 0.085_662_25],
        [0.169_395_31, 0.180_380_79],
        [0.380_690_4, 0.233_956_97],
        [0.619_309_6, 0.233_956_97],
        [0.830_604_7, 0.180_380_79],
        [0.966_234_8, 0.085_662_25],
    ];
    let mut bands = [0.0; 3];
    for [mu, weight] in NODES {
        let v = TAU as f32 * weight * mu * k(mu);
        bands[0] += v;
        bands[1] += v * mu;
        bands[2] += v * (1.5 * mu * mu - 0.5);
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// Band 0 is π times the average that the tables state for themselves.
    #[test]
    fn band_zero_is_the_average() {
        let table = ZonalTable::new();
        for i in 0..=20 {
            let r = i as f32 / 20.0;
            let (w, l) = (Row::new(r).average().w, MirrorLoss::new(r * r).average());
            let (got_w, got_l) = (table.schlick(r)[0] / PI, table.loss(r)[0] / PI);
            assert!((got_w - w).abs() < 5e-4, "W at {r}: {got_w} {w}");
            assert!((got_l - l).abs() < 5e-4 + 5e-3 * l, "loss at {r}: {got_l} {l}");
        }
    }

    /// A mirror's weight is (1 − μ)⁵: 2π ∫ μ (1 − μ)⁵ P_l dμ in closed form.
    #[test]
    fn a_mirror_has_schlicks_bands() {
        let got = ZonalTable::new().schlick(0.0);
        // ∫ μ (1−μ)⁵ = 1/42, ∫ μ² (1−μ)⁵ = 1/168, ∫ μ³ (1−μ)⁵ = 1/504.
        let want = [1.0 / 42.0, 1.0 / 168.0, 1.5 / 504.0 - 0.5 / 42.0].map(|v: f32| v * 2.0 * PI);
        for l in 0..3 {
            assert!((got[l] - want[l]).abs() < 1e-3, "band {l}: {got:?} {want:?}");
        }
    }
}
