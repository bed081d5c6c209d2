//! A film as a file: what an interrupted, distributed or later continued run is made of.
//!
//! Layout: the magic `ETFILM01`, the header's length (u32, little-endian), the header (JSON), then for each plane of sums,
//! and for each of its sixteen bytes from the lowest up, that byte of every pixel, deflated, preceded by its compressed
//! length (u64); then the id passes; at the end the CRC-32 of all before. Splitting by bytes puts the many zero bytes of a
//! 128-bit sum next to each other.

use crate::film::{Coverage, Film, SampleRanges};
use crate::{Fixed, PassSet};
use miniz_oxide::deflate::compress_to_vec;
use miniz_oxide::inflate::decompress_to_vec_with_limit;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const MAGIC: &[u8; 8] = b"ETFILM01";

/// What a film file says of itself beside the sums.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilmInfo {
    /// Identifies scene, camera and settings: only films with the same one add.
    pub picture: String,
    /// Whatever the program that wrote it wants to know later: command, version, tone curve …
    pub notes: BTreeMap<String, String>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    width: u32,
    height: u32,
    passes: String,
    ranges: Vec<(u32, u32)>,
    rejected: u64,
    #[serde(flatten)]
    info: FilmInfo,
}

/// Why bytes are no film.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// Another kind of file.
    #[error("not a film file: it does not begin with ETFILM01")]
    Magic,
    /// Shorter than it says.
    #[error("the film file is cut off after {0} bytes")]
    Truncated(usize),
    /// The checksum at the end does not fit.
    #[error("the film file is damaged: its checksum does not match")]
    Checksum,
    /// The header does not make sense.
    #[error("the film file's header is invalid: {0}")]
    Header(String),
    /// A block does not decompress to what it must.
    #[error("the film file is damaged in plane {0}")]
    Plane(usize),
}

/// Largest film that is read, pixels: 65536 × 16384.
const MAX_PIXELS: u64 = 1 << 30;

impl Film {
    /// The film as bytes of a file.
    pub fn to_bytes(&self, info: &FilmInfo) -> Vec<u8> {
        let header = Header {
            width: self.width,
            height: self.height,
            passes: self.passes.to_string(),
            ranges: self.ranges.as_slice().to_vec(),
            rejected: self.rejected,
            info: info.clone(),
        };
        let header = serde_json::to_vec(&header).expect("a header is plain data");
        let mut out = MAGIC.to_vec();
        out.extend((header.len() as u32).to_le_bytes());
        out.extend(header);
        let stride = self.stride();
        let blocks: Vec<Vec<u8>> = (0..stride * 16)
            .into_par_iter()
            .map(|k| {
                let (plane, byte) = (k / 16, k % 16);
                let raw: Vec<u8> =
                    self.sums.iter().skip(plane).step_by(stride).map(|s| s.0.to_le_bytes()[byte]).collect();
                compress_to_vec(&raw, 1)
            })
            .collect();
        let ids = self.ids.par_iter().map(|coverage| {
            let mut raw = Vec::new();
            for c in coverage {
                raw.extend((c.len() as u32).to_le_bytes());
                for (id, n) in c {
                    raw.extend(id.to_le_bytes());
                    raw.extend(n.to_le_bytes());
                }
            }
            let mut block = (raw.len() as u64).to_le_bytes().to_vec();
            block.extend(compress_to_vec(&raw, 1));
            block
        });
        for block in blocks.into_iter().chain(ids.collect::<Vec<_>>()) {
            out.extend((block.len() as u64).to_le_bytes());
            out.extend(block);
        }
        out.extend(crc32fast::hash(&out).to_le_bytes());
        out
    }

    /// Reads what [`Film::to_bytes`] wrote.
    ///
    /// # Errors
    /// The first thing that is wrong. Allocates no more than the header's size asks for, and that only after the checksum
    /// has been found right.
    pub fn from_bytes(bytes: &[u8]) -> Result<(Self, FilmInfo), FilmError> {
        if !bytes.starts_with(MAGIC) {
            return Err(FilmError::Magic);
        }
        let truncated = || FilmError::Truncated(bytes.len());
        let (body, crc) = bytes.split_last_chunk::<4>().ok_or_else(truncated)?;
        let mut rest = &body[MAGIC.len().min(body.len())..];
        let (length, tail) = rest.split_first_chunk::<4>().ok_or_else(truncated)?;
        let header = tail.get(..u32::from_le_bytes(*length) as usize).ok_or_else(truncated)?;
        rest = &tail[header.len()..];
        if crc32fast::hash(body) != u32::from_le_bytes(*crc) {
            return Err(FilmError::Checksum);
        }
        let h: Header = serde_json::from_slice(header).map_err(|e| FilmError::Header(e.to_string()))?;
        let pixels = u64::from(h.width) * u64::from(h.height);
        if pixels == 0 || pixels > MAX_PIXELS {
            return Err(FilmError::Header(format!("{} × {} pixels", h.width, h.height)));
        }
        let passes = PassSet::parse(&h.passes).map_err(FilmError::Header)?;
        let ranges = SampleRanges::new(h.ranges)
            .map_err(|s| FilmError::Header(format!("sample {s} is held twice")))?;
        let pixels = pixels as usize;
        let mut next = || -> Result<&[u8], FilmError> {
            let (length, tail) = rest.split_first_chunk::<8>().ok_or_else(truncated)?;
            let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| truncated())?;
            let block = tail.get(..length).ok_or_else(truncated)?;
            rest = &tail[length..];
            Ok(block)
        };
        let stride = Self::stride_of(passes);
        let blocks = (0..stride * 16).map(|_| next()).collect::<Result<Vec<_>, _>>()?;
        let id_blocks = [next()?, next()?];
        let mut film = Self::new(h.width, h.height, passes);
        for plane in 0..stride {
            let bytes: Vec<Vec<u8>> = blocks[plane * 16..][..16]
                .par_iter()
                .map(|b| decompress_to_vec_with_limit(b, pixels).ok().filter(|v| v.len() == pixels))
                .collect::<Option<_>>()
                .ok_or(FilmError::Plane(plane))?;
            for (i, sum) in film.sums.iter_mut().skip(plane).step_by(stride).enumerate() {
                *sum = Fixed(i128::from_le_bytes(std::array::from_fn(|b| bytes[b][i])));
            }
        }
        for (kind, block) in id_blocks.into_iter().enumerate() {
            film.ids[kind] = read_ids(block, film.ids[kind].len()).ok_or(FilmError::Plane(stride + kind))?;
        }
        film.ranges = ranges;
        film.rejected = h.rejected;
        Ok((film, h.info))
    }
}

fn read_ids(block: &[u8], pixels: usize) -> Option<Vec<Coverage>> {
    let (length, packed) = block.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    // Deflate packs no better than 1032 : 1.
    if length > packed.len().saturating_mul(1040).saturating_add(64) {
        return None;
    }
    let raw = decompress_to_vec_with_limit(packed, length).ok().filter(|v| v.len() == length)?;
    let mut words = raw.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]));
    let mut out = Vec::with_capacity(pixels);
    for _ in 0..pixels {
        let mut c = Coverage::new();
        for _ in 0..words.next()? {
            c.insert(words.next()?, words.next()?);
        }
        out.push(c);
    }
    words.next().is_none().then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pass;

    fn film() -> Film {
        let mut f = Film::new(7, 5, PassSet::default().with(Pass::Depth).with(Pass::ObjectId));
        for (i, s) in f.sums.iter_mut().enumerate() {
            *s = Fixed::from_f32((i as f32 - 90.0) * 0.37);
        }
        for (i, c) in f.ids[0].iter_mut().enumerate() {
            c.insert(i as u32 % 3, 4);
        }
        f.ids[0][3].insert(99, 2);
        f.ranges = SampleRanges::new([(0, 4), (8, 9)]).unwrap();
        f.rejected = 2;
        f
    }

    #[test]
    fn comes_back_as_it_was() {
        let info =
            FilmInfo { picture: "ab12".into(), notes: BTreeMap::from([("command".into(), "x".into())]) };
        let f = film();
        let (g, i) = Film::from_bytes(&f.to_bytes(&info)).unwrap();
        assert_eq!((f, info), (g, i));
    }

    #[test]
    fn damage_is_an_error() {
        let bytes = film().to_bytes(&FilmInfo::default());
        assert_eq!(Film::from_bytes(b"PNG").unwrap_err(), FilmError::Magic);
        for cut in [8, 11, 12, 40, bytes.len() / 2, bytes.len() - 1] {
            assert!(Film::from_bytes(&bytes[..cut]).is_err(), "cut at {cut}");
        }
        for i in (8..bytes.len()).step_by(7) {
            let mut b = bytes.clone();
            b[i] ^= 0x40;
            assert!(Film::from_bytes(&b).is_err(), "flip at {i}");
        }
    }

    /// A file whose checksum is right but whose contents lie: no panic, no large allocation.
    #[test]
    fn forged_headers_are_errors() {
        let forge = |header: &str| {
            let mut b = MAGIC.to_vec();
            b.extend((header.len() as u32).to_le_bytes());
            b.extend(header.as_bytes());
            b.extend([0; 64]);
            b.extend(crc32fast::hash(&b).to_le_bytes());
            Film::from_bytes(&b)
        };
        let h = |w: u32, rest: &str| {
            format!(
                r#"{{"width":{w},"height":{w},"passes":"","rejected":0,"picture":"","notes":{{}},{rest}}}"#
            )
        };
        assert!(matches!(forge(&h(0, r#""ranges":[]"#)), Err(FilmError::Header(_))));
        assert!(matches!(forge(&h(4_000_000_000, r#""ranges":[]"#)), Err(FilmError::Header(_))));
        assert!(matches!(forge(&h(9, r#""ranges":[[0,4],[2,6]]"#)), Err(FilmError::Header(_))));
        assert!(forge(&h(30_000, r#""ranges":[[0,4]]"#)).is_err());
        assert!(matches!(forge("{"), Err(FilmError::Header(_))));
    }
}
