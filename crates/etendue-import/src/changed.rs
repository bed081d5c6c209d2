//! Materials, cameras, lights and skies whose values an animation changes: their JSON with the new values in it, read again.

use crate::document::{Camera, ImageLight, Light, Material};
use crate::error::Fault;
use crate::json::Reader;
use crate::pointer::{Owner, set};
use crate::warning::Warnings;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};

/// New values by where they belong.
#[derive(Default)]
pub(crate) struct Changes(BTreeMap<Owner, Vec<(Vec<String>, Value)>>);

impl Changes {
    /// Notes that the property at `path` within `owner` is now `value`.
    pub fn add(&mut self, owner: Owner, path: &[&str], value: Vec<f64>) {
        let value = if let [one] = value[..] { one.into() } else { Value::from(value) };
        let path = path.iter().map(|s| (*s).to_owned()).collect();
        self.0.entry(owner).or_default().push((path, value));
    }

    /// The JSON of the changed objects of the document `tree`.
    pub fn objects(&self, tree: &Value, warnings: &mut Warnings) -> Vec<(Owner, Value)> {
        let changed = self.0.iter().filter_map(|(owner, values)| {
            let mut object = tree.pointer(&owner.pointer())?.clone();
            for (path, value) in values {
                let path: Vec<&str> = path.iter().map(String::as_str).collect();
                if !set(&mut object, &path, value.clone()) {
                    let place = format!("{}/{}", owner.pointer(), path.join("/"));
                    warnings
                        .add(place, "is animated, but it belongs to an object that is not there; ignored");
                }
            }
            Some((*owner, object))
        });
        changed.collect()
    }
}

/// The changed objects; others are as the document has them.
#[derive(Default)]
pub(crate) struct Changed<'v> {
    pub materials: HashMap<u32, Material<'v>>,
    pub cameras: HashMap<u32, Camera<'v>>,
    pub lights: HashMap<u32, Light<'v>>,
    pub skies: HashMap<u32, ImageLight>,
}

impl<'v> Changed<'v> {
    /// Reads the objects again, `drafts` of extensions too if they are asked for. What is odd about them otherwise has been said
    /// of the document.
    pub fn read(objects: &'v [(Owner, Value)], drafts: bool) -> Result<Self, Fault> {
        let mut r = Reader::new(Warnings::default(), drafts);
        let mut out = Self::default();
        for (owner, v) in objects {
            match *owner {
                Owner::Material(i) => drop(out.materials.insert(i, Material::read(&mut r, v)?)),
                Owner::Camera(i) => drop(out.cameras.insert(i, Camera::read(&mut r, v)?)),
                Owner::Light(i) => drop(out.lights.insert(i, Light::read(&mut r, v)?)),
                Owner::Sky(i) => drop(out.skies.insert(i, ImageLight::read(&mut r, v)?)),
            }
        }
        Ok(out)
    }
}
