//! A short name for "exactly this picture", so that films of different pictures are not added.

use crate::Settings;
use crc32fast::Hasher;
use etendue_image::{Image, Pixels};
use etendue_scene::{Camera, Environment, Mesh, Scene};
use rayon::prelude::*;

/// Raised when a change makes the same scene and settings give other samples.
const SAMPLES_VERSION: u32 = 2;

/// CRC-32 of all that the scene's light depends on.
pub(crate) fn scene(scene: &Scene) -> u32 {
    let mut h = Hasher::new();
    let meshes: Vec<u32> = scene.meshes.par_iter().map(mesh).collect();
    let images: Vec<u32> = scene.images.par_iter().map(|i| image(i)).collect();
    for crc in meshes.iter().chain(&images) {
        h.update(&crc.to_le_bytes());
    }
    for i in &scene.instances {
        floats(&mut h, i.transform.to_cols_array());
        h.update(format!("{:?}", (&i.name, i.mesh, i.material)).as_bytes());
    }
    h.update(format!("{:?}", (&scene.materials, &scene.textures, &scene.lights)).as_bytes());
    match &scene.environment {
        Environment::Constant(c) => floats(&mut h, c.to_array()),
        Environment::LatLong { image: i, rotation, intensity } => {
            h.update(&image(i).to_le_bytes());
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

fn mesh(m: &Mesh) -> u32 {
    let mut h = Hasher::new();
    floats(&mut h, m.positions.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.normals.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.tangents.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.uvs.iter().flatten().flat_map(|v| v.to_array()));
    floats(&mut h, m.colors.iter().flat_map(|v| v.to_array()));
    floats(&mut h, m.indices.iter().flatten().map(|i| f32::from_bits(*i)));
    h.finalize()
}

fn image(i: &Image) -> u32 {
    let mut h = Hasher::new();
    h.update(format!("{} {} {}", i.width, i.height, i.channels).as_bytes());
    match &i.pixels {
        Pixels::U8(p) => h.update(p),
        Pixels::U16(p) => floats(&mut h, p.iter().map(|v| f32::from(*v))),
        Pixels::F32(p) => floats(&mut h, p.iter().copied()),
    }
    h.finalize()
}
