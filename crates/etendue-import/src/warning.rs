//! What an import had to leave out or mend, said once per kind.

use std::collections::HashMap;
use std::fmt;

/// Something in the file that was ignored, mended or looks wrong, though a picture can be made.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// JSON pointer (RFC 6901) to the first place where it occurs, or for formats other than glTF the place in words (`line
    /// 12`); empty for the whole document.
    pub pointer: String,
    /// What is wrong and what was done about it.
    pub message: String,
    /// In how many places.
    pub count: u64,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if self.pointer.is_empty() { "document" } else { &self.pointer };
        write!(f, "{place}: {}", self.message)?;
        if self.count > 1 {
            write!(f, " (and {} more)", self.count - 1)?;
        }
        Ok(())
    }
}

/// Warnings in the order of their first occurrence; equal messages are joined and counted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    by_message: HashMap<String, usize>,
}

/// More kinds of warnings than any reader would read; a hostile file must not fill the memory with them.
const MAX_KINDS: usize = 1000;

impl Warnings {
    /// Notes `message` at `pointer`.
    pub fn add(&mut self, pointer: impl Into<String>, message: impl Into<String>) {
        self.join(Warning { pointer: pointer.into(), message: message.into(), count: 1 });
    }

    /// Adds a list that was gathered elsewhere.
    pub fn extend(&mut self, other: Warnings) {
        for w in other.list {
            self.join(w);
        }
    }

    /// Adds one.
    pub fn join(&mut self, w: Warning) {
        if let Some(&i) = self.by_message.get(&w.message) {
            self.list[i].count += w.count;
        } else if self.list.len() < MAX_KINDS {
            self.by_message.insert(w.message.clone(), self.list.len());
            self.list.push(w);
        }
    }

    /// The warnings, first occurrence first.
    pub fn into_vec(self) -> Vec<Warning> {
        self.list
    }
}
