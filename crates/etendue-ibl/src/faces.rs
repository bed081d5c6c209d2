//! Cube maps as pictures: the six faces of a mip below one another.

use crate::cube::CubeMap;
use etendue_image::{Image, Pixels};

/// How the faces of a strip are turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// As in [`crate::cube`]: what OpenGL, Vulkan and Direct3D take as textures.
    Texture,
    /// As OpenEXR's `envmap = cube` has them (`ImfEnvmap.h`): seen from inside, so that the sides are mirrored left to right, and top and bottom
    /// upside down, against the textures. Texels stay where they are: OpenEXR's own tools put the outermost ones on the cube's edges,
    /// half a texel further out.
    OpenExr,
}

/// A mip as a picture of n × 6n pixels, three floats each: +X on top, then −X, +Y, −Y, +Z, −Z.
pub fn strip(cube: &CubeMap, mip: usize, turn: Turn) -> Image {
    let n = cube.mip_size(mip) as usize;
    let texels = cube.mip(mip);
    let pixels = (0..6 * n * n)
        .flat_map(|i| {
            let (face, y, x) = (i / (n * n), i / n % n, i % n);
            let (x, y) = match turn {
                Turn::Texture => (x, y),
                Turn::OpenExr if face / 2 == 1 => (x, n - 1 - y),
                Turn::OpenExr => (n - 1 - x, y),
            };
            texels[(face * n + y) * n + x].to_rgb()
        })
        .collect();
    Image { width: n as u32, height: 6 * n as u32, channels: 3, pixels: Pixels::F32(pixels) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SkyMap, to_cube};
    use etendue_color::Spectrum;
    use etendue_image::{
        DecodeLimits, Metadata, PictureFormat, WriteOptions, decode_environment, encode_picture,
    };
    use etendue_scene::Environment;
    use glam::Vec3A;
    use std::sync::Arc;

    #[test]
    fn faces_stand_below_one_another() {
        let texels = (0..24).map(|i| Spectrum::rgb(i as f32, 0.0, 1.0));
        let image = strip(&CubeMap::new(2, texels.collect()).unwrap(), 0, Turn::Texture);
        assert_eq!((image.width, image.height), (2, 12));
        assert_eq!(image.sample(1, 3, 0), 7.0);
    }

    /// A cube that is written as OpenEXR and read back as a sky shows the same light from everywhere.
    #[test]
    fn files_of_cubes_are_skies_again() {
        let light = |d: Vec3A| Spectrum::rgb(2.0 + d.x, 2.0 + d.y, 2.0 + d.z);
        let cube = CubeMap::from_fn(32, light);
        let mut metadata = Metadata::default();
        metadata.set("envmap", "cube");
        let options = WriteOptions { half: false, metadata, ..Default::default() };
        let mut file = Vec::new();
        encode_picture(&mut file, PictureFormat::Exr, &strip(&cube, 0, Turn::OpenExr), &options).unwrap();
        let image = Arc::new(decode_environment(&file, &DecodeLimits::default()).unwrap().image);
        let sky = SkyMap::new(&Environment::LatLong { image, rotation: 0.0, intensity: 1.0 }).unwrap();
        let back = to_cube(&sky, 32);
        for (a, b) in back.mip(0).iter().zip(cube.mip(0)) {
            assert!((*a - *b).map(f32::abs).max_element() < 0.04, "{a:?} {b:?}");
        }
    }
}
