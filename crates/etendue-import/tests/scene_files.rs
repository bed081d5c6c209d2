//! Scene files: text in; models placed, materials changed, lights added, mistakes named with their place.

use etendue_import::scene_file::{
    Grammar, Key, Kind, LoadOptions, Mistake, SceneFile, SceneFileError, Section, Value, schema, template,
};
use etendue_import::{ImportOptions, Imported, Limits};
use etendue_scene::{AlphaMode, LightKind, Material, Substitute};
use glam::{Vec3, Vec3A};
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\nusemtl blue\nf 3/3 2/2 1/1\n";
const PIXEL: &[u8] = include_bytes!("data/pixel.png");

/// A folder with models.
fn folder() -> TempDir {
    let dir = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(dir.path().join(name), bytes).expect("written");
    write("m.obj", OBJ.as_bytes());
    write("m.mtl", b"newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    write("plain.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("pixel.png", PIXEL);
    let variants = r#"{"asset":{"version":"2.0"},
        "extensionsUsed":["KHR_materials_variants","KHR_lights_punctual"],
        "extensions":{"KHR_materials_variants":{"variants":[{"name":"day"},{"name":"night"}]},
            "KHR_lights_punctual":{"lights":[{"type":"spot","intensity":5,"spot":{}}]}},
        "scenes":[{"nodes":[0,1,2]}],"scene":0,
        "nodes":[{"mesh":0},{"extensions":{"KHR_lights_punctual":{"light":0}}},{"camera":0,"translation":[0,0,5]}],
        "cameras":[{"type":"perspective","name":"eye","perspective":{"yfov":1,"znear":0.1}}],
        "materials":[{"name":"own"},{"name":"day"},{"name":"night"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0,"extensions":{"KHR_materials_variants":{
            "mappings":[{"material":1,"variants":[0]},{"material":2,"variants":[1]}]}}}]}],
        "buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
    write("v.gltf", variants.as_bytes());
    dir
}

fn sections() -> Vec<Section> {
    let keys = vec![
        Key::new("size", Kind::Pair("x"), "Pixels").or("[512, 512]"),
        Key::new("curve", Kind::choice(&["agx", "neutral"]), "Tone").or("\"neutral\""),
        Key::new("passes", Kind::Words(vec!["depth".into(), "all".into()]), "Layers"),
        Key::new("time", Kind::Time, "How long"),
        Key::new("camera", Kind::Name, "Which"),
        Key::new("sky", Kind::Sky(vec!["studio".into()]), "The sky").or("\"studio\""),
        Key::new("choice", Kind::Table(vec![Key::new("dfg", Kind::choice(&["a", "b"]), "How")]), "Choices"),
        Key::new("quiet", Kind::Flag, "Say nothing").or("false"),
        Key::new("seed", Kind::Integer([0, 9]), "Noise").or("0"),
        Key::new("more", Kind::Texts, "Words"),
    ];
    vec![Section { name: "render".into(), about: "Settings.".into(), keys }]
}

fn parse(text: &str, folder: &Path) -> Result<SceneFile, SceneFileError> {
    let sections = sections();
    let grammar = Grammar {
        sections: &sections,
        builtins: &["helmet"],
        folder: folder.into(),
        limits: Limits::default(),
    };
    SceneFile::parse(text, "s.toml", &grammar)
}

fn load_with(text: &str, folder: &Path, options: &LoadOptions<'_>) -> Result<Imported, SceneFileError> {
    parse(text, folder)?.load(options)
}

fn load(text: &str, folder: &Path) -> Imported {
    load_with(text, folder, &LoadOptions::default()).unwrap_or_else(|e| panic!("{text}\n{e}"))
}

/// The mistake that reading or loading `text` finds.
fn mistake(text: &str) -> Mistake {
    let dir = folder();
    match load_with(text, dir.path(), &LoadOptions::default()) {
        Err(SceneFileError::Wrong(m)) => *m,
        other => panic!("{text}\nis no mistake: {other:?}"),
    }
}

fn material<'a>(model: &'a Imported, name: &str) -> &'a Material {
    model.scene.materials.iter().find(|m| m.name == name).expect("there")
}

#[test]
fn models_stand_where_the_file_says() {
    let dir = folder();
    let text = "[[model]]\nfile = 'm.obj'\ntranslation = [10, 0, 0]\nrotation = [0, 90, 0]\nscale = 2\n\
        [[model]]\nfile = 'm.obj'\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,5,0,1]\n";
    let model = load(text, dir.path());
    let s = &model.scene;
    // Read once, shown twice, each with materials of its own.
    assert_eq!((s.meshes.len(), s.instances.len(), s.materials.len()), (2, 4, 4));
    let corner = |i: usize| s.instances[i].transform.transform_point3a(Vec3A::X);
    assert!((corner(0) - Vec3A::new(10.0, 0.0, -2.0)).length() < 1e-5, "{}", corner(0));
    assert_eq!(corner(2), Vec3A::new(1.0, 5.0, 0.0));
    assert_eq!(model.info.counts.instances, 4);
    assert_eq!(model.info.format, "scene file");
}

#[test]
fn a_moved_model_takes_its_lights_and_cameras_along() {
    let dir = folder();
    let model = load(
        "[[model]]\nfile = 'v.gltf'\nrotation = [0, 180, 0]\ntranslation = [0, 1, 0]\nscale = 3\n",
        dir.path(),
    );
    let l = &model.scene.lights[0];
    assert!((l.position - Vec3::Y).length() < 1e-5 && (l.direction - Vec3::Z).length() < 1e-5, "{l:?}");
    let c = &model.scene.cameras[0].transform;
    assert!((c.translation - Vec3A::new(0.0, 1.0, -15.0)).length() < 1e-4, "{c:?}");
    assert!(
        (c.matrix3.z_axis - Vec3A::NEG_Z).length() < 1e-5 && (c.matrix3.determinant() - 1.0).abs() < 1e-5
    );
}

#[test]
fn variants_are_chosen_per_model_and_from_outside() {
    let dir = folder();
    let text = "[[model]]\nfile = 'v.gltf'\nvariant = 'day'\n[[model]]\nfile = 'v.gltf'\n";
    let shown = |model: &Imported| -> Vec<String> {
        let s = &model.scene;
        s.instances.iter().map(|i| s.materials[i.material.expect("one") as usize].name.clone()).collect()
    };
    let mut model = load(text, dir.path());
    assert_eq!(shown(&model), ["day", "own"]);
    model.scene.select_variant("night").expect("there is one");
    assert_eq!(shown(&model), ["night", "night"]);
    let options = LoadOptions { variant: Some("night"), ..LoadOptions::default() };
    assert_eq!(shown(&load_with(text, dir.path(), &options).expect("loads")), ["night", "night"]);
    let m = mistake("[[model]]\nfile = 'v.gltf'\nvariant = 'nigth'\n");
    assert!(m.help.as_deref().is_some_and(|h| h.contains("\"night\"")), "{m:?}");
}

#[test]
fn materials_are_changed_by_name() {
    let dir = folder();
    let text = "[[model]]\nfile = 'm.obj'\n[model.override.red]\nroughness = 0.9\n\
        [[model]]\nfile = 'm.obj'\n\
        [override.'*']\nroughness = 0.25\nmetallic = 1\n[override.blue]\nroughness = 0.5\nalpha_cutoff = 0.3\nsheen_color = '#ff0000'\n";
    let model = load(text, dir.path());
    let seen: Vec<_> = model.scene.materials.iter().map(|m| (&m.name[..], m.roughness, m.metallic)).collect();
    // What is said of one model goes before what is said of all, a name before the star.
    assert_eq!(
        seen,
        [("red", 0.9, 1.0), ("blue", 0.5, 1.0), ("red", 0.25, 1.0), ("blue", 0.5, 1.0)],
        "{seen:?}"
    );
    let blue = material(&model, "blue");
    assert_eq!(blue.alpha_mode, AlphaMode::Mask(0.3));
    assert_eq!(blue.extensions.as_ref().and_then(|e| e.sheen).map(|s| s.color), Some(Vec3::X));
    // What has no material gets one of its own under the star.
    let model = load("[[model]]\nfile = 'plain.obj'\n[override.'*']\nior = 2\n", dir.path());
    assert!(model.scene.materials.iter().all(|m| m.ior == 2.0));
}

#[test]
fn another_model_takes_a_materials_place() {
    let dir = folder();
    let text = "[[model]]\nfile = 'm.obj'\n[override.red]\nmodel = 'openpbr'\ncoat_weight = 1\nbase_color = [0.1, 0.2, 0.3]\nalpha = 0.5\n\
        [override.blue]\nmodel = 'gold'\nroughness = 0.2\n";
    let model = load(text, dir.path());
    let of = |name: &str| match &material(&model, name).substitute {
        Some(Substitute::Model(m)) => **m,
        other => panic!("{other:?}"),
    };
    assert_eq!(of("red").name(), "openpbr");
    assert_eq!(of("red").get("coat_weight").map(|v| format!("{v:?}")).as_deref(), Some("Number(1.0)"));
    assert_eq!(material(&model, "red").alpha, 0.5);
    assert_eq!(of("blue").name(), "conductor");
    let m = mistake("[[model]]\nfile = 'm.obj'\n[override.red]\nmodel = 'openpbr'\nroughness = 0.1\n");
    assert!(m.message.contains("of glTF's surface") && m.line == 5, "{m}");
    let m = mistake("[[model]]\nfile = 'm.obj'\n[override.red]\nmodel = 'openpdr'\n");
    assert_eq!(m.help.as_deref(), Some("did you mean \"openpbr\"?"));
}

#[test]
fn textures_are_put_on_and_left_out() {
    let dir = folder();
    let text = "[[model]]\nfile = 'm.obj'\n[override.red]\nbase_color_texture = 'pixel.png'\nnormal_texture = 'pixel.png'\nnormal_scale = 0.5\n";
    let model = load(text, dir.path());
    let red = material(&model, "red");
    let (t, n) = (red.base_color_texture.expect("a texture"), red.normal_texture.expect("a map"));
    assert_eq!((t.texture, n.texture.texture, n.scale), (0, 0, 0.5), "one picture for both");
    assert_eq!(model.scene.images.len(), 1);
    // Its mesh had no need of tangents before.
    assert!(!model.scene.meshes[0].tangents.is_empty() && model.scene.meshes[1].tangents.is_empty());
    let text =
        text.to_owned() + "[override.'*']\nbase_color = 0.5\n[override.blue]\nglossiness_texture = false\n";
    let model = load(&text, dir.path());
    assert!(material(&model, "blue").extensions.is_none(), "nothing to leave out, and nothing left behind");
    let m = mistake("[[model]]\nfile = 'm.obj'\n[override.red]\nbase_color_texture = 'none.png'\n");
    assert!(m.message.contains("none.png") && m.line == 4, "{m}");
}

#[test]
fn lights_shine_as_they_are_written() {
    let dir = folder();
    let text = "[[light]]\nkind = 'directional'\ndirection = [0, -2, 0]\nintensity = 3\ncolor = [1, 0.5, 0]\n\
        [[light]]\nkind = 'spot'\nposition = [0, 2, 0]\ntarget = [0, 0, 0]\ninner = 10\nouter = 20\nrange = 4\n\
        [[light]]\nkind = 'point'\n";
    let lights = load(text, dir.path()).scene.lights;
    assert_eq!((lights[0].direction, lights[0].intensity), (Vec3::NEG_Y, Vec3::new(3.0, 1.5, 0.0)));
    let LightKind::Spot { inner, outer } = lights[1].kind else { panic!("{:?}", lights[1]) };
    assert!((inner.to_degrees() - 10.0).abs() < 1e-4 && (outer.to_degrees() - 20.0).abs() < 1e-4);
    assert_eq!((lights[1].direction, lights[1].range), (Vec3::NEG_Y, Some(4.0)));
    assert_eq!(lights[2].kind, LightKind::Point);
    for (wrong, line) in [
        ("[[light]]\nintensity = 1\n", 1),
        ("[[light]]\nkind = 'point'\ndirection = [0, 1, 0]\n", 3),
        ("[[light]]\nkind = 'spot'\nposition = [0, 1, 0]\ntarget = [0, 1, 0]\n", 4),
        ("[[light]]\nkind = 'spot'\ninner = 30\nouter = 20\n", 3),
        ("[[light]]\nkind = 'spot'\nouter = 120\n", 3),
        ("[[light]]\nkind = 'point'\nintensity = -1\n", 3),
    ] {
        assert_eq!(mistake(wrong).line, line, "{wrong}");
    }
}

#[test]
fn settings_are_checked_and_handed_on() {
    let dir = folder();
    let text = "[render]\nsize = [640, 480]\ncurve = 'agx'\npasses = 'depth, all'\ntime = 90\ncamera = 0\nsky = [0.5, 0.5, 1]\nquiet = true\nchoice = { dfg = 'b' }\nseed = 3\n";
    let file = parse(text, dir.path()).expect("good");
    let of = |key: &str| file.settings.iter().find(|s| s.key == key).map(|s| s.value.clone());
    assert_eq!(of("size"), Some(Value::Text("640x480".into())));
    assert_eq!(of("passes"), Some(Value::Texts(vec!["depth".into(), "all".into()])));
    assert_eq!(of("time"), Some(Value::Number(90.0)));
    assert_eq!(of("camera"), Some(Value::Integer(0)));
    assert_eq!(of("sky"), Some(Value::Numbers(vec![0.5, 0.5, 1.0])));
    assert_eq!(of("choice"), Some(Value::Table(vec![("dfg".into(), Value::Text("b".into()))])));
    let sky = parse("[render]\nsky = 'a/b.hdr'\n", dir.path()).expect("good");
    assert_eq!(sky.settings[0].value, Value::Path(dir.path().join("a/b.hdr")));
}

#[test]
fn a_mistake_is_told_with_its_place_and_what_was_meant() {
    let told = |text: &str| {
        let m = mistake(text);
        (m.line, m.column, m.message.clone(), m.help.unwrap_or_default())
    };
    let check = |text: &str, line, column, said: &str, help: &str| {
        let t = told(text);
        assert_eq!((t.0, t.1), (line, column), "{text}: {t:?}");
        assert!(t.2.contains(said) && t.3.contains(help), "{text}: {t:?}");
    };
    check("[[model]]\nfile = 'm.obj'\nrotaton = [0, 1, 2]\n", 3, 1, "no `rotaton`", "`rotation`");
    check("[render]\ncurve = 'agz'\n", 2, 9, "\"agz\"", "\"agx\"");
    check("[rendr]\n", 1, 2, "no `rendr`", "`render`");
    check("seed = 1\n", 1, 1, "no `seed`", "[render]");
    check("[render]\nseed = 10\n", 2, 8, "from 0 to 9", "");
    check("[render]\nsize = [1, 2, 3]\n", 2, 8, "two whole numbers", "");
    check("[render]\nchoice = { dgf = 'a' }\n", 2, 12, "no `dgf`", "`dfg`");
    check("[model]\nfile = 'm.obj'\n", 1, 1, "array of tables", "[[model]]");
    check("[[model]]\nfile = 'm.obj'\nbuiltin = 'helmet'\n", 3, 11, "either", "");
    check("[[model]]\nname = 'x'\n", 1, 1, "names no file", "file =");
    check(
        "[[model]]\nfile = 'm.obj'\nscale = 1\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n",
        3,
        9,
        "matrix",
        "",
    );
    check("[[model]]\nfile = '../m.obj'\n", 2, 8, "outside", "--allow-outside");
    check("[[model]]\nfile = '/etc/passwd'\n", 2, 8, "outside", "--allow-outside");
    check("[[model]]\nfile = 's.toml'\n", 2, 8, "scene file", "");
    check(
        "[[model]]\nfile = 'm.obj'\n[override.rde]\nroughness = 0.1\n",
        3,
        11,
        "no material \"rde\"",
        "\"red\"",
    );
    check("[[model]]\nfile = 'm.obj'\n[override.red]\nroughness = 1.5\n", 4, 13, "from 0 to 1", "");
    check("[[model]]\nfile = 'm.obj'\n[override.red]\nroughness = nan\n", 4, 13, "from 0 to 1", "");
    check("a = = 1\n", 1, 5, "", "");
    check("# é\n[[model]]\nfile = 'm.obj' 'x'\n", 3, 16, "", "");
}

#[test]
fn a_model_that_does_not_load_is_named_with_its_line() {
    let dir = folder();
    let load = |text: &str| {
        load_with(text, dir.path(), &LoadOptions::default()).expect_err("does not load").to_string()
    };
    let e = load("\n[[model]]\nfile = 'none.glb'\n");
    assert!(e.contains("s.toml: line 3") && e.contains("none.glb"), "{e}");
    let e = load("[[model]]\nbuiltin = 'helmet'\n");
    assert!(e.contains("no built-in model"), "{e}");
}

#[test]
fn limits_hold_for_all_models_together() {
    let dir = folder();
    let text = "[[model]]\nfile = 'm.obj'\n".repeat(3);
    let limits = |instances: u64, vertices: u64| {
        let limits = Limits { instances, vertices, ..Limits::default() };
        LoadOptions { import: ImportOptions { limits, ..ImportOptions::default() }, ..LoadOptions::default() }
    };
    assert!(load_with(&text, dir.path(), &limits(100, 6)).is_ok());
    let e = load_with(&text, dir.path(), &limits(7, 6)).expect_err("too many").to_string();
    assert!(e.contains("`instances`"), "{e}");
    let text = "[[model]]\nfile = 'm.obj'\n[[model]]\nfile = 'plain.obj'\n";
    assert!(load_with(text, dir.path(), &limits(100, 9)).is_ok());
    let e = load_with(text, dir.path(), &limits(100, 8)).expect_err("too many").to_string();
    assert!(e.contains("`vertices`"), "{e}");
    // Enough for either of them.
    let memory = |memory_bytes: u64| {
        let limits = Limits { memory_bytes, ..Limits::default() };
        LoadOptions { import: ImportOptions { limits, ..ImportOptions::default() }, ..LoadOptions::default() }
    };
    let alone = |n: u64| load_with("[[model]]\nfile = 'm.obj'\n", dir.path(), &memory(n)).is_ok();
    let least = (1..1 << 16).find(|n| alone(64 * n)).expect("so small a model fits") * 64;
    let both = "[[model]]\nfile = 'plain.obj'\n[[model]]\nfile = 'm.obj'\n";
    let together = |n: u64| load_with(both, dir.path(), &memory(n)).map(|_| ()).map_err(|e| e.to_string());
    assert!(together(least).is_err_and(|e| e.contains("`memory_bytes`")));
    assert_eq!(together(3 * least), Ok(()));
}

/// Every setting of the template, behind `#` without a space, is taken where it stands.
#[test]
fn the_template_says_only_what_the_reader_takes() {
    let dir = folder();
    let text = template(&sections(), &["helmet"], "x.json");
    let file = parse(&text, dir.path()).expect("as it stands");
    assert_eq!((file.models.len(), file.lights.len()), (1, 0));
    let is_setting =
        |l: &str| l.starts_with('#') && !l.starts_with("# ") && !l.starts_with("#:") && l.len() > 1;
    let (mut table, mut count) = (String::new(), 0);
    for line in text.lines() {
        let bare = line.trim_start_matches('#');
        if bare.starts_with('[') {
            table = bare.into();
        } else if is_setting(line) && !bare.starts_with("file =") && !bare.starts_with("kind") {
            let before = if table == "[[light]]" { "kind = 'spot'\n" } else { "" };
            let model = if table == "[[model]]" { "builtin = 'helmet'\n" } else { "" };
            parse(&format!("{table}\n{before}{model}{bare}\n"), dir.path())
                .unwrap_or_else(|e| panic!("{table} {bare}: {e}"));
            count += 1;
        }
    }
    assert!(count > 25, "{count}");
}

/// Every property of the schema's objects is taken by the reader with its default, and every key of the reader is in the
/// schema.
#[test]
fn the_schema_names_what_the_reader_takes() {
    let dir = folder();
    let schema = schema(&sections(), &["helmet"]);
    let properties = |v: &serde_json::Value| -> Vec<(String, Option<serde_json::Value>)> {
        let p = v["properties"].as_object().expect("an object");
        p.iter().map(|(k, v)| (k.clone(), v.get("default").cloned())).collect()
    };
    let mut tried = 0;
    let mut try_all = |header: &str, object: &serde_json::Value| {
        for (key, default) in properties(object) {
            let e = match default {
                Some(d) => parse(&format!("{header}{key} = {d}\n"), dir.path()).err(),
                // Any value of the wrong kind shows that the key is known.
                None => match parse(&format!("{header}{key} = 1979-05-27\n"), dir.path()) {
                    Err(e) if e.to_string().contains("there is no") => Some(e),
                    _ => None,
                },
            };
            assert!(e.is_none(), "{header} {key}: {e:?}");
            tried += 1;
        }
    };
    let p = &schema["properties"];
    for (name, section) in p.as_object().expect("an object") {
        match name.as_str() {
            "model" => try_all("[[model]]\nfile = 'm.obj'\n", &{
                let mut m = section["items"].clone();
                m["properties"].as_object_mut().expect("an object").retain(|k, _| k != "file");
                m
            }),
            "light" => try_all("[[light]]\nkind = 'spot'\n", &{
                let mut m = section["items"].clone();
                m["properties"].as_object_mut().expect("an object").retain(|k, _| k != "kind");
                m
            }),
            "override" => {}
            name => try_all(&format!("[{name}]\n"), section),
        }
    }
    let shapes = schema["definitions"]["override"]["oneOf"].as_array().expect("shapes");
    assert_eq!(shapes.len(), 2 + etendue_bxdf::model::Model::NAMES.len());
    for shape in shapes {
        let names = &shape["properties"]["model"]["enum"];
        let header = match names.as_array() {
            Some(n) => format!("[override.a]\nmodel = {}\n", n[0]),
            None => "[override.a]\n".to_owned(),
        };
        let mut shape = shape.clone();
        shape["properties"].as_object_mut().expect("an object").retain(|k, _| k != "model");
        try_all(&header, &shape);
    }
    assert!(tried > 300, "{tried}");
    // The other way round: what the reader lists as known is what the schema has.
    for (text, object) in [
        ("[[model]]\nfile = 'm.obj'\nqqqqqqqqqq = 1\n", &p["model"]["items"]),
        ("[render]\nqqqqqqqqqq = 1\n", &p["render"]),
        ("[override.a]\nqqqqqqqqqq = 1\n", &shapes[0]),
    ] {
        let m = mistake(text);
        let listed = m.help.expect("a list");
        let mut listed: Vec<_> =
            listed.trim_start_matches("there are ").split(", ").map(str::to_owned).collect();
        listed.retain(|k| !["model", "measured"].contains(&&k[..]));
        let mut known: Vec<_> = properties(object).into_iter().map(|(k, _)| k).collect();
        known.sort_unstable();
        assert_eq!(listed, known, "{text}");
    }
}

/// Every part of a material that is not its name or what stands in for it can be overridden.
#[test]
fn every_parameter_of_a_material_has_a_key() {
    use etendue_scene::*;
    let m = Material {
        extensions: Some(Box::new(Extensions {
            anisotropy: Some(Default::default()),
            clearcoat: Some(Default::default()),
            diffuse_roughness: Some(Default::default()),
            diffuse_transmission: Some(Default::default()),
            fuzz: Some(Default::default()),
            iridescence: Some(Default::default()),
            scatter: Some(Default::default()),
            sheen: Some(Default::default()),
            specular_glossiness: Some(Default::default()),
            transmission: Some(Default::default()),
            volume: Some(Default::default()),
            ..Default::default()
        })),
        ..Material::default()
    };
    let debug = format!("{m:?}");
    let mut fields: Vec<&str> =
        debug.split([' ', '{', '(', ',']).filter_map(|w| w.strip_suffix(':')).collect();
    fields.sort_unstable();
    fields.dedup();
    // Fields of the extensions have keys that begin with the extension's name.
    let known = schema(&[], &[]).to_string();
    let under_another_name = [
        ("extensions", "sheen_color"),
        ("substitute", "model"),
        ("name", "override"),
        ("anisotropy", "anisotropy_strength"),
        ("strength", "anisotropy_strength"),
        ("rotation", "anisotropy_rotation"),
        ("color", "sheen_color"),
        ("color_texture", "sheen_color_texture"),
        ("roughness_texture", "sheen_roughness_texture"),
        ("factor", "clearcoat"),
        ("darkening", "coat_darkening"),
        ("sheen", "sheen_color"),
        ("specular_glossiness", "glossiness"),
        ("texture", "transmission_texture"),
        ("volume", "thickness"),
        ("scatter", "scatter_strength"),
    ];
    for f in fields {
        let key = under_another_name.iter().find(|(a, _)| *a == f).map_or(f, |(_, k)| k);
        assert!(known.contains(&format!("\"{key}\":")), "Material::{f} has no key in a scene file");
    }
}

/// A scene file that is read once shows at each moment what loading it at that time shows, without any of its files, and shares
/// what does not change.
#[test]
fn moments_of_a_scene_are_loaded_once() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    // A triangle that moves, with texture coordinates but no tangents.
    let floats: [f32; 23] =
        [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1., 0., 2., 0., 0., 0., 5., 0., 0.];
    let bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(at("move.bin"), &bytes).unwrap();
    let accessor = |offset: usize, count: usize, shape: &str| {
        format!(
            r#"{{"bufferView":0,"byteOffset":{offset},"componentType":5126,"count":{count},"type":"{shape}"}}"#
        )
    };
    let list =
        [accessor(0, 3, "VEC3"), accessor(36, 3, "VEC2"), accessor(60, 2, "SCALAR"), accessor(68, 2, "VEC3")];
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"move.bin","byteLength":92}}],
        "bufferViews":[{{"buffer":0,"byteLength":92}}],"accessors":[{}],"materials":[{{"name":"skin"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"scene":0,
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}],
        "samplers":[{{"input":2,"output":3}}]}}]}}"#,
        list.join(",")
    );
    std::fs::write(at("move.gltf"), text).unwrap();
    let scene = "[[model]]\nfile = 'move.gltf'\nat = 1\n[[model]]\nfile = 'move.gltf'\ntranslation = [0, 3, 0]\n\
        [[model]]\nfile = 'm.obj'\n[override.skin]\nnormal_texture = 'pixel.png'\nbase_color_texture = 'pixel.png'\n";
    let times = [None, Some(0.5f32), Some(1.5), None];
    let load = |t: Option<f32>| {
        let options =
            LoadOptions { import: ImportOptions { at: t, ..Default::default() }, ..Default::default() };
        load_with(scene, dir.path(), &options).unwrap()
    };
    let expected: Vec<Imported> = times.iter().map(|t| load(*t)).collect();
    assert_eq!(expected[1].scene.instances[0].transform.translation.x, 1.25);
    assert!(!expected[0].scene.meshes[0].tangents.is_empty());
    let models = parse(scene, dir.path()).unwrap().with_models(&LoadOptions::default()).unwrap();
    let moving = models.open();
    let text = |i: &Imported| {
        let s = &i.scene;
        let parts = (&s.meshes, &s.instances, &s.materials, &s.textures, &s.images, &s.lights, &s.cameras);
        format!("{parts:?} {:?}", i.warnings)
    };
    // Buffers and pictures are read with the first moment.
    assert!(text(&moving.at(None).unwrap()) == text(&expected[0]));
    let digest = moving.digest().unwrap();
    drop(dir);
    let mut before: Option<Imported> = None;
    for (t, e) in times.iter().zip(&expected) {
        let now = moving.at(t.map(f64::from)).unwrap_or_else(|e| panic!("at {t:?}: {e}"));
        assert!(text(&now) == text(e), "at {t:?}");
        if let (Some(b), Some(_)) = (&before, t) {
            let same = |a: &[Arc<etendue_scene::Mesh>], b: &[Arc<etendue_scene::Mesh>]| {
                a.iter().filter(|m| b.iter().any(|n| Arc::ptr_eq(m, n))).count()
            };
            assert_eq!(same(&now.scene.meshes, &b.scene.meshes), now.scene.meshes.len(), "at {t:?}");
        }
        before = Some(now);
    }
    assert_eq!(moving.digest().unwrap(), digest);
}
