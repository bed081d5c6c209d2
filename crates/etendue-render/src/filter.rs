//! Pixel filters, by importance sampling.
//!
//! A sample's place in the picture is drawn from the filter itself, so that every sample counts for its pixel with weight
//! 1 and belongs to no other (Ernst, Stamminger, Greiner 2006, "Filter Importance Sampling"). So pixels stay independent,
//! which makes tiles, crops and merges exact.

use std::fmt;
use std::str::FromStr;

/// The shape of a pixel. All are non-negative and separable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// One pixel wide: the mean over the pixel's square.
    Box,
    /// σ = ½ pixel, cut at ±1.5 pixels.
    Gaussian,
    /// The four-term Blackman-Harris window, ±1.5 pixels wide: sharp, without ringing.
    #[default]
    BlackmanHarris,
}

impl Filter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::Box, Self::Gaussian, Self::BlackmanHarris];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Gaussian => "gaussian",
            Self::BlackmanHarris => "blackman-harris",
        }
    }

    /// Half the filter's width, pixels.
    pub fn radius(self) -> f32 {
        if self == Self::Box { 0.5 } else { 1.5 }
    }

    /// The filter's value at distance `x` pixels from the centre, along one axis; not normalised.
    pub fn value(self, x: f32) -> f32 {
        let r = self.radius();
        if x.abs() > r {
            return 0.0;
        }
        match self {
            Self::Box => 1.0,
            Self::Gaussian => (-2.0 * x * x).exp() - (-2.0 * r * r).exp(),
            Self::BlackmanHarris => {
                // Harris 1978, "On the use of windows for harmonic analysis", the minimum four-term window.
                let t = std::f32::consts::TAU * (x / r * 0.5 + 0.5);
                0.35875 - 0.48829 * t.cos() + 0.14128 * (2.0 * t).cos() - 0.01168 * (3.0 * t).cos()
            }
        }
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Filter {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|f| f.name() == s)
            .ok_or_else(|| format!("no filter is called {s:?}; there are box, gaussian, blackman-harris"))
    }
}

const STEPS: usize = 1024;

/// The inverse of a filter's cumulative distribution, tabulated.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    inverse: Vec<f32>,
}

impl FilterSampler {
    /// Integrates `filter` and inverts the integral at equal steps.
    pub fn new(filter: Filter) -> Self {
        const FINE: usize = 1 << 16;
        let r = f64::from(filter.radius());
        let at = |i: usize| -r + 2.0 * r * i as f64 / FINE as f64;
        let mut cdf = vec![0.0f64; FINE + 1];
        for i in 0..FINE {
            cdf[i + 1] = cdf[i] + f64::from(filter.value(((at(i) + at(i + 1)) * 0.5) as f32)).max(0.0);
        }
        let total = cdf[FINE];
        let mut inverse = Vec::with_capacity(STEPS + 1);
        let mut k = 0;
        for j in 0..=STEPS {
            let q = total * j as f64 / STEPS as f64;
            while k + 1 < FINE && cdf[k + 1] < q {
                k += 1;
            }
            let f = if cdf[k + 1] > cdf[k] { (q - cdf[k]) / (cdf[k + 1] - cdf[k]) } else { 0.0 };
            inverse.push((at(k) + f.clamp(0.0, 1.0) * 2.0 * r / FINE as f64) as f32);
        }
        Self { inverse }
    }

    /// Distance from the pixel's centre along one axis, pixels, for `u` in [0, 1).
    #[inline(always)]
    pub fn sample(&self, u: f32) -> f32 {
        let x = u * STEPS as f32;
        let i = (x as usize).min(STEPS - 1);
        let f = x - i as f32;
        self.inverse[i] * (1.0 - f) + self.inverse[i + 1] * f
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The drawn offsets have the filter's own variance (quadrature beside the sampler), and no bias.
    #[test]
    fn samples_follow_the_filter() {
        for filter in Filter::ALL {
            let s = FilterSampler::new(filter);
            let n = 100_000;
            let (mut mean, mut var) = (0.0f64, 0.0f64);
            for i in 0..n {
                let x = f64::from(s.sample((i as f32 + 0.5) / n as f32));
                assert!(x.abs() <= f64::from(filter.radius()) + 1e-5);
                mean += x / n as f64;
                var += x * x / n as f64;
            }
            let (mut w, mut m2) = (0.0f64, 0.0f64);
            for i in 0..n {
                let x = ((i as f32 + 0.5) / n as f32 * 2.0 - 1.0) * filter.radius();
                w += f64::from(filter.value(x));
                m2 += f64::from(filter.value(x) * x * x);
            }
            assert!(mean.abs() < 1e-4, "{filter}: mean {mean}");
            assert!((var - m2 / w).abs() < 4e-3 * (m2 / w), "{filter}: variance {var}, filter {}", m2 / w);
        }
    }

    #[test]
    fn names_round_trip() {
        for f in Filter::ALL {
            assert_eq!(f.name().parse(), Ok(f));
        }
        assert!("lanczos".parse::<Filter>().is_err());
    }
}
