//! What is written is read: a sky that becomes a cube file is the same sky when the file is read as one.
use etendue_color::Spectrum;
use etendue_ibl::{CubeMap, SkyMap, TexelFormat, dds, ktx2, to_cube};
use etendue_image::{DecodeLimits, Metadata, decode_environment};
use etendue_scene::Environment;
use glam::Vec3A;
use std::sync::Arc;

/// Smooth light that differs in every direction.
fn light(d: Vec3A) -> Spectrum {
    Spectrum::rgb(2.0 + d.x, 2.0 + d.y, 2.0 + d.z)
}

#[test]
fn cube_files_are_the_same_sky_again() {
    let size = 32;
    let cube = CubeMap::from_fn(size, light).with_mips();
    for (format, tolerance) in
        [(TexelFormat::Rgba16f, 0.003), (TexelFormat::Rgb9e5, 0.006), (TexelFormat::Bc6h, 0.09)]
    {
        for (kind, file) in
            [("ktx2", ktx2::encode(&cube, format, &Metadata::default())), ("dds", dds::encode(&cube, format))]
        {
            let image = Arc::new(decode_environment(&file, &DecodeLimits::default()).unwrap().image);
            assert_eq!((image.width, image.height), (4 * size, 2 * size));
            let sky = SkyMap::new(&Environment::LatLong { image, rotation: 0.0, intensity: 1.0 }).unwrap();
            let back = to_cube(&sky, size);
            let worst = (back.mip(0).iter().zip(cube.mip(0)))
                .map(|(a, b)| (*a - *b).map(f32::abs).max_element())
                .fold(0.0, f32::max);
            println!("{kind} {format}: {worst}");
            assert!(worst < tolerance, "{kind} {format}: {worst}");
        }
    }
}
