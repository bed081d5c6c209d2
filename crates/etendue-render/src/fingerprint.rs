//! A short name for "exactly this picture", so that films of different pictures are not added.

use crate::Settings;
use crate::{Moment, Shutter};
use crc32fast::Hasher;
use etendue_image::{Image, Pixels};
use etendue_scene::{Camera, Environment, Material, Mesh, Scene};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// Raised when a change makes the same scene and settings give other samples.
const SAMPLES_VERSION: u32 = 2;

/// CRC-32 of all that the light of a scene with these `materials` depends on. `meshes` and `images` are the CRCs of its meshes and
/// images, `sky` that of its sky's picture.
pub(crate) fn scene(scene: &Scene, materials: &[Material], meshes: &[u32], images: &[u32], sky: u32) -> u32 {
    let mut h = Hasher::new();
    for crc in meshes.iter().chain(images) {
        h.update(&crc.to_le_bytes());
    }
    for i in &scene.instances {
        floats(&mut h, i.transform.to_cols_array());
        h.update(format!("{:?}", (&i.name, i.mesh, i.material)).as_bytes());
    }
    h.update(format!("{:?}", (materials, &scene.textures, &scene.lights)).as_bytes());
    if !scene.profiles.is_empty() {
        h.update(format!("{:?}", scene.profiles).as_bytes());
    }
    match &scene.environment {
        Environment::Constant(c) => floats(&mut h, c.to_array()),
        Environment::LatLong { rotation, intensity, .. } => {
            h.update(&sky.to_le_bytes());
            floats(&mut h, [*rotation, *intensity]);
        }
    }
    h.finalize()
}

/// The name of the picture of a scene by a camera with settings: sixteen hexadecimal digits.
pub(crate) fn picture(scene: u32, camera: &Camera, settings: &Settings) -> String {
    let mut h = Hasher::new();
    h.update(&SAMPLES_VERSION.to_le_bytes());
    floats(&mut h, camera.transform.to_cols_array());
    h.update(format!("{:?} {settings:?}", camera.projection).as_bytes());
    format!("{scene:08x}{:08x}", h.finalize())
}

/// The name of the picture that [`crate::Renderer`] makes of `scene`, without making it ready for that.
pub fn picture_id(scene: &Scene, camera: &Camera, settings: &Settings) -> String {
    Checksums::default().picture_id(scene, camera, settings)
}

/// CRCs of meshes and images that have been seen, so that each is read once, however many scenes share it.
#[derive(Debug, Default)]
pub(crate) struct Checksums {
    pub meshes: Known<Mesh>,
    pub images: Known<Image>,
}

impl Checksums {
    /// See [`picture_id`].
    pub fn picture_id(&mut self, of: &Scene, camera: &Camera, settings: &Settings) -> String {
        let meshes = self.meshes.of(&of.meshes, mesh);
        let images = self.images.of(&of.images, image);
        let sky = match &of.environment {
            Environment::LatLong { image: i, .. } => self.images.of(std::slice::from_ref(i), image)[0],
            Environment::Constant(_) => 0,
        };
        picture(scene(of, &of.materials, &meshes, &images, sky), camera, settings)
    }

    /// The name of the picture of what moves as `digest` says, from the first to the last of the `ends`.
    pub fn moving_id(
        &mut self,
        ends: &[Moment; 2],
        shutter: &Shutter,
        settings: &Settings,
        digest: u32,
    ) -> String {
        let mut h = Hasher::new();
        ends.iter().for_each(|m| h.update(self.picture_id(&m.scene, &m.camera, settings).as_bytes()));
        h.update(&digest.to_le_bytes());
        let scene = h.clone().finalize();
        h.update(b"shutter");
        h.update(&shutter.open.to_le_bytes());
        h.update(&shutter.close.to_le_bytes());
        h.update(&shutter.block().to_le_bytes());
        format!("{scene:08x}{:08x}", h.finalize())
    }
}

/// CRCs by what they are of. An entry's weak reference keeps its address from being given to something else.
#[derive(Debug)]
pub(crate) struct Known<T>(HashMap<usize, (Weak<T>, u32)>);

impl<T> Default for Known<T> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<T: Send + Sync> Known<T> {
    pub fn learn(&mut self, thing: &Weak<T>, crc: u32) {
        if thing.strong_count() > 0 {
            self.0.insert(thing.as_ptr().addr(), (thing.clone(), crc));
        }
    }

    /// The CRCs of `things`, by `crc` where they are not known.
    pub fn of(&mut self, things: &[Arc<T>], crc: impl Fn(&T) -> u32 + Sync) -> Vec<u32> {
        if self.0.len() > 2 * things.len() + 64 {
            self.0.retain(|_, (thing, _)| thing.strong_count() > 0);
        }
        let known = &self.0;
        let all: Vec<u32> = things
            .par_iter()
            .map(|t| known.get(&Arc::as_ptr(t).addr()).map_or_else(|| crc(t), |(_, crc)| *crc))
            .collect();
        for (t, crc) in things.iter().zip(&all) {
            self.0.entry(Arc::as_ptr(t).addr()).or_insert_with(|| (Arc::downgrade(t), *crc));
        }
        all
    }
}

fn floats(h: &mut Hasher, values: impl IntoIterator<Item = f32>) {
    let mut block = [0u8; 4096];
    let mut at = 0;
    for v in values {
        block[at..at + 4].copy_from_slice(&v.to_le_bytes());
        at += 4;
        if at == block.len() {
            h.update(&block);
            at = 0;
        }
    }
    h.update(&block[..at]);
}

/// CRC-32 of all of a mesh but its name.
pub(crate) fn mesh(m: &Mesh) -> u32 {
    let mut h = Hasher::new();
    floats(&mut h, m.positions.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.normals.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.tangents.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.uvs.iter().flatten().flat_map(|v| v.to_array()));
    floats(&mut h, m.colors.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.indices.iter().flatten().map(|i| f32::from_bits(*i)));
    h.finalize()
}

/// CRC-32 of a picture's size and samples.
pub(crate) fn image(i: &Image) -> u32 {
    let mut h = Hasher::new();
    h.update(format!("{} {} {}", i.width, i.height, i.channels).as_bytes());
    match &i.pixels {
        Pixels::U8(p) => h.update(p),
        Pixels::U16(p) => floats(&mut h, p.iter().map(|v| f32::from(*v))),
        Pixels::F32(p) => floats(&mut h, p.iter().copied()),
    }
    h.finalize()
}
