//! JPEG out (ITU-T T.81, JFIF 1.02).

use std::io::Write;

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use crate::{Image, ImageError, Metadata, Pixels};

const F: &str = "JPEG";

/// Writes opaque 8-bit samples; each metadata entry becomes a comment segment `name: value`.
pub(super) fn write(
    w: &mut dyn Write,
    image: &Image,
    quality: u8,
    metadata: &Metadata,
) -> Result<(), ImageError> {
    let Pixels::U8(pixels) = &image.pixels else {
        return Err(ImageError::unwritable(F, "samples of more than 8 bits"));
    };
    if image.width > 65535 || image.height > 65535 {
        return Err(ImageError::unwritable(F, "more than 65535 pixels in a row or column"));
    }
    let color = if image.channels == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    let mut coded = Vec::new();
    JpegEncoder::new_with_quality(&mut coded, quality.clamp(1, 100))
        .encode(pixels, image.width, image.height, color)
        .map_err(|e| ImageError::unwritable(F, e))?;
    // Comments follow the start marker and, where there is one, the JFIF segment, which has to come first.
    let mut at = 2;
    if let [_, _, 0xff, 0xe0, hi, lo, ..] = coded[..] {
        at += 2 + usize::from(u16::from_be_bytes([hi, lo]));
    }
    let (head, rest) =
        coded.split_at_checked(at).ok_or_else(|| ImageError::unwritable(F, "encoder failed"))?;
    w.write_all(head)?;
    for (name, value) in &metadata.entries {
        let text = format!("{name}: {value}");
        let text = &text.as_bytes()[..text.len().min(65533)];
        w.write_all(&[0xff, 0xfe])?;
        w.write_all(&(text.len() as u16 + 2).to_be_bytes())?;
        w.write_all(text)?;
    }
    w.write_all(rest)?;
    Ok(())
}
