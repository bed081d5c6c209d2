//! Instances, lights and cameras as nodes.

use super::document::Document;
use super::place::Place;
use crate::extensions as ext;
use crate::ies::write_ies;
use etendue_scene::{Camera, Instance, Light, LightKind, Projection, Scene};
use glam::{Affine3A, Mat3, Mat3A, Quat, Vec3};
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// From so many instances of one thing in a row on, one node has them all.
const MANY: usize = 8;

/// What tells meshes of the file apart: geometry, material, and the materials in variants, for each primitive.
type Key = Vec<(u32, Option<u32>, Vec<[u32; 2]>)>;

struct Nodes<'a> {
    scene: &'a Scene,
    doc: &'a mut Document,
    roots: Vec<usize>,
    /// Per instance: pairs of a variant and a material.
    variants: HashMap<u32, Vec<[u32; 2]>>,
    primitives: HashMap<u32, Value>,
    meshes: HashMap<Key, usize>,
}

/// Adds all nodes; returns them.
pub(super) fn nodes(scene: &Scene, doc: &mut Document) -> Vec<usize> {
    let mut variants: HashMap<u32, Vec<[u32; 2]>> = HashMap::new();
    for (v, variant) in scene.variants.iter().enumerate() {
        for &[instance, material] in &variant.materials {
            variants.entry(instance).or_default().push([v as u32, material]);
        }
    }
    if !scene.variants.is_empty() {
        let list: Vec<_> = scene.variants.iter().map(|v| json!({ "name": v.name })).collect();
        doc.extension(ext::VARIANTS, json!({ "variants": list }));
    }
    let mut n =
        Nodes { scene, doc, roots: Vec::new(), variants, primitives: HashMap::new(), meshes: HashMap::new() };
    let mut i = 0;
    while i < scene.instances.len() {
        i += n.instances(i);
    }
    n.lights();
    for c in &scene.cameras {
        n.camera(c);
    }
    n.roots
}

impl Nodes<'_> {
    fn part(&self, i: usize) -> (u32, Option<u32>, Vec<[u32; 2]>) {
        let instance = &self.scene.instances[i];
        let variants = self.variants.get(&(i as u32)).cloned().unwrap_or_default();
        (instance.mesh, instance.material, variants)
    }

    /// Adds instances from number `i` on that belong together; returns how many.
    fn instances(&mut self, i: usize) -> usize {
        let all = &self.scene.instances;
        let first = &all[i];
        let mesh_name = |i: &Instance| &self.scene.meshes[i.mesh as usize].name;
        // Parts of one mesh: the same name in the same place.
        let parts = all[i..]
            .iter()
            .take_while(|k| {
                k.name == first.name && k.transform == first.transform && mesh_name(k) == mesh_name(first)
            })
            .count();
        if parts == 1 {
            let key = self.part(i);
            let run =
                (i..all.len()).take_while(|&k| all[k].name == first.name && self.part(k) == key).count();
            if run >= MANY {
                let places: Vec<_> = all[i..i + run].iter().map(|k| Place::of(&k.transform)).collect();
                if places.iter().all(|p| p.first.is_none()) {
                    self.crowd(vec![key], &first.name, &places);
                    return run;
                }
            }
        }
        let mesh = self.mesh((i..i + parts).map(|k| self.part(k)).collect());
        let place = Place::of(&first.transform);
        let mut node = place.node();
        match place.first {
            None => drop(node.insert("mesh".into(), json!(mesh))),
            Some(q) => {
                let mut inner = named(&first.name);
                inner.insert("mesh".into(), json!(mesh));
                inner.insert("rotation".into(), json!(q.to_array()));
                let child = self.doc.node(Value::Object(inner));
                node.insert("children".into(), json!([child]));
            }
        }
        node.extend(named(&first.name));
        let number = self.doc.node(Value::Object(node));
        self.roots.push(number);
        parts
    }

    /// One node with many instances.
    fn crowd(&mut self, key: Key, name: &str, places: &[Place]) {
        let mesh = self.mesh(key);
        let t: Vec<_> = places.iter().map(|p| p.translation.as_vec3().to_array()).collect();
        let r: Vec<_> = places.iter().map(|p| p.rotation.as_quat().to_array()).collect();
        let s: Vec<_> = places.iter().map(|p| p.scale.as_vec3().to_array()).collect();
        let mut attributes = Map::new();
        attributes.insert("TRANSLATION".into(), json!(self.doc.floats(&t, false, false)));
        if places.iter().any(|p| p.rotation != glam::DQuat::IDENTITY) {
            attributes.insert("ROTATION".into(), json!(self.doc.floats(&r, false, false)));
        }
        if places.iter().any(|p| p.scale != glam::DVec3::ONE) {
            attributes.insert("SCALE".into(), json!(self.doc.floats(&s, false, false)));
        }
        self.doc.requires(ext::GPU_INSTANCING);
        let mut node = named(name);
        node.insert("mesh".into(), json!(mesh));
        node.insert("extensions".into(), json!({ ext::GPU_INSTANCING: { "attributes": attributes } }));
        let number = self.doc.node(Value::Object(node));
        self.roots.push(number);
    }

    fn mesh(&mut self, key: Key) -> usize {
        if let Some(&known) = self.meshes.get(&key) {
            return known;
        }
        let name = key.first().map_or("", |k| &self.scene.meshes[k.0 as usize].name);
        let mut list = Vec::with_capacity(key.len());
        for (mesh, material, variants) in &key {
            let (doc, scene) = (&mut *self.doc, self.scene);
            let geometry =
                self.primitives.entry(*mesh).or_insert_with(|| doc.primitive(&scene.meshes[*mesh as usize]));
            let mut p = geometry.clone();
            if let Some(m) = material {
                p["material"] = json!(m);
            }
            if !variants.is_empty() {
                // One entry per material.
                let mut mappings: Vec<(u32, Vec<u32>)> = Vec::new();
                for &[v, m] in variants {
                    match mappings.iter_mut().find(|(known, _)| *known == m) {
                        Some((_, list)) => list.push(v),
                        None => mappings.push((m, vec![v])),
                    }
                }
                let mappings: Vec<_> =
                    mappings.into_iter().map(|(m, v)| json!({ "material": m, "variants": v })).collect();
                self.doc.uses(ext::VARIANTS);
                p["extensions"] = json!({ ext::VARIANTS: { "mappings": mappings } });
            }
            list.push(p);
        }
        let number = self.doc.mesh(name, list);
        self.meshes.insert(key, number);
        number
    }

    fn lights(&mut self) {
        if self.scene.lights.is_empty() {
            return;
        }
        let list: Vec<_> = self.scene.lights.iter().filter_map(light).collect();
        if !list.is_empty() {
            self.doc.extension(ext::LIGHTS_PUNCTUAL, json!({ "lights": list }));
        }
        self.profiles();
        let mut punctual = 0;
        for l in &self.scene.lights {
            // A light shines along −Z of its node.
            let aim = l.direction.normalize_or(Vec3::NEG_Z);
            let (turn, extension) = match l.kind {
                LightKind::Profile { profile, side } => {
                    let turn = Quat::from_mat3(&Mat3::from_cols(side, side.cross(aim), -aim));
                    let peak = l.intensity.max_element();
                    let color = if peak > 0.0 { l.intensity / peak } else { Vec3::ONE };
                    let lamp = json!({ "light": profile, "multiplier": peak, "color": color.to_array() });
                    (turn, json!({ ext::LIGHTS_IES: lamp }))
                }
                _ => {
                    punctual += 1;
                    let turn = Quat::from_rotation_arc(Vec3::NEG_Z, aim);
                    (turn, json!({ ext::LIGHTS_PUNCTUAL: { "light": punctual - 1 } }))
                }
            };
            let at = Affine3A { matrix3: Mat3A::from_quat(turn), translation: l.position.into() };
            let mut node = named(&l.name);
            node.extend(Place::of(&at).node());
            node.insert("extensions".into(), extension);
            let number = self.doc.node(Value::Object(node));
            self.roots.push(number);
        }
    }

    /// How measured lamps shine, as files in the buffer.
    fn profiles(&mut self) {
        if self.scene.profiles.is_empty() {
            return;
        }
        let mut list = Vec::new();
        for p in &self.scene.profiles {
            let view = self.doc.file(write_ies(p).as_bytes());
            list.push(json!({ "bufferView": view, "mimeType": "application/x-ies-lm-63" }));
        }
        self.doc.extension(ext::LIGHTS_IES, json!({ "lights": list }));
    }

    fn camera(&mut self, c: &Camera) {
        // The scene's cameras see everything; a rasteriser has to be told how near and how far.
        let bounds = self.scene.bounds();
        let size = if bounds.is_empty() { 1.0 } else { bounds.diagonal().clamp(1e-3, 1e6) };
        let eye = c.transform.translation;
        let far = if bounds.is_empty() { 100.0 } else { (eye - bounds.center()).length() + 2.0 * size };
        let mut camera = named(&c.name);
        match c.projection {
            Projection::Perspective { yfov } => {
                let mut p = json!({ "yfov": yfov, "znear": size * 1e-3 });
                if let Some(a) = c.aspect {
                    p["aspectRatio"] = json!(a);
                }
                camera.insert("type".into(), json!("perspective"));
                camera.insert("perspective".into(), p);
            }
            Projection::Orthographic { ymag } => {
                let x = ymag * c.aspect.unwrap_or(1.0);
                let o = json!({ "xmag": x, "ymag": ymag, "znear": 0.0, "zfar": far });
                camera.insert("type".into(), json!("orthographic"));
                camera.insert("orthographic".into(), o);
            }
        }
        let number = self.doc.camera(Value::Object(camera));
        let mut node = named(&c.name);
        node.extend(Place::of(&c.transform).node());
        node.insert("camera".into(), json!(number));
        let number = self.doc.node(Value::Object(node));
        self.roots.push(number);
    }
}

/// An object with a name, if there is one.
fn named(name: &str) -> Map<String, Value> {
    let mut out = Map::new();
    if !name.is_empty() {
        out.insert("name".into(), json!(name));
    }
    out
}

/// The light as `KHR_lights_punctual` has it; `None` for a measured one.
fn light(l: &Light) -> Option<Value> {
    let mut out = named(&l.name);
    let intensity = l.intensity.max_element();
    if intensity > 0.0 {
        out.insert("color".into(), json!((l.intensity.as_dvec3() / f64::from(intensity)).to_array()));
    }
    out.insert("intensity".into(), json!(intensity));
    if let Some(r) = l.range {
        out.insert("range".into(), json!(r));
    }
    let kind = match l.kind {
        LightKind::Directional => "directional",
        LightKind::Point => "point",
        LightKind::Spot { inner, outer } => {
            out.insert("spot".into(), json!({ "innerConeAngle": inner, "outerConeAngle": outer }));
            "spot"
        }
        LightKind::Profile { .. } => return None,
    };
    out.insert("type".into(), json!(kind));
    Some(Value::Object(out))
}
