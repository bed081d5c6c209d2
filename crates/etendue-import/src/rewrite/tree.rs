//! A JSON document that keeps what nobody changes as it was written: the order of keys, the digits of numbers, the escapes of
//! strings.

use std::borrow::Cow;

/// A JSON value over the text that it was read from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree<'t> {
    /// A number, a string, `true`, `false` or `null`, as it is written.
    Leaf(Cow<'t, str>),
    Array(Vec<Self>),
    /// Keys as they are written, with their quotes, and their values.
    Object(Vec<(Cow<'t, str>, Self)>),
}

impl<'t> Tree<'t> {
    /// Reads a text that is known to be JSON and nested moderately; `None` if it is not JSON after all.
    pub fn read(text: &'t str) -> Option<Self> {
        let mut s = Scanner { text, at: 0 };
        let tree = s.value()?;
        s.space();
        (s.at == text.len()).then_some(tree)
    }

    /// A number.
    pub fn number(n: u64) -> Self {
        Self::Leaf(n.to_string().into())
    }

    /// A string.
    pub fn string(s: &str) -> Self {
        Self::Leaf(serde_json::Value::from(s).to_string().into())
    }

    /// An object of entries in their order; the keys need no escapes.
    pub fn object<const N: usize>(entries: [(&str, Self); N]) -> Self {
        Self::Object(entries.into_iter().map(|(k, v)| (format!("\"{k}\"").into(), v)).collect())
    }

    /// The value at `key` of an object; of several, the last, as everybody reads JSON.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let Self::Object(entries) = self else { return None };
        entries.iter().rev().find(|(k, _)| is(k, key)).map(|(_, v)| v)
    }

    /// As [`Tree::get`], to be changed.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Self> {
        let Self::Object(entries) = self else { return None };
        entries.iter_mut().rev().find(|(k, _)| is(k, key)).map(|(_, v)| v)
    }

    /// What is at the end of the keys, each within the one before.
    pub fn within(&self, keys: &[&str]) -> Option<&Self> {
        keys.iter().try_fold(self, |t, k| t.get(k))
    }

    /// As [`Tree::within`], to be changed.
    pub fn within_mut(&mut self, keys: &[&str]) -> Option<&mut Self> {
        keys.iter().try_fold(self, |t, k| t.get_mut(k))
    }

    /// Sets `key` of an object, in its place or at the end; other values stay what they are.
    pub fn set(&mut self, key: &str, value: Self) {
        match self.get_mut(key) {
            Some(v) => *v = value,
            None => {
                if let Self::Object(entries) = self {
                    entries.push((format!("\"{key}\"").into(), value));
                }
            }
        }
    }

    /// Takes `key` out of an object; true if it was there.
    pub fn remove(&mut self, key: &str) -> bool {
        let Self::Object(entries) = self else { return false };
        let before = entries.len();
        entries.retain(|(k, _)| !is(k, key));
        entries.len() < before
    }

    /// Takes the extension `name` off an object, with `extensions` itself if nothing else is in it; true if it was there.
    pub fn remove_extension(&mut self, name: &str) -> bool {
        let Some(e) = self.get_mut("extensions") else { return false };
        let was = e.remove(name);
        if was && e.entries().is_empty() {
            self.remove("extensions");
        }
        was
    }

    /// The entries of an object; nothing for other values.
    pub fn entries(&self) -> &[(Cow<'t, str>, Self)] {
        match self {
            Self::Object(entries) => entries,
            _ => &[],
        }
    }

    /// The values of an object with their keys, to be changed.
    pub fn entries_mut(&mut self) -> &mut [(Cow<'t, str>, Self)] {
        match self {
            Self::Object(entries) => entries,
            _ => &mut [],
        }
    }

    /// The elements of an array; nothing for other values.
    pub fn items(&self) -> &[Self] {
        match self {
            Self::Array(items) => items,
            _ => &[],
        }
    }

    /// As [`Tree::items`], to be changed.
    pub fn items_mut(&mut self) -> &mut [Self] {
        match self {
            Self::Array(items) => items,
            _ => &mut [],
        }
    }

    /// The elements of the array at `key`.
    pub fn list(&self, key: &str) -> &[Self] {
        self.get(key).map_or(&[], Self::items)
    }

    /// As [`Tree::list`], to be changed.
    pub fn list_mut(&mut self, key: &str) -> &mut [Self] {
        self.get_mut(key).map_or(&mut [], Self::items_mut)
    }

    /// Appends to the array at `key`, which is made if there is none; the element's number.
    pub fn push(&mut self, key: &str, value: Self) -> u32 {
        if self.get(key).is_none() {
            self.set(key, Self::Array(Vec::new()));
        }
        match self.get_mut(key) {
            Some(Self::Array(items)) => {
                items.push(value);
                (items.len() - 1) as u32
            }
            _ => 0,
        }
    }

    /// A whole number from 0 up; `3.0` is one, as for the reader of documents.
    pub fn index(&self) -> Option<u32> {
        let Self::Leaf(text) = self else { return None };
        if let Ok(n) = text.parse() {
            return Some(n);
        }
        let n: f64 = serde_json::from_str(text).ok()?;
        (n >= 0.0 && n.fract() == 0.0 && n <= f64::from(u32::MAX)).then_some(n as u32)
    }

    /// The content of a string.
    pub fn text(&self) -> Option<String> {
        let Self::Leaf(text) = self else { return None };
        serde_json::from_str(text).ok()
    }

    /// Appends the value as JSON without spaces.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Leaf(text) => out.extend_from_slice(text.as_bytes()),
            Self::Array(items) => {
                out.push(b'[');
                for (i, v) in items.iter().enumerate() {
                    if i > 0 {
                        out.push(b',');
                    }
                    v.write(out);
                }
                out.push(b']');
            }
            Self::Object(entries) => {
                out.push(b'{');
                for (i, (k, v)) in entries.iter().enumerate() {
                    if i > 0 {
                        out.push(b',');
                    }
                    out.extend_from_slice(k.as_bytes());
                    out.push(b':');
                    v.write(out);
                }
                out.push(b'}');
            }
        }
    }
}

/// Whether the key that is written as `raw` says `key`.
fn is(raw: &str, key: &str) -> bool {
    let inner = raw.get(1..raw.len() - 1).unwrap_or_default();
    inner == key || (inner.contains('\\') && name(raw) == key)
}

/// What a key that is written as `raw` says.
pub(super) fn name(raw: &str) -> String {
    serde_json::from_str(raw).unwrap_or_default()
}

/// Goes through a text once. What it relies on was checked by who parsed the text before; it is not checked again here.
struct Scanner<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Scanner<'t> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    /// Skips spaces and takes `byte` if it comes next.
    fn take(&mut self, byte: u8) -> bool {
        self.space();
        let is = self.peek() == Some(byte);
        self.at += usize::from(is);
        is
    }

    fn value(&mut self) -> Option<Tree<'t>> {
        self.space();
        Some(match self.peek()? {
            b'[' => {
                self.at += 1;
                let mut items = Vec::new();
                while !self.take(b']') {
                    if !items.is_empty() && !self.take(b',') {
                        return None;
                    }
                    items.push(self.value()?);
                }
                items.shrink_to_fit();
                Tree::Array(items)
            }
            b'{' => {
                self.at += 1;
                let mut entries = Vec::new();
                while !self.take(b'}') {
                    if !entries.is_empty() && !self.take(b',') {
                        return None;
                    }
                    self.space();
                    let key = self.string()?;
                    if !self.take(b':') {
                        return None;
                    }
                    entries.push((key.into(), self.value()?));
                }
                entries.shrink_to_fit();
                Tree::Object(entries)
            }
            b'"' => Tree::Leaf(self.string()?.into()),
            _ => {
                let rest = &self.text[self.at..];
                let end = rest.find([',', ']', '}', ' ', '\t', '\n', '\r']).unwrap_or(rest.len());
                self.at += end;
                Tree::Leaf(rest.get(..end).filter(|s| !s.is_empty())?.into())
            }
        })
    }

    /// A string with its quotes.
    fn string(&mut self) -> Option<&'t str> {
        let start = self.at;
        if self.peek()? != b'"' {
            return None;
        }
        self.at += 1;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        self.text.get(start..self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(t: &Tree<'_>) -> String {
        let mut out = Vec::new();
        t.write(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn everything_stays_as_it_is_written() {
        let text = "{ \"z\" : [1.50, -0, 1e+3 ,{}, []],\n\"a\\u0041\":\"\\\"x\\\\\\u00e9 é\", \"n\": null,\"t\":true }  ";
        let kept = r#"{"z":[1.50,-0,1e+3,{},[]],"a\u0041":"\"x\\\u00e9 é","n":null,"t":true}"#;
        let t = Tree::read(text).unwrap();
        assert_eq!(written(&t), kept);
        let value = |s: &str| serde_json::from_str::<serde_json::Value>(s).unwrap();
        assert_eq!(value(text), value(kept));
        assert_eq!(t.get("aA").and_then(Tree::text).as_deref(), Some("\"x\\é é"));
        assert_eq!(t.list("z")[2].index(), Some(1000));
        assert_eq!((t.list("z")[0].index(), t.get("n").and_then(Tree::index)), (None, None));
    }

    #[test]
    fn changes_touch_nothing_else() {
        let mut t = Tree::read(r#"{"b":1,"a":2,"extensions":{"X":{},"Y":{}},"a":3}"#).unwrap();
        assert_eq!(t.get("a").and_then(Tree::index), Some(3));
        t.set("a", Tree::number(4));
        t.set("c", Tree::string("\u{1}/é"));
        assert!(t.remove("b") && !t.remove("b"));
        assert!(t.remove_extension("X") && !t.remove_extension("X") && t.remove_extension("Y"));
        assert_eq!(t.push("list", Tree::object([("k", Tree::number(0))])), 0);
        assert_eq!(t.push("list", Tree::number(7)), 1);
        assert_eq!(written(&t), r#"{"a":2,"a":4,"c":"\u0001/é","list":[{"k":0},7]}"#);
    }

    #[test]
    fn what_is_no_json_is_nothing() {
        for bad in ["", "{", "[1", "{\"a\"}", "{\"a\":}", "[1 2]", "\"", "\"\\", "1 2", "{1:2}", "[,]"] {
            assert_eq!(Tree::read(bad), None, "{bad}");
        }
    }
}
