//! A glTF document under construction, and its bytes.

use super::ExportError;
use crate::glb;
use crate::uri;
use etendue_scene::{Filter, Mesh, Sampler, Wrap};
use glam::Vec3;
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// Collects a glTF 2.0 document and its one buffer.
///
/// Parts are numbered in the order in which they are added; the caller puts the numbers into what refers to them.
#[derive(Debug)]
pub struct Document {
    bytes: Vec<u8>,
    asset: Map<String, Value>,
    scenes: Vec<Value>,
    extensions: Map<String, Value>,
    used: Vec<&'static str>,
    required: Vec<&'static str>,
    /// Arrays of the document by their names.
    lists: HashMap<&'static str, Vec<Value>>,
    samplers: Vec<Sampling>,
    textures: HashMap<(usize, usize), usize>,
    images: HashMap<Vec<u8>, usize>,
}

/// How a texture is looked up, in glTF's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    mag: u32,
    min: u32,
    wrap_s: u32,
    wrap_t: u32,
}

impl Sampling {
    /// That of a scene's sampler; minified textures are looked up trilinearly, or in the nearest texel of the nearest level.
    pub fn of(s: &Sampler) -> Self {
        let wrap = |w| match w {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        };
        let (mag, min) = match s.filter {
            Filter::Linear => (9729, 9987),
            Filter::Nearest => (9728, 9984),
        };
        Self { mag, min, wrap_s: wrap(s.wrap_u), wrap_t: wrap(s.wrap_v) }
    }
}

/// What a buffer view is for.
const ARRAY: u32 = 34962;
const INDICES: u32 = 34963;
/// Types of components.
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

impl Document {
    /// An empty document, written by `generator`.
    pub fn new(generator: &str) -> Self {
        let mut asset = Map::new();
        asset.insert("version".into(), json!("2.0"));
        asset.insert("generator".into(), json!(generator));
        Self {
            bytes: Vec::new(),
            asset,
            scenes: Vec::new(),
            extensions: Map::new(),
            used: Vec::new(),
            required: Vec::new(),
            lists: HashMap::new(),
            samplers: Vec::new(),
            textures: HashMap::new(),
            images: HashMap::new(),
        }
    }

    /// Says something of the asset.
    pub fn asset(&mut self, key: &str, value: Value) {
        self.asset.insert(key.into(), value);
    }

    fn push(&mut self, list: &'static str, value: Value) -> usize {
        let list = self.lists.entry(list).or_default();
        list.push(value);
        list.len() - 1
    }

    /// Names an extension that is used.
    pub fn uses(&mut self, extension: &'static str) {
        if !self.used.contains(&extension) {
            self.used.push(extension);
        }
    }

    /// Names an extension without which the scene cannot be shown.
    pub fn requires(&mut self, extension: &'static str) {
        self.uses(extension);
        if !self.required.contains(&extension) {
            self.required.push(extension);
        }
    }

    /// Sets an extension of the document itself.
    pub fn extension(&mut self, name: &'static str, value: Value) {
        self.uses(name);
        self.extensions.insert(name.into(), value);
    }

    /// Adds bytes, aligned to four; returns their view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut v = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(t) = target {
            v["target"] = json!(t);
        }
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", v)
    }

    /// Adds a file as it stands; the number of its view.
    pub fn file(&mut self, bytes: &[u8]) -> usize {
        self.view(bytes, None)
    }

    /// Adds `N`-vectors of floats; returns their accessor.
    ///
    /// `vertices` says that they are attributes of vertices, `bounds` that their smallest and largest values are noted.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]], vertices: bool, bounds: bool) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, vertices.then_some(ARRAY));
        let kind = ["SCALAR", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        let mut a = json!({ "bufferView": view, "componentType": F32, "count": values.len(), "type": kind });
        if let (true, Some(first)) = (bounds, values.first()) {
            let (mut min, mut max) = (*first, *first);
            for v in values {
                for k in 0..N {
                    min[k] = min[k].min(v[k]);
                    max[k] = max[k].max(v[k]);
                }
            }
            a["min"] = json!(min.to_vec());
            a["max"] = json!(max.to_vec());
        }
        self.push("accessors", a)
    }

    /// Adds triangles over `vertices` vertices, in 16 bits where these suffice; returns their accessor.
    pub fn triangles(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let flat = triangles.as_flattened();
        // The largest number of a type starts a new strip and is no vertex (glTF 2.0, 3.7.2.1).
        let (bytes, component): (Vec<u8>, u32) = if vertices <= 65_535 {
            (flat.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect(), U16)
        } else {
            (flat.iter().flat_map(|i| i.to_le_bytes()).collect(), U32)
        };
        let view = self.view(&bytes, Some(INDICES));
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "count": flat.len(), "type": "SCALAR" }),
        )
    }

    /// Adds the geometry of a mesh that has triangles; returns it as a primitive without a material.
    pub fn primitive(&mut self, m: &Mesh) -> Value {
        let list = |v: &[Vec3]| v.iter().map(|p| p.to_array()).collect::<Vec<_>>();
        let mut attributes = Map::new();
        attributes.insert("POSITION".into(), json!(self.floats(&list(&m.positions), true, true)));
        if !m.normals.is_empty() {
            attributes.insert("NORMAL".into(), json!(self.floats(&list(&m.normals), true, false)));
        }
        for (n, set) in m.uvs.iter().enumerate() {
            let set: Vec<_> = set.iter().map(|uv| uv.to_array()).collect();
            attributes.insert(format!("TEXCOORD_{n}"), json!(self.floats(&set, true, false)));
        }
        if !m.colors.is_empty() {
            let colors: Vec<_> = m.colors.iter().map(|c| c.to_array()).collect();
            attributes.insert("COLOR_0".into(), json!(self.floats(&colors, true, false)));
        }
        let indices = self.triangles(&m.indices, m.positions.len());
        if !m.tangents.is_empty() {
            let tangents: Vec<_> = m.tangents.iter().map(|t| t.to_array()).collect();
            attributes.insert("TANGENT".into(), json!(self.floats(&tangents, true, false)));
        }
        json!({ "attributes": attributes, "indices": indices })
    }

    /// Adds a picture file; returns the image. The same bytes are stored once. WebP makes its extension required where it is
    /// used, as no other picture stands beside it.
    pub fn image(&mut self, name: &str, mime: &'static str, file: &[u8]) -> usize {
        if let Some(&known) = self.images.get(file) {
            return known;
        }
        let view = self.view(file, None);
        let mut image = json!({ "bufferView": view, "mimeType": mime });
        if !name.is_empty() {
            image["name"] = json!(name);
        }
        let number = self.push("images", image);
        self.images.insert(file.to_vec(), number);
        number
    }

    /// Adds a texture of `image`; returns it. Equal ones are one.
    pub fn texture(&mut self, name: &str, image: usize, sampling: Sampling) -> usize {
        let sampler = self.samplers.iter().position(|s| *s == sampling).unwrap_or_else(|| {
            self.samplers.push(sampling);
            let Sampling { mag, min, wrap_s, wrap_t } = sampling;
            self.push(
                "samplers",
                json!({ "magFilter": mag, "minFilter": min, "wrapS": wrap_s, "wrapT": wrap_t }),
            )
        });
        if let Some(&known) = self.textures.get(&(image, sampler)) {
            return known;
        }
        let webp = self.lists["images"][image]["mimeType"] == "image/webp";
        let mut texture = if webp {
            self.requires("EXT_texture_webp");
            json!({ "extensions": { "EXT_texture_webp": { "source": image } }, "sampler": sampler })
        } else {
            json!({ "source": image, "sampler": sampler })
        };
        if !name.is_empty() {
            texture["name"] = json!(name);
        }
        let number = self.push("textures", texture);
        self.textures.insert((image, sampler), number);
        number
    }

    /// Adds a material as it stands in the file; the extensions in it count as used. Returns its number.
    pub fn material(&mut self, material: Value) -> usize {
        self.push("materials", material)
    }

    /// The materials so far.
    pub fn materials(&self) -> &[Value] {
        self.lists.get("materials").map_or(&[], Vec::as_slice)
    }

    /// Adds a mesh of primitives; returns its number.
    pub fn mesh(&mut self, name: &str, primitives: Vec<Value>) -> usize {
        let mut mesh = json!({ "primitives": primitives });
        if !name.is_empty() {
            mesh["name"] = json!(name);
        }
        self.push("meshes", mesh)
    }

    /// Adds a camera; returns its number.
    pub fn camera(&mut self, camera: Value) -> usize {
        self.push("cameras", camera)
    }

    /// Adds a node; returns its number.
    pub fn node(&mut self, node: Value) -> usize {
        self.push("nodes", node)
    }

    /// Adds a scene of nodes; the first one is shown.
    pub fn scene(&mut self, name: Option<&str>, roots: Vec<usize>) {
        let mut scene = Map::new();
        if let Some(n) = name {
            scene.insert("name".into(), json!(n));
        }
        if !roots.is_empty() {
            scene.insert("nodes".into(), json!(roots));
        }
        self.scenes.push(Value::Object(scene));
    }

    /// The JSON, with `uri` for the buffer.
    fn json(&mut self, uri: Option<String>) -> Vec<u8> {
        let mut doc = Map::new();
        doc.insert("asset".into(), Value::Object(std::mem::take(&mut self.asset)));
        if !self.scenes.is_empty() {
            doc.insert("scene".into(), json!(0));
            doc.insert("scenes".into(), Value::Array(std::mem::take(&mut self.scenes)));
        }
        // Empty arrays are not allowed.
        for (name, list) in self.lists.drain() {
            doc.insert(name.into(), Value::Array(list));
        }
        if !self.bytes.is_empty() {
            let mut buffer = json!({ "byteLength": self.bytes.len() });
            if let Some(uri) = uri {
                buffer["uri"] = json!(uri);
            }
            doc.insert("buffers".into(), json!([buffer]));
        }
        if !self.extensions.is_empty() {
            doc.insert("extensions".into(), Value::Object(std::mem::take(&mut self.extensions)));
        }
        for (key, list) in [("extensionsUsed", &self.used), ("extensionsRequired", &self.required)] {
            if !list.is_empty() {
                doc.insert(key.into(), json!(list));
            }
        }
        Value::Object(doc).to_string().into_bytes()
    }

    /// The document as GLB.
    ///
    /// # Errors
    /// [`ExportError::TooLarge`].
    pub fn glb(mut self) -> Result<Vec<u8>, ExportError> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let text = self.json(None);
        let length = Some(self.bytes.len() as u64).filter(|n| *n > 0);
        glb::join(&text, std::iter::once(&self.bytes[..]), length).map_err(ExportError::TooLarge)
    }

    /// The document as JSON that holds its bytes.
    ///
    /// # Errors
    /// [`ExportError::TooLarge`], as for GLB.
    pub fn embedded(mut self) -> Result<Vec<u8>, ExportError> {
        if u32::try_from(self.bytes.len()).is_err() {
            return Err(ExportError::TooLarge(self.bytes.len() as u64));
        }
        let uri = uri::of(&self.bytes);
        Ok(self.json(Some(uri)))
    }
}
