//! When a run ends: by samples, error, time, or the user.

use crate::lab::{Lab, wait_for};
use std::time::{Duration, Instant};

fn json(lab: &Lab, line: &str) -> serde_json::Value {
    serde_json::from_str(&lab.ok(&format!("{line} --json")).out).unwrap()
}

#[test]
fn noise_ends_it_at_the_same_sample_everywhere() {
    let lab = Lab::new();
    let at = |options: &str| {
        let v = json(&lab, &format!("render --size 24x24 {options}"));
        (v["samples"].as_u64().unwrap(), v["relative_error"].as_f64().unwrap())
    };
    let (n, error) = at("--noise 0.09 -j 1 -o a.png");
    assert!(error < 0.09 && n > 16, "{n} samples, error {error}");
    assert_eq!(at("--noise 0.09 -j 2 -o b.png"), (n, error));
    assert_eq!(lab.image("a.png"), lab.image("b.png"));
    // Less noise takes more; the number of samples bounds it.
    let (more, _) = at("--noise 0.06");
    assert!(more > n, "{more} {n}");
    assert_eq!(at("--noise 0.0001 --spp 20").0, 20);
    // Too few samples tell nothing of the error.
    assert_eq!(at("--noise 100").0, 16);
    // Interrupted at any sample and resumed, it stops where it would have.
    lab.ok("render --size 24x24 --spp 19 --film part.film -o c.png");
    lab.ok("render --resume part.film --noise 0.09");
    assert_eq!(lab.film("part.film").0.samples(), n);
    assert_eq!(lab.image("c.png"), lab.image("a.png"));
}

#[test]
fn time_ends_it() {
    let lab = Lab::new();
    let start = Instant::now();
    let v = json(&lab, "render --size 32x32 --time 700ms -o t.png");
    let took = start.elapsed();
    let render = v["seconds"]["render"].as_f64().unwrap();
    assert!(v["samples"].as_u64().unwrap() > 1 && v["finished"] == true);
    // Machines under load are slow, not early.
    assert!(render > 0.3 && took < Duration::from_secs(20), "{render} {took:?}");
    assert_eq!(json(&lab, "render --size 32x32 --time 1h --spp 2 -o t.png")["samples"], 2);
}

#[cfg(unix)]
pub fn interrupt(child: &std::process::Child) {
    let ok = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(ok.success());
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_picture_and_film_and_says_how_to_go_on() {
    let lab = Lab::new();
    // The checkpoint tells that samples are being taken.
    let child = lab.start("render --size 32x32 --spp 1000000 --checkpoint 0.1s -o i.png");
    wait_for("a checkpoint", || lab.path("i.film").exists());
    interrupt(&child);
    let run = lab.finish(child).ends_with(1);
    let run =
        run.says(&["interrupted after", "of 1000000 samples", "i.png", "etendue render --resume i.film"]);
    assert!(run.out.contains("i.png"), "{}", run.out);
    assert_eq!(lab.files(), ["i.film", "i.png"]);
    let n = lab.film("i.film").0.samples() + 3;
    lab.ok(&format!("render --resume i.film --spp {n}"));
    lab.ok(&format!("render --size 32x32 -o once.png --spp {n}"));
    assert_eq!(lab.image("i.png"), lab.image("once.png"));

    // Another interrupted run of the same name leaves the first one's film alone.
    let before = lab.bytes("i.film");
    let child = lab.start("render --size 32x32 --spp 1000000 --checkpoint 0.1s --seed 2 -o i.png");
    wait_for("a checkpoint", || lab.path("i-2.film").exists());
    interrupt(&child);
    lab.finish(child).ends_with(1).says(&["--resume i-2.film"]);
    assert_eq!(lab.bytes("i.film"), before);
}

#[test]
fn a_finished_run_leaves_no_checkpoint_that_nobody_asked_for() {
    let lab = Lab::new();
    lab.ok("render --size 32x32 --time 600ms --checkpoint 0.05s -o a.png");
    assert_eq!(lab.files(), ["a.png"]);
}

#[test]
fn watching_rewrites_the_picture() {
    let lab = Lab::new();
    let mut child = lab.start("render --size 32x32 --time 3s --watch -o w.png");
    let mut seen = std::collections::BTreeSet::new();
    while child.try_wait().unwrap().is_none() {
        if let Ok(bytes) = std::fs::read(lab.path("w.png")) {
            // Always a whole picture.
            etendue::image::decode(&bytes, &Default::default()).expect("a whole picture");
            seen.insert(bytes);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    lab.finish(child).ends_with(0);
    assert!(seen.len() >= 2, "{} versions", seen.len());
    assert_eq!(lab.files(), ["w.png"]);
}
