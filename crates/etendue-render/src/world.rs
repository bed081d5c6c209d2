//! The scene made ready for rays: acceleration structure, interleaved vertices, lights.

use crate::body::{Body, Kind};
use crate::lights::Lights;
use crate::lookup::Lookup;
use crate::sampler::{hash, unit};
use crate::sky::Sky;
use crate::texels::Texels;
use etendue_image::{Image, Pixels};
use etendue_scene::{AlphaMode, Environment, InvalidScene, Material, Scene};
use etendue_trace::{Accel, Hit, Ray};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A, Vec4};
use rayon::prelude::*;
use std::collections::HashSet;
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
    pub(crate) fingerprint: u32,
    build_seconds: [f64; 2],
    /// What the images were made of, and its CRC.
    sources: Vec<(Weak<Image>, u32)>,
    sky_crc: u32,
}

impl World {
    /// Builds everything that rendering needs: acceleration structure and light tree.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds.
    pub fn new(scene: Scene) -> Result<Self, InvalidScene> {
        Self::build(scene, None)
    }

    /// The world of `scene`, which is this one's at another moment: images and sky that both share (the same [`Arc`]) are
    /// taken over instead of being prepared again. The result is that of [`World::new`].
    ///
    /// # Errors
    /// What [`Scene::validate`] finds.
    pub fn again(self, scene: Scene) -> Result<Self, InvalidScene> {
        Self::build(scene, Some(self))
    }

    fn build(mut scene: Scene, before: Option<World>) -> Result<Self, InvalidScene> {
        scene.validate()?;
        let start = std::time::Instant::now();
        let mut kept = Kept::of(before);
        let (sky, sky_crc) = kept.sky(&scene.environment);
        let accel = Accel::build(&scene);
        let traced = start.elapsed().as_secs_f64();
        // After the tree, whose building takes more memory than the tree.
        let needed = emitting_images(&scene);
        let (sources, images): (Vec<_>, Vec<_>) = kept.images(&mut scene.images, &needed).into_iter().unzip();
        let crcs: Vec<u32> = sources.iter().map(|(_, crc)| *crc).collect();
        let fingerprint = crate::fingerprint::scene(&scene, &crcs, sky_crc);
        // One material more than the file has: glTF's default.
        let default = scene.materials.len() as u32;
        scene.materials.push(Material::default());
        let mut instances: Vec<InstanceData> = scene
            .instances
            .iter()
            .map(|i| {
                let m = i.transform.matrix3;
                let det = m.determinant();
                // The matrix of cofactors is det · inverse transpose, and exists when the inverse does not.
                let cofactors = Mat3A::from_cols(
                    m.y_axis.cross(m.z_axis),
                    m.z_axis.cross(m.x_axis),
                    m.x_axis.cross(m.y_axis),
                );
                let handedness = if det < 0.0 { -1.0 } else { 1.0 };
                InstanceData {
                    mesh: i.mesh,
                    material: i.material.unwrap_or(default),
                    to_world: i.transform,
                    normal_to_world: cofactors * handedness,
                    handedness,
                    baked: false,
                }
            })
            .collect();
        let mut meshes: Vec<MeshData> = scene.meshes.par_iter_mut().map(MeshData::take).collect();
        bake(&mut meshes, &mut instances);
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
            fingerprint,
            build_seconds: [traced, 0.0],
            sources,
            sky_crc,
        };
        world.lights = Lights::new(&world, sky);
        world.scene.images = Vec::new();
        world.build_seconds[1] = start.elapsed().as_secs_f64() - traced;
        Ok(world)
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

/// What a world leaves to the next.
#[derive(Default)]
struct Kept {
    images: Vec<(Weak<Image>, u32, Texels)>,
    sky: Option<(Environment, Sky, u32)>,
}

impl Kept {
    fn of(world: Option<World>) -> Self {
        let Some(w) = world else { return Self::default() };
        let images = w.sources.into_iter().zip(w.images).map(|((source, crc), t)| (source, crc, t)).collect();
        let sky = w.lights.into_sky().map(|sky| (w.scene.environment, sky, w.sky_crc));
        Self { images, sky }
    }

    /// Source, CRC and prepared form of each image. Those that are not `needed` any more are let go as soon as they are
    /// prepared, so that a model's pictures are never in memory twice.
    fn images(
        &mut self,
        images: &mut [Arc<Image>],
        needed: &HashSet<usize>,
    ) -> Vec<((Weak<Image>, u32), Texels)> {
        let mut known: Vec<Option<(u32, Texels)>> = images
            .iter()
            .map(|i| {
                let same = |k: &(Weak<Image>, u32, Texels)| std::ptr::eq(k.0.as_ptr(), Arc::as_ptr(i));
                let at = self.images.iter().position(same)?;
                let (_, crc, texels) = self.images.swap_remove(at);
                Some((crc, texels))
            })
            .collect();
        self.images.clear();
        let nothing = Arc::new(Image { width: 1, height: 1, channels: 1, pixels: Pixels::U8(vec![0]) });
        images
            .par_iter_mut()
            .zip(&mut known)
            .enumerate()
            .map(|(k, (i, known))| {
                let made = || (crate::fingerprint::image(i), Texels::new(i.clone()));
                let (crc, texels) = known.take().unwrap_or_else(made);
                let source = Arc::downgrade(i);
                if !needed.contains(&k) {
                    *i = nothing.clone();
                }
                ((source, crc), texels)
            })
            .collect()
    }

    /// The sky, and the CRC of its picture.
    fn sky(&mut self, environment: &Environment) -> (Sky, u32) {
        match (self.sky.take(), environment) {
            (
                Some((Environment::LatLong { image: a, rotation: r, intensity: i }, sky, crc)),
                Environment::LatLong { image, rotation, intensity },
            ) if Arc::ptr_eq(&a, image) && (r, i) == (*rotation, *intensity) => (sky, crc),
            (_, Environment::LatLong { image, .. }) => {
                (Sky::new(environment), crate::fingerprint::image(image))
            }
            (_, Environment::Constant(_)) => (Sky::new(environment), 0),
        }
    }
}

/// Moves the vertices of meshes that stand in one place there, so that no hit has to.
fn bake(meshes: &mut [MeshData], instances: &mut [InstanceData]) {
    let mut places = vec![0u32; meshes.len()];
    instances.iter().for_each(|i| places[i.mesh as usize] += 1);
    for i in instances.iter_mut().filter(|i| places[i.mesh as usize] == 1) {
        meshes[i.mesh as usize].vertices.par_iter_mut().for_each(|v| {
            v.position = i.to_world.transform_point3a(v.position.into()).into();
            v.normal = (i.normal_to_world * Vec3A::from(v.normal)).normalize_or_zero().into();
            let t = i.to_world.matrix3 * Vec3A::from_vec4(v.tangent);
            v.tangent = t.normalize_or_zero().extend(v.tangent.w);
        });
        i.to_world = Affine3A::IDENTITY;
        i.normal_to_world = Mat3A::IDENTITY;
        i.baked = true;
    }
}

impl MeshData {
    /// Moves the arrays out of the scene's mesh into the layout that shading reads.
    fn take(mesh: &mut etendue_scene::Mesh) -> Self {
        let mut uvs = std::mem::take(&mut mesh.uvs);
        let first = if uvs.is_empty() { Vec::new() } else { uvs.remove(0) };
        let (has_uv, has_normals, has_tangents) =
            (!first.is_empty(), !mesh.normals.is_empty(), !mesh.tangents.is_empty());
        let vertices = (0..mesh.positions.len())
            .map(|i| Vertex {
                position: mesh.positions[i],
                normal: mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO),
                tangent: mesh.tangents.get(i).copied().unwrap_or(Vec4::ZERO),
                uv: first.get(i).copied().unwrap_or(Vec2::ZERO),
            })
            .collect();
        mesh.positions = Vec::new();
        mesh.normals = Vec::new();
        mesh.tangents = Vec::new();
        Self {
            vertices,
            indices: std::mem::take(&mut mesh.indices),
            more_uvs: uvs,
            colors: std::mem::take(&mut mesh.colors),
            has_uv,
            has_normals,
            has_tangents,
        }
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
