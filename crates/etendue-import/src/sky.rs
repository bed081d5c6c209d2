//! The sky that a glTF file brings along (`EXT_lights_image_based`).

use crate::buffers::Buffers;
use crate::document::{Document, ImageLight, get};
use crate::error::Fault;
use crate::extensions as ext;
use crate::source::Source;
use crate::texture;
use crate::warning::Warnings;
use etendue_color::srgb_decode;
use etendue_image::{DecodeLimits, Image, Pixels, decode, lat_long_of_cube};
use etendue_scene::Environment;
use glam::{Quat, Vec3};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// The sky of the scene that is shown.
pub(crate) struct Sky {
    /// Which of the file's it is.
    pub number: u32,
    faces: Vec<Image>,
    /// For the rotation that was asked for last.
    made: Mutex<Option<([f64; 4], Arc<Image>)>>,
}

/// The sky of the scene that is shown; `None` if it has none, or, with a warning, none that can be read.
pub(crate) fn load(
    doc: &Document<'_>,
    buffers: &Buffers<'_>,
    source: &Source<'_>,
    warnings: &mut Warnings,
) -> Result<Option<Sky>, Fault> {
    let scene = doc.scene.unwrap_or(0);
    let Some(number) = doc.scenes.get(scene as usize).and_then(|s| s.image_light) else { return Ok(None) };
    let pointer = format!("/extensions/{}/lights/{number}", ext::LIGHTS_IMAGE_BASED);
    let from = || format!("/scenes/{scene}/extensions/{}/light", ext::LIGHTS_IMAGE_BASED);
    let light = get(&doc.image_lights, number, "image-based light", from)?;
    match faces(light, doc, buffers, source) {
        Ok(faces) => Ok(Some(Sky { number, faces, made: Mutex::default() })),
        Err(e) => {
            warnings.add(pointer, format!("the sky cannot be shown: {e}"));
            Ok(None)
        }
    }
}

fn faces(
    light: &ImageLight,
    doc: &Document<'_>,
    buffers: &Buffers<'_>,
    source: &Source<'_>,
) -> Result<Vec<Image>, String> {
    let limits =
        DecodeLimits { max_pixels: source.limits.image_pixels, max_bytes: source.limits.image_bytes };
    let faces: Vec<Image> = light
        .faces
        .par_iter()
        .map(|&i| {
            let code = texture::bytes(doc, i, buffers, source).map_err(|e| e.message())?;
            face(&decode(&code, &limits).map_err(|e| e.to_string())?)
        })
        .collect::<Result<_, String>>()?;
    let n = faces[0].width;
    if faces.iter().any(|f| (f.width, f.height) != (n, n)) {
        return Err("its six faces are not squares of one size".into());
    }
    // Four faces wide, two high, three floats each.
    if 96 * u64::from(n) * u64::from(n) > source.limits.image_bytes {
        return Err(format!("its faces of {n} × {n} pixels are beyond the limit `image_bytes`"));
    }
    Ok(faces)
}

impl Sky {
    /// As bright as `light` says, and turned so.
    pub fn at(&self, light: &ImageLight) -> Environment {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let image = match &*made {
            Some((rotation, image)) if *rotation == light.rotation => image.clone(),
            _ => Arc::new(self.turned(light.rotation)),
        };
        *made = Some((light.rotation, image.clone()));
        let intensity = light.intensity as f32;
        let intensity = if intensity.is_finite() && intensity >= 0.0 { intensity } else { 1.0 };
        Environment::LatLong { image, rotation: 0.0, intensity }
    }

    fn turned(&self, rotation: [f64; 4]) -> Image {
        let [x, y, z, w] = rotation.map(|v| v as f32);
        let turn = Quat::from_xyzw(x, y, z, w);
        let turn =
            if turn.is_finite() && turn.length_squared() > 1e-12 { turn.normalize() } else { Quat::IDENTITY };
        let back = turn.inverse();
        lat_long_of_cube(&self.faces, |d| (back * Vec3::from_array(d)).to_array())
    }
}

/// A face as light, oriented as graphics processors take it.
///
/// Four channels are RGBD: colours divided by alpha. They are encoded as sRGB, which the specification does not say, but the program that the extension
/// comes from (Babylon.js, `fromRGBD`) does. "Each saved image must be flipped about its vertical axis" ("Prefiltered Specular
/// Radiance Cubemaps"): columns are turned round.
fn face(image: &Image) -> Result<Image, String> {
    if image.channels < 3 {
        return Err("a face has no colours".into());
    }
    let (w, h) = (image.width, image.height);
    let mut out = Vec::with_capacity(3 * w as usize * h as usize);
    for y in 0..h {
        for x in (0..w).rev() {
            // No alpha would be infinite light; the smallest that a byte can say stands in.
            let d = if image.channels == 4 { image.sample(x, y, 3).max(1.0 / 255.0) } else { 1.0 };
            out.extend([0, 1, 2].map(|c| srgb_decode(image.sample(x, y, c)) / d));
        }
    }
    Ok(Image { width: w, height: h, channels: 3, pixels: Pixels::F32(out) })
}
