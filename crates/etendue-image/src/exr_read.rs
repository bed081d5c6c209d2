//! OpenEXR in: headers judged before anything is allocated, then only the wanted channels of the wanted part.
//!
//! The crate `exr` parses headers and decompresses chunks; this file decides what is read, bounds it, and places it.
//! Chunks are decompressed in parallel, a batch at a time, and stored in order.

use std::io::Cursor;

use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock};
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::compression::Compression;
use exr::error::Error as ExrError;
use exr::meta::attribute::{AttributeValue, EnvironmentMap, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use half::f16;
use rayon::prelude::*;

use crate::decode::{DEFLATE_RATIO, DecodeLimits};
use crate::{ChannelData, ExrImage, ImageError, Layer, Metadata};

pub(crate) const F: &str = "OpenEXR";

/// Chunks that are held compressed at once before they are decompressed together.
const BATCH: usize = 64;

pub(crate) fn exr_error(e: ExrError) -> ImageError {
    match e {
        ExrError::NotSupported(m) => {
            let feature = m.trim_end_matches(" yet").trim_end_matches(" not supported");
            ImageError::unsupported(F, feature.trim_start_matches("yet unimplemented "))
        }
        ExrError::Invalid(m) => ImageError::damaged(F, m),
        ExrError::Io(e) => ImageError::damaged(F, format!("the data ends early ({e})")),
        ExrError::Aborted => ImageError::damaged(F, "aborted"),
    }
}

/// The headers of a file, each checked against the bytes that are there.
pub(crate) fn read_headers(bytes: &[u8]) -> Result<MetaData, ImageError> {
    let meta = block::read(Cursor::new(bytes), false).map_err(exr_error)?.into_meta_data();
    // Each chunk has an entry of eight bytes in the offset table: a count beyond that is a lie, and walking over the
    // blocks of such a header would take for ever.
    let chunks = meta.headers.iter().try_fold(0usize, |n, h| n.checked_add(h.chunk_count));
    if chunks.is_none_or(|n| n > bytes.len() / 8) {
        return Err(ImageError::damaged(F, "the offset table is longer than the file"));
    }
    Ok(meta)
}

/// Bytes that one byte of compressed data can become, at most, by the construction of the coder.
fn expansion(c: Compression) -> u64 {
    match c {
        Compression::Uncompressed => 1,
        // Runs of at most 128 bytes in two.
        Compression::RLE => 64,
        // Blocks of 16 halfs in at least three bytes.
        Compression::B44 | Compression::B44A => 11,
        Compression::ZIP1 | Compression::ZIP16 | Compression::PXR24 | Compression::PIZ => 2 * DEFLATE_RATIO,
        // Two stages: run lengths or Huffman codes, deflated.
        _ => 64 * DEFLATE_RATIO,
    }
}

/// Refuses a part whose pixels break the limits or cannot come from the bytes present.
pub(crate) fn check_part(header: &Header, bytes: &[u8], limits: &DecodeLimits) -> Result<(), ImageError> {
    if header.deep {
        return Err(ImageError::unsupported(F, "deep data"));
    }
    let size = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    let samples = size.0.saturating_mul(size.1).saturating_mul(header.channels.bytes_per_pixel as u64);
    limits.check(F, size, samples, bytes.len(), expansion(header.compression))?;
    if let BlockDescription::Tiles(t) = header.blocks {
        // Decompression works on whole tiles, so a tile far larger than the picture is no harmless oddity.
        let (w, h) = (t.tile_size.width() as u64, t.tile_size.height() as u64);
        let tile = w.saturating_mul(h);
        if tile > limits.max_pixels || tile > (size.0 * size.1).saturating_mul(64).max(1 << 20) {
            return Err(ImageError::damaged(F, format!("tiles of {w} × {h} pixels in a smaller picture")));
        }
    }
    Ok(())
}

/// A row of samples of one channel as it came out of decompression, in the byte order of this machine.
pub(crate) struct Row<'a> {
    /// Index of the channel in the header.
    pub channel: usize,
    /// First column, relative to the data window.
    pub x: usize,
    /// Row, relative to the data window.
    pub y: usize,
    pub kind: SampleType,
    pub bytes: &'a [u8],
}

impl Row<'_> {
    /// The samples as floats; unsigned integers are converted by value.
    pub(crate) fn floats(&self) -> impl Iterator<Item = f32> + '_ {
        let kind = self.kind;
        self.bytes.chunks_exact(kind.bytes_per_sample()).map(move |b| match (kind, b) {
            (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
            (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
            (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
            _ => 0.0,
        })
    }

    /// The samples of an unsigned channel.
    fn uints(&self) -> impl Iterator<Item = u32> + '_ {
        self.bytes.chunks_exact(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]))
    }
}

/// Decodes the full-resolution level of the parts for which `want` holds, and hands each row to `put(part, row)`.
pub(crate) fn decode_rows(
    bytes: &[u8],
    want: impl Fn(usize) -> bool + Sync,
    mut put: impl FnMut(usize, Row<'_>),
) -> Result<(), ImageError> {
    let reader = block::read(Cursor::new(bytes), false).map_err(exr_error)?;
    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| want(block.layer) && tile.is_largest_resolution_level())
        .map_err(exr_error)?;
    let meta = chunks.meta_data().clone();
    let mut batch: Vec<Chunk> = Vec::with_capacity(BATCH);
    loop {
        batch.clear();
        for chunk in chunks.by_ref().take(BATCH) {
            batch.push(chunk.map_err(exr_error)?);
        }
        if batch.is_empty() {
            return Ok(());
        }
        let blocks: Vec<_> = std::mem::take(&mut batch)
            .into_par_iter()
            .map(|c| {
                // The offset table may point at a chunk that was not asked for.
                let wanted = want(c.layer_index) && is_full_resolution(&c);
                if wanted {
                    check_chunk(&meta.headers[c.layer_index], &c.compressed_block)?;
                    UncompressedBlock::decompress_chunk(c, &meta, false).map(Some)
                } else {
                    Ok(None)
                }
            })
            .collect::<Result<Vec<_>, _>>()
            .map_err(exr_error)?;
        for block in blocks {
            let Some(block) = block else {
                return Err(ImageError::damaged(F, "the offset table points at the wrong chunk"));
            };
            let header = &meta.headers[block.index.layer];
            for line in block.lines(&header.channels) {
                let p = line.location.position;
                let kind = header.channels.list[line.location.channel].sample_type;
                let row = Row { channel: line.location.channel, x: p.x(), y: p.y(), kind, bytes: line.value };
                put(block.index.layer, row);
            }
        }
    }
}

/// Refuses a DWA chunk whose own counters claim more than its pixels need or its bytes can hold: the decompressor
/// allocates by them.
fn check_chunk(header: &Header, block: &CompressedBlock) -> Result<(), ExrError> {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let (CompressedBlock::ScanLine(CompressedScanLineBlock { compressed_pixels_le: bytes, .. })
    | CompressedBlock::Tile(CompressedTileBlock { compressed_pixels_le: bytes, .. })) = block
    else {
        return Ok(());
    };
    let size = header.get_absolute_block_pixel_coordinates(header.get_block_data_indices(block)?)?.size;
    // Data that would not shrink are stored without the counters.
    if bytes.len() == size.area() * header.channels.bytes_per_pixel {
        return Ok(());
    }
    // Coefficients come in blocks of 8 × 8; no section takes more than eight bytes for a sample.
    let samples =
        size.width().next_multiple_of(8) * size.height().next_multiple_of(8) * header.channels.list.len();
    let most = (8 * samples).min(2 * DEFLATE_RATIO as usize * bytes.len()) as u64 + 64;
    // The header is eleven 64-bit counters; these five are decompressed sizes.
    let too_large = |i: usize| {
        bytes
            .get(8 * i..8 * i + 8)
            .is_some_and(|b| b.iter().rev().fold(0, |v, b| v << 8 | u64::from(*b)) > most)
    };
    if [1, 6, 7, 8, 9].into_iter().any(too_large) {
        return Err(ExrError::Invalid("the counters of a DWA chunk are too large".into()));
    }
    Ok(())
}

fn is_full_resolution(c: &Chunk) -> bool {
    use CompressedBlock::*;
    match &c.compressed_block {
        Tile(t) => t.coordinates.is_largest_resolution_level(),
        DeepTile(t) => t.coordinates.is_largest_resolution_level(),
        ScanLine(_) | DeepScanLine(_) => true,
    }
}

/// Reads all flat parts of an OpenEXR file with all their channels.
///
/// Channels are grouped into layers by what stands before the last dot of their name, a part's name coming first
/// (`beauty` + `diffuse.R` → layer `beauty.diffuse`, channel `R`) when the file has several parts. Half channels become
/// [`ChannelData::Color`], float channels [`ChannelData::F32`], unsigned ones [`ChannelData::U32`]. Only parts whose data
/// window has the size and place of the first one's are kept together; others are an error.
///
/// # Errors
/// [`ImageError::Damaged`], [`ImageError::Unsupported`] (deep data, subsampled channels, HTJ2K),
/// [`ImageError::TooLarge`].
pub fn read_exr_layers(bytes: &[u8], limits: &DecodeLimits) -> Result<ExrImage, ImageError> {
    let meta = read_headers(bytes)?;
    let headers = &meta.headers;
    let first = headers.first().ok_or_else(|| ImageError::damaged(F, "it has no parts"))?;
    let (width, height) = (first.layer_size.width(), first.layer_size.height());
    let mut total = 0u64;
    for h in headers {
        check_part(h, bytes, limits)?;
        if h.layer_size != first.layer_size
            || h.own_attributes.layer_position != first.own_attributes.layer_position
        {
            return Err(ImageError::unsupported(F, "parts of different sizes in one picture"));
        }
        // Halves are widened to floats.
        total += (width * height) as u64 * 4 * h.channels.list.len() as u64;
    }
    limits.check(F, (width as u64, height as u64), total, usize::MAX, 1)?;

    // Made when the first chunks have been decompressed: a damaged file that fails there has cost nothing.
    let mut planes: Vec<Vec<ChannelData>> = Vec::new();
    let allocate = || {
        let plane = |kind| match kind {
            SampleType::F16 => ChannelData::Color(vec![0.0; width * height]),
            SampleType::F32 => ChannelData::F32(vec![0.0; width * height]),
            SampleType::U32 => ChannelData::U32(vec![0; width * height]),
        };
        headers.iter().map(|h| h.channels.list.iter().map(|c| plane(c.sample_type)).collect()).collect()
    };
    decode_rows(
        bytes,
        |_| true,
        |part, row| {
            if planes.is_empty() {
                planes = allocate();
            }
            let at = row.y * width + row.x;
            match &mut planes[part][row.channel] {
                ChannelData::Color(p) | ChannelData::F32(p) => {
                    p[at..].iter_mut().zip(row.floats()).for_each(|(p, v)| *p = v);
                }
                ChannelData::U32(p) => p[at..].iter_mut().zip(row.uints()).for_each(|(p, v)| *p = v),
            }
        },
    )?;

    let mut layers: Vec<Layer> = Vec::new();
    for (header, planes) in headers.iter().zip(planes) {
        let part = match &header.own_attributes.layer_name {
            Some(n) if headers.len() > 1 => n.to_string(),
            _ => String::new(),
        };
        for (description, data) in header.channels.list.iter().zip(planes) {
            let full = description.name.to_string();
            let (prefix, channel) = full.rsplit_once('.').unwrap_or(("", &full));
            let name = match (part.as_str(), prefix) {
                ("", p) | (p, "") => p.to_string(),
                (a, b) => format!("{a}.{b}"),
            };
            let channel = (channel.to_string(), data);
            match layers.iter_mut().find(|l| l.name == name) {
                Some(l) => l.channels.push(channel),
                None => layers.push(Layer { name, channels: vec![channel] }),
            }
        }
    }
    // "A, B, G, R" as the file sorts them is nobody's order.
    for l in &mut layers {
        l.channels.sort_by_key(|(n, _)| ("RGBAXYZUV".find(n.as_str()).unwrap_or(9), n.clone()));
    }
    Ok(ExrImage { width: width as u32, height: height as u32, layers, metadata: metadata(first) })
}

/// The texts of a header, by attribute name.
fn metadata(h: &Header) -> Metadata {
    let mut m = Metadata::default();
    let own = &h.own_attributes;
    for (name, value) in [
        ("software", &own.software_name),
        ("comments", &own.comments),
        ("owner", &own.owner),
        ("capDate", &own.capture_date),
    ] {
        if let Some(v) = value {
            m.set(name, v.to_string());
        }
    }
    if let Some(layout) = own.environment_map {
        let cube = layout == EnvironmentMap::Cube;
        m.set("envmap", if cube { "cube" } else { "latlong" });
    }
    let mut other: Vec<(String, String)> = own
        .other
        .iter()
        .chain(&h.shared_attributes.other)
        .filter_map(|(n, v)| match v {
            AttributeValue::Text(t) => Some((n.to_string(), String::from_utf8_lossy(t.bytes()).into_owned())),
            _ => None,
        })
        .collect();
    other.sort();
    m.entries.extend(other);
    m
}
