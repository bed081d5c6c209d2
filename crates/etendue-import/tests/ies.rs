//! IES profiles: every form of the file, measured lamps, lamps in glTF files, and back.
mod common;

use common::Model;
use etendue_import::{parse_ies, write_ies};
use etendue_scene::{LightKind, LightProfile, Web};
use glam::{Vec3, Vec3A};
use serde_json::json;
use std::f64::consts::PI;

fn profile(text: &str) -> LightProfile {
    parse_ies(text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}")).profile
}

/// The direction of a vertical and a horizontal angle of type C, degrees; z is the aim.
fn at(v: f32, h: f32) -> Vec3A {
    let (v, h) = (v.to_radians(), h.to_radians());
    Vec3A::new(v.sin() * h.cos(), v.sin() * h.sin(), v.cos())
}

fn near(p: &LightProfile, v: f32, h: f32, want: f32) {
    let got = p.candela(at(v, h));
    assert!((got - want).abs() <= 0.01 * want.max(0.1), "{v} {h}: {got}, not {want}");
}

/// A luminaire whose vertical angles are 0, 90 and 180.
fn text(head: &str, tilt: &str, factors: &str, horizontal: &[f32], candela: &[[f32; 3]]) -> String {
    let h: Vec<String> = horizontal.iter().map(f32::to_string).collect();
    let rows: Vec<String> = candela.iter().map(|r| format!("{} {},{}", r[0], r[1], r[2])).collect();
    format!(
        "{head}TILT={tilt}\r\n1 1000 {factors} 3 {} 1 2 0.1 0.1 0\r\n0.5 2 60\r\n0 90 180\r\n{}\r\n{}\r\n",
        h.len(),
        h.join(" "),
        rows.join("\r\n")
    )
}

#[test]
fn every_edition_is_read() {
    let lamp = [[8.0, 4.0, 2.0]];
    // Multiplier 3, ballast 0.5, and before 2002 the ballast-lamp factor 2.
    for (head, factor) in [
        ("A luminaire of 1986\nno header\n", 3.0),
        ("IESNA91\n[TEST] 1\n[MANUFAC] none\n", 3.0),
        ("IESNA:LM-63-1995\n[TEST] 1\n[MORE] TILTED\n", 3.0),
        ("IESNA:LM-63-2002\n[TEST] 1\n", 1.5),
        ("IES:LM-63-2019\n[TEST] 1\n", 1.5),
        ("", 3.0),
    ] {
        let p = profile(&text(head, "NONE", "3", &[0.0], &lamp));
        near(&p, 0.0, 0.0, 8.0 * factor);
        near(&p, 45.0, 200.0, 6.0 * factor);
        near(&p, 180.0, 17.0, 2.0 * factor);
    }
    let file = parse_ies(text("IESNA91\n[LAMP] x\n", "NONE", "1", &[0.0], &lamp).as_bytes()).unwrap();
    assert_eq!((file.labels[1].as_str(), file.lamp_lumens), ("[LAMP] x", Some(1000.0)));
    assert!(file.notes.is_empty());
    let tilted = text("", "INCLUDE\n1\n2\n0 90\n1.0 0.8", "1", &[0.0], &lamp);
    let file = parse_ies(tilted.as_bytes()).unwrap();
    assert_eq!(file.profile.candela(Vec3A::Z), 8.0);
    assert!(file.notes[0].contains("tilted"), "{:?}", file.notes);
    assert_eq!(parse_ies(text("", "lamp.tlt", "1", &[0.0], &lamp).as_bytes()).unwrap().notes.len(), 1);
}

#[test]
fn symmetries_are_unfolded() {
    let rows = |n: u32| -> Vec<[f32; 3]> { (0..n).map(|k| [9.0, 10.0 + k as f32, 1.0]).collect() };
    let of = |angles: &[f32]| profile(&text("IESNA91\n", "NONE", "1", angles, &rows(angles.len() as u32)));
    let quarter = of(&[0.0, 45.0, 90.0]);
    for h in [45.0, 135.0, 225.0, 315.0] {
        near(&quarter, 90.0, h, 11.0);
    }
    near(&quarter, 90.0, 180.0, 10.0);
    near(&quarter, 90.0, 270.0, 12.0);
    let half = of(&[0.0, 90.0, 180.0]);
    near(&half, 90.0, 270.0, 11.0);
    near(&half, 90.0, 315.0, 10.5);
    let other_half = of(&[90.0, 135.0, 180.0, 270.0]);
    for (h, want) in [(90.0, 10.0), (135.0, 11.0), (45.0, 11.0), (180.0, 12.0), (0.0, 12.0), (270.0, 13.0)] {
        near(&other_half, 90.0, h, want);
    }
    // One about 90 and 270 without a plane between them at 180 is closed, too.
    let beside = of(&[90.0, 170.0, 270.0]);
    for (h, want) in [(10.0, 11.0), (170.0, 11.0), (270.0, 12.0), (350.0, 11.2), (0.0, 11.1)] {
        near(&beside, 90.0, h, want);
    }
    // Without a plane at 360 the first one closes the round.
    let open = of(&[0.0, 90.0, 180.0, 270.0]);
    near(&open, 90.0, 315.0, 11.5);
    // Without one at 0 either, the two about it.
    let turned = of(&[45.0, 135.0, 225.0, 315.0]);
    near(&turned, 90.0, 0.0, 11.5);
    near(&turned, 90.0, 45.0, 10.0);
    // Angles below 0 and above 360 are those a turn away.
    for angles in [[-90.0, 0.0, 90.0, 180.0], [270.0, 360.0, 450.0, 540.0]] {
        let around = of(&angles);
        for (h, want) in [(270.0, 10.0), (0.0, 11.0), (90.0, 12.0), (180.0, 13.0), (45.0, 11.5)] {
            near(&around, 90.0, h, want);
        }
        assert_eq!((around.horizontal()[0], around.horizontal().last()), (0.0, Some(&360.0)));
    }
}

#[test]
fn types_a_and_b_are_read() {
    let text = |kind: u32, h: &str, rows: &str| {
        format!(
            "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 {} {kind} 2 0 0 0\n1 1 5\n-90 0 90\n{h}\n{rows}\n",
            h.split(' ').count()
        )
    };
    let a = profile(&text(3, "0 90", "0 10 20  0 40 0"));
    assert_eq!((a.web(), a.horizontal()), (Web::A, &[-90.0, 0.0, 90.0][..]));
    let c30 = 0.75f32.sqrt();
    assert!((a.candela(Vec3A::new(0.5, 0.0, c30)) - 40.0 / 3.0).abs() < 0.01, "upwards");
    assert!((a.candela(Vec3A::new(0.0, 0.5, c30)) - 20.0).abs() < 0.01, "either side");
    let b = profile(&text(2, "-90 0 90", "0 40 0  0 10 0  0 70 0"));
    assert_eq!(b.web(), Web::B);
    assert!((b.candela(Vec3A::new(0.0, -0.5, c30)) - 30.0).abs() < 0.01);
    assert!((b.candela(Vec3A::new(0.0, 0.5, c30)) - 20.0).abs() < 0.01);
    assert_eq!(b.candela(Vec3A::NEG_Z), 0.0);
}

#[test]
fn broken_files_are_told_so() {
    let good = text("IESNA91\n", "NONE", "1", &[0.0], &[[8.0, 4.0, 2.0]]);
    for (bad, line, message) in [
        (String::new(), 0, "no line `TILT=`"),
        ("IESNA91\nnothing\n".into(), 2, "no line `TILT=`"),
        (good.replace("0 90 180", "0 90"), 7, "ends"),
        (good.replace("0 90 180", "0 x 180"), 5, "`x` is no number"),
        (good.replace("1 1000 1 3", "1 1000 1 30000000"), 3, "number of vertical angles is 30000000"),
        (good.replace("1 1000 1 3", "1 1000 0 3"), 4, "factors"),
        (good.replace(" 1 1 2 0.1", " 1 4 2 0.1"), 3, "photometric type"),
        (good.replace("8 4,2", "8 4,nan"), 7, "`nan` is no number"),
        (good.replace("8 4,2", "8 4"), 7, "ends"),
        (good.replace("0 90 180", "90 0 180"), 7, "ascend"),
    ] {
        let e = parse_ies(bad.as_bytes()).expect_err(message);
        assert!(e.message.contains(message) && e.line == line, "{e}; wanted {line} {message}");
    }
    for end in 0..good.len() {
        let _ = parse_ies(&good.as_bytes()[..end]);
        let mut bent = good.clone().into_bytes();
        bent[end] ^= 0x15;
        let _ = parse_ies(&bent);
    }
}

/// Lamps as a manufacturer measured them (absolute photometry): the flux that the intensities integrate to is at most that of the bare
/// lamps, which the labels name, and most of it.
#[test]
fn measured_lamps_have_the_flux_that_they_say() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/env/ies");
    let Ok(files) = std::fs::read_dir(folder) else {
        println!("skipped: {folder} is not there");
        return;
    };
    let mut count = 0;
    for f in files {
        let path = f.unwrap().path();
        let file =
            parse_ies(&std::fs::read(&path).unwrap()).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let words = file.labels.join(" ");
        let said: Vec<f64> = words
            .split_whitespace()
            .zip(words.split_whitespace().skip(1))
            .filter(|(_, unit)| unit.trim_matches(',').starts_with("lm"))
            .filter_map(|(n, _)| n.parse().ok())
            .collect();
        let lumens = file.profile.lumens();
        println!(
            "{}: {lumens:.0} lm of {said:?}, peak {} cd, {:?}",
            path.display(),
            file.profile.peak(),
            file.notes
        );
        assert!(lumens > 10.0);
        if let Some(said) = said.first() {
            assert!(lumens < 1.02 * said && lumens > 0.3 * said, "{lumens} of {said}");
        }
        let again = profile(&write_ies(&file.profile));
        assert_eq!(again, file.profile);
        count += 1;
    }
    assert!(count > 0);
}

#[test]
fn uniform_light_has_its_flux() {
    let p = profile(&text("IESNA91\n", "NONE", "1", &[0.0], &[[50.0; 3]]));
    assert!((p.lumens() / (200.0 * PI) - 1.0).abs() < 1e-5, "{}", p.lumens());
}

#[test]
fn lamps_of_gltf_hang_on_their_nodes() {
    let ies = text("IESNA91\n", "NONE", "1", &[0.0], &[[8.0, 4.0, 0.0]]);
    let mut m = Model::new();
    let view = m.view(ies.as_bytes());
    let data = format!(
        "data:application/x-ies-lm-63,{}",
        ies.replace('\r', "").replace('\n', "%0A").replace(' ', "%20")
    );
    m.json["extensionsUsed"] = json!(["EXT_lights_ies"]);
    m.json["extensions"] = json!({ "EXT_lights_ies": { "lights": [
        { "bufferView": view, "mimeType": "application/x-ies-lm-63" },
        { "uri": data },
        { "uri": "data:,broken" },
    ] } });
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let node = |light: u32, more: serde_json::Value| {
        let mut n = json!({ "extensions": { "EXT_lights_ies": { "light": light } } });
        n.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        n
    };
    let mut tinted = node(
        0,
        json!({ "name": "lamp", "translation": [1.0, 2.0, 3.0], "rotation": [-half, 0.0, 0.0, half], "scale": [4.0, 4.0, 4.0] }),
    );
    tinted["extensions"]["EXT_lights_ies"]["multiplier"] = json!(2.0);
    tinted["extensions"]["EXT_lights_ies"]["color"] = json!([1.0, 0.5, 0.25]);
    m.json["nodes"] = json!([tinted, node(1, json!({})), node(2, json!({}))]);
    m.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    m.json["scene"] = json!(0);
    let model = m.import();
    let s = &model.scene;
    assert_eq!((s.lights.len(), s.profiles.len()), (2, 2));
    assert!(model.warnings.iter().any(|w| w.to_string().contains("TILT")), "{:?}", model.warnings);
    let lamp = &s.lights[0];
    assert_eq!((lamp.name.as_str(), lamp.position), ("lamp", Vec3::new(1.0, 2.0, 3.0)));
    assert!(lamp.direction.abs_diff_eq(Vec3::NEG_Y, 1e-6), "down: {}", lamp.direction);
    assert_eq!(lamp.intensity, Vec3::new(2.0, 1.0, 0.5));
    assert!(matches!(lamp.kind, LightKind::Profile { profile: 0, side } if side.abs_diff_eq(Vec3::X, 1e-6)));
    let aimed = s.aimed_profile(lamp).unwrap();
    assert!((aimed.candela(Vec3A::NEG_Y) - 8.0).abs() < 1e-4 && (aimed.candela(Vec3A::X) - 4.0).abs() < 1e-2);
    assert!(aimed.candela(Vec3A::Y) < 0.05);

    // Written and read again.
    let file = etendue_import::export(s, &[], &Default::default()).unwrap();
    let again = etendue_import::import_bytes(&file.bytes, "a.glb", &Default::default()).unwrap().scene;
    assert_eq!(again.profiles, s.profiles);
    for (a, b) in again.lights.iter().zip(&s.lights) {
        assert!(a.direction.abs_diff_eq(b.direction, 1e-5) && a.intensity.abs_diff_eq(b.intensity, 1e-5));
        let (LightKind::Profile { side: a, .. }, LightKind::Profile { side: b, .. }) = (a.kind, b.kind)
        else {
            panic!("not measured")
        };
        assert!(a.abs_diff_eq(b, 1e-5));
    }
}
