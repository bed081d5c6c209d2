//! Scenes of formats other than glTF, which have meshes and materials but no hierarchy.

use crate::error::Fault;
use crate::import::{Imported, drop_empty_meshes, image_files};
use crate::info::Info;
use crate::texture::Decoded;
use crate::warning::Warnings;
use crate::{clean, plan, strokes, tangents};
use etendue_scene::{Instance, Material, Mesh, Sampler, Scene, Texture};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// A scene under construction.
#[derive(Default)]
pub(crate) struct Assembly {
    pub meshes: Vec<Mesh>,
    /// Per mesh.
    pub material_of: Vec<Option<u32>>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub images: Vec<Decoded>,
}

/// What is known of the file.
pub(crate) struct Facts<'a> {
    /// Name for messages.
    pub file: &'a str,
    pub format: &'static str,
    pub bytes: u64,
    /// Bytes read from files beside it.
    pub external: u64,
    /// What it says of itself.
    pub comment: Option<String>,
}

/// What stands in for a material that is not there: light grey, neither shiny nor dull, seen from both sides.
pub(crate) fn plain() -> Material {
    Material {
        name: "plain".into(),
        base_color: Vec3::splat(0.8),
        metallic: 0.0,
        roughness: 0.5,
        double_sided: true,
        ..Material::default()
    }
}

impl Assembly {
    /// Adds a mesh; without a material it is plain.
    pub fn add(&mut self, mesh: Mesh, material: Option<u32>) {
        self.meshes.push(mesh);
        self.material_of.push(material);
    }

    /// Adds points and lines: a mesh of triangles `[a, b, b]` and `[a, a, a]`, which are unlit where they have no normals, as glTF has it.
    pub fn add_strokes(&mut self, mut mesh: Mesh, material: Option<u32>) {
        let mut material = match material.and_then(|m| self.materials.get(m as usize)) {
            Some(m) => m.clone(),
            None if mesh.colors.is_empty() => plain(),
            None => Material { base_color: Vec3::ONE, ..plain() },
        };
        material.unlit = mesh.normals.is_empty();
        strokes::thicken(&mut mesh);
        let known = self.materials.iter().position(|m| *m == material);
        let number = known.unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        self.add(mesh, Some(number as u32));
    }

    /// The number of the texture of image `image` with `sampler`.
    pub fn texture(&mut self, image: u32, sampler: Sampler) -> u32 {
        let wanted = Texture { image, sampler };
        let known = self.textures.iter().position(|t| *t == wanted);
        known.unwrap_or_else(|| {
            self.textures.push(wanted);
            self.textures.len() - 1
        }) as u32
    }

    /// The scene: meshes cleaned, with tangents where a material needs them, each standing where it was drawn.
    pub fn finish(
        mut self,
        facts: Facts<'_>,
        keep_files: bool,
        mut warnings: Warnings,
    ) -> Result<Imported, Fault> {
        if self.material_of.iter().any(Option::is_none) {
            let number = self.materials.len() as u32;
            let uncolored = |(m, _): &(&Mesh, _)| m.colors.is_empty();
            let mut material = plain();
            // Colours of vertices are colours of the surface, not a tint of grey.
            if !self.meshes.iter().zip(&self.material_of).filter(|(_, m)| m.is_none()).any(|p| uncolored(&p))
            {
                material.base_color = Vec3::ONE;
            }
            self.materials.push(material);
            self.material_of.iter_mut().for_each(|m| *m = m.or(Some(number)));
        }
        let mut instances = Vec::with_capacity(self.meshes.len());
        for (i, (m, &material)) in self.meshes.iter_mut().zip(&self.material_of).enumerate() {
            let place = if m.name.is_empty() { format!("mesh {i}") } else { m.name.clone() };
            clean::mesh(m, &place, &mut warnings);
            let surface = material.and_then(|k| self.materials.get(k as usize));
            if let Some(space) = surface.and_then(plan::tangent_space) {
                if m.uvs.is_empty() {
                    warnings.add(
                        place,
                        "its material has a normal map, but there are no texture coordinates; shown without",
                    );
                } else {
                    tangents::generate(m, 0, &space.transform());
                }
            }
            instances.push(Instance {
                name: m.name.clone(),
                mesh: i as u32,
                material,
                transform: Affine3A::IDENTITY,
            });
        }
        let mut scene = Scene {
            meshes: self.meshes.into_iter().map(Arc::new).collect(),
            instances,
            materials: self.materials,
            textures: self.textures,
            images: self.images.iter().map(|d| d.image.clone()).collect(),
            ..Scene::default()
        };
        drop_empty_meshes(&mut scene);
        if scene.meshes.is_empty() {
            warnings.add("", "there are no triangles: nothing to see");
        }
        scene.validate().map_err(|e| Fault::invalid("", e.0))?;
        let info = Info::of_scene(&scene, &self.images, facts);
        let image_files = image_files(&self.images, keep_files);
        Ok(Imported { scene, warnings: warnings.into_vec(), info, image_files })
    }
}
