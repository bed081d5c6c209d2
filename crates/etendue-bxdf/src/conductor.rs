//! Fresnel reflection from an absorbing medium: metals, by complex index of refraction.
//!
//! Symbols: the far side's index over the near side's is η + ik; c the cosine of incidence, s² = 1 − c²; a + ib =
//! √((η + ik)² − s²), the complex (η + ik)·cos θt. With M = a² + b²,
//!
//! ```text
//! Rs = ((a − c)² + b²) / ((a + c)² + b²),    Rp / Rs = ((ac − s²)² + b²c²) / ((ac + s²)² + b²c²)
//! ```
//!
//! (Born, Wolf, "Principles of Optics", 7th ed., section 14.2, in real numbers). Written so, no term cancels; of a and b
//! the one that would is taken from ab = ηk.

use etendue_color::Spectrum;

/// Indices beyond this are clamped: the reflectance is one to 4e-4 at normal incidence.
const LARGEST: f32 = 1e4;

/// a and b of the module's head.
#[inline(always)]
fn refracted(s2: f32, eta: f32, k: f32) -> (f32, f32) {
    let t = eta * eta - k * k - s2;
    let ek = eta * k;
    let m = (t * t + 4.0 * ek * ek).sqrt();
    if t >= 0.0 {
        let a = (0.5 * (m + t)).sqrt();
        (a, if a > 0.0 { ek / a } else { 0.0 })
    } else {
        let b = (0.5 * (m - t)).sqrt();
        (ek / b, b)
    }
}

/// 0..10⁴, NaN to 0.
#[inline(always)]
fn index(v: f32) -> f32 {
    v.max(0.0).min(LARGEST)
}

/// Unpolarised reflectance of a smooth boundary to an absorbing medium, exact.
///
/// `cos` is the cosine of incidence, clamped to 0..1 (NaN counts as 0); `eta` and `k` are the real and imaginary parts of
/// the far side's index over the near side's, clamped to 0..10⁴, NaN to 0. For k = 0 it is
/// [`crate::fresnel::dielectric`].
#[inline(always)]
pub fn conductor(cos: f32, eta: f32, k: f32) -> f32 {
    let [s, p] = conductor_polarised(cos, eta, k);
    0.5 * (s + p)
}

/// Reflectances of the two polarisations, perpendicular (s) first; arguments as of [`conductor`].
#[inline(always)]
pub fn conductor_polarised(cos: f32, eta: f32, k: f32) -> [f32; 2] {
    let c = cos.max(0.0).min(1.0);
    let s2 = (1.0 - c) * (1.0 + c);
    let (a, b) = refracted(s2, index(eta), index(k));
    let b2 = b * b;
    let ratio = |numerator: f32, denominator: f32| {
        // Both are zero only where the wave goes on as if nothing were there to turn it: total reflection.
        if denominator > 0.0 { (numerator / denominator).min(1.0) } else { 1.0 }
    };
    let square = |x: f32| x * x;
    let s = ratio(square(a - c) + b2, square(a + c) + b2);
    let bc2 = b2 * (c * c);
    let p = s * ratio(square(a * c - s2) + bc2, square(a * c + s2) + bc2);
    [s, p]
}

/// Complex amplitude of a reflected wave over that of the incident one, for each polarisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes {
    /// Perpendicular polarisation: real and imaginary part.
    pub s: [f32; 2],
    /// Parallel polarisation: real and imaginary part.
    pub p: [f32; 2],
}

/// Amplitudes of reflection: rs = (c − q) / (c + q), rp = (N² c − q) / (N² c + q), with N = η + ik and q = √(N² − s²).
///
/// The sign of rp is Verdet's (rs = −rp at normal incidence); waves go as exp(−iωt), so absorption is k > 0 and the phases
/// of reflection are those of the returned numbers. |r|² is [`conductor_polarised`]. Total internal reflection, k = 0, has
/// |r| = 1. Arguments as of [`conductor`].
#[inline(always)]
pub fn conductor_amplitudes(cos: f32, eta: f32, k: f32) -> Amplitudes {
    let c = cos.max(0.0).min(1.0);
    let s2 = (1.0 - c) * (1.0 + c);
    let (eta, k) = (index(eta), index(k));
    let (a, b) = refracted(s2, eta, k);
    // (x − q) / (x + q) for complex x and q.
    let ratio = |x: [f32; 2]| {
        let (nr, ni) = (x[0] - a, x[1] - b);
        let (dr, di) = (x[0] + a, x[1] + b);
        let d = dr * dr + di * di;
        if d > 0.0 { [(nr * dr + ni * di) / d, (ni * dr - nr * di) / d] } else { [-1.0, 0.0] }
    };
    Amplitudes { s: ratio([c, 0.0]), p: ratio([(eta * eta - k * k) * c, 2.0 * eta * k * c]) }
}

/// The largest k that [`k_from_f0`] gives.
const LARGEST_K: f32 = 1e3;

/// Fresnel reflectance of a metal, exact in each lane, by complex index of refraction.
///
/// The indices are relative to the medium outside: divide both by its index if that is not air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    eta: Spectrum,
    k: Spectrum,
}

impl Conductor {
    /// From the real and imaginary part of the index, each clamped to 0..10⁴, NaN to 0.
    #[inline(always)]
    pub fn new(eta: Spectrum, k: Spectrum) -> Self {
        Self { eta: eta.map(index), k: k.map(index) }
    }

    /// Real part of the index.
    #[inline(always)]
    pub fn eta(&self) -> Spectrum {
        self.eta
    }

    /// Imaginary part of the index.
    #[inline(always)]
    pub fn k(&self) -> Spectrum {
        self.k
    }

    /// Unpolarised reflectance at an angle of cosine `cos`.
    #[inline(always)]
    pub fn eval(&self, cos: f32) -> Spectrum {
        Spectrum(core::array::from_fn(|i| conductor(cos, self.eta[i], self.k[i])))
    }

    /// 2 ∫ F(μ) μ dμ by eight Gauss-Legendre nodes: within 3e-4 for the indices of metals.
    pub fn average(&self) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for (x, w) in NODES {
            for (x, w) in [(x, w), (-x, w)] {
                let mu = 0.5 + 0.5 * x;
                // The weights are those of −1..1: half of each for 0..1, twice for 2 μ.
                sum += self.eval(mu) * (w * mu);
            }
        }
        sum.min(Spectrum::ONE)
    }
}

/// Positive nodes and weights of the eight-point Gauss-Legendre rule on −1..1 (Abramowitz, Stegun, table 25.4).
const NODES: [(f32, f32); 4] = [
    (0.183_434_65, 0.362_683_78),
    (0.525_532_4, 0.313_706_64),
    (0.796_666_5, 0.222_381_03),
    (0.960_289_86, 0.101_228_54),
];

/// The k with which an index η + ik reflects `f0` at normal incidence: √((F0 (η + 1)² − (η − 1)²) / (1 − F0)) (Gulbrandsen
/// 2014, "Artist Friendly Metallic Fresnel", eq. 1 solved for k).
///
/// Zero where η alone reflects more than `f0`; at most 10³, which F0 → 1 would exceed. η and F0 are clamped to 0..10⁴ and
/// 0..1.
pub fn k_from_f0(eta: f32, f0: f32) -> f32 {
    let (eta, f0) = (index(eta), f0.max(0.0).min(1.0));
    let k2 = (f0 * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - f0);
    k2.max(0.0).sqrt().min(LARGEST_K)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::dielectric;

    /// Complex arithmetic in `f64`, straight from the amplitudes.
    fn reference(c: f64, n: f64, k: f64) -> [f64; 2] {
        type C = (f64, f64);
        let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let abs2 = |a: C| a.0 * a.0 + a.1 * a.1;
        let sqrt = |z: C| {
            let (r, arg) = (abs2(z).sqrt().sqrt(), 0.5 * z.1.atan2(z.0));
            (r * arg.cos(), r * arg.sin())
        };
        let n2 = mul((n, k), (n, k));
        let q = sqrt((n2.0 - (1.0 - c * c), n2.1));
        let r = |x: C| abs2((x.0 - q.0, x.1 - q.1)) / abs2((x.0 + q.0, x.1 + q.1));
        [r((c, 0.0)), r((n2.0 * c, n2.1 * c))]
    }

    #[test]
    fn meets_complex_arithmetic() {
        let mut worst = 0.0f64;
        for n in [0.02, 0.05, 0.2, 0.9, 1.0, 1.5, 3.0, 10.0] {
            for k in [0.01, 0.5, 1.0, 2.0, 3.5, 7.0, 30.0] {
                for i in 0..=200 {
                    let c = i as f64 / 200.0;
                    let [s, p] = reference(c, n, k);
                    let got = conductor_polarised(c as f32, n as f32, k as f32);
                    let a = conductor_amplitudes(c as f32, n as f32, k as f32);
                    let abs2 = |z: [f32; 2]| (z[0] * z[0] + z[1] * z[1]) as f64;
                    for (want, got) in
                        [(s, got[0] as f64), (p, got[1] as f64), (s, abs2(a.s)), (p, abs2(a.p))]
                    {
                        worst = worst.max((want - got).abs());
                    }
                }
            }
        }
        println!("conductor: largest error {worst:.2e}");
        assert!(worst < 2e-6);
    }

    #[test]
    fn without_absorption_it_is_the_dielectric() {
        for eta in [0.5, 0.75, 1.0, 1.33, 1.5, 2.4] {
            for i in 1..=100 {
                let c = i as f32 / 100.0;
                let (a, b) = (conductor(c, eta, 0.0), dielectric(c, eta));
                assert!((a - b).abs() < 3e-6, "η {eta} cos {c}: {a} {b}");
            }
        }
        // Beyond the critical angle the amplitudes turn, at full length.
        let a = conductor_amplitudes(0.3, 1.0 / 1.5, 0.0);
        let length = |z: [f32; 2]| z[0] * z[0] + z[1] * z[1];
        assert!((length(a.s) - 1.0).abs() < 1e-6 && (length(a.p) - 1.0).abs() < 1e-6 && a.s[1].abs() > 0.1);
    }

    #[test]
    fn phases_have_the_stated_signs() {
        let a = conductor_amplitudes(1.0, 0.2, 3.4);
        assert!((a.s[0] + a.p[0]).abs() < 1e-6 && (a.s[1] + a.p[1]).abs() < 1e-6, "{a:?}");
        // (1 − N) / (1 + N) for N = 0.2 + 3.4i: ((1 − n² − k²) − 2ik) / ((1 + n)² + k²).
        let d = 1.2 * 1.2 + 3.4 * 3.4;
        let want = [(1.0 - 0.2 * 0.2 - 3.4 * 3.4) / d, -2.0 * 3.4 / d];
        assert!((a.s[0] - want[0]).abs() < 1e-6 && (a.s[1] - want[1]).abs() < 1e-6, "{a:?} {want:?}");
    }

    #[test]
    fn k_meets_f0() {
        for eta in [0.05, 0.2, 1.0, 3.0] {
            for f0 in [0.3, 0.5, 0.9, 0.99] {
                let k = k_from_f0(eta, f0);
                if k > 0.0 {
                    assert!((conductor(1.0, eta, k) - f0).abs() < 1e-5, "{eta} {f0}: {k}");
                } else {
                    assert!(conductor(1.0, eta, 0.0) >= f0);
                }
            }
        }
        assert!(k_from_f0(0.2, 1.0) == LARGEST_K && k_from_f0(f32::NAN, f32::NAN).is_finite());
    }

    #[test]
    fn any_input_is_bounded() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-30, 0.5, 1.0, 1e4, 1e30];
        for c in odd {
            for eta in odd {
                for k in odd {
                    let r = conductor(c, eta, k);
                    assert!((0.0..=1.0).contains(&r), "{c} {eta} {k}: {r}");
                    let a = conductor_amplitudes(c, eta, k);
                    let all = [a.s[0], a.s[1], a.p[0], a.p[1]];
                    assert!(all.iter().all(|v| v.abs() <= 1.0 + 1e-6), "{c} {eta} {k}: {a:?}");
                }
            }
        }
    }
}
