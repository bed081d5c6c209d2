//! Models of every format: rendered, described, checked, converted.

use crate::lab::{Lab, samples, triangle};

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n";

fn lab() -> Lab {
    let lab = Lab::new();
    lab.write("m.obj", OBJ);
    lab.write("m.mtl", "newmtl red\nKd 1 0 0\n");
    lab.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
    lab.write("odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nbend 1 2\nf 1 2 3\n");
    let (ply, stl) = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n",
    );
    lab.write("m.ply", ply);
    lab.write("m.stl", stl);
    lab.write("t.gltf", triangle(""));
    lab
}

#[test]
fn other_formats_just_work() {
    let lab = lab();
    for model in ["m.obj", "m.ply", "m.stl"] {
        lab.ok(&format!("render {model} --size 8x8 --spp 2 --env 1,1,1 -o {model}.png"));
        let info = lab.ok(&format!("info {model}")).out;
        assert!(info.contains("taken as metres") && info.contains("shown in 1 instances"), "{info}");
    }
    // Red, and not the grey of a plain surface.
    let picture = lab.image("m.obj.png");
    let (r, b) = (picture.sample(4, 4, 0), picture.sample(4, 4, 2));
    assert!(r > 4.0 * b, "{r} {b}");
}

#[test]
fn what_is_converted_looks_the_same() {
    let lab = lab();
    for model in ["m.obj", "t.gltf"] {
        for form in ["glb", "gltf"] {
            let run = lab.ok(&format!("convert {model} -o c.{form}"));
            assert!(run.out.contains("triangles in 1 meshes"), "{}", run.out);
            lab.ok(&format!("render {model} --size 12x12 --spp 4 --env 1,1,1 -o a.png"));
            lab.ok(&format!("render c.{form} --size 12x12 --spp 4 --env 1,1,1 -o b.png"));
            assert_eq!(lab.image("a.png"), lab.image("b.png"), "{model} {form}");
        }
    }
    lab.run("convert m.obj -o c.fbx").ends_with(2).says(&["c.fbx", ".glb"]);
    lab.run("convert none.obj -o c.glb").ends_with(1).says(&["none.obj"]);
    assert_eq!(lab.ok("convert m.obj -o c.glb --quiet").out, "");
}

fn text(lab: &Lab, name: &str) -> String {
    String::from_utf8(lab.bytes(name)).unwrap()
}

#[test]
fn gltf_keeps_what_no_scene_has() {
    let lab = lab();
    let moving = concat!(
        r#","animations":[{"name":"go","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],"#,
        r#""samplers":[{"input":0,"output":0}]}],"extras":{"note":1.50}"#
    );
    // A sampler of positions is no animation that could be shown, but one that can be kept.
    lab.write("a.gltf", triangle(moving));
    let run = lab.ok("convert a.gltf -o kept.gltf");
    assert!(run.out.contains("1 animation") && !run.err.contains("not written"), "{} {}", run.out, run.err);
    let kept = text(&lab, "kept.gltf");
    assert!(kept.contains(r#""name":"go""#) && kept.contains(r#""note":1.50"#), "{kept}");
    lab.ok("convert kept.gltf -o twice.gltf");
    assert_eq!(text(&lab, "twice.gltf"), kept);
    // A moment is a scene.
    lab.ok("convert t.gltf -o b.gltf --at 0");
    assert!(text(&lab, "b.gltf").contains("etendue"), "written by this program");
}

#[test]
fn limits_are_named_and_can_be_raised() {
    // The file itself has 805 bytes.
    let lab = lab();
    for command in ["info", "render", "check", "convert -o c.glb", "compare"] {
        let (command, rest) = command.split_once(' ').unwrap_or((command, ""));
        let run = lab.run(&format!("{command} t.gltf --max-memory 800 {rest}"));
        let said = run.out + &run.err;
        assert_ne!(run.code, Some(0), "{command}: {said}");
        assert!(said.contains("`memory_bytes`"), "{command}: {said}");
    }
    lab.run("info t.gltf --max-memory 800").ends_with(1).says(&["--max-memory SIZE raises"]);
    lab.run("info t.gltf --limit accessors=0").ends_with(1).says(&["/accessors", "--limit accessors=NUMBER"]);
    lab.run("info t.gltf --limit acessors=0").ends_with(2).says(&["did you mean accessors?"]);
    lab.run("info t.gltf --max-memory much").ends_with(2).says(&["4GiB"]);
    lab.ok("info t.gltf --max-memory 64GiB --limit image_dimension=100000");
}

#[test]
fn checking_ends_with_three_if_a_model_does_not_load() {
    let lab = lab();
    let run = lab.ok("check m.obj m.ply m.stl t.gltf");
    assert!(run.out.contains("4 ok, 0 with warnings, 0 with errors"), "{}", run.out);
    let run = lab.run("check m.obj bad.obj odd.obj none.glb").ends_with(3);
    assert!(run.out.contains("bad.obj: error: line 2: refers to position 3"), "{}", run.out);
    assert!(run.out.contains("odd.obj: warnings: line 4: `bend` is no statement"), "{}", run.out);
    assert!(run.out.contains("1 ok, 1 with warnings, 2 with errors"), "{}", run.out);
    lab.run("check odd.obj").ends_with(0);
    lab.run("check odd.obj --strict").ends_with(3);
    let json = lab.run("check --json m.obj bad.obj").ends_with(3).out;
    let v: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&v["files"][0]["verdict"], &v["files"][1]["verdict"]), (&"ok".into(), &"error".into()));
    assert_eq!((&v["files"][0]["triangles"], &v["errors"]), (&2.into(), &1.into()));
}

/// Drafts of extensions are named with the switch that reads them, and read with it, on the command line or by a scene file.
#[test]
fn drafts_are_asked_for() {
    let lab = Lab::new();
    let rough = |extra: &str| {
        triangle(extra).replace(
            r#""doubleSided":true"#,
            r#""doubleSided":true,"extensions":{"KHR_materials_diffuse_roughness":{"diffuseRoughnessFactor":1}}"#,
        )
    };
    lab.write("used.gltf", rough(r#","extensionsUsed":["KHR_materials_diffuse_roughness"]"#));
    let needed = r#","extensionsUsed":["KHR_materials_diffuse_roughness"],"extensionsRequired":["KHR_materials_diffuse_roughness"]"#;
    lab.write("needed.gltf", rough(needed));
    let out = lab.ok("info used.gltf").out;
    assert!(
        out.contains("a draft: ignored without --drafts") && out.contains("ignored without --drafts ("),
        "{out}"
    );
    let out = lab.ok("info --drafts used.gltf").out;
    assert!(
        out.contains("a draft: read") && out.contains("diffuseRoughness 1") && !out.contains("warnings"),
        "{out}"
    );
    lab.run("info needed.gltf").ends_with(1).says(&["KHR_materials_diffuse_roughness", "--drafts"]);
    lab.run("check --strict used.gltf").ends_with(3);
    lab.run("check --strict --drafts used.gltf needed.gltf").ends_with(0);
    lab.ok("convert --drafts used.gltf -o out.gltf");
    assert!(String::from_utf8(lab.bytes("out.gltf")).unwrap().contains("diffuseRoughnessFactor"));
    lab.write("s.toml", "[render]\ndrafts = true\n[[model]]\nfile = \"used.gltf\"\n");
    let picture =
        |line: &str| lab.ok(&format!("render {line} --camera 0 -s 16x16 -n 4 --env studio -o p.png"));
    let bytes = |line: &str| {
        picture(line);
        samples(&lab.image("p.png"))
    };
    let (off, on) = (bytes("used.gltf -q"), bytes("used.gltf --drafts -q"));
    assert_ne!(off, on);
    assert_eq!(on, bytes("s.toml -q"));
}

#[test]
fn a_sheet_shows_every_model_and_what_fails() {
    let lab = lab();
    let run = lab.run("sheet . -o s.png --cell 32 --columns 2 --rows 2 -n 2 --env 1,1,1").ends_with(3);
    assert!(run.out.contains("bad.obj: error: line 2: refers to position 3"), "{}", run.out);
    assert!(run.out.contains("4 ok, 1 with warnings, 1 with errors"), "{}", run.out);
    // Six models: four on the first page, two on the second, which is half as high.
    let (first, second) = (lab.image("s.png"), lab.image("s-2.png"));
    assert_eq!((first.width, first.height, second.height), (2 * 44 + 12, 2 * 80 + 12, 80 + 12));
    assert!(!lab.files().contains(&"s-3.png".to_string()));
    let at = |image: &etendue::image::Image, x, y| [0, 1, 2].map(|c| (image.sample(x, y, c) * 255.0) as u8);
    // In the order of names: bad.obj on pale red, then m.obj, which is red, m.ply and m.stl, odd.obj; t.gltf.
    assert_eq!(at(&first, 40, 40), [0xfb, 0xea, 0xea]);
    let [r, g, _] = at(&first, 56 + 16, 12 + 16);
    assert!(r > 2 * g, "{r} {g}");
    let [r, g, b] = at(&first, 12 + 14, 92 + 18);
    assert!(r == g && g == b && r > 0x80, "{r} {g} {b}");
    let [r, g, _] = at(&second, 56 + 16, 12 + 20);
    assert!(r > 2 * g, "{r} {g}");
    let json = lab.run("sheet m.obj odd.obj -o t.png --cell 32 -n 1 --integrator path --env 1,1,1 --json");
    let v: serde_json::Value = serde_json::from_str(&json.ends_with(0).out).unwrap();
    assert_eq!((&v["ok"], &v["warnings"], &v["pages"][0]), (&1.into(), &1.into(), &"t.png".into()));
    lab.run("sheet odd.obj -o t.png --cell 32 -n 1 --strict").ends_with(3);
    // Nothing is loaded and drawn in so little time.
    let run = lab.run("sheet m.obj -o t.png --cell 512 -n 4096 --env 1,1,1 --time 50ms").ends_with(3);
    assert!(run.out.contains("took longer than 0.05 s"), "{}", run.out);
    lab.run("sheet m.obj -o t.png --time 0s").ends_with(2).says(&["above 0"]);
    lab.run("sheet m.obj -o t.jpg").ends_with(2).says(&["t.jpg"]);
    std::fs::create_dir(lab.path("none")).unwrap();
    lab.run("sheet none -o t.png").ends_with(2).says(&["there is no model", "none"]);
    assert!(lab.ok("check --strict m.obj t.gltf m.ply m.stl").out.contains("4 ok"));
    lab.run("check .").ends_with(3);
}
