//! How much of the light the sheen lobe takes, as a table.
//!
//! Two functions of cos θ and roughness, by quadrature, over ⁴√cos θ and [`row_roughness`]: E, the directional albedo of white
//! fibres, and the albedo that the lobe would have as its formulas stand, which passes one. Each row ends with their
//! averages ∫ · 2µ dµ. `cargo run --release -p etendue-bxdf --example sheen_table` writes it anew; a test holds it against
//! the integral.

use super::charlie::LEAST_ROUGHNESS;

/// Columns: values at cos θ = (i / (COLUMNS − 1))⁴: dense where masking changes fast.
pub const COLUMNS: usize = 64;
/// Rows: values at [`row_roughness`].
pub const ROWS: usize = 41;
/// The largest literal albedo that the table can hold.
pub const LARGEST: f32 = 8.0;
/// Pairs per row: the columns and the average.
const STRIDE: usize = COLUMNS + 1;

/// The roughness of a row: LEAST_ROUGHNESS .. 1, dense at the lower end where the lobe changes fast.
pub fn row_roughness(row: usize) -> f64 {
    let t = row as f64 / (ROWS - 1) as f64;
    LEAST_ROUGHNESS as f64 + (1.0 - LEAST_ROUGHNESS as f64) * t * t
}

/// The table's file: rows of pairs, each a little-endian 16-bit fraction of 65535: E, and the literal albedo over [`LARGEST`].
static BYTES: &[u8; ROWS * STRIDE * 4] = include_bytes!("charlie_table.bin");

/// The table as numbers, unpacked by the compiler.
static TABLE: [[f32; 2]; ROWS * STRIDE] = unpack();

const fn unpack() -> [[f32; 2]; ROWS * STRIDE] {
    let mut out = [[0.0; 2]; ROWS * STRIDE];
    let mut i = 0;
    while i < out.len() {
        let at = 4 * i;
        out[i][0] = (BYTES[at] as u32 + 256 * BYTES[at + 1] as u32) as f32 / 65535.0;
        out[i][1] = (BYTES[at + 2] as u32 + 256 * BYTES[at + 3] as u32) as f32 * (LARGEST / 65535.0);
        i += 1;
    }
    out
}

/// The table at one roughness: found once for a closure, then asked for angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheenRow {
    first: u32,
    fraction: f32,
}

impl SheenRow {
    /// The row of a perceptual roughness, clamped to [`LEAST_ROUGHNESS`]..1 (NaN as the least).
    #[inline]
    pub fn new(roughness: f32) -> Self {
        let r = roughness.max(LEAST_ROUGHNESS).min(1.0);
        let x = ((r - LEAST_ROUGHNESS) * (1.0 / (1.0 - LEAST_ROUGHNESS))).sqrt() * (ROWS - 1) as f32;
        let j = (x as usize).min(ROWS - 2);
        Self { first: (j * STRIDE) as u32, fraction: x - j as f32 }
    }

    #[inline(always)]
    fn at<const K: usize>(&self, cos: f32) -> f32 {
        let x = cos.max(0.0).min(1.0).sqrt().sqrt() * (COLUMNS - 1) as f32;
        let i = (x as usize).min(COLUMNS - 2);
        let t = x - i as f32;
        let at = self.first as usize + i;
        let (p, q) = (TABLE[at][K], TABLE[at + 1][K]);
        let (r, s) = (TABLE[at + STRIDE][K], TABLE[at + STRIDE + 1][K]);
        let (low, high) = (p + (q - p) * t, r + (s - r) * t);
        low + (high - low) * self.fraction
    }

    /// E at an angle of cosine `cos`, clamped to 0..1: the part of the light from there that white fibres reflect, 0..1.
    #[inline]
    pub fn directional(&self, cos: f32) -> f32 {
        self.at::<0>(cos)
    }

    /// The albedo of the literal lobe, which may pass 1.
    #[inline]
    pub fn literal(&self, cos: f32) -> f32 {
        self.at::<1>(cos)
    }

    /// ∫ E 2µ dµ: the part of an evenly lit surface's light that white fibres reflect.
    #[inline]
    pub fn average(&self) -> f32 {
        let at = self.first as usize + COLUMNS;
        TABLE[at][0] + (TABLE[at + STRIDE][0] - TABLE[at][0]) * self.fraction
    }

    /// What sheen of the largest colour lane `color` (0..1) leaves for the layers below of light between two directions
    /// of these cosines: min(1 − color · E(cos_o), 1 − color · E(cos_i)), `KHR_materials_sheen`'s symmetric form.
    #[inline]
    pub fn below(&self, color: f32, cos_o: f32, cos_i: f32) -> f32 {
        self.below_view(color, cos_o).min(self.below_view(color, cos_i))
    }

    /// The same by the view's direction alone: 1 − color · E(cos_o), the form that the extension offers for rasterisers. It bounds the
    /// symmetric one from above.
    #[inline]
    pub fn below_view(&self, color: f32, cos_o: f32) -> f32 {
        1.0 - color.max(0.0).min(1.0) * self.directional(cos_o)
    }
}
