//! What is written is read back: samples, alpha, metadata, in every format.

use std::io::Cursor;
use std::path::Path;

use etendue_color::ToneCurve;
use etendue_image::{
    ChannelData, DecodeLimits, Depth, Development, Image, ImageError, Layer, Metadata, PictureFormat, Pixels,
    WriteOptions, decode, decode_environment, develop, encode_picture, read_environment, read_exr_layers,
    write_layers_exr, write_picture,
};
use image::ImageDecoder;

/// Light over many magnitudes, all values distinct enough that a swap of axes or channels shows.
fn light(width: u32, height: u32, channels: u8) -> Image {
    let mut p = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let v = (x as f32 * 0.37 + y as f32 * 1.9).sin() * 0.5 + 0.5;
            let alpha = (x + 1) as f32 / width as f32;
            let a = if channels == 4 { alpha } else { 1.0 };
            p.extend([v * a, v * v * 3.0 * a, (y as f32 / 8.0).exp2() * 0.01 * a]);
            if channels == 4 {
                p.push(alpha);
            }
        }
    }
    Image { width, height, channels, pixels: Pixels::F32(p) }
}

fn options() -> WriteOptions {
    let mut metadata = Metadata::default();
    metadata.set("Software", "etendue 0.1.0");
    metadata.set("Command", "etendue render <helmet> & \"sky\" --spp 256");
    metadata.set("Comment", "größer → 光");
    metadata.set("a name that is longer than thirty-one bytes", "42");
    WriteOptions { metadata, ..Default::default() }
}

fn encode(format: PictureFormat, image: &Image, options: &WriteOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_picture(&mut bytes, format, image, options).unwrap();
    bytes
}

fn floats(image: &Image) -> &[f32] {
    match &image.pixels {
        Pixels::F32(p) => p,
        _ => panic!("not floats"),
    }
}

#[test]
fn lossless_formats_return_the_developed_samples() {
    let limits = DecodeLimits::default();
    for channels in [3, 4] {
        for depth in [Depth::Eight, Depth::Sixteen] {
            let picture = light(37, 21, channels);
            let development =
                Development { depth, curve: ToneCurve::Agx, exposure_ev: -0.5, ..Default::default() };
            let o = WriteOptions { development, ..options() };
            let png = decode(&encode(PictureFormat::Png, &picture, &o), &limits).unwrap();
            assert_eq!(png, develop(&picture, &development));
            let webp = decode(&encode(PictureFormat::WebP, &picture, &o), &limits).unwrap();
            assert_eq!(webp, develop(&picture, &Development { depth: Depth::Eight, ..development }));
        }
    }
    // Grey and grey + alpha as well.
    for channels in [1u8, 2] {
        let pixels = Pixels::U8((0..200).map(|v| v as u8).collect());
        let picture = Image { width: 200 / u32::from(channels), height: 1, channels, pixels };
        assert_eq!(decode(&encode(PictureFormat::Png, &picture, &options()), &limits).unwrap(), picture);
        let webp = decode(&encode(PictureFormat::WebP, &picture, &options()), &limits).unwrap();
        for x in 0..picture.width {
            assert_eq!(webp.sample(x, 0, 0), picture.sample(x, 0, 0));
            assert_eq!(
                webp.sample(x, 0, webp.channels - 1),
                if channels == 2 { picture.sample(x, 0, 1) } else { webp.sample(x, 0, 2) }
            );
        }
    }
    // 16 bits pass PNG untouched.
    let wide = Image { width: 3, height: 1, channels: 1, pixels: Pixels::U16(vec![1, 0x1234, 65535]) };
    assert_eq!(decode(&encode(PictureFormat::Png, &wide, &options()), &limits).unwrap(), wide);
}

#[test]
fn jpeg_is_near_and_lies_on_black() {
    let limits = DecodeLimits::default();
    let picture = light(64, 48, 3);
    let o = WriteOptions { jpeg_quality: 100, ..options() };
    let (got, want) = (
        decode(&encode(PictureFormat::Jpeg, &picture, &o), &limits).unwrap(),
        develop(&picture, &o.development),
    );
    let (Pixels::U8(a), Pixels::U8(b)) = (&got.pixels, &want.pixels) else { panic!() };
    let rms = (a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum::<f64>()
        / a.len() as f64)
        .sqrt();
    assert_eq!((got.width, got.height, got.channels), (64, 48, 3));
    assert!(rms < 3.0, "{rms}");

    let clear =
        Image { width: 8, height: 8, channels: 4, pixels: Pixels::F32([0.5, 0.5, 0.5, 0.5].repeat(64)) };
    let got = decode(&encode(PictureFormat::Jpeg, &clear, &o), &limits).unwrap();
    // Straight colour 1 at alpha ½: 128 of 255.
    assert!((got.sample(3, 3, 0) * 255.0 - 128.0).abs() < 3.0);
}

#[test]
fn hdr_keeps_light_within_its_mantissa() {
    for width in [3, 37, 600] {
        let picture = light(width, 21, 3);
        let e =
            decode_environment(&encode(PictureFormat::Hdr, &picture, &options()), &DecodeLimits::default())
                .unwrap();
        assert_eq!((e.image.width, e.image.height, e.repaired), (width, 21, 0));
        for (a, b) in floats(&e.image).chunks_exact(3).zip(floats(&picture).chunks_exact(3)) {
            let peak = b[0].max(b[1]).max(b[2]);
            // Half a step of the shared exponent: at worst 1/256 of the largest channel.
            assert!((0..3).all(|i| (a[i] - b[i]).abs() <= peak / 255.0), "{a:?} {b:?}");
        }
    }
}

#[test]
fn exr_keeps_float_light_exactly_and_half_to_eleven_bits() {
    let limits = DecodeLimits::default();
    for channels in [3, 4] {
        let picture = light(37, 53, channels);
        let float = encode(PictureFormat::Exr, &picture, &WriteOptions { half: false, ..options() });
        let half = encode(PictureFormat::Exr, &picture, &WriteOptions { half: true, ..options() });
        assert!(half.len() < float.len());
        let sky = decode_environment(&float, &limits).unwrap();
        assert!(sky.notes.is_empty(), "{:?}", sky.notes);
        let n = channels as usize;
        for (a, b) in floats(&sky.image).chunks_exact(3).zip(floats(&picture).chunks_exact(n)) {
            assert_eq!(a, &b[..3]);
        }
        let sky = decode_environment(&half, &limits).unwrap();
        for (a, b) in floats(&sky.image).chunks_exact(3).zip(floats(&picture).chunks_exact(n)) {
            assert!((0..3).all(|i| (a[i] - b[i]).abs() <= b[i] / 2048.0 + 3e-8), "{a:?} {b:?}");
        }
        let layers = read_exr_layers(&float, &limits).unwrap();
        let beauty = layers.layer("").unwrap();
        assert_eq!(beauty.channels.iter().map(|c| c.0.as_str()).collect::<String>(), &"RGBA"[..n]);
        if let Some(ChannelData::F32(a)) = beauty.channel("A") {
            assert_eq!(a[5], 6.0 / 37.0);
        }
    }
}

#[test]
fn layers_keep_their_names_types_and_bits() {
    let (w, h) = (19u32, 35u32);
    let n = (w * h) as usize;
    let ramp = |k: f32| (0..n).map(|i| i as f32 * k).collect::<Vec<f32>>();
    let nan_like = f32::from_bits(0x0012_3456); // a Cryptomatte hash may be a denormal
    let layer = |name: &str, channels: Vec<(&str, ChannelData)>| Layer {
        name: name.into(),
        channels: channels.into_iter().map(|(c, d)| (c.to_string(), d)).collect(),
    };
    let layers = vec![
        layer(
            "",
            "RGBA"
                .chars()
                .map(|c| (c.to_string(), c))
                .map(|(_, c)| match c {
                    'R' => ("R", ChannelData::Color(ramp(0.5))),
                    'G' => ("G", ChannelData::Color(ramp(100.0))),
                    'B' => ("B", ChannelData::Color(ramp(1.0))),
                    _ => ("A", ChannelData::Color(vec![1.0; n])),
                })
                .collect(),
        ),
        layer(
            "normal",
            vec![
                ("X", ChannelData::F32(ramp(-0.001))),
                ("Y", ChannelData::F32(ramp(0.3))),
                ("Z", ChannelData::F32(ramp(1e-3))),
            ],
        ),
        layer("depth", vec![("Z", ChannelData::F32(ramp(1e6)))]),
        layer(
            "object",
            vec![("id", ChannelData::U32((0..n as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect()))],
        ),
        layer(
            "CryptoObject00",
            vec![("R", ChannelData::F32(vec![nan_like; n])), ("G", ChannelData::F32(ramp(0.1)))],
        ),
    ];
    let mut metadata = options().metadata;
    metadata.set("cryptomatte/28322e9/name", "CryptoObject");
    metadata.set("cryptomatte/28322e9/manifest", "{\"visor\":\"13851a76\"}");
    metadata.set("compression", "not the real one");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("all.exr");
    for half in [false, true] {
        write_layers_exr(&path, &layers, (w, h), &metadata, half).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let back = read_exr_layers(&bytes, &DecodeLimits::default()).unwrap();
        assert_eq!((back.width, back.height), (w, h));
        for l in &layers {
            let got = back.layer(&l.name).unwrap_or_else(|| panic!("{} is missing", l.name));
            for (name, data) in &l.channels {
                match (data, got.channel(name).unwrap()) {
                    (ChannelData::Color(a), ChannelData::Color(b)) if half => {
                        // 100 × 664 is beyond the halfs: it stays finite.
                        assert!(a.iter().zip(b).all(|(a, b)| (a.min(65504.0) - b).abs() <= a / 2048.0));
                    }
                    (ChannelData::Color(a), ChannelData::F32(b)) if !half => assert_eq!(a, b),
                    (ChannelData::F32(a), ChannelData::F32(b)) => {
                        assert!(
                            a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits()),
                            "{}.{name}",
                            l.name
                        );
                    }
                    (a, b) => assert_eq!(a, b),
                }
            }
        }
        for (name, value) in &metadata.entries {
            let name = if name == "compression" { "meta/compression" } else { name };
            assert_eq!(back.metadata.get(name), Some(value.as_str()), "{name}");
        }
    }
}

#[test]
fn exr_bytes_do_not_depend_on_threads() {
    let picture = light(300, 200, 4);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| encode(PictureFormat::Exr, &picture, &options()))
    };
    let one = with(1);
    for threads in [2, 7] {
        assert!(one == with(threads));
    }
}

#[test]
fn metadata_stand_in_every_file() {
    let picture = light(16, 16, 4);
    let o = options();
    let want = &o.metadata.entries;

    let png = encode(PictureFormat::Png, &picture, &o);
    let reader = png::Decoder::new(Cursor::new(&png)).read_info().unwrap();
    let info = reader.info();
    assert!(info.srgb.is_some());
    for (name, value) in want {
        let latin = info.uncompressed_latin1_text.iter().any(|t| &t.keyword == name && &t.text == value);
        let utf8 = info.utf8_text.iter().any(|t| &t.keyword == name && &t.get_text().unwrap() == value);
        assert!(latin || utf8, "PNG: {name}");
    }
    let linear = WriteOptions { development: Development { linear: true, ..o.development }, ..o.clone() };
    let png = encode(PictureFormat::Png, &picture, &linear);
    let reader = png::Decoder::new(Cursor::new(&png)).read_info().unwrap();
    assert!(reader.info().srgb.is_none());
    assert_eq!(reader.info().gama_chunk.map(|g| g.into_scaled()), Some(100_000));

    let contains = |bytes: &[u8], text: &str| bytes.windows(text.len()).any(|w| w == text.as_bytes());
    let jpeg = encode(PictureFormat::Jpeg, &picture, &o);
    let hdr = encode(PictureFormat::Hdr, &picture, &o);
    for (name, value) in want {
        assert!(contains(&jpeg, &format!("{name}: {value}")), "JPEG: {name}");
        assert!(contains(&hdr, &format!("# {name}: {value}\n")), "HDR: {name}");
    }

    let webp = encode(PictureFormat::WebP, &picture, &o);
    let mut decoder = image::codecs::webp::WebPDecoder::new(Cursor::new(&webp)).unwrap();
    let xmp = String::from_utf8(decoder.xmp_metadata().unwrap().unwrap()).unwrap();
    for (name, value) in want {
        let value =
            value.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        assert!(xmp.contains(&format!("e:name=\"{name}\">{value}<")), "WebP: {xmp}");
    }
}

#[test]
fn unknown_extensions_and_failed_writes_leave_the_old_file() {
    let dir = tempfile::tempdir().unwrap();
    let picture = light(8, 8, 3);
    let e = write_picture(Path::new("a.tga"), &picture, &options()).unwrap_err();
    assert!(e.to_string().contains(".png, .jpg, .jpeg, .webp, .hdr, .exr"), "{e}");
    // WebP ends at 16384 pixels: the old picture stays.
    let path = dir.path().join("a.WebP");
    write_picture(&path, &picture, &options()).unwrap();
    let old = std::fs::read(&path).unwrap();
    let wide = Image { width: 16385, height: 1, channels: 1, pixels: Pixels::U8(vec![0; 16385]) };
    let e = write_picture(&path, &wide, &options()).unwrap_err();
    assert!(matches!(e, ImageError::InFile { .. }) && e.to_string().contains("a.WebP"), "{e}");
    assert_eq!(std::fs::read(&path).unwrap(), old);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    let e = read_environment(&dir.path().join("missing.hdr")).unwrap_err();
    assert!(e.to_string().contains("missing.hdr"), "{e}");
}

#[test]
fn a_sky_in_exr_is_repaired() {
    let mut picture = light(4, 4, 3);
    if let Pixels::F32(p) = &mut picture.pixels {
        p[0] = f32::NAN;
        p[4] = f32::INFINITY;
        p[5] = -1.0;
        p[9] = -1e-3;
    }
    let bytes = encode(PictureFormat::Exr, &picture, &WriteOptions { half: false, ..options() });
    let sky = decode_environment(&bytes, &DecodeLimits::default()).unwrap();
    assert_eq!(sky.repaired, 3);
    let largest = floats(&picture).iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
    assert_eq!(
        floats(&sky.image)[..6],
        [0.0, floats(&picture)[1], floats(&picture)[2], floats(&picture)[3], largest, 0.0]
    );
}

/// A strip of six faces with the attribute is a sky: each face's light comes from where OpenEXR says that it stands.
#[test]
fn cube_strips_are_skies() {
    let n = 8u32;
    let pixels =
        (0..6 * n * n).flat_map(|i| [(i / (n * n)) as f32, (i % n) as f32, (i / n % n) as f32]).collect();
    let strip = Image { width: n, height: 6 * n, channels: 3, pixels: Pixels::F32(pixels) };
    let mut metadata = Metadata::default();
    metadata.set("envmap", "cube");
    let options = WriteOptions { half: false, metadata, ..Default::default() };
    let mut file = Vec::new();
    encode_picture(&mut file, PictureFormat::Exr, &strip, &options).unwrap();
    let layers = read_exr_layers(&file, &DecodeLimits::default()).unwrap();
    assert_eq!(layers.metadata.get("envmap"), Some("cube"));

    let sky = decode_environment(&file, &DecodeLimits::default()).unwrap();
    assert_eq!((sky.image.width, sky.image.height, sky.repaired), (4 * n, 2 * n, 0));
    assert!(sky.notes.iter().any(|n| n.contains("cube map")), "{:?}", sky.notes);
    // +X in the middle, +Z a quarter to the right, −Z to the left, −X at the seam; +Y above, −Y below.
    for (x, y, face) in [(16, 8, 0.0), (0, 8, 1.0), (24, 8, 4.0), (8, 8, 5.0), (5, 0, 2.0), (5, 15, 3.0)] {
        assert_eq!(sky.image.sample(x, y, 0), face, "({x}, {y})");
    }
    // On +X columns go towards +Z (to the right), rows down.
    let column = |x| sky.image.sample(x, 8, 1);
    assert!(column(18) > column(15) && sky.image.sample(16, 10, 2) > sky.image.sample(16, 6, 2));

    // Any other shape is none, and a value that the attribute cannot have is a text.
    let wide = Image { width: 12, height: 32, ..strip };
    let mut file = Vec::new();
    encode_picture(&mut file, PictureFormat::Exr, &wide, &options).unwrap();
    let e = decode_environment(&file, &DecodeLimits::default()).unwrap_err().to_string();
    assert!(e.contains("12 × 32") && e.contains("six square faces"), "{e}");
    let mut metadata = Metadata::default();
    metadata.set("envmap", "octahedron");
    let mut file = Vec::new();
    encode_picture(&mut file, PictureFormat::Exr, &wide, &WriteOptions { metadata, ..options }).unwrap();
    let layers = read_exr_layers(&file, &DecodeLimits::default()).unwrap();
    assert_eq!(layers.metadata.get("meta/envmap"), Some("octahedron"));
}
