//! `bake`: folders, files, skies that are not as they should be, outputs that cannot be written.

use crate::lab::{Lab, plane};
use serde_json::Value;

/// Small, so that a bake takes a moment.
const QUICK: &str = "--size 16 --samples 16 --dfg-size 8 --dfg-samples 64 --irradiance-size 4";

/// A Radiance file of flat pixels.
fn hdr(width: usize, height: usize, pixel: impl Fn(usize, usize) -> [u8; 4]) -> Vec<u8> {
    let mut b = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for i in 0..width * height {
        b.extend(pixel(i % width, i / width));
    }
    b
}

/// 128 · 2^(129 − 136) = 1.
const ONE: [u8; 4] = [128, 128, 128, 129];

#[test]
fn a_folder_says_what_is_what() {
    let lab = Lab::new();
    lab.ok(&format!("bake 1,0.5,0.25 -o white/ {QUICK}"));
    let mut names: Vec<_> = std::fs::read_dir(lab.path("white"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["bake.json", "dfg.exr", "irradiance.ktx2", "specular.ktx2"]);
    let json: Value = serde_json::from_slice(&lab.bytes("white/bake.json")).unwrap();
    let number = |v: &Value| v.as_f64().unwrap();
    // A white sky: only the first coefficient, √(4π); Unity's constant term is the sky itself.
    let c = &json["sh9"]["radiance"];
    assert!((number(&c[0][0]) - (4.0 * std::f64::consts::PI).sqrt()).abs() < 1e-5);
    assert!((1..9).all(|i| number(&c[i][0]).abs() < 1e-5));
    for (name, want) in [("unity_SHAr", 1.0), ("unity_SHAg", 0.5), ("unity_SHAb", 0.25)] {
        assert!((number(&json["sh9"]["unity"][name][3]) - want).abs() < 1e-5, "{name}");
    }
    assert_eq!(json["specular"]["files"][0], "specular.ktx2");
    assert_eq!(json["specular"]["roughness"].as_array().unwrap().len(), 2);
    assert!(json["dfg"]["layout"].as_str().unwrap().contains("F0"));
    // The table: a mirror seen from above reflects F0 whole.
    let dfg = lab.exr("white/dfg.exr");
    assert!((plane(&dfg, "", "R")[7] - 1.0).abs() < 0.01 && plane(&dfg, "", "G")[7].abs() < 0.01);
    // The same again gives the same bytes, over the old files.
    let before = lab.bytes("white/specular.ktx2");
    lab.ok(&format!("bake 1,0.5,0.25 -o white {QUICK} -j 1 -q"));
    assert_eq!(before, lab.bytes("white/specular.ktx2"));
}

#[test]
fn single_files_by_extension_and_format() {
    let lab = Lab::new();
    lab.ok(&format!("bake studio -o a.ktx2 {QUICK} --encoding bc6h --mapping notes -q"));
    assert_eq!(&lab.bytes("a.ktx2")[1..7], b"KTX 20");
    lab.ok(&format!("bake studio -o a.dds {QUICK} --encoding rgb9e5 --kernel lobe -q"));
    assert_eq!(&lab.bytes("a.dds")[..4], b"DDS ");
    lab.ok(&format!("bake 2,2,2 -o a.exr {QUICK} -q"));
    let top = lab.exr("a.exr");
    assert_eq!((top.width, top.height), (16, 96));
    assert!(plane(&lab.exr("a-mip1.exr"), "", "R").iter().all(|v| (v - 2.0).abs() < 2e-3));
    lab.ok(&format!("bake 2,2,2 -o raw.bin --format hdr {QUICK} -q"));
    assert!(lab.bytes("raw.bin").starts_with(b"#?RADIANCE"));
    lab.ok("bake --dfg -o table.exr --dfg-size 8 --dfg-samples 0 --dfg-layout multiscatter -q");
    let table = lab.exr("table.exr");
    assert!((plane(&table, "", "G")[7] - 1.0).abs() < 1e-3, "E of a mirror");
    let run = lab.ok(&format!("bake 1,1,1 -o b.ktx2 {QUICK} --json"));
    let json: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(json["files"][0], "b.ktx2");
}

#[test]
fn odd_skies_have_a_clear_outcome() {
    let lab = Lab::new();
    lab.write("one.hdr", hdr(1, 1, |_, _| ONE));
    lab.ok(&format!("bake one.hdr -o one.exr {QUICK}")).says(&["one.hdr", "one pixel"]);
    assert!(plane(&lab.exr("one.exr"), "", "G").iter().all(|v| (v - 1.0).abs() < 1e-3));
    lab.write("square.hdr", hdr(4, 4, |_, _| ONE));
    lab.ok(&format!("bake square.hdr -o square.exr {QUICK}")).says(&["4 × 4", "2:1"]);
    lab.write("black.hdr", hdr(4, 2, |_, _| [0; 4]));
    lab.ok(&format!("bake black.hdr -o black/ {QUICK}")).says(&["black"]);
    // Exponent 255 is beyond half floats: what a file cannot hold is its brightest, never infinite.
    lab.write("bright.hdr", hdr(4, 2, |x, _| if x == 1 { [255, 255, 255, 255] } else { ONE }));
    lab.ok(&format!("bake bright.hdr -o bright.exr {QUICK}"));
    assert!(plane(&lab.exr("bright.exr"), "", "R").iter().all(|v| v.is_finite() && *v <= 65504.0));
    // NaN, negative and infinite pixels, which only OpenEXR has.
    let nan = [f32::NAN, -3.0, f32::INFINITY, 1.0, 1.0, 1.0, 1.0, 1.0];
    let channel = |name: &str| (name.to_string(), etendue::image::ChannelData::F32(nan.to_vec()));
    let layer =
        etendue::image::Layer { name: String::new(), channels: ["R", "G", "B"].map(channel).to_vec() };
    etendue::image::write_layers_exr(&lab.path("nan.exr"), &[layer], (4, 2), &Default::default(), false)
        .unwrap();
    lab.ok(&format!("bake nan.exr -o nan-out.exr {QUICK}")).says(&["3 pixels", "repaired"]);
    // What was baked as a cube is a sky again.
    lab.ok(&format!("bake nan-out.exr -o again.exr {QUICK}")).says(&["cube map", "64 × 32"]);
    assert!(plane(&lab.exr("nan-out.exr"), "", "R").iter().all(|v| v.is_finite() && *v >= 0.0));
}

#[test]
fn what_cannot_be_done_leaves_nothing() {
    let lab = Lab::new();
    lab.write("noise.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9000 +X 18000\nshort");
    for (line, code, parts) in [
        ("bake", 2, &["SKY", "--output"][..]),
        ("bake missing.hdr -o a.ktx2", 1, &["missing.hdr"]),
        ("bake noise.hdr -o a.ktx2", 1, &["noise.hdr"]),
        ("bake -o a.ktx2 -- -1,0,0", 2, &["-1,0,0"]),
        ("bake 1,1,1 -o a.png", 2, &["a.png", ".ktx2"]),
        ("bake --dfg -o a.ktx2", 2, &["a.ktx2", ".exr"]),
        ("bake 1,1,1 -o a.ktx2 --size 100", 2, &["power of two"]),
        ("bake 1,1,1 -o a.ktx2 --encoding png", 2, &["rgb9e5"]),
        ("bake 1,1,1 -o a.ktx2 --window round", 2, &["lanczos"]),
        ("bake 1,1,1 -o nowhere/a.ktx2", 1, &["nowhere"]),
        ("bake 1,1,1 -o nowhere/deep/", 1, &["nowhere"]),
        ("bake 1,1,1 --dfg -o a.exr", 2, &["--dfg"]),
    ] {
        lab.run(line).ends_with(code).says(parts);
    }
    assert_eq!(lab.files(), ["noise.hdr"]);
    #[cfg(target_os = "linux")]
    {
        lab.run(&format!("bake 1,1,1 -o /dev/full --format ktx2 {QUICK}")).ends_with(1).says(&["/dev/full"]);
        // A folder in which one file cannot be written: what was new is taken away again.
        std::fs::create_dir_all(lab.path("half/dfg.exr")).unwrap();
        lab.run(&format!("bake 1,1,1 -o half {QUICK}")).ends_with(1).says(&["dfg.exr"]);
        let left: Vec<_> = std::fs::read_dir(lab.path("half")).unwrap().collect();
        assert_eq!(left.len(), 1, "{left:?}");
    }
}
