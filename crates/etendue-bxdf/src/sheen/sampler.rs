//! How the sheen lobe is sampled: a transformed cosine with a small even part.
//!
//! Estevez, Kulla 2017 found sampling by D worse than an even hemisphere, which this replaces by a lobe that follows f cos θi:
//! a clamped cosine under a linear transform (Heitz, Dupuy, Hill, Neubelt 2016, "Real-Time Polygonal-Light Shading with
//! Linearly Transformed Cosines"),
//!
//! ```text
//!       | a  0  b |
//! M⁻¹ = | 0  c  0 |   in the frame whose x axis lies under wo,   pdf = a c wi.z / (π |M⁻¹ wi|⁴)
//!       | 0  0  1 |
//! ```
//!
//! with a, b, c fitted per angle and roughness for the least variance of weights (`cargo run --release -p etendue-bxdf
//! --example sheen_sampling` writes the table), and one sample in ten even over the hemisphere, which bounds the weights.

use super::charlie::LEAST_ROUGHNESS;
use crate::sampling::{cosine_hemisphere, uniform_hemisphere};
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::{Vec3A, vec3a};

/// Columns: values at [`column_cos`].
pub const COLUMNS: usize = 24;
/// Rows: values at [`row_roughness`].
pub const ROWS: usize = 24;
/// Share of the even part.
const EVEN: f32 = 0.1;
/// a and c lie in LEAST..LARGEST, b in ±LARGEST.
const LEAST: f32 = 0.02;
const LARGEST: f32 = 4.0;

/// The roughness of a row: LEAST_ROUGHNESS .. 1, dense at the lower end.
pub fn row_roughness(row: usize) -> f32 {
    let t = row as f32 / (ROWS - 1) as f32;
    LEAST_ROUGHNESS + (1.0 - LEAST_ROUGHNESS) * t * t
}

/// The cosine of a column: dense towards grazing.
pub fn column_cos(column: usize) -> f32 {
    let t = column as f32 / (COLUMNS - 1) as f32;
    (t * t) * (t * t)
}

/// The table's file: a / LARGEST, b / (2 LARGEST) + ½, c / LARGEST, each a little-endian 16-bit fraction of 65535.
static BYTES: &[u8; ROWS * COLUMNS * 6] = include_bytes!("charlie_sampling.bin");

/// The table as numbers, unpacked by the compiler.
static TABLE: [[f32; 3]; ROWS * COLUMNS] = unpack();

const fn unpack() -> [[f32; 3]; ROWS * COLUMNS] {
    let mut out = [[0.0; 3]; ROWS * COLUMNS];
    let mut i = 0;
    while i < out.len() {
        let mut k = 0;
        while k < 3 {
            let at = 6 * i + 2 * k;
            out[i][k] = (BYTES[at] as u32 + 256 * BYTES[at + 1] as u32) as f32 / 65535.0 * LARGEST;
            k += 1;
        }
        out[i][1] = 2.0 * out[i][1] - LARGEST;
        i += 1;
    }
    out
}

/// A lobe as the table holds it.
pub fn pack(lobe: &Lobe) -> [u8; 6] {
    let code = |v: f32| ((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes();
    let [a, b] = code(lobe.a / LARGEST);
    let [c, d] = code(lobe.b / (2.0 * LARGEST) + 0.5);
    let [e, f] = code(lobe.c / LARGEST);
    [a, b, c, d, e, f]
}

/// The density for one `wo`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// M⁻¹'s stretch along the plane of incidence.
    pub a: f32,
    /// Its shear.
    pub b: f32,
    /// Its stretch across.
    pub c: f32,
    /// Cosine and sine of the azimuth of `wo`.
    pub x: [f32; 2],
}

impl Lobe {
    /// The lobe with parameters that the table can hold.
    pub fn clamped(self) -> Self {
        Self {
            a: self.a.clamp(LEAST, LARGEST),
            b: self.b.clamp(-LARGEST, LARGEST),
            c: self.c.clamp(LEAST, LARGEST),
            ..self
        }
    }

    /// Density, per steradian, of a direction above the surface.
    #[inline(always)]
    pub fn pdf(&self, wi: Vec3A) -> f32 {
        let x = self.x[0] * wi.x + self.x[1] * wi.y;
        let y = self.x[0] * wi.y - self.x[1] * wi.x;
        let t = vec3a(self.a * x + self.b * wi.z, self.c * y, wi.z);
        let len2 = t.length_squared();
        EVEN / TAU + (1.0 - EVEN) * FRAC_1_PI * self.a * self.c * wi.z / (len2 * len2)
    }

    /// A direction of the upper hemisphere.
    #[inline(always)]
    fn sample(&self, uc: f32, u: [f32; 2]) -> Vec3A {
        if uc < EVEN {
            return uniform_hemisphere(u);
        }
        let h = cosine_hemisphere(u);
        // M times a c, which is one direction with M.
        let w = vec3a(self.c * (h.x - self.b * h.z), self.a * h.y, self.a * self.c * h.z);
        let w = w * (1.0 / w.length_squared().sqrt());
        vec3a(self.x[0] * w.x - self.x[1] * w.y, self.x[1] * w.x + self.x[0] * w.y, w.z)
    }
}

/// The density for one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampler {
    first: u32,
    fraction: f32,
}

impl Sampler {
    #[inline]
    pub(super) fn new(roughness: f32) -> Self {
        let r = roughness.max(LEAST_ROUGHNESS).min(1.0);
        let x = ((r - LEAST_ROUGHNESS) * (1.0 / (1.0 - LEAST_ROUGHNESS))).sqrt() * (ROWS - 1) as f32;
        let j = (x as usize).min(ROWS - 2);
        Self { first: (j * COLUMNS) as u32, fraction: x - j as f32 }
    }

    #[inline(always)]
    fn lobe(&self, wo: Vec3A) -> Lobe {
        let x = wo.z.max(0.0).min(1.0).sqrt().sqrt() * (COLUMNS - 1) as f32;
        let i = (x as usize).min(COLUMNS - 2);
        let t = x - i as f32;
        let at = self.first as usize + i;
        let [a, b, c] = core::array::from_fn(|k| {
            let (p, q) = (TABLE[at][k], TABLE[at + 1][k]);
            let (r, s) = (TABLE[at + COLUMNS][k], TABLE[at + COLUMNS + 1][k]);
            let (low, high) = (p + (q - p) * t, r + (s - r) * t);
            low + (high - low) * self.fraction
        });
        let len2 = wo.x * wo.x + wo.y * wo.y;
        let x = if len2 > 0.0 {
            let inv = 1.0 / len2.sqrt();
            [wo.x * inv, wo.y * inv]
        } else {
            [1.0, 0.0]
        };
        Lobe { a, b, c, x }
    }

    #[inline(always)]
    pub(super) fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        self.lobe(wo).pdf(wi)
    }

    #[inline(always)]
    pub(super) fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Vec3A {
        self.lobe(wo).sample(uc, u)
    }
}
