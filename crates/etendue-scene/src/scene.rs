//! The scene: every part in one place, and the check that they fit together.

use crate::{
    AimedProfile, Camera, Environment, Instance, Light, LightKind, LightProfile, Material, Mesh, Texture,
};
use etendue_image::Image;
use glam::Vec3A;
use std::sync::Arc;

/// All that a renderer needs to know of the world.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Geometry in its own space; see [`Mesh`]. Scenes of two moments that share a mesh (the same [`Arc`]) say by that that it is
    /// the same.
    pub meshes: Vec<Arc<Mesh>>,
    /// Where meshes stand in the world, and of what they are made.
    pub instances: Vec<Instance>,
    /// Surfaces. An instance without one gets [`Material::default`].
    pub materials: Vec<Material>,
    /// Images with the way they are sampled.
    pub textures: Vec<Texture>,
    /// Decoded pictures, shared.
    pub images: Vec<Arc<Image>>,
    /// Point, spot, directional and measured lights.
    pub lights: Vec<Light>,
    /// How measured lamps shine, shared.
    pub profiles: Vec<Arc<LightProfile>>,
    /// Cameras that the file brought along; may be empty.
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away.
    pub environment: Environment,
    /// Other sets of materials that the file brought along (`KHR_materials_variants`); see [`Scene::select_variant`].
    pub variants: Vec<Variant>,
}

/// A named choice of materials.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// The file's name for it.
    pub name: String,
    /// Pairs of an instance and the material that it has in this variant; other instances keep theirs.
    pub materials: Vec<[u32; 2]>,
}

/// An axis-aligned box; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3A,
    /// Largest corner.
    pub max: Vec3A,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// Grows the box to hold `p`.
    #[inline]
    pub fn include(&mut self, p: Vec3A) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// The smallest box that holds both.
    #[inline]
    pub fn union(self, o: Self) -> Self {
        Self { min: self.min.min(o.min), max: self.max.max(o.max) }
    }

    /// True if the box holds nothing.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Middle of the box.
    pub fn center(&self) -> Vec3A {
        (self.min + self.max) * 0.5
    }

    /// Length of the box's diagonal; 0 if empty.
    pub fn diagonal(&self) -> f32 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() }
    }
}

/// Why a scene does not hold together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidScene(pub String);

impl std::fmt::Display for InvalidScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}
impl std::error::Error for InvalidScene {}

impl Scene {
    /// Gives the instances the materials of the variant `name`.
    ///
    /// # Errors
    /// A sentence with the names that there are, if there is no such variant.
    pub fn select_variant(&mut self, name: &str) -> Result<(), String> {
        let Some(variant) = self.variants.iter().find(|v| v.name == name) else {
            let names: Vec<_> = self.variants.iter().map(|v| format!("{:?}", v.name)).collect();
            return Err(if names.is_empty() {
                format!("there is no variant {name:?}: the model has no variants")
            } else {
                format!("there is no variant {name:?}; there are {}", names.join(", "))
            });
        };
        for &[instance, material] in &variant.materials {
            if let Some(i) = self.instances.get_mut(instance as usize) {
                i.material = Some(material);
            }
        }
        Ok(())
    }

    /// How a measured lamp shines where it hangs; `None` for lights of other kinds.
    pub fn aimed_profile(&self, light: &Light) -> Option<AimedProfile> {
        let LightKind::Profile { profile, side } = light.kind else { return None };
        let profile = self.profiles.get(profile as usize)?;
        Some(AimedProfile::new(profile.clone(), light.direction, side))
    }

    /// Number of triangles as rendered: each instance counts its mesh's.
    pub fn triangle_count(&self) -> u64 {
        self.instances.iter().map(|i| self.meshes[i.mesh as usize].indices.len() as u64).sum()
    }

    /// World-space box around all instances.
    pub fn bounds(&self) -> Bounds {
        let mut b = Bounds::EMPTY;
        for i in &self.instances {
            for p in &self.meshes[i.mesh as usize].positions {
                b.include(i.transform.transform_point3a((*p).into()));
            }
        }
        b
    }

    /// Checks that every index is in range, every array has its mesh's length, and every number that reaches the
    /// light transport is finite.
    ///
    /// # Errors
    /// The first fault found, with the part and its number.
    pub fn validate(&self) -> Result<(), InvalidScene> {
        self.validate_but(|_| false)
    }

    /// As [`Scene::validate`], without looking into meshes that are `known` to be sound.
    ///
    /// # Errors
    /// As [`Scene::validate`].
    pub fn validate_but(&self, known: impl Fn(&Arc<Mesh>) -> bool) -> Result<(), InvalidScene> {
        let err = |s: String| Err(InvalidScene(s));
        for (n, m) in self.meshes.iter().enumerate().filter(|(_, m)| !known(m)) {
            if let Err(e) = m.validate() {
                return err(format!("mesh {n} ({}): {e}", m.name));
            }
        }
        for (n, i) in self.instances.iter().enumerate() {
            if i.mesh as usize >= self.meshes.len() {
                return err(format!("instance {n} ({}): mesh {} does not exist", i.name, i.mesh));
            }
            if i.material.is_some_and(|m| m as usize >= self.materials.len()) {
                return err(format!("instance {n} ({}): material {:?} does not exist", i.name, i.material));
            }
            if !i.transform.is_finite() {
                return err(format!("instance {n} ({}): transform is not finite", i.name));
            }
        }
        for (n, v) in self.variants.iter().enumerate() {
            for &[i, m] in &v.materials {
                if i as usize >= self.instances.len() || m as usize >= self.materials.len() {
                    return err(format!(
                        "variant {n} ({}): instance {i} or material {m} does not exist",
                        v.name
                    ));
                }
            }
        }
        for (n, t) in self.textures.iter().enumerate() {
            if t.image as usize >= self.images.len() {
                return err(format!("texture {n}: image {} does not exist", t.image));
            }
        }
        for (n, m) in self.materials.iter().enumerate() {
            for t in m.textures() {
                if t.texture as usize >= self.textures.len() {
                    return err(format!("material {n} ({}): texture {} does not exist", m.name, t.texture));
                }
            }
            if !m.is_finite() {
                return err(format!("material {n} ({}): a factor is not finite", m.name));
            }
        }
        for (n, i) in self.images.iter().enumerate() {
            let stored = match &i.pixels {
                etendue_image::Pixels::U8(p) => p.len(),
                etendue_image::Pixels::U16(p) => p.len(),
                etendue_image::Pixels::F32(p) => p.len(),
            };
            if i.width == 0 || i.height == 0 || !(1..=4).contains(&i.channels) || stored != i.len() {
                return err(format!(
                    "image {n}: {}×{}×{} with {stored} samples",
                    i.width, i.height, i.channels
                ));
            }
        }
        for (n, l) in self.lights.iter().enumerate() {
            if !l.is_finite() {
                return err(format!("light {n} ({}): a value is not finite", l.name));
            }
            if let LightKind::Profile { profile, .. } = l.kind
                && profile as usize >= self.profiles.len()
            {
                return err(format!("light {n} ({}): profile {profile} does not exist", l.name));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;

    #[test]
    fn a_variant_changes_its_own_instances_only() {
        let instance =
            |material| Instance { name: String::new(), mesh: 0, material, transform: Affine3A::IDENTITY };
        let mut scene = Scene {
            meshes: vec![Arc::default()],
            instances: vec![instance(Some(0)), instance(None)],
            materials: vec![Material::default(); 2],
            variants: vec![Variant { name: "red".into(), materials: vec![[0, 1]] }],
            ..Scene::default()
        };
        assert!(scene.validate().is_ok());
        assert!(scene.select_variant("blue").expect_err("unknown").contains("\"red\""));
        assert!(scene.select_variant("red").is_ok());
        assert_eq!((scene.instances[0].material, scene.instances[1].material), (Some(1), None));
        scene.variants[0].materials.push([2, 0]);
        assert!(scene.validate().is_err());
    }
}
