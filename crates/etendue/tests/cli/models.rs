//! Models of every format: rendered, described, checked, converted.

use crate::lab::{Lab, triangle};

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n";

fn lab() -> Lab {
    let lab = Lab::new();
    lab.write("m.obj", OBJ);
    lab.write("m.mtl", "newmtl red\nKd 1 0 0\n");
    lab.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
    lab.write("odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n");
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

#[test]
fn checking_ends_with_three_if_a_model_does_not_load() {
    let lab = lab();
    let run = lab.ok("check m.obj m.ply m.stl t.gltf");
    assert!(run.out.contains("4 ok, 0 with warnings, 0 with errors"), "{}", run.out);
    let run = lab.run("check m.obj bad.obj odd.obj none.glb").ends_with(3);
    assert!(run.out.contains("bad.obj: error: line 2: refers to position 3"), "{}", run.out);
    assert!(run.out.contains("odd.obj: warnings: line 4: lines are not supported"), "{}", run.out);
    assert!(run.out.contains("1 ok, 1 with warnings, 2 with errors"), "{}", run.out);
    lab.run("check odd.obj").ends_with(0);
    lab.run("check odd.obj --strict").ends_with(3);
    let json = lab.run("check --json m.obj bad.obj").ends_with(3).out;
    let v: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&v["files"][0]["verdict"], &v["files"][1]["verdict"]), (&"ok".into(), &"error".into()));
    assert_eq!((&v["files"][0]["triangles"], &v["errors"]), (&2.into(), &1.into()));
}
