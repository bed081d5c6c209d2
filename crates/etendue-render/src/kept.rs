//! What a world leaves to that of another moment.

use crate::fingerprint::Checksums;
use crate::lights::Lights;
use crate::mesh_data::{KeptMeshes, Origin, same_place};
use crate::sky::Sky;
use crate::texels::Texels;
use crate::world::World;
use etendue_image::{Image, Pixels};
use etendue_scene::{Environment, Scene, TextureRef};
use etendue_trace::Accel;
use rayon::prelude::*;
use std::collections::HashSet;
use std::sync::{Arc, Weak};

/// The parts of a world that was.
#[derive(Default)]
pub(crate) struct Kept {
    images: Vec<(Weak<Image>, u32, Texels)>,
    sky: Option<(Environment, Sky, u32)>,
    pub accel: Option<Accel>,
    pub meshes: KeptMeshes,
    pub lights: Option<Lights>,
    scene: Scene,
    origins: Vec<Origin>,
    sources: Vec<Weak<Image>>,
}

impl Kept {
    pub fn of(world: Option<World>) -> Self {
        let Some(mut w) = world else { return Self::default() };
        let sources: Vec<_> = w.sources.iter().map(|(source, _)| source.clone()).collect();
        let images = w.sources.into_iter().zip(w.images).map(|((source, crc), t)| (source, crc, t)).collect();
        let sky = w.lights.take_sky().map(|sky| (w.scene.environment.clone(), sky, w.sky_crc));
        Self {
            images,
            sky,
            accel: Some(w.accel),
            origins: w.origins.clone(),
            meshes: KeptMeshes::new(w.meshes, w.origins),
            lights: Some(w.lights),
            scene: w.scene,
            sources,
        }
    }

    /// Tells what is known of meshes and images.
    pub fn tell(&self, checksums: &mut Checksums) {
        self.origins.iter().for_each(|o| checksums.meshes.learn(o.mesh(), o.crc));
        self.images.iter().for_each(|(source, crc, _)| checksums.images.learn(source, *crc));
    }

    /// Source, CRC and prepared form of each image. Those that are not `needed` any more are let go as soon as they are
    /// prepared, so that a model's pictures are never in memory twice.
    pub fn images(
        &mut self,
        images: &mut [Arc<Image>],
        needed: &HashSet<usize>,
        checksums: &mut Checksums,
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
        let crcs = checksums.images.of(images, crate::fingerprint::image);
        let nothing = Arc::new(Image { width: 1, height: 1, channels: 1, pixels: Pixels::U8(vec![0]) });
        images
            .par_iter_mut()
            .zip(&mut known)
            .zip(crcs)
            .enumerate()
            .map(|(k, ((i, known), crc))| {
                let (crc, texels) = known.take().unwrap_or_else(|| (crc, Texels::new(i.clone())));
                let source = Arc::downgrade(i);
                if !needed.contains(&k) {
                    *i = nothing.clone();
                }
                ((source, crc), texels)
            })
            .collect()
    }

    /// The sky, and the CRC of its picture.
    pub fn sky(&mut self, environment: &Environment, checksums: &mut Checksums) -> (Sky, u32) {
        match (self.sky.take(), environment) {
            (
                Some((Environment::LatLong { image: a, intensity: i, .. }, sky, crc)),
                Environment::LatLong { image, rotation, intensity },
            ) if Arc::ptr_eq(&a, image) && i == *intensity => (sky.turned(*rotation), crc),
            (_, Environment::LatLong { image, .. }) => (
                Sky::new(environment),
                checksums.images.of(std::slice::from_ref(image), crate::fingerprint::image)[0],
            ),
            (_, Environment::Constant(_)) => (Sky::new(environment), 0),
        }
    }

    /// Per instance of `now`, whether it emits what the instance of that number emitted, from where that did.
    pub fn unchanged(&self, now: &World) -> Vec<bool> {
        let (a, b) = (&self.scene, &now.scene);
        if a.instances.len() != b.instances.len() {
            return vec![false; b.instances.len()];
        }
        let looks = |t: &TextureRef| {
            let (x, y) = (a.textures.get(t.texture as usize), b.textures.get(t.texture as usize));
            x.zip(y).is_some_and(|(x, y)| {
                x.sampler == y.sampler
                    && self.sources[x.image as usize].ptr_eq(&now.sources[y.image as usize].0)
            })
        };
        let surface = |k: Option<u32>| {
            let of = |s: &Scene| k.map(|k| s.materials.get(k as usize).cloned());
            let (x, y) = (of(a), of(b));
            x == y && y.flatten().is_none_or(|m| m.textures().all(looks))
        };
        let mut known = vec![None; b.materials.len()];
        let mut surface_of = |k: Option<u32>| match k {
            Some(k) => *known[k as usize].get_or_insert_with(|| surface(Some(k))),
            None => true,
        };
        a.instances
            .iter()
            .zip(&b.instances)
            .map(|(x, y)| {
                x.material == y.material
                    && same_place(&x.transform, &y.transform)
                    && self.origins[x.mesh as usize].is(&now.origins[y.mesh as usize])
                    && surface_of(y.material)
            })
            .collect()
    }
}
