//! Meshes in the layout that shading reads.

use crate::fingerprint::Checksums;
use crate::world::InstanceData;
use etendue_scene::Mesh;
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A, Vec4};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// One vertex, all that shading needs of it in 48 bytes, so that a hit touches few cache lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    pub tangent: Vec4,
    pub uv: Vec2,
}

/// A mesh as shading reads it.
#[derive(Debug)]
pub(crate) struct MeshData {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<[u32; 3]>,
    /// Texture coordinate sets from the second one on.
    pub more_uvs: Vec<Vec<Vec2>>,
    pub colors: Vec<Vec4>,
    pub has_uv: bool,
    pub has_normals: bool,
    pub has_tangents: bool,
}

/// What a [`MeshData`] was made of.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    mesh: Weak<Mesh>,
    /// Its CRC.
    pub crc: u32,
    /// Where it stands, if its vertices are in world space.
    baked: Option<Affine3A>,
}

/// Equal to the bit.
pub(crate) fn same_place(a: &Affine3A, b: &Affine3A) -> bool {
    a.to_cols_array().map(f32::to_bits) == b.to_cols_array().map(f32::to_bits)
}

impl Origin {
    pub fn mesh(&self) -> &Weak<Mesh> {
        &self.mesh
    }

    /// True if both were made of the same mesh.
    pub fn is(&self, o: &Self) -> bool {
        self.mesh.ptr_eq(&o.mesh)
    }
}

/// Meshes of another moment.
#[derive(Default)]
pub(crate) struct KeptMeshes(HashMap<usize, (MeshData, Origin)>);

impl KeptMeshes {
    pub fn new(meshes: Vec<MeshData>, origins: Vec<Origin>) -> Self {
        Self(meshes.into_iter().zip(origins).map(|(m, o)| (o.mesh.as_ptr().addr(), (m, o))).collect())
    }

    /// True if the mesh was there, and has been found to be sound.
    pub fn knows(&self, mesh: &Arc<Mesh>) -> bool {
        self.0.contains_key(&Arc::as_ptr(mesh).addr())
    }

    /// Makes ready the meshes that `instances` show, and moves the vertices of those that stand in one place there, so that no hit
    /// has to. What is as it was is taken over; meshes that nobody else holds are moved instead of copied.
    pub fn prepare(
        mut self,
        meshes: Vec<Arc<Mesh>>,
        instances: &mut [InstanceData],
        checksums: &mut Checksums,
    ) -> (Vec<MeshData>, Vec<Origin>) {
        let mut places = vec![(0u32, 0u32); meshes.len()];
        for (n, i) in instances.iter().enumerate() {
            let (count, at) = &mut places[i.mesh as usize];
            (*count, *at) = (*count + 1, n as u32);
        }
        let crcs = checksums.meshes.of(&meshes, crate::fingerprint::mesh);
        let known: Vec<_> = meshes.iter().map(|m| self.0.remove(&Arc::as_ptr(m).addr())).collect();
        drop(self);
        let seen: &[InstanceData] = instances;
        let all: Vec<_> = meshes
            .into_par_iter()
            .zip(known)
            .zip(&places)
            .zip(crcs)
            .map(|(((mesh, known), &(count, at)), crc)| {
                let baked = (count == 1).then(|| seen[at as usize].to_world);
                if let Some((data, origin)) = known
                    && match (&origin.baked, &baked) {
                        (Some(a), Some(b)) => same_place(a, b),
                        (a, b) => a.is_none() && b.is_none(),
                    }
                {
                    return (data, origin);
                }
                let origin = Origin { mesh: Arc::downgrade(&mesh), crc, baked };
                let mut data = MeshData::new(mesh);
                if baked.is_some() {
                    data.stand_at(&seen[at as usize]);
                }
                (data, origin)
            })
            .collect();
        for (count, at) in places {
            if count == 1 {
                let i = &mut instances[at as usize];
                (i.to_world, i.normal_to_world, i.baked) = (Affine3A::IDENTITY, Mat3A::IDENTITY, true);
            }
        }
        all.into_iter().unzip()
    }
}

impl MeshData {
    /// Moves the arrays out of the mesh if nobody else holds it, else copies them.
    fn new(mesh: Arc<Mesh>) -> Self {
        let (has_uv, has_normals, has_tangents) =
            (!mesh.uvs.is_empty(), !mesh.normals.is_empty(), !mesh.tangents.is_empty());
        let first = mesh.uvs.first().map_or(&[][..], Vec::as_slice);
        let vertices = (0..mesh.positions.len())
            .map(|i| Vertex {
                position: mesh.positions[i],
                normal: mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO),
                tangent: mesh.tangents.get(i).copied().unwrap_or(Vec4::ZERO),
                uv: first.get(i).copied().unwrap_or(Vec2::ZERO),
            })
            .collect();
        let (indices, more_uvs, colors) = match Arc::try_unwrap(mesh) {
            Ok(m) => (m.indices, m.uvs.into_iter().skip(1).collect(), m.colors),
            Err(m) => (m.indices.clone(), m.uvs.iter().skip(1).cloned().collect(), m.colors.clone()),
        };
        Self { vertices, indices, more_uvs, colors, has_uv, has_normals, has_tangents }
    }

    /// Moves the vertices to where the instance stands.
    fn stand_at(&mut self, i: &InstanceData) {
        self.vertices.par_iter_mut().for_each(|v| {
            v.position = i.to_world.transform_point3a(v.position.into()).into();
            v.normal = (i.normal_to_world * Vec3A::from(v.normal)).normalize_or_zero().into();
            let t = i.to_world.matrix3 * Vec3A::from_vec4(v.tangent);
            v.tangent = t.normalize_or_zero().extend(v.tangent.w);
        });
    }

    /// Texture coordinate of set `set` at barycentric `w`; (0, 0) if there is no such set.
    #[inline(always)]
    pub(crate) fn uv(&self, set: u32, corners: [u32; 3], w: [f32; 3]) -> Vec2 {
        let [a, b, c] = if set == 0 {
            corners.map(|k| self.vertices[k as usize].uv)
        } else {
            match self.more_uvs.get(set as usize - 1) {
                Some(uv) => corners.map(|k| uv[k as usize]),
                None => return Vec2::ZERO,
            }
        };
        a * w[0] + b * w[1] + c * w[2]
    }
}
