//! Scene files: `scene.toml`, which places models, changes their materials, adds lights, and holds a program's settings.
//!
//! ```toml
//! [[model]]
//! file = "helmet.glb"
//! rotation = [0, 30, 0]
//!
//! [override."visor"]
//! roughness = 0.1
//!
//! [[light]]
//! kind = "spot"
//! position = [0, 3, 0]
//! intensity = 40
//! ```
//!
//! One list of [`Key`]s serves the reader, the [`schema`] and the [`template`]. Tables for settings come from outside as
//! [`Section`]s: they are checked here and handed on as [`Setting`]s, because this crate does not know cameras' defaults or
//! samples per pixel. A mistake knows its place, and what was probably meant.
//!
//! ```
//! use etendue_import::scene_file::SceneFile;
//! let text = "[[model]]\nfile = 'a.glb'\nrotaton = [0, 30, 0]\n";
//! let e = SceneFile::parse(text, "scene.toml", &Default::default()).unwrap_err();
//! assert_eq!(e.to_string(), "scene.toml: line 3, column 1: there is no `rotaton` in [[model]]");
//! ```

mod check;
mod error;
mod key;
mod light;
mod load;
mod merge;
mod moments;
mod nearest;
mod overrides;
mod place;
mod schema;
mod surface;
mod template;

pub use error::{Mistake, SceneFileError};
pub use key::{Key, Kind, Section, Value};
pub use load::LoadOptions;
pub use moments::{MovingScene, SceneModels};
pub use nearest::nearest;
pub use place::Placed;
pub use schema::schema;
pub use template::template;

use crate::limits::Limits;
use crate::source::{ReadError, read_file};
use check::{Checker, Entry, items, shorten};
use error::Text;
use etendue_scene::Light;
use overrides::Override;
use place::Field;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What a scene file may hold beside models, lights and overrides, and how it is read.
#[derive(Clone, Debug, Default)]
pub struct Grammar<'a> {
    /// Tables that are checked and handed on.
    pub sections: &'a [Section],
    /// Names of models that need no file.
    pub builtins: &'a [&'a str],
    /// Where relative file names start.
    pub folder: PathBuf,
    /// Bounds on what is read.
    pub limits: Limits,
}

/// A setting from one of the [`Section`]s.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The section.
    pub section: String,
    /// The key.
    pub key: String,
    /// Checked against the key's [`Kind`].
    pub value: Value,
    /// Which bytes of the file say it.
    pub span: Range<usize>,
}

/// A scene file that was read: nothing that it names has been loaded yet.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Models and where they stand.
    pub models: Vec<Placed>,
    /// Lights beside those of the models.
    pub lights: Vec<Light>,
    /// What the sections hold, in the order of the file.
    pub settings: Vec<Setting>,
    /// For all models.
    overrides: Vec<Override>,
    /// Per model: for it alone.
    own_overrides: Vec<Vec<Override>>,
    text: Text,
}

/// Whether `path` is a scene file by its name.
pub fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

impl SceneFile {
    /// Reads the scene file at `path`, whose folder takes the place of the grammar's.
    ///
    /// # Errors
    /// See [`SceneFileError`].
    pub fn read(path: &Path, grammar: &Grammar<'_>) -> Result<Self, SceneFileError> {
        let file = path.display().to_string();
        // A scene that is written by hand is small, and so is what a program writes; text is bounded as a model's is.
        let bytes = read_file(path, grammar.limits.json_bytes).map_err(|e| match e {
            ReadError::Io(source) => SceneFileError::Read { file: file.clone(), source },
            ReadError::TooLarge(n) => SceneFileError::TooLarge {
                file: file.clone(),
                what: format!("{n} bytes"),
                limit: "json_bytes",
            },
        })?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let grammar = Grammar { folder, ..grammar.clone() };
        match String::from_utf8(bytes) {
            Ok(text) => Self::parse(&text, &file, &grammar),
            Err(e) => {
                let at = e.utf8_error().valid_up_to();
                let text = String::from_utf8_lossy(e.as_bytes()).into_owned();
                let text = Text { file, text: text.into() };
                Err(text.wrong(&(at..at), "the text is not UTF-8", Some("save it as UTF-8".into())))
            }
        }
    }

    /// Reads a scene from its text; `file` stands for it in messages.
    ///
    /// # Errors
    /// See [`SceneFileError`].
    pub fn parse(text: &str, file: &str, grammar: &Grammar<'_>) -> Result<Self, SceneFileError> {
        let text = Text { file: file.to_owned(), text: text.into() };
        let source = text.text.clone();
        let document = DeTable::parse(&source).map_err(|e| {
            let end = source.len();
            text.wrong(&e.span().unwrap_or(end..end), e.message().trim_end(), None)
        })?;
        let checker =
            Checker { text: &text, folder: &grammar.folder, outside: grammar.limits.outside_folder };
        let mut scene = Self {
            models: Vec::new(),
            lights: Vec::new(),
            settings: Vec::new(),
            overrides: Vec::new(),
            own_overrides: Vec::new(),
            text: text.clone(),
        };
        let own = ["model", "light", "override"];
        for (name, span, value) in items(document.get_ref()) {
            match name {
                "model" => scene.read_models(value, &checker, grammar)?,
                "light" => scene.read_lights(value, &checker, grammar)?,
                "override" => scene.overrides = overrides::read_all(value, &checker)?,
                name => match grammar.sections.iter().find(|s| s.name == name) {
                    Some(section) => scene.read_section(section, &span, value, &checker)?,
                    None => {
                        let tables = own.into_iter().chain(grammar.sections.iter().map(|s| s.name.as_str()));
                        let mut e = checker.unknown(name, &span, tables, "at the top of a scene file");
                        point_to_section(&mut e, name, grammar.sections);
                        return Err(e);
                    }
                },
            }
        }
        Ok(scene)
    }

    fn read_models(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        c: &Checker<'_>,
        grammar: &Grammar<'_>,
    ) -> Result<(), SceneFileError> {
        let fields = place::keys(grammar.builtins);
        for (span, table) in tables(value, "model", grammar.limits.nodes, c)? {
            let mut own = Vec::new();
            let mut entries = Vec::new();
            let keys: Vec<&Key> = fields.iter().map(|f| &f.key).collect();
            for (name, key_span, value) in items(table) {
                if name == "override" {
                    own = overrides::read_all(value, c)?;
                } else {
                    let known = keys.iter().map(|k| k.name.as_str()).chain(["override"]);
                    if !keys.iter().any(|k| k.name == name) {
                        return Err(c.unknown(name, &key_span, known, "in [[model]]"));
                    }
                    entries.push(c.entry(name, &key_span, value, &keys, "in [[model]]")?);
                }
            }
            self.models.push(placed(&entries, &fields, span, c)?);
            self.own_overrides.push(own);
        }
        Ok(())
    }

    fn read_lights(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        c: &Checker<'_>,
        grammar: &Grammar<'_>,
    ) -> Result<(), SceneFileError> {
        let fields = light::keys();
        let keys: Vec<&Key> = fields.iter().map(|f| &f.key).collect();
        for (span, table) in tables(value, "light", grammar.limits.nodes, c)? {
            let entries = c.table(table, &keys, "in [[light]]")?;
            self.lights.push(light::light(&entries, &fields, &span, c)?);
        }
        Ok(())
    }

    fn read_section(
        &mut self,
        section: &Section,
        span: &Range<usize>,
        value: &Spanned<DeValue<'_>>,
        c: &Checker<'_>,
    ) -> Result<(), SceneFileError> {
        let DeValue::Table(table) = value.get_ref() else {
            return Err(c.text.wrong(span, format!("`{0}` has to be a table: [{0}]", section.name), None));
        };
        let keys: Vec<&Key> = section.keys.iter().collect();
        for e in c.table(table, &keys, &format!("in [{}]", section.name))? {
            self.settings.push(Setting {
                section: section.name.clone(),
                key: keys[e.key].name.clone(),
                value: e.value,
                span: e.span,
            });
        }
        Ok(())
    }

    /// Says that something at `span` is wrong: for programs that find it out from [`SceneFile::settings`].
    pub fn mistake(
        &self,
        span: &Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> SceneFileError {
        self.text.wrong(span, message, help)
    }
}

/// Says in which section a key stands that was written above all of them.
fn point_to_section(e: &mut SceneFileError, name: &str, sections: &[Section]) {
    let SceneFileError::Wrong(mistake) = e else { return };
    if let Some(s) = sections.iter().find(|s| s.keys.iter().any(|k| k.name == name)) {
        mistake.help = Some(format!("`{name}` stands in [{}]", s.name));
    }
}

/// The tables of an array of tables, with their places.
fn tables<'t, 'i>(
    value: &'t Spanned<DeValue<'i>>,
    name: &str,
    most: u64,
    c: &Checker<'_>,
) -> Result<Vec<(Range<usize>, &'t DeTable<'i>)>, SceneFileError> {
    let fail = |span: &Range<usize>| {
        let message = format!("`{name}` has to be an array of tables");
        Err(c.text.wrong(span, message, Some(format!("write [[{name}]] in double brackets"))))
    };
    let DeValue::Array(list) = value.get_ref() else { return fail(&value.span()) };
    if list.len() as u64 > most {
        return Err(SceneFileError::TooLarge {
            file: c.text.file.clone(),
            what: format!("{} tables [[{name}]]", list.len()),
            limit: "nodes",
        });
    }
    let mut out = Vec::with_capacity(list.len());
    for v in list.iter() {
        match v.get_ref() {
            DeValue::Table(t) => out.push((v.span(), t)),
            _ => return fail(&v.span()),
        }
    }
    Ok(out)
}

/// The model that `entries` of the table at `span` place.
fn placed(
    entries: &[Entry],
    fields: &[Field<Placed>],
    span: Range<usize>,
    c: &Checker<'_>,
) -> Result<Placed, SceneFileError> {
    let of = |name: &str| entries.iter().find(|e| fields[e.key].key.name == name);
    let mut m = Placed::new(span.clone());
    entries.iter().for_each(|e| (fields[e.key].set)(&mut m, &e.value));
    match (of("file"), of("builtin")) {
        (None, None) => {
            let help = Some("add file = \"MODEL.glb\", or builtin = \"helmet\"".into());
            return Err(c.text.wrong(&span, "a model names no file", help));
        }
        (Some(_), Some(e)) => {
            return Err(c.text.wrong(&e.span, "a model has either `file` or `builtin`", None));
        }
        (Some(e), None) => {
            if is_scene_file(&m.file) {
                let message = format!("{:?} is a scene file, and scene files hold none", shorten(&m.label()));
                return Err(c.text.wrong(&e.span, message, None));
            }
            m.span = e.span.clone();
        }
        (None, Some(e)) => m.span = e.span.clone(),
    }
    if of("matrix").is_some()
        && let Some(e) = of("translation").or(of("rotation")).or(of("scale"))
    {
        let message = "a model stands by `matrix`, or by `translation`, `rotation` and `scale`";
        return Err(c.text.wrong(&e.span, message, None));
    }
    if !m.transform().is_finite() {
        return Err(c.text.wrong(&span, "the model stands where no number reaches", None));
    }
    Ok(m)
}
