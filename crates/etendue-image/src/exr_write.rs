//! OpenEXR out: one part, scan lines, ZIP, the same bytes for the same picture on every machine.
//!
//! Written by hand against "OpenEXR File Layout" and "Technical Introduction to OpenEXR" (Academy Software Foundation,
//! version 2 files), because attributes have to stand in a fixed order and the target need not seek: chunks are compressed first, in parallel,
//! and the offset table follows from their lengths.

use std::io::Write;
use std::path::Path;

use half::f16;
use rayon::prelude::*;

use crate::{ImageError, Metadata, write_atomic};

const F: &str = "OpenEXR";

/// The samples of one channel, row by row.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelData {
    /// Light and colour: 16-bit floats when the file is written as half, else 32-bit floats. In half, finite values
    /// beyond ±65504 become ±65504.
    Color(Vec<f32>),
    /// Numbers that need their precision (depth, position, Cryptomatte): always 32-bit floats, bit for bit.
    F32(Vec<f32>),
    /// Unsigned integers.
    U32(Vec<u32>),
}

impl ChannelData {
    fn len(&self) -> usize {
        match self {
            Self::Color(v) | Self::F32(v) => v.len(),
            Self::U32(v) => v.len(),
        }
    }
}

/// Channels that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Empty for the beauty picture; else it stands before each channel's name with a dot.
    pub name: String,
    /// Names (`R`, `G`, `B`, `A`, `X`, `Z`, `U` …) and samples.
    pub channels: Vec<(String, ChannelData)>,
}

/// A layered picture as read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrImage {
    /// Pixels in a row of the data window.
    pub width: u32,
    /// Rows of the data window.
    pub height: u32,
    /// Layers in the order of the file, each once.
    pub layers: Vec<Layer>,
    /// Text attributes.
    pub metadata: Metadata,
}

impl ExrImage {
    /// The layer of this name; the empty name is the beauty picture.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|l| l.name == name)
    }
}

impl Layer {
    /// The samples of a channel.
    pub fn channel(&self, name: &str) -> Option<&ChannelData> {
        self.channels.iter().find(|c| c.0 == name).map(|c| &c.1)
    }
}

/// Writes one OpenEXR file that holds all layers, atomically (see [`write_atomic`]).
///
/// Channels are named `layer.channel`, as compositing programs expect: `R`, `G`, `B`, `A` for the layer with the empty
/// name, `albedo.R`, `normal.X`, `depth.Z`, and for Cryptomatte `CryptoObject00.R` with its manifest given as metadata
/// entries (`cryptomatte/<id>/name`, …). Each metadata entry becomes a text attribute, but for `envmap` with the value `latlong` or `cube`, which becomes the
/// format's own attribute: the picture shows all directions, as latitude and longitude or as six faces below one another. Colours are linear Rec.709
/// (a `chromaticities` attribute says so), alpha is premultiplied. Compression is ZIP over 16 rows. The bytes do not depend on the
/// number of threads.
///
/// # Errors
/// [`ImageError::Unwritable`] when a name is empty, too long (255 bytes) or given twice, or a channel has not
/// `width × height` samples; [`ImageError::Io`].
pub fn write_layers_exr(
    path: &Path,
    layers: &[Layer],
    size: (u32, u32),
    metadata: &Metadata,
    half: bool,
) -> Result<(), ImageError> {
    let file = encode_exr(layers, size, metadata, half)?;
    write_atomic(path, |w| file.write(w))
}

/// A file ready to be written: everything before the offset table, and the chunks.
pub(crate) struct ExrFile {
    head: Vec<u8>,
    /// First row and compressed data of each chunk.
    chunks: Vec<(i32, Vec<u8>)>,
}

impl ExrFile {
    pub(crate) fn write(&self, w: &mut dyn Write) -> Result<(), ImageError> {
        w.write_all(&self.head)?;
        let mut offset = (self.head.len() + 8 * self.chunks.len()) as u64;
        for (_, data) in &self.chunks {
            w.write_all(&offset.to_le_bytes())?;
            offset += 8 + data.len() as u64;
        }
        for (y, data) in &self.chunks {
            w.write_all(&y.to_le_bytes())?;
            w.write_all(&(data.len() as i32).to_le_bytes())?;
            w.write_all(data)?;
        }
        Ok(())
    }
}

/// Rows in a ZIP chunk.
const ROWS: usize = 16;

/// The attributes that this writer sets itself: entries of these names are stored under another.
const OWN: [&str; 11] = [
    "channels",
    "chromaticities",
    "compression",
    "dataWindow",
    "displayWindow",
    "envmap",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "name",
];

pub(crate) fn encode_exr(
    layers: &[Layer],
    (width, height): (u32, u32),
    metadata: &Metadata,
    half: bool,
) -> Result<ExrFile, ImageError> {
    let bad = |cause: String| ImageError::unwritable(F, cause);
    let (w, h) = (width as usize, height as usize);
    if w == 0 || h == 0 || width > i32::MAX as u32 / 64 || height > i32::MAX as u32 / 64 {
        return Err(bad(format!("a picture of {width} × {height} pixels")));
    }

    // Channels sorted by name, as the format demands (bytewise, as readers compare them).
    let mut channels: Vec<(String, &ChannelData)> = Vec::new();
    for layer in layers {
        for (name, data) in &layer.channels {
            let full = if layer.name.is_empty() { name.clone() } else { format!("{}.{name}", layer.name) };
            if name.is_empty() || full.len() > 255 || full.contains('\0') {
                return Err(bad(format!("the channel name {full:?}")));
            }
            if data.len() != w * h {
                return Err(bad(format!("channel {full} has {} samples, not {w} × {h}", data.len())));
            }
            channels.push((full, data));
        }
    }
    channels.sort_by(|a, b| a.0.as_bytes().cmp(b.0.as_bytes()));
    if let Some(twice) = channels.windows(2).find(|c| c[0].0 == c[1].0) {
        return Err(bad(format!("two channels named {}", twice[0].0)));
    }
    if channels.is_empty() {
        return Err(bad("a file without channels".into()));
    }

    let head = header(&channels, (width, height), metadata, half)?;
    let chunks = (0..h.div_ceil(ROWS))
        .into_par_iter()
        .map(|i| {
            let rows = i * ROWS..((i + 1) * ROWS).min(h);
            (rows.start as i32, compress(&raw_rows(&channels, w, rows, half)))
        })
        .collect();
    Ok(ExrFile { head, chunks })
}

/// Magic number, version and attributes, up to the offset table.
fn header(
    channels: &[(String, &ChannelData)],
    (width, height): (u32, u32),
    metadata: &Metadata,
    half: bool,
) -> Result<Vec<u8>, ImageError> {
    let mut attributes: Vec<(String, &str, Vec<u8>)> = Vec::new();

    let mut list = Vec::new();
    for (name, data) in channels {
        list.extend_from_slice(name.as_bytes());
        list.push(0);
        let kind: i32 = match data {
            ChannelData::U32(_) => 0,
            ChannelData::Color(_) if half => 1,
            ChannelData::Color(_) | ChannelData::F32(_) => 2,
        };
        list.extend_from_slice(&kind.to_le_bytes());
        // pLinear (only lossy compression looks at it) and three reserved bytes; then x and y sampling.
        list.extend_from_slice(&[0; 4]);
        list.extend_from_slice(&1i32.to_le_bytes());
        list.extend_from_slice(&1i32.to_le_bytes());
    }
    list.push(0);
    attributes.push(("channels".into(), "chlist", list));

    let floats = |v: &[f32]| v.iter().flat_map(|f| f.to_le_bytes()).collect::<Vec<u8>>();
    let window: Vec<u8> =
        [0, 0, width as i32 - 1, height as i32 - 1].iter().flat_map(|v: &i32| v.to_le_bytes()).collect();
    // Rec. ITU-R BT.709-6, item 1.3 and 1.4: red, green, blue, white (D65).
    let rec709 = floats(&[0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]);
    attributes.push(("chromaticities".into(), "chromaticities", rec709));
    attributes.push(("compression".into(), "compression", vec![3])); // ZIP, 16 rows
    attributes.push(("dataWindow".into(), "box2i", window.clone()));
    attributes.push(("displayWindow".into(), "box2i", window));
    match metadata.get("envmap") {
        Some("latlong") => attributes.push(("envmap".into(), "envmap", vec![0])),
        Some("cube") => attributes.push(("envmap".into(), "envmap", vec![1])),
        _ => {}
    }
    attributes.push(("lineOrder".into(), "lineOrder", vec![0])); // increasing y
    attributes.push(("pixelAspectRatio".into(), "float", floats(&[1.0])));
    attributes.push(("screenWindowCenter".into(), "v2f", floats(&[0.0, 0.0])));
    attributes.push(("screenWindowWidth".into(), "float", floats(&[1.0])));

    let layout =
        |(name, value): &&(String, String)| name == "envmap" && matches!(&**value, "latlong" | "cube");
    for (name, value) in metadata.entries.iter().filter(|e| !layout(e)) {
        // Names end with a zero byte; a name of ours would be taken for the real attribute.
        let mut name: String = name.chars().filter(|&c| c != '\0').collect();
        if name.is_empty() || OWN.contains(&name.as_str()) || attributes.iter().any(|a| a.0 == name) {
            name = format!("meta/{name}");
        }
        if name.len() > 255 {
            return Err(ImageError::unwritable(F, format!("the attribute name {name:?} is too long")));
        }
        attributes.push((name, "string", value.as_bytes().to_vec()));
    }

    let mut out = vec![0x76, 0x2f, 0x31, 0x01];
    // Version 2; bit 10 allows names of more than 31 bytes.
    let long = attributes.iter().map(|a| a.0.len()).chain(channels.iter().map(|c| c.0.len())).any(|n| n > 31);
    out.extend_from_slice(&(2u32 | if long { 0x400 } else { 0 }).to_le_bytes());
    for (name, kind, data) in attributes {
        out.extend_from_slice(name.as_bytes());
        out.push(0);
        out.extend_from_slice(kind.as_bytes());
        out.push(0);
        let len = i32::try_from(data.len())
            .map_err(|_| ImageError::unwritable(F, format!("the attribute {name} is too long")))?;
        out.extend_from_slice(&len.to_le_bytes());
        out.extend_from_slice(&data);
    }
    out.push(0);
    Ok(out)
}

/// The uncompressed bytes of some rows: for each row, for each channel, its samples in little endian.
fn raw_rows(
    channels: &[(String, &ChannelData)],
    w: usize,
    rows: std::ops::Range<usize>,
    half: bool,
) -> Vec<u8> {
    let mut raw = Vec::with_capacity(rows.len() * w * channels.len() * 4);
    for y in rows {
        let row = y * w..(y + 1) * w;
        for (_, data) in channels {
            match data {
                ChannelData::Color(v) if half => {
                    v[row.clone()].iter().for_each(|&v| raw.extend_from_slice(&to_half(v).to_le_bytes()));
                }
                ChannelData::Color(v) | ChannelData::F32(v) => {
                    v[row.clone()].iter().for_each(|v| raw.extend_from_slice(&v.to_le_bytes()));
                }
                ChannelData::U32(v) => {
                    v[row.clone()].iter().for_each(|v| raw.extend_from_slice(&v.to_le_bytes()));
                }
            }
        }
    }
    raw
}

/// Rounds to nearest half, keeping finite values finite.
fn to_half(v: f32) -> f16 {
    if v.is_finite() { f16::from_f32(v.clamp(-65504.0, 65504.0)) } else { f16::from_f32(v) }
}

/// The ZIP scheme of OpenEXR: even bytes before odd ones, then differences, then zlib. Data that would grow stay raw.
fn compress(raw: &[u8]) -> Vec<u8> {
    let mut split: Vec<u8> = raw.iter().step_by(2).chain(raw.iter().skip(1).step_by(2)).copied().collect();
    let mut previous = match split.first() {
        Some(&b) => b,
        None => return Vec::new(),
    };
    for b in &mut split[1..] {
        let now = *b;
        *b = now.wrapping_sub(previous).wrapping_add(128);
        previous = now;
    }
    let packed = miniz_oxide::deflate::compress_to_vec_zlib(&split, 5);
    if packed.len() < raw.len() { packed } else { raw.to_vec() }
}
