//! `tonemap` and `info`.

use crate::lab::{Lab, plane, triangle};

#[test]
fn developing_later_is_the_same_as_at_once() {
    let lab = Lab::new();
    lab.ok("render --size 24x24 --spp 3 --bits 32 -o light.exr");
    for (n, develop) in [
        "",
        "--curve agx",
        "--curve aces --exposure 1.5",
        "--curve aces-fitted",
        "--curve reinhard --bits 16",
        "--curve none --exposure -1",
        "--linear",
    ]
    .into_iter()
    .enumerate()
    {
        lab.ok(&format!("render --size 24x24 --spp 3 {develop} -o now{n}.png"));
        lab.ok(&format!("tonemap light.exr {develop} -o later{n}.png"));
        assert_eq!(lab.image(&format!("now{n}.png")), lab.image(&format!("later{n}.png")), "{develop}");
        if n > 0 {
            assert_ne!(lab.image(&format!("now{n}.png")), lab.image("now0.png"), "{develop} does nothing");
        }
    }
    // With alpha, too.
    lab.ok("render --size 24x24 --spp 3 --bits 32 --transparent -o t.exr");
    lab.ok("render --size 24x24 --spp 3 --transparent -o now.png");
    lab.ok("tonemap t.exr -o later.png");
    assert_eq!(lab.image("now.png"), lab.image("later.png"));
}

#[test]
fn exposure_of_light_and_layers() {
    let lab = Lab::new();
    lab.ok("render --size 12x12 --spp 2 --bits 32 --passes albedo,depth -o l.exr");
    lab.ok("tonemap l.exr --exposure 1 --bits 32 -o bright.exr");
    let (a, b) = (plane(&lab.exr("l.exr"), "", "G"), plane(&lab.exr("bright.exr"), "", "G"));
    assert!(a.iter().zip(&b).all(|(a, b)| (a * 2.0 - b).abs() <= a * 1e-6));
    lab.ok("tonemap l.exr --layer albedo --bits 32 -o albedo.exr");
    assert_eq!(plane(&lab.exr("l.exr"), "albedo", "R"), plane(&lab.exr("albedo.exr"), "", "R"));
    lab.ok("tonemap l.exr --layer depth -o depth.png");
    lab.run("tonemap l.exr --layer gloss -o a.png").ends_with(2).says(&["gloss", "albedo", "depth"]);
    lab.ok("render --size 12x12 --spp 2 -o l.hdr");
    let run = lab.ok("tonemap l.hdr -o hdr.png");
    assert!(run.out.contains("12 × 12"), "{}", run.out);
    assert_eq!(lab.ok("tonemap l.hdr -o hdr.png --quiet").out, "");
}

#[test]
fn info_tells_what_a_file_holds() {
    let lab = Lab::new();
    lab.write(
        "sign.gltf",
        triangle(r#","extensionsUsed":["KHR_materials_unlit","KHR_xmp","VENDOR_unheard"],"animations":[]"#)
            .replace(r#","animations":[]"#, ""),
    );
    let text = lab.ok("info sign.gltf").out;
    for part in
        ["sign.gltf", "glTF 2.0", "triangles", "red", "double-sided", "front", "28.6°", "VENDOR_unheard"]
    {
        assert!(text.contains(part), "{part} is not in:\n{text}");
    }
    let support = |name: &str| text.lines().find(|l| l.contains(name)).unwrap_or_default().to_string();
    assert!(support("KHR_materials_unlit").contains("supported"));
    assert!(support("VENDOR_unheard").contains("ignored"), "{text}");
    let v: serde_json::Value = serde_json::from_str(&lab.ok("info sign.gltf --json").out).unwrap();
    assert_eq!(v["info"]["counts"]["triangles"], 1);
    assert_eq!(v["info"]["cameras"][0]["name"], "front");
    let helmet = lab.ok("info").out;
    for part in ["built-in helmet", "visor", "shell", "strap", "rim", "textures"] {
        assert!(helmet.contains(part), "{part} is not in:\n{helmet}");
    }
}
