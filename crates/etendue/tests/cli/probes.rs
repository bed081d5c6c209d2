//! `bake --probe` and `--probes`: the light at places of a model, and disks that are full.

use crate::lab::{Lab, plane, triangle};
use etendue::ibl::ProbeFile;
use serde_json::Value;

const QUICK: &str =
    "--size 16 --samples 16 --dfg-size 8 --dfg-samples 64 --irradiance-size 4 --probe-samples 8";

/// A triangle seen from 1 m: red light from its side, the sky from all others.
#[test]
fn a_reflection_probe_shows_the_model() {
    let lab = Lab::new();
    lab.write("sign.gltf", triangle(""));
    let line = "bake --probe sign.gltf --at 0,-0.2,1 --env 1,1,1 -q";
    lab.ok(&format!("{line} -o probe.exr {QUICK} --box=-1,-1,-2,1,1,2"));
    let exr = lab.exr("probe.exr");
    assert_eq!((exr.metadata.get("envmap"), exr.metadata.get("At")), (Some("cube"), Some("0 -0.2 1")));
    assert_eq!(exr.metadata.get("Box"), Some("-1 -1 -2 1 1 2"));
    let (red, green) = (plane(&exr, "", "R"), plane(&exr, "", "G"));
    let middle = |face: usize| (face * 16 + 8) * 16 + 8;
    // −Z is the sixth face; a dielectric's gloss gives it some of the sky's green.
    assert!(green[middle(5)] < 0.15 && red[middle(5)] > 0.5, "{} {}", red[middle(5)], green[middle(5)]);
    for face in 0..5 {
        assert!((green[middle(face)] - 1.0).abs() < 1e-3 && (red[middle(face)] - 1.0).abs() < 1e-3, "{face}");
    }

    lab.ok(&format!("{line} -o folder/ {QUICK}"));
    let json: Value = serde_json::from_slice(&lab.bytes("folder/bake.json")).unwrap();
    let probe = &json["probe"];
    assert_eq!(
        (&probe["scene"], &probe["samples"], &probe["box"]),
        (&"sign.gltf".into(), &8.into(), &Value::Null)
    );
    assert_eq!((probe["at"][2].as_f64(), probe["backs"].as_f64()), (Some(1.0), Some(0.0)));
    assert_eq!(json["sky"], "1,1,1");
    // The mean of red is the sky's, that of green less by the sign's share of directions.
    let mean =
        |c: usize| json["sh9"]["radiance"][0][c].as_f64().unwrap() / (4.0 * std::f64::consts::PI).sqrt();
    assert!((0.8..1.01).contains(&mean(0)) && mean(1) < mean(0) - 0.03, "{} {}", mean(0), mean(1));
    // The same bytes on any number of threads.
    let before = lab.bytes("folder/specular.ktx2");
    lab.ok(&format!("{line} -o folder/ {QUICK} -j 1"));
    assert_eq!(before, lab.bytes("folder/specular.ktx2"));
}

/// A scene file is baked as it is rendered: under its sky, with its settings; the command line goes first.
#[test]
fn probes_follow_scene_files() {
    let lab = Lab::new();
    lab.write("sign.gltf", triangle(""));
    lab.write(
        "sign.toml",
        "[[model]]\nfile = \"sign.gltf\"\n[environment]\nsky = \"0,1,0\"\nintensity = 0.5\n[render]\nbounces = 2\n",
    );
    let light = |line: &str| {
        let run = lab.ok(&format!(
            "bake --probes 1,1,1 sign.toml -o p.json --box=-3,-1,2,3,1,3 --probe-samples 64 --json {line}"
        ));
        let report: Value = serde_json::from_str(&run.out).unwrap();
        let file = ProbeFile::from_json(&String::from_utf8(lab.bytes("p.json")).unwrap()).unwrap();
        let e = file.grid.probe([0, 0, 0]).irradiance(glam::Vec3::Z) * std::f32::consts::FRAC_1_PI;
        (report["sky"].as_str().unwrap().to_owned(), [e[0], e[1], e[2]])
    };
    let (sky, [r, g, _]) = light("");
    assert!(sky == "0,1,0" && r.abs() < 0.02 && (g - 0.5).abs() < 0.05, "{sky} {r} {g}");
    let (sky, [r, g, _]) = light("--env 1,0,0");
    assert!(sky == "1,0,0" && (r - 0.5).abs() < 0.05 && g.abs() < 0.02, "{sky} {r} {g}");
    let (_, [_, g, _]) = light("--env-intensity 2");
    assert!((g - 2.0).abs() < 0.2, "{g}");
}

#[test]
fn light_probes_are_a_file_that_the_library_reads() {
    let lab = Lab::new();
    lab.write("sign.gltf", triangle(""));
    let run = lab.ok("bake --probes 3,1,2 sign.gltf -o probes.json --env 1,1,1 --box=-3,-1,-2,3,1,2 --probe-samples 768 --json");
    let report: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((&report["hidden"], &report["first"][0]), (&0.into(), &(-2.0).into()));
    let file = ProbeFile::from_json(&String::from_utf8(lab.bytes("probes.json")).unwrap()).unwrap();
    assert_eq!((file.grid.counts(), file.scene.as_str()), ([3, 1, 2], "sign.gltf"));
    // In front of the sign red light comes from it, whatever the normal sees of the sky.
    let e = file.grid.probe([1, 0, 1]).irradiance(glam::Vec3::NEG_Z);
    assert!(e[1] < 0.9 * e[0] && e[0] < 3.3, "{e:?}");
    let away = file.grid.probe([1, 0, 1]).irradiance(glam::Vec3::Z);
    assert!((away[1] / away[0] - 1.0).abs() < 0.15, "{away:?}");
    // Without a box the model's own.
    lab.ok("bake --probes 1,1,1 sign.gltf -o one.json --probe-samples 1 -q");
}

#[test]
fn wrong_probes_leave_nothing() {
    let lab = Lab::new();
    lab.write("sign.gltf", triangle(""));
    lab.write("empty.gltf", r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{}]}"#);
    for (line, code, parts) in [
        ("bake --probe sign.gltf -o a.ktx2", 2, &["--at"][..]),
        ("bake --probe none.gltf --at 0,0,0 -o a.ktx2", 1, &["none.gltf"]),
        ("bake --probe sign.gltf --at 0,0 -o a.ktx2", 2, &["three numbers"]),
        ("bake --probe sign.gltf --at 9,0,0 --box=-1,-1,-1,1,1,1 -o a.ktx2", 2, &["outside"]),
        ("bake --probe sign.gltf --at 0,0,0 --box=1,-1,-1,-1,1,1 -o a.ktx2", 2, &["six numbers"]),
        ("bake --probe sign.gltf --at 0,0,0 --probe-size 100 -o a.ktx2", 2, &["power of two"]),
        ("bake --probe sign.gltf --at 0,0,0 --env lost.hdr -o a.ktx2", 1, &["lost.hdr"]),
        ("bake --probes 2,2,2 sign.gltf -o a.ktx2", 2, &["a.ktx2", ".json"]),
        ("bake --probes 2,0,2 sign.gltf -o a.json", 2, &["three counts"]),
        ("bake --probes 4096,4096,4096 sign.gltf -o a.json", 2, &["three counts"]),
        ("bake --probes 2,2,2 -o a.json", 2, &["SKY|MODEL"]),
        ("bake --probes 2,2,2 empty.gltf -o a.json", 2, &["empty.gltf", "--box"]),
        ("bake --probes 2,2,2 sign.gltf -o nowhere/a.json", 1, &["nowhere"]),
    ] {
        lab.run(line).ends_with(code).says(parts);
    }
    assert_eq!(lab.files(), ["empty.gltf", "sign.gltf"]);
}

/// On a disk that fills up while the folder is written, nothing is left: neither whole files beside missing ones nor parts.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing() {
    let lab = Lab::new();
    std::fs::create_dir(lab.path("disk")).unwrap();
    let exe = env!("CARGO_BIN_EXE_etendue");
    let script = |output: &str| {
        format!(
            "mount -t tmpfs -o size=28k none disk || exit 77
            {exe} bake 1,1,1 -o disk/{output} --size 16 --samples 4 --dfg-size 64 --dfg-samples 16 --irradiance-size 4 -q
            code=$?; ls -AR disk; exit $code"
        )
    };
    // Into a new folder and an old one: the cubes find room, the table does not.
    for output in ["out/", ""] {
        let mut run = std::process::Command::new("unshare");
        run.args(["-rm", "sh", "-c"]).arg(script(output)).current_dir(lab.folder());
        let Ok(o) = run.output() else {
            println!("skipped: there is no unshare");
            return;
        };
        if o.status.code().is_none_or(|c| c == 77) || String::from_utf8_lossy(&o.stderr).contains("unshare") {
            println!("skipped: a file system cannot be mounted here");
            return;
        }
        let (out, err) = (String::from_utf8_lossy(&o.stdout), String::from_utf8_lossy(&o.stderr));
        assert_eq!(o.status.code(), Some(1), "{output}: {out}{err}");
        assert!(err.contains("disk/"), "{err}");
        assert_eq!(out.trim(), "disk:", "{output}: {err}");
    }
}
