//! The numbers of a PLY file, one after another, from text or bytes.

use super::header::{Element, Encoding, Property, Type};
use crate::error::Fault;
use crate::text::{number, shown};
use crate::warning::Warnings;

/// Reads numbers and knows where it stands.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    pos: usize,
    /// Of the first byte in the file.
    start: u64,
    /// The current one, in text.
    line: u64,
    encoding: Encoding,
}

impl<'a> Values<'a> {
    /// The numbers in `bytes`, which start at byte `start` of the file after `lines` lines.
    pub fn new(bytes: &'a [u8], start: u64, lines: u64, encoding: Encoding) -> Self {
        Self { bytes, pos: 0, start, line: lines + 1, encoding }
    }

    /// Something wrong here.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        match self.encoding {
            Encoding::Text => Fault::line(self.line, message),
            _ => Fault::byte(self.start + self.pos as u64, message),
        }
    }

    /// Checks that what is left may hold all of `e`, so that memory can be taken for it at once.
    pub fn check_room(&self, e: &Element) -> Result<(), Fault> {
        let least: usize = match self.encoding {
            // A digit and a separator for each.
            Encoding::Text => 2 * e.properties.len(),
            _ => e.properties.iter().map(|p| p.list.unwrap_or(p.kind).size()).sum(),
        };
        let left = (self.bytes.len() - self.pos) as u64;
        // The very last number needs no separator.
        if e.count.saturating_mul(least as u64) > left.saturating_add(1) {
            let message = format!(
                "{} elements `{}` announced, but only {left} bytes are left: the file is cut off",
                e.count, e.name
            );
            return Err(self.fault(message));
        }
        Ok(())
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], Fault> {
        let Some(b) = self.bytes.get(self.pos..self.pos + n) else {
            return Err(self.fault("the file is cut off"));
        };
        self.pos += n;
        Ok(b)
    }

    fn word(&mut self) -> Result<&'a [u8], Fault> {
        while let Some(b) = self.bytes.get(self.pos).filter(|b| b.is_ascii_whitespace()) {
            self.line += u64::from(*b == b'\n');
            self.pos += 1;
        }
        let rest = &self.bytes[self.pos..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if end == 0 {
            return Err(self.fault("the file is cut off"));
        }
        self.pos += end;
        Ok(&rest[..end])
    }

    /// The next number.
    pub fn next(&mut self, t: Type) -> Result<f64, Fault> {
        if self.encoding == Encoding::Text {
            let word = self.word()?;
            return number(word).ok_or_else(|| self.fault(format!("`{}` is not a number", shown(word))));
        }
        let mut b = [0u8; 8];
        let n = t.size();
        b[..n].copy_from_slice(self.take(n)?);
        if self.encoding == Encoding::Big {
            b[..n].reverse();
        }
        let [b0, b1, b2, b3, ..] = b;
        Ok(match t {
            Type::I8 => f64::from(b0 as i8),
            Type::U8 => f64::from(b0),
            Type::I16 => f64::from(i16::from_le_bytes([b0, b1])),
            Type::U16 => f64::from(u16::from_le_bytes([b0, b1])),
            Type::I32 => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
            Type::U32 => f64::from(u32::from_le_bytes([b0, b1, b2, b3])),
            Type::F32 => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
            Type::F64 => f64::from_le_bytes(b),
        })
    }

    /// The next numbers that belong to property `p`, into `out`.
    pub fn property(&mut self, p: &Property, out: &mut Vec<f64>) -> Result<(), Fault> {
        out.clear();
        let Some(length) = p.list else {
            out.push(self.next(p.kind)?);
            return Ok(());
        };
        let n = self.next(length)?;
        let least = if self.encoding == Encoding::Text { 1 } else { p.kind.size() };
        let left = self.bytes.len() - self.pos;
        if !(n >= 0.0 && n.fract() == 0.0 && n * least as f64 <= left as f64) {
            return Err(self.fault(format!("a list `{}` of {n} numbers, with {left} bytes left", p.name)));
        }
        for _ in 0..n as usize {
            out.push(self.next(p.kind)?);
        }
        Ok(())
    }

    /// Passes over all of `e`.
    pub fn skip(&mut self, e: &Element) -> Result<(), Fault> {
        if e.properties.is_empty() {
            return Ok(());
        }
        let mut list = Vec::new();
        for _ in 0..e.count {
            for p in &e.properties {
                self.property(p, &mut list)?;
            }
        }
        Ok(())
    }

    /// Looks at what is left after the last element.
    pub fn end(&self, warnings: &mut Warnings) {
        let rest = &self.bytes[self.pos..];
        if rest.iter().any(|b| !b.is_ascii_whitespace() && *b != 0) {
            let place = format!("byte {}", self.start + self.pos as u64);
            warnings.add(place, format!("{} bytes after the last element; ignored", rest.len()));
        }
    }
}
