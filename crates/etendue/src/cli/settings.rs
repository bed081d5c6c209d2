//! The arguments of `etendue render` as tables of a scene file. The command line's own definition is the only list: what is added
//! there can be said in a scene file, stands in the schema, and is explained by the same words.

use super::args::{Cli, Integrator};
use super::motion_args::FrameRange;
use super::values::Vec3Arg;
use crate::color::ToneCurve;
use crate::image::SkyLayout;
use crate::import::scene_file::{Key, Kind, Section, Value};
use crate::realtime::{self, Choices, Preset};
use crate::render::{self, Filter};
use clap::{Arg, ArgAction, CommandFactory};
use std::any::TypeId;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments that no table has, and why.
pub(crate) const NOT_IN_A_SCENE: [(&str, &str); 10] = [
    ("model", "models stand in [[model]]"),
    ("material", "materials are changed by [override]"),
    ("variant", "each model has its own"),
    ("at", "each model has its own"),
    ("animation", "each model has its own"),
    ("turn_frame", "it is what a film remembers"),
    ("resume", "to go on is a deed, not a setting"),
    ("allow_outside", "a file must not allow itself what its reader did not"),
    ("max_memory", "likewise"),
    ("limit", "likewise"),
];

/// An argument, and where a scene file has it.
pub(crate) struct Setting {
    /// Name of the field of `RenderArgs`.
    pub id: String,
    /// Name of the option, without the dashes.
    pub long: String,
    /// The table.
    pub section: &'static str,
    pub key: Key,
}

const SKY: &str = "environment";
const CAMERA: &str = "camera";
const RENDER: &str = "render";

/// All arguments that a scene file may hold, in the order of the command line's help.
pub(crate) fn settings() -> Vec<Setting> {
    let cli = Cli::command();
    let Some(render) = cli.find_subcommand("render") else { return Vec::new() };
    render.get_arguments().filter_map(setting).collect()
}

/// The tables of a scene file that hold settings.
pub(crate) fn sections(settings: &[Setting]) -> Vec<Section> {
    let about = [
        (SKY, "The sky, light from infinitely far away."),
        (CAMERA, "Where the picture is taken from. Without `eye` or `camera` it frames the models."),
        (RENDER, "The picture, and how it is made."),
    ];
    let keys = |section| settings.iter().filter(move |s| s.section == section).map(|s| s.key.clone());
    let section = |(name, about): (&'static str, &str)| Section {
        name: name.into(),
        about: about.into(),
        keys: keys(name).collect(),
    };
    about.into_iter().map(section).collect()
}

fn setting(arg: &Arg) -> Option<Setting> {
    let id = arg.get_id().as_str();
    let long = arg.get_long()?;
    let builtin = matches!(
        arg.get_action(),
        ArgAction::Help | ArgAction::HelpShort | ArgAction::HelpLong | ArgAction::Version
    );
    if builtin || NOT_IN_A_SCENE.iter().any(|(n, _)| *n == id) {
        return None;
    }
    let heading = arg.get_help_heading().unwrap_or_default();
    let (section, name) = match id.strip_prefix("env") {
        Some("") => (SKY, "sky"),
        Some(rest) if rest.starts_with('_') => (SKY, &rest[1..]),
        // How bright the film is belongs to who holds the camera.
        _ if heading == "Camera" || id == "exposure" => (CAMERA, id),
        _ => (RENDER, id),
    };
    let kind = kind(arg);
    let default = default(arg, &kind);
    let about = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let key = Key { name: name.into(), about: about.trim().into(), kind, default };
    Some(Setting { id: id.into(), long: long.into(), section, key })
}

/// What may stand at the key of an argument: by the type of its value, or by name where a table says more than text.
fn kind(arg: &Arg) -> Kind {
    match arg.get_id().as_str() {
        "env" => return Kind::Sky(vec!["studio".into(), "none".into()]),
        "choice" => {
            let keys = Choices::KEYS.iter().map(|k| {
                let default = Choices::default().get(k.name).unwrap_or_default();
                Key::new(k.name, Kind::choice(k.values), k.about).or(&format!("{default:?}"))
            });
            return Kind::Table(keys.collect());
        }
        // 8, 16 or 32.
        "bits" => return Kind::Integer([8, 32]),
        "preset" => return one_of(Preset::ALL),
        "passes" => {
            let mut names: Vec<String> = ["all", "parts"].map(str::to_owned).to_vec();
            let paths = render::Pass::ALL.iter().map(|p| p.name());
            for n in paths.chain(realtime::passes::Pass::ALL.iter().map(|p| p.name())) {
                if !names.iter().any(|known| known == n) {
                    names.push(n.to_owned());
                }
            }
            return Kind::Words(names);
        }
        _ => {}
    }
    let append = matches!(arg.get_action(), ArgAction::Append);
    let value_type = arg.get_value_parser().type_id();
    let is = |t: TypeId| value_type == t;
    let value_name = arg.get_value_names().and_then(|n| n.first()).map_or("", |n| n.as_str());
    let possible: Vec<String> = arg.get_possible_values().iter().map(|v| v.get_name().to_owned()).collect();
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        Kind::Flag
    } else if append {
        Kind::Texts
    } else if !possible.is_empty() {
        Kind::Choice(possible)
    } else if is(TypeId::of::<f32>()) || is(TypeId::of::<f64>()) {
        Kind::ANY
    } else if is(TypeId::of::<u8>()) {
        Kind::Integer([0, u8::MAX.into()])
    } else if is(TypeId::of::<u32>()) {
        Kind::Integer([0, u32::MAX.into()])
    } else if is(TypeId::of::<u64>()) {
        Kind::Integer([0, i64::MAX])
    } else if is(TypeId::of::<Vec3Arg>()) {
        Kind::Vector
    } else if is(TypeId::of::<(u32, u32)>()) || is(TypeId::of::<FrameRange>()) {
        Kind::Pair(if value_name.contains("..") { ".." } else { "x" })
    } else if is(TypeId::of::<Duration>()) {
        Kind::Time
    } else if is(TypeId::of::<PathBuf>()) {
        Kind::Path
    } else if is(TypeId::of::<ToneCurve>()) {
        one_of(&ToneCurve::ALL)
    } else if is(TypeId::of::<Filter>()) {
        one_of(&Filter::ALL)
    } else if is(TypeId::of::<Integrator>()) {
        one_of(&Integrator::ALL)
    } else if is(TypeId::of::<SkyLayout>()) {
        one_of(&SkyLayout::ALL)
    } else if value_name == "N|NAME" || value_name == "NAME|N" {
        Kind::Name
    } else {
        Kind::Text
    }
}

/// One of the words that the values show themselves as.
fn one_of<T: ToString>(values: &[T]) -> Kind {
    Kind::Choice(values.iter().map(T::to_string).collect())
}

/// The argument's default as TOML.
fn default(arg: &Arg, kind: &Kind) -> Option<String> {
    let text = arg.get_default_values().first().and_then(|d| d.to_str()).filter(|d| !d.is_empty());
    match (kind, text) {
        (Kind::Flag, _) => Some("false".into()),
        (Kind::Sky(_), None) => Some("\"studio\"".into()),
        (_, None) => None,
        (Kind::Number(_) | Kind::Integer(_), Some(t)) => Some(t.to_owned()),
        (_, Some(t)) => Some(format!("{t:?}")),
    }
}

/// A value as the command line has it: the words of the argument.
pub(crate) fn words(long: &str, value: &Value) -> Vec<String> {
    let one = |v: String| vec![format!("--{long}={v}")];
    match value {
        Value::Flag(true) => vec![format!("--{long}")],
        Value::Flag(false) => Vec::new(),
        Value::Number(v) => one(v.to_string()),
        Value::Integer(v) => one(v.to_string()),
        Value::Text(v) => one(v.clone()),
        Value::Path(p) => one(p.to_string_lossy().into_owned()),
        Value::Numbers(v) => one(v.iter().map(f64::to_string).collect::<Vec<_>>().join(",")),
        Value::Texts(v) if long == "passes" => one(v.join(",")),
        Value::Texts(v) => v.iter().map(|v| format!("--{long}={v}")).collect(),
        Value::Table(t) => t
            .iter()
            .map(|(k, v)| match v {
                Value::Text(v) => format!("--{long}={k}={v}"),
                other => format!("--{long}={k}={other:?}"),
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::args::RenderArgs;
    use super::super::scene_file::{builtin_names, fields, under};
    use super::*;
    use crate::import::scene_file::template;

    /// Whatever the command line learns, a scene file can say, or the list says why not.
    #[test]
    fn a_scene_file_has_what_the_command_line_has() {
        let settings = settings();
        let all = fields(&RenderArgs::builtin());
        for id in all.keys() {
            let has = settings.iter().any(|s| s.id == *id);
            let left_out = NOT_IN_A_SCENE.iter().any(|(n, _)| n == id);
            assert!(has != left_out, "{id}: in a scene file {has}, left out {left_out}");
        }
        for (n, _) in NOT_IN_A_SCENE {
            assert!(all.contains_key(n), "{n} is no argument any more");
        }
        for s in &settings {
            assert!(all.contains_key(&s.id), "{} is stored under another name", s.id);
            assert!(!s.key.about.is_empty(), "{}", s.id);
            let twice =
                settings.iter().filter(|o| (o.section, &o.key.name) == (s.section, &s.key.name)).count();
            assert_eq!(twice, 1, "[{}] {}", s.section, s.key.name);
        }
    }

    /// Each setting of a new scene file, with the `#` taken away, becomes the argument of that name.
    #[test]
    fn each_setting_of_a_new_scene_file_reaches_its_argument() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("s.toml");
        let settings = settings();
        let text = template(&sections(&settings), &builtin_names(), "x");
        let (mut section, mut tried) = (String::new(), 0);
        for line in text.lines() {
            let bare = line.strip_prefix('#').filter(|l| !l.starts_with([' ', ':'])).unwrap_or(line);
            if bare.starts_with('[') {
                section = bare.trim_matches(['[', ']']).to_owned();
            }
            let Some(s) = bare
                .split_once(" = ")
                .and_then(|(key, _)| settings.iter().find(|s| s.section == section && s.key.name == key))
            else {
                continue;
            };
            let eye = if ["target", "up"].contains(&&s.id[..]) { "eye = [1, 2, 3]\n" } else { "" };
            std::fs::write(&path, format!("[{section}]\n{eye}{bare}\n")).expect("written");
            let args = RenderArgs { model: Some(path.clone()), ..RenderArgs::builtin() };
            let args = under(args).unwrap_or_else(|e| panic!("[{section}] {bare}: {e}"));
            assert!(args.in_file.contains(&s.id), "{}", s.id);
            tried += 1;
        }
        assert_eq!(tried, settings.len());
    }
}
