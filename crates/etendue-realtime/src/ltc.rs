//! Linearly transformed cosines: the GGX lobe as a stretched, turned cosine lobe, whose light from a polygon has a closed form.
//!
//! Heitz, Dupuy, Hill, Neubelt 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines". With the lobe seen in the
//! plane of x and z, its mirror direction at an angle θ from z towards +x, the transform is
//!
//! ```text
//! M = R(θ + δ) · | m11  0   m13 |
//!                |  0  m22   0  |        D(l) = cos⁺(l') / π · |∂l'/∂l|,   l' = M⁻¹ l / |M⁻¹ l|
//!                |  0   0    1  |
//! ```
//!
//! The surface's horizon cuts off a part of D that a real lobe does not have. Here D is zero below it and divided by the part above,
//! which the transform keeps a cap of the cosine lobe: (1 + cos φ) / 2, φ the angle between Mᵀ z and z. (The paper leaves that part to
//! the fit, which near grazing then must give up the lobe's form.)
//!
//! The paper tabulates M⁻¹; here the turn by θ is exact, and only what is left, smooth in roughness and angle, is tabulated: m11 / α,
//! m22 / α, m13 / α and δ / α. The lobe's size is that of the albedo's table, so that energy is as everywhere else.
//!
//! The table is fitted to the reference's height-correlated Smith GGX: `cargo run --release -p etendue-realtime --example fit_ltc` writes
//! it anew, with the error of each row.

use etendue_bxdf::math::sin_cos_tau;
use glam::{Vec3A, vec3a};
use half::f16;
use std::f32::consts::{FRAC_1_PI, TAU};

/// Rows by roughness and columns by angle.
pub const SIZE: usize = 32;
/// The least perceptual roughness of the table.
pub const LEAST_ROUGHNESS: f32 = 0.04;

/// The table's file: rows of columns of four little-endian half floats.
static BYTES: &[u8; SIZE * SIZE * 8] = include_bytes!("ltc_table.bin");

/// The perceptual roughness of a row.
pub fn row_roughness(row: usize) -> f32 {
    LEAST_ROUGHNESS + (1.0 - LEAST_ROUGHNESS) * row as f32 / (SIZE - 1) as f32
}

/// The cosine of a column: 1 − (i / (SIZE − 1))², not below 0.01.
pub fn column_cos(column: usize) -> f32 {
    let x = column as f32 / (SIZE - 1) as f32;
    (1.0 - x * x).max(0.01)
}

/// What is left of a transform beside the turn to the mirror direction and the scale by α.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shape {
    /// m11 / α.
    pub m11: f32,
    /// m22 / α.
    pub m22: f32,
    /// m13 / α.
    pub m13: f32,
    /// δ / α, radians: how far beyond the mirror direction the lobe leans.
    pub lean: f32,
}

/// A transform at one roughness and angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ltc {
    m11: f32,
    m22: f32,
    m13: f32,
    /// Sine and cosine of θ + δ.
    turn: [f32; 2],
    /// One over the part above the surface's horizon.
    inv_above: f32,
}

impl Ltc {
    /// From a shape, an α and the cosine of the view's angle.
    pub fn new(shape: Shape, alpha: f32, cos: f32) -> Self {
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (s, c) = sin_cos_tau(shape.lean * alpha / TAU);
        let turn = [sin * c + cos * s, cos * c - sin * s];
        let (m11, m22, m13) =
            ((shape.m11 * alpha).max(1e-6), (shape.m22 * alpha).max(1e-6), shape.m13 * alpha);
        // The third row of M.
        let (x, z) = (-turn[0] * m11, turn[1] - turn[0] * m13);
        let above = 0.5 * (1.0 + z / (x * x + z * z).sqrt());
        Self { m11, m22, m13, turn, inv_above: 1.0 / above.max(1e-3) }
    }

    /// What the part of a cosine lobe above the straightened horizon is multiplied with, so that the whole hemisphere gives 1.
    #[inline]
    pub fn inv_above(&self) -> f32 {
        self.inv_above
    }

    /// M⁻¹ v, in the frame whose x points away from the viewer.
    #[inline]
    pub fn straighten(&self, v: Vec3A) -> Vec3A {
        let [s, c] = self.turn;
        let (x, z) = (v.x * c - v.z * s, v.x * s + v.z * c);
        vec3a((x - self.m13 * z) / self.m11, v.y / self.m22, z)
    }

    /// M v.
    #[inline]
    pub fn stretch(&self, v: Vec3A) -> Vec3A {
        let [s, c] = self.turn;
        let (x, z) = (self.m11 * v.x + self.m13 * v.z, v.z);
        vec3a(x * c + z * s, self.m22 * v.y, z * c - x * s)
    }

    /// D at a unit direction, 1/sr; its integral over the upper hemisphere is 1, below it is 0.
    #[inline]
    pub fn density(&self, l: Vec3A) -> f32 {
        if !(l.z > 0.0) {
            return 0.0;
        }
        let straight = self.straighten(l);
        let len2 = straight.length_squared();
        // |∂l'/∂l| = |det M⁻¹| / |M⁻¹ l|³.
        straight.z.max(0.0) * FRAC_1_PI * self.inv_above / (self.m11 * self.m22 * len2 * len2)
    }
}

/// The table.
#[derive(Clone, Debug, PartialEq)]
pub struct LtcTable(Vec<Shape>);

impl Default for LtcTable {
    fn default() -> Self {
        let number = |i: usize| f16::from_le_bytes([BYTES[2 * i], BYTES[2 * i + 1]]).to_f32();
        let shape = |i: usize| Shape {
            m11: number(4 * i),
            m22: number(4 * i + 1),
            m13: number(4 * i + 2),
            lean: number(4 * i + 3),
        };
        Self((0..SIZE * SIZE).map(shape).collect())
    }
}

impl LtcTable {
    /// The transform for a perceptual roughness and the cosine of the view's angle, both clamped to what the table has.
    #[inline]
    pub fn at(&self, roughness: f32, cos: f32) -> Ltc {
        let place = |x: f32| {
            let x = x.max(0.0).min(1.0) * (SIZE - 1) as f32;
            let i = (x as usize).min(SIZE - 2);
            (i, x - i as f32)
        };
        let (j, tj) = place((roughness - LEAST_ROUGHNESS) / (1.0 - LEAST_ROUGHNESS));
        let cos = cos.max(0.0).min(1.0);
        let (i, ti) = place((1.0 - cos).sqrt());
        let mix = |a: Shape, b: Shape, t: f32| Shape {
            m11: a.m11 + (b.m11 - a.m11) * t,
            m22: a.m22 + (b.m22 - a.m22) * t,
            m13: a.m13 + (b.m13 - a.m13) * t,
            lean: a.lean + (b.lean - a.lean) * t,
        };
        let row = |j: usize| mix(self.0[j * SIZE + i], self.0[j * SIZE + i + 1], ti);
        let r = roughness.max(LEAST_ROUGHNESS).min(1.0);
        Ltc::new(mix(row(j), row(j + 1), tj), r * r, cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::sampling::uniform_sphere;

    #[test]
    fn transforms_are_inverse_and_densities_integrate_to_one() {
        let table = LtcTable::default();
        for (roughness, cos) in [(0.3, 0.9), (0.6, 0.4), (1.0, 0.1), (0.8, 1.0)] {
            let ltc = table.at(roughness, cos);
            let (n, mut sum) = (1 << 16, 0.0f64);
            for i in 0..n {
                let u = [(i as f32 + 0.5) / n as f32, (f64::from(i) * 0.618_033_988_75).fract() as f32];
                let d = uniform_sphere(u);
                let there = ltc.stretch(ltc.straighten(d));
                assert!((there - d).length() < 1e-3);
                sum += f64::from(ltc.density(d));
            }
            let integral = sum * 4.0 * std::f64::consts::PI / f64::from(n);
            assert!((integral - 1.0).abs() < 0.01, "{roughness} {cos}: {integral}");
        }
    }
}
