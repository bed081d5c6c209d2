//! Pictures out, the format being told by the extension.

mod hdr;
mod jpeg;
mod png;
mod webp;

use std::io::Write;
use std::path::Path;

use etendue_color::{srgb_decode, srgb8_decode};

use crate::exr_write::encode_exr;
use crate::{
    ChannelData, Depth, Development, Image, ImageError, Layer, Metadata, Pixels, develop, write_atomic,
};

/// What to make of a picture on its way into a file.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    /// How light becomes display values, for PNG, JPEG and WebP. HDR and EXR keep the light as it is, exposure included.
    pub development: Development,
    /// Quality of JPEG, 1 to 100.
    pub jpeg_quality: u8,
    /// EXR with 16-bit floats instead of 32-bit.
    pub half: bool,
    /// What the file says about itself.
    pub metadata: Metadata,
}

impl Default for WriteOptions {
    /// sRGB without a tone curve, JPEG quality 92, EXR in half floats, no metadata.
    fn default() -> Self {
        Self {
            development: Development::default(),
            jpeg_quality: 92,
            half: true,
            metadata: Metadata::default(),
        }
    }
}

/// A format that [`write_picture`] knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PictureFormat {
    /// `.png`: 8 or 16 bits, straight alpha.
    Png,
    /// `.jpg`, `.jpeg`: 8 bits; a transparent picture lies on black.
    Jpeg,
    /// `.webp`: lossless, 8 bits, straight alpha.
    WebP,
    /// `.hdr`: Radiance RGBE; a transparent picture lies on black.
    Hdr,
    /// `.exr`: OpenEXR, half or float, premultiplied alpha.
    Exr,
}

impl PictureFormat {
    /// Extensions that are understood, as a user reads them.
    pub const KNOWN: &'static str = ".png, .jpg, .jpeg, .webp, .hdr, .exr";

    /// The format for a file name, by its extension in any case.
    ///
    /// # Errors
    /// [`ImageError::UnknownExtension`].
    pub fn from_path(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "webp" => Ok(Self::WebP),
            "hdr" => Ok(Self::Hdr),
            "exr" => Ok(Self::Exr),
            _ => Err(ImageError::UnknownExtension { path: path.to_path_buf(), known: Self::KNOWN }),
        }
    }
}

/// Writes a picture atomically (see [`write_atomic`]) in the format of the path's extension.
///
/// A float picture is linear Rec.709 light, colour premultiplied with alpha where it has alpha (2 or 4 channels): PNG,
/// JPEG and WebP get it developed, with straight alpha; HDR and EXR get it as it is. An integer picture counts as developed (sRGB,
/// straight alpha): PNG, JPEG and WebP get its samples, HDR and EXR the light they stand for. JPEG and HDR have no alpha: there the picture lies
/// on black. PNG keeps 16 bits; JPEG and WebP round them to 8.
///
/// Metadata go into `tEXt`/`iTXt` chunks (PNG), comment segments (JPEG), an XMP packet (WebP), comment lines (HDR) and
/// text attributes (EXR).
///
/// # Errors
/// [`ImageError::UnknownExtension`]; [`ImageError::Unwritable`] when the format cannot hold the picture's size;
/// [`ImageError::Io`]. The old file, if any, is then still there.
pub fn write_picture(path: &Path, picture: &Image, options: &WriteOptions) -> Result<(), ImageError> {
    let format = PictureFormat::from_path(path)?;
    let name = |e: ImageError| match e {
        ImageError::Io(_) => e,
        e => e.in_file(path),
    };
    write_atomic(path, |w| encode_picture(w, format, picture, options)).map_err(name)
}

/// Encodes a picture as [`write_picture`] does, into any sink.
///
/// # Errors
/// As [`write_picture`].
pub fn encode_picture(
    w: &mut dyn Write,
    format: PictureFormat,
    picture: &Image,
    options: &WriteOptions,
) -> Result<(), ImageError> {
    let have = match &picture.pixels {
        Pixels::U8(p) => p.len(),
        Pixels::U16(p) => p.len(),
        Pixels::F32(p) => p.len(),
    };
    if !(1..=4).contains(&picture.channels) || picture.is_empty() || have != picture.len() {
        return Err(ImageError::unwritable("the picture", "its samples do not fit its size"));
    }
    let metadata = &options.metadata;
    match format {
        PictureFormat::Png => {
            let linear = options.development.linear && matches!(picture.pixels, Pixels::F32(_));
            png::write(w, &develop(picture, &options.development), linear, metadata)
        }
        PictureFormat::Jpeg => jpeg::write(
            w,
            &opaque(&eight_bits(picture, &options.development)),
            options.jpeg_quality,
            metadata,
        ),
        PictureFormat::WebP => webp::write(w, &eight_bits(picture, &options.development), metadata),
        PictureFormat::Hdr => hdr::write(w, &light(picture), metadata),
        PictureFormat::Exr => {
            let light = light(picture);
            let names: &[&str] = if light.channels == 4 { &["R", "G", "B", "A"] } else { &["R", "G", "B"] };
            let n = names.len();
            let Pixels::F32(p) = &light.pixels else { unreachable!("light() yields floats") };
            let plane = |c: usize| ChannelData::Color(p.iter().skip(c).step_by(n).copied().collect());
            let channels = names.iter().enumerate().map(|(c, name)| (name.to_string(), plane(c))).collect();
            let layer = Layer { name: String::new(), channels };
            encode_exr(&[layer], (light.width, light.height), metadata, options.half)?.write(w)
        }
    }
}

/// Developed at eight bits, whatever the depth asked for or given.
fn eight_bits(picture: &Image, development: &Development) -> Image {
    let mut image = develop(picture, &Development { depth: Depth::Eight, ..*development });
    if let Pixels::U16(p) = &image.pixels {
        // Nearest of 256 codes: 65535 = 257 · 255.
        image.pixels = Pixels::U8(p.iter().map(|&v| ((u32::from(v) + 128) / 257) as u8).collect());
    }
    image
}

/// Laid on black, without alpha. Encoded values are scaled, as display programs do.
fn opaque(image: &Image) -> Image {
    let n = image.channels as usize;
    let Pixels::U8(p) = &image.pixels else { return image.clone() };
    if !n.is_multiple_of(2) {
        return image.clone();
    }
    let mut out = Vec::with_capacity(p.len() / n * (n - 1));
    for px in p.chunks_exact(n) {
        let a = u32::from(px[n - 1]);
        out.extend(px[..n - 1].iter().map(|&v| ((u32::from(v) * a + 127) / 255) as u8));
    }
    Image { channels: image.channels - 1, pixels: Pixels::U8(out), ..*image }
}

/// Linear light, premultiplied, as three or four float channels.
fn light(image: &Image) -> Image {
    let n = image.channels as usize;
    let has_alpha = n.is_multiple_of(2);
    let colors = if has_alpha { n - 1 } else { n };
    let channels = if has_alpha { 4 } else { 3 };
    let mut out = Vec::with_capacity(image.width as usize * image.height as usize * channels);
    for i in (0..image.len()).step_by(n) {
        let pixel = |c: usize| i + if colors == 1 { 0 } else { c };
        let a = i + n - 1;
        match &image.pixels {
            Pixels::F32(p) => {
                out.extend((0..3).map(|c| p[pixel(c)]));
                out.extend(has_alpha.then(|| p[a]));
            }
            Pixels::U8(p) => {
                let a = has_alpha.then(|| f32::from(p[a]) / 255.0);
                out.extend((0..3).map(|c| srgb8_decode(p[pixel(c)]) * a.unwrap_or(1.0)));
                out.extend(a);
            }
            Pixels::U16(p) => {
                let a = has_alpha.then(|| f32::from(p[a]) / 65535.0);
                out.extend((0..3).map(|c| srgb_decode(f32::from(p[pixel(c)]) / 65535.0) * a.unwrap_or(1.0)));
                out.extend(a);
            }
        }
    }
    Image { channels: channels as u8, pixels: Pixels::F32(out), ..*image }
}
