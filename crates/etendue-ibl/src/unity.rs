//! The seven vectors that Unity's `ShadeSH9` reads.
//!
//! Unity evaluates irradiance over π (a white sky gives 1) as
//!
//! ```text
//! ShadeSH9(n) = A·(n, 1) + B·(nx ny, ny nz, nz nz, nz nx) + C (nx² − ny²)      (UnityCG.cginc, one A and B per colour)
//! ```
//!
//! so A, B and C are the coefficients with basis constants and A_l / π multiplied in, and Y20's −1 moved into A's last
//! component (Sloan 2008, "Stupid Spherical Harmonics Tricks", appendix A10). The notes' shader divides this by π once more; see
//! the real-time preset that does it too.

use crate::sh::{COSINE, K, Sh9};
use glam::Vec3;
use serde::Serialize;
use std::f64::consts::PI;

/// Unity's coefficients, under Unity's names.
#[allow(non_snake_case)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnitySh {
    /// Constant and linear terms of red: factors of x, y, z, 1.
    pub unity_SHAr: [f32; 4],
    /// The same of green.
    pub unity_SHAg: [f32; 4],
    /// The same of blue.
    pub unity_SHAb: [f32; 4],
    /// Quadratic terms of red: factors of xy, yz, zz, zx.
    pub unity_SHBr: [f32; 4],
    /// The same of green.
    pub unity_SHBg: [f32; 4],
    /// The same of blue.
    pub unity_SHBb: [f32; 4],
    /// Factor of x² − y² for red, green, blue; the last is 1, as Unity sets it.
    pub unity_SHC: [f32; 4],
}

impl UnitySh {
    /// Packs coefficients of radiance, in the frame that they are in. Unity's world is left-handed: for normals in Unity's frame
    /// pack [`Sh9::mirror_z`] of a sky in the house's frame.
    pub fn new(sh: &Sh9) -> Self {
        let [a0, a1, a2] = COSINE.map(|a| a / PI);
        let c = |i: usize, lane: usize| f64::from(sh.0[i][lane]);
        let a = |l: usize| {
            let k = a1 * K[1];
            [k * c(3, l), k * c(1, l), k * c(2, l), a0 * K[0] * c(0, l) - a2 * K[3] * c(6, l)]
                .map(|v| v as f32)
        };
        let b = |l: usize| {
            let k = a2 * K[2];
            [k * c(4, l), k * c(5, l), 3.0 * a2 * K[3] * c(6, l), k * c(7, l)].map(|v| v as f32)
        };
        let d = |l: usize| (a2 * K[4] * c(8, l)) as f32;
        Self {
            unity_SHAr: a(0),
            unity_SHAg: a(1),
            unity_SHAb: a(2),
            unity_SHBr: b(0),
            unity_SHBg: b(1),
            unity_SHBb: b(2),
            unity_SHC: [d(0), d(1), d(2), 1.0],
        }
    }

    /// What `ShadeSH9(float4(n, 1))` returns: irradiance over π.
    pub fn shade(&self, n: Vec3) -> [f32; 3] {
        let dot = |v: &[f32; 4], x: [f32; 4]| v[0] * x[0] + v[1] * x[1] + v[2] * x[2] + v[3] * x[3];
        let linear = [n.x, n.y, n.z, 1.0];
        let square = [n.x * n.y, n.y * n.z, n.z * n.z, n.z * n.x];
        let c = n.x * n.x - n.y * n.y;
        [
            dot(&self.unity_SHAr, linear) + dot(&self.unity_SHBr, square) + self.unity_SHC[0] * c,
            dot(&self.unity_SHAg, linear) + dot(&self.unity_SHBg, square) + self.unity_SHC[1] * c,
            dot(&self.unity_SHAb, linear) + dot(&self.unity_SHBb, square) + self.unity_SHC[2] * c,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_color::Spectrum;

    #[test]
    fn shade_is_irradiance_over_pi() {
        let sh = Sh9(std::array::from_fn(|i| {
            Spectrum::rgb(1.0 / (i as f32 + 1.0), (i as f32).sin(), 0.1 * i as f32 - 0.3)
        }));
        let unity = UnitySh::new(&sh);
        for n in [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::new(0.48, 0.6, -0.64), Vec3::new(-0.8, 0.0, 0.6)] {
            let want = sh.irradiance(n) * std::f32::consts::FRAC_1_PI;
            for (a, b) in unity.shade(n).iter().zip(want.to_rgb()) {
                assert!((a - b).abs() < 1e-6, "{n}: {a} {b}");
            }
        }
    }
}
