//! Cube maps as pictures: the six faces of a mip below one another.

use crate::cube::CubeMap;
use etendue_image::{Image, Pixels};

/// A mip as a picture of n × 6n pixels, three floats each: +X on top, then −X, +Y, −Y, +Z, −Z (the order of OpenEXR's
/// vertical strips; the faces are turned as in [`crate::cube`]).
pub fn strip(cube: &CubeMap, mip: usize) -> Image {
    let n = cube.mip_size(mip);
    let pixels = cube.mip(mip).iter().flat_map(|l| l.to_rgb()).collect();
    Image { width: n, height: 6 * n, channels: 3, pixels: Pixels::F32(pixels) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_color::Spectrum;

    #[test]
    fn faces_stand_below_one_another() {
        let texels = (0..24).map(|i| Spectrum::rgb(i as f32, 0.0, 1.0));
        let image = strip(&CubeMap::new(2, texels.collect()).unwrap(), 0);
        assert_eq!((image.width, image.height), (2, 12));
        assert_eq!(image.sample(1, 3, 0), 7.0);
    }
}
