//! The JSON alone: lists, references, extensions and where they stand.

use super::{Case, list};
use crate::extensions as ext;
use serde_json::Value;
use std::collections::HashSet;

/// Properties of the entries of lists that refer to an entry of a list.
const REFERENCES: [(&str, &str, &str); 13] = [
    ("accessors", "bufferView", "bufferViews"),
    ("bufferViews", "buffer", "buffers"),
    ("images", "bufferView", "bufferViews"),
    ("nodes", "camera", "cameras"),
    ("nodes", "children", "nodes"),
    ("nodes", "mesh", "meshes"),
    ("nodes", "skin", "skins"),
    ("scenes", "nodes", "nodes"),
    ("skins", "inverseBindMatrices", "accessors"),
    ("skins", "joints", "nodes"),
    ("skins", "skeleton", "nodes"),
    ("textures", "sampler", "samplers"),
    ("textures", "source", "images"),
];

/// Lists whose entries the reader does not look at for extensions that have no place there, and those that have one.
const PLACES: [(&str, &[&str]); 6] = [
    ("animations", &[]),
    ("buffers", &[ext::EXT_MESHOPT, ext::KHR_MESHOPT]),
    ("images", &[]),
    ("samplers", &[]),
    ("skins", &[]),
    ("textures", &[ext::TEXTURE_BASISU, ext::TEXTURE_WEBP]),
];

/// Extensions at the root that need a list, and its name.
const LISTS: [(&str, &str); 3] =
    [(ext::LIGHTS_PUNCTUAL, "lights"), (ext::LIGHTS_IMAGE_BASED, "lights"), (ext::VARIANTS, "variants")];

impl Case<'_> {
    pub(super) fn structure(&mut self) {
        self.names();
        let root = self.root;
        self.walk(root, &mut String::new());
        self.references();
        self.places();
        self.lights();
        self.cameras();
    }

    fn declared(&self) -> HashSet<&str> {
        list(self.root, "extensionsUsed").iter().filter_map(Value::as_str).collect()
    }

    fn names(&mut self) {
        for key in ["extensionsUsed", "extensionsRequired"] {
            let mut seen = HashSet::new();
            for (i, v) in list(self.root, key).iter().enumerate() {
                if !seen.insert(v.as_str()) {
                    self.out.add(format!("/{key}/{i}"), "an extension is named twice");
                }
            }
        }
        let declared: HashSet<&str> =
            list(self.root, "extensionsUsed").iter().filter_map(Value::as_str).collect();
        for (i, v) in list(self.root, "extensionsRequired").iter().enumerate() {
            if v.as_str().is_some_and(|n| !declared.contains(n)) {
                self.out.add(
                    format!("/extensionsRequired/{i}"),
                    "a required extension is not named in `extensionsUsed`, too",
                );
            }
        }
    }

    /// Everything below `v`, to which `at` points: its depth is bounded by the limit on the JSON's.
    fn walk(&mut self, v: &Value, at: &mut String) {
        let length = at.len();
        match v {
            Value::Array(a) => {
                for (i, v) in a.iter().enumerate() {
                    at.push_str(&format!("/{i}"));
                    self.walk(v, at);
                    at.truncate(length);
                }
            }
            Value::Object(o) => {
                for (k, v) in o {
                    at.push('/');
                    at.push_str(&k.replace('~', "~0").replace('/', "~1"));
                    match (k.as_str(), v) {
                        // Anything may stand there.
                        ("extras", _) => {}
                        ("extensions", Value::Object(e)) => self.extensions(e, at),
                        (_, Value::Array(a)) if a.is_empty() => {
                            self.out.add(at.clone(), "an empty list; it should be left out");
                        }
                        _ => self.walk(v, at),
                    }
                    at.truncate(length);
                }
            }
            _ => {}
        }
    }

    fn extensions(&mut self, e: &serde_json::Map<String, Value>, at: &mut String) {
        let length = at.len();
        for (name, v) in e {
            at.push_str(&format!("/{}", name.replace('~', "~0").replace('/', "~1")));
            if !self.declared().contains(name.as_str()) {
                self.out.add(at.clone(), format!("{name} stands here but is not named in `extensionsUsed`"));
            }
            // Below a material only textures have extensions.
            let deep = at.starts_with("/materials/") && at.matches('/').count() > 4;
            if deep && name != ext::TEXTURE_TRANSFORM && ext::is_understood(name) {
                self.out.add(at.clone(), format!("{name} has no place here"));
            }
            // What unknown ones hold is theirs.
            if ext::is_understood(name) && name != ext::XMP {
                self.walk(v, at);
            }
            at.truncate(length);
        }
    }

    fn references(&mut self) {
        let count = |name: &str| list(self.root, name).len();
        let out = &mut self.out;
        let mut check = |v: &Value, target: &str, at: String| {
            // Other types are the reader's to complain about.
            let Some(i) = v.as_u64() else { return };
            let n = count(target);
            if i >= n as u64 {
                out.add(at, format!("refers to number {i} of `{target}`, which has {n}"));
            }
        };
        for (from, key, target) in REFERENCES {
            for (i, entry) in list(self.root, from).iter().enumerate() {
                match entry.get(key) {
                    Some(Value::Array(a)) => {
                        for (k, v) in a.iter().enumerate() {
                            check(v, target, format!("/{from}/{i}/{key}/{k}"));
                        }
                    }
                    Some(v) => check(v, target, format!("/{from}/{i}/{key}")),
                    None => {}
                }
            }
        }
        for (i, t) in list(self.root, "textures").iter().enumerate() {
            for name in [ext::TEXTURE_BASISU, ext::TEXTURE_WEBP] {
                if let Some(v) = t.pointer(&format!("/extensions/{name}/source")) {
                    check(v, "images", format!("/textures/{i}/extensions/{name}/source"));
                }
            }
        }
        for (i, m) in list(self.root, "meshes").iter().enumerate() {
            let primitives = m.get("primitives").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            for (k, p) in primitives.iter().enumerate() {
                let at = format!("/meshes/{i}/primitives/{k}");
                for (key, target) in [("indices", "accessors"), ("material", "materials")] {
                    if let Some(v) = p.get(key) {
                        check(v, target, format!("{at}/{key}"));
                    }
                }
                let sets = p.get("targets").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
                for o in p.get("attributes").into_iter().chain(sets).filter_map(Value::as_object) {
                    o.iter().for_each(|(name, v)| check(v, "accessors", format!("{at}/attributes/{name}")));
                }
            }
        }
    }

    /// Known extensions where they say nothing.
    fn places(&mut self) {
        for (name, allowed) in PLACES {
            for (i, entry) in list(self.root, name).iter().enumerate() {
                let Some(Value::Object(e)) = entry.get("extensions") else { continue };
                for n in e.keys().filter(|n| ext::is_understood(n) && *n != ext::XMP) {
                    if !allowed.contains(&n.as_str()) {
                        self.out.add(format!("/{name}/{i}/extensions/{n}"), format!("{n} has no place here"));
                    }
                }
            }
        }
    }

    fn lights(&mut self) {
        for (name, needed) in LISTS {
            if let Some(e) = self.root.pointer(&format!("/extensions/{name}"))
                && e.get(needed).is_none()
            {
                self.out.add(format!("/extensions/{name}"), format!("`{needed}` is missing"));
            }
        }
        let lights = self.root.pointer(&format!("/extensions/{}/lights", ext::LIGHTS_PUNCTUAL));
        let lights = lights.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        for (i, l) in lights.iter().enumerate() {
            let at = format!("/extensions/{}/lights/{i}", ext::LIGHTS_PUNCTUAL);
            if l.get("type").and_then(Value::as_str) != Some("spot") {
                continue;
            }
            let Some(spot) = l.get("spot") else {
                self.out.add(at, "a spot light has no `spot`");
                continue;
            };
            let angle = |key: &str, usual: f64| spot.get(key).and_then(Value::as_f64).unwrap_or(usual);
            let (inner, outer) =
                (angle("innerConeAngle", 0.0), angle("outerConeAngle", std::f64::consts::FRAC_PI_4));
            if inner >= outer {
                self.out.add(format!("{at}/spot"), "the inner cone is not inside the outer one");
            }
        }
    }

    fn cameras(&mut self) {
        for (i, c) in list(self.root, "cameras").iter().enumerate() {
            let at = format!("/cameras/{i}");
            if c.get("perspective").is_some() && c.get("orthographic").is_some() {
                self.out.add(at.clone(), "is both perspective and orthographic");
            }
            for kind in ["perspective", "orthographic"] {
                let plane = |key: &str| c.get(kind)?.get(key)?.as_f64();
                if let (Some(near), Some(far)) = (plane("znear"), plane("zfar"))
                    && far <= near
                {
                    self.out.add(format!("{at}/{kind}"), "`zfar` is not beyond `znear`");
                }
            }
        }
    }
}
