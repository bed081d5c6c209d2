//! Thin films: soap, oil, oxide; colours from light that interferes with its own reflection.
//!
//! A film of index η₂ and thickness d between the outside and a base reflects, for one wavelength λ, Airy's sum
//! ([`Stack::reflectance`]). A renderer of three colours needs its mean over broad sensitivities. Belcour, Barla 2017
//! ("A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence", eq. 7 to 10) write Airy's sum as
//! a Fourier series in the phase and the sensitivities of the eye as Gaussians, for which each term has a closed form:
//!
//! ```text
//! R  = R₁₂ + R* + Σₘ Cₘ · 2 Sₘ(m D, m φ),    D = 2 η₂ d cos θ₂
//! R* = T₁₂₁² R₂₃ / (1 − R₁₂ R₂₃),            Cₘ = (R* − T₁₂₁) √(R₁₂ R₂₃)ᵐ
//! ```
//!
//! # Three forms
//! - [`FilmView::gltf`]: as `KHR_materials_iridescence` writes it: both faces by Schlick's curve, phases of 0 or π, no
//!   polarisation, two terms of the series, the base's index real and taken from its F0.
//! - [`FilmView::exact`]: both faces by Fresnel's formulas for s and p, a complex index of the base with its phase, three
//!   terms.
//! - For [`Lanes::Wavelengths`] both ask Airy's sum itself, lane by lane (the first with the real index from F0).
//!
//! # Where this departs from the extension
//! The extension adds the phase of the base's red, green and blue to the Gaussians of X, Y and Z. Here each colour's phase
//! stays with that colour; the two agree unless the base's index lies between lanes above and below the film's.
//!
//! # What three colours lose
//! The Gaussians give equal energy at all wavelengths the colour (1.205, 0.948, 0.910), not white, so that in the
//! extension's form the interference term is too strong in red and too weak in the others. [`FilmView::exact`] divides
//! each colour by its share of that white. Distance from the integral of Airy's sum over the CIE 1931 observer, in
//! reflectance, over films of 50 to 1000 nm, indices 1.1 to 2 and cos θ from 0.1 (`cargo test -p etendue-bxdf --test
//! thin_film -- --nocapture`):
//!
//! | base | exact, mean | worst | extension, mean | worst |
//! |---|---|---|---|---|
//! | dielectrics, index 1.2, 1.5, 2 | 0.002 | 0.018 | 0.020 | 0.26 |
//! | metals | 0.005 | 0.083 | 0.074 | 0.65 |
//!
//! The extension's worst are metals: it has no phase for them. Its clamp to 0..1 bites for 5 % of films on bases of F0 ≤ 0.1
//! (the range before is −0.15..1.09) and 9 % on others (−0.19..1.28).

mod airy;

pub use airy::Stack;

use crate::{
    fresnel::pow5,
    math::{exp, sin_cos_tau},
};
use airy::Complex;
use etendue_color::Spectrum;

/// What the four lanes of light are, for things that must know a wavelength.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lanes {
    /// Linear Rec.709 red, green and blue, and a spare.
    #[default]
    Rgb,
    /// Four wavelengths, nanometres.
    Wavelengths([f32; 4]),
}

/// A Gaussian of the eye's sensitivity in wave numbers (Belcour, Barla 2017, supplemental code; the figures stand in
/// `KHR_materials_iridescence`), after division by the integral of ȳ.
struct Gaussian {
    /// val · √(2π var) / 1.0685e-7.
    amplitude: f32,
    /// pos, as turns per nanometre of path.
    turns: f32,
    /// var · (2π)², per nanometre² of path.
    decay: f32,
}

/// X has two, Y and Z one each.
const SENSITIVITY: [Gaussian; 4] = [
    Gaussian { amplitude: 0.846_59, turns: 1.6810e-3, decay: 1.708_547e-7 },
    Gaussian { amplitude: 0.153_868_31, turns: 2.2399e-3, decay: 1.787_661_7e-7 },
    Gaussian { amplitude: 1.000_221_9, turns: 1.7953e-3, decay: 3.673_308_8e-7 },
    Gaussian { amplitude: 1.001_122_5, turns: 2.2084e-3, decay: 2.610_352_5e-7 },
];

/// CIE XYZ to linear Rec.709, white D65, with the extension's digits.
const XYZ_TO_REC709: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// One over the colour that the Gaussians give to equal energy at all wavelengths.
const INVERSE_WHITE: [f32; 3] = [0.829_621_64, 1.054_496_9, 1.098_889_4];

/// Nanometres; beyond, the colours of all orders have mixed long ago.
const THICKEST: f32 = 1e5;

/// A film on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    outside: f32,
    ior: f32,
    thickness: f32,
    lanes: Lanes,
    /// Reflectance of the outer face at normal incidence.
    f0: f32,
}

/// What a base under a film is, for the extension's form: found once from its F0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmBase {
    ior: Spectrum,
    /// Reflectance of the inner face at normal incidence.
    f0: Spectrum,
    /// −1 where light changes sign at the inner face: the base's index is below the film's.
    sign: Spectrum,
}

/// A film seen at an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmView {
    film: ThinFilm,
    cos: f32,
    /// Cosine in the film; 0 beyond the critical angle.
    cos_film: f32,
    /// ∫ of the sensitivities with e^{i m 2π D / λ}, for m = 1, 2, by colour.
    harmonics: [[Complex; 3]; 2],
}

/// ((a − b) / (a + b))².
#[inline(always)]
fn normal_reflectance(a: f32, b: f32) -> f32 {
    let r = (a - b) / (a + b);
    r * r
}

#[inline(always)]
fn schlick(f0: f32, cos: f32) -> f32 {
    f0 + (1.0 - f0) * pow5((1.0 - cos).max(0.0).min(1.0))
}

/// The sensitivities' Fourier transform at a path difference in nanometres, by colour.
fn harmonic(path: f32) -> [Complex; 3] {
    let mut xyz = [Complex::new(0.0, 0.0); 3];
    for (g, axis) in SENSITIVITY.iter().zip([0, 0, 1, 2]) {
        let size = g.amplitude * exp(-g.decay * (path * path));
        let (sin, cos) = sin_cos_tau(g.turns * path);
        xyz[axis] = xyz[axis].add(Complex::new(size * cos, size * sin));
    }
    XYZ_TO_REC709.map(|row| {
        let at = |k: usize| xyz[k].scale(row[k]);
        at(0).add(at(1)).add(at(2))
    })
}

impl ThinFilm {
    /// A film of index `ior` (1..10) and `thickness` in nanometres (0..100 000) in a medium of index `outside` (1..10);
    /// out of range is clamped, NaN to the lower end.
    #[inline]
    pub fn new(ior: f32, thickness: f32, outside: f32, lanes: Lanes) -> Self {
        let ior = ior.max(1.0).min(10.0);
        let outside = outside.max(1.0).min(10.0);
        Self {
            outside,
            ior,
            thickness: thickness.max(0.0).min(THICKEST),
            lanes,
            f0: normal_reflectance(ior, outside),
        }
    }

    /// A base of reflectance `f0` in air (lanes clamped to 0..1, NaN to 0) under this film.
    ///
    /// Its index is real: (1 + √F0) / (1 − √F0), with 1e-4 added to F0 as the extension does, and kept from 1.
    #[inline]
    pub fn base(&self, f0: Spectrum) -> FilmBase {
        let ior = f0.map(|f| {
            let root = (f.max(0.0).min(1.0) + 1e-4).min(0.9999).sqrt();
            (1.0 + root) / (1.0 - root)
        });
        FilmBase {
            ior,
            f0: ior.map(|n| normal_reflectance(n, self.ior)),
            sign: ior.map(|n| if n < self.ior { -1.0 } else { 1.0 }),
        }
    }

    /// The film from an angle of cosine `cos` outside, clamped to 0..1 (NaN to 0).
    #[inline]
    pub fn at(&self, cos: f32) -> FilmView {
        let cos = cos.max(0.0).min(1.0);
        let ratio = self.outside / self.ior;
        let cos2 = 1.0 - ratio * ratio * ((1.0 - cos) * (1.0 + cos));
        let cos_film = cos2.max(0.0).sqrt();
        let harmonics = match self.lanes {
            Lanes::Rgb => {
                let path = 2.0 * self.ior * self.thickness * cos_film;
                [harmonic(path), harmonic(2.0 * path)]
            }
            Lanes::Wavelengths(_) => [[Complex::new(0.0, 0.0); 3]; 2],
        };
        FilmView { film: *self, cos, cos_film, harmonics }
    }
}

impl FilmView {
    /// The extension's reflectance, each lane 0..1; in the spare lane of RGB 0.
    #[inline]
    pub fn gltf(&self, base: &FilmBase) -> Spectrum {
        self.gltf_unclamped(base).map(|v| v.max(0.0).min(1.0))
    }

    /// [`FilmView::gltf`] before the clamp.
    pub fn gltf_unclamped(&self, base: &FilmBase) -> Spectrum {
        if let Lanes::Wavelengths(nm) = self.film.lanes {
            return Spectrum(core::array::from_fn(|i| self.airy(base.ior[i], 0.0, nm[i])));
        }
        if !(self.cos_film > 0.0) {
            return Spectrum::rgb(1.0, 1.0, 1.0);
        }
        let r12 = schlick(self.film.f0, self.cos);
        let t121 = 1.0 - r12;
        // Light changes sign at the outer face on one of its two sides.
        let outer = if self.film.ior < self.film.outside { 1.0 } else { -1.0 };
        let mut out = Spectrum::ZERO;
        for lane in 0..3 {
            let r23 = schlick(base.f0[lane], self.cos_film);
            let r123 = (r12 * r23).max(1e-5).min(0.9999);
            let root = r123.sqrt();
            let star = t121 * t121 * r23 / (1.0 - r123);
            let sign = outer * base.sign[lane];
            let first = 2.0 * self.harmonics[0][lane].re * sign;
            let second = 2.0 * self.harmonics[1][lane].re;
            out[lane] = r12 + star + (star - t121) * (root * first + r123 * second);
        }
        out
    }

    /// Reflectance on a base of complex index n + ik, each lane 0..1; in the spare lane of RGB 0.
    #[inline]
    pub fn exact(&self, n: Spectrum, k: Spectrum) -> Spectrum {
        self.exact_unclamped(n, k).map(|v| v.max(0.0).min(1.0))
    }

    /// [`FilmView::exact`] before the clamp.
    pub fn exact_unclamped(&self, n: Spectrum, k: Spectrum) -> Spectrum {
        let index = |v: f32| v.max(0.0).min(100.0);
        if let Lanes::Wavelengths(nm) = self.film.lanes {
            return Spectrum(core::array::from_fn(|i| self.airy(index(n[i]), index(k[i]), nm[i])));
        }
        // Light that tunnels through a film beyond its critical angle is left out: all is reflected.
        if !(self.cos_film > 0.0) {
            return Spectrum::rgb(1.0, 1.0, 1.0);
        }
        let path = 2.0 * self.film.ior * self.film.thickness * self.cos_film;
        let third = harmonic(3.0 * path);
        let mut out = Spectrum::ZERO;
        for lane in 0..3 {
            let stack = self.stack(index(n[lane]), index(k[lane]));
            let a = stack.amplitudes(self.cos);
            let harmonics = [self.harmonics[0][lane], self.harmonics[1][lane], third[lane]];
            let mut sum = 0.0;
            for (outer, inner) in a.outer.into_iter().zip(a.inner) {
                // r₂₁ = −r₁₂; the loop's amplitude is r₂₁ r₂₃.
                let turn = Complex::new(-outer.re, -outer.im).mul(inner);
                let (r12, r23) = (outer.norm2(), inner.norm2());
                let t121 = 1.0 - r12;
                let star = t121 * t121 * r23 / (1.0 - r12 * r23).max(1e-6);
                let mut power = turn;
                let mut series = 0.0;
                for h in harmonics {
                    series += 2.0 * h.mul(power).re * INVERSE_WHITE[lane];
                    power = power.mul(turn);
                }
                sum += r12 + star + (star - t121) * series;
            }
            let r = 0.5 * sum;
            out[lane] = if r.is_finite() { r } else { 1.0 };
        }
        out
    }

    #[inline(always)]
    fn stack(&self, base: f32, base_k: f32) -> Stack {
        Stack { outside: self.film.outside, film: self.film.ior, base, base_k }
    }

    #[inline(always)]
    fn airy(&self, n: f32, k: f32, wavelength: f32) -> f32 {
        // The clamp keeps the phase within what the sine can turn; the eye sees nothing there.
        self.stack(n, k).reflectance(self.cos, self.film.thickness, wavelength.max(100.0).min(1e5))
    }
}
