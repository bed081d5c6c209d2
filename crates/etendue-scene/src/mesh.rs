//! Triangles, and where they stand.

use glam::{Affine3A, Vec2, Vec3, Vec4};

/// Indexed triangles with per-vertex attributes, in the mesh's own space.
///
/// One glTF primitive is one mesh: it has one material. Counter-clockwise triangles face the viewer (before an
/// instance's transform, which may mirror).
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// For people: the file's name for it.
    pub name: String,
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals, one per vertex, or empty: the triangle's own normal is used.
    pub normals: Vec<Vec3>,
    /// Unit tangents with the bitangent's sign in `w` (bitangent = cross(normal, tangent) · w), or empty.
    pub tangents: Vec<Vec4>,
    /// Texture coordinate sets; each has one entry per vertex. Origin top-left.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear RGBA multiplied onto the base colour, one per vertex, or empty.
    pub colors: Vec<Vec4>,
    /// Three vertex indices per triangle.
    pub indices: Vec<[u32; 3]>,
}

impl Mesh {
    /// Bytes of its vertices and triangles.
    pub fn bytes(&self) -> u64 {
        let uvs: usize = self.uvs.iter().map(|uv| size_of_val(uv.as_slice())).sum();
        let all = size_of_val(self.positions.as_slice())
            + size_of_val(self.normals.as_slice())
            + size_of_val(self.tangents.as_slice())
            + size_of_val(self.colors.as_slice())
            + size_of_val(self.indices.as_slice())
            + uvs;
        all as u64
    }

    /// Checks array lengths, index ranges and that positions and attributes are finite.
    ///
    /// # Errors
    /// A sentence that names the attribute and the first bad entry.
    pub fn validate(&self) -> Result<(), String> {
        let n = self.positions.len();
        let lengths = [
            ("normals", self.normals.len()),
            ("tangents", self.tangents.len()),
            ("colors", self.colors.len()),
        ];
        for (what, len) in lengths {
            if len != 0 && len != n {
                return Err(format!("{len} {what} for {n} positions"));
            }
        }
        for (s, uv) in self.uvs.iter().enumerate() {
            if uv.len() != n {
                return Err(format!("{} texture coordinates in set {s} for {n} positions", uv.len()));
            }
        }
        if let Some(t) = self.indices.iter().position(|t| t.iter().any(|&i| i as usize >= n)) {
            return Err(format!("triangle {t} uses vertices {:?} of {n}", self.indices[t]));
        }
        if let Some(i) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(format!("position {i} is {}", self.positions[i]));
        }
        let finite = self.normals.iter().all(|v| v.is_finite())
            && self.tangents.iter().all(|v| v.is_finite())
            && self.colors.iter().all(|v| v.is_finite())
            && self.uvs.iter().flatten().all(|v| v.is_finite());
        if finite { Ok(()) } else { Err("an attribute is not finite".into()) }
    }
}

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// For people: the node's name.
    pub name: String,
    /// Index into [`crate::Scene::meshes`].
    pub mesh: u32,
    /// Index into [`crate::Scene::materials`]; `None` is glTF's default material.
    pub material: Option<u32>,
    /// Mesh space to world space. May scale unevenly and mirror (negative determinant flips which side is the front's
    /// winding, as glTF demands); may be singular, in which case the instance has no area and is not seen.
    pub transform: Affine3A,
}
