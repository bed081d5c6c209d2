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
    /// Not encoded, though the others are.
    pub linear: bool,
    /// Where in the texel it was taken; 0 is the texel itself.
    pub position: u32,
    /// What stands for 0 (or −1) and 1.
    pub lower: u32,
    pub upper: u32,
}

/// The descriptor.
pub(super) struct Descriptor {
    pub model: Model,
    pub srgb: bool,
    /// Numbers of the Khronos Data Format, tables 5.10 and 5.11.
    pub primaries: u32,
    pub transfer: u32,
    pub premultiplied: bool,
    /// Bytes of a texel of plain samples.
    pub texel_bytes: u32,
    /// Bytes of a block of texels as the file says; 0 if it does not.
    pub plane_bytes: u32,
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
        // What may follow the basic block is not looked at, but it has to be blocks.
        let mut more = &bytes[4 + size..];
        while !more.is_empty() {
            let length = more.get(6..8).map_or(0, |b| usize::from(u16::from_le_bytes([b[0], b[1]])));
            match more.get(length..) {
                Some(rest) if length >= 8 => more = rest,
                _ => return bad("has a further block of an impossible size"),
            }
        }
        if version & 0xffff != 2 {
            return Err(ImageError::unsupported(F, format!("a descriptor of version {}", version & 0xffff)));
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
        // Numbers of KDF 1.3, tables 5.10 and 5.11.
        let (primaries, transfer) = (model >> 8 & 255, model >> 16 & 255);
        if primaries > 11 || transfer > 19 {
            return bad("has primaries or a transfer function that are not known");
        }
        // The second stream of ETC1S, alpha, counts as a plane.
        let second = if kind == Model::Etc1s { planes >> 16 } else { planes >> 8 };
        let more_planes = second != 0 || word(24) != 0;
        if more_planes || samples.iter().any(|s| s.position != 0) {
            return Err(ImageError::unsupported(F, "texels of several planes or places"));
        }
        // Alpha is never encoded; for the others the descriptor would contradict itself.
        if samples.iter().any(|s| s.linear && (transfer == 1 || s.channel != 15 && kind != Model::Bc6h)) {
            return bad("calls a sample linear that is not, or need not be");
        }
        if !basis_samples(kind, &samples) {
            return bad("has samples that its texels do not have");
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
            srgb: transfer == 2,
            primaries,
            transfer,
            premultiplied: model >> 24 & 1 == 1,
            texel_bytes,
            plane_bytes: planes & 255,
            samples,
        })
    }
}

/// Whether the samples are those of the coded blocks (KTX 2.0, 3.10; KDF 1.3, tables 5.27 and 5.29); true for plain ones.
fn basis_samples(model: Model, samples: &[Sample]) -> bool {
    let is = |s: &Sample, bit: u32, bits: u32, channels: &[u8]| {
        let whole = s.bit == bit && s.bits == bits && s.lower == 0 && s.upper == u32::MAX;
        whole && channels.contains(&s.channel)
    };
    match (model, samples) {
        (Model::Plain, _) => true,
        (Model::Uastc, [s]) => is(s, 0, 128, &[0, 3, 4, 5, 6]),
        (Model::Etc1s, [s]) => is(s, 0, 64, &[0, 3]),
        (Model::Etc1s, [s, t]) => is(s, 0, 64, &[0, 3]) && is(t, 64, 64, &[4, 15]),
        (Model::Bc6h, [s]) => s.bit == 0 && s.bits == 128 && s.channel == 0 && s.float,
        _ => false,
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
            linear: kind & 0x10 != 0,
            position: word(4),
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
