//! `render --integrator realtime`.

use crate::lab::{Lab, plane};

const RT: &str = "render --integrator realtime --size 40x40 --spp 2";

#[test]
fn the_built_in_helmet_in_real_time_is_near_the_traced_one() {
    let lab = Lab::new();
    lab.ok(&format!("{RT} --bits 32 --transparent -o rt.exr"));
    lab.ok("render --size 40x40 --spp 32 --bits 32 --transparent -o path.exr");
    let (rt, path) = (lab.exr("rt.exr"), lab.exr("path.exr"));
    let coverage: Vec<[f32; 2]> =
        plane(&rt, "", "A").iter().zip(plane(&path, "", "A")).map(|(a, b)| [*a, b]).collect();
    assert!(coverage.iter().all(|[a, b]| (a - b).abs() < 0.8), "edges are where they are");
    let (mut sums, mut difference) = ([0.0f32; 2], 0.0);
    for (a, b) in plane(&rt, "", "G").iter().zip(plane(&path, "", "G")) {
        let (a, b) = (a.min(1.0), b.min(1.0));
        sums = [sums[0] + a, sums[1] + b];
        difference += (a - b).abs();
    }
    // Occlusion and interreflection are missing: about as bright, and alike.
    assert!((0.7..1.5).contains(&(sums[0] / sums[1])), "{sums:?}");
    assert!(difference < 0.35 * sums[1], "{difference} of {}", sums[1]);
    assert_eq!(rt.metadata.get("Integrator"), Some("realtime"));
    assert!(rt.metadata.get("Choices").is_some_and(|c| c.contains("dfg=table")));
}

#[test]
fn passes_are_layers_or_pictures() {
    let lab = Lab::new();
    lab.ok(&format!("{RT} --passes all --bits 32 -o all.exr"));
    let all = lab.exr("all.exr");
    let terms = [
        "direct-diffuse",
        "direct-specular",
        "indirect-diffuse",
        "indirect-specular",
        "transmission",
        "emission",
        "environment",
    ];
    for c in ["R", "G", "B"] {
        let parts = terms.map(|l| plane(&all, l, c));
        for (i, whole) in plane(&all, "", c).iter().enumerate() {
            let sum: f32 = parts.iter().map(|p| p[i]).sum();
            assert!((sum - whole).abs() <= 1e-4 * whole.max(1.0), "{c} of pixel {i}: {sum} of {whole}");
        }
        // The developed layer is what a picture shows.
        assert!(plane(&all, "tone-mapped", c).iter().all(|v| (0.0..=1.0).contains(v)));
    }
    let middle = 20 * 40 + 20;
    let n = ["X", "Y", "Z"].map(|c| plane(&all, "normal", c)[middle]);
    assert!((n.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 0.1, "{n:?}");
    assert!((0.2..3.0).contains(&plane(&all, "depth", "Z")[middle]));

    // The founding notes' names, as pictures beside the picture.
    let run = lab.ok(&format!("{RT} --passes N,Ks,AO,tone-mapped -o small.png"));
    assert!(run.out.contains("small.normal.png") && run.out.contains("4 passes"), "{}", run.out);
    let wrong = "--choice pi=twice,coupling=whole";
    lab.run(&format!("{RT} {wrong} -o x.png")).ends_with(2).says(&["coupling", "diffuse-coupling"]);
    let choices =
        ["", "--preset notes", "--preset notes --curve neutral", "--preset unity", "--preset filament"];
    let more = ["--choice pi=twice --choice diffuse=sh9", "--preset filament --choice dfg=karis"];
    let mut seen = Vec::new();
    for (i, text) in choices.iter().chain(&more).enumerate() {
        lab.ok(&format!("{RT} {text} -o {i}.png"));
        let picture = lab.image(&format!("{i}.png")).pixels;
        assert!(!seen.contains(&picture), "{text} changes nothing");
        seen.push(picture);
    }
}

#[test]
fn what_does_not_apply_is_refused() {
    let lab = Lab::new();
    for (line, named) in [
        ("--noise 0.1", "--noise"),
        ("--time 1s", "--time"),
        ("--samples 0..4", "--samples"),
        ("--bounces 3", "--bounces"),
        ("--clamp-indirect 3", "--clamp-indirect"),
        ("--film a.film", "--film"),
        ("--checkpoint 3s", "--checkpoint"),
        ("--resume a.film", "--resume"),
        ("--watch", "--watch"),
        ("--compensation none", "--choice compensation"),
        ("--material gold", "metal-rough"),
        ("--preset toy", "filament"),
        ("--choice dfg=best", "karis"),
        ("--choice best", "compensation"),
        ("--passes shiny", "env-brdf"),
        ("--passes object", "vertex-normal"),
        ("--size 65536x65536", "pixels"),
    ] {
        let line = format!("render --integrator realtime {line} -o a.png");
        lab.run(&line).ends_with(2).says(&[named]);
    }
    lab.run("render --integrator radiosity").ends_with(2).says(&["path and realtime"]);
    for option in ["--preset notes", "--choice pi=twice"] {
        lab.run(&format!("render {option} -o a.png")).ends_with(2).says(&["--integrator realtime"]);
    }
    assert_eq!(lab.files(), [""; 0]);
    // A model that the shading knows is no mistake.
    lab.ok(&format!("{RT} --material metal-rough:roughness=0.5 -o b.png"));
    assert!(lab.run("help render").ends_with(0).out.contains("kulla-conty"));
}
