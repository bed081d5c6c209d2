//! PNG, JPEG, WebP, KTX2, BMP and TGA into a picture at the depth of the file.

use std::io::Cursor;

use image::ImageDecoder;

use crate::{Image, ImageError, Ktx2, Pixels};

/// How much a file may ask for before it is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeLimits {
    /// Most pixels of one picture.
    pub max_pixels: u64,
    /// Most bytes of decoded samples of one picture.
    pub max_bytes: u64,
}

impl Default for DecodeLimits {
    /// 2²⁸ pixels (16384 × 16384) and 4 GiB.
    fn default() -> Self {
        Self { max_pixels: 1 << 28, max_bytes: 4 << 30 }
    }
}

impl DecodeLimits {
    /// Refuses an empty picture, one beyond the limits, and one whose `samples` (in bytes, decoded) exceed `ratio`
    /// times the `present` bytes: more than its coding could have packed into them.
    pub(crate) fn check(
        &self,
        format: &'static str,
        (width, height): (u64, u64),
        samples: u64,
        present: usize,
        ratio: u64,
    ) -> Result<(), ImageError> {
        let refuse = |cause: String| Err(ImageError::TooLarge { format, width, height, cause });
        let pixels = width.saturating_mul(height);
        if pixels == 0 {
            return refuse("it has no pixels".into());
        }
        if pixels > self.max_pixels {
            return refuse(format!("more than the limit of {} pixels", self.max_pixels));
        }
        if samples > self.max_bytes {
            return refuse(format!("{samples} bytes are more than the limit of {}", self.max_bytes));
        }
        // Headers and small pictures: 4 KiB of grace.
        if samples > (present as u64).saturating_add(64).saturating_mul(ratio).saturating_add(4096) {
            return refuse(format!("the {present} bytes present cannot hold it"));
        }
        Ok(())
    }
}

/// The formats that [`decode`] reads.
const KNOWN: &str = "PNG, JPEG, WebP, KTX2, BMP, TGA";

/// Decodes a PNG, JPEG, WebP, KTX2, BMP or TGA picture, told apart by its first bytes; TGA, which has none of its own, by a
/// header that makes sense.
///
/// Samples keep the file's depth (8 bits, or 16 in 16-bit PNG; fewer bits are scaled to 8) and its kind: grey,
/// grey + alpha, RGB or RGBA, alpha not multiplied in. Palettes are expanded, a transparent colour becomes an alpha channel, CMYK
/// and YCCK become RGB; of an animation the first frame is read. Colour profiles, gamma and EXIF orientation are left
/// alone, as glTF asks (glTF 2.0, 3.8.3): what the numbers mean is the caller's to know. Of a KTX2 texture it is the largest
/// mip, the first layer and the first face ([`Ktx2`] has the others); one of floats is not for textures and refused.
///
/// # Errors
/// [`ImageError::UnknownFormat`], [`ImageError::Damaged`] (truncated data included, except that a JPEG whose entropy-coded
/// data ends early may be filled up), [`ImageError::Unsupported`], [`ImageError::TooLarge`].
pub fn decode(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => decode_png(bytes, limits),
        [0xff, 0xd8, ..] => decode_jpeg(bytes, limits),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => decode_webp(bytes, limits),
        [0xab, b'K', b'T', b'X', b' ', b'2', ..] => decode_ktx2(bytes, limits),
        [b'B', b'M', ..] => decode_bmp(bytes, limits),
        _ if is_tga(bytes) => decode_tga(bytes, limits),
        _ => Err(unknown_format(bytes, KNOWN)),
    }
}

/// True if the bytes begin as a TGA file does (Truevision, "TGA File Format Specification" 2.0).
pub fn is_tga(bytes: &[u8]) -> bool {
    let Some(head) = bytes.get(..18) else { return false };
    let (map, kind, depth) = (head[1], head[2], head[16]);
    let entries = u16::from_le_bytes([head[5], head[6]]);
    let mapped = match kind {
        1 | 9 => map == 1 && entries > 0 && matches!(head[7], 15 | 16 | 24 | 32) && matches!(depth, 8 | 16),
        2 | 10 => map <= 1 && matches!(depth, 15 | 16 | 24 | 32),
        3 | 11 => map == 0 && matches!(depth, 8 | 16),
        _ => false,
    };
    let size = |i: usize| u16::from_le_bytes([head[i], head[i + 1]]) > 0;
    // The two highest bits of the descriptor have to be 0; alpha has eight bits at most.
    mapped && size(12) && size(14) && head[17] >> 6 == 0 && head[17] & 15 <= 8
}

/// Runs of at most 255 pixels in two bytes, of four channels each.
const RUNS_PER_BYTE: u64 = 512;

fn decode_bmp(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    const F: &str = "BMP";
    let decoder = image::codecs::bmp::BmpDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(F, e))?;
    let (w, h) = decoder.dimensions();
    limits.check(F, (w.into(), h.into()), decoder.total_bytes(), bytes.len(), RUNS_PER_BYTE)?;
    read_image(F, decoder)
}

fn decode_tga(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    const F: &str = "TGA";
    let (w, h) = (u16::from_le_bytes([bytes[12], bytes[13]]), u16::from_le_bytes([bytes[14], bytes[15]]));
    // Four channels at most; looked at before the decoder allocates anything.
    limits.check(F, (w.into(), h.into()), 4 * u64::from(w) * u64::from(h), bytes.len(), RUNS_PER_BYTE)?;
    let decoder = image::codecs::tga::TgaDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(F, e))?;
    read_image(F, decoder)
}

fn decode_ktx2(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    let Image { width, height, channels, pixels } = Ktx2::new(bytes, limits)?.texture()?;
    finish("KTX2", width, height, channels, pixels)
}

pub(crate) fn unknown_format(bytes: &[u8], known: &'static str) -> ImageError {
    let start: Vec<String> = bytes.iter().take(8).map(|b| format!("{b:02x}")).collect();
    ImageError::UnknownFormat { start: if start.is_empty() { "none".into() } else { start.join(" ") }, known }
}

/// Deflate packs at most 258 bytes into two bits (RFC 1951, 3.2.5: the longest match with one-bit codes).
pub(crate) const DEFLATE_RATIO: u64 = 1032;

fn decode_png(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    const F: &str = "PNG";
    let err = |e: png::DecodingError| match e {
        png::DecodingError::LimitsExceeded => {
            ImageError::damaged(F, "it asks for more memory than is allowed")
        }
        e => ImageError::damaged(F, e),
    };
    let max = usize::try_from(limits.max_bytes).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: max });
    // Text and profiles are not used; leaving them out spares their decompression.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(err)?;
    let info = reader.info();
    let (width, height) = (info.width, info.height);
    let size = (width.into(), height.into());
    // What deflate has to deliver: rows of packed samples as they stand in the file.
    limits.check(F, size, info.raw_bytes() as u64, bytes.len(), DEFLATE_RATIO)?;
    let (color, depth) = reader.output_color_type();
    let channels = match color {
        png::ColorType::Grayscale => 1u8,
        png::ColorType::GrayscaleAlpha => 2,
        png::ColorType::Rgb => 3,
        png::ColorType::Rgba => 4,
        png::ColorType::Indexed => return Err(ImageError::damaged(F, "palette is missing")),
    };
    let len = reader.output_buffer_size().unwrap_or(usize::MAX);
    limits.check(F, size, len as u64, usize::MAX, 1)?;
    let mut data = vec![0; len];
    let frame = reader.next_frame(&mut data).map_err(err)?;
    // The first frame of an animation may cover less than the canvas: then the file is not a plain picture.
    if (frame.width, frame.height) != (width, height) {
        return Err(ImageError::unsupported(F, "a first frame smaller than the canvas"));
    }
    data.truncate(frame.buffer_size());
    let pixels = match depth {
        png::BitDepth::Sixteen => {
            Pixels::U16(data.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect())
        }
        _ => Pixels::U8(data),
    };
    finish(F, width, height, channels, pixels)
}

/// Each 8 × 8 block of a JPEG takes at least one bit (a Huffman code), so a byte holds at most 512 pixels.
const JPEG_PIXELS_PER_BYTE: u64 = 512;

fn decode_jpeg(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    const F: &str = "JPEG";
    let decoder = image::codecs::jpeg::JpegDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(F, e))?;
    let (w, h) = decoder.dimensions();
    let channels = decoder.color_type().channel_count() as u64;
    limits.check(
        F,
        (w.into(), h.into()),
        u64::from(w) * u64::from(h) * channels,
        bytes.len(),
        JPEG_PIXELS_PER_BYTE * channels,
    )?;
    read_image(F, decoder)
}

fn decode_webp(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    const F: &str = "WebP";
    let decoder = image::codecs::webp::WebPDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(F, e))?;
    let (w, h) = decoder.dimensions();
    // Lossless WebP spends no bits on a picture of one colour, so only the limits bound it.
    limits.check(F, (w.into(), h.into()), decoder.total_bytes(), usize::MAX, 1)?;
    read_image(F, decoder)
}

fn read_image(format: &'static str, decoder: impl ImageDecoder) -> Result<Image, ImageError> {
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let channels = color.channel_count();
    if color.bytes_per_pixel() != channels {
        return Err(ImageError::unsupported(format, format!("samples of type {color:?}")));
    }
    let len = usize::try_from(decoder.total_bytes())
        .map_err(|_| ImageError::damaged(format, "it does not fit into memory"))?;
    let mut data = vec![0; len];
    decoder.read_image(&mut data).map_err(|e| image_error(format, e))?;
    finish(format, width, height, channels, Pixels::U8(data))
}

fn image_error(format: &'static str, e: image::ImageError) -> ImageError {
    match e {
        image::ImageError::Unsupported(u) => ImageError::unsupported(format, u.to_string()),
        e => ImageError::damaged(format, e),
    }
}

/// The last check that what a decoder returned is a whole picture.
fn finish(
    format: &'static str,
    width: u32,
    height: u32,
    channels: u8,
    pixels: Pixels,
) -> Result<Image, ImageError> {
    let image = Image { width, height, channels, pixels };
    let have = match &image.pixels {
        Pixels::U8(p) => p.len(),
        Pixels::U16(p) => p.len(),
        Pixels::F32(p) => p.len(),
    };
    if have != image.len() || image.is_empty() {
        return Err(ImageError::damaged(format, format!("{have} samples where {} belong", image.len())));
    }
    Ok(image)
}
