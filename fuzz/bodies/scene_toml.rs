//! Scene files: any text is a scene that holds together, or a mistake with its place.

use etendue_import::scene_file::{Grammar, Key, Kind, LoadOptions, SceneFile, SceneFileError, Section};
use etendue_import::{ImportOptions, Limits};

/// The model that needs no file: two materials, texture coordinates.
const MODEL: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\nusemtl visor\nf 3/3 2/2 1/1\n";

/// A section with a key of each kind.
fn section() -> Section {
    let words = || vec!["one".to_owned(), "two".to_owned()];
    let kinds = [
        Kind::Flag,
        Kind::UNIT,
        Kind::Integer([-5, 5]),
        Kind::Text,
        Kind::Name,
        Kind::Time,
        Kind::Path,
        Kind::Choice(words()),
        Kind::Words(words()),
        Kind::Texts,
        Kind::Color,
        Kind::Vector,
        Kind::Numbers(vec![1, 4]),
        Kind::Pair("x"),
        Kind::Texture,
        Kind::Sky(words()),
        Kind::Table(vec![Key::new("one", Kind::Flag, "")]),
    ];
    let letters = ('a'..).map(|c| c.to_string());
    let keys = kinds.into_iter().zip(letters).map(|(kind, name)| Key::new(&name, kind, "")).collect();
    Section { name: "render".into(), about: String::new(), keys }
}

/// One input.
pub fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    // Small, so that a claim beyond them is a finding and not a slow run.
    let limits =
        Limits { instances: 1 << 10, vertices: 1 << 12, nodes: 1 << 8, file_bytes: 0, ..Limits::default() };
    let sections = [section()];
    let grammar = Grammar {
        sections: &sections,
        builtins: &["helmet.obj"],
        // No file is found there.
        folder: "/nonexistent".into(),
        limits: limits.clone(),
    };
    let check = |e: SceneFileError| {
        if let SceneFileError::Wrong(m) = e {
            assert!(m.line >= 1 && m.column >= 1 && m.span.start <= m.span.end && m.span.end <= m.text.len());
        }
    };
    match SceneFile::parse(text, "fuzz.toml", &grammar) {
        Ok(file) => {
            let import = ImportOptions { limits, ..ImportOptions::default() };
            let options = LoadOptions { import, builtins: &[("helmet.obj", MODEL)], variant: None };
            match file.load(&options) {
                Ok(model) => assert_eq!(model.scene.validate(), Ok(())),
                Err(e) => check(e),
            }
        }
        Err(e) => check(e),
    }
}
