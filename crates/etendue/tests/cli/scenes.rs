//! Scene files: a file in, a picture out; what goes before what; mistakes.

use crate::lab::{Lab, samples};

const OBJ: &str = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl red\nf 1 2 3 4\n";
const SCENE: &str = "[[model]]\nfile = 'm/m.obj'\n[environment]\nsky = [1, 1, 1]\n[camera]\neye = [0, 0, 4]\ntarget = [0, 0, 0]\nvfov = 20\n\
    [render]\nsize = [8, 6]\nspp = 2\nbounces = 3\n";

fn lab() -> Lab {
    let lab = Lab::new();
    std::fs::create_dir(lab.path("m")).expect("a folder");
    lab.write("m/m.obj", OBJ);
    lab.write("m/m.mtl", "newmtl red\nKd 1 0 0\n");
    lab.write("s.toml", SCENE);
    lab
}

#[test]
fn a_scene_file_is_the_picture_that_its_words_are_on_the_command_line() {
    let lab = lab();
    lab.ok("render s.toml -o a.png");
    lab.ok(
        "render m/m.obj --env 1,1,1 --eye 0,0,4 --target 0,0,0 --vfov 20 -s 8x6 -n 2 --bounces 3 -o b.png",
    );
    assert_eq!(lab.image("a.png"), lab.image("b.png"));
    // Without -o it has the scene's name and lies here; from elsewhere its files are found all the same.
    lab.ok("render s.toml");
    assert_eq!(lab.image("s.png"), lab.image("a.png"));
    std::fs::create_dir(lab.path("deep")).expect("a folder");
    lab.write("deep/up.toml", SCENE.replace("m/m.obj", "../m/m.obj"));
    lab.run("render deep/up.toml -o c.png").ends_with(1).says(&["outside", "--allow-outside", "line 2"]);
    lab.ok("render deep/up.toml -o c.png --allow-outside");
    assert_eq!(lab.image("c.png"), lab.image("a.png"));
}

#[test]
fn the_command_line_goes_before_the_scene_file() {
    let lab = lab();
    lab.ok("render s.toml -o a.png --size 5x4 --env 0,0,1 --json");
    let picture = lab.image("a.png");
    assert_eq!((picture.width, picture.height), (5, 4));
    // Red under blue light is black.
    assert_eq!(picture.sample(2, 2, 0), 0.0);
    // A goal that is given replaces the file's; so does a camera.
    let run = lab.ok("render s.toml -o b.png --samples 0..3 --film b.film --json");
    assert_eq!(lab.film("b.film").0.samples(), 3, "{}", run.out);
    lab.run("render s.toml --camera 0").ends_with(2).says(&["no camera 0"]);
    // Settings of paths do not stand in the way of the real-time picture, nor the other way round.
    lab.ok("render s.toml --integrator realtime -o r.png");
    lab.write("r.toml", SCENE.to_owned() + "preset = 'unity'\nchoice = { dfg = 'karis' }\n");
    lab.ok("render r.toml -o p.png");
    lab.ok("render r.toml --integrator realtime -o r.png");
}

#[test]
fn a_film_of_a_scene_file_goes_on() {
    let lab = lab();
    lab.ok("render s.toml -n 4 -o whole.png");
    lab.ok("render s.toml --samples 0..2 --film f.film -o part.png");
    lab.ok("render --resume f.film --samples 0..4 -o part.png");
    assert_eq!(lab.image("part.png"), lab.image("whole.png"));
    lab.write("s.toml", SCENE.to_owned() + "[[light]]\nkind = 'point'\nposition = [0, 0, 2]\n");
    lab.run("render --resume f.film --samples 0..6").ends_with(1).says(&["has changed"]);
}

#[test]
fn overrides_and_lights_are_seen() {
    let lab = lab();
    let brightness = |text: &str| {
        lab.write("o.toml", text);
        lab.ok("render o.toml -o o.png --linear");
        samples(&lab.image("o.png")).iter().sum::<f32>()
    };
    let plain = brightness(SCENE);
    let green = SCENE.to_owned() + "[override.red]\nbase_color = [0, 1, 0]\n";
    brightness(&green);
    let picture = lab.image("o.png");
    assert!(picture.sample(4, 3, 1) > 4.0 * picture.sample(4, 3, 0));
    let black = SCENE.replace("[1, 1, 1]", "'none'");
    assert_eq!(brightness(&black), 0.0);
    let lit = black + "[[light]]\nkind = 'directional'\ndirection = [0, 0, -1]\nintensity = 3\n";
    assert!(brightness(&lit) > 0.0);
    let gone = SCENE.replace("file = 'm/m.obj'", "file = 'm/m.obj'\ntranslation = [100, 0, 0]");
    assert!(brightness(&gone) > plain, "nothing but sky");
    // What is said on the command line of a material goes last.
    lab.ok("render o.toml -o l.png --material red=lambert:base_color=0,0,1");
}

#[test]
fn a_new_scene_file_renders_as_it_is() {
    let lab = Lab::new();
    let run = lab.ok("new");
    assert!(run.out.contains("etendue render scene.toml"), "{}", run.out);
    assert_eq!(lab.files(), ["etendue.schema.json", "scene.toml"]);
    let text = String::from_utf8(lab.bytes("scene.toml")).expect("text");
    assert!(text.starts_with("#:schema etendue.schema.json\n"));
    lab.ok("render scene.toml -s 8x8 -n 1 -o a.png");
    lab.ok("render -s 8x8 -n 1 -o b.png");
    assert_eq!(lab.image("a.png"), lab.image("b.png"));
    lab.write("scene.toml", "mine");
    lab.run("new").ends_with(2).says(&["scene.toml is there", "--force"]);
    assert_eq!(lab.bytes("scene.toml"), b"mine");
    lab.ok("new --force");
    lab.run("new a.glb").ends_with(2).says(&[".toml"]);
    let schema: serde_json::Value = serde_json::from_str(&lab.ok("schema").out).expect("JSON");
    let written: serde_json::Value = serde_json::from_slice(&lab.bytes("etendue.schema.json")).expect("JSON");
    assert_eq!(schema, written);
    assert_eq!(schema["properties"]["render"]["properties"]["bounces"]["default"], 8);
}

#[test]
fn mistakes_are_shown_where_they_are() {
    let lab = lab();
    let wrong = |text: &str, said: &[&str]| {
        lab.write("w.toml", text);
        lab.run("render w.toml").ends_with(1).says(said);
    };
    wrong(
        "[render]\nbouncs = 3\n",
        &["w.toml: line 2, column 1", "no `bouncs` in [render]", "did you mean `bounces`?", "bouncs = 3"],
    );
    wrong("[camera]\nvfov = 190\n", &["line 2, column 8", "between 0 and 180"]);
    wrong("[camera]\neye = [0, 0, 1]\ncamera = 0\n", &["w.toml: line", "cannot be used with"]);
    wrong("[render]\nsamples = [0, 4]\nspp = 3\n", &["w.toml: line", "cannot be used with"]);
    wrong("[render]\nallow_outside = true\n", &["no `allow_outside`"]);
    wrong("[render]\nmax_memory = '1TiB'\n", &["no `max_memory`"]);
    wrong("[[model]]\nfile = 'none.glb'\n", &["w.toml: line 2", "none.glb"]);
    wrong(
        "[[model]]\nfile = 'm/m.obj'\n[override.rad]\nroughness = 0.5\n",
        &["no material \"rad\"", "did you mean \"red\"?"],
    );
    wrong("a = 1\n[a]\n", &["w.toml: line"]);
    lab.run("render none.toml").ends_with(1).says(&["none.toml", "etendue new"]);
    lab.write("latin.toml", b"# caf\xe9\n");
    lab.run("render latin.toml").ends_with(1).says(&["line 1, column 6", "UTF-8"]);
}

#[test]
fn other_commands_take_scene_files_for_models() {
    let lab = lab();
    lab.write(
        "two.toml",
        SCENE.replace("[environment]", "[[model]]\nfile = 'm/m.obj'\ntranslation = [0, 0, 1]\n[environment]"),
    );
    let info = lab.ok("info two.toml").out;
    assert!(info.contains("scene file") && info.contains("shown in 2 instances"), "{info}");
    let run = lab.ok("check two.toml");
    assert!(run.out.contains("1 ok"), "{}", run.out);
    lab.ok("convert two.toml -o two.glb");
    let info = lab.ok("info two.glb").out;
    assert!(info.contains("shown in 2 instances"), "{info}");
    let run = lab.ok("compare s.toml --quick -n 2 --realtime-samples 1 --json");
    let report: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    assert_eq!(report["width"], 8, "{}", run.out);
}
