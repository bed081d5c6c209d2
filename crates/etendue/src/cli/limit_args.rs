//! What models may take and what of them is read, on every command that loads one.

use crate::import::{ImportOptions, Limits};
use clap::Args;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct LimitArgs {
    /// Read drafts of glTF extensions too, which may still change: KHR_materials_coat, diffuse_roughness, fuzz, scatter, volume_scatter
    #[arg(long, help_heading = "Scene")]
    pub drafts: bool,
    /// Let models read files outside their own folders
    #[arg(long, help_heading = "Limits")]
    pub allow_outside: bool,
    /// Most memory for a model's files, pictures and geometry together, e.g. 4GiB or 500MB [default: 32GiB]
    #[arg(long, value_name = "SIZE", value_parser = bytes, help_heading = "Limits")]
    pub max_memory: Option<u64>,
    /// Another limit on what a model may be, by the name that errors give it (repeatable); --help lists them
    #[arg(long, value_name = "NAME=NUMBER", value_parser = limit, long_help = names(), help_heading = "Limits")]
    pub limit: Vec<String>,
}

impl LimitArgs {
    /// How models are imported.
    pub fn options(&self) -> ImportOptions {
        ImportOptions { limits: self.limits(), drafts: self.drafts, ..ImportOptions::default() }
    }

    /// The importer's limits.
    pub fn limits(&self) -> Limits {
        let mut limits = Limits { outside_folder: self.allow_outside, ..Limits::default() };
        if let Some(bytes) = self.max_memory {
            limits = limits.with_memory(bytes);
        }
        for (name, value) in self.limit.iter().filter_map(|l| parts(l)) {
            // The parser has tried it already.
            let _ = limits.set(name, value);
        }
        limits
    }
}

fn parts(text: &str) -> Option<(&str, u64)> {
    let (name, value) = text.split_once('=')?;
    Some((name.trim(), bytes(value.trim()).ok()?))
}

/// Finds out whether there is such a limit.
fn limit(text: &str) -> Result<String, String> {
    let (name, value) =
        parts(text).ok_or("give a name and a number, as in nodes=10000000 or json_bytes=1GiB")?;
    Limits::default().set(name, value)?;
    Ok(text.to_owned())
}

/// A number of bytes: `4GiB`, `500MB`, `1000`; a single letter means what the `iB` behind it would.
fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || "give a size, as in 4GiB, 500MB or a number of bytes".to_owned();
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = (&text[..end], text[end..].trim_start().to_ascii_lowercase());
    let (letter, rest) = match unit.chars().next() {
        None => ('b', ""),
        Some(c) => (c, &unit[c.len_utf8()..]),
    };
    let power = "bkmgt".find(letter).ok_or_else(wrong)? as i32;
    let scale: f64 = match (letter, rest) {
        ('b', "") => 1.0,
        (_, "b") if letter != 'b' => 1000f64.powi(power),
        (_, "" | "ib") if letter != 'b' => 1024f64.powi(power),
        _ => return Err(wrong()),
    };
    // A whole number exactly, however many digits it has.
    if let (Ok(n), true) = (number.parse::<u64>(), scale >= 1.0) {
        return n.checked_mul(scale as u64).ok_or_else(wrong);
    }
    let value = number.parse::<f64>().map_err(|_| wrong())? * scale;
    if value.is_finite() && value >= 0.0 && value < u64::MAX as f64 { Ok(value as u64) } else { Err(wrong()) }
}

/// Every limit with its default.
fn names() -> String {
    let mut text = String::from(
        "Another limit on what a model may be, by the name that errors give it (repeatable)\n\nThere are, with their defaults:\n",
    );
    let default = Limits::default();
    for (name, about) in Limits::NAMES {
        text += &format!("  {name}={}:{about}\n", default.get(name).unwrap_or_default());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, n) in [
            ("1000", 1000),
            ("4GiB", 4 << 30),
            ("4g", 4 << 30),
            ("500MB", 500_000_000),
            ("1.5 KiB", 1536),
            ("7b", 7),
        ] {
            assert_eq!(bytes(text), Ok(n), "{text}");
        }
        for text in ["", "GiB", "-1", "4XB", "4GiBs", "1e9", "99999999999TiB", "1bb", "..", "é"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn limits_are_set_by_name() {
        assert!(limit("nodes=5").is_ok() && limit("json_bytes=1GiB").is_ok());
        assert!(limit("node=5").is_err_and(|e| e.contains("nodes")));
        assert!(limit("node_depth=99999999999").is_err() && limit("nodes").is_err());
        let args =
            LimitArgs { max_memory: Some(1 << 40), limit: vec!["nodes=5".into()], ..LimitArgs::default() };
        let l = args.limits();
        assert_eq!((l.nodes, l.memory_bytes, l.image_bytes, l.file_bytes), (5, 1 << 40, 1 << 40, 1 << 40));
        let small = LimitArgs { max_memory: Some(1 << 20), ..LimitArgs::default() }.limits();
        assert_eq!((small.memory_bytes, small.image_bytes), (1 << 20, Limits::default().image_bytes));
    }
}
