//! `lab`: plots, verification, formulas.

use crate::lab::Lab;

#[test]
fn models_and_parameters_are_listed() {
    let lab = Lab::new();
    let all = lab.ok("lab list").out;
    for name in etendue::bxdf::model::Model::NAMES {
        assert!(all.lines().any(|l| l.split_whitespace().next() == Some(name)), "{name} is not in: {all}");
    }
    let one = lab.ok("lab list metal-rough").out;
    for part in ["base_color=", "roughness=", "0 to 1", "metallic="] {
        assert!(one.contains(part), "{part} is not in: {one}");
    }
    lab.run("lab list plastic").ends_with(2).says(&["plastic", "metal-rough"]);
}

#[test]
fn a_model_is_plotted() {
    let lab = Lab::new();
    let run = lab.ok("lab bxdf metal-rough roughness=0.25 base_color=#ffaa00 metallic=1 -o gold");
    for name in ["slice", "sphere", "terms", "albedo", "sampling"] {
        let svg = String::from_utf8(lab.bytes(&format!("gold/{name}.svg"))).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("metal-rough"), "{name}");
        let words: String =
            svg.split("</text>").filter_map(|t| t.rsplit('>').next()).collect::<Vec<_>>().join(" ");
        for part in ["roughness=0.25", "metallic=1", "etendue lab bxdf", "#ffaa00"] {
            assert!(words.contains(part), "{name}: {part} is not in: {words}");
        }
        let png = lab.image(&format!("gold/{name}.png"));
        assert!(png.width >= 600 && png.height >= 400, "{name}");
        assert!(run.err.contains(name), "{}", run.err);
    }
    // The same command draws the same bytes; another parameter other ones.
    lab.ok("lab bxdf metal-rough roughness=0.25 base_color=#ffaa00 metallic=1 -o again -q");
    lab.ok("lab bxdf metal-rough roughness=0.5 base_color=#ffaa00 metallic=1 -o other -q");
    for name in ["slice", "sphere", "terms", "albedo", "sampling"] {
        let file = |folder: &str| lab.bytes(&format!("{folder}/{name}.png"));
        assert_eq!(file("gold"), file("again"), "{name}");
        assert_ne!(file("gold"), file("other"), "{name}");
    }
}

#[test]
fn wrong_parameters_are_named() {
    let lab = Lab::new();
    for (line, parts) in [
        ("lab bxdf plastic", ["plastic", "lambert"]),
        ("lab bxdf lambert shine=1", ["shine", "base_color"]),
        ("lab bxdf lambert base_color=red", ["red", "r,g,b"]),
        ("lab bxdf lambert base_color", ["base_color", "NAME=VALUE"]),
        ("lab verify --model plastic", ["plastic", "lambert"]),
        ("lab verify --samples 3", ["--samples", "1000"]),
        ("lab", ["bxdf", "verify"]),
    ] {
        lab.run(line).ends_with(2).says(&parts);
    }
    assert_eq!(lab.files(), [""; 0]);
}

#[test]
fn verification_writes_a_verdict_for_each_cell() {
    let lab = Lab::new();
    let run = lab.ok("lab verify --model lambert --samples 5000 -o laws.html --json laws.json");
    let page = String::from_utf8(lab.bytes("laws.html")).unwrap();
    assert!(page.contains("every claimed law holds") && page.contains("--model lambert --samples 5000"));
    assert!(!page.contains("http://") && !page.contains("https://"), "the page needs nothing from elsewhere");
    let json: serde_json::Value = serde_json::from_slice(&lab.bytes("laws.json")).unwrap();
    let cells = json["cells"].as_array().unwrap();
    assert!(cells.len() > 10);
    for law in ["chi2", "weights", "density", "furnace", "sampled-albedo", "albedo", "reciprocity", "finite"]
    {
        assert!(cells.iter().any(|c| c["law"] == law && c["verdict"] == "holds"), "{law}");
        assert!(run.out.contains(law));
    }
    // Squares of the page and cells of the file are the same; three more squares explain the colours.
    let squares = page.matches("<b class=\"").count();
    assert_eq!(squares, cells.len() + 5, "a square for each cell, one for the verdict, four in the legend");
    // Threads do not change the numbers.
    lab.ok("lab verify --model lambert --samples 5000 -o one.html --json one.json -j 1 -q");
    let other: serde_json::Value = serde_json::from_slice(&lab.bytes("one.json")).unwrap();
    assert_eq!(json["cells"], other["cells"]);
}

#[test]
fn formulas_of_the_notes_are_compared() {
    let lab = Lab::new();
    let run = lab.ok("lab notes -o formulas");
    let page = String::from_utf8(lab.bytes("formulas/notes.html")).unwrap();
    for part in ["fifth power", "tangent", "twice in the split sum", "π twice", "another distribution"] {
        assert!(page.contains(part) && run.out.contains(part), "{part}");
    }
    assert_eq!(page.matches("<svg").count(), page.matches("<h2").count());
    assert!(lab.run("lab notes -o formulas/notes.html").code == Some(1));
}
