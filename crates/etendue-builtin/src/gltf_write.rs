//! The helmet's glTF: its parts put into the document that the importer's room writes.

use crate::shape::Mesh;
use etendue_import::write::{Document, ExportError, Sampling};
use etendue_scene::Sampler;
use glam::Mat4;
use serde_json::{Value, json};

/// Collects textured metal-rough materials, meshes, and a flat list of nodes.
pub struct Gltf {
    doc: Document,
    nodes: Vec<usize>,
}

const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";

impl Gltf {
    /// An empty document.
    pub fn new() -> Self {
        Self { doc: Document::new("etendue-builtin"), nodes: Vec::new() }
    }

    /// Adds a picture file (PNG or JPEG) and a repeating, trilinear texture of it; returns the texture. The same bytes are
    /// stored once.
    pub fn texture(&mut self, name: &str, mime: &'static str, file: &[u8]) -> usize {
        let image = self.doc.image(name, mime, file);
        self.doc.texture(name, image, Sampling::of(&Sampler::default()))
    }

    /// Adds a material as it stands in the file; returns its index.
    pub fn material(&mut self, material: Value) -> usize {
        if material["extensions"][EMISSIVE_STRENGTH].is_object() {
            self.doc.uses(EMISSIVE_STRENGTH);
        }
        self.doc.material(material)
    }

    /// Adds a mesh of (geometry, material) primitives; returns its index.
    pub fn mesh(&mut self, name: &str, primitives: &[(&Mesh, usize)]) -> usize {
        let list = primitives.iter().map(|(m, material)| self.primitive(m, *material)).collect();
        self.doc.mesh(name, list)
    }

    fn primitive(&mut self, m: &Mesh, material: usize) -> Value {
        let m = without_unused(m);
        // Tangents serve normal maps alone.
        let bumpy = self.doc.materials()[material]["normalTexture"].is_object();
        let mut p = self.doc.primitive(&etendue_scene::Mesh {
            tangents: if bumpy { m.tangents() } else { Vec::new() },
            indices: m.idx.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            positions: m.pos,
            normals: m.nrm,
            uvs: vec![m.uv],
            ..etendue_scene::Mesh::default()
        });
        p["material"] = json!(material);
        p
    }

    /// Adds a node that shows a mesh at a place without scale or shear.
    pub fn node(&mut self, name: &str, mesh: usize, place: Mat4) {
        let (_, r, t) = place.to_scale_rotation_translation();
        let mut node = json!({ "name": name, "mesh": mesh });
        if place != Mat4::IDENTITY {
            node["translation"] = json!(t.to_array());
            node["rotation"] = json!(r.normalize().to_array());
        }
        self.nodes.push(self.doc.node(node));
    }

    /// The file. All nodes become children of one root named `name`, moved by `offset` metres upward.
    ///
    /// # Errors
    /// If it has more bytes than a GLB can hold.
    pub fn finish(mut self, name: &str, offset: f32) -> Result<Vec<u8>, ExportError> {
        let root = json!({ "name": name, "children": self.nodes, "translation": [0.0, offset, 0.0] });
        let root = self.doc.node(root);
        self.doc.scene(Some(name), vec![root]);
        self.doc.glb()
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
