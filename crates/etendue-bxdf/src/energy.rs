//! How much light the single-scattering GGX lobe reflects, as a table.
//!
//! The lobe's directional albedo for F = 1 is E(cos θ, roughness): below 1, because light that meets a second
//! microfacet is lost. With Schlick's Fresnel its albedo is E · F̄, where F̄ = F0 + (F90 − F0) · W is Fresnel's term
//! averaged over the microfacets that are seen, and W the mean of (1 − cos)⁵ (E · F̄ is the F0 · A + F90 · B of Karis 2013,
//! "Real Shading in Unreal Engine 4"; keeping E apart separates what is lost from what is not reflected, as Kulla,
//! Conty 2017 need it). The table holds E and W by quadrature over √cos θ × √roughness; each row ends with the averages
//! ∫ · 2µ dµ.
//!
//! `cargo run --release -p etendue-bxdf --example ggx_table` writes it anew; a test holds it against the integral.

/// Columns: values at cos θ = (i / (COLUMNS − 1))².
pub const COLUMNS: usize = 72;
/// Rows: values at perceptual roughness (j / (ROWS − 1))²: dense where the table's step at cos θ ≈ α moves fast.
pub const ROWS: usize = 73;

/// Pairs per row: the columns and the average.
const STRIDE: usize = COLUMNS + 1;

/// The table's file: rows of pairs (E, W), each a little-endian 16-bit fraction of 65535.
static BYTES: &[u8; ROWS * STRIDE * 4] = include_bytes!("ggx_table.bin");

/// The table as numbers, unpacked by the compiler.
static TABLE: [[f32; 2]; ROWS * STRIDE] = unpack();

const fn unpack() -> [[f32; 2]; ROWS * STRIDE] {
    let mut out = [[0.0; 2]; ROWS * STRIDE];
    let mut i = 0;
    while i < out.len() {
        let mut k = 0;
        while k < 2 {
            let at = (2 * i + k) * 2;
            out[i][k] = (BYTES[at] as u32 + 256 * BYTES[at + 1] as u32) as f32 / 65535.0;
            k += 1;
        }
        i += 1;
    }
    out
}

/// What the lobe does to light from one direction, or on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// E: the albedo for F = 1.
    pub e: f32,
    /// W: the mean Schlick weight, so that the mean Fresnel term is F0 + (F90 − F0) · W.
    pub w: f32,
}

/// The table at one roughness: found once for a closure, then asked for angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    first: u32,
    fraction: f32,
}

impl Row {
    /// The row of a perceptual roughness, clamped to 0..1 (NaN as 0).
    #[inline(always)]
    pub fn new(roughness: f32) -> Self {
        let x = roughness.max(0.0).min(1.0).sqrt() * (ROWS - 1) as f32;
        let j = (x as usize).min(ROWS - 2);
        Self { first: (j * STRIDE) as u32, fraction: x - j as f32 }
    }

    /// Directional albedo at an angle of cosine `cos`, clamped to 0..1; bilinear. Against the integral the
    /// error of each is at most 2e-3 for cos θ ≥ 0.01 (the test prints them); it grows
    /// towards grazing where α is small.
    #[inline(always)]
    pub fn directional(&self, cos: f32) -> Albedo {
        let x = cos.max(0.0).min(1.0).sqrt() * (COLUMNS - 1) as f32;
        let i = (x as usize).min(COLUMNS - 2);
        let t = x - i as f32;
        let at = self.first as usize + i;
        let (p, q) = (TABLE[at], TABLE[at + 1]);
        let (r, s) = (TABLE[at + STRIDE], TABLE[at + STRIDE + 1]);
        let mix = |k: usize| {
            let low = p[k] + (q[k] - p[k]) * t;
            let high = r[k] + (s[k] - r[k]) * t;
            low + (high - low) * self.fraction
        };
        Albedo { e: mix(0), w: mix(1) }
    }

    /// Average albedo: of a surface lit evenly from everywhere.
    #[inline(always)]
    pub fn average(&self) -> Albedo {
        let at = self.first as usize + COLUMNS;
        let (p, q) = (TABLE[at], TABLE[at + STRIDE]);
        Albedo { e: p[0] + (q[0] - p[0]) * self.fraction, w: p[1] + (q[1] - p[1]) * self.fraction }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bsdf, GgxReflection, Schlick, laws::Rng, quadrature::directional_albedo};
    use etendue_color::Spectrum;
    use glam::vec3a;

    /// (E, W) by quadrature.
    fn integral(roughness: f32, cos: f32) -> [f32; 2] {
        let fresnel = Schlick { f0: Spectrum([1.0, 0.0, 0.0, 0.0]), f90: Spectrum::ONE };
        let alpha = roughness * roughness;
        let lobe = GgxReflection::new(alpha, alpha, fresnel);
        let wo = vec3a((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        assert!(lobe.eval(wo, wo).is_finite());
        let e = directional_albedo(&lobe, wo);
        [e[0], e[1] / e[0]]
    }

    #[test]
    fn table_meets_the_integral() {
        let mut rng = Rng::new(7);
        let mut worst = [0.0f32; 2];
        for i in 0..400 {
            let roughness = rng.uniform();
            let cos = 0.01 + 0.99 * rng.uniform().powi(1 + i % 3);
            let want = integral(roughness, cos);
            let got = Row::new(roughness).directional(cos);
            let errors = [(got.e - want[0]).abs(), (got.w - want[1]).abs()];
            for k in 0..2 {
                assert!(errors[k] < 2e-3, "roughness {roughness} cos {cos}: {got:?}, {want:?}");
                worst[k] = worst[k].max(errors[k]);
            }
        }
        println!("worst error of E {:.1e}, of W {:.1e}", worst[0], worst[1]);
    }

    #[test]
    fn averages_are_those_of_the_columns() {
        for roughness in [0.0, 0.1, 0.37, 0.8, 1.0] {
            let row = Row::new(roughness);
            let n = 4000;
            let mut sum = [0.0f64; 2];
            for i in 0..n {
                let cos = (i as f32 + 0.5) / n as f32;
                let v = row.directional(cos);
                sum[0] += (v.e * 2.0 * cos) as f64 / n as f64;
                sum[1] += (v.w * 2.0 * cos) as f64 / n as f64;
            }
            let average = row.average();
            assert!((sum[0] - average.e as f64).abs() < 5e-4, "{roughness}: {sum:?} {average:?}");
            assert!((sum[1] - average.w as f64).abs() < 5e-4, "{roughness}: {sum:?} {average:?}");
        }
    }

    #[test]
    fn any_input_gives_a_number() {
        for v in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1.0, 2.0] {
            let row = Row::new(v);
            for cos in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1.0, 2.0] {
                let d = row.directional(cos);
                assert!((0.0..=1.0).contains(&d.e) && (0.0..=1.0).contains(&d.w));
            }
        }
    }
}
