//! The basic data format descriptor: what the bits of a texel mean (Khronos Data Format 1.3, section 5).

use super::F;
use crate::ImageError;

/// What texels are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Model {
    /// Samples of red, green, blue and alpha.
    Plain,
    Etc1s,
    Uastc,
    /// Blocks of light for graphics hardware.
    Bc6h,
}

/// A sample of a texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub bit: u32,
    pub bits: u32,
    /// Which channel, in the numbers of the model.
    pub channel: u8,
    pub float: bool,
    pub signed: bool,
    pub exponent: bool,
    /// What stands for 0 (or −1) and 1.
    pub lower: u32,
    pub upper: u32,
}

/// The descriptor.
pub(super) struct Descriptor {
    pub model: Model,
    pub srgb: bool,
    pub premultiplied: bool,
    /// Bytes of a texel of plain samples.
    pub texel_bytes: u32,
    pub samples: Vec<Sample>,
}

/// More samples than any descriptor has: no format needs more than 16, but a file may repeat some.
const MAX_SAMPLES: usize = 64;

impl Descriptor {
    pub fn read(bytes: &[u8]) -> Result<Self, ImageError> {
        let bad = |cause: &str| Err(ImageError::damaged(F, format!("the data format descriptor {cause}")));
        let Some(head) = bytes.get(..28) else { return bad("is cut off") };
        let word = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
        let [total, vendor, version, model, dimensions, planes] = [0, 4, 8, 12, 16, 20].map(word);
        let size = (version >> 16) as usize;
        if total as usize != bytes.len() || size < 24 || size > bytes.len() - 4 {
            return bad("has not the size that it says");
        }
        // Vendor 0 (Khronos), type 0 (basic).
        if vendor != 0 {
            return bad("is not the basic one");
        }
        let (samples, rest) = bytes[28..4 + size].as_chunks::<16>();
        if !rest.is_empty() || samples.is_empty() || samples.len() > MAX_SAMPLES {
            return bad("has an impossible number of samples");
        }
        let samples: Vec<Sample> = samples.iter().map(Sample::read).collect();
        let (kind, texel) = match model & 255 {
            1 => (Model::Plain, 0),
            133 => (Model::Bc6h, 0x0303),
            163 => (Model::Etc1s, 0x0303),
            166 => (Model::Uastc, 0x0303),
            n => return Err(ImageError::unsupported(F, format!("texels of {}", model_name(n)))),
        };
        if dimensions != texel {
            return Err(ImageError::unsupported(F, "blocks of texels of an unusual size"));
        }
        // The size may be left out under supercompression; then it is that of the samples.
        let end = samples.iter().map(|s| s.bit + s.bits).max().unwrap_or(0);
        let texel_bytes = match planes & 255 {
            0 => end.div_ceil(8),
            n => n,
        };
        if kind == Model::Plain && (end > 8 * texel_bytes || texel_bytes > 32) {
            return bad("has samples outside of the texel");
        }
        Ok(Self {
            model: kind,
            srgb: model >> 16 & 255 == 2,
            premultiplied: model >> 24 & 1 == 1,
            texel_bytes,
            samples,
        })
    }
}

impl Sample {
    fn read(b: &[u8; 16]) -> Self {
        let word = |i: usize| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        let kind = b[3];
        Self {
            bit: word(0) & 0xffff,
            bits: u32::from(b[2]) + 1,
            channel: kind & 15,
            float: kind & 0x80 != 0,
            signed: kind & 0x40 != 0,
            exponent: kind & 0x20 != 0,
            lower: word(8),
            upper: word(12),
        }
    }
}

/// Names of colour models (table 5.6), for messages.
fn model_name(model: u32) -> String {
    let name = match model {
        2 => return "luma and chroma".into(),
        128 => "BC1",
        129 => "BC2",
        130 => "BC3",
        131 => "BC4",
        132 => "BC5",
        134 => "BC7",
        160 => "ETC1",
        161 => "ETC2",
        162 => "ASTC",
        164 | 165 => "PVRTC",
        167 | 168 => "UASTC HDR",
        _ => return format!("colour model {model}"),
    };
    format!("{name} (compressed for graphics hardware)")
}
