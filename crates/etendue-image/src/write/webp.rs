//! WebP out: lossless (RFC 9649).

use std::io::{Cursor, Write};

use image::ExtendedColorType;
use image::codecs::webp::WebPEncoder;

use crate::{Image, ImageError, Metadata, Pixels};

const F: &str = "WebP";

/// Writes 8-bit samples without loss; metadata become one XMP packet.
pub(super) fn write(w: &mut dyn Write, image: &Image, metadata: &Metadata) -> Result<(), ImageError> {
    let Pixels::U8(pixels) = &image.pixels else {
        return Err(ImageError::unwritable(F, "samples of more than 8 bits"));
    };
    if image.width > 16384 || image.height > 16384 {
        return Err(ImageError::unwritable(F, "more than 16384 pixels in a row or column"));
    }
    let color = match image.channels {
        1 => ExtendedColorType::L8,
        2 => ExtendedColorType::La8,
        3 => ExtendedColorType::Rgb8,
        _ => ExtendedColorType::Rgba8,
    };
    let mut coded = Vec::new();
    WebPEncoder::new_lossless(Cursor::new(&mut coded))
        .encode(pixels, image.width, image.height, color)
        .map_err(|e| ImageError::unwritable(F, e))?;
    if metadata.entries.is_empty() {
        return Ok(w.write_all(&coded)?);
    }
    // RIFF header (12 bytes) and one VP8L chunk, its padding included: RFC 9649, 2.6.
    let Some(picture) = coded.get(12..).filter(|c| c.starts_with(b"VP8L")) else {
        return Err(ImageError::unwritable(F, "encoder failed"));
    };
    let mut xmp = packet(metadata).into_bytes();
    let xmp_len = xmp.len() as u32;
    if !xmp.len().is_multiple_of(2) {
        xmp.push(0);
    }
    // The extended format, 2.7: flags (alpha 16, XMP 4), three reserved bytes, width − 1 and height − 1 in 24 bits.
    let alpha = if image.channels.is_multiple_of(2) { 16 } else { 0 };
    let mut extended = vec![alpha | 4, 0, 0, 0];
    extended.extend_from_slice(&(image.width - 1).to_le_bytes()[..3]);
    extended.extend_from_slice(&(image.height - 1).to_le_bytes()[..3]);
    let len = 4 + 8 + extended.len() + picture.len() + 8 + xmp.len();
    let len = u32::try_from(len).map_err(|_| ImageError::unwritable(F, "more than 4 GiB"))?;
    w.write_all(b"RIFF")?;
    w.write_all(&len.to_le_bytes())?;
    w.write_all(b"WEBPVP8X")?;
    w.write_all(&(extended.len() as u32).to_le_bytes())?;
    w.write_all(&extended)?;
    w.write_all(picture)?;
    w.write_all(b"XMP ")?;
    w.write_all(&xmp_len.to_le_bytes())?;
    w.write_all(&xmp)?;
    Ok(())
}

/// An XMP packet (ISO 16684-1) with one property per entry, the name as the property's `e:name`.
fn packet(metadata: &Metadata) -> String {
    let mut items = String::new();
    for (name, value) in &metadata.entries {
        items += &format!("<rdf:li e:name=\"{}\">{}</rdf:li>", escape(name), escape(value));
    }
    format!(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
         <rdf:Description rdf:about=\"\" xmlns:e=\"urn:etendue\"><e:metadata><rdf:Seq>{items}</rdf:Seq></e:metadata>\
         </rdf:Description></rdf:RDF></x:xmpmeta>"
    )
}

/// Text as XML 1.0 allows it.
fn escape(s: &str) -> String {
    let mut out = String::with_capacity(s.len());
    for c in s.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\t' | '\n' | '\r' => out.push(c),
            c if c < ' ' || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
