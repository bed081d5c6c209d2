//! Nine spherical harmonics: a sky as a matte surface sees it.
//!
//! The real harmonics of bands 0, 1 and 2, without alternating signs, in world coordinates (x, y, z):
//!
//! ```text
//! Y00 = 0.282095                        Y2−2 = 1.092548 xy      Y20 = 0.315392 (3z² − 1)
//! Y1−1, Y10, Y11 = 0.488603 (y, z, x)   Y2−1 = 1.092548 yz      Y21 = 1.092548 xz     Y22 = 0.546274 (x² − y²)
//! ```
//!
//! The cosine of a matte surface damps band l by A_l = π, 2π/3, π/4, and lets nearly nothing of higher bands through
//! (Ramamoorthi, Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps", eq. 9 and section 3).

use crate::sky::SkyMap;
use etendue_bxdf::quadrature::gauss_legendre;
use etendue_color::Spectrum;
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// √(1/4π), √(3/4π), √(15/4π), √(5/16π), √(15/16π).
pub(crate) const K: [f64; 5] = [
    0.282_094_791_773_878_14,
    0.488_602_511_902_919_9,
    1.092_548_430_592_079_2,
    0.315_391_565_252_520_05,
    0.546_274_215_296_039_6,
];

/// A_l: what the clamped cosine does to band l.
pub const COSINE: [f64; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];

/// The band of each coefficient.
pub const BAND: [usize; 9] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

/// Radiance as nine coefficients in the order Y00, Y1−1, Y10, Y11, Y2−2, Y2−1, Y20, Y21, Y22.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sh9(pub [Spectrum; 9]);

impl Serialize for Sh9 {
    /// Nine triples.
    fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_seq(self.0.iter().map(|c| c.to_rgb()))
    }
}

/// The nine harmonics at a unit direction.
#[inline]
pub fn basis(d: Vec3) -> [f32; 9] {
    let k = K.map(|v| v as f32);
    let (x, y, z) = (d.x, d.y, d.z);
    [
        k[0],
        k[1] * y,
        k[1] * z,
        k[1] * x,
        k[2] * x * y,
        k[2] * y * z,
        k[3] * (3.0 * z * z - 1.0),
        k[2] * x * z,
        k[4] * (x * x - y * y),
    ]
}

impl Sh9 {
    /// No light.
    pub const ZERO: Self = Self([Spectrum::ZERO; 9]);

    /// Projects a sky: c = ∫ L Y dω, exactly, for the picture that its texels make when they are joined bilinearly.
    ///
    /// In latitude and longitude both the harmonics and the bilinear weights are products of a function of θ and one
    /// of φ, so each texel's integral is a product too: its column's in closed form (a hat of half width Δ keeps cos kφ up to
    /// the factor Δ (sin(kΔ/2) / (kΔ/2))²), its row's by Gauss-Legendre quadrature to the last digits. Sums are in `f64` and in a
    /// fixed order: the result does not depend on the number of threads.
    pub fn project(sky: &SkyMap) -> Self {
        let (w, h) = (sky.width(), sky.height());
        let columns = columns(w, f64::from(sky.turn()));
        let nodes = gauss_legendre(16);
        let rows: Vec<[[f64; 3]; 9]> = (0..h)
            .into_par_iter()
            .map(|y| {
                // ∫ over the row of L times 1, cos φ, sin φ, cos 2φ, sin 2φ.
                let mut f = [[0.0f64; 3]; 5];
                for (x, c) in columns.iter().enumerate() {
                    let l = sky.texel(x, y).to_rgb().map(f64::from);
                    for (f, c) in f.iter_mut().zip(c) {
                        (0..3).for_each(|i| f[i] += c * l[i]);
                    }
                }
                let r = row(y, h, &nodes);
                // Factors of 1, cos φ, sin φ, cos 2φ, sin 2φ in each harmonic, with x = sin θ cos φ, y = cos θ, z = sin θ sin φ.
                let terms: [[f64; 5]; 9] = [
                    [K[0] * r.one, 0.0, 0.0, 0.0, 0.0],
                    [K[1] * r.cos, 0.0, 0.0, 0.0, 0.0],
                    [0.0, 0.0, K[1] * r.sin, 0.0, 0.0],
                    [0.0, K[1] * r.sin, 0.0, 0.0, 0.0],
                    [0.0, K[2] * r.sin_cos, 0.0, 0.0, 0.0],
                    [0.0, 0.0, K[2] * r.sin_cos, 0.0, 0.0],
                    [K[3] * (1.5 * r.sin2 - r.one), 0.0, 0.0, -1.5 * K[3] * r.sin2, 0.0],
                    [0.0, 0.0, 0.0, 0.0, 0.5 * K[2] * r.sin2],
                    [K[4] * (0.5 * r.sin2 - r.cos2), 0.0, 0.0, 0.5 * K[4] * r.sin2, 0.0],
                ];
                terms.map(|t| {
                    let lane = |i: usize| t.iter().zip(&f).map(|(t, f)| t * f[i]).sum::<f64>();
                    [lane(0), lane(1), lane(2)]
                })
            })
            .collect();
        let mut sum = [[0.0f64; 3]; 9];
        for row in rows {
            for (s, r) in sum.iter_mut().zip(row) {
                (0..3).for_each(|i| s[i] += r[i]);
            }
        }
        Self(sum.map(|c| Spectrum::from_rgb(c.map(|v| v as f32))))
    }

    /// Projects a function of direction by its values at directions of given solid angles (they add up to 4π).
    pub fn from_samples(samples: impl IntoIterator<Item = (Vec3, Spectrum, f64)>) -> Self {
        let mut sum = [[0.0f64; 4]; 9];
        for (d, radiance, solid_angle) in samples {
            for (s, b) in sum.iter_mut().zip(basis(d)) {
                (0..4).for_each(|i| s[i] += f64::from(b) * f64::from(radiance[i]) * solid_angle);
            }
        }
        Self(sum.map(|c| Spectrum(c.map(|v| v as f32))))
    }

    /// The radiance that the nine coefficients stand for, from the unit direction `d`; may be negative.
    #[inline]
    pub fn radiance(&self, d: Vec3) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for (c, b) in self.0.iter().zip(basis(d)) {
            sum += *c * b;
        }
        sum
    }

    /// Irradiance on a surface of unit normal `n`: E(n) = Σ A_l c_lm Y_lm(n) (Ramamoorthi, Hanrahan 2001, eq. 13). Under
    /// radiance 1 from everywhere it is π. May be negative if the coefficients ring; see [`crate::Window`].
    #[inline]
    pub fn irradiance(&self, n: Vec3) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for ((c, b), band) in self.0.iter().zip(basis(n)).zip(BAND) {
            sum += *c * (b * COSINE[band] as f32);
        }
        sum
    }

    /// Each band multiplied by a factor.
    pub fn scale_bands(&self, factor: [f64; 3]) -> Self {
        let mut out = *self;
        for (c, band) in out.0.iter_mut().zip(BAND) {
            *c *= factor[band] as f32;
        }
        out
    }

    /// The light seen in a mirror that turns z around: what right-handed coordinates become in left-handed ones.
    pub fn mirror_z(&self) -> Self {
        let mut out = *self;
        for i in [2, 5, 7] {
            out.0[i] = -out.0[i];
        }
        out
    }

    /// Linear mixture: `self · (1 − t) + other · t`.
    pub fn lerp(&self, other: &Self, t: f32) -> Self {
        Self(std::array::from_fn(|i| self.0[i].lerp(other.0[i], t)))
    }
}

/// ∫ hat(φ) {1, cos φ, sin φ, cos 2φ, sin 2φ} dφ for each column.
fn columns(w: usize, turn: f64) -> Vec<[f64; 5]> {
    let delta = TAU / w as f64;
    let keep = |k: f64| {
        let x = 0.5 * k * delta;
        delta * (x.sin() / x).powi(2)
    };
    let (one, two) = (keep(1.0), keep(2.0));
    (0..w)
        .map(|x| {
            let phi = TAU * ((x as f64 + 0.5) / w as f64 - 0.5 - turn);
            [delta, one * phi.cos(), one * phi.sin(), two * (2.0 * phi).cos(), two * (2.0 * phi).sin()]
        })
        .collect()
}

/// ∫ hat(θ) g(θ) sin θ dθ of a row.
struct Row {
    one: f64,
    cos: f64,
    sin: f64,
    sin_cos: f64,
    sin2: f64,
    cos2: f64,
}

fn row(y: usize, h: usize, nodes: &[(f64, f64)]) -> Row {
    let delta = PI / h as f64;
    let centre = (y as f64 + 0.5) * delta;
    let mut r = Row { one: 0.0, cos: 0.0, sin: 0.0, sin_cos: 0.0, sin2: 0.0, cos2: 0.0 };
    let mut add = |from: f64, to: f64, weight: &dyn Fn(f64) -> f64| {
        for &(x, q) in nodes {
            let theta = from + (to - from) * x;
            let (s, c) = theta.sin_cos();
            let m = q * (to - from) * weight(theta) * s;
            r.one += m;
            r.cos += m * c;
            r.sin += m * s;
            r.sin_cos += m * s * c;
            r.sin2 += m * s * s;
            r.cos2 += m * c * c;
        }
    };
    let hat = |theta: f64| 1.0 - (theta - centre).abs() / delta;
    // Towards a pole the first and the last row go on as they are.
    if y == 0 {
        add(0.0, centre, &|_| 1.0);
    } else {
        add(centre - delta, centre, &hat);
    }
    if y + 1 == h {
        add(centre, PI, &|_| 1.0);
    } else {
        add(centre, centre + delta, &hat);
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::irradiance::ExactIrradiance;
    use crate::sky::tests_support::lat_long;
    use etendue_bxdf::laws::Rng;

    fn direction(rng: &mut Rng) -> Vec3 {
        let (z, phi) = (2.0 * rng.uniform() - 1.0, std::f32::consts::TAU * rng.uniform());
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    #[test]
    fn white_sky_has_irradiance_pi() {
        for (w, h) in [(1, 1), (2, 1), (3, 2), (64, 32)] {
            let sh = Sh9::project(&lat_long(w, h, 0.3, |_, _| [1.0, 0.5, 2.0]));
            let mut rng = Rng::new(1);
            for _ in 0..50 {
                let e = sh.irradiance(direction(&mut rng)).to_rgb();
                for (e, l) in e.iter().zip([1.0, 0.5, 2.0]) {
                    assert!((e / (std::f32::consts::PI * l) - 1.0).abs() < 1e-6, "{w} × {h}: {e}");
                }
            }
            assert!(sh.0[1..].iter().all(|c| c.map(f32::abs).max_element() < 1e-6), "{sh:?}");
        }
    }

    /// The coefficients of a bilinear picture against a brute integral of the same picture, turned.
    #[test]
    fn projection_is_the_integral_of_the_bilinear_picture() {
        let sky = lat_long(7, 5, 1.1, |x, y| [(x * 3 + y * y) as f32 % 5.0, (x == 3) as u8 as f32, y as f32]);
        let got = Sh9::project(&sky);
        let n = 1200;
        let mut samples = Vec::new();
        for i in 0..n {
            let theta = PI * (i as f64 + 0.5) / n as f64;
            let band = (PI * i as f64 / n as f64).cos() - (PI * (i + 1) as f64 / n as f64).cos();
            for j in 0..2 * n {
                let phi = TAU * (j as f64 + 0.5) / (2 * n) as f64;
                let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|v| v as f32);
                samples.push((
                    Vec3::from(d),
                    sky.radiance(Vec3::from(d).into()),
                    band * TAU / (2 * n) as f64,
                ));
            }
        }
        let want = Sh9::from_samples(samples);
        for i in 0..9 {
            let error = (got.0[i] - want.0[i]).map(f32::abs).max_element();
            assert!(error < 2e-4, "coefficient {i}: {:?}, {:?}", got.0[i], want.0[i]);
        }
    }

    /// A sky that is a polynomial of second degree in direction is kept whole: irradiance is exact.
    #[test]
    fn smooth_skies_are_exact() {
        let (w, h) = (512, 256);
        let l = |d: Vec3| 1.0 + 0.4 * d.x - 0.3 * d.z + 0.5 * d.x * d.y - 0.2 * d.y * d.z + 0.3 * d.z * d.z;
        let sky = lat_long(w, h, 0.0, |x, y| {
            let phi = std::f32::consts::TAU * ((x as f32 + 0.5) / w as f32 - 0.5);
            let theta = std::f32::consts::PI * (y as f32 + 0.5) / h as f32;
            [l(Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())); 3]
        });
        let (sh, exact) = (Sh9::project(&sky), ExactIrradiance::new(&sky));
        let mut rng = Rng::new(3);
        for _ in 0..100 {
            let d = direction(&mut rng);
            assert!((sh.radiance(d)[0] - l(d)).abs() < 2e-4);
            let (a, b) = (sh.irradiance(d)[0], exact.at(d)[0]);
            assert!((a / b - 1.0).abs() < 2e-4, "{a} {b}");
        }
    }

    #[test]
    fn mirror_turns_z_around() {
        let sh = Sh9(std::array::from_fn(|i| Spectrum::splat(i as f32 + 1.0)));
        let mut rng = Rng::new(3);
        for _ in 0..20 {
            let d = direction(&mut rng);
            let (a, b) = (sh.radiance(d)[0], sh.mirror_z().radiance(Vec3::new(d.x, d.y, -d.z))[0]);
            assert!((a - b).abs() < 1e-4);
        }
    }
}
