//! From TOML to checked values.

use super::error::{SceneFileError, Text};
use super::key::{Key, Kind, Value};
use super::nearest::nearest;
use etendue_bxdf::model;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A key that was found, with its value and its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    /// Which of the keys that were looked for.
    pub key: usize,
    pub value: Value,
    /// The value's place.
    pub span: Range<usize>,
}

/// Where values are checked: the text that they stand in, and what its files may be.
pub(crate) struct Checker<'a> {
    pub text: &'a Text,
    /// Relative names start here.
    pub folder: &'a Path,
    /// Whether files may lie outside the folder.
    pub outside: bool,
}

/// A key and its value in a table.
pub(crate) type Item<'t, 'i> = (&'t str, Range<usize>, &'t Spanned<DeValue<'i>>);

/// The entries of a table in the order of the file.
pub(crate) fn items<'t, 'i>(table: &'t DeTable<'i>) -> Vec<Item<'t, 'i>> {
    let mut all: Vec<Item<'t, 'i>> = table.iter().map(|(k, v)| (k.get_ref().as_ref(), k.span(), v)).collect();
    all.sort_by_key(|(_, span, _)| span.start);
    all
}

/// What a value is, for messages.
fn what(v: &DeValue<'_>) -> &'static str {
    match v {
        DeValue::String(_) => "text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

fn number(v: &DeValue<'_>) -> Option<f64> {
    match v {
        DeValue::Integer(i) => integer_of(i.as_str(), i.radix()).map(|i| i as f64),
        DeValue::Float(f) => f.as_str().parse::<f64>().ok().filter(|v| v.is_finite()),
        _ => None,
    }
}

fn integer_of(digits: &str, radix: u32) -> Option<i64> {
    i64::from_str_radix(digits, radix).ok()
}

fn integer(v: &DeValue<'_>) -> Option<i64> {
    match v {
        DeValue::Integer(i) => integer_of(i.as_str(), i.radix()),
        _ => None,
    }
}

fn text<'v>(v: &'v DeValue<'_>) -> Option<&'v str> {
    match v {
        DeValue::String(s) => Some(s),
        _ => None,
    }
}

fn numbers(v: &DeValue<'_>) -> Option<Vec<f64>> {
    match v {
        // More than a matrix is nothing that is known.
        DeValue::Array(a) if a.len() <= 16 => a.iter().map(|v| number(v.get_ref())).collect(),
        _ => None,
    }
}

fn texts(v: &DeValue<'_>) -> Option<Vec<String>> {
    match v {
        DeValue::String(s) => Some(vec![s.to_string()]),
        DeValue::Array(a) => a.iter().map(|v| text(v.get_ref()).map(str::to_owned)).collect(),
        _ => None,
    }
}

/// A colour in linear Rec.709.
fn color(v: &DeValue<'_>) -> Option<Vec<f64>> {
    let found = match v {
        DeValue::String(s) if s.starts_with('#') => {
            let parameter = model::Parameter {
                name: "color",
                about: "",
                default: model::Value::Color([0.0; 3]),
                range: [0.0, 1.0],
                choices: &[],
            };
            match parameter.parse(s) {
                Ok(model::Value::Color(c)) => c.map(f64::from).to_vec(),
                _ => return None,
            }
        }
        DeValue::Array(_) => numbers(v).filter(|v| v.len() == 3)?,
        v => vec![number(v)?; 3],
    };
    found.iter().all(|v| *v >= 0.0).then_some(found)
}

impl Checker<'_> {
    /// Reads `table`, which may hold `keys` and nothing else. `place` names it in messages.
    pub fn table(
        &self,
        table: &DeTable<'_>,
        keys: &[&Key],
        place: &str,
    ) -> Result<Vec<Entry>, SceneFileError> {
        items(table)
            .into_iter()
            .map(|(name, span, value)| self.entry(name, &span, value, keys, place))
            .collect()
    }

    /// Reads one of `keys`.
    pub fn entry(
        &self,
        name: &str,
        span: &Range<usize>,
        value: &Spanned<DeValue<'_>>,
        keys: &[&Key],
        place: &str,
    ) -> Result<Entry, SceneFileError> {
        match keys.iter().position(|k| k.name == name) {
            Some(key) => {
                Ok(Entry { key, value: self.value(name, &keys[key].kind, value)?, span: value.span() })
            }
            None => Err(self.unknown(name, span, keys.iter().map(|k| k.name.as_str()), place)),
        }
    }

    /// The error for a name that there is not.
    pub fn unknown<'n>(
        &self,
        name: &str,
        span: &Range<usize>,
        known: impl Iterator<Item = &'n str> + Clone,
        place: &str,
    ) -> SceneFileError {
        let help = match nearest(name, known.clone()) {
            Some(n) => format!("did you mean `{n}`?"),
            None => {
                let mut list: Vec<_> = known.collect();
                list.sort_unstable();
                format!("there are {}", list.join(", "))
            }
        };
        self.text.wrong(span, format!("there is no `{}` {place}", shorten(name)), Some(help))
    }

    /// Checks one value.
    fn value(&self, name: &str, kind: &Kind, value: &Spanned<DeValue<'_>>) -> Result<Value, SceneFileError> {
        let (v, span) = (value.get_ref(), value.span());
        let wrong = |help: Option<String>| {
            let found = match v {
                DeValue::String(s) => format!("{:?}", shorten(s)),
                DeValue::Integer(i) => shorten(i.as_str()),
                DeValue::Float(f) => shorten(f.as_str()),
                DeValue::Boolean(b) => b.to_string(),
                v => what(v).to_owned(),
            };
            self.text.wrong(&span, format!("`{name}` is {found}, and has to be {}", kind.wanted()), help)
        };
        let word = |words: &[String], s: &str| match words.iter().any(|w| w == s) {
            true => Ok(Value::Text(s.to_owned())),
            false => Err(wrong(
                nearest(s, words.iter().map(String::as_str)).map(|n| format!("did you mean {n:?}?")),
            )),
        };
        let found = match kind {
            Kind::Flag => match v {
                DeValue::Boolean(b) => Some(Value::Flag(*b)),
                _ => None,
            },
            Kind::Number([low, high]) => number(v).filter(|v| (low..=high).contains(&v)).map(Value::Number),
            Kind::Integer([low, high]) => {
                integer(v).filter(|v| (low..=high).contains(&v)).map(Value::Integer)
            }
            Kind::Text => text(v).map(|s| Value::Text(s.to_owned())),
            Kind::Name => match integer(v) {
                Some(i) => (i >= 0).then_some(Value::Integer(i)),
                None => text(v).map(|s| Value::Text(s.to_owned())),
            },
            Kind::Time => match number(v) {
                Some(s) => (s >= 0.0).then_some(Value::Number(s)),
                None => text(v).map(|s| Value::Text(s.to_owned())),
            },
            Kind::Path => match text(v) {
                Some(s) => return self.path(s, &span).map(Value::Path),
                None => None,
            },
            Kind::Choice(words) => match text(v) {
                Some(s) => return word(words, s),
                None => None,
            },
            Kind::Words(words) => match texts(v) {
                Some(list) => {
                    let parts =
                        list.iter().flat_map(|s| s.split(',')).map(str::trim).filter(|s| !s.is_empty());
                    let parts: Vec<String> = parts.map(str::to_owned).collect();
                    for p in &parts {
                        word(words, p)?;
                    }
                    Some(Value::Texts(parts))
                }
                None => None,
            },
            Kind::Texts => texts(v).map(Value::Texts),
            Kind::Color => color(v).map(Value::Numbers),
            Kind::Vector => numbers(v).filter(|n| n.len() == 3).map(Value::Numbers),
            Kind::Numbers(counts) => match number(v) {
                Some(one) => counts.contains(&1).then(|| Value::Numbers(vec![one])),
                None => numbers(v).filter(|n| counts.contains(&n.len())).map(Value::Numbers),
            },
            Kind::Pair(between) => match v {
                DeValue::String(s) => Some(Value::Text(s.to_string())),
                DeValue::Array(a) if a.len() == 2 => {
                    let parts: Option<Vec<i64>> = a.iter().map(|v| integer(v.get_ref())).collect();
                    parts.map(|p| Value::Text(format!("{}{between}{}", p[0], p[1])))
                }
                _ => None,
            },
            Kind::Texture => match v {
                DeValue::Boolean(false) => Some(Value::Flag(false)),
                DeValue::String(s) => return self.path(s, &span).map(Value::Path),
                _ => None,
            },
            Kind::Sky(names) => match v {
                DeValue::String(s) if names.iter().any(|n| **n == **s) => Some(Value::Text(s.to_string())),
                DeValue::String(s) if s.starts_with('#') => color(v).map(Value::Numbers),
                DeValue::String(s) => return self.path(s, &span).map(Value::Path),
                v => color(v).map(Value::Numbers),
            },
            Kind::Table(keys) => match v {
                DeValue::Table(t) => {
                    let keys: Vec<&Key> = keys.iter().collect();
                    let entries = self.table(t, &keys, &format!("in `{name}`"))?;
                    Some(Value::Table(
                        entries.into_iter().map(|e| (keys[e.key].name.clone(), e.value)).collect(),
                    ))
                }
                _ => None,
            },
        };
        found.ok_or_else(|| wrong(None))
    }

    /// Where a file name leads; it has to stay below the scene file's folder unless more is allowed.
    fn path(&self, name: &str, span: &Range<usize>) -> Result<PathBuf, SceneFileError> {
        if name.is_empty() || name.contains('\0') {
            return Err(self.text.wrong(span, "a file name is empty or holds a zero byte", None));
        }
        let relative = Path::new(name);
        let mut depth = 0i64;
        for c in relative.components() {
            match c {
                Component::Normal(_) => depth += 1,
                Component::CurDir => {}
                Component::ParentDir => depth -= 1,
                Component::RootDir | Component::Prefix(_) => depth = i64::MIN / 2,
            }
            if depth < 0 && !self.outside {
                return Err(self.text.wrong(
                    span,
                    format!("{:?} lies outside the scene file's folder", shorten(name)),
                    Some("--allow-outside lets the scene file name files outside its own folder".into()),
                ));
            }
        }
        Ok(self.folder.join(relative))
    }
}

/// A name in messages: long ones cut short.
pub(crate) fn shorten(s: &str) -> String {
    crate::uri::shorten(s)
}
