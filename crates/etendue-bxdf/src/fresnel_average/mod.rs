//! Any Fresnel term averaged over the microfacets that a GGX lobe shows: Gauss nodes instead of a table per Fresnel.
//!
//! Seen from `wo`, the lobe (F = 1, single scattering, heights correlated) spreads its albedo E over the cosines
//! µ = wo·m of the half angle: a measure on 0..1 that depends on cos θ and roughness only. For each of these the table
//! holds the [`NODES`]-point Gauss rule of that measure, normalised, so that
//!
//! ```text
//! ∫ F(µ) D G2 / (4 cos θo cos θi) cos θi dωi  =  E Σ wₖ F(µₖ)
//! ```
//!
//! is exact for polynomials F of degree 2 · NODES − 1 (Schlick's is one of degree 5, F82-tint's one of 7) and close for
//! every smooth F: dielectrics from outside, conductors, thin films. Total reflection, a step in F, is not smooth.
//! E itself is [`crate::energy`]'s for isotropic lobes; those with two widths have a table of their own with E in it,
//! [`AnisotropicRules`].
//!
//! `cargo run --release -p etendue-bxdf --example fresnel_average_table` writes the tables anew; tests hold them against
//! the integral.

pub mod anisotropic;

pub use anisotropic::AnisotropicRules;

/// Nodes of each rule.
pub const NODES: usize = 4;
/// Columns: rules at cos θ = (i / (COLUMNS − 1))².
pub const COLUMNS: usize = 64;
/// Rows: rules at perceptual roughness [`row_roughness`].
pub const ROWS: usize = 48;

/// Numbers of each rule: the nodes, then all weights but the last, which brings their sum to one.
pub const STRIDE: usize = 2 * NODES - 1;

/// The square root of the first row's roughness; rougher lobes differ, sharper ones are as a mirror to the table.
const FIRST_ROOT: f32 = 0.1;

/// The table's file: rows of columns of rules, each number a little-endian 16-bit fraction of 65535.
static BYTES: &[u8; ROWS * COLUMNS * STRIDE * 2] = include_bytes!("isotropic.bin");

/// The table as numbers, unpacked by the compiler.
static TABLE: [[f32; STRIDE]; ROWS * COLUMNS] = unpack();

const fn unpack() -> [[f32; STRIDE]; ROWS * COLUMNS] {
    let mut out = [[0.0; STRIDE]; ROWS * COLUMNS];
    let mut i = 0;
    while i < out.len() {
        let mut k = 0;
        while k < STRIDE {
            let at = (STRIDE * i + k) * 2;
            out[i][k] = (BYTES[at] as u32 + 256 * BYTES[at + 1] as u32) as f32 / 65535.0;
            k += 1;
        }
        i += 1;
    }
    out
}

/// Perceptual roughness of row `j`.
pub fn row_roughness(j: usize) -> f32 {
    let root = FIRST_ROOT + (1.0 - FIRST_ROOT) * j as f32 / (ROWS - 1) as f32;
    root * root
}

/// A Gauss rule for the half angle's cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Cosines of the half angle, 0..1.
    pub cos: [f32; NODES],
    /// Their weights, which sum to one.
    pub weight: [f32; NODES],
}

impl Rule {
    /// From the numbers of a table's entry: the nodes, then all weights but the last.
    #[inline(always)]
    fn unpacked(number: impl Fn(usize) -> f32) -> Self {
        let cos = core::array::from_fn(&number);
        let mut weight: [f32; NODES] =
            core::array::from_fn(|k| if k + 1 < NODES { number(NODES + k) } else { 0.0 });
        let sum: f32 = weight.iter().sum();
        weight[NODES - 1] = (1.0 - sum).max(0.0);
        Self { cos, weight }
    }

    /// The rule of a mirror: all at one angle.
    #[inline(always)]
    pub fn mirror(cos: f32) -> Self {
        Self { cos: [cos; NODES], weight: [1.0 / NODES as f32; NODES] }
    }
}

/// The rules at one roughness: found once for a closure, then asked for angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    first: u32,
    fraction: f32,
}

impl Rules {
    /// The row of a perceptual roughness, clamped to 0..1 (NaN as 0).
    #[inline(always)]
    pub fn new(roughness: f32) -> Self {
        let root = roughness.max(FIRST_ROOT * FIRST_ROOT).min(1.0).sqrt();
        let x = ((root - FIRST_ROOT) * ((ROWS - 1) as f32 / (1.0 - FIRST_ROOT))).max(0.0);
        let j = (x as usize).min(ROWS - 2);
        Self { first: (j * COLUMNS) as u32, fraction: x - j as f32 }
    }

    /// The rule seen from an angle of cosine `cos`, clamped to 0..1; bilinear.
    ///
    /// Averages of dielectric, metallic and film reflectances differ from the integral by at most 1e-3 for cos θ ≥ 0.02.
    #[inline(always)]
    pub fn directional(&self, cos: f32) -> Rule {
        let x = cos.max(0.0).min(1.0).sqrt() * (COLUMNS - 1) as f32;
        let i = (x as usize).min(COLUMNS - 2);
        let t = x - i as f32;
        let at = self.first as usize + i;
        let (p, q) = (&TABLE[at], &TABLE[at + 1]);
        let (r, s) = (&TABLE[at + COLUMNS], &TABLE[at + COLUMNS + 1]);
        let mix = |k: usize| {
            let low = p[k] + (q[k] - p[k]) * t;
            let high = r[k] + (s[k] - r[k]) * t;
            low + (high - low) * self.fraction
        };
        Rule::unpacked(mix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Ggx,
        fresnel::{dielectric, pow5},
        laws::Rng,
        quadrature::{HalfVectorMap, gauss_legendre},
    };
    use glam::vec3a;

    /// Averages of four functions by quadrature.
    fn averages(roughness: f32, cos: f32, f: impl Fn(f32) -> [f32; 4]) -> [f32; 4] {
        let ggx = Ggx::new(roughness * roughness, roughness * roughness);
        let wo = vec3a((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let map = HalfVectorMap::new(wo, ggx.alpha());
        let nodes = gauss_legendre(6);
        let lobe = |wi: glam::Vec3A| if wi.z > 1e-6 { ggx.pair(wo, wi).value * wi.z } else { 0.0 };
        let mass = map.integrate_all(&nodes, |wi| [lobe(wi), 0.0, 0.0, 0.0])[0];
        let sum = map.integrate_all(&nodes, |wi| f(0.5 * (wo + wi).length()).map(|v| v * lobe(wi)));
        sum.map(|v| (v / mass) as f32)
    }

    #[test]
    fn rules_meet_the_integral() {
        // The last is a film's: fringes that a film of half a micrometre shows.
        let f = |mu: f32| {
            let fringe = 0.5 + 0.5 * (10.0 * (1.0 - 0.5 * (1.0 - mu * mu)).sqrt()).cos();
            [pow5(1.0 - mu), dielectric(mu, 1.5), dielectric(mu, 3.0), fringe]
        };
        let mut rng = Rng::new(11);
        let mut worst = [0.0f32; 4];
        for i in 0..300 {
            let roughness = rng.uniform();
            let cos = 0.02 + 0.98 * rng.uniform().powi(1 + i % 3);
            let want = averages(roughness, cos, f);
            let rule = Rules::new(roughness).directional(cos);
            let mut got = [0.0f32; 4];
            for k in 0..NODES {
                let v = f(rule.cos[k]);
                (0..4).for_each(|i| got[i] += rule.weight[k] * v[i]);
            }
            for k in 0..4 {
                let error = (got[k] - want[k]).abs();
                assert!(error < 1e-3, "function {k}, roughness {roughness} cos {cos}: {got:?}, {want:?}");
                worst[k] = worst[k].max(error);
            }
        }
        println!("worst errors {worst:?}");
    }

    #[test]
    fn any_input_gives_a_rule() {
        for v in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1.0, 2.0] {
            for cos in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1.0, 2.0] {
                let rule = Rules::new(v).directional(cos);
                let sum: f32 = rule.weight.iter().sum();
                assert!((sum - 1.0).abs() < 1e-5 && rule.weight.iter().all(|&w| w >= 0.0), "{rule:?}");
                assert!(rule.cos.iter().all(|c| (0.0..=1.0).contains(c)), "{rule:?}");
            }
        }
    }
}
