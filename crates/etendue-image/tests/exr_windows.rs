//! OpenEXR files as other programs make them: windows, parts, layers, sample types.

use std::io::Cursor;
use std::path::Path;

use etendue_image::{
    ChannelData, DecodeLimits, Environment, Image, PictureFormat, Pixels, WriteOptions, decode_environment,
    encode_picture, read_environment, read_exr_layers,
};
use exr::prelude as e;
use exr::prelude::{FlatSamples, IntegerBounds, LayerAttributes, Vec2, WritableImage};

fn channel(name: &str, samples: FlatSamples) -> e::AnyChannel<FlatSamples> {
    e::AnyChannel::new(name, samples)
}

fn layer(
    name: &str,
    size: (usize, usize),
    at: (i32, i32),
    encoding: e::Encoding,
    channels: Vec<e::AnyChannel<FlatSamples>>,
) -> e::Layer<e::AnyChannels<FlatSamples>> {
    let attributes = LayerAttributes { layer_position: Vec2(at.0, at.1), ..LayerAttributes::named(name) };
    e::Layer::new(size, attributes, encoding, e::AnyChannels::sort(channels.into()))
}

fn file(display: IntegerBounds, layers: Vec<e::Layer<e::AnyChannels<FlatSamples>>>) -> Vec<u8> {
    let image =
        e::Image { attributes: e::ImageAttributes::new(display), layer_data: e::Layers::from(layers) };
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn sky(bytes: &[u8]) -> Environment {
    decode_environment(bytes, &DecodeLimits::default()).unwrap()
}

fn floats(e: &Environment) -> &[f32] {
    let Pixels::F32(p) = &e.image.pixels else { panic!() };
    p
}

fn ramp(n: usize, from: f32) -> FlatSamples {
    FlatSamples::F32((0..n).map(|i| from + i as f32).collect())
}

fn window(x: i32, y: i32, w: usize, h: usize) -> IntegerBounds {
    IntegerBounds::new((x, y), (w, h))
}

#[test]
fn the_data_window_is_placed_in_the_display_window() {
    let rgb = |n| ["R", "G", "B"].map(|c| channel(c, ramp(n, 1.0))).to_vec();
    // 2 × 2 pixels at (11, 21) in a display window of 4 × 3 at (10, 20): column 1, row 1.
    let bytes =
        file(window(10, 20, 4, 3), vec![layer("a", (2, 2), (11, 21), e::Encoding::UNCOMPRESSED, rgb(4))]);
    let got = sky(&bytes);
    assert_eq!((got.image.width, got.image.height), (4, 3));
    let red: Vec<f32> = floats(&got).iter().step_by(3).copied().collect();
    assert_eq!(red, [0., 0., 0., 0., 0., 1., 2., 0., 0., 3., 4., 0.]);
    // Larger than the display window on all sides: cut.
    let bytes =
        file(window(0, 0, 2, 1), vec![layer("a", (4, 3), (-1, -1), e::Encoding::SMALL_LOSSLESS, rgb(12))]);
    let red: Vec<f32> = floats(&sky(&bytes)).iter().step_by(3).copied().collect();
    assert_eq!(red, [6.0, 7.0]);
    // Beside it: nothing but black.
    let bytes =
        file(window(0, 0, 2, 1), vec![layer("a", (1, 1), (500, 0), e::Encoding::UNCOMPRESSED, rgb(1))]);
    assert_eq!(floats(&sky(&bytes)), [0.0; 6]);
}

#[test]
fn colours_are_found_among_parts_and_layers() {
    let n = 6;
    let depth =
        layer("depth", (3, 2), (0, 0), e::Encoding::FAST_LOSSLESS, vec![channel("Z", ramp(n, 100.0))]);
    let named = ["diffuse.R", "diffuse.G", "diffuse.B"].map(|c| channel(c, ramp(n, 10.0))).to_vec();
    let named = layer("light", (3, 2), (0, 0), e::Encoding::FAST_LOSSLESS, named);
    let plain = vec![
        channel("R", ramp(n, 1.0)),
        channel("G", FlatSamples::F16((0..6).map(|v| half::f16::from_f32(v as f32)).collect())),
        channel("B", FlatSamples::U32((0..6).collect())),
        channel("A", ramp(n, 0.0)),
    ];
    let plain = layer("beauty", (3, 2), (0, 0), e::Encoding::SMALL_LOSSLESS, plain);
    let d = window(0, 0, 3, 2);
    // Plain channels win, wherever the part stands.
    let all = sky(&file(d, vec![depth.clone(), named.clone(), plain]));
    assert_eq!(floats(&all)[..6], [1.0, 0.0, 0.0, 2.0, 1.0, 1.0]);
    assert!(all.notes[0].contains("beauty"), "{:?}", all.notes);
    // Without them the first layer that has colours.
    let got = sky(&file(d, vec![depth.clone(), named]));
    assert_eq!(floats(&got)[..3], [10.0; 3]);
    assert!(got.notes[0].contains("diffuse"), "{:?}", got.notes);
    // Luminance alone is grey; depth alone is no picture.
    let grey = layer("y", (3, 2), (0, 0), e::Encoding::FAST_LOSSLESS, vec![channel("Y", ramp(n, 5.0))]);
    assert_eq!(floats(&sky(&file(d, vec![grey])))[..3], [5.0; 3]);
    let e = decode_environment(&file(d, vec![depth]), &DecodeLimits::default()).unwrap_err();
    assert!(e.to_string().contains("no channels R, G, B or Y"), "{e}");
}

#[test]
fn layers_of_several_parts_carry_their_names() {
    let d = window(0, 0, 3, 2);
    let a = layer(
        "a",
        (3, 2),
        (0, 0),
        e::Encoding::FAST_LOSSLESS,
        vec![channel("R", ramp(6, 1.0)), channel("x.Z", ramp(6, 2.0))],
    );
    let b = layer(
        "b",
        (3, 2),
        (0, 0),
        e::Encoding::FAST_LOSSLESS,
        vec![channel("id", FlatSamples::U32((0..6).collect()))],
    );
    let got = read_exr_layers(&file(d, vec![a, b]), &DecodeLimits::default()).unwrap();
    let names: Vec<&str> = got.layers.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["a", "a.x", "b"]);
    assert_eq!(got.layer("b").unwrap().channel("id"), Some(&ChannelData::U32((0..6).collect())));
}

#[test]
fn a_claim_beyond_the_bytes_is_refused() {
    let picture = Image { width: 1, height: 1, channels: 3, pixels: Pixels::F32(vec![1.0; 3]) };
    let mut bytes = Vec::new();
    encode_picture(&mut bytes, PictureFormat::Exr, &picture, &WriteOptions::default()).unwrap();
    // The windows are boxes of four little-endian integers behind their names; a million pixels each way.
    let claim = |name: &str, bytes: &mut Vec<u8>| {
        let key = format!("{name}\0box2i\0");
        let at = bytes.windows(key.len()).position(|w| w == key.as_bytes()).unwrap() + key.len() + 4;
        bytes[at + 8..at + 12].copy_from_slice(&999_999i32.to_le_bytes());
        bytes[at + 12..at + 16].copy_from_slice(&999_999i32.to_le_bytes());
    };
    let (mut data, mut display) = (bytes.clone(), bytes);
    claim("dataWindow", &mut data);
    claim("displayWindow", &mut display);
    for (b, why) in [(&data, "offset table"), (&display, "limit of 268435456 pixels")] {
        let e = decode_environment(b, &DecodeLimits::default()).unwrap_err().to_string();
        assert!(e.contains(why), "{e}");
    }
    // Within the limit of pixels the small picture still bounds its frame.
    let wide = DecodeLimits { max_pixels: u64::MAX, max_bytes: u64::MAX };
    let e = decode_environment(&display, &wide).unwrap_err().to_string();
    assert!(e.contains("far larger than the data window of 1 × 1"), "{e}");
    assert!(read_exr_layers(&data, &DecodeLimits::default()).is_err());
}

/// The OpenEXR sample pictures `t01` to `t15` are one picture with its windows moved.
#[test]
fn the_sample_windows_show_the_same_picture() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets/images-valid/openexr-images");
    if !folder.is_dir() {
        println!("skipped: no test assets beside the workspace");
        return;
    }
    let whole = read_environment(&folder.join("t01.exr")).unwrap();
    // Size of the display window, and where the data window of 400 × 300 lies in it: from the files' headers.
    for (name, size, at) in [
        ("t02", (400, 300), (-1, -1)),
        ("t03", (370, 280), (-30, -20)),
        ("t05", (340, 260), (-30, -20)),
        ("t06", (402, 302), (1, 1)),
        ("t07", (481, 371), (40, 40)),
        ("t08", (501, 401), (30, 40)),
        ("t09", (200, 300), (-400, 0)),
        ("t13", (101, 101), (-399, -299)),
    ] {
        let got = read_environment(&folder.join(format!("{name}.exr"))).unwrap();
        assert_eq!((got.image.width, got.image.height), size, "{name}");
        for y in 0..size.1 {
            for x in 0..size.0 {
                let (u, v) = (x as i32 - at.0, y as i32 - at.1);
                let inside = (0..400).contains(&u) && (0..300).contains(&v);
                let want = if inside { whole.image.sample(u as u32, v as u32, 0) } else { 0.0 };
                assert_eq!(got.image.sample(x, y, 0), want, "{name} ({x}, {y})");
            }
        }
    }
}

/// Found by mutation: a DWA chunk says how long its sections are once inflated, and the decompressor took its word (2 TB).
#[test]
fn the_counters_of_a_dwa_chunk_are_not_believed() {
    let picture = Image { width: 1, height: 1, channels: 3, pixels: Pixels::F32(vec![1.0; 3]) };
    let mut bytes = Vec::new();
    encode_picture(&mut bytes, PictureFormat::Exr, &picture, &WriteOptions::default()).unwrap();
    let key = b"compression\0compression\0\x01\0\0\0";
    let at = bytes.windows(key.len()).position(|w| w == key).unwrap() + key.len();
    bytes[at] = 8; // DWAA
    // One chunk of six raw bytes ends the file; in its place eleven counters, one of them absurd.
    bytes.truncate(bytes.len() - 6 - 4);
    bytes.extend_from_slice(&88i32.to_le_bytes());
    let end = bytes.len();
    for counter in [1, 6, 7, 8, 9] {
        bytes.truncate(end);
        for i in 0..11u64 {
            bytes.extend_from_slice(&(if i == counter { 1u64 << 41 } else { 0 }).to_le_bytes());
        }
        let e = decode_environment(&bytes, &DecodeLimits::default()).unwrap_err().to_string();
        assert!(e.contains("DWA"), "{e}");
    }
}
