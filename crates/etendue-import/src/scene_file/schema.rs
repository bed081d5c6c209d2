//! The JSON Schema of scene files, made from the lists that the reader goes by.

use super::key::{Key, Kind, Section};
use super::overrides::{ALL, measured_key, model_key, model_of, parameter_key};
use super::surface::{factors, textures};
use super::{light, place};
use serde_json::{Map, Value, json};
use toml::de::DeValue;

/// The schema (draft 7, which editors' TOML extensions know) of scene files with these tables of settings and built-in models.
pub fn schema(sections: &[Section], builtins: &[&str]) -> Value {
    let (model, lamp) = (place::keys(builtins), light::keys());
    let over = |about: &str| {
        json!({
            "type": "object",
            "description": about,
            "additionalProperties": { "$ref": "#/definitions/override" },
        })
    };
    let mut model = object(model.iter().map(|f| &f.key));
    model["properties"]["override"] = over("What is changed of this model's materials, by name");
    model["oneOf"] = json!([{ "required": ["file"] }, { "required": ["builtin"] }]);
    let mut lamp = object(lamp.iter().map(|f| &f.key));
    lamp["required"] = json!(["kind"]);
    let mut properties = Map::new();
    let list = |about: &str, items: Value| json!({ "type": "array", "description": about, "items": items });
    properties.insert("model".into(), list("A model and where it stands", model));
    properties.insert("light".into(), list("A light beside those of the models and the sky", lamp));
    let about = format!("What is changed of materials, by name; {ALL:?} stands for all of them");
    properties.insert("override".into(), over(&about));
    for s in sections {
        let mut table = object(s.keys.iter());
        table["description"] = json!(s.about);
        properties.insert(s.name.clone(), table);
    }
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A scene for etendue",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
        "definitions": { "override": overrides() },
    })
}

/// One shape for glTF's own surface, one for each model in its place, one for measured materials.
fn overrides() -> Value {
    let (factors, textures) = (factors(), textures());
    let all = factors.iter().map(|f| &f.field.key).chain(textures.iter().map(|t| &t.key));
    let factors_stay = factors.iter().filter(|f| f.stays).map(|f| &f.field.key);
    let stay: Vec<&Key> = factors_stay.chain(textures.iter().filter(|t| t.stays).map(|t| &t.key)).collect();
    let mut shapes = vec![object(all)];
    shapes[0]["title"] = json!("glTF's surface");
    let model = model_key();
    let Kind::Choice(names) = &model.kind else { return json!({}) };
    // Names that stand for one model share a shape: a metal is a conductor.
    let mut kinds: Vec<(&'static str, Vec<&String>)> = Vec::new();
    for (name, m) in names.iter().filter_map(|n| Some((n, model_of(n)?))) {
        match kinds.iter_mut().find(|(k, _)| *k == m.name()) {
            Some((_, list)) => list.push(name),
            None => kinds.push((m.name(), vec![name])),
        }
    }
    for (kind, names) in kinds {
        let Some(m) = model_of(kind) else { continue };
        let parameters: Vec<Key> = m.parameters().iter().map(parameter_key).collect();
        // What stays of the material goes first, so that a parameter of the same name takes its place.
        let mut shape = object(stay.iter().copied().chain(&parameters));
        shape["title"] = json!(kind);
        shape["description"] = json!(m.about());
        shape["properties"]["model"] = json!({ "enum": names, "description": model.about });
        shape["required"] = json!(["model"]);
        shapes.push(shape);
    }
    let measured = measured_key();
    let mut shape = object(stay.iter().copied().chain([&measured]));
    shape["title"] = json!("a measured material");
    shape["required"] = json!([measured.name]);
    shapes.push(shape);
    json!({ "oneOf": shapes })
}

fn object<'k>(keys: impl Iterator<Item = &'k Key>) -> Value {
    let properties: Map<String, Value> = keys.map(|k| (k.name.clone(), property(k))).collect();
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

fn property(key: &Key) -> Value {
    let mut p = shape(&key.kind);
    p["description"] = json!(key.about);
    if let Some(default) = key.default.as_deref().and_then(|d| DeValue::parse(d).ok()) {
        p["default"] = json_of(default.get_ref());
    }
    p
}

fn shape(kind: &Kind) -> Value {
    let bounded = |kind: &str, low: Option<Value>, high: Option<Value>| {
        let mut s = json!({ "type": kind });
        for (name, bound) in [("minimum", low), ("maximum", high)] {
            if let Some(v) = bound {
                s[name] = v;
            }
        }
        s
    };
    let numbers =
        |n: usize| json!({ "type": "array", "items": { "type": "number" }, "minItems": n, "maxItems": n });
    match kind {
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Number([a, b]) => {
            let bound = |v: &f64| v.is_finite().then(|| json!(v));
            bounded("number", bound(a), bound(b))
        }
        Kind::Integer([a, b]) => {
            bounded("integer", (*a > i64::MIN).then(|| json!(a)), (*b < i64::MAX).then(|| json!(b)))
        }
        Kind::Text | Kind::Path => json!({ "type": "string" }),
        Kind::Name => json!({ "anyOf": [{ "type": "string" }, { "type": "integer", "minimum": 0 }] }),
        Kind::Time => json!({ "anyOf": [{ "type": "number", "minimum": 0 }, { "type": "string" }] }),
        Kind::Choice(words) => json!({ "enum": words }),
        Kind::Words(words) => json!({
            "anyOf": [{ "type": "array", "items": { "enum": words } }, { "type": "string" }]
        }),
        Kind::Texts => json!({
            "anyOf": [{ "type": "array", "items": { "type": "string" } }, { "type": "string" }]
        }),
        Kind::Color => {
            let mut three = numbers(3);
            three["items"]["minimum"] = json!(0);
            json!({ "anyOf": [
                three,
                { "type": "number", "minimum": 0 },
                { "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" },
            ] })
        }
        Kind::Vector => numbers(3),
        Kind::Numbers(counts) => {
            let any: Vec<Value> = counts
                .iter()
                .map(|&n| if n == 1 { json!({ "type": "number" }) } else { numbers(n) })
                .collect();
            json!({ "anyOf": any })
        }
        Kind::Pair(_) => json!({ "anyOf": [
            { "type": "array", "items": { "type": "integer" }, "minItems": 2, "maxItems": 2 },
            { "type": "string" },
        ] }),
        Kind::Texture => json!({ "anyOf": [{ "type": "string" }, { "const": false }] }),
        Kind::Sky(names) => {
            let color = shape(&Kind::Color);
            json!({ "anyOf": [{ "enum": names }, { "type": "string" }, color] })
        }
        Kind::Table(keys) => object(keys.iter()),
    }
}

/// A value of TOML as JSON.
fn json_of(v: &DeValue<'_>) -> Value {
    match v {
        DeValue::String(s) => json!(s),
        DeValue::Boolean(b) => json!(b),
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).map_or(Value::Null, |i| json!(i)),
        DeValue::Float(f) => f.as_str().parse::<f64>().map_or(Value::Null, |f| json!(f)),
        DeValue::Array(a) => a.iter().map(|v| json_of(v.get_ref())).collect(),
        DeValue::Table(t) => t
            .iter()
            .map(|(k, v)| (k.get_ref().to_string(), json_of(v.get_ref())))
            .collect::<Map<_, _>>()
            .into(),
        DeValue::Datetime(d) => json!(d.to_string()),
    }
}
