//! The binary container of glTF (glTF 2.0, chapter 4): a header, a JSON chunk, a chunk of bytes.

use crate::error::Fault;
use crate::warning::Warnings;

/// The parts of a model file.
#[derive(Debug)]
pub(crate) struct Container<'a> {
    pub json: &'a [u8],
    /// The binary chunk of a GLB.
    pub binary: Option<&'a [u8]>,
    pub is_glb: bool,
}

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Splits a GLB into its chunks; anything that does not start like one is taken for JSON.
pub(crate) fn split<'a>(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Container<'a>, Fault> {
    if !bytes.starts_with(b"glTF") {
        return match bytes.iter().find(|b| !b.is_ascii_whitespace()) {
            Some(b'{' | 0xef) => Ok(Container { json: bytes, binary: None, is_glb: false }),
            None => Err(at(0, "the file is empty")),
            Some(_) => Err(at(0, "neither GLB (starts with `glTF`) nor JSON (starts with `{`)")),
        };
    }
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    match word(4) {
        None => return Err(at(4, "the file ends within the GLB header of 12 bytes")),
        Some(1) => {
            return Err(Fault::Unsupported {
                pointer: "byte 4".into(),
                what: "binary glTF 1".into(),
                hint: "; glTF 2.0 is. Export the model again as glTF 2.0".into(),
            });
        }
        Some(2) => {}
        Some(v) => return Err(at(4, format!("GLB version {v}; 2 is read"))),
    }
    let Some(length) = word(8) else { return Err(at(8, "the file ends within the GLB header of 12 bytes")) };
    let length = length as usize;
    if length > bytes.len() {
        return Err(at(8, format!("the GLB is cut off: {length} bytes announced, {} present", bytes.len())));
    }
    if length < bytes.len() {
        warnings.add("", format!("{} bytes after the end of the GLB; ignored", bytes.len() - length));
    }
    let mut parts = Container { json: &[], binary: None, is_glb: true };
    let mut pos = 12;
    let mut n = 0;
    while pos < length {
        let (Some(size), Some(kind)) = (word(pos), word(pos + 4)) else {
            return Err(at(pos, "the file ends within a chunk's header"));
        };
        let start = pos + 8;
        let Some(end) = start.checked_add(size as usize).filter(|&e| e <= length) else {
            return Err(at(pos, format!("a chunk of {size} bytes reaches beyond the end of the GLB")));
        };
        let data = &bytes[start..end];
        match (n, kind) {
            (0, JSON) => parts.json = data,
            (0, _) => return Err(at(pos, "the first chunk is not JSON")),
            (1, BIN) => parts.binary = Some(data),
            (_, JSON | BIN) => {
                warnings.add("", format!("chunk {n} at byte {pos} repeats JSON or BIN; ignored"));
            }
            // Unknown chunks must be skipped (glTF 2.0, 4.4.1).
            _ => {}
        }
        n += 1;
        pos = end;
    }
    if n == 0 {
        return Err(at(12, "no JSON chunk"));
    }
    Ok(parts)
}

fn at(offset: usize, message: impl Into<String>) -> Fault {
    Fault::Container { offset: offset as u64, message: message.into() }
}

/// Puts a GLB together: JSON, and a chunk of `length` bytes in `pieces` that each begin at a multiple of four, if there is
/// to be one.
///
/// # Errors
/// The size, if it is beyond what the container can say.
pub(crate) fn join<'p>(
    text: &[u8],
    pieces: impl Iterator<Item = &'p [u8]>,
    length: Option<u64>,
) -> Result<Vec<u8>, u64> {
    let four = |n: u64| n.next_multiple_of(4);
    let binary = length.map_or(0, |n| 8 + four(n));
    let total = 12 + 8 + four(text.len() as u64) + binary;
    let size = u32::try_from(total).map_err(|_| total)?;
    let mut out = Vec::with_capacity(total as usize);
    let word = |out: &mut Vec<u8>, w: u32| out.extend_from_slice(&w.to_le_bytes());
    for w in [u32::from_le_bytes(*b"glTF"), 2, size, four(text.len() as u64) as u32, JSON] {
        word(&mut out, w);
    }
    out.extend_from_slice(text);
    out.resize(out.len().next_multiple_of(4), b' ');
    if let Some(n) = length {
        word(&mut out, four(n) as u32);
        word(&mut out, BIN);
        pieces.for_each(|p| {
            out.extend_from_slice(p);
            out.resize(out.len().next_multiple_of(4), 0);
        });
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*data);
        }
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((12 + body.len() as u32).to_le_bytes());
        out.extend(body);
        out
    }

    #[test]
    fn splits_chunks_and_skips_unknown_ones() {
        let bytes = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"1234"), (b"XYZ ", b"56")]);
        let c = split(&bytes, &mut Warnings::default()).unwrap();
        assert_eq!((c.json, c.binary), (&b"{}  "[..], Some(&b"1234"[..])));
    }

    #[test]
    fn every_cut_is_a_fault_that_says_where() {
        let bytes = glb(&[(b"JSON", b"{}  "), (b"BIN\0", b"1234")]);
        for cut in 4..bytes.len() {
            let e = split(&bytes[..cut], &mut Warnings::default());
            assert!(matches!(e, Err(Fault::Container { .. })), "cut at {cut}: {e:?}");
        }
        // Cut with an honest header: a chunk that reaches beyond.
        for cut in 13..28 {
            let mut b = bytes[..cut].to_vec();
            b[8..12].copy_from_slice(&(cut as u32).to_le_bytes());
            let whole_json = cut == 24;
            assert_eq!(split(&b, &mut Warnings::default()).is_ok(), whole_json, "cut at {cut}");
        }
    }
}
