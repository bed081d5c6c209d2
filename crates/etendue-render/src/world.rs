//! The scene made ready for rays: acceleration structure, interleaved vertices, lights.

use crate::body::{Body, Kind};
use crate::fingerprint::Checksums;
use crate::kept::Kept;
use crate::lights::Lights;
use crate::lookup::Lookup;
use crate::mesh_data::{MeshData, Origin};
use crate::sampler::{hash, unit};
use crate::texels::Texels;
use etendue_image::Image;
use etendue_scene::{AlphaMode, Instance, InvalidScene, Material, Mesh, Scene};
use etendue_trace::{Accel, Hit, Ray};
use glam::{Affine3A, Mat3A, Vec3A};
use std::collections::HashSet;
use std::sync::{Arc, Weak};

/// An instance as shading reads it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceData {
    pub mesh: u32,
    pub material: u32,
    pub to_world: Affine3A,
    /// Inverse transpose of the linear part, up to a positive factor.
    pub normal_to_world: Mat3A,
    /// +1, or −1 if the transform mirrors.
    pub handedness: f32,
    /// The mesh stands nowhere else, and its vertices are in world space already; the transforms here are identities.
    pub baked: bool,
}

impl InstanceData {
    /// As it stands in the scene; without a material it has that of the number `default`.
    fn new(i: &Instance, default: u32) -> Self {
        let m = i.transform.matrix3;
        let det = m.determinant();
        // The matrix of cofactors is det · inverse transpose, and exists when the inverse does not.
        let cofactors =
            Mat3A::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let handedness = if det < 0.0 { -1.0 } else { 1.0 };
        Self {
            mesh: i.mesh,
            material: i.material.unwrap_or(default),
            to_world: i.transform,
            normal_to_world: cofactors * handedness,
            handedness,
            baked: false,
        }
    }
}

/// A scene ready to be rendered.
pub struct World {
    pub(crate) scene: Scene,
    pub(crate) images: Vec<Texels>,
    pub(crate) meshes: Vec<MeshData>,
    pub(crate) instances: Vec<InstanceData>,
    pub(crate) accel: Accel,
    pub(crate) lights: Lights,
    /// Per material.
    pub(crate) bodies: Vec<Body>,
    /// Distance by which rays start off a surface at the origin of the world; grows with the coordinates.
    pub(crate) epsilon: f32,
    build_seconds: [f64; 2],
    /// What the meshes were made of.
    pub(crate) origins: Vec<Origin>,
    /// What the images were made of, and its CRC.
    pub(crate) sources: Vec<(Weak<Image>, u32)>,
    pub(crate) sky_crc: u32,
}

impl World {
    /// Builds everything that rendering needs: acceleration structure and light tree.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds.
    pub fn new(scene: Scene) -> Result<Self, InvalidScene> {
        Self::build(scene, None, &mut Checksums::default())
    }

    /// The world of `scene`, which is this one's at another moment: meshes, images and sky that both share (the same [`Arc`]), and
    /// lights and trees of what did not move, are taken over instead of being prepared again. The result is that of
    /// [`World::new`]: the same pictures, to the bit.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds.
    pub fn again(self, scene: Scene) -> Result<Self, InvalidScene> {
        Self::build(scene, Some(self), &mut Checksums::default())
    }

    pub(crate) fn build(
        mut scene: Scene,
        before: Option<World>,
        checksums: &mut Checksums,
    ) -> Result<Self, InvalidScene> {
        let start = std::time::Instant::now();
        let mut kept = Kept::of(before);
        kept.tell(checksums);
        scene.validate_but(|m| kept.meshes.knows(m))?;
        let (sky, sky_crc) = kept.sky(&scene.environment, checksums);
        let accel = match kept.accel.take() {
            Some(a) => a.again(&scene),
            None => Accel::build(&scene),
        };
        let traced = start.elapsed().as_secs_f64();
        // After the tree, whose building takes more memory than the tree.
        let needed = emitting_images(&scene);
        let (sources, images): (Vec<_>, Vec<_>) =
            kept.images(&mut scene.images, &needed, checksums).into_iter().unzip();
        // One material more than the file has: glTF's default.
        let default = scene.materials.len() as u32;
        scene.materials.push(Material::default());
        let mut instances: Vec<InstanceData> =
            scene.instances.iter().map(|i| InstanceData::new(i, default)).collect();
        let names = |m: &Arc<Mesh>| Arc::new(Mesh { name: m.name.clone(), ..Mesh::default() });
        let names = scene.meshes.iter().map(names).collect();
        let meshes = std::mem::replace(&mut scene.meshes, names);
        let (meshes, origins) = std::mem::take(&mut kept.meshes).prepare(meshes, &mut instances, checksums);
        let bounds = accel.bounds();
        let mut world = Self {
            images,
            meshes,
            instances,
            accel,
            lights: Lights::default(),
            bodies: scene.materials.iter().map(Body::new).collect(),
            epsilon: (bounds.diagonal() * 2e-7).max(1e-12),
            scene,
            build_seconds: [traced, 0.0],
            origins,
            sources,
            sky_crc,
        };
        let lights = kept.lights.take().map(|l| (l, kept.unchanged(&world)));
        world.lights = Lights::new(&world, sky, lights);
        world.scene.images = Vec::new();
        world.build_seconds[1] = start.elapsed().as_secs_f64() - traced;
        Ok(world)
    }

    /// CRC-32 of all that the scene's light depends on.
    pub(crate) fn fingerprint(&self) -> u32 {
        let meshes: Vec<u32> = self.origins.iter().map(|o| o.crc).collect();
        let images: Vec<u32> = self.sources.iter().map(|(_, crc)| *crc).collect();
        // The last material is not the scene's.
        let materials = &self.scene.materials[..self.scene.materials.len() - 1];
        crate::fingerprint::scene(&self.scene, materials, &meshes, &images, self.sky_crc)
    }

    /// The scene that was prepared. Its images and its meshes' arrays were moved into the renderer's own layout and are empty.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The ray engine.
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// Seconds that the acceleration structure took to build.
    pub fn accel_seconds(&self) -> f64 {
        self.build_seconds[0]
    }

    /// Seconds that lights and vertex layout took to prepare.
    pub fn light_seconds(&self) -> f64 {
        self.build_seconds[1]
    }

    /// Number of lights that are drawn from: punctual lights and emissive triangles.
    pub fn light_count(&self) -> usize {
        self.lights.count()
    }

    /// True if a material needs more than glTF's core closure.
    pub(crate) fn is_whole(&self) -> bool {
        self.bodies.iter().any(|b| b.kind != Kind::Plain)
    }

    /// True if the surface is there for this ray: the alpha test. `key` makes the choice for blended surfaces.
    #[inline(always)]
    pub(crate) fn accepts(&self, key: u32, instance: u32, triangle: u32, u: f32, v: f32) -> bool {
        let m = &self.scene.materials[self.instances[instance as usize].material as usize];
        let alpha = self.alpha(instance, triangle, u, v);
        match m.alpha_mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => alpha >= cutoff,
            AlphaMode::Blend => unit(hash(key ^ hash(triangle ^ hash(instance)))) < alpha,
        }
    }

    /// Opacity of a point: factor times vertex colour times texture.
    #[inline(always)]
    pub(crate) fn alpha(&self, instance: u32, triangle: u32, u: f32, v: f32) -> f32 {
        let i = &self.instances[instance as usize];
        let m = &self.scene.materials[i.material as usize];
        let mesh = &self.meshes[i.mesh as usize];
        let corners = mesh.indices[triangle as usize];
        let mut lookup = Lookup::new(corners, [1.0 - u - v, u, v]);
        let alpha = m.alpha * lookup.vertex_color(mesh).w;
        match &m.base_color_texture {
            Some(t) => alpha * lookup.linear(self, mesh, t).w,
            None => alpha,
        }
    }

    /// The nearest surface that the ray meets.
    #[inline(always)]
    pub(crate) fn closest(&self, ray: &Ray, key: u32) -> Option<Hit> {
        self.accel.closest(ray, &|i, t, u, v| self.accepts(key, i, t, u, v))
    }

    /// True if anything lies on the ray.
    #[inline(always)]
    pub(crate) fn occluded(&self, ray: &Ray, key: u32) -> bool {
        self.accel.any(ray, &|i, t, u, v| self.accepts(key, i, t, u, v))
    }

    /// The three corners of a triangle in world space.
    #[inline(always)]
    pub(crate) fn corners(&self, instance: u32, triangle: u32) -> [Vec3A; 3] {
        let i = &self.instances[instance as usize];
        let mesh = &self.meshes[i.mesh as usize];
        let [a, b, c] = mesh.indices[triangle as usize];
        let at = |k: u32| Vec3A::from(mesh.vertices[k as usize].position);
        if i.baked {
            return [at(a), at(b), at(c)];
        }
        [
            i.to_world.transform_point3a(at(a)),
            i.to_world.transform_point3a(at(b)),
            i.to_world.transform_point3a(at(c)),
        ]
    }
}

/// Images of textures that emit: the lights are made from them.
fn emitting_images(scene: &Scene) -> HashSet<usize> {
    let textures = scene.materials.iter().filter_map(|m| m.emissive_texture.as_ref());
    textures.map(|t| scene.textures[t.texture as usize].image as usize).collect()
}
