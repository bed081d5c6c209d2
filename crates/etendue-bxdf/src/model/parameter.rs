//! What a user may set on a model: names, ranges and defaults, and the way from text to a closure's parameters.

use etendue_color::Spectrum;
use glam::Vec3A;
use thiserror::Error;

/// A parameter's value as a user writes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A plain number.
    Number(f32),
    /// Linear Rec.709 red, green, blue.
    Color([f32; 3]),
    /// A direction in the local frame.
    Vector([f32; 3]),
    /// On or off.
    Flag(bool),
    /// One of the parameter's [`Parameter::choices`].
    Choice(&'static str),
}

/// One parameter of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, in `snake_case`.
    pub name: &'static str,
    /// What it does, as one or more lines of documentation.
    pub about: &'static str,
    /// Its value if nothing is said; also tells its kind.
    pub default: Value,
    /// Least and largest sensible value of a number or of a colour's lanes; values outside are clamped by the model.
    pub range: [f32; 2],
    /// The words that a choice may be; empty for other kinds.
    pub choices: &'static [&'static str],
}

/// Why a parameter could not be set.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ParameterError {
    /// No model has this name.
    #[error("there is no model {name:?}; there are {known}")]
    UnknownModel {
        /// What was asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// The model has no parameter of this name.
    #[error("{model} has no parameter {name:?}; it has {known}")]
    UnknownParameter {
        /// The model.
        model: &'static str,
        /// What was asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// The text is not a value of the parameter's kind.
    #[error("{name} = {text:?}: expected {expected}")]
    NotAValue {
        /// The parameter.
        name: String,
        /// What was written.
        text: String,
        /// What it should have been.
        expected: String,
    },
}

/// A type that a parameter may have.
pub trait Field: Copy {
    /// As the user sees it.
    fn value(self) -> Value;
    /// From a value of the same kind; a number also serves for a colour (each lane) and a flag (not zero).
    fn from_value(v: Value) -> Option<Self>;
    /// For choices, the words.
    const CHOICES: &'static [&'static str] = &[];
}

impl Field for f32 {
    fn value(self) -> Value {
        Value::Number(self)
    }
    fn from_value(v: Value) -> Option<Self> {
        match v {
            Value::Number(x) => Some(x),
            _ => None,
        }
    }
}

impl Field for Spectrum {
    fn value(self) -> Value {
        Value::Color(self.to_rgb())
    }
    fn from_value(v: Value) -> Option<Self> {
        match v {
            Value::Number(x) => Some(Self::rgb(x, x, x)),
            Value::Color(c) => Some(Self::from_rgb(c)),
            _ => None,
        }
    }
}

impl Field for Vec3A {
    fn value(self) -> Value {
        Value::Vector(self.to_array())
    }
    fn from_value(v: Value) -> Option<Self> {
        match v {
            Value::Vector(v) => Some(Self::from_array(v)),
            _ => None,
        }
    }
}

impl Field for bool {
    fn value(self) -> Value {
        Value::Flag(self)
    }
    fn from_value(v: Value) -> Option<Self> {
        match v {
            Value::Flag(b) => Some(b),
            Value::Number(x) => Some(x != 0.0),
            _ => None,
        }
    }
}

impl Parameter {
    /// Reads a value of this parameter's kind: a number; a colour as `r,g,b`, one number or `#rrggbb` (sRGB); a direction
    /// as `x,y,z`; `true` or `false`; one of the choices.
    ///
    /// # Errors
    /// [`ParameterError::NotAValue`], with what was expected.
    pub fn parse(&self, text: &str) -> Result<Value, ParameterError> {
        let number = |t: &str| t.trim().parse::<f32>().ok().filter(|v| v.is_finite());
        let found = match self.default {
            Value::Number(_) => number(text).map(Value::Number),
            Value::Color(_) => color(text).map(Value::Color),
            Value::Vector(_) => vector(text).map(Value::Vector),
            Value::Flag(_) => text.trim().parse().ok().map(Value::Flag),
            Value::Choice(_) => self.choices.iter().find(|c| **c == text.trim()).map(|c| Value::Choice(c)),
        };
        found.ok_or_else(|| ParameterError::NotAValue {
            name: self.name.into(),
            text: text.into(),
            expected: match self.default {
                Value::Number(_) => "a number".into(),
                Value::Color(_) => "a colour: r,g,b or one number (linear), or #rrggbb (sRGB)".into(),
                Value::Vector(_) => "a direction: x,y,z".into(),
                Value::Flag(_) => "true or false".into(),
                Value::Choice(_) => format!("one of {}", self.choices.join(", ")),
            },
        })
    }
}

/// `r,g,b`, one number for all three, or `#rrggbb`.
fn color(text: &str) -> Option<[f32; 3]> {
    let text = text.trim();
    if let Some(hex) = text.strip_prefix('#') {
        if hex.len() != 6 || !hex.is_ascii() {
            return None;
        }
        let mut out = [0.0; 3];
        for (i, lane) in out.iter_mut().enumerate() {
            let byte = u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).ok()?;
            *lane = etendue_color::srgb8_decode(byte);
        }
        return Some(out);
    }
    match numbers(text)?[..] {
        [v] => Some([v; 3]),
        [r, g, b] => Some([r, g, b]),
        _ => None,
    }
}

/// `x,y,z`.
fn vector(text: &str) -> Option<[f32; 3]> {
    match numbers(text)?[..] {
        [x, y, z] => Some([x, y, z]),
        _ => None,
    }
}

/// Finite numbers between commas.
fn numbers(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|t| t.trim().parse::<f32>().ok().filter(|v| v.is_finite())).collect()
}

/// Declares a model's parameters: the struct, its `Default`, and its table for users.
///
/// ```
/// use etendue_bxdf::{model::Parameters, parameters};
/// use etendue_color::Spectrum;
///
/// parameters! {
///     /// What paper is at a point.
///     pub struct PaperParams {
///         /// Reflectance.
///         base_color: Spectrum = Spectrum::rgb(0.8, 0.8, 0.8), 0.0..1.0;
///         /// Perceptual roughness.
///         roughness: f32 = 0.5, 0.0..1.0;
///     }
/// }
/// let mut p = PaperParams::default();
/// assert_eq!(PaperParams::table()[1].name, "roughness");
/// assert!(p.set("roughness", etendue_bxdf::model::Value::Number(0.25)));
/// assert_eq!(p.roughness, 0.25);
/// ```
#[macro_export]
macro_rules! parameters {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $( $(#[doc = $about:expr])+ $field:ident : $kind:ty = $default:expr, $low:literal .. $high:expr; )*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $( $(#[doc = $about])+ pub $field: $kind, )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $( $field: $default, )* }
            }
        }

        impl $crate::model::Parameters for $name {
            fn table() -> Vec<$crate::model::Parameter> {
                use $crate::model::Field;
                vec![ $( $crate::model::Parameter {
                    name: stringify!($field),
                    about: concat!($($about, "\n"),+),
                    default: <$kind as Field>::value($default),
                    range: [$low, $high],
                    choices: <$kind as Field>::CHOICES,
                }, )* ]
            }

            fn get(&self, name: &str) -> Option<$crate::model::Value> {
                use $crate::model::Field;
                match name {
                    $( stringify!($field) => Some(<$kind as Field>::value(self.$field)), )*
                    _ => None,
                }
            }

            fn set(&mut self, name: &str, value: $crate::model::Value) -> bool {
                use $crate::model::Field;
                match name {
                    $( stringify!($field) => match <$kind as Field>::from_value(value) {
                        Some(v) => {
                            self.$field = v;
                            true
                        }
                        None => false,
                    }, )*
                    _ => false,
                }
            }
        }
    };
}

/// Declares an enum of named choices that a parameter may be: variants, the words for them, and what they mean.
#[macro_export]
macro_rules! choices {
    (
        $(#[$meta:meta])*
        pub enum $name:ident { $( $(#[$about:meta])* $variant:ident = $word:literal, )* }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $( $(#[$about])* $variant, )* }

        impl $crate::model::Field for $name {
            fn value(self) -> $crate::model::Value {
                $crate::model::Value::Choice(match self { $( Self::$variant => $word, )* })
            }
            fn from_value(v: $crate::model::Value) -> Option<Self> {
                match v {
                    $( $crate::model::Value::Choice($word) => Some(Self::$variant), )*
                    _ => None,
                }
            }
            const CHOICES: &'static [&'static str] = &[$( $word, )*];
        }
    };
}

/// A set of parameters that a user can list, read and set by name; made by [`crate::parameters!`].
pub trait Parameters: Copy + Default {
    /// Every parameter, in order of declaration.
    fn table() -> Vec<Parameter>;
    /// The value of the parameter `name`; `None` if there is none.
    fn get(&self, name: &str) -> Option<Value>;
    /// Sets the parameter `name`; false if there is none or `value` is of another kind.
    fn set(&mut self, name: &str, value: Value) -> bool;
}
