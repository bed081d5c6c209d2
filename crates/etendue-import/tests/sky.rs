//! The sky and the metadata that a glTF file brings along.
mod common;

use common::Model;
use etendue_image::{Image, PictureFormat, Pixels, WriteOptions, encode_picture};
use etendue_import::{ExportOptions, ImportOptions, ModelFile, export, import_bytes};
use etendue_scene::Environment;
use serde_json::json;
use std::f32::consts::TAU;
use std::sync::Arc;

/// What an eye in the cube sees on each face, s to the right and t down, −1..1 (`EXT_lights_image_based`: the faces of graphics processors,
/// flipped about their vertical axes).
const SEEN: [fn(f32, f32) -> [f32; 3]; 6] = [
    |s, t| [1.0, -t, s],
    |s, t| [-1.0, -t, -s],
    |s, t| [-s, 1.0, t],
    |s, t| [-s, -1.0, -t],
    |s, t| [-s, -t, 1.0],
    |s, t| [s, -t, -1.0],
];

/// Light that is its direction, between 0 and 4.
fn light(d: [f32; 3]) -> [f32; 3] {
    let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
    d.map(|v| 2.0 + 2.0 * v / length)
}

/// A model with a sky of six faces as RGBD, on the scene if `used`.
fn model(n: u32, rotation: [f32; 4], used: bool) -> Model {
    let mut m = Model::new();
    let mut images = Vec::new();
    for face in SEEN {
        let c = |i: u32| (2 * i + 1) as f32 / n as f32 - 1.0;
        let mut pixels = Vec::new();
        for i in 0..n * n {
            let l = light(face(c(i % n), c(i / n)));
            // D is a whole number of 255ths: colours times D stay below 1.
            let d = (255.0 / l.iter().copied().fold(1.0, f32::max)).floor();
            pixels.extend(l.map(|v| (etendue_color::srgb_encode(v * d / 255.0) * 255.0).round() as u8));
            pixels.push(d as u8);
        }
        let image = Image { width: n, height: n, channels: 4, pixels: Pixels::U8(pixels) };
        let mut file = Vec::new();
        encode_picture(&mut file, PictureFormat::Png, &image, &WriteOptions::default()).unwrap();
        let view = m.view(&file);
        images.push(m.push("images", json!({ "bufferView": view, "mimeType": "image/png" })));
    }
    let coefficients = vec![[0.5; 3]; 9];
    m.json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    m.json["extensions"]["EXT_lights_image_based"] = json!({ "lights": [{
        "rotation": rotation, "intensity": 2.0, "irradianceCoefficients": coefficients,
        "specularImageSize": n, "specularImages": [images],
    }] });
    m.json["scenes"] = json!([{ "extensions": { "EXT_lights_image_based": { "light": 0 } } }]);
    if !used {
        m.json["scenes"] = json!([{}]);
    }
    m.json["scene"] = json!(0);
    m
}

#[test]
fn a_sky_of_the_file_shines_from_where_it_says() {
    // A quarter about +Y: what was at +X comes from −Z.
    let quarter = [0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    for (rotation, turn) in
        [([0.0, 0.0, 0.0, 1.0], (|d| d) as fn([f32; 3]) -> [f32; 3]), (quarter, |[x, y, z]| [-z, y, x])]
    {
        let imported = model(16, rotation, true).import();
        let Environment::LatLong { image, rotation, intensity } = &imported.scene.environment else {
            panic!("no sky: {:?}", imported.warnings)
        };
        assert_eq!((image.width, image.height, *rotation, *intensity), (64, 32, 0.0, 2.0));
        let mut worst = 0.0f32;
        for i in 0..64 * 32u32 {
            let (x, y) = (i % 64, i / 64);
            let (phi, theta) = (TAU * ((x as f32 + 0.5) / 64.0 - 0.5), 0.5 * TAU * (y as f32 + 0.5) / 32.0);
            let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            for (c, want) in light(turn(d)).into_iter().enumerate() {
                worst = worst.max((image.sample(x, y, c as u8) - want).abs());
            }
        }
        println!("worst {worst}");
        assert!(worst < 0.1, "{worst}");
    }
    assert!(matches!(model(4, quarter, false).import().scene.environment, Environment::Constant(_)));
}

#[test]
fn a_sky_that_is_broken_is_a_warning() {
    let mut m = model(4, [0.0, 0.0, 0.0, 1.0], true);
    let other = common::png();
    let view = m.view(&other);
    m.json["images"][2]["bufferView"] = json!(view);
    let imported = m.import();
    assert!(common::warned(&imported, "the sky cannot be shown"), "{:?}", imported.warnings);
    m.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = json!(3);
    assert!(m.error().contains("image-based light 3 does not exist"), "{}", m.error());
}

#[test]
fn metadata_are_kept() {
    let mut m = Model::new();
    let packet = json!({ "@context": { "dc": "http://purl.org/dc/elements/1.1/" }, "dc:title": { "@value": "Chair" } });
    m.json["extensionsUsed"] = json!(["KHR_xmp_json_ld"]);
    m.json["extensions"] = json!({ "KHR_xmp_json_ld": { "packets": [{}, packet] } });
    m.json["asset"]["extensions"] = json!({ "KHR_xmp_json_ld": { "packet": 1 } });
    m.json["nodes"] = json!([{ "extensions": { "KHR_xmp_json_ld": { "packet": 0 } } }]);
    m.json["scenes"] = json!([{ "nodes": [0] }]);
    let imported = m.import();
    assert!(!common::warned(&imported, "xmp"), "{:?}", imported.warnings);
    assert_eq!((imported.info.xmp.len(), imported.info.xmp_of_asset), (2, Some(1)));
    let options =
        ExportOptions { xmp: imported.info.xmp.clone(), xmp_of_asset: Some(1), ..Default::default() };
    let file = export(&imported.scene, &[], &options).unwrap();
    let again = import_bytes(&file.bytes, "a.glb", &Default::default()).unwrap().info;
    assert_eq!((again.xmp, again.xmp_of_asset), (imported.info.xmp, Some(1)));
}

/// Brightness and rotation of a sky that an animation changes are those of a sky that has them; the pictures are read once.
#[test]
fn a_sky_moves() {
    let turned = |turns: f32| {
        let (sin, cos) = (turns * TAU / 2.0).sin_cos();
        [0.0, sin, 0.0, cos]
    };
    let mut m = model(8, turned(0.0), true);
    let input = m.floats(&[0.0, 2.0], "SCALAR");
    let rotation = m.floats(&[turned(0.0), turned(0.25)].concat(), "VEC4");
    let intensity = m.floats(&[2.0, 6.0], "SCALAR");
    let target = |what: &str| {
        let pointer = format!("/extensions/EXT_lights_image_based/lights/0/{what}");
        json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}})
    };
    m.json["animations"] = json!([{
        "channels": [
            {"sampler": 0, "target": target("rotation")},
            {"sampler": 1, "target": target("intensity")}
        ],
        "samplers": [{"input": input, "output": rotation}, {"input": input, "output": intensity}]
    }]);
    let bytes = m.glb();
    let file = ModelFile::from_bytes(&bytes, "sky.glb", &ImportOptions::default());
    let moving = file.open().unwrap();
    let sky = |e: &Environment| match e {
        Environment::LatLong { image, rotation, intensity } => (image.clone(), *rotation, *intensity),
        e => panic!("{e:?}"),
    };
    let mut seen = Vec::new();
    for (seconds, part) in [(0.0, 0.0), (0.5, 0.25), (2.0, 1.0), (2.0, 1.0)] {
        let now = moving.at(Some(seconds)).unwrap();
        assert!(now.warnings.is_empty(), "{:?}", now.warnings);
        let (image, rotation, intensity) = sky(&now.scene.environment);
        let alone = model(8, turned(0.25 * part), true).import();
        let (expected, ..) = sky(&alone.scene.environment);
        assert_eq!((rotation, intensity), (0.0, 2.0 + 4.0 * part));
        let worst = (0..image.width * image.height * 3)
            .map(|k| (k / 3 % image.width, k / 3 / image.width, (k % 3) as u8))
            .map(|(x, y, c)| (image.sample(x, y, c) - expected.sample(x, y, c)).abs());
        assert!(worst.fold(0.0, f32::max) < 1e-3, "at {seconds} s");
        seen.push(image);
    }
    assert!(Arc::ptr_eq(&seen[2], &seen[3]), "nothing changed");
    assert!(seen[0].sample(0, 8, 0) != seen[2].sample(0, 8, 0));
}
