//! Textures of `KHR_texture_basisu`: the picture of the plain variant, what `info` says, warnings that are true.
mod common;
use common::*;
use etendue_image::Pixels;
use etendue_import::{ImportOptions, Support, import, support};
use serde_json::json;
use std::path::Path;

/// The reference encoder's files of `etendue-image`'s tests.
fn data(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../etendue-image/tests/data");
    std::fs::read(Path::new(folder).join(name)).unwrap()
}

/// A triangle with a base colour texture: a picture, or a KTX2 file under the extension.
fn textured(picture: &[u8], ktx2: bool) -> Model {
    let mut m = with(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    m.json["images"][0] = json!({"uri": data_uri(picture)});
    if ktx2 {
        m.json["images"][0] = json!({"bufferView": m.view(picture), "mimeType": "image/ktx2"});
        m.json["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
        m.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    }
    m
}

#[test]
fn a_compressed_texture_is_the_plain_one_within_its_loss() {
    assert_eq!(support("KHR_texture_basisu"), Some(Support::Full));
    let plain = textured(&data("source.png"), false).import().scene;
    for (name, format, least) in [("etc1s_rgba", "KTX2 ETC1S", 30.0), ("uastc_rgba", "KTX2 UASTC", 40.0)] {
        let i = textured(&data(&format!("{name}.ktx2")), true).import();
        assert!(i.warnings.is_empty(), "{:?}", i.warnings);
        let info = &i.info.images[0];
        assert_eq!((info.format, info.mips, info.width, info.bits), (format, 1, 46, 8));
        let image = &i.scene.images[0];
        let floats = |i: &etendue_image::Image| -> Vec<f32> {
            let Pixels::U8(p) = &i.pixels else { panic!() };
            p.iter().map(|&v| f32::from(v) / 255.0).collect()
        };
        assert_eq!(image.channels, plain.images[0].channels);
        let (a, b) = (floats(image), floats(&plain.images[0]));
        let mse = a.iter().zip(&b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64;
        let db = -10.0 * mse.log10();
        println!("{name}: {db:.1} dB");
        assert!(db > least, "{name}: {db}");
    }
}

#[test]
fn an_encoding_that_contradicts_its_use_is_named() {
    // Linear, but a base colour; with mips.
    let i = textured(&data("uastc_rgb_zstd_mips.ktx2"), true).import();
    assert!(
        warned(&i, "/images/0: says that it is linear, but a material has it for colour"),
        "{:?}",
        i.warnings
    );
    assert_eq!(i.info.images[0].mips, 6);
    // sRGB, but normals.
    let mut m = textured(&data("uastc_rgba.ktx2"), true);
    m.json["materials"][0] = json!({"normalTexture": {"index": 0}});
    assert!(warned(&m.import(), "says that it is sRGB, but a material has it for data"));
}

#[test]
fn damaged_and_unknown_textures_say_which() {
    let file = data("uastc_rgba.ktx2");
    let e = textured(&file[..file.len() - 9], true).error();
    assert!(e.contains("/images/0") && e.contains("damaged KTX2 data"), "{e}");
    let mut bc7 = file;
    let dfd = u32::from_le_bytes(bc7[48..52].try_into().unwrap()) as usize;
    bc7[dfd + 12] = 134;
    let e = textured(&bc7, true).error();
    assert!(e.contains("/images/0: requires KTX2 textures with texels of BC7"), "{e}");
}

/// A model of another program whose three textures are ETC1S.
#[test]
fn balloon() {
    let file = "../../../shared/assets/models/cesium-BalloonKTX2/CesiumBalloonKTX2.glb";
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    if !file.exists() {
        println!("skipped: no {}", file.display());
        return;
    }
    let i = import(&file, &ImportOptions::default()).unwrap();
    println!("{:?}", i.warnings);
    let used: Vec<_> = i.info.images.iter().map(|i| (i.format, i.width, i.height, i.channels)).collect();
    println!("{used:?}");
    assert!(used.iter().all(|u| u.0 == "KTX2 ETC1S" && u.1 >= 64));
}
