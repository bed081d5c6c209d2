//! Scenes into one scene.

use crate::import::{ImageFile, Imported};
use crate::info::Info;
use crate::nodes::without_scale;
use crate::warning::{Warning, Warnings};
use etendue_scene::{Camera, Environment, Instance, Light, LightKind, Material, Scene, Variant};
use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3A, Vec3A};
use std::ops::Range;

/// What of a model is shared by all of its places, and what each place has anew.
pub(crate) struct Part {
    first_mesh: u32,
    first_profile: u32,
    materials: Vec<Material>,
    instances: Vec<Instance>,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
    variants: Vec<Variant>,
}

impl Part {
    /// Names of its sets of materials.
    pub fn variants(&self) -> impl Iterator<Item = &str> + Clone {
        self.variants.iter().map(|v| v.name.as_str())
    }

    pub fn instances(&self) -> usize {
        self.instances.len()
    }
}

/// The scene that models are put into.
#[derive(Default)]
pub(crate) struct Union {
    pub scene: Scene,
    pub info: Info,
    pub image_files: Vec<Option<ImageFile>>,
    pub warnings: Warnings,
}

impl Union {
    /// Adds what a model's places share: meshes, textures, images. `label` stands for the model in warnings.
    pub fn add(&mut self, mut model: Imported, label: &str) -> Part {
        let (first_mesh, first_texture, first_image) = (
            self.scene.meshes.len() as u32,
            self.scene.textures.len() as u32,
            self.scene.images.len() as u32,
        );
        let s = &mut model.scene;
        self.scene.meshes.append(&mut s.meshes);
        s.textures.iter_mut().for_each(|t| t.image += first_image);
        self.scene.textures.append(&mut s.textures);
        self.scene.images.append(&mut s.images);
        self.image_files.append(&mut model.image_files);
        for m in &mut s.materials {
            m.textures_mut().for_each(|t| t.texture += first_texture);
        }
        for w in model.warnings {
            let pointer =
                if w.pointer.is_empty() { label.to_owned() } else { format!("{label}: {}", w.pointer) };
            self.warnings.join(Warning { pointer, ..w });
        }
        join(&mut self.info, model.info, label);
        let s = model.scene;
        let first_profile = self.scene.profiles.len() as u32;
        self.scene.profiles.extend(s.profiles);
        // One sky shines on all: that of the first model that brings one.
        if let (Environment::LatLong { .. }, Environment::Constant(_)) =
            (&s.environment, &self.scene.environment)
        {
            self.scene.environment = s.environment;
        }
        Part {
            first_mesh,
            first_profile,
            materials: s.materials,
            instances: s.instances,
            lights: s.lights,
            cameras: s.cameras,
            variants: s.variants,
        }
    }

    /// Adds a place of a model, in the materials of its set `variant` if one is named; returns the numbers of its materials.
    /// Variants that several models have are one. With `spell_out`, what has no material gets glTF's default as one of its own.
    pub fn place(
        &mut self,
        part: &Part,
        at: &Affine3A,
        variant: Option<&str>,
        label: &str,
        spell_out: bool,
    ) -> Range<usize> {
        let materials = self.scene.materials.len();
        let instances = self.scene.instances.len() as u32;
        let first = materials as u32;
        self.scene.materials.extend_from_slice(&part.materials);
        let start = self.scene.instances.len();
        self.scene.instances.extend(part.instances.iter().map(|i| Instance {
            mesh: i.mesh + part.first_mesh,
            material: i.material.map(|m| m + first),
            transform: *at * i.transform,
            ..i.clone()
        }));
        for v in &part.variants {
            let moved = v.materials.iter().map(|&[i, m]| [i + instances, m + first]);
            if Some(v.name.as_str()) == variant {
                for [i, m] in moved.clone() {
                    self.scene.instances[i as usize].material = Some(m);
                }
            }
            match self.scene.variants.iter_mut().find(|known| known.name == v.name) {
                Some(known) => known.materials.extend(moved),
                None => {
                    let materials = moved.collect();
                    self.scene.variants.push(Variant { name: v.name.clone(), materials });
                }
            }
        }
        let mut placed = self.scene.instances[start..].iter_mut().filter(|i| i.material.is_none()).peekable();
        if spell_out && placed.peek().is_some() {
            placed.for_each(|i| i.material = Some(self.scene.materials.len() as u32));
            self.scene.materials.push(Material::default());
        }
        for l in &part.lights {
            match light(l, at, part.first_profile) {
                Some(l) => self.scene.lights.push(l),
                None => {
                    self.warnings.add(label, format!("the light {:?} is left out: its model is flat", l.name))
                }
            }
        }
        for c in &part.cameras {
            match camera(c, at) {
                Some(c) => self.scene.cameras.push(c),
                None => self
                    .warnings
                    .add(label, format!("the camera {:?} is left out: its model is flat", c.name)),
            }
        }
        materials..self.scene.materials.len()
    }
}

/// A light of a model that stands at `at`. As in glTF, scale moves a light and does not change how bright it is.
fn light(l: &Light, at: &Affine3A, first_profile: u32) -> Option<Light> {
    let direction = at.matrix3.as_dmat3() * l.direction.as_dvec3();
    let direction = match l.kind {
        LightKind::Point => l.direction,
        _ => (direction / direction.abs().max_element()).try_normalize()?.as_vec3(),
    };
    let kind = match l.kind {
        LightKind::Profile { profile, side } => {
            let side =
                (at.matrix3 * Vec3A::from(side)).as_dvec3().reject_from_normalized(direction.as_dvec3());
            let side = (side / side.abs().max_element()).try_normalize()?.as_vec3();
            LightKind::Profile { profile: profile + first_profile, side }
        }
        other => other,
    };
    let moved = Light { position: at.transform_point3(l.position), direction, kind, ..l.clone() };
    moved.is_finite().then_some(moved)
}

/// A camera of a model that stands at `at`, without the model's scale.
fn camera(c: &Camera, at: &Affine3A) -> Option<Camera> {
    let m = *at * c.transform;
    let wide = DAffine3 {
        matrix3: DMat3::from_cols(
            m.matrix3.x_axis.as_dvec3(),
            m.matrix3.y_axis.as_dvec3(),
            m.matrix3.z_axis.as_dvec3(),
        ),
        translation: DVec3::ZERO,
    };
    let r = without_scale(&wide)?;
    let transform = Affine3A {
        matrix3: Mat3A::from_cols(r.x_axis.as_vec3a(), r.y_axis.as_vec3a(), r.z_axis.as_vec3a()),
        translation: m.translation,
    };
    transform.is_finite().then(|| Camera { transform, ..c.clone() })
}

/// Adds what is known of a model.
fn join(all: &mut Info, mut one: Info, label: &str) {
    let (materials, textures) = (all.materials.len() as u32, all.counts.textures as u32);
    for p in one.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        p.material = p.material.map(|m| m.saturating_add(materials));
    }
    for (_, t) in one.materials.iter_mut().flat_map(|m| &mut m.textures) {
        *t = t.saturating_add(textures);
    }
    for e in one.extensions {
        match all.extensions.iter_mut().find(|known| known.name == e.name) {
            Some(known) => known.required |= e.required,
            None => all.extensions.push(e),
        }
    }
    for v in one.variants {
        if !all.variants.contains(&v) {
            all.variants.push(v);
        }
    }
    all.external_bytes += one.bytes + one.external_bytes;
    all.meshes.append(&mut one.meshes);
    all.materials.append(&mut one.materials);
    all.images.append(&mut one.images);
    all.cameras.append(&mut one.cameras);
    all.lights.append(&mut one.lights);
    all.animations.append(&mut one.animations);
    for (from, to) in [(one.unusual, &mut all.unusual), (one.breaches, &mut all.breaches)] {
        to.extend(from.into_iter().map(|w| {
            let pointer =
                if w.pointer.is_empty() { label.to_owned() } else { format!("{label}: {}", w.pointer) };
            Warning { pointer, ..w }
        }));
    }
    let (a, b) = (&mut all.sizes, &one.sizes);
    a.json += b.json;
    a.geometry += b.geometry;
    a.images += b.images;
    a.animation += b.animation;
    a.other += b.other;
    a.unused += b.unused;
    let (a, b) = (&mut all.counts, &one.counts);
    a.scenes += b.scenes;
    a.nodes += b.nodes;
    a.visible_nodes += b.visible_nodes;
    a.meshes += b.meshes;
    a.primitives += b.primitives;
    a.triangles = a.triangles.saturating_add(b.triangles);
    a.vertices = a.vertices.saturating_add(b.vertices);
    a.materials += b.materials;
    a.textures += b.textures;
    a.images += b.images;
    a.skins += b.skins;
    a.image_bytes += b.image_bytes;
}
