//! What `etendue render` writes.

use crate::lab::{Lab, plane, samples, triangle};
use etendue::image::{Pixels, read_environment};

/// The text chunks of a PNG.
fn texts(png: &[u8]) -> Vec<(String, String)> {
    let mut out = Vec::new();
    let mut at = 8;
    while at + 12 <= png.len() {
        let n = u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        let (kind, data) = (&png[at + 4..at + 8], &png[at + 8..at + 8 + n]);
        if kind == b"tEXt" || kind == b"iTXt" {
            let split = data.iter().position(|b| *b == 0).unwrap();
            let value = data[split..].iter().copied().filter(|b| *b != 0).collect();
            out.push((String::from_utf8_lossy(&data[..split]).into(), String::from_utf8(value).unwrap()));
        }
        at += n + 12;
    }
    out
}

#[test]
fn without_a_model_it_is_the_helmet_and_says_how_it_was_made() {
    let lab = Lab::new();
    let run = lab.ok("render --size 32x24 --spp 3 --seed 5");
    assert_eq!(lab.files(), ["etendue.png"]);
    assert!(run.out.contains("etendue.png: 32 × 24, 3 samples"), "{}", run.out);
    assert_eq!(run.err, "");
    let image = lab.image("etendue.png");
    assert_eq!((image.width, image.height), (32, 24));
    // A helmet in the middle, not one colour.
    let p = samples(&image);
    let n = image.channels as usize;
    let distinct: std::collections::BTreeSet<_> = p.chunks(n).map(|c| c[0] as u32).collect();
    assert!(distinct.len() > 20, "{distinct:?}");
    let texts = texts(&lab.bytes("etendue.png"));
    let get = |k: &str| &texts.iter().find(|t| t.0 == k).unwrap_or_else(|| panic!("{k} in {texts:?}")).1;
    assert!(get("Command").ends_with("etendue render --size 32x24 --spp 3 --seed 5"), "{}", get("Command"));
    assert_eq!((get("Seed").as_str(), get("Samples").as_str()), ("5", "3"));
    assert_eq!(get("Version"), env!("CARGO_PKG_VERSION"));
    assert_eq!(get("Software"), concat!("etendue ", env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_format_by_its_extension() {
    let lab = Lab::new();
    for name in ["a.png", "a.PNG", "a.jpg", "a.jpeg", "a.webp"] {
        lab.ok(&format!("render --size 16x8 --spp 1 -o {name}"));
        let i = lab.image(name);
        assert_eq!((i.width, i.height, matches!(i.pixels, Pixels::U8(_))), (16, 8, true), "{name}");
    }
    lab.ok("render --size 16x8 --spp 1 --bits 16 -o deep.png");
    assert!(matches!(lab.image("deep.png").pixels, Pixels::U16(_)));
    lab.ok("render --size 16x8 --spp 1 -o a.hdr");
    lab.ok("render --size 16x8 --spp 1 -o a.exr");
    lab.ok("render --size 16x8 --spp 1 --bits 32 -o b.exr");
    // The two files of light hold the same, up to their precision: RGBE eight bits of the largest channel, half eleven.
    let float = lab.exr("b.exr");
    let planes = ["R", "G", "B"].map(|c| plane(&float, "", c));
    let hdr = read_environment(&lab.path("a.hdr")).unwrap().image;
    let half = lab.exr("a.exr");
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        for (i, h) in plane(&half, "", name).iter().enumerate() {
            let pixel = planes.each_ref().map(|p| p[i]);
            let (v, largest) = (pixel[c], pixel.into_iter().fold(0.0, f32::max));
            assert!((h - v).abs() <= v * 5e-4 + 1e-7, "half {h} {v}");
            let rgbe = hdr.sample(i as u32 % 16, i as u32 / 16, c as u8);
            assert!((rgbe - v).abs() <= largest / 100.0, "rgbe {rgbe} {v}");
        }
    }
    // All say how they were made.
    for name in lab.files() {
        let bytes = lab.bytes(&name);
        let said = bytes.windows(14).any(|w| w == b"etendue render");
        assert!(said, "{name} does not hold its command");
    }
}

#[test]
fn all_passes_in_one_layered_file() {
    let lab = Lab::new();
    lab.ok("render --size 24x24 --spp 4 --passes all --bits 32 -o all.exr");
    lab.ok("render --size 24x24 --spp 4 --bits 32 -o beauty.exr");
    let (all, beauty) = (lab.exr("all.exr"), lab.exr("beauty.exr"));
    for c in ["R", "G", "B"] {
        let b = plane(&beauty, "", c);
        // Passes do not change the picture.
        assert_eq!(plane(&all, "", c), b);
        // The light paths are divided without loss: direct, indirect, what shines by itself, and the sky.
        let parts = ["direct", "indirect", "emission", "environment"].map(|l| plane(&all, l, c));
        for (i, whole) in b.iter().enumerate() {
            let sum: f32 = parts.iter().map(|p| p[i]).sum();
            assert!((sum - whole).abs() <= 1e-4 * whole.max(1.0), "{c} of pixel {i}: {sum} of {whole}");
        }
    }
    for (layer, channels) in [
        ("albedo", "RGB"),
        ("normal", "XYZ"),
        ("position", "XYZ"),
        ("depth", "Z"),
        ("uv", "UV"),
        ("diffuse", "RGB"),
        ("specular", "RGB"),
        ("error", "Y"),
        ("CryptoObject00", "RGBA"),
        ("CryptoMaterial02", "RGBA"),
    ] {
        for c in channels.chars() {
            let p = plane(&all, layer, &c.to_string());
            assert!(p.iter().all(|v| v.is_finite()), "{layer}.{c}");
        }
    }
    // The middle pixel sees the visor: a normal of unit length, a distance, whole coverage by ids.
    let middle = 12 * 24 + 12;
    let n = ["X", "Y", "Z"].map(|c| plane(&all, "normal", c)[middle]);
    assert!((n.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 0.1, "{n:?}");
    let depth = plane(&all, "depth", "Z")[middle];
    assert!((0.2..3.0).contains(&depth), "{depth}");
    let manifest = all.metadata.entries.iter().any(|(k, v)| k.ends_with("/manifest") && v.contains("visor"));
    assert!(manifest, "{:?}", all.metadata);
    assert_eq!(all.metadata.get("Samples"), Some("4"));
}

#[test]
fn transparent_leaves_the_sky_out() {
    let lab = Lab::new();
    for name in ["t.png", "t.webp"] {
        lab.ok(&format!("render --size 32x32 --spp 4 --transparent -o {name}"));
        let i = lab.image(name);
        assert_eq!(i.channels, 4, "{name}");
        assert_eq!(i.sample(0, 0, 3), 0.0, "the corner is sky");
        assert_eq!(i.sample(16, 16, 3), 1.0, "the middle is helmet");
    }
    lab.ok("render --size 32x32 --spp 4 --transparent -o t.exr");
    let exr = lab.exr("t.exr");
    let (alpha, red) = (plane(&exr, "", "A"), plane(&exr, "", "R"));
    assert_eq!((alpha[0], red[0]), (0.0, 0.0));
    assert_eq!(alpha[16 * 32 + 16], 1.0);
    // The surface is lit as before: alpha leaves the inside of the picture alone.
    lab.ok("render --size 32x32 --spp 4 -o o.exr");
    let opaque = plane(&lab.exr("o.exr"), "", "R");
    assert_eq!(red[16 * 32 + 16], opaque[16 * 32 + 16]);
}

#[test]
fn json_is_one_line_of_facts() {
    let lab = Lab::new();
    let run = lab.ok("render --size 16x16 --spp 4 --seed 3 -j 2 --json -o j.png --film j.film");
    assert_eq!(run.out.lines().count(), 1);
    assert_eq!(run.err, "");
    let v: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(v["output"], "j.png");
    assert_eq!(v["film"], "j.film");
    assert_eq!((&v["width"], &v["height"], &v["samples"]), (&16.into(), &16.into(), &4.into()));
    assert_eq!((&v["seed"], &v["threads"], &v["finished"]), (&3.into(), &2.into(), &true.into()));
    assert_eq!((&v["rejected_samples"], &v["warnings"]), (&0.into(), &serde_json::json!([])));
    assert!(v["triangles"].as_u64().unwrap() > 10_000);
    assert!(v["rays"]["closest"].as_u64().unwrap() >= 16 * 16 * 4);
    assert!(v["seconds"]["total"].as_f64().unwrap() >= v["seconds"]["render"].as_f64().unwrap());
    assert!(v["rays_per_second"].as_f64().unwrap() > 1000.0);
    let error = v["relative_error"].as_f64().unwrap();
    assert!(error > 0.0 && error < 10.0, "{error}");
    let mean: Vec<f64> = v["mean"].as_array().unwrap().iter().map(|m| m.as_f64().unwrap()).collect();
    assert!(mean.len() == 3 && mean.iter().all(|m| (0.001..10.0).contains(m)), "{mean:?}");
    assert_eq!(v["picture"].as_str().unwrap().len(), 16);
    assert_eq!(lab.ok("render --size 8x8 --spp 1 --quiet").out, "");
}

#[test]
fn the_model_fills_the_picture() {
    let lab = Lab::new();
    for (size, w, h) in [("64x64", 64, 64), ("96x48", 96, 48), ("40x80", 40, 80)] {
        lab.ok(&format!("render --size {size} --spp 4 --transparent --filter box -o f.exr"));
        let alpha = plane(&lab.exr("f.exr"), "", "A");
        let seen = |x: usize, y: usize| alpha[y * w + x] > 0.25;
        let columns: Vec<_> = (0..w).filter(|x| (0..h).any(|y| seen(*x, y))).collect();
        let rows: Vec<_> = (0..h).filter(|y| (0..w).any(|x| seen(x, *y))).collect();
        let span = |v: &[usize]| (v[v.len() - 1] + 1 - v[0]) as f32;
        let filled = (span(&columns) / w as f32).max(span(&rows) / h as f32);
        assert!((0.82..=0.92).contains(&filled), "{size}: {filled}");
        // In the middle of the side that it fills.
        let (v, side) =
            if span(&columns) / w as f32 > span(&rows) / h as f32 { (&columns, w) } else { (&rows, h) };
        let (before, after) = (v[0] as i32, (side - 1 - v[v.len() - 1]) as i32);
        assert!((before - after).abs() <= 2 + side as i32 / 40, "{size}: {before} and {after}");
    }
}

#[test]
fn cameras_of_the_file_and_of_the_line_agree() {
    let lab = Lab::new();
    lab.write("sign.gltf", triangle(""));
    let sky = "--env 1,1,1 --size 20x20 --spp 4 --bits 32";
    lab.ok(&format!("render sign.gltf {sky} --camera 0 -o number.exr"));
    lab.ok(&format!("render sign.gltf {sky} --camera front -o name.exr"));
    lab.ok(&format!("render sign.gltf {sky} --eye 0,0,3 --target 0,0,0 --vfov 28.64789 -o eye.exr"));
    lab.ok(&format!("render sign.gltf {sky} --eye 0,0,-3 --target 0,0,0 --vfov 28.64789 -o behind.exr"));
    let red = |name: &str| plane(&lab.exr(name), "", "G");
    assert_eq!(red("number.exr"), red("name.exr"));
    let worst = red("number.exr").iter().zip(red("eye.exr")).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 0.02, "{worst}");
    // The picture's middle is the sign, its upper corners the sky; a triangle, point up, is as high as it is wide.
    let g = red("number.exr");
    assert!(g[10 * 20 + 10] < 0.2 && (g[0] - 1.0).abs() < 1e-3, "{} {}", g[10 * 20 + 10], g[0]);
    // Twice the angle: the sign takes less of the picture.
    lab.ok(&format!("render sign.gltf {sky} --camera 0 --vfov 60 -o wide.exr"));
    let sky_of = |name: &str| red(name).iter().filter(|v| (**v - 1.0).abs() < 1e-3).count();
    assert!(sky_of("wide.exr") > sky_of("number.exr"));
    // From above, without a word about what is up.
    lab.ok(&format!("render sign.gltf {sky} --eye 0,4,0 --target 0,0,0 -o above.exr"));
    lab.run(&format!("render sign.gltf {sky} --camera 1")).ends_with(2).says(&["no camera 1", "0 (front)"]);
    lab.run(&format!("render sign.gltf {sky} --eye 1,1,1 --target 1,1,1")).ends_with(2).says(&["same point"]);
    lab.run(&format!("render sign.gltf {sky} --eye 0,0,3 --target 0,0,0 --up 0,0,2"))
        .ends_with(2)
        .says(&["--up"]);
    lab.run("render --camera 0").ends_with(2).says(&["the file has none"]);
}

#[test]
fn variants_of_the_model() {
    let lab = Lab::new();
    let names = r#","extensions":{"KHR_materials_variants":{"variants":[{"name":"warm"},{"name":"sea"}]}}"#;
    let mapping = r#""material":1,"extensions":{"KHR_materials_variants":{"mappings":[{"material":0,"variants":[1]}]}}"#;
    let blue = r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0,0,1,1],"metallicFactor":0},"doubleSided":true},"#;
    // Blue stands first in the file and is material 0; red, the model's own, is material 1.
    let text = triangle(names).replace(r#""material":0"#, mapping).replace(r#""materials":["#, blue);
    lab.write("sign.gltf", text);
    let render = "render sign.gltf --env 1,1,1 --size 20x20 --spp 4 --bits 32 --camera 0 -o sign.exr";
    let is_blue = |options: &str| {
        lab.ok(&format!("{render} {options}"));
        let image = lab.exr("sign.exr");
        let [r, b] = ["R", "B"].map(|c| plane(&image, "", c)[10 * 20 + 10]);
        assert!(r.max(b) > 0.5 && r.min(b) < 0.2, "{r} {b}");
        b > r
    };
    assert!(!is_blue("") && !is_blue("--variant warm") && is_blue("--variant sea --film sea.film"));
    // The film knows its variant.
    lab.ok("render --resume sea.film --spp 5 -o resumed.exr");
    assert_eq!(lab.film("sea.film").0.samples(), 5);
    lab.run("render --resume sea.film --spp 6 --variant warm")
        .ends_with(1)
        .says(&["--variant", "another picture"]);
    lab.run(&format!("{render} --variant noon"))
        .ends_with(2)
        .says(&["no variant \"noon\"", "\"warm\", \"sea\""]);
    lab.run("render --variant sea").ends_with(2).says(&["the model has no variants"]);
    let info = lab.ok("info sign.gltf").out;
    assert!(
        info.contains("variants\n") && info.contains("sea") && info.contains("on 1 instance\n"),
        "{info}"
    );
    let v: serde_json::Value = serde_json::from_str(&lab.ok("info sign.gltf --json").out).unwrap();
    assert_eq!(v["info"]["variants"], serde_json::json!(["warm", "sea"]));
}
