//! `render --frames`, `--turntable`, `--shutter`.

use crate::lab::{Lab, plane, samples, wait_for};
use serde_json::json;

/// A bright strip, 0.6 wide, that goes from x = −0.8 at 0 s to x = 0.8 at 1 s, and a camera of the file that sees x from
/// −1.6 to 1.6.
fn model(lab: &Lab) {
    let floats: Vec<f32> = [
        &[-0.3, -1.0, 0.0, 0.3, -1.0, 0.0, 0.3, 1.0, 0.0, -0.3, 1.0, 0.0f32][..],
        &[0.0, 1.0],
        &[-0.8, 0.0, 0.0, 0.8, 0.0, 0.0],
    ]
    .concat();
    let mut bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    lab.write("strip.bin", &bytes);
    let view =
        |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let floats = |view: u32, count: u32, shape: &str| json!({"bufferView": view, "componentType": 5126, "count": count, "type": shape});
    let gltf = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "buffers": [{"uri": "strip.bin", "byteLength": bytes.len()}],
        "bufferViews": [view(0, 48), view(48, 8), view(56, 24), view(80, 12)],
        "accessors": [
            floats(0, 4, "VEC3"),
            floats(1, 2, "SCALAR"),
            floats(2, 2, "VEC3"),
            {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 3, "material": 0}]}],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 1.6, "ymag": 0.1, "znear": 0.1, "zfar": 9}}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}],
        "scenes": [{"nodes": [0, 1]}],
        "animations": [{
            "name": "go",
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 1, "output": 2}]
        }]
    });
    lab.write("strip.gltf", gltf.to_string());
}

/// The red of the picture's first row.
fn row(lab: &Lab, name: &str) -> Vec<f32> {
    plane(&lab.exr(name), "", "R")[..32].to_vec()
}

const SMALL: &str = "strip.gltf --env none --camera 0 --size 32x2 --filter box --bounces 0 --bits 32";

#[test]
fn frames_are_at_their_times_and_rendered_once() {
    let lab = Lab::new();
    model(&lab);
    let frames = |range: &str, more: &str| {
        let run = lab.ok(&format!("render {SMALL} --frames {range} --fps 4 -o f-##.exr {more}"));
        run.out + &run.err
    };
    frames("0..2", "-n 4");
    // The middle of the strip: −0.8, −0.4, 0.
    for (n, middle) in [(0, -0.8f32), (1, -0.4), (2, 0.0)] {
        let r = row(&lab, &format!("f-{n:02}.exr"));
        let x = |i: usize| -1.55 + 0.1 * i as f32;
        let mean = r.iter().enumerate().map(|(i, v)| v * x(i)).sum::<f32>() / r.iter().sum::<f32>();
        assert!((mean - middle).abs() < 0.02, "frame {n}: {mean}, and {middle} is expected");
    }
    assert!(!lab.path("f-03.exr").exists(), "the last frame is included, and no more");
    let before = [0, 1, 2].map(|n| lab.bytes(&format!("f-{n:02}.exr")));
    let picture = row(&lab, "f-01.exr");
    std::fs::remove_file(lab.path("f-01.exr")).unwrap();
    assert!(frames("0..2", "-n 4").contains("2 of 3 frames were there already"));
    assert_eq!([0, 2].map(|n| lab.bytes(&format!("f-{n:02}.exr"))), [before[0].clone(), before[2].clone()]);
    assert_eq!(row(&lab, "f-01.exr"), picture);
    let text = frames("2", "-n 5");
    assert!(text.contains("f-02.exr: not finished, or made with other settings; rendered again"), "{text}");
    assert!(!frames("2", "-n 5 --overwrite").contains("there already"));
    lab.run(&format!("render {SMALL} --frames 0..2 -o f.exr")).ends_with(2).says(&["f-####.exr"]);
}

/// The strip is seen for a part of the time that is a trapezoid along its way. The shutter is open around the frame's time:
/// 0.5 s at 4 frames per second are 720°.
#[test]
fn the_shutter_blurs_around_the_frame() {
    let lab = Lab::new();
    model(&lab);
    lab.ok(&format!("render {SMALL} --frames 2 --fps 4 --shutter 720deg -n 128 -o a.exr"));
    lab.ok(&format!("render {SMALL} --at 0.5 --shutter 1/2s -n 128 -o b.exr"));
    let (a, b) = (row(&lab, "a.exr"), row(&lab, "b.exr"));
    assert_eq!(a, b, "an angle is a time");
    for (i, seen) in a.into_iter().enumerate() {
        let covered = |x: f64| (((x + 0.3).min(0.4) - (x - 0.3).max(-0.4)) / 0.8).max(0.0);
        let x = |k: i32| -1.6 + 0.1 * (i as f64 + (f64::from(k) + 0.5) / 50.0);
        let mean = (0..50).map(|k| covered(x(k))).sum::<f64>() / 50.0;
        assert!((f64::from(seen) - mean).abs() < 0.04, "pixel {i}: {seen}, and {mean} is expected");
    }
    let part = |range: &str, film: &str| {
        let shutter = "--at 0.5 --shutter 0.5s";
        lab.ok(&format!("render {SMALL} {shutter} --samples {range} --film {film} -o part.exr"));
    };
    part("0..40", "a.film");
    part("40..128", "b.film");
    lab.ok("merge a.film b.film -o whole.exr --bits 32");
    assert_eq!(row(&lab, "whole.exr"), b, "parts add to the whole");
    lab.ok(&format!("render {SMALL} --at 0.5 --shutter 0.5s --film r.film --samples 0..40 -o r.exr"));
    lab.ok("render --resume r.film --samples 0..128 -o r.exr");
    assert_eq!(row(&lab, "r.exr"), b, "a run that goes on gives the same");
    lab.run("render --shutter 0.6s --samples 0..130 --resume b.film -o c.exr")
        .ends_with(1)
        .says(&["--shutter"]);
    lab.run(&format!("render {SMALL} --shutter 0.5s -o c.exr")).ends_with(2).says(&["nothing moves"]);
}

#[test]
fn turntables_and_real_time() {
    let lab = Lab::new();
    model(&lab);
    let table = "render strip.gltf --env 0.2,0.2,0.2 --turntable 4 --size 24x24 -n 4";
    lab.ok(&format!("{table} -o t-#.png"));
    let seen: Vec<_> = (0..4).map(|n| samples(&lab.image(&format!("t-{n}.png")))).collect();
    assert!(seen[0] != seen[1] && !lab.path("t-4.png").exists());
    let frames = format!("{table} --integrator realtime --frames 0..1 -o r-#.png");
    lab.ok(&frames);
    assert!(lab.path("r-0.png").exists() && lab.path("r-1.png").exists());
    let run = lab.ok(&frames);
    assert!(run.out.contains("2 of 2 frames were there already"), "{run:?}");
    lab.run(&format!("{frames} --shutter 180deg")).ends_with(2).says(&["--shutter"]);
    lab.run("render strip.gltf --animation dance --at 0 -o n.png").ends_with(1).says(&["0 `go`"]);
}

/// A run that is interrupted within a frame leaves whole frames and says how to go on; the same command then leaves the files that
/// it leaves when nobody interrupts it, to the bit.
#[cfg(unix)]
#[test]
fn an_interrupted_sequence_goes_on_to_the_same_files() {
    for shutter in ["", "--shutter 1/8s"] {
        let line = format!(
            "render strip.gltf --env none --camera 0 --size 128x128 --bounces 0 --frames 0..3 --fps 4 -n 448 {shutter} \
             --checkpoint 0.05s -o f-#.exr"
        );
        let names = ["f-0.exr", "f-1.exr", "f-2.exr", "f-3.exr"];
        let (whole, parts) = (Lab::new(), Lab::new());
        model(&whole);
        model(&parts);
        whole.ok(&line);
        let child = parts.start(&line);
        // A film beside a frame tells that its samples are being taken.
        wait_for("a frame and a part of the next", || {
            parts.path("f-0.exr").exists() && (1..4).any(|n| parts.path(&format!("f-{n}.film")).exists())
        });
        crate::stop::interrupt(&child);
        let run = parts.finish(child).ends_with(1);
        let run = run.says(&["interrupted at frame", "of 448 samples", "the same command"]);
        let film =
            parts.files().into_iter().find(|f| f.ends_with(".film")).unwrap_or_else(|| panic!("{run:?}"));
        let at: usize = film["f-".len()..film.len() - ".film".len()].parse().unwrap();
        assert!(at >= 1, "{film}");
        for name in &names[..at] {
            assert_eq!(parts.bytes(name), whole.bytes(name), "{name} is whole");
        }
        assert!(parts.bytes(names[at]) != whole.bytes(names[at]), "frame {at} is not finished");
        assert!(parts.film(&film).0.samples() < 448);
        let run = parts.ok(&line);
        assert!(run.out.contains(&format!("{at} of 4 frames")), "{run:?}");
        for name in names {
            assert_eq!(parts.bytes(name), whole.bytes(name), "{name} after all, {shutter}");
        }
        assert_eq!(parts.files(), whole.files());
    }
}

/// A scene file's frames are its model's, with and without an open shutter.
#[test]
fn scene_files_move() {
    let lab = Lab::new();
    model(&lab);
    lab.write("scene.toml", "[[model]]\nfile = \"strip.gltf\"\n");
    for shutter in ["", "--shutter 1/8s"] {
        let frames = format!("--frames 1..2 --fps 4 -n 4 {shutter}");
        lab.ok(&format!("render {SMALL} {frames} -o m-#.exr"));
        lab.ok(&format!("render {} {frames} -o s-#.exr", SMALL.replace("strip.gltf", "scene.toml")));
        for n in 1..3 {
            assert_eq!(row(&lab, &format!("s-{n}.exr")), row(&lab, &format!("m-{n}.exr")), "{shutter}");
        }
    }
    lab.run(&format!("render {SMALL} --at 0.5 --moments 64 -o n.exr")).ends_with(2).says(&["--shutter"]);
    lab.run(&format!("render {SMALL} --at 0.5 --shutter 1/8s --moments 3 -o n.exr"))
        .ends_with(2)
        .says(&["power of two"]);
}
