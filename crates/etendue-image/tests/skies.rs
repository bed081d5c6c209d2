//! Skies in every layout: light that is its own direction, laid out as each convention says, comes back at its directions.
use etendue_image::{
    DecodeLimits, Image, Metadata, PictureFormat, Pixels, SkyLayout, WriteOptions, decode_environment,
    decode_environment_as, encode_picture,
};
use std::f64::consts::{PI, TAU};

type Direction = [f32; 3];

/// The light from a direction of any length.
fn light(d: Direction) -> [f32; 3] {
    let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
    d.map(|v| 2.0 + v / length)
}

/// What each cell of a picture shows at (s, t), −1..1 to the right and down: column, row, direction.
type Cell = (u32, u32, fn(f32, f32) -> Direction);

/// OpenGL 4.6, table 8.19.
const TEXTURE: [fn(f32, f32) -> Direction; 6] = [
    |s, t| [1.0, -t, -s],
    |s, t| [-1.0, -t, s],
    |s, t| [s, 1.0, t],
    |s, t| [s, -1.0, -t],
    |s, t| [s, -t, 1.0],
    |s, t| [-s, -t, -1.0],
];

/// `pixelPosition` of OpenEXR's `ImfEnvmap.cpp`, solved for the direction.
const OPENEXR: [fn(f32, f32) -> Direction; 6] = [
    |s, t| [1.0, -t, s],
    |s, t| [-1.0, -t, -s],
    |s, t| [s, 1.0, -t],
    |s, t| [s, -1.0, t],
    |s, t| [-s, -t, 1.0],
    |s, t| [s, -t, -1.0],
];

/// What an eye within the cube sees that looks along −Z and turns right, left, up, down, and round.
const SEEN: [Cell; 6] = [
    (1, 1, |s, t| [s, -t, -1.0]),
    (2, 1, |s, t| [1.0, -t, s]),
    (0, 1, |s, t| [-1.0, -t, -s]),
    (1, 0, |s, t| [s, 1.0, -t]),
    (1, 2, |s, t| [s, -1.0, t]),
    (3, 1, |s, t| [-s, -t, 1.0]),
];

/// The last one when it hangs below: upside down.
const BELOW: Cell = (1, 3, |s, t| [s, t, 1.0]);

/// `n`² pixels for each cell, black elsewhere.
fn picture(n: u32, columns: u32, rows: u32, cells: &[Cell], mirrored: bool) -> Image {
    let (width, height) = (n * columns, n * rows);
    let mut pixels = vec![0.0; (3 * width * height) as usize];
    let c = |i: u32| (2 * i + 1) as f32 / n as f32 - 1.0;
    for (column, row, direction) in cells {
        for y in 0..n {
            for x in 0..n {
                let mut d = direction(c(x), c(y));
                if mirrored {
                    d[2] = -d[2];
                }
                let at = ((row * n + y) * width + column * n + x) as usize * 3;
                pixels[at..at + 3].copy_from_slice(&light(d));
            }
        }
    }
    Image { width, height, channels: 3, pixels: Pixels::F32(pixels) }
}

fn strip(n: u32, faces: &[fn(f32, f32) -> Direction; 6], down: bool) -> Image {
    let cells: Vec<Cell> =
        (0..6).map(|i| (if down { 0 } else { i }, if down { i } else { 0 }, faces[i as usize])).collect();
    if down { picture(n, 1, 6, &cells, false) } else { picture(n, 6, 1, &cells, false) }
}

fn encode(image: &Image, format: PictureFormat, envmap: Option<&str>) -> Vec<u8> {
    let mut metadata = Metadata::default();
    if let Some(kind) = envmap {
        metadata.set("envmap", kind);
    }
    let mut out = Vec::new();
    let options = WriteOptions { half: false, metadata, ..WriteOptions::default() };
    encode_picture(&mut out, format, image, &options).unwrap();
    out
}

/// The largest error of a latitude-longitude picture of [`light`].
fn worst(image: &Image) -> f32 {
    assert_eq!(image.width, 2 * image.height);
    let mut worst = 0.0f32;
    for y in 0..image.height {
        for x in 0..image.width {
            let phi = TAU * ((f64::from(x) + 0.5) / f64::from(image.width) - 0.5);
            let theta = PI * (f64::from(y) + 0.5) / f64::from(image.height);
            let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|v| v as f32);
            for (c, l) in light(d).iter().enumerate() {
                worst = worst.max((image.sample(x, y, c as u8) - l).abs());
            }
        }
    }
    worst
}

#[test]
fn layouts_are_told_apart_and_oriented() {
    let n = 32;
    let mut below = SEEN.to_vec();
    below[5] = BELOW;
    let limits = DecodeLimits::default();
    let all: [(&str, Image, Option<SkyLayout>, Option<&str>); 8] = [
        ("strip down", strip(n, &TEXTURE, true), None, None),
        ("strip across", strip(n, &TEXTURE, false), None, None),
        ("envmap cube", strip(n, &OPENEXR, true), None, Some("cube")),
        ("strip-exr across", strip(n, &OPENEXR, false), Some(SkyLayout::StripExr), None),
        ("cross", picture(n, 4, 3, &SEEN, false), None, None),
        ("cross upright", picture(n, 3, 4, &below, false), None, None),
        ("cross-texture", picture(n, 4, 3, &SEEN, true), Some(SkyLayout::CrossTexture), None),
        ("cross-texture upright", picture(n, 3, 4, &below, true), Some(SkyLayout::CrossTexture), None),
    ];
    for (name, image, layout, envmap) in &all {
        let file = encode(image, PictureFormat::Exr, *envmap);
        let sky = decode_environment_as(&file, &limits, *layout).unwrap();
        let error = worst(&sky.image);
        println!("{name}: {error}");
        assert!(error < 0.012, "{name}: {error}");
        assert!(sky.notes.iter().any(|n| n.contains("a cube map of 32 × 32")), "{:?}", sky.notes);
        // Radiance keeps eight bits of the brightest channel.
        let file = encode(image, PictureFormat::Hdr, None);
        let error = match envmap {
            Some(_) => {
                worst(&decode_environment_as(&file, &limits, Some(SkyLayout::StripExr)).unwrap().image)
            }
            None => worst(&decode_environment_as(&file, &limits, *layout).unwrap().image),
        };
        assert!(error < 0.03, "{name}: {error}");
    }
}

/// What the file or the user says counts more than the size.
#[test]
fn a_layout_can_be_said() {
    let limits = DecodeLimits::default();
    let cross = picture(8, 4, 3, &SEEN, false);
    let file = encode(&cross, PictureFormat::Exr, None);
    let as_it_is = decode_environment_as(&file, &limits, Some(SkyLayout::LatLong)).unwrap();
    assert_eq!(as_it_is.image, cross);
    let wrong = decode_environment_as(&file, &limits, Some(SkyLayout::Strip)).unwrap_err().to_string();
    assert!(wrong.contains("32 × 24") && wrong.contains("strip"), "{wrong}");
    // Turned the other way, a face is elsewhere.
    let turned = decode_environment_as(&file, &limits, Some(SkyLayout::CrossTexture)).unwrap();
    assert!(worst(&turned.image) > 1.0);
}

/// Sky of 8 bits in a strip: colours are decoded.
#[test]
fn a_strip_of_a_png_is_a_sky() {
    let mut strip = strip(16, &TEXTURE, false);
    let Pixels::F32(p) = &strip.pixels else { panic!() };
    let coded = p.iter().map(|v| (etendue_color::srgb_encode(v / 4.0) * 255.0).round() as u8);
    strip.pixels = Pixels::U8(coded.collect());
    let mut sky = decode_environment(&encode(&strip, PictureFormat::Png, None), &DecodeLimits::default())
        .unwrap()
        .image;
    if let Pixels::F32(p) = &mut sky.pixels {
        p.iter_mut().for_each(|v| *v *= 4.0);
    }
    let error = worst(&sky);
    assert!(error < 0.06, "{error}");
}

/// A DDS file: header with the given words for the pixel format, caps2 and the DX10 part, then the data.
fn dds(
    size: (u32, u32),
    mips: u32,
    pixel: [u32; 8],
    caps2: u32,
    dx10: Option<[u32; 5]>,
    data: &[u8],
) -> Vec<u8> {
    let mut words = vec![u32::from_le_bytes(*b"DDS "), 124, 0x1007, size.1, size.0, 0, 0, mips];
    words.extend([0; 11]);
    words.extend(pixel);
    words.extend([0x1000, caps2, 0, 0, 0]);
    words.extend(dx10.into_iter().flatten());
    let mut out: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    out.extend(data);
    out
}

fn dx10(format: u32, cube: bool, size: u32, mips: u32, data: &[u8]) -> Vec<u8> {
    let four = u32::from_le_bytes(*b"DX10");
    let misc = if cube { 4 } else { 0 };
    dds((size, size), mips, [32, 4, four, 0, 0, 0, 0, 0], 0, Some([format, 3, misc, 1, 0]), data)
}

#[test]
fn texels_of_dds_are_read() {
    let first = |file: &[u8]| {
        let sky = decode_environment(file, &DecodeLimits::default()).unwrap().image;
        [0, 1, 2].map(|c| sky.sample(0, 0, c))
    };
    let near =
        |a: [f32; 3], b: [f32; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3), "{a:?} {b:?}");
    let floats: Vec<u8> = [1.0f32, 2.5, 0.25, 0.5].iter().flat_map(|v| v.to_le_bytes()).collect();
    near(first(&dx10(2, false, 1, 1, &floats)), [1.0, 2.5, 0.25]);
    near(first(&dx10(6, false, 1, 1, &floats[..12])), [1.0, 2.5, 0.25]);
    // 1, 2.5, 0.25, 0.5 as halves.
    let halves: Vec<u8> = [0x3c00u16, 0x4100, 0x3400, 0x3800].iter().flat_map(|v| v.to_le_bytes()).collect();
    near(first(&dx10(10, false, 1, 1, &halves)), [1.0, 2.5, 0.25]);
    near(first(&dds((1, 1), 1, [32, 4, 113, 0, 0, 0, 0, 0], 0, None, &halves)), [1.0, 2.5, 0.25]);
    // Exponents of five bits and mantissas of six, six and five.
    let packed = 0x3c0u32 | 0x410 << 11 | 0x1a0 << 22;
    near(first(&dx10(26, false, 1, 1, &packed.to_le_bytes())), [1.0, 2.5, 0.25]);
    // 512, 256 and 64 at 2⁻⁸: 2, 1, 0.25.
    let shared = 511u32 | 256 << 9 | 64 << 18 | 16 << 27;
    near(first(&dx10(67, false, 1, 1, &shared.to_le_bytes())), [511.0 / 256.0, 1.0, 0.25]);
    near(first(&dx10(28, false, 1, 1, &[255, 51, 0, 255])), [1.0, 0.2, 0.0]);
    near(first(&dx10(29, false, 1, 1, &[255, 124, 0, 255])), [1.0, 0.2016, 0.0]);
    near(first(&dx10(87, false, 1, 1, &[0, 51, 255, 255])), [1.0, 0.2, 0.0]);
    near(first(&dx10(24, false, 1, 1, &(1023u32 | 205 << 10 | 3 << 30).to_le_bytes())), [1.0, 0.2004, 0.0]);
    let masks = [32, 0x40, 0, 32, 0xff0000, 0xff00, 0xff, 0];
    near(first(&dds((1, 1), 1, masks, 0, None, &[0, 124, 255, 9])), [1.0, 0.2016, 0.0]);

    // A cube whose faces are 0, 1 … 5, each with two mips.
    let data: Vec<u8> =
        (0..6u8).flat_map(|f| [[f * 20, 0, 0, 255].repeat(4), vec![255; 4]].concat()).collect();
    let sky = decode_environment(&dx10(28, true, 2, 2, &data), &DecodeLimits::default()).unwrap().image;
    assert_eq!((sky.width, sky.height), (8, 4));
    // The middle of a row is +X, its left end −X, a quarter from the right +Z.
    let red = |x| sky.sample(x, 2, 0) * 255.0;
    assert!(red(0) > 5.0 && red(4) < red(0) && red(6) > 60.0, "{} {} {}", red(0), red(4), red(6));

    let limits = DecodeLimits::default();
    for (bad, why) in [
        (dx10(28, true, 2, 2, &data[..data.len() - 5]), "which end"),
        (dx10(71, false, 4, 1, &[0; 8]), "format 71"),
        (dx10(28, false, 0, 1, &[]), "mips"),
        (dds((1, 1), 1, [32, 4, u32::from_le_bytes(*b"DXT5"), 0, 0, 0, 0, 0], 0, None, &[0; 16]), "DXT5"),
        (dds((1, 1), 1, masks, 0x200 | 0x400, None, &[0; 4]), "lacks faces"),
        (dx10(2, false, 60_000, 1, &[]), "more than the limit"),
    ] {
        let e = decode_environment(&bad, &limits).unwrap_err().to_string();
        assert!(e.contains(why), "{e}");
    }
}

#[test]
fn any_bytes_are_a_sky_or_an_error() {
    let data = vec![60; 6 * 4 * 5];
    let good = dx10(28, true, 2, 2, &data);
    let limits = DecodeLimits { max_pixels: 1 << 16, max_bytes: 1 << 20 };
    for at in 0..good.len() {
        for value in [0, 1, 4, 0x40, 0x7f, 0xff] {
            let mut bad = good.clone();
            bad[at] = value;
            let _ = decode_environment(&bad, &limits);
        }
        let _ = decode_environment(&good[..at], &limits);
    }
}
