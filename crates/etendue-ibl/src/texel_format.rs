//! What a texel of light becomes in a file.

use crate::bc6h;
use crate::cube::CubeMap;
use etendue_color::Spectrum;
use half::f16;
use rayon::prelude::*;
use std::fmt;
use std::str::FromStr;

/// An encoding of light for textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TexelFormat {
    /// Four half floats, alpha 1: 8 bytes per texel; up to 65504.
    #[default]
    Rgba16f,
    /// Nine bits for each colour and a common exponent: 4 bytes per texel; up to 65408.
    Rgb9e5,
    /// Blocks of 4 × 4 texels in 16 bytes (BPTC unsigned float): 1 byte per texel; up to 65504.
    Bc6h,
}

impl TexelFormat {
    /// Width and height of a block, in texels.
    pub fn block(self) -> u32 {
        if self == Self::Bc6h { 4 } else { 1 }
    }

    /// Bytes of a block.
    pub fn block_bytes(self) -> usize {
        match self {
            Self::Rgba16f => 8,
            Self::Rgb9e5 => 4,
            Self::Bc6h => 16,
        }
    }

    /// The number of Vulkan's format, as KTX2 stores it.
    pub fn vulkan(self) -> u32 {
        match self {
            Self::Rgba16f => 97, // VK_FORMAT_R16G16B16A16_SFLOAT
            Self::Rgb9e5 => 123, // VK_FORMAT_E5B9G9R9_UFLOAT_PACK32
            Self::Bc6h => 143,   // VK_FORMAT_BC6H_UFLOAT_BLOCK
        }
    }

    /// The number of DXGI's format, as DDS stores it.
    pub fn dxgi(self) -> u32 {
        match self {
            Self::Rgba16f => 10, // DXGI_FORMAT_R16G16B16A16_FLOAT
            Self::Rgb9e5 => 67,  // DXGI_FORMAT_R9G9B9E5_SHAREDEXP
            Self::Bc6h => 95,    // DXGI_FORMAT_BC6H_UF16
        }
    }

    /// The bytes of one face of one mip, rows from the top; what is brighter than the format can say becomes its brightest.
    pub fn encode(self, cube: &CubeMap, mip: usize, face: usize) -> Vec<u8> {
        let (n, texels) = (cube.mip_size(mip) as usize, cube.face(mip, face));
        match self {
            Self::Rgba16f => texels
                .iter()
                .flat_map(|l| {
                    let [r, g, b] = l.to_rgb().map(to_half);
                    [r, g, b, f16::ONE].map(|h| h.to_bits().to_le_bytes()).concat()
                })
                .collect(),
            Self::Rgb9e5 => texels.iter().flat_map(|l| to_rgb9e5(l.to_rgb()).to_le_bytes()).collect(),
            Self::Bc6h => {
                let blocks = n.div_ceil(4);
                (0..blocks * blocks)
                    .into_par_iter()
                    .flat_map_iter(|i| {
                        // A mip smaller than a block repeats its last row and column.
                        let texel = |k: usize| {
                            let (x, y) = (i % blocks * 4 + k % 4, i / blocks * 4 + k / 4);
                            texels[y.min(n - 1) * n + x.min(n - 1)].to_rgb().map(|v| to_half(v).to_bits())
                        };
                        bc6h::encode(&std::array::from_fn(texel))
                    })
                    .collect()
            }
        }
    }

    /// The texels of one face of `n`² that [`TexelFormat::encode`] wrote; `None` if the bytes are too few.
    pub fn decode(self, bytes: &[u8], n: usize) -> Option<Vec<Spectrum>> {
        let blocks = n.div_ceil(self.block() as usize);
        let bytes = bytes.get(..blocks * blocks * self.block_bytes())?;
        let half = |b: &[u8]| f16::from_le_bytes([b[0], b[1]]).to_f32();
        Some(match self {
            Self::Rgba16f => {
                bytes.chunks_exact(8).map(|b| Spectrum::rgb(half(b), half(&b[2..]), half(&b[4..]))).collect()
            }
            Self::Rgb9e5 => bytes
                .chunks_exact(4)
                .map(|b| Spectrum::from_rgb(from_rgb9e5(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))))
                .collect(),
            Self::Bc6h => {
                let mut out = vec![Spectrum::ZERO; n * n];
                for (i, block) in bytes.chunks_exact(16).enumerate() {
                    let mut b = [0; 16];
                    b.copy_from_slice(block);
                    for (k, t) in bc6h::decode(&b)?.iter().enumerate() {
                        let (x, y) = (i % blocks * 4 + k % 4, i / blocks * 4 + k / 4);
                        if x < n && y < n {
                            out[y * n + x] = Spectrum::from_rgb(t.map(|h| f16::from_bits(h).to_f32()));
                        }
                    }
                }
                out
            }
        })
    }
}

impl fmt::Display for TexelFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rgba16f => "rgba16f",
            Self::Rgb9e5 => "rgb9e5",
            Self::Bc6h => "bc6h",
        })
    }
}

impl FromStr for TexelFormat {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "rgba16f" => Ok(Self::Rgba16f),
            "rgb9e5" => Ok(Self::Rgb9e5),
            "bc6h" => Ok(Self::Bc6h),
            _ => Err("give rgba16f, rgb9e5 or bc6h".into()),
        }
    }
}

/// The nearest half float, 0..65504; NaN and what is negative become 0.
fn to_half(v: f32) -> f16 {
    f16::from_f32(v.max(0.0).min(65504.0))
}

/// Packs three colours under one exponent (Khronos, "EXT_texture_shared_exponent", section 3.8.x): N = 9 bits, bias 15.
fn to_rgb9e5(c: [f32; 3]) -> u32 {
    let c = c.map(|v| v.max(0.0).min(65408.0));
    let peak = c[0].max(c[1]).max(c[2]);
    // ⌊log2 peak⌋ from the bits, −16 at least (what is smaller shares exponent 0).
    let log = (peak.to_bits() >> 23) as i32 - 127;
    let mut exponent = log.max(-16) + 1 + 15;
    let scale = |e: i32| f32::exp2((24 - e) as f32);
    if (peak * scale(exponent)).round() >= 512.0 {
        exponent += 1;
    }
    let m = c.map(|v| (v * scale(exponent)).round() as u32);
    m[0] | m[1] << 9 | m[2] << 18 | (exponent as u32) << 27
}

fn from_rgb9e5(v: u32) -> [f32; 3] {
    let scale = f32::exp2((v >> 27) as f32 - 24.0);
    [v, v >> 9, v >> 18].map(|m| (m & 511) as f32 * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;

    #[test]
    fn shared_exponent_is_within_half_a_step() {
        let mut rng = Rng::new(1);
        for i in 0..20_000 {
            let bright = f32::exp2(34.0 * rng.uniform() - 18.0);
            let c = [bright * rng.uniform(), bright * rng.uniform(), bright];
            let c = if i % 7 == 0 { [c[0], bright * (1.0 - 1e-4), bright] } else { c };
            let got = from_rgb9e5(to_rgb9e5(c));
            // A step is 2⁻⁹ of the power of two above the peak: half a step is at most 2⁻⁹ of the peak itself.
            let step = (bright / 512.0).max(f32::exp2(-25.0));
            for k in 0..3 {
                assert!((got[k] - c[k].min(65408.0)).abs() <= step * 1.0001, "{c:?} {got:?}");
            }
        }
        assert_eq!(from_rgb9e5(to_rgb9e5([1.0, 0.5, 0.0])), [1.0, 0.5, 0.0]);
        assert_eq!(from_rgb9e5(to_rgb9e5([f32::NAN, -1.0, 1e9])), [0.0, 0.0, 65408.0]);
        assert_eq!(to_rgb9e5([0.0; 3]) & 0x7ff_ffff, 0);
    }

    /// Each format gives back what it was given, within what it promises.
    #[test]
    fn faces_survive() {
        let mut rng = Rng::new(4);
        for n in [1u32, 2, 6, 8] {
            let texels = (0..6 * n * n).map(|_| {
                let v = 2.0 + 0.5 * rng.uniform();
                Spectrum::rgb(v, 0.5 * v, 0.25 * v)
            });
            let cube = CubeMap::new(n, texels.collect()).unwrap();
            for (format, tolerance) in
                [(TexelFormat::Rgba16f, 5e-4), (TexelFormat::Rgb9e5, 3e-3), (TexelFormat::Bc6h, 2e-2)]
            {
                for face in 0..6 {
                    let bytes = format.encode(&cube, 0, face);
                    let back = format.decode(&bytes, n as usize).unwrap();
                    for (a, b) in back.iter().zip(cube.face(0, face)) {
                        let error = (*a - *b).map(f32::abs).max_element();
                        assert!(error <= tolerance * b.max_element(), "{format} {n}: {a:?} {b:?}");
                    }
                }
            }
        }
    }
}
