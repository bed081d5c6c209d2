//! `compare`: two pictures, their figures, and what a visual test makes of them.

use crate::lab::Lab;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

#[test]
fn pictures_compare_by_figures_and_exit_code() {
    let lab = Lab::new();
    lab.ok("render --size 40x32 --spp 4 -o a.png");
    lab.ok("render --size 40x32 --spp 4 --seed 1 -o b.png");
    let same = json(&lab.ok("compare a.png a.png --json --max-flip 0").out);
    assert_eq!(
        (&same["flip"]["mean"], &same["rmse"], &same["passes"]),
        (&0.0.into(), &0.0.into(), &true.into())
    );
    let other = json(&lab.ok("compare a.png b.png --json").out);
    let mean = other["flip"]["mean"].as_f64().unwrap();
    assert!(mean > 0.005 && mean < 0.3, "{other:#}");
    assert!(other["psnr"].as_f64().unwrap() > 10.0 && other["max_flip"].is_null());
    // The limit's code is neither an error's nor wrong usage's.
    lab.ok(&format!("compare a.png b.png --max-flip {} --quiet", mean + 1e-4));
    let run = lab.run(&format!("compare a.png b.png --max-flip {}", mean - 1e-4)).ends_with(3);
    assert!(run.out.contains("FLIP") && run.err.contains("mean FLIP"), "{run:?}");
    // Light is judged over all exposures: the metric says so.
    lab.ok("render --size 40x32 --spp 4 -o a.exr");
    lab.ok("render --size 40x32 --spp 4 --seed 1 -o b.hdr");
    let light = json(&lab.ok("compare a.exr b.hdr --json").out);
    assert_eq!(light["flip"]["metric"], "HDR-FLIP");
    assert!(light["flip"]["mean"].as_f64().unwrap() > mean, "{light:#}");
}

#[test]
fn a_report_stands_in_its_folder() {
    let lab = Lab::new();
    lab.ok("render --size 24x20 --spp 2 -o a.webp");
    lab.ok("render --size 24x20 --spp 2 --exposure 0.5 -o b.png");
    let printed = lab.ok("compare a.webp b.png -o deep/report --json").out;
    assert_eq!(json(&printed), json(&String::from_utf8(lab.bytes("deep/report/report.json")).unwrap()));
    let page = String::from_utf8(lab.bytes("deep/report/index.html")).unwrap();
    assert!(page.contains("a.webp") && page.matches("data:image/png;base64,").count() == 7);
    assert!(!page.contains("http") && !page.contains("<link"));
    assert!(json(&printed)["bias"].as_array().unwrap().iter().all(|b| b.as_f64().unwrap() > 0.0));
    let names: Vec<_> = std::fs::read_dir(lab.path("deep/report"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(names.len(), 2, "{names:?}");
}

#[test]
fn what_does_not_compare_is_told_apart() {
    let lab = Lab::new();
    lab.ok("render --size 24x20 --spp 1 -o a.png");
    lab.ok("render --size 20x24 --spp 1 -o tall.png");
    lab.ok("render --size 24x20 --spp 1 -o a.exr");
    lab.run("compare a.png tall.png").ends_with(1).says(&["24 × 20", "20 × 24", "one size"]);
    lab.run("compare a.png a.exr").ends_with(1).says(&["linear light", "etendue tonemap"]);
    lab.run("compare a.png none.png").ends_with(1).says(&["cannot read none.png"]);
    lab.write("torn.png", &lab.bytes("a.png")[..60]);
    lab.run("compare torn.png a.png").ends_with(1).says(&["torn.png"]);
    lab.run("compare a.png a.png --max-flip -1").ends_with(2).says(&["not negative"]);
    lab.write("file", "x");
    lab.run("compare a.png a.png -o file").ends_with(1).says(&["cannot write file"]);
}

#[test]
fn a_models_picture_stands_beside_its_path_traced_one() {
    let lab = Lab::new();
    let common = "compare --env 0.4,0.5,0.6 --size 32x32 -n 8 --realtime-samples 8 --quick";
    let v = json(&lab.ok(&format!("{common} -o report --json")).out);
    assert_eq!(v, json(&String::from_utf8(lab.bytes("report/report.json")).unwrap()));
    assert_eq!((&v["kind"], &v["samples"]["reference"]), (&"model".into(), &8.into()));
    let mean = |side: &str| v[side]["flip"]["mean"].as_f64().unwrap();
    assert!(mean("shading") < mean("whole") && mean("whole") < 0.5, "{v:#}");
    let page = String::from_utf8(lab.bytes("report/index.html")).unwrap();
    assert!(page.contains("the built-in helmet, exact") && !page.contains("http"));
    // The limit judges the picture, or the shading alone.
    let limit = 0.5 * (mean("shading") + mean("whole"));
    lab.run(&format!("{common} --quiet --max-flip {limit}")).ends_with(3).says(&["mean FLIP"]);
    lab.ok(&format!("{common} --quiet --max-flip {limit} --light-only"));
    // Mixtures and names that do not exist are wrong usage.
    lab.run("compare a.png").ends_with(2).says(&["the one to compare with it"]);
    lab.run("compare a.glb b.png").ends_with(2).says(&["one model, or two pictures"]);
    lab.run("compare a.png b.png --env 1,1,1").ends_with(2).says(&["--env is for models"]);
    lab.run("compare --ablations colour").ends_with(2).says(&["colour", "dfg"]);
    lab.run("compare --preset best").ends_with(2).says(&["best", "filament"]);
}
