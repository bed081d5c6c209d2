//! Reading typed values out of a JSON tree, knowing at every moment where in it one stands.

use crate::error::Fault;
use crate::extensions::{SWITCH, Support, XMP, is_draft, support};
use crate::warning::Warnings;
use serde_json::{Map, Value};

/// A JSON object.
pub(crate) type Object = Map<String, Value>;

#[derive(Clone, Copy)]
enum Step<'v> {
    Key(&'v str),
    Index(usize),
}

/// Walks a JSON tree. Keeps the path to the current value, so that faults and warnings can name it, and builds the
/// pointer's text only when one is needed.
pub(crate) struct Reader<'v> {
    path: Vec<Step<'v>>,
    /// What was odd but harmless.
    pub warnings: Warnings,
    /// Whether drafts of extensions are read.
    pub drafts: bool,
}

/// How one kind of value is read.
type Read<'v, T> = fn(&mut Reader<'v>, &'v Value) -> Result<T, Fault>;

/// Parses `text`; a byte order mark is skipped with a warning.
pub(crate) fn parse(mut text: &[u8], warnings: &mut Warnings) -> Result<Value, Fault> {
    if let Some(rest) = text.strip_prefix(b"\xef\xbb\xbf") {
        warnings.add("", "the JSON starts with a byte order mark, which glTF forbids; skipped");
        text = rest;
    }
    serde_json::from_slice(text).map_err(|e| {
        // serde_json repeats the place at the end of its message.
        let message = e.to_string();
        let message = message.split(" at line ").next().unwrap_or_default().to_owned();
        Fault::Json { line: e.line(), column: e.column(), message }
    })
}

/// An error if objects and arrays of `text` lie deeper within one another than `most`. Looks at brackets outside of strings, whether
/// or not the rest is JSON.
pub(crate) fn check_depth(text: &[u8], most: u32) -> Result<(), Fault> {
    let (mut depth, mut quoted, mut escaped) = (0u32, false, false);
    for &b in text {
        match b {
            _ if escaped => escaped = false,
            b'\\' if quoted => escaped = true,
            b'"' => quoted = !quoted,
            b'{' | b'[' if !quoted => {
                depth += 1;
                if depth > most {
                    let what = format!("more than {most} objects and arrays within one another");
                    return Err(Fault::TooLarge { pointer: String::new(), what, limit: "json_depth" });
                }
            }
            b'}' | b']' if !quoted => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    Ok(())
}

fn kind(v: &Value) -> &'static str {
    match v {
        Value::Null => "null",
        Value::Bool(_) => "a boolean",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}

impl<'v> Reader<'v> {
    pub fn new(warnings: Warnings, drafts: bool) -> Self {
        Self { path: Vec::new(), warnings, drafts }
    }

    /// The current place as a JSON pointer.
    pub fn pointer(&self) -> String {
        let mut s = String::new();
        for step in &self.path {
            s.push('/');
            match step {
                Step::Key(k) => s.push_str(&k.replace('~', "~0").replace('/', "~1")),
                Step::Index(i) => s.push_str(&i.to_string()),
            }
        }
        s
    }

    /// A fault at the current place.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::invalid(self.pointer(), message)
    }

    /// A warning at the current place.
    pub fn warn(&mut self, message: impl Into<String>) {
        let pointer = self.pointer();
        self.warnings.add(pointer, message);
    }

    /// Reads `o[key]` with `f` if it is there.
    pub fn opt<T>(
        &mut self,
        o: &'v Object,
        key: &'static str,
        f: impl FnOnce(&mut Self, &'v Value) -> Result<T, Fault>,
    ) -> Result<Option<T>, Fault> {
        let Some(value) = o.get(key) else { return Ok(None) };
        self.path.push(Step::Key(key));
        let r = f(self, value);
        self.path.pop();
        r.map(Some)
    }

    /// Reads `o[key]` with `f`; it must be there.
    pub fn req<T>(
        &mut self,
        o: &'v Object,
        key: &'static str,
        f: impl FnOnce(&mut Self, &'v Value) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        match self.opt(o, key, f)? {
            Some(v) => Ok(v),
            None => Err(self.fault(format!("`{key}` is missing"))),
        }
    }

    /// Reads `o[key]` with `f` where a faulty value does no harm: it is left out with a warning.
    pub fn soft<T>(
        &mut self,
        o: &'v Object,
        key: &'static str,
        f: impl FnOnce(&mut Self, &'v Value) -> Result<T, Fault>,
    ) -> Option<T> {
        self.harmless(|r| r.opt(o, key, f)).flatten()
    }

    /// What `f` reads, or nothing and a warning: for what does no harm when it is left out.
    pub fn harmless<T>(&mut self, f: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Option<T> {
        match f(self) {
            Ok(v) => Some(v),
            Err(Fault::Invalid { pointer, message }) => {
                self.warnings.add(pointer, format!("{message}; ignored"));
                None
            }
            Err(other) => {
                self.warn(format!("{}; ignored", other.message()));
                None
            }
        }
    }

    /// Reads the array `o[key]`, each entry with `f`; an absent array is empty.
    pub fn list<T>(
        &mut self,
        o: &'v Object,
        key: &'static str,
        f: impl Fn(&mut Self, &'v Value) -> Result<T, Fault>,
    ) -> Result<Vec<T>, Fault> {
        Ok(self.opt(o, key, |r, v| r.array(v, f))?.unwrap_or_default())
    }

    /// Reads `v` as an array, each entry with `f`.
    pub fn array<T>(
        &mut self,
        v: &'v Value,
        f: impl Fn(&mut Self, &'v Value) -> Result<T, Fault>,
    ) -> Result<Vec<T>, Fault> {
        let Value::Array(a) = v else {
            return Err(self.fault(format!("an array is needed, not {}", kind(v))));
        };
        let mut out = Vec::with_capacity(a.len());
        for (i, v) in a.iter().enumerate() {
            self.path.push(Step::Index(i));
            let r = f(self, v);
            self.path.pop();
            out.push(r?);
        }
        Ok(out)
    }

    /// Reads every entry of the object `v` with `f`.
    pub fn entries<T>(&mut self, v: &'v Value, f: Read<'v, T>) -> Result<Vec<(&'v str, T)>, Fault> {
        let o = self.object(v)?;
        let mut out = Vec::with_capacity(o.len());
        for (k, v) in o {
            self.path.push(Step::Key(k));
            let r = f(self, v);
            self.path.pop();
            out.push((k.as_str(), r?));
        }
        Ok(out)
    }

    pub fn object(&mut self, v: &'v Value) -> Result<&'v Object, Fault> {
        v.as_object().ok_or_else(|| self.fault(format!("an object is needed, not {}", kind(v))))
    }

    pub fn string(&mut self, v: &'v Value) -> Result<&'v str, Fault> {
        v.as_str().ok_or_else(|| self.fault(format!("a string is needed, not {}", kind(v))))
    }

    pub fn boolean(&mut self, v: &'v Value) -> Result<bool, Fault> {
        v.as_bool().ok_or_else(|| self.fault(format!("true or false is needed, not {}", kind(v))))
    }

    pub fn number(&mut self, v: &'v Value) -> Result<f64, Fault> {
        match v.as_f64() {
            Some(n) if n.is_finite() => Ok(n),
            _ => Err(self.fault(format!("a number is needed, not {}", kind(v)))),
        }
    }

    /// A whole number from 0 up; `3.0` counts as whole, as JSON does not tell.
    pub fn count(&mut self, v: &'v Value) -> Result<u64, Fault> {
        if let Some(n) = v.as_u64() {
            return Ok(n);
        }
        match v.as_f64() {
            Some(n) if n >= 0.0 && n.fract() == 0.0 && n <= 9e15 => Ok(n as u64),
            Some(n) => Err(self.fault(format!("a whole number from 0 up is needed, not {n}"))),
            None => Err(self.fault(format!("a whole number from 0 up is needed, not {}", kind(v)))),
        }
    }

    /// An index into one of the document's arrays; whether that entry exists is checked where it is used.
    pub fn index(&mut self, v: &'v Value) -> Result<u32, Fault> {
        let n = self.count(v)?;
        u32::try_from(n).map_err(|_| self.fault(format!("the index {n} is too large")))
    }

    /// `N` numbers.
    pub fn numbers<const N: usize>(&mut self, v: &'v Value) -> Result<[f64; N], Fault> {
        let a = self.array(v, Self::number)?;
        <[f64; N]>::try_from(a.as_slice())
            .map_err(|_| self.fault(format!("{N} numbers are needed, not {}", a.len())))
    }

    /// Reads the extension `name` of the object `o`, if it is used there (and asked for, if it is a draft).
    pub fn extension<T>(
        &mut self,
        o: &'v Object,
        name: &'static str,
        f: impl FnOnce(&mut Self, &'v Object) -> Result<T, Fault>,
    ) -> Result<Option<T>, Fault> {
        if !self.drafts && is_draft(name) {
            return Ok(None);
        }
        Ok(self
            .opt(o, "extensions", |r, v| {
                let e = r.object(v)?;
                r.opt(e, name, |r, v| {
                    let o = r.object(v)?;
                    f(r, o)
                })
            })?
            .flatten())
    }

    /// Warns of every extension of `o` that is not in `known`.
    pub fn other_extensions(&mut self, o: &'v Object, known: &[&str]) {
        let Some(Value::Object(e)) = o.get("extensions") else { return };
        let drafts = self.drafts;
        let read = |n: &String| known.contains(&n.as_str()) && (drafts || !is_draft(n));
        let beside = |n: &String| *n == XMP || support(n) == Some(Support::Ignored);
        for name in e.keys().filter(|n| !read(n) && !beside(n)) {
            self.path.push(Step::Key("extensions"));
            self.path.push(Step::Key(name));
            self.warn(if is_draft(name) && !drafts {
                format!("{name} is a draft; ignored without {SWITCH}")
            } else {
                format!("{name} is not supported yet; ignored")
            });
            self.path.truncate(self.path.len() - 2);
        }
    }
}
