//! How much light a GGX lobe reflects from everywhere: the split sum's second factor.
//!
//! With f the height-correlated Smith GGX lobe without its Fresnel term, and Fc = (1 − wo·h)⁵,
//!
//! ```text
//! E = ∫ f cos θi dωi        B = ∫ f Fc cos θi dωi        A = E − B
//! albedo with Schlick's Fresnel = F0 · A + F90 · B = F0 · E + (F90 − F0) · B
//! ```
//!
//! (Karis 2013, "Real Shading in Unreal Engine 4", with (A, B) = (scale, bias); Lagarde, de Rousiers 2014, "Moving Frostbite to
//! PBR", section 4.9.2.) Keeping E apart is what energy compensation needs.

use etendue_bxdf::{Ggx, GgxReflection, MIN_COS, Schlick, quadrature::directional_albedo, sheen::SheenRow};
use etendue_color::Spectrum;
use glam::vec3a;
use rayon::prelude::*;

/// The lobe's reflection at one angle and roughness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dfg {
    /// A, the factor of F0: Karis' scale.
    pub scale: f32,
    /// B, the factor of F90: Karis' bias.
    pub bias: f32,
}

impl Dfg {
    /// E = A + B: the albedo for F = 1; what a single scattering leaves of a white sky.
    #[inline]
    pub fn energy(&self) -> f32 {
        self.scale + self.bias
    }

    /// The lobe's albedo with Schlick's Fresnel term from `f0` to `f90`.
    #[inline]
    pub fn albedo(&self, f0: Spectrum, f90: Spectrum) -> Spectrum {
        f0 * self.scale + f90 * self.bias
    }

    /// By quadrature to about 1e-5; takes about a millisecond. Roughness is perceptual (α = roughness²), 0..1, and
    /// `cos` = N·V, raised to 1e-4: at the horizon itself the limit from above.
    pub fn exact(roughness: f32, cos: f32) -> Self {
        let fresnel = Schlick { f0: Spectrum([1.0, 0.0, 0.0, 0.0]), f90: Spectrum::ONE };
        let alpha = roughness.max(0.0).min(1.0).powi(2);
        let lobe = GgxReflection::new(alpha, alpha, fresnel);
        let e = directional_albedo(&lobe, view(cos));
        Self { scale: e[0] - e[1], bias: e[1] }
    }

    /// By importance sampling of the visible normals (Heitz 2018) with `samples` points of a golden-ratio lattice: the estimate is
    /// the mean of G2/G1, and of G2/G1 · Fc.
    pub fn sampled(roughness: f32, cos: f32, samples: u32) -> Self {
        let alpha = roughness.max(0.0).min(1.0).powi(2);
        let (wo, n) = (view(cos), samples.max(1));
        let ggx = Ggx::new(alpha, alpha);
        let (mut e, mut b) = (0.0f64, 0.0f64);
        for i in 0..n {
            // Half of the azimuths suffice: the lobe is symmetric about the plane of incidence.
            let u = [0.5 * (i as f32 * 0.618_034).fract(), (i as f32 + 0.5) / n as f32];
            let m = ggx.sample_half(wo, u);
            let cos_half = wo.dot(m);
            let wi = m * (2.0 * cos_half) - wo;
            if !(wi.z > MIN_COS) {
                continue;
            }
            let g1 = 2.0 * wo.z / (wo.z + ggx.stretched_length(wo));
            let weight = f64::from(ggx.g2(wo, wi) / g1);
            e += weight;
            b += weight * f64::from((1.0 - cos_half).max(0.0).powi(5));
        }
        let (e, b) = ((e / f64::from(n)) as f32, (b / f64::from(n)) as f32);
        Self { scale: e - b, bias: b }
    }
}

/// A view direction of this cosine.
fn view(cos: f32) -> glam::Vec3A {
    let cos = cos.max(1e-4).min(1.0);
    vec3a((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

/// How a table is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DfgMethod {
    /// By quadrature.
    Exact,
    /// By importance sampling with so many samples for each texel.
    Sampled(u32),
}

/// What the channels of a stored table mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DfgLayout {
    /// Red A, green B: albedo = F0 · r + g (Karis; Unreal's, Unity's HDRP without multiple scattering, glTF viewers, the notes).
    #[default]
    ScaleBias,
    /// Red B, green E, blue the sheen lobe's E: albedo = mix(r, g, F0) (Filament's multiple-scattering table with its cloth
    /// channel; the sheen here is `KHR_materials_sheen`'s, kept below one).
    Multiscatter,
}

/// A square table over N·V (columns) and perceptual roughness (rows, the least on top).
///
/// Values belong to the middles of texels, (i + ½)/n, as a graphics processor's bilinear lookup with clamped edges takes them.
///
/// ```
/// use etendue_ibl::{DfgTable, dfg::DfgMethod};
/// let table = DfgTable::new(16, DfgMethod::Sampled(256));
/// let mirror = table.lookup(1.0 / 32.0, 31.0 / 32.0);
/// assert!((mirror.energy() - 1.0).abs() < 1e-3);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DfgTable {
    size: u32,
    values: Vec<Dfg>,
    sheen: Vec<f32>,
}

impl DfgTable {
    /// Integrates a table of `size`² texels, 1..=4096; in parallel, the result does not depend on the threads.
    pub fn new(size: u32, method: DfgMethod) -> Self {
        let size = size.clamp(1, 4096);
        let at = |i: u32| (i as f32 + 0.5) / size as f32;
        let cell = |i: u32| (at(i / size), at(i % size));
        let values = (0..size * size)
            .into_par_iter()
            .map(|i| {
                let (roughness, cos) = cell(i);
                match method {
                    DfgMethod::Exact => Dfg::exact(roughness, cos),
                    DfgMethod::Sampled(n) => Dfg::sampled(roughness, cos, n),
                }
            })
            .collect();
        let sheen = (0..size * size)
            .map(|i| {
                let (roughness, cos) = cell(i);
                SheenRow::new(roughness).directional(cos)
            })
            .collect();
        Self { size, values, sheen }
    }

    /// Texels along an edge.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// The values, row by row.
    pub fn values(&self) -> &[Dfg] {
        &self.values
    }

    /// Bilinear, with clamped edges, as a texture; inputs are clamped to 0..1, NaN to 0.
    pub fn lookup(&self, roughness: f32, cos: f32) -> Dfg {
        let n = self.size as usize;
        let place = |v: f32| {
            let x = (v.max(0.0).min(1.0) * n as f32 - 0.5).max(0.0).min((n - 1) as f32);
            let i = (x as usize).min(n - 1);
            (i, (i + 1).min(n - 1), x - i as f32)
        };
        let ((x0, x1, tx), (y0, y1, ty)) = (place(cos), place(roughness));
        let mix = |a: Dfg, b: Dfg, t: f32| Dfg {
            scale: a.scale + (b.scale - a.scale) * t,
            bias: a.bias + (b.bias - a.bias) * t,
        };
        let row = |y: usize| mix(self.values[y * n + x0], self.values[y * n + x1], tx);
        mix(row(y0), row(y1), ty)
    }

    /// Three channels for each texel in a layout, row by row.
    pub fn pixels(&self, layout: DfgLayout) -> Vec<[f32; 3]> {
        self.values
            .iter()
            .zip(&self.sheen)
            .map(|(v, sheen)| match layout {
                DfgLayout::ScaleBias => [v.scale, v.bias, 0.0],
                DfgLayout::Multiscatter => [v.bias, v.energy(), *sheen],
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;

    /// Figures known from elsewhere: E = 1 − ln 2 at roughness 1 and normal incidence; a mirror has Schlick's two weights.
    #[test]
    fn known_values() {
        let e = Dfg::exact(1.0, 1.0).energy();
        assert!((e - (1.0 - std::f32::consts::LN_2)).abs() < 2e-5, "{e}");
        assert!((Dfg::exact(0.5, 0.5).energy() - 0.8573).abs() < 2e-4);
        let mirror = Dfg::exact(0.0, 0.5);
        assert!((mirror.bias - 0.5f32.powi(5)).abs() < 1e-6 && (mirror.energy() - 1.0).abs() < 1e-6);
    }

    /// A table of 64² texels with 4096 samples each is within 1e-3 of quadrature.
    #[test]
    fn sampled_table_meets_quadrature() {
        let table = DfgTable::new(64, DfgMethod::Sampled(4096));
        let mut worst = 0.0f32;
        // A seventh of the texels, scattered, with all corners; the example `dfg` compares each.
        for i in (0..64 * 64).step_by(7).chain([0, 63, 63 * 64, 64 * 64 - 1]) {
            let want = Dfg::exact((i / 64) as f32 / 64.0 + 0.5 / 64.0, (i % 64) as f32 / 64.0 + 0.5 / 64.0);
            let got = table.values()[i];
            worst = worst.max((got.energy() - want.energy()).abs()).max((got.bias - want.bias).abs());
        }
        println!("worst {worst:.1e}");
        assert!(worst < 1e-3, "{worst}");
    }

    #[test]
    fn lookups_are_texels_at_their_middles_and_clamped_beyond() {
        let table = DfgTable::new(8, DfgMethod::Sampled(64));
        for i in 0..64usize {
            let got = table.lookup(((i / 8) as f32 + 0.5) / 8.0, ((i % 8) as f32 + 0.5) / 8.0);
            let want = table.values()[i];
            assert!((got.scale - want.scale).abs() < 1e-6 && (got.bias - want.bias).abs() < 1e-6);
        }
        assert_eq!(table.lookup(-3.0, 7.0), table.values()[7]);
        assert_eq!(table.lookup(f32::NAN, f32::NAN), table.values()[0]);
        let mut rng = Rng::new(1);
        for _ in 0..1000 {
            let v = table.lookup(rng.uniform(), rng.uniform());
            assert!((0.0..=1.0).contains(&v.scale) && (0.0..=1.0).contains(&v.bias) && v.energy() <= 1.001);
        }
    }

    /// The two layouts say the same.
    #[test]
    fn layouts_agree() {
        let table = DfgTable::new(4, DfgMethod::Sampled(64));
        let (a, b) = (table.pixels(DfgLayout::ScaleBias), table.pixels(DfgLayout::Multiscatter));
        for (a, b) in a.iter().zip(&b) {
            for f0 in [0.0, 0.04, 1.0] {
                assert!((f0 * a[0] + a[1] - (b[0] + (b[1] - b[0]) * f0)).abs() < 1e-6);
            }
            assert!((0.0..=1.0).contains(&b[2]));
        }
    }
}
