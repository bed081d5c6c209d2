//! The same bits whatever the threads, the parts and the interruptions.

use crate::lab::{Lab, plane, wait_for};
use etendue::render::Film;

/// All channels of the beauty picture of a float EXR.
fn light(lab: &Lab, name: &str) -> Vec<Vec<f32>> {
    let exr = lab.exr(name);
    ["R", "G", "B"].map(|c| plane(&exr, "", c)).to_vec()
}

#[test]
fn threads_do_not_matter() {
    let lab = Lab::new();
    let mut files = Vec::new();
    for j in [1, 2, 7] {
        lab.ok(&format!("render --size 40x24 --spp 5 -j {j} -o {j}.png"));
        lab.ok(&format!(
            "render --size 40x24 --spp 5 -j {j} -o {j}.exr --bits 32 --passes all --film {j}.film"
        ));
        let exr = lab.exr(&format!("{j}.exr"));
        files.push((lab.image(&format!("{j}.png")), exr.layers, lab.film(&format!("{j}.film")).0));
    }
    assert!(files.windows(2).all(|w| w[0] == w[1]));
    // And the seed does.
    lab.ok("render --size 40x24 --spp 5 --seed 1 -o seed.png");
    assert_ne!(lab.image("seed.png"), files[0].0);
}

#[test]
fn parts_add_to_the_whole_in_any_order() {
    let lab = Lab::new();
    let picture = "--size 20x20 --passes object,depth --bits 32 --curve agx";
    lab.ok(&format!("render {picture} --spp 13 -o whole.exr --film whole.film"));
    for (name, range) in [("a", "0..4"), ("b", "4..5"), ("c", "5..13")] {
        lab.ok(&format!("render {picture} --samples {range} -o {name}.exr --film {name}.film"));
    }
    let (whole, info) = lab.film("whole.film");
    for (n, order) in ["a b c", "c a b", "b c a"].into_iter().enumerate() {
        let films: Vec<_> = order.split(' ').map(|p| format!("{p}.film")).collect();
        let films = films.join(" ");
        lab.ok(&format!("merge {films} -o m{n}.film"));
        lab.ok(&format!("merge {films} -o m{n}.exr"));
        let (film, theirs) = lab.film(&format!("m{n}.film"));
        assert_eq!((&film, &theirs.picture), (&whole, &info.picture), "{order}");
        assert_eq!(lab.exr(&format!("m{n}.exr")).layers, lab.exr("whole.exr").layers, "{order}");
        assert_eq!(lab.bytes(&format!("m{n}.film")), lab.bytes("m0.film"), "{order}");
    }
    // A sum is a film like any other: it can be added to and continued.
    lab.ok("merge a.film c.film -o ac.film");
    lab.ok("render --resume ac.film");
    assert_eq!(lab.film("ac.film").0, whole);
    let two = lab.run("merge a.film a.film -o x.exr").ends_with(1).says(&["a.film", "sample 0", "once"]);
    assert!(!two.err.contains("panicked") && !lab.path("x.exr").exists());
    lab.ok("render --size 20x20 --spp 1 --seed 2 -o x.png --film other.film");
    lab.run("merge a.film other.film -o x.exr").ends_with(1).says(&["other.film", "different pictures"]);
    let json = lab.ok("merge a.film b.film -o ab.exr --json").out;
    let v: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&v["samples"], &v["films"]), (&5.into(), &2.into()));
}

#[test]
fn a_merged_picture_is_developed_like_its_parts() {
    let lab = Lab::new();
    let picture = "--size 16x16 --curve reinhard --exposure 1 --transparent";
    lab.ok(&format!("render {picture} --spp 4 -o whole.png"));
    lab.ok(&format!("render {picture} --samples 0..2 -o a.png --film a.film"));
    lab.ok(&format!("render {picture} --samples 2..4 -o b.png --film b.film"));
    lab.ok("merge b.film a.film -o merged.png");
    assert_eq!(lab.image("merged.png"), lab.image("whole.png"));
    lab.ok("merge b.film a.film -o dark.png --exposure -2");
    assert_ne!(lab.image("dark.png"), lab.image("whole.png"));
}

#[test]
fn a_killed_run_goes_on_to_the_same_bits() {
    let lab = Lab::new();
    let picture = "--size 48x48 --bits 32 -o run.exr";
    let mut child = lab.start(&format!("render {picture} --spp 1000000 --film run.film --checkpoint 0.1s"));
    wait_for("a checkpoint", || lab.path("run.film").exists());
    // Whichever moment this is: the film on the disk is a whole one.
    child.kill().unwrap();
    child.wait().unwrap();
    let (film, _) = lab.film("run.film");
    let have = film.samples();
    assert!(have > 0 && !lab.path("run.exr").exists());
    let n = have + 5;
    lab.ok(&format!("render --resume run.film --spp {n}"));
    lab.ok(&format!("render --size 48x48 --bits 32 -o once.exr --spp {n} --film once.film"));
    assert_eq!(lab.film("run.film").0, lab.film("once.film").0);
    assert_eq!(light(&lab, "run.exr"), light(&lab, "once.exr"));
    // The picture names the command that began it.
    let command = lab.exr("run.exr").metadata.get("Command").unwrap().to_string();
    assert!(command.contains("--size 48x48") && !command.contains("--resume"), "{command}");
}

#[test]
fn a_film_knows_its_options_and_hears_new_ones() {
    let lab = Lab::new();
    let model = lab.write("sign.gltf", crate::lab::triangle(""));
    lab.ok(
        "render sign.gltf --size 16x12 --seed 4 --bounces 3 --filter box --spp 2 --eye 1,1,4 --film a.film",
    );
    lab.ok("render sign.gltf --size 16x12 --seed 4 --bounces 3 --filter box --spp 6 --eye 1,1,4 -o once.png");
    lab.ok("render --resume a.film --spp 6");
    assert_eq!(lab.image("sign.png"), lab.image("once.png"));
    // Another development is not another picture.
    lab.ok("render --resume a.film -o bright.png --exposure 2");
    assert_ne!(lab.image("bright.png"), lab.image("once.png"));
    assert_eq!(lab.film("a.film").0.samples(), 6);
    // An option with the same value is the same picture.
    lab.ok("render --resume a.film --seed 4 --size 16x12");
    // What would make it another picture is named, and the film is left alone.
    let before = lab.bytes("a.film");
    for (options, named) in [
        ("--seed 5", "--seed"),
        ("--size 12x16", "--size"),
        ("--env 1,1,1", "--env"),
        ("--env-rotation 20", "--env-rotation"),
        ("--bounces 2 --quality 50", "--bounces"),
        ("--passes depth -o x.exr", "--passes"),
        ("--transparent", "--transparent"),
        ("--camera 0", "--camera"),
        ("--eye 2,1,4", "--eye"),
    ] {
        let run = lab.run(&format!("render --resume a.film --spp 9 {options}")).ends_with(1);
        let run = run.says(&["a.film", named, "another picture"]);
        assert!(!run.err.contains("--quality"), "{}", run.err);
    }
    std::fs::write(&model, crate::lab::triangle(r#","extras":1"#).replace("[1,0,0,1]", "[0,1,0,1]")).unwrap();
    lab.run("render --resume a.film --spp 9").ends_with(1).says(&["a.film", "has changed"]);
    assert_eq!(lab.bytes("a.film"), before);
}

#[test]
fn damaged_films_are_errors() {
    let lab = Lab::new();
    lab.ok("render --size 8x8 --spp 1 --film good.film");
    let good = lab.bytes("good.film");
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 1;
    lab.write("flipped.film", flipped);
    lab.write("short.film", &good[..good.len() / 2]);
    lab.write("empty.film", "");
    lab.write("text.film", "hello");
    for (name, cause) in [
        ("flipped.film", "damaged"),
        ("short.film", "film file is"),
        ("empty.film", "not a film"),
        ("text.film", "not a film"),
        ("none.film", "No such file"),
    ] {
        lab.run(&format!("render --resume {name}")).ends_with(1).says(&[name, cause]);
        lab.run(&format!("merge good.film {name} -o m.png")).ends_with(1).says(&[name, cause]);
    }
    // Whole, but made by something that did not say how.
    let (film, mut info) = Film::from_bytes(&good).unwrap();
    info.notes.clear();
    lab.write("mute.film", film.to_bytes(&info));
    lab.run("render --resume mute.film").ends_with(1).says(&["mute.film", "does not say how"]);
    // A header that names the picture of another size: an error, no panic.
    let (small, info) = Film::from_bytes(&good).unwrap();
    let mut forged = Film::new(4, 4, small.passes);
    forged.ranges = small.ranges;
    lab.write("forged.film", forged.to_bytes(&info));
    lab.run("render --resume forged.film --spp 2").ends_with(1).says(&["forged.film", "cannot go on"]);
}
