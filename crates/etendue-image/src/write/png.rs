//! PNG out (ISO/IEC 15948:2004, with the extensions of W3C PNG third edition).

use std::io::Write;

use png::text_metadata::{ITXtChunk, TEXtChunk};
use png::{BitDepth, ColorType, Encoder, EncodingError, ScaledFloat, SrgbRenderingIntent};

use crate::{Image, ImageError, Metadata, Pixels};

fn error(e: EncodingError) -> ImageError {
    match e {
        EncodingError::IoError(e) => e.into(),
        e => ImageError::unwritable("PNG", e),
    }
}

/// Writes 8- or 16-bit samples; `linear` says so in a `gAMA` chunk, otherwise an `sRGB` chunk does.
pub(super) fn write(
    w: &mut dyn Write,
    image: &Image,
    linear: bool,
    metadata: &Metadata,
) -> Result<(), ImageError> {
    let mut encoder = Encoder::new(w, image.width, image.height);
    encoder.set_color(match image.channels {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    if linear {
        encoder.set_source_gamma(ScaledFloat::new(1.0));
    } else {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    let bytes: std::borrow::Cow<[u8]> = match &image.pixels {
        Pixels::U8(p) => {
            encoder.set_depth(BitDepth::Eight);
            p.as_slice().into()
        }
        Pixels::U16(p) => {
            encoder.set_depth(BitDepth::Sixteen);
            p.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<u8>>().into()
        }
        Pixels::F32(_) => return Err(ImageError::unwritable("PNG", "float samples")),
    };
    let mut writer = encoder.write_header().map_err(error)?;
    for (name, value) in &metadata.entries {
        // Latin-1 goes into tEXt, which every reader knows; the rest into iTXt, which is UTF-8.
        let keyword = keyword(name);
        let plain = value
            .chars()
            .all(|c| c == '\n' || (' '..='~').contains(&c) || ('\u{a1}'..='\u{ff}').contains(&c));
        if plain {
            writer.write_text_chunk(&TEXtChunk::new(keyword, value.as_str())).map_err(error)?;
        } else {
            let value = value.replace('\0', "");
            writer.write_text_chunk(&ITXtChunk::new(keyword, value)).map_err(error)?;
        }
    }
    writer.write_image_data(&bytes).map_err(error)?;
    writer.finish().map_err(error)
}

/// A keyword as PNG 11.3.4.2 allows it: 1 to 79 printable Latin-1 characters without outer or double spaces.
fn keyword(name: &str) -> String {
    let printable = |c: char| (' '..='~').contains(&c) || ('\u{a1}'..='\u{ff}').contains(&c);
    let clean: String = name.chars().map(|c| if printable(c) { c } else { '_' }).collect();
    let clean = clean.split_whitespace().collect::<Vec<_>>().join(" ");
    let clean: String = clean.chars().take(79).collect();
    let clean = clean.trim();
    if clean.is_empty() { "Comment".into() } else { clean.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_are_legal() {
        assert_eq!(keyword("Software"), "Software");
        assert_eq!(keyword(" a  b\n"), "a b_");
        assert_eq!(keyword(""), "Comment");
        assert_eq!(keyword(&"x".repeat(100)).len(), 79);
    }
}
