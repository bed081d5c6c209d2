//! One glTF primitive, at one moment, becomes one mesh.

use crate::accessor::{Accessors, Elements};
use crate::clean;
use crate::document::{Component, Mode, Shape, Target};
use crate::error::Fault;
use crate::skin::Influences;
use crate::strokes;
use crate::tangents;
use crate::topology;
use crate::warning::Warnings;
use etendue_scene::Mesh;
use glam::{Affine2, Affine3A, Mat2, Vec2, Vec3, Vec4};

/// What determines a mesh: primitives and moments with equal keys share one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MeshKey {
    pub mode: Mode,
    pub indices: Option<u32>,
    pub position: u32,
    pub normal: Option<u32>,
    pub tangent: Option<u32>,
    pub color: Option<u32>,
    /// Accessors of the UV sets that the material uses, by number of the set.
    pub uvs: Vec<Option<u32>>,
    /// Along what tangents run, if the material needs some and the file has none.
    pub tangent_space: Option<TangentSpace>,
    /// Morph targets that have a weight, and the weight's bits.
    pub morph: Vec<(Target, u32)>,
    pub skin: Option<SkinKey>,
}

/// The texture coordinates along which tangents run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TangentSpace {
    pub uv_set: u32,
    /// Bits of the texture transform: a rotated map has rotated tangents.
    transform: [u32; 6],
}

impl TangentSpace {
    pub fn new(uv_set: u32, transform: &Affine2) -> Self {
        Self { uv_set, transform: transform.to_cols_array().map(f32::to_bits) }
    }

    pub fn transform(&self) -> Affine2 {
        let m = self.transform.map(f32::from_bits);
        Affine2 {
            matrix2: Mat2::from_cols(Vec2::new(m[0], m[1]), Vec2::new(m[2], m[3])),
            translation: Vec2::new(m[4], m[5]),
        }
    }
}

/// A skin and the accessors that tie vertices to it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SkinKey {
    pub skin: u32,
    /// `JOINTS_n` and `WEIGHTS_n`.
    pub influences: Vec<(u32, u32)>,
}

/// A mesh to be built.
pub(crate) struct Job {
    pub key: MeshKey,
    pub name: String,
    /// JSON pointer to the primitive.
    pub pointer: String,
}

/// How much a job will take, found without decoding anything.
pub(crate) struct Estimate {
    pub vertices: u64,
    pub bytes: u64,
}

const VEC3: &[Shape] = &[Shape::Vec3];

impl Job {
    fn attribute(&self, name: &str) -> String {
        format!("{}/attributes/{name}", self.pointer)
    }

    fn positions<'a>(&self, accessors: Accessors<'a>) -> Result<Elements<'a>, Fault> {
        accessors.open(self.key.position, "POSITION", VEC3, || self.attribute("POSITION"))
    }

    fn indices<'a>(&self, accessors: Accessors<'a>) -> Result<Option<Elements<'a>>, Fault> {
        let from = || format!("{}/indices", self.pointer);
        self.key.indices.map(|i| accessors.open(i, "an index", &[Shape::Scalar], from)).transpose()
    }

    /// An upper bound on the size of the mesh.
    pub fn estimate(&self, accessors: Accessors<'_>) -> Result<Estimate, Fault> {
        let points = self.positions(accessors)?.len() as u64;
        let corners = self.indices(accessors)?.map_or(points, |i| i.len() as u64);
        let (vertices, triangles) = match self.key.mode {
            Mode::Triangles => (points.min(corners), corners / 3),
            Mode::Strip | Mode::Fan => (points.min(corners), corners.saturating_sub(2)),
            // A stroke for each corner at the most.
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                (corners.saturating_mul(strokes::VERTICES), corners.saturating_mul(strokes::TRIANGLES))
            }
        };
        // Generated tangents may give every corner a vertex of its own, and MikkTSpace's own tables take about 300 bytes
        // per triangle.
        let (unwelded, tables) =
            if self.key.tangent_space.is_some() { (3 * triangles, 300 * triangles) } else { (vertices, 0) };
        let per_vertex = 12
            + if self.key.normal.is_some() || self.key.tangent_space.is_some() { 12 } else { 0 }
            + if self.key.tangent.is_some() || self.key.tangent_space.is_some() { 16 } else { 0 }
            + if self.key.color.is_some() { 16 } else { 0 }
            + 8 * self.key.uvs.len() as u64
            + self.key.skin.as_ref().map_or(0, |s| 32 * s.influences.len() as u64);
        Ok(Estimate {
            vertices,
            bytes: unwelded
                .saturating_mul(per_vertex)
                .saturating_add(triangles.saturating_mul(12))
                .saturating_add(tables),
        })
    }

    /// The triangles of the primitive, over its vertices as the file numbers them.
    pub fn triangles(
        &self,
        accessors: Accessors<'_>,
        warnings: &mut Warnings,
    ) -> Result<Vec<[u32; 3]>, Fault> {
        topology::triangles(self, &self.positions(accessors)?, self.indices(accessors)?, warnings)
    }

    /// Decodes, deforms and cleans the mesh. `joints` are the matrices of the key's skin.
    pub fn build(
        &self,
        accessors: Accessors<'_>,
        joints: Option<&[Affine3A]>,
        warnings: &mut Warnings,
    ) -> Result<Mesh, Fault> {
        let positions = self.positions(accessors)?;
        let mut triangles = self.triangles(accessors, warnings)?;
        let pick = topology::compact(&mut triangles, positions.len());
        let pick = pick.as_deref();
        let vertices = Vertices { job: self, accessors, count: positions.len(), pick };

        let mut mesh = Mesh { name: self.name.clone(), indices: triangles, ..Mesh::default() };
        mesh.positions = vec3s(positions.floats(pick));
        if let Some(a) = self.key.normal {
            mesh.normals = vertices
                .read(a, "NORMAL", VEC3, warnings)?
                .map(|e| vec3s(e.floats(pick)))
                .unwrap_or_default();
        }
        // Tangents without normals mean nothing (glTF 2.0, 3.7.2.1).
        if let Some(a) = self.key.tangent.filter(|_| !mesh.normals.is_empty()) {
            mesh.tangents = vertices
                .read(a, "TANGENT", &[Shape::Vec4], warnings)?
                .map(|e| e.floats(pick).into_iter().map(Vec4::from_array).collect())
                .unwrap_or_default();
        }
        mesh.uvs = self.uvs(&vertices, warnings)?;
        mesh.colors = self.colors(&vertices, warnings)?;
        self.morph(&vertices, &mut mesh, warnings)?;
        if let (Some(key), Some(joints)) = (&self.key.skin, joints) {
            self.skin(key, joints, &vertices, &mut mesh, warnings)?;
        }
        if self.key.mode.is_stroke() {
            strokes::thicken(&mut mesh);
        }
        clean::mesh(&mut mesh, &self.pointer, warnings);
        if let Some(space) = self.key.tangent_space.filter(|_| mesh.tangents.is_empty()) {
            if (space.uv_set as usize) < mesh.uvs.len() {
                tangents::generate(&mut mesh, space.uv_set as usize, &space.transform());
            } else {
                warnings.add(
                    &self.pointer,
                    "its material needs tangents (for a normal texture or anisotropy), but there are no tangents and no texture coordinates to make them from; shown without",
                );
            }
        }
        Ok(mesh)
    }

    fn uvs(&self, vertices: &Vertices<'_>, warnings: &mut Warnings) -> Result<Vec<Vec<Vec2>>, Fault> {
        let mut out = Vec::with_capacity(self.key.uvs.len());
        for (set, accessor) in self.key.uvs.iter().enumerate() {
            let read = match accessor {
                Some(a) => vertices.read(*a, &format!("TEXCOORD_{set}"), &[Shape::Vec2], warnings)?,
                // Another set is used; this one holds its place.
                None => None,
            };
            out.push(match read {
                Some(e) => e.floats(vertices.pick).into_iter().map(Vec2::from_array).collect(),
                None => vec![Vec2::ZERO; vertices.len()],
            });
        }
        Ok(out)
    }

    fn colors(&self, vertices: &Vertices<'_>, warnings: &mut Warnings) -> Result<Vec<Vec4>, Fault> {
        let Some(a) = self.key.color else { return Ok(Vec::new()) };
        let Some(e) = vertices.read(a, "COLOR_0", &[Shape::Vec3, Shape::Vec4], warnings)? else {
            return Ok(Vec::new());
        };
        if e.component() != Component::F32 && !e.normalized() {
            warnings
                .add(e.pointer(), "integer colours that are not marked as normalised; taken as normalised");
        }
        Ok(if e.shape() == Shape::Vec3 {
            e.unit_floats(vertices.pick).into_iter().map(|[r, g, b]| Vec4::new(r, g, b, 1.0)).collect()
        } else {
            e.unit_floats(vertices.pick).into_iter().map(Vec4::from_array).collect()
        })
    }

    /// Adds every target's displacements, times its weight.
    fn morph(&self, vertices: &Vertices<'_>, mesh: &mut Mesh, warnings: &mut Warnings) -> Result<(), Fault> {
        for (n, (target, weight)) in self.key.morph.iter().enumerate() {
            let weight = f32::from_bits(*weight);
            let mut displacements = |accessor: Option<u32>, name: &str| -> Result<Vec<[f32; 3]>, Fault> {
                let Some(a) = accessor else { return Ok(Vec::new()) };
                let what = format!("{name} of morph target {n}");
                Ok(vertices
                    .read(a, &what, VEC3, warnings)?
                    .map(|e| e.floats(vertices.pick))
                    .unwrap_or_default())
            };
            for (p, d) in mesh.positions.iter_mut().zip(displacements(target.position, "POSITION")?) {
                *p += Vec3::from_array(d) * weight;
            }
            if !mesh.normals.is_empty() {
                for (v, d) in mesh.normals.iter_mut().zip(displacements(target.normal, "NORMAL")?) {
                    *v += Vec3::from_array(d) * weight;
                }
            }
            if !mesh.tangents.is_empty() {
                for (t, d) in mesh.tangents.iter_mut().zip(displacements(target.tangent, "TANGENT")?) {
                    *t += (Vec3::from_array(d) * weight).extend(0.0);
                }
            }
        }
        Ok(())
    }

    fn skin(
        &self,
        key: &SkinKey,
        joints: &[Affine3A],
        vertices: &Vertices<'_>,
        mesh: &mut Mesh,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        let mut influences = Influences { joints: Vec::new(), weights: Vec::new() };
        for (n, &(j, w)) in key.influences.iter().enumerate() {
            let name = format!("JOINTS_{n}");
            let j = vertices.read(j, &name, &[Shape::Vec4], warnings)?;
            let w = vertices.read(w, &format!("WEIGHTS_{n}"), &[Shape::Vec4], warnings)?;
            let (Some(j), Some(w)) = (j, w) else { continue };
            let Some(joints) = j.integers(vertices.pick) else {
                return Err(Fault::invalid(self.attribute(&name), "joints are unsigned integers"));
            };
            influences.joints.push(joints);
            influences.weights.push(w.unit_floats(vertices.pick));
        }
        if influences.joints.is_empty() || joints.is_empty() {
            return Ok(());
        }
        influences.normalise(joints.len(), || self.attribute("JOINTS_0"), warnings)?;
        let mirrored = influences.deform(joints, &mut mesh.positions, &mut mesh.normals, &mut mesh.tangents);
        if mirrored {
            mesh.indices.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(())
    }
}

/// Reads attributes of a primitive's vertices.
struct Vertices<'a> {
    job: &'a Job,
    accessors: Accessors<'a>,
    /// Vertices in the file.
    count: usize,
    /// Those of them that triangles use; `None` is all.
    pick: Option<&'a [u32]>,
}

impl<'a> Vertices<'a> {
    fn len(&self) -> usize {
        self.pick.map_or(self.count, <[u32]>::len)
    }

    /// Opens an attribute. One that has not as many entries as there are positions is left out with a warning.
    fn read(
        &self,
        accessor: u32,
        name: &str,
        shapes: &[Shape],
        warnings: &mut Warnings,
    ) -> Result<Option<Elements<'a>>, Fault> {
        let e = self.accessors.open(accessor, name, shapes, || self.job.attribute(name))?;
        if e.len() != self.count {
            warnings.add(
                self.job.attribute(name),
                format!("{name} has {} entries for {} positions; ignored", e.len(), self.count),
            );
            return Ok(None);
        }
        Ok(Some(e))
    }
}

fn vec3s(v: Vec<[f32; 3]>) -> Vec<Vec3> {
    v.into_iter().map(Vec3::from_array).collect()
}
