//! Lines, words and numbers of the text formats (OBJ, MTL, the ASCII forms of PLY and STL).

use std::borrow::Cow;
use std::str::FromStr;

/// The lines of a text with their numbers, from 1. A `\` at the end of a line joins the next one to it.
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    /// The lines of `text`; a byte order mark is skipped.
    pub fn new(text: &'a [u8]) -> Self {
        Self { rest: text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text), number: 0 }
    }

    /// The next line as it stands, without its end. Lines end with LF, CR LF, or CR alone.
    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = match rest {
            [b'\r', b'\n', more @ ..] | [b'\r' | b'\n', more @ ..] => more,
            _ => rest,
        };
        Some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let line = self.physical()?;
        let number = self.number;
        let Some(first) = line.strip_suffix(b"\\") else { return Some((number, Cow::Borrowed(line))) };
        let mut joined = first.to_vec();
        while let Some(line) = self.physical() {
            joined.push(b' ');
            match line.strip_suffix(b"\\") {
                Some(more) => joined.extend_from_slice(more),
                None => {
                    joined.extend_from_slice(line);
                    break;
                }
            }
        }
        Some((number, Cow::Owned(joined)))
    }
}

/// The words of a line, separated by white space.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
}

/// The first word of `line` and what follows it, without white space at either end.
pub(crate) fn split_word(line: &[u8]) -> (&[u8], &[u8]) {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// The number that `word` spells; `None` if it is none.
pub(crate) fn number<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Text for people: bytes that are not UTF-8 are replaced, long text is cut short.
pub(crate) fn shown(bytes: &[u8]) -> String {
    const MOST: usize = 120;
    let cut = bytes.len() > MOST;
    let mut s = String::from_utf8_lossy(&bytes[..bytes.len().min(MOST)]).into_owned();
    if cut {
        s.push_str("...");
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_and_joined() {
        let text = b"\xef\xbb\xbfa b\r\nc \\\nd\\\r\ne\rf\n\n\tg";
        let lines: Vec<_> =
            Lines::new(text).map(|(n, l)| (n, String::from_utf8_lossy(&l).into_owned())).collect();
        let expected = [(1, "a b"), (2, "c  d e"), (5, "f"), (6, ""), (7, "\tg")];
        assert_eq!(lines, expected.map(|(n, l)| (n, l.to_owned())));
        assert_eq!(Lines::new(b"a\\").map(|(_, l)| l.into_owned()).collect::<Vec<_>>(), [b"a"]);
    }

    #[test]
    fn words_and_numbers() {
        assert_eq!(words(b" v  1\t2 ").collect::<Vec<_>>(), [&b"v"[..], b"1", b"2"]);
        assert_eq!(split_word(b"  usemtl  a b "), (&b"usemtl"[..], &b"a b"[..]));
        assert_eq!(number::<f32>(b"-1.5e2"), Some(-150.0));
        assert_eq!((number::<f32>(b"1,5"), number::<i64>(b"\xff")), (None, None));
    }
}
