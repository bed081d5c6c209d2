//! A small writer of binary glTF 2.0: meshes, textured metal-rough materials, a flat list of nodes.

use crate::shape::Mesh;
use glam::Mat4;
use serde_json::{Value, json};
use std::collections::HashMap;

/// Collects a glTF document and its one binary chunk.
pub struct Gltf {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    nodes: Vec<Value>,
    extensions: Vec<&'static str>,
    shared: HashMap<Vec<u8>, usize>,
}

/// glTF's name for an array buffer and an index buffer.
const ARRAY: u32 = 34962;
const INDICES: u32 = 34963;

impl Gltf {
    /// An empty document.
    pub fn new() -> Self {
        Self {
            bin: Vec::new(),
            views: Vec::new(),
            accessors: Vec::new(),
            meshes: Vec::new(),
            materials: Vec::new(),
            images: Vec::new(),
            textures: Vec::new(),
            nodes: Vec::new(),
            extensions: Vec::new(),
            shared: HashMap::new(),
        }
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        while !self.bin.len().is_multiple_of(4) {
            self.bin.push(0);
        }
        let mut v = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(t) = target {
            v["target"] = json!(t);
        }
        self.bin.extend_from_slice(bytes);
        self.views.push(v);
        self.views.len() - 1
    }

    fn floats(&mut self, kind: &str, values: &[f32], bounds: Option<(Vec<f32>, Vec<f32>)>) -> usize {
        let n = match kind {
            "VEC2" => 2,
            "VEC4" => 4,
            _ => 3,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY));
        let mut a =
            json!({ "bufferView": view, "componentType": 5126, "count": values.len() / n, "type": kind });
        if let Some((min, max)) = bounds {
            a["min"] = json!(min);
            a["max"] = json!(max);
        }
        self.accessors.push(a);
        self.accessors.len() - 1
    }

    /// Adds a picture file (PNG or JPEG) and a repeating, trilinear texture of it; returns the texture. The same bytes are
    /// stored once.
    pub fn texture(&mut self, name: &str, mime: &str, file: &[u8]) -> usize {
        if let Some(&t) = self.shared.get(file) {
            return t;
        }
        let view = self.view(file, None);
        self.images.push(json!({ "bufferView": view, "mimeType": mime, "name": name }));
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": 0, "name": name }));
        self.shared.insert(file.to_vec(), self.textures.len() - 1);
        self.textures.len() - 1
    }

    /// Adds a material as it stands in the file; returns its index.
    pub fn material(&mut self, material: Value) -> usize {
        if material["extensions"]["KHR_materials_emissive_strength"].is_object()
            && !self.extensions.contains(&"KHR_materials_emissive_strength")
        {
            self.extensions.push("KHR_materials_emissive_strength");
        }
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a mesh of (geometry, material) primitives; returns its index.
    pub fn mesh(&mut self, name: &str, primitives: &[(&Mesh, usize)]) -> usize {
        let list: Vec<Value> = primitives.iter().map(|(m, material)| self.primitive(m, *material)).collect();
        self.meshes.push(json!({ "name": name, "primitives": list }));
        self.meshes.len() - 1
    }

    fn primitive(&mut self, m: &Mesh, material: usize) -> Value {
        let m = without_unused(m);
        let (mut min, mut max) = (m.pos[0], m.pos[0]);
        for p in &m.pos {
            (min, max) = (min.min(*p), max.max(*p));
        }
        let flat = |v: &[glam::Vec3]| v.iter().flat_map(|p| p.to_array()).collect::<Vec<_>>();
        let bounds = Some((min.to_array().to_vec(), max.to_array().to_vec()));
        let position = self.floats("VEC3", &flat(&m.pos), bounds);
        let normal = self.floats("VEC3", &flat(&m.nrm), None);
        let uv = self.floats("VEC2", &m.uv.iter().flat_map(|t| t.to_array()).collect::<Vec<_>>(), None);
        let bytes: Vec<u8> = m.idx.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect();
        assert!(m.pos.len() < 65_535, "a primitive's vertices are counted in 16 bits");
        let view = self.view(&bytes, Some(INDICES));
        self.accessors.push(
            json!({ "bufferView": view, "componentType": 5123, "count": m.idx.len(), "type": "SCALAR" }),
        );
        let indices = self.accessors.len() - 1;
        let mut attributes = json!({ "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv });
        // Tangents serve normal maps alone.
        if self.materials[material]["normalTexture"].is_object() {
            let tangents: Vec<f32> = m.tangents().iter().flat_map(|t| t.to_array()).collect();
            attributes["TANGENT"] = json!(self.floats("VEC4", &tangents, None));
        }
        json!({ "attributes": attributes, "indices": indices, "material": material })
    }

    /// Adds a node that shows a mesh at a place without scale or shear.
    pub fn node(&mut self, name: &str, mesh: usize, place: Mat4) {
        let (_, r, t) = place.to_scale_rotation_translation();
        let mut node = json!({ "name": name, "mesh": mesh });
        if place != Mat4::IDENTITY {
            node["translation"] = json!(t.to_array());
            node["rotation"] = json!(r.normalize().to_array());
        }
        self.nodes.push(node);
    }

    /// The file. All nodes become children of one root named `name`, moved by `offset` metres upward.
    pub fn finish(mut self, name: &str, offset: f32) -> Vec<u8> {
        let children: Vec<usize> = (0..self.nodes.len()).collect();
        self.nodes.push(json!({ "name": name, "children": children, "translation": [0.0, offset, 0.0] }));
        while !self.bin.len().is_multiple_of(4) {
            self.bin.push(0);
        }
        let mut doc = json!({
            "asset": { "version": "2.0", "generator": "etendue-builtin" },
            "scene": 0,
            "scenes": [{ "name": name, "nodes": [self.nodes.len() - 1] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "textures": self.textures,
            "images": self.images,
            "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bin.len() }]
        });
        if !self.extensions.is_empty() {
            doc["extensionsUsed"] = json!(self.extensions);
        }
        let mut text = doc.to_string().into_bytes();
        while !text.len().is_multiple_of(4) {
            text.push(b' ');
        }
        let total = 12 + 8 + text.len() + 8 + self.bin.len();
        let mut out = Vec::with_capacity(total);
        for word in [0x4654_6c67, 2, total as u32, text.len() as u32, 0x4e4f_534a] {
            out.extend_from_slice(&u32::to_le_bytes(word));
        }
        out.extend_from_slice(&text);
        for word in [self.bin.len() as u32, 0x004e_4942] {
            out.extend_from_slice(&u32::to_le_bytes(word));
        }
        out.extend_from_slice(&self.bin);
        out
    }
}

/// The mesh without vertices that no triangle uses.
fn without_unused(m: &Mesh) -> Mesh {
    let mut out = Mesh::default();
    let mut map = vec![u32::MAX; m.pos.len()];
    for &i in &m.idx {
        let k = i as usize;
        if map[k] == u32::MAX {
            map[k] = out.push(m.pos[k], m.nrm[k], m.uv[k], m.aux[k]);
        }
        out.idx.push(map[k]);
    }
    out
}
