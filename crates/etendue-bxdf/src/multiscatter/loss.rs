//! How much light single scattering by GGX microfacets loses.
//!
//! L(μ, α) = 1 − E is what of the light from a direction of cosine μ finds no way out after one event, for a surface of
//! microfacets with F = 1; L(μ, α, η) the same for a boundary between two dielectrics, reflection and refraction together,
//! counted as power. Averages are L̄ = 2 ∫ L μ dμ.
//!
//! The loss of a rough surface lives at cosines near α and below. So the columns are not in μ but in
//!
//! ```text
//! v = μ (1 + α) / (μ + α),   0..1, squared nodes,
//! ```
//!
//! in which it keeps its shape for every α, and √L is stored (16 bits), which is nearly straight and keeps its digits
//! where L falls off as (α / μ)². The averages are those of the interpolated function, so that a lobe built of both
//! integrates to what it must. [`crate::energy`] has E beside Schlick's mean on a coarser raster for layering;
//! compensation asks for more digits.
//!
//! `cargo run --release -p etendue-bxdf --example loss_table` writes both tables anew; tests hold them against quadrature.

/// Columns of the mirror's table: v = (i / (COLUMNS − 1))².
pub const COLUMNS: usize = 48;
/// Rows of the mirror's table: see [`row_roughness`].
pub const ROWS: usize = 48;
/// The least α of the tables: the first row's.
pub const LEAST_ALPHA: f32 = 1e-4;
/// Averages: on the rows' axis, sixteen to a row, because over α² they bend where α is small.
pub const AVERAGES: usize = 16 * (ROWS - 1) + 1;
/// What an average over α² is divided by, so that it is a fraction.
pub const AVERAGE_SCALE: f32 = 32.0;

/// Perceptual roughness of a row of `rows`: from √[`LEAST_ALPHA`] to 1, evenly.
pub fn row_roughness(row: usize, rows: usize) -> f64 {
    let least = (LEAST_ALPHA as f64).sqrt();
    least + (1.0 - least) * row as f64 / (rows - 1) as f64
}

/// μ at a column of the mirror's table.
pub fn cosine(column: usize, alpha: f64) -> f64 {
    let v = (column as f64 / (COLUMNS - 1) as f64).powi(2);
    alpha * v / (1.0 + alpha - v)
}

/// A 16-bit fraction of 65535.
const fn unpack<const BYTES: usize, const N: usize>(bytes: &[u8; BYTES]) -> [f32; N] {
    let mut out = [0.0; N];
    let mut i = 0;
    while i < N {
        out[i] = (bytes[2 * i] as u32 + 256 * bytes[2 * i + 1] as u32) as f32 / 65535.0;
        i += 1;
    }
    out
}

static MIRROR: [f32; ROWS * COLUMNS + AVERAGES] = unpack(include_bytes!("mirror_loss.bin"));

/// Position on an axis of `n` nodes: the node below and the fraction to the next. `x` in 0..1, NaN counts as 0.
#[inline(always)]
fn place(x: f32, n: usize) -> (usize, f32) {
    let x = x.max(0.0).min(1.0) * (n - 1) as f32;
    let i = (x as usize).min(n - 2);
    (i, x - i as f32)
}

/// The row of an α.
#[inline(always)]
fn place_alpha(alpha: f32, rows: usize) -> (usize, f32) {
    // √LEAST_ALPHA = 0.01.
    place((alpha.sqrt() - 0.01) * (1.0 / 0.99), rows)
}

/// √v of a cosine.
#[inline(always)]
fn root_v(mu: f32, alpha: f32) -> f32 {
    (mu * (1.0 + alpha) / (mu + alpha)).sqrt()
}

#[inline(always)]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// The loss of a surface of mirrors at one α: found once for a closure, then asked for angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorLoss {
    alpha: f32,
    first: u32,
    fraction: f32,
    average: f32,
}

impl MirrorLoss {
    /// At α (roughness²), clamped to [`LEAST_ALPHA`]..1; NaN counts as the least.
    #[inline(always)]
    pub fn new(alpha: f32) -> Self {
        let alpha = alpha.max(LEAST_ALPHA).min(1.0);
        let (row, fraction) = place_alpha(alpha, ROWS);
        let (i, t) = place_alpha(alpha, AVERAGES);
        let at = ROWS * COLUMNS + i;
        let average = mix(MIRROR[at], MIRROR[at + 1], t) * AVERAGE_SCALE * (alpha * alpha);
        Self { alpha, first: (row * COLUMNS) as u32, fraction, average }
    }

    /// 1 − E at an angle of cosine `cos` (clamped to 0..1), 0..1; within 5e-4 of the integral.
    #[inline(always)]
    pub fn directional(&self, cos: f32) -> f32 {
        let (i, t) = place(root_v(cos.max(0.0).min(1.0), self.alpha), COLUMNS);
        let at = self.first as usize + i;
        let low = mix(MIRROR[at], MIRROR[at + 1], t);
        let high = mix(MIRROR[at + COLUMNS], MIRROR[at + COLUMNS + 1], t);
        let root = mix(low, high, self.fraction);
        root * root
    }

    /// 1 − E averaged over the hemisphere, weighted by the cosine; of the function above, to 4e-3 of itself. Above 0.
    #[inline(always)]
    pub fn average(&self) -> f32 {
        self.average
    }
}

/// Indices of the boundary's table, entering and leaving: see [`node_index`].
pub const INDICES: usize = 18;
/// Rows by roughness of the boundary's table, as [`row_roughness`].
pub const BOUNDARY_ROWS: usize = 24;
/// Columns of the boundary's table: at [`boundary_cosine`].
pub const BOUNDARY_COLUMNS: usize = 48;
/// Averages on the axis of rows for each index.
pub const BOUNDARY_AVERAGES: usize = 8 * (BOUNDARY_ROWS - 1) + 1;
/// μ at a column of the boundary's table: where (√v + μ) / 2 is the column's part of the way. Half of the columns lie as the
/// mirror's do, half evenly over μ, where the critical angle may be.
pub fn boundary_cosine(column: usize, alpha: f64) -> f64 {
    let x = column as f64 / (BOUNDARY_COLUMNS - 1) as f64;
    let (mut low, mut high) = (0.0f64, 1.0f64);
    for _ in 0..60 {
        let mu = 0.5 * (low + high);
        if 0.5 * ((mu * (1.0 + alpha) / (mu + alpha)).sqrt() + mu) < x { low = mu } else { high = mu }
    }
    0.5 * (low + high)
}

/// (η − 1) / (η + 1) of the largest index, 5.
const LARGEST_RATIO: f32 = 2.0 / 3.0;
/// Numbers per index.
const SLAB: usize = BOUNDARY_ROWS * BOUNDARY_COLUMNS + BOUNDARY_AVERAGES;

/// The larger index over the smaller at a node: even in √((η − 1) / (η + 1)), for where indices are near to each other
/// the loss changes over cosines of √|η − 1|; from 1.001 (nearer to 1 nothing is bent) to 5.
pub fn node_index(node: usize) -> f64 {
    let root = node as f64 / (INDICES - 1) as f64;
    let r = 2.0 / 3.0 * root * root;
    ((1.0 + r) / (1.0 - r)).max(1.001)
}

/// First all indices entering the denser medium, then all leaving it.
static BOUNDARY: [f32; 2 * INDICES * SLAB] = unpack(include_bytes!("boundary_loss.bin"));

/// Four nodes around a place on an axis of `n`, and their weights in the cubic through them (Lagrange's).
#[inline(always)]
fn cubic(x: f32, n: usize) -> (usize, [f32; 4]) {
    let x = x.max(0.0).min(1.0) * (n - 1) as f32;
    let first = (x as usize).saturating_sub(1).min(n - 4);
    let t = x - first as f32;
    let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
    (first, [b * c * d * (-1.0 / 6.0), a * c * d * 0.5, a * b * d * -0.5, a * b * c * (1.0 / 6.0)])
}

/// The loss of a boundary between dielectrics at one α and relative index: found once for a closure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryLoss {
    alpha: f32,
    first: u32,
    /// Weights of four rows and four indices.
    rows: [f32; 4],
    indices: [f32; 4],
    average: f32,
}

impl BoundaryLoss {
    /// At α (clamped to [`LEAST_ALPHA`]..1) and η, the far side's index over the near side's (clamped to 1/5..5). NaN counts
    /// as the least.
    #[inline]
    pub fn new(alpha: f32, eta: f32) -> Self {
        let alpha = alpha.max(LEAST_ALPHA).min(1.0);
        let eta = eta.max(0.2).min(5.0);
        let ratio = (((eta - 1.0) / (eta + 1.0)).abs() * (1.0 / LARGEST_RATIO)).sqrt();
        let (index, indices) = cubic(ratio, INDICES);
        let slab = (if eta >= 1.0 { index } else { INDICES + index }) * SLAB;
        let (row, rows) = cubic((alpha.sqrt() - 0.01) * (1.0 / 0.99), BOUNDARY_ROWS);
        let (i, t) = place_alpha(alpha, BOUNDARY_AVERAGES);
        let mut average = 0.0;
        for (k, w) in indices.iter().enumerate() {
            let at = slab + k * SLAB + BOUNDARY_ROWS * BOUNDARY_COLUMNS + i;
            average += w * mix(BOUNDARY[at], BOUNDARY[at + 1], t);
        }
        Self {
            alpha,
            first: (slab + row * BOUNDARY_COLUMNS) as u32,
            rows,
            indices,
            average: (average * AVERAGE_SCALE * (alpha * alpha)).max(1e-12),
        }
    }

    /// What of the light from a direction of cosine `cos` (clamped to 0..1) neither reflection nor refraction of one
    /// event brings out, 0..1; within 6e-3 of the integral, 1e-3 in the mean, and rather below it, for relative indices
    /// 1.33..2.4 and their inverses (the worst is at normal incidence on the inside of water, roughness 0.6).
    #[inline]
    pub fn directional(&self, cos: f32) -> f32 {
        let mu = cos.max(0.0).min(1.0);
        let (i, t) = place(0.5 * (root_v(mu, self.alpha) + mu), BOUNDARY_COLUMNS);
        let mut root = 0.0;
        for (k, w) in self.indices.iter().enumerate() {
            let mut slab = 0.0;
            for (j, v) in self.rows.iter().enumerate() {
                let at = self.first as usize + k * SLAB + j * BOUNDARY_COLUMNS + i;
                slab += v * mix(BOUNDARY[at], BOUNDARY[at + 1], t);
            }
            root += w * slab;
        }
        let root = root.max(0.0).min(0.999);
        root * root
    }

    /// The average of the function above, weighted by the cosine. Above 0.
    #[inline(always)]
    pub fn average(&self) -> f32 {
        self.average
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        GgxDielectric, GgxReflection, Schlick, fresnel_term::Dielectric, laws::Rng, model::Transport,
        quadrature::directional_albedo,
    };
    use glam::vec3a;

    #[test]
    fn the_mirrors_table_meets_the_integral() {
        let mut rng = Rng::new(11);
        let mut worst = (0.0f32, 0.0, 0.0);
        for i in 0..600 {
            // Roughness 0.01 and up; a half of the cosines near α.
            let roughness = 0.01 + 0.99 * rng.uniform();
            let alpha = roughness * roughness;
            let u = rng.uniform();
            let cos = if i % 2 == 0 { u } else { (alpha * u / (1.0 + alpha - u)).min(1.0) }.max(1e-3);
            let wo = vec3a((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
            let e = directional_albedo(&GgxReflection::new(alpha, alpha, Schlick::ONE), wo)[0];
            let error = (MirrorLoss::new(alpha).directional(cos) - (1.0 - e)).abs();
            if error > worst.0 {
                worst = (error, roughness, cos);
            }
        }
        println!("worst error {worst:?}");
        assert!(worst.0 < 5e-4, "{worst:?}");
    }

    #[test]
    fn the_boundarys_table_meets_the_integral() {
        let mut rng = Rng::new(12);
        let mut worst = (0.0f32, 0.0, 0.0, 0.0);
        let mut sum = 0.0;
        let n = 300;
        for i in 0..n {
            let roughness = 0.01 + 0.99 * rng.uniform();
            let alpha = roughness * roughness;
            let index = 1.05 + 1.95 * rng.uniform();
            let eta = if i % 4 < 2 { index } else { 1.0 / index };
            let u = rng.uniform();
            let cos = if i % 2 == 0 { u } else { (alpha * u / (1.0 + alpha - u)).min(1.0) }.max(0.01);
            let wo = vec3a((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
            let boundary = GgxDielectric::new([alpha, alpha], Dielectric::new(eta), Transport::Importance);
            if boundary.is_smooth() {
                continue;
            }
            let lost = 1.0 - directional_albedo(&boundary, wo)[0];
            let error = (BoundaryLoss::new(alpha, eta).directional(cos) - lost).abs();
            sum += error / n as f32;
            if error > worst.0 {
                worst = (error, roughness, eta, cos);
            }
        }
        println!("boundary: worst error {worst:?}, mean {sum}");
        assert!(worst.0 < 3e-3, "{worst:?}");
    }

    #[test]
    fn the_mirrors_average_is_that_of_its_function() {
        let mut worst = (0.0f64, 0.0);
        for k in 0..300 {
            let alpha = ((k as f32 + 0.5) / 300.0).powi(2).max(LEAST_ALPHA);
            let loss = MirrorLoss::new(alpha);
            let n = 4000;
            let low = (alpha as f64 * 1e-4).ln();
            let mut sum = 0.0f64;
            for i in 0..n {
                let mu = (low * (1.0 - (i as f64 + 0.5) / n as f64)).exp();
                sum += 2.0 * mu * mu * loss.directional(mu as f32) as f64 * -low / n as f64;
            }
            let error = (loss.average() as f64 / sum - 1.0).abs();
            if error > worst.0 {
                worst = (error, alpha);
            }
        }
        println!("worst relative error {worst:?}");
        assert!(worst.0 < 3e-3, "{worst:?}");
    }

    #[test]
    fn any_input_gives_a_number() {
        for a in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-5, 0.5, 1.0, 2.0] {
            let loss = MirrorLoss::new(a);
            assert!(loss.average() > 0.0 && loss.average() < 1.0);
            for cos in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-7, 0.5, 1.0, 2.0] {
                assert!((0.0..1.0).contains(&loss.directional(cos)));
            }
        }
    }
}
