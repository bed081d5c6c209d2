//! Any picture file as it stands: nothing repaired, nothing converted.

use crate::decode::{DecodeLimits, decode, unknown_format};
use crate::hdr::{decode_hdr, is_hdr};
use crate::{ChannelData, ExrImage, Image, ImageError, Pixels, read_exr_layers};

/// The first bytes of every OpenEXR file.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// Decodes a PNG, JPEG, WebP, Radiance or OpenEXR picture, told apart by its first bytes, to be looked at or compared.
///
/// PNG, JPEG and WebP give integer samples, display values (sRGB); Radiance and OpenEXR give floats, linear light, as they
/// stand in the file: NaN, infinities and negative values included, alpha kept (premultiplied in OpenEXR). Of an OpenEXR file
/// it is the layer without a name.
///
/// # Errors
/// Those of [`decode`] and [`read_exr_layers`]; [`ImageError::Unsupported`] for an OpenEXR file whose layer without a name has neither
/// R, G and B nor Y.
pub fn decode_picture(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, ImageError> {
    if is_hdr(bytes) {
        return Ok(decode_hdr(bytes, limits)?.image);
    }
    if bytes.starts_with(EXR_MAGIC) {
        return beauty(&read_exr_layers(bytes, limits)?);
    }
    decode(bytes, limits).map_err(|e| match e {
        ImageError::UnknownFormat { .. } => unknown_format(bytes, "PNG, JPEG, WebP, Radiance HDR, OpenEXR"),
        e => e,
    })
}

/// The layer without a name, as one, two, three or four float channels.
fn beauty(exr: &ExrImage) -> Result<Image, ImageError> {
    let find = |names: &[&str]| -> Option<Vec<Vec<f32>>> {
        let layer = exr.layer("")?;
        names.iter().map(|n| layer.channel(n).map(floats)).collect()
    };
    let order: [&[&str]; 4] = [&["R", "G", "B", "A"], &["R", "G", "B"], &["Y", "A"], &["Y"]];
    let planes = order.into_iter().find_map(find).ok_or_else(|| {
        let names: Vec<&str> = exr.layers.iter().map(|l| l.name.as_str()).filter(|n| !n.is_empty()).collect();
        let feature = format!("no R, G, B in its nameless layer (other layers: {})", names.join(", "));
        ImageError::unsupported("OpenEXR", feature)
    })?;
    let pixels = (0..planes[0].len()).flat_map(|i| planes.iter().map(move |p| p[i])).collect();
    Ok(Image {
        width: exr.width,
        height: exr.height,
        channels: planes.len() as u8,
        pixels: Pixels::F32(pixels),
    })
}

fn floats(data: &ChannelData) -> Vec<f32> {
    match data {
        ChannelData::Color(v) | ChannelData::F32(v) => v.clone(),
        ChannelData::U32(v) => v.iter().map(|x| *x as f32).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PictureFormat, WriteOptions, encode_picture};

    #[test]
    fn samples_come_back_as_they_stand() {
        let light = Image {
            width: 2,
            height: 1,
            channels: 4,
            pixels: Pixels::F32(vec![0.5, -1.0, f32::INFINITY, 0.25, 3.0, 0.0, 1.0, 1.0]),
        };
        let read = |format| {
            let mut bytes = Vec::new();
            encode_picture(&mut bytes, format, &light, &WriteOptions::default()).unwrap();
            decode_picture(&bytes, &DecodeLimits::default()).unwrap()
        };
        assert_eq!(read(PictureFormat::Exr), light);
        let png = read(PictureFormat::Png);
        assert!(png.channels == 4 && matches!(png.pixels, Pixels::U8(_)));
        let hdr = read(PictureFormat::Hdr);
        assert!(hdr.channels == 3 && hdr.sample(1, 0, 0) == 3.0);
        let e = decode_picture(b"nothing of the kind", &DecodeLimits::default()).unwrap_err();
        assert!(e.to_string().contains("OpenEXR"), "{e}");
    }
}
