//! One wavelength and one film, exactly: Airy's sum over all bounces, for both polarisations.

use crate::math::{exp, sin_cos_tau};

/// A complex number, as far as a film needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Complex {
    pub re: f32,
    pub im: f32,
}

impl Complex {
    #[inline(always)]
    pub fn new(re: f32, im: f32) -> Self {
        Self { re, im }
    }
    #[inline(always)]
    pub fn add(self, o: Self) -> Self {
        Self::new(self.re + o.re, self.im + o.im)
    }
    #[inline(always)]
    pub fn sub(self, o: Self) -> Self {
        Self::new(self.re - o.re, self.im - o.im)
    }
    #[inline(always)]
    pub fn mul(self, o: Self) -> Self {
        Self::new(self.re * o.re - self.im * o.im, self.re * o.im + self.im * o.re)
    }
    #[inline(always)]
    pub fn scale(self, s: f32) -> Self {
        Self::new(self.re * s, self.im * s)
    }
    #[inline(always)]
    pub fn norm2(self) -> f32 {
        self.re * self.re + self.im * self.im
    }
    #[inline(always)]
    pub fn div(self, o: Self) -> Self {
        Self::new(self.re * o.re + self.im * o.im, self.im * o.re - self.re * o.im).scale(1.0 / o.norm2())
    }
    /// The root in the first quadrant, for numbers with im ≥ 0.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let length = self.norm2().sqrt();
        // The larger part by a sum, the smaller from their product, which is im / 2: no digits are lost.
        let large = (0.5 * (length + self.re.abs())).sqrt();
        let small = if large > 0.0 { 0.5 * self.im / large } else { 0.0 };
        if self.re >= 0.0 { Self::new(large, small) } else { Self::new(small, large) }
    }
}

/// The stack of media that light meets: outside, film, base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stack {
    /// Index of refraction outside, > 0.
    pub outside: f32,
    /// Index of refraction of the film, > 0.
    pub film: f32,
    /// Real index of the base, ≥ 0.
    pub base: f32,
    /// Extinction coefficient of the base, ≥ 0; 0 for dielectrics.
    pub base_k: f32,
}

/// Amplitudes of reflection at both faces of the film, [s, p], and the film's normal component of the wave vector.
pub(crate) struct Amplitudes {
    pub outer: [Complex; 2],
    pub inner: [Complex; 2],
    /// n cos θ in the film: real, or imaginary beyond the critical angle.
    pub film_cos: Complex,
}

impl Stack {
    /// Fresnel's amplitudes at an angle of cosine `cos` outside; s first, then p.
    #[inline(always)]
    pub(crate) fn amplitudes(&self, cos: f32) -> Amplitudes {
        let sin2 = self.outside * self.outside * ((1.0 - cos) * (1.0 + cos));
        let (e1, e2) = (self.outside * self.outside, self.film * self.film);
        let e3 = Complex::new(
            (self.base - self.base_k) * (self.base + self.base_k),
            2.0 * self.base * self.base_k,
        );
        let q1 = Complex::new(self.outside * cos, 0.0);
        let q2 = Complex::new(e2 - sin2, 0.0).sqrt();
        let q3 = Complex::new(e3.re - sin2, e3.im).sqrt();
        let ratio = |a: Complex, b: Complex| a.sub(b).div(a.add(b));
        Amplitudes {
            outer: [ratio(q1, q2), ratio(q1.scale(e2), q2.scale(e1))],
            inner: [ratio(q2, q3), ratio(e3.mul(q2), q3.scale(e2))],
            film_cos: q2,
        }
    }

    /// Unpolarised reflectance of the film on its base, 0..1, at an angle of cosine `cos` (0..1) for one wavelength;
    /// `thickness` and `wavelength` in the same unit, > 0.
    ///
    /// R = ½ Σ |(r₁₂ + r₂₃ e^{iδ}) / (1 + r₁₂ r₂₃ e^{iδ})|² over s and p, δ = 4π n₂ d cos θ₂ / λ (Airy 1833; Born, Wolf,
    /// "Principles of Optics" 7th ed., section 1.6.4, eq. 57). Light that only tunnels through the film is in it. What is not a number gives 1.
    #[inline]
    pub fn reflectance(&self, cos: f32, thickness: f32, wavelength: f32) -> f32 {
        let a = self.amplitudes(cos.max(0.0).min(1.0));
        let path = 2.0 * thickness / wavelength;
        let (sin, cos) = sin_cos_tau(path * a.film_cos.re);
        let decay = exp(-(core::f32::consts::TAU * path * a.film_cos.im));
        let turn = Complex::new(cos * decay, sin * decay);
        let mut sum = 0.0;
        for (outer, inner) in a.outer.into_iter().zip(a.inner) {
            let back = inner.mul(turn);
            let one = Complex::new(1.0, 0.0);
            sum += outer.add(back).norm2() / one.add(outer.mul(back)).norm2();
        }
        let r = 0.5 * sum;
        // Also taken by NaN.
        if r < 1.0 { r.max(0.0) } else { 1.0 }
    }
}
