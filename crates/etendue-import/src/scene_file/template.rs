//! A scene file to begin with: renders as it is, and says in comments what else there is.

use super::key::{Key, Kind, Section};
use super::overrides::{ALL, measured_key, model_key};
use super::surface::{factors, textures};
use super::{light, place};
use std::fmt::Write;

/// Longest line of a comment.
const WIDTH: usize = 110;

/// The text of a scene file that shows the first of `builtins`. What is not said has its default and stands there behind a `#`
/// without a space; `schema` is where an editor finds the schema.
pub fn template(sections: &[Section], builtins: &[&str], schema: &str) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "#:schema {schema}");
    comment(
        &mut out,
        "A scene for etendue. Everything is optional but a model; what stands behind a # without a space is a setting with its default, or an example where it has none. File names are relative to this file. Numbers of the command line go before those that stand here.",
    );
    out.push('\n');
    comment(&mut out, "Models: as many as there are [[model]].");
    let first = builtins.first().copied().unwrap_or_default();
    let _ = writeln!(out, "[[model]]\nbuiltin = {first:?}");
    for f in place::keys(builtins).iter().filter(|f| f.key.name != "builtin") {
        setting(&mut out, &f.key);
    }
    out.push('\n');
    comment(
        &mut out,
        &format!(
            "What is changed of materials, by their names (`etendue info` lists them); {ALL:?} stands for all. Factors are multiplied by the material's textures. [model.override.\"NAME\"] below a [[model]] changes it for that model alone."
        ),
    );
    let _ = writeln!(out, "#[override.\"visor\"]\n#roughness = 0.1");
    let names = |list: Vec<Key>| list.into_iter().map(|k| k.name).collect::<Vec<_>>().join(", ");
    comment(&mut out, &format!("There are {}.", names(factors().into_iter().map(|f| f.field.key).collect())));
    comment(
        &mut out,
        &format!(
            "Of pictures, or false to leave one out: {}.",
            names(textures().into_iter().map(|t| t.key).collect())
        ),
    );
    setting(&mut out, &model_key());
    setting(&mut out, &measured_key());
    out.push('\n');
    comment(&mut out, "Lights beside the sky and those of the models: as many as there are [[light]].");
    let _ = writeln!(out, "#[[light]]");
    for f in light::keys() {
        if f.key.name == "kind" {
            comment(&mut out, &f.key.about);
            let _ = writeln!(out, "#kind = \"spot\"");
        } else {
            setting(&mut out, &f.key);
        }
    }
    for s in sections {
        out.push('\n');
        comment(&mut out, &s.about);
        let _ = writeln!(out, "[{}]", s.name);
        s.keys.iter().for_each(|k| setting(&mut out, k));
    }
    out
}

/// A key with what it does, behind `#`.
fn setting(out: &mut String, key: &Key) {
    comment(out, &key.about);
    let value = key.default.clone().unwrap_or_else(|| example(&key.kind));
    let _ = writeln!(out, "#{} = {value}", key.name);
}

/// Prose, broken into lines.
fn comment(out: &mut String, text: &str) {
    let mut line = String::from("#");
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() >= WIDTH {
            let _ = writeln!(out, "{line}");
            line = String::from("#");
        }
        let _ = write!(line, " {word}");
    }
    let _ = writeln!(out, "{line}");
}

/// A value of a kind, for keys without a default.
fn example(kind: &Kind) -> String {
    match kind {
        Kind::Flag => "true".into(),
        Kind::Number([a, b]) => 1f64.clamp(*a, *b).to_string(),
        Kind::Integer([a, b]) => 1i64.clamp(*a, *b).to_string(),
        Kind::Text => "\"NAME\"".into(),
        Kind::Name => "0".into(),
        Kind::Time => "\"60s\"".into(),
        Kind::Path => "\"FILE\"".into(),
        Kind::Choice(words) => format!("{:?}", words.first().map_or("", String::as_str)),
        Kind::Words(words) => format!("[{:?}]", words.first().map_or("", String::as_str)),
        Kind::Texts => "[]".into(),
        Kind::Color => "[1, 1, 1]".into(),
        Kind::Vector => "[0, 1, 0]".into(),
        // Four by four: what changes nothing.
        Kind::Numbers(counts) if counts == &[16] => "[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]".into(),
        Kind::Numbers(counts) => match counts.first() {
            Some(1) | None => "1".into(),
            Some(n) => format!("{:?}", vec![0; *n]),
        },
        Kind::Pair(between) => if *between == "x" { "[512, 512]" } else { "[0, 64]" }.into(),
        Kind::Texture => "false".into(),
        Kind::Sky(names) => format!("{:?}", names.first().map_or("none", String::as_str)),
        Kind::Table(_) => "{}".into(),
    }
}
