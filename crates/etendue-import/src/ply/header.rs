//! What a PLY file says that it holds.

use crate::error::Fault;
use crate::text::{number, shown, words};
use crate::warning::Warnings;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn read(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number in the binary forms.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The largest number of an integer type, which stands for 1 in colours; `None` for floats.
    pub fn largest(self) -> Option<f64> {
        Some(match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::I32 => 2_147_483_647.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 | Self::F64 => return None,
        })
    }
}

/// A property of an element: a number, or a list of as many as a number before it says.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Type,
    /// Type of the length, for a list.
    pub list: Option<Type>,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// From a comment `TextureFile NAME`.
    pub texture: Option<String>,
    /// The first other comment.
    pub comment: Option<String>,
    /// Its size.
    pub bytes: usize,
    /// Its number of lines.
    pub lines: u64,
}

/// Larger than any header that is written.
const MOST: usize = 1 << 20;

impl Header {
    pub fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<Self, Fault> {
        let mut encoding = None;
        let mut out = Self {
            encoding: Encoding::Text,
            elements: Vec::new(),
            texture: None,
            comment: None,
            bytes: 0,
            lines: 0,
        };
        loop {
            let rest = &bytes[out.bytes..bytes.len().min(MOST)];
            let Some(end) = rest.iter().position(|b| matches!(b, b'\n' | b'\r')) else {
                return Err(Fault::line(out.lines + 1, "the header does not end: `end_header` is missing"));
            };
            let line = &rest[..end];
            out.bytes += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
            out.lines += 1;
            let n = out.lines;
            let mut w = words(line);
            let fault = |message: String| Err(Fault::line(n, message));
            match w.next() {
                Some(b"ply") if n == 1 => {}
                _ if n == 1 => return fault("the first line is not `ply`".into()),
                None => {}
                Some(b"format") => {
                    encoding = match w.next() {
                        Some(b"ascii") => Some(Encoding::Text),
                        Some(b"binary_little_endian") => Some(Encoding::Little),
                        Some(b"binary_big_endian") => Some(Encoding::Big),
                        other => {
                            return fault(format!(
                                "the format `{}` is none of ascii, binary_little_endian, binary_big_endian",
                                shown(other.unwrap_or_default())
                            ));
                        }
                    };
                    if w.next() != Some(b"1.0") {
                        warnings.add(format!("line {n}"), "the version is not 1.0; read as such");
                    }
                }
                Some(b"comment" | b"obj_info") => out.comment(line.trim_ascii()),
                Some(b"element") => {
                    let (Some(name), Some(count)) = (w.next(), w.next().and_then(number)) else {
                        return fault("an element has a name and a count".into());
                    };
                    out.elements.push(Element { name: shown(name), count, properties: Vec::new() });
                }
                Some(b"property") => {
                    let Some(e) = out.elements.last_mut() else {
                        return fault("a property stands before the first element".into());
                    };
                    e.properties.push(property(&mut w).map_err(|m| Fault::line(n, m))?);
                }
                Some(b"end_header") => break,
                Some(other) => return fault(format!("`{}` is not known in a header", shown(other))),
            }
        }
        out.encoding = encoding.ok_or_else(|| Fault::line(out.lines, "the header names no format"))?;
        Ok(out)
    }

    fn comment(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line);
        let text = text.split_once(char::is_whitespace).map_or("", |(_, t)| t.trim());
        match text.strip_prefix("TextureFile") {
            Some(name) if self.texture.is_none() => self.texture = Some(name.trim().to_owned()),
            _ if self.comment.is_none() && !text.is_empty() => self.comment = Some(shown(text.as_bytes())),
            _ => {}
        }
    }
}

fn property<'a>(w: &mut impl Iterator<Item = &'a [u8]>) -> Result<Property, String> {
    let mut kind = || {
        let word = w.next().unwrap_or_default();
        if word == b"list" {
            Ok(None)
        } else {
            Type::read(word).map(Some).ok_or_else(|| format!("`{}` is no type of a number", shown(word)))
        }
    };
    let (list, kind) = match kind()? {
        Some(t) => (None, t),
        None => {
            let (Some(length), Some(t)) = (kind()?, kind()?) else { return Err("a list of lists".into()) };
            if length.largest().is_none() {
                return Err("the length of a list is no whole number".into());
            }
            (Some(length), t)
        }
    };
    let name = shown(w.next().ok_or("the property has no name")?);
    Ok(Property { name, kind, list })
}
