//! What a scene file may say: keys, and the kinds of their values. The reader, the schema and the template all go by these.

use std::path::PathBuf;

/// One key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// As it is written, in `snake_case`.
    pub name: String,
    /// What it does, with its unit.
    pub about: String,
    /// What may stand there.
    pub kind: Kind,
    /// Its value if it is not there, as TOML; `None` if there is none to write down.
    pub default: Option<String>,
}

/// A table of settings that the reader only checks and hands on: a program's own.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// The table's name.
    pub name: String,
    /// What it is for.
    pub about: String,
    /// What may stand in it.
    pub keys: Vec<Key>,
}

/// What may stand at a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `true` or `false`.
    Flag,
    /// A finite number from the first to the second.
    Number([f64; 2]),
    /// A whole number from the first to the second.
    Integer([i64; 2]),
    /// Any text.
    Text,
    /// A name, or a number from 0 that stands for it.
    Name,
    /// A time: seconds, or text with a unit such as `"5m"`.
    Time,
    /// A file, relative to the folder of the scene file.
    Path,
    /// One of these words.
    Choice(Vec<String>),
    /// Any of these words: an array of them, or text with commas.
    Words(Vec<String>),
    /// Texts, one or an array.
    Texts,
    /// A colour: an array of three numbers from 0 or one for all three (linear Rec.709), or text `"#rrggbb"` (sRGB).
    Color,
    /// Three numbers.
    Vector,
    /// So many numbers; of several counts.
    Numbers(Vec<usize>),
    /// Two whole numbers, as an array, or as text with this between them.
    Pair(&'static str),
    /// A picture file for a texture, or `false` to leave the texture out.
    Texture,
    /// A sky: a file, one of these names, or a colour.
    Sky(Vec<String>),
    /// A table with these keys.
    Table(Vec<Key>),
}

/// A value that was found good for its [`Kind`].
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Of [`Kind::Flag`].
    Flag(bool),
    /// Of [`Kind::Number`], and of kinds that take text or a number.
    Number(f64),
    /// Of [`Kind::Integer`], and of [`Kind::Name`] where it is a number.
    Integer(i64),
    /// Of kinds that are text.
    Text(String),
    /// Of kinds that name a file: resolved against the scene file's folder, and found to lie below it unless more is allowed.
    Path(PathBuf),
    /// Of kinds that are several numbers.
    Numbers(Vec<f64>),
    /// Of [`Kind::Words`] and [`Kind::Texts`].
    Texts(Vec<String>),
    /// Of [`Kind::Table`]: names and values, in the order of the file.
    Table(Vec<(String, Value)>),
}

impl Key {
    /// A key without a default.
    pub fn new(name: &str, kind: Kind, about: &str) -> Self {
        Self { name: name.into(), about: about.into(), kind, default: None }
    }

    /// The same with a default, written as TOML.
    #[must_use]
    pub fn or(mut self, default: &str) -> Self {
        self.default = Some(default.into());
        self
    }
}

impl Kind {
    /// A number from 0 to 1.
    pub const UNIT: Self = Self::Number([0.0, 1.0]);
    /// Any finite number.
    pub const ANY: Self = Self::Number([f64::NEG_INFINITY, f64::INFINITY]);
    /// A number from 0 on.
    pub const POSITIVE: Self = Self::Number([0.0, f64::INFINITY]);

    /// One of `words`.
    pub fn choice(words: &[&str]) -> Self {
        Self::Choice(words.iter().map(|w| (*w).to_owned()).collect())
    }

    /// What is needed, for messages.
    pub fn wanted(&self) -> String {
        let from_to =
            |low: String, high: String, [open_low, open_high]: [bool; 2]| match (open_low, open_high) {
                (true, true) => String::new(),
                (false, true) => format!(" of {low} or more"),
                (true, false) => format!(" of {high} or less"),
                (false, false) => format!(" from {low} to {high}"),
            };
        let list = |words: &[String]| words.iter().map(|w| format!("{w:?}")).collect::<Vec<_>>().join(", ");
        match self {
            Self::Flag => "true or false".into(),
            Self::Number([a, b]) => {
                format!(
                    "a number{}",
                    from_to(a.to_string(), b.to_string(), [a.is_infinite(), b.is_infinite()])
                )
            }
            Self::Integer([a, b]) => {
                format!("a whole number{}", from_to(a.to_string(), b.to_string(), [false, *b == i64::MAX]))
            }
            Self::Text => "text in quotation marks".into(),
            Self::Name => "a name in quotation marks, or a number from 0".into(),
            Self::Time => "a number of seconds, or text with a unit such as \"5m\"".into(),
            Self::Path => "a file name in quotation marks".into(),
            Self::Choice(words) => format!("one of {}", list(words)),
            Self::Words(words) => format!("an array of {}", list(words)),
            Self::Texts => "text, or an array of texts".into(),
            Self::Color => "a colour: [r, g, b] or one number (linear, 0 or more), or \"#rrggbb\"".into(),
            Self::Vector => "three numbers, as in [1.5, 0, -2]".into(),
            Self::Numbers(counts) => {
                let counts: Vec<_> = counts.iter().map(usize::to_string).collect();
                format!("an array of {} numbers", counts.join(" or "))
            }
            Self::Pair(between) => format!("two whole numbers, as in [1, 2] or \"1{between}2\""),
            Self::Texture => "a picture file in quotation marks, or false".into(),
            Self::Sky(names) => format!("a file, {} or a colour [r, g, b]", list(names)),
            Self::Table(_) => "a table".into(),
        }
    }
}

impl Value {
    /// The number, or 0.
    pub(crate) fn f64(&self) -> f64 {
        match self {
            Self::Number(v) => *v,
            Self::Integer(v) => *v as f64,
            _ => 0.0,
        }
    }

    /// The number as the renderer has it; what exceeds its range is the largest that it has.
    pub(crate) fn f32(&self) -> f32 {
        narrow(self.f64())
    }

    pub(crate) fn flag(&self) -> bool {
        *self == Self::Flag(true)
    }

    pub(crate) fn text(&self) -> &str {
        match self {
            Self::Text(t) => t,
            _ => "",
        }
    }

    /// The numbers; what is missing is 0.
    pub(crate) fn numbers<const N: usize>(&self) -> [f32; N] {
        match self {
            Self::Numbers(v) => std::array::from_fn(|i| v.get(i).copied().map_or(0.0, narrow)),
            _ => [0.0; N],
        }
    }
}

fn narrow(v: f64) -> f32 {
    v.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}
