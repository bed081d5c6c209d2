//! What goes wrong: the exit code, and a message that names file, cause and way out.

use crate::lab::{Lab, triangle};

#[test]
fn wrong_usage_is_two() {
    let lab = Lab::new();
    for (line, named) in [
        ("render --frobnicate", "--frobnicate"),
        ("frobnicate", "frobnicate"),
        ("render --spp 0", "--spp"),
        ("render --size 0x10", "1280x720"),
        ("render --size 70000x10", "1280x720"),
        ("render --size 65536x65536", "pixels"),
        ("render --noise -1", "--noise"),
        ("render --time soon", "90s"),
        ("render --samples 4..4", "0..64"),
        ("render --samples 0..4 --spp 4", "--spp"),
        ("render --passes shiny -o a.exr", "shiny"),
        ("render --passes depth -o a.png", ".exr"),
        ("render --passes depth", "etendue.png"),
        ("render --curve purple", "purple"),
        ("render --env-rotation nan", "--env-rotation"),
        ("render --at inf", "--at"),
        ("render --env=-1,0,0", "negative"),
        ("render -o picture.tga", ".tga"),
        ("render -o picture", "extension"),
        ("render --eye 0,0", "three numbers"),
        ("render --target 0,0,0", "--eye"),
        ("merge -o a.png", "FILMS"),
        ("tonemap", "INPUT"),
        ("tonemap a.exr -o a.gif", "a.gif"),
    ] {
        lab.run(line).ends_with(2).says(&[named]);
    }
    // Told before the work: nothing has been written.
    assert_eq!(lab.files(), [""; 0]);
    for line in ["--help", "help render", "--version", "render -h"] {
        let run = lab.run(line).ends_with(0);
        assert!(run.out.contains("etendue") || run.out.contains("Usage"), "{line}: {}", run.out);
    }
}

#[test]
fn missing_files_are_named_with_where_they_were_looked_for() {
    let lab = Lab::new();
    let here = lab.folder().canonicalize().unwrap();
    let at = |name: &str| here.join(name).display().to_string();
    lab.run("render models/none.glb").ends_with(1).says(&["models/none.glb", &at("models/none.glb")]);
    lab.run("info none.gltf").ends_with(1).says(&["none.gltf", &at("none.gltf")]);
    lab.run("render --env sky.hdr").ends_with(1).says(&["sky.hdr", &at("sky.hdr"), "studio"]);
    lab.run("tonemap none.exr -o a.png").ends_with(1).says(&["none.exr", &at("none.exr")]);
    lab.run("merge none.film -o a.png").ends_with(1).says(&["none.film", &at("none.film")]);
    lab.write(
        "image.gltf",
        triangle(r#","images":[{"uri":"lost/wood.png"}],"textures":[{"source":0}]"#).replace(
            r#""pbrMetallicRoughness":{"#,
            r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0},"#,
        ),
    );
    lab.run("render image.gltf").ends_with(1).says(&["image.gltf", "/images/0", "lost/wood.png"]);
    lab.write("buffer.gltf", triangle("").replace("data:application/octet-stream,", "lost.bin?"));
    lab.run("render buffer.gltf").ends_with(1).says(&["buffer.gltf", "/buffers/0", "lost.bin"]);
    // Not one of them left a picture behind.
    assert_eq!(lab.files(), ["buffer.gltf", "image.gltf"]);
}

#[test]
fn files_of_another_kind_are_errors() {
    let lab = Lab::new();
    lab.write("text.glb", "this is no model");
    lab.write("text.hdr", "this is no sky");
    lab.write("text.exr", "this is no picture");
    lab.write("cut.gltf", &triangle("")[..200]);
    std::fs::create_dir(lab.path("folder.glb")).unwrap();
    lab.run("render text.glb").ends_with(1).says(&["text.glb"]);
    lab.run("render cut.gltf").ends_with(1).says(&["cut.gltf", "line"]);
    lab.run("render folder.glb").ends_with(1).says(&["folder.glb"]);
    lab.run("render --env text.hdr").ends_with(1).says(&["text.hdr", "not a picture"]);
    lab.run("render --env folder.glb").ends_with(1).says(&["folder.glb"]);
    lab.run("tonemap text.exr -o a.png").ends_with(1).says(&["text.exr", "not a picture"]);
}

#[test]
fn where_nothing_can_be_written_is_told_before_the_work() {
    let lab = Lab::new();
    lab.write("file", "");
    std::fs::create_dir(lab.path("folder.png")).unwrap();
    let endless = "--spp 1000000000";
    lab.run(&format!("render {endless} -o none/a.png")).ends_with(1).says(&["none/a.png", "no folder"]);
    lab.run(&format!("render {endless} -o file/a.png")).ends_with(1).says(&["file/a.png"]);
    lab.run(&format!("render {endless} -o folder.png")).ends_with(1).says(&["folder.png", "folder"]);
    lab.run(&format!("render {endless} --film none/a.film")).ends_with(1).says(&["none/a.film"]);
    if cfg!(target_os = "linux") {
        // Nobody makes files in there, whatever his rights.
        lab.run(&format!("render {endless} -o /proc/a.png")).ends_with(1).says(&["/proc/a.png"]);
    }
    assert_eq!(lab.files(), ["file", "folder.png"]);
}

#[cfg(unix)]
#[test]
fn a_failed_write_leaves_the_old_picture_and_keeps_the_samples() {
    use std::process::Command;
    let lab = Lab::new();
    lab.ok("render --size 16x16 --spp 1 -o a.png");
    let old = lab.bytes("a.png");
    // Files may grow to one block of 512 or 1024 bytes: what a full disk does, in the middle of the picture.
    let script = format!(
        "trap '' XFSZ; ulimit -f 1; exec {} render --size 200x200 --spp 1 -o a.png",
        env!("CARGO_BIN_EXE_etendue")
    );
    let o = Command::new("sh").args(["-c", &script]).current_dir(lab.folder()).output().unwrap();
    let err = String::from_utf8_lossy(&o.stderr);
    assert_eq!(o.status.code(), Some(1), "{err}");
    assert!(err.contains("cannot write a.png") && !err.contains("panicked"), "{err}");
    assert_eq!(lab.bytes("a.png"), old);
    assert_eq!(lab.files(), ["a.png"]);
    // Only the picture's place fails: the film is kept and becomes a picture elsewhere.
    std::os::unix::fs::symlink("/dev/full", lab.path("full.png")).unwrap();
    if cfg!(target_os = "linux") {
        let run = lab.run("render --size 16x16 --spp 1 -o full.png").ends_with(1);
        run.says(&["cannot write full.png", "etendue merge full.film"]);
        lab.ok("merge full.film -o saved.png");
        assert_eq!(lab.image("saved.png"), lab.image("a.png"));
    }
}

#[cfg(unix)]
#[test]
fn readers_that_go_away_are_no_error() {
    use std::process::Command;
    let lab = Lab::new();
    let exe = env!("CARGO_BIN_EXE_etendue");
    for command in ["info", "info --json", "help render", "render --size 8x8 --spp 1"] {
        let script = format!("{exe} {command} 2>err | head -c 1 >out; cat err");
        let o = Command::new("sh").args(["-c", &script]).current_dir(lab.folder()).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&o.stdout), "", "{command}");
    }
    if cfg!(target_os = "linux") {
        let script = format!("{exe} info >/dev/full");
        let o = Command::new("sh").args(["-c", &script]).output().unwrap();
        assert_eq!(o.status.code(), Some(1));
    }
}

#[cfg(unix)]
#[test]
fn names_that_are_not_unicode_are_names() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let lab = Lab::new();
    let name = OsStr::from_bytes(b"bad\xff name.png");
    let o = std::process::Command::new(env!("CARGO_BIN_EXE_etendue"))
        .current_dir(lab.folder())
        .args(["render", "--size", "8x8", "--spp", "1", "--json", "-o"])
        .arg(name)
        .output()
        .unwrap();
    assert_eq!(o.status.code(), Some(0), "{}", String::from_utf8_lossy(&o.stderr));
    assert!(lab.folder().join(name).exists());
}
