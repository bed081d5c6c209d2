//! `[override."NAME"]`: what is changed of a material, or another model in its place.

use super::check::{Checker, items, shorten};
use super::error::SceneFileError;
use super::key::{Key, Kind, Value};
use super::surface::{SurfaceKey, TextureKey, factors, textures};
use etendue_bxdf::ior_table;
use etendue_bxdf::model::{Model, Parameter, Value as Given};
use etendue_scene::{Extensions, Material, MeasuredMaterial, Substitute, TextureRef};
use glam::Vec3;
use std::ops::Range;
use std::path::PathBuf;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The name that stands for every material.
pub(crate) const ALL: &str = "*";

/// What is changed of the materials of one name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Override {
    /// Their name, or [`ALL`].
    pub material: String,
    /// The name's place.
    pub span: Range<usize>,
    model: Option<Box<Model>>,
    /// The file of a measured material.
    pub measured: Option<(PathBuf, Range<usize>)>,
    /// Number in [`factors`], value.
    factors: Vec<(usize, Value)>,
    /// Number in [`textures`], file or none, place.
    pub textures: Vec<(usize, Option<PathBuf>, Range<usize>)>,
}

/// The key that puts a model in the material's place.
pub(crate) fn model_key() -> Key {
    let names: Vec<&str> = Model::NAMES.iter().copied().chain(ior_table::names()).collect();
    let about = "Another scattering model instead of glTF's, whose parameters then stand here (`etendue lab list` lists them); names of measured metals and glasses are models, too";
    Key::new("model", Kind::choice(&names), about)
}

/// The key that puts a measurement in the material's place.
pub(crate) fn measured_key() -> Key {
    let about = "A measured material instead of glTF's: a .bsdf or .pbsdf file";
    Key::new("measured", Kind::Path, about)
}

/// The model of a name: whole models first, then measured materials, as in `--material`.
pub(crate) fn model_of(name: &str) -> Option<Model> {
    Model::by_name(name).ok().or_else(|| Model::measured(name))
}

/// A model's parameter as a key.
pub(crate) fn parameter_key(p: &Parameter) -> Key {
    // By way of their shortest text: 0.1 shall not become 0.10000000149.
    let wide = |v: f32| v.to_string().parse().unwrap_or(f64::from(v));
    let list = |v: [f32; 3]| format!("[{}, {}, {}]", wide(v[0]), wide(v[1]), wide(v[2]));
    let kind = match p.default {
        Given::Number(_) => Kind::Number(p.range.map(wide)),
        Given::Color(_) => Kind::Color,
        Given::Vector(_) => Kind::Vector,
        Given::Flag(_) => Kind::Flag,
        Given::Choice(_) => Kind::choice(p.choices),
    };
    let default = match p.default {
        // There is no number for what has no bound; it is what stands there if nothing does.
        Given::Number(v) => v.is_finite().then(|| wide(v).to_string()),
        Given::Color(v) | Given::Vector(v) => Some(list(v)),
        Given::Flag(v) => Some(v.to_string()),
        Given::Choice(v) => Some(format!("{v:?}")),
    };
    let about = p.about.split_whitespace().collect::<Vec<_>>().join(" ");
    Key { default, ..Key::new(p.name, kind, &about) }
}

/// A checked value as the model takes it.
fn given(p: &Parameter, v: &Value) -> Given {
    match p.default {
        Given::Number(_) => Given::Number(v.f32()),
        Given::Color(_) => Given::Color(v.numbers()),
        Given::Vector(_) => Given::Vector(v.numbers()),
        Given::Flag(_) => Given::Flag(v.flag()),
        Given::Choice(c) => Given::Choice(p.choices.iter().find(|c| **c == v.text()).unwrap_or(&c)),
    }
}

impl Override {
    /// Reads the table of `material`.
    pub fn read(
        material: &str,
        span: &Range<usize>,
        table: &DeTable<'_>,
        c: &Checker<'_>,
    ) -> Result<Self, SceneFileError> {
        let mut o = Self {
            material: material.to_owned(),
            span: span.clone(),
            model: None,
            measured: None,
            factors: Vec::new(),
            textures: Vec::new(),
        };
        let place = format!("in override {:?}", shorten(material));
        let (factors, textures): (Vec<SurfaceKey>, Vec<TextureKey>) = (factors(), textures());
        let (model_key, measured_key) = (model_key(), measured_key());
        // What stands for the whole is read first, wherever it is written.
        let mut model = None;
        for (name, key_span, value) in items(table) {
            let key = match name {
                "model" => &model_key,
                "measured" => &measured_key,
                _ => continue,
            };
            if o.measured.is_some() || model.is_some() {
                let message = "an override has either `model` or `measured`";
                return Err(c.text.wrong(&key_span, message, None));
            }
            let entry = c.entry(name, &key_span, value, &[key], &place)?;
            match entry.value {
                Value::Path(path) => o.measured = Some((path, entry.span)),
                v => model = model_of(v.text()),
            }
        }
        let parameters = model.map(|m| m.parameters()).unwrap_or_default();
        let parameter_keys: Vec<Key> = parameters.iter().map(parameter_key).collect();
        let whole = model.is_none() && o.measured.is_none();
        let surface: Vec<usize> = (0..factors.len()).filter(|&i| whole || factors[i].stays).collect();
        let slots: Vec<usize> = (0..textures.len()).filter(|&i| whole || textures[i].stays).collect();
        // The model's parameters go before what stays of the material.
        let keys: Vec<&Key> = parameter_keys
            .iter()
            .chain(surface.iter().map(|&i| &factors[i].field.key))
            .chain(slots.iter().map(|&i| &textures[i].key))
            .collect();
        for (name, key_span, value) in items(table) {
            if ["model", "measured"].contains(&name) {
                continue;
            }
            if !keys.iter().any(|k| k.name == name) && !whole {
                let known = factors.iter().map(|f| &f.field.key).chain(textures.iter().map(|t| &t.key));
                if known.into_iter().any(|k| k.name == name) {
                    return Err(replaced(name, &key_span, model.as_ref(), c));
                }
            }
            let known = keys.iter().map(|k| k.name.as_str()).chain(["model", "measured"]);
            if !keys.iter().any(|k| k.name == name) {
                return Err(c.unknown(name, &key_span, known, &place));
            }
            let e = c.entry(name, &key_span, value, &keys, &place)?;
            let (after_model, after_surface) =
                (e.key.checked_sub(parameters.len()), e.key.checked_sub(parameters.len() + surface.len()));
            match (model.as_mut(), after_model, after_surface) {
                (_, _, Some(slot)) => {
                    let file = if let Value::Path(p) = e.value { Some(p) } else { None };
                    o.textures.push((slots[slot], file, e.span));
                }
                (_, Some(factor), None) => o.factors.push((surface[factor], e.value)),
                (Some(m), None, _) => {
                    let p = &parameters[e.key];
                    m.set(p.name, given(p, &e.value));
                }
                (None, None, _) => {}
            }
        }
        o.model = model.map(Box::new);
        Ok(o)
    }

    /// Changes `m`: `measured` is what was read from the file of that key, `loaded` the textures in the order of
    /// [`Override::textures`].
    pub fn apply(
        &self,
        m: &mut Material,
        measured: Option<&MeasuredMaterial>,
        loaded: &[Option<TextureRef>],
    ) {
        let (fields, slots) = (factors(), textures());
        if let Some(model) = &self.model {
            let emission = Vec3::from(model.emission().to_rgb());
            if emission != Vec3::ZERO {
                (m.emissive, m.emissive_texture) = (emission, None);
            }
            m.substitute = Some(Substitute::Model(model.clone()));
        }
        if let Some(measured) = measured {
            m.substitute = Some(Substitute::Measured(measured.clone()));
        }
        // Before the factors, some of which are about a texture.
        for ((slot, ..), texture) in self.textures.iter().zip(loaded) {
            match texture {
                Some(t) => (slots[*slot].set)(m, Some(*t)),
                None => leave_out(m, slots[*slot].set),
            }
        }
        for (k, v) in &self.factors {
            (fields[*k].field.set)(m, v);
        }
    }
}

/// The error for a key of glTF's surface where something else is in its place.
fn replaced(name: &str, span: &Range<usize>, model: Option<&Model>, c: &Checker<'_>) -> SceneFileError {
    let (what, help) = match model {
        Some(m) => {
            let names: Vec<_> = m.parameters().iter().map(|p| p.name).collect();
            let near = super::nearest(name, names.iter().copied());
            let help = near
                .map_or_else(|| format!("it has {}", names.join(", ")), |n| format!("did you mean `{n}`?"));
            (m.name().to_owned(), Some(help))
        }
        None => ("a measured material".into(), None),
    };
    c.text.wrong(span, format!("`{name}` is of glTF's surface; {what} stands in its place"), help)
}

/// Takes a texture away without leaving an extension where there was none.
fn leave_out(m: &mut Material, set: fn(&mut Material, Option<TextureRef>)) {
    let had = m.extensions.clone();
    set(m, None);
    m.extensions = match (had, m.extensions.take()) {
        (Some(had), Some(now)) => {
            let now = *now;
            Some(Box::new(Extensions {
                anisotropy: now.anisotropy.filter(|_| had.anisotropy.is_some()),
                clearcoat: now.clearcoat.filter(|_| had.clearcoat.is_some()),
                diffuse_roughness: now.diffuse_roughness.filter(|_| had.diffuse_roughness.is_some()),
                diffuse_transmission: now.diffuse_transmission.filter(|_| had.diffuse_transmission.is_some()),
                fuzz: now.fuzz.filter(|_| had.fuzz.is_some()),
                iridescence: now.iridescence.filter(|_| had.iridescence.is_some()),
                scatter: now.scatter.filter(|_| had.scatter.is_some()),
                sheen: now.sheen.filter(|_| had.sheen.is_some()),
                specular_glossiness: now.specular_glossiness.filter(|_| had.specular_glossiness.is_some()),
                transmission: now.transmission.filter(|_| had.transmission.is_some()),
                volume: now.volume.filter(|_| had.volume.is_some()),
                ..now
            }))
        }
        _ => None,
    };
}

/// Reads a table of overrides.
pub(crate) fn read_all(
    value: &Spanned<DeValue<'_>>,
    c: &Checker<'_>,
) -> Result<Vec<Override>, SceneFileError> {
    let DeValue::Table(table) = value.get_ref() else {
        let help = Some("write [override.\"NAME\"] with the material's name".into());
        return Err(c.text.wrong(&value.span(), "`override` has to be a table of materials", help));
    };
    let read = |(name, span, value): super::check::Item<'_, '_>| match value.get_ref() {
        DeValue::Table(t) => Override::read(name, &span, t, c),
        _ => {
            let help = Some(format!("write [override.\"{name}\"] and below it what is changed"));
            Err(c.text.wrong(&span, format!("override {:?} has to be a table", shorten(name)), help))
        }
    };
    items(table).into_iter().map(read).collect()
}
