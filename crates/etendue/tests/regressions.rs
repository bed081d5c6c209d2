//! What the fuzzers once found, replayed: `fuzz/regressions/TARGET/` holds the inputs, `fuzz/bodies/TARGET.rs` says what has to hold.

use std::path::Path;

#[path = "../../../fuzz/bodies/draco.rs"]
mod draco;
#[path = "../../../fuzz/bodies/exr.rs"]
mod exr;
#[path = "../../../fuzz/bodies/gltf.rs"]
mod gltf;
#[path = "../../../fuzz/bodies/hdr.rs"]
mod hdr;
#[path = "../../../fuzz/bodies/ies.rs"]
mod ies;
#[path = "../../../fuzz/bodies/ktx2.rs"]
mod ktx2;
#[path = "../../../fuzz/bodies/meshopt.rs"]
mod meshopt;
#[path = "../../../fuzz/bodies/obj.rs"]
mod obj;
#[path = "../../../fuzz/bodies/picture.rs"]
mod picture;
#[path = "../../../fuzz/bodies/ply.rs"]
mod ply;
#[path = "../../../fuzz/bodies/scene_toml.rs"]
mod scene_toml;
#[path = "../../../fuzz/bodies/stl.rs"]
mod stl;

type Body = fn(&[u8]);

const BODIES: [(&str, Body); 12] = [
    ("draco", draco::run),
    ("exr", exr::run),
    ("gltf", gltf::run),
    ("hdr", hdr::run),
    ("ies", ies::run),
    ("ktx2", ktx2::run),
    ("meshopt", meshopt::run),
    ("obj", obj::run),
    ("picture", picture::run),
    ("ply", ply::run),
    ("scene_toml", scene_toml::run),
    ("stl", stl::run),
];

#[test]
fn what_was_found_is_mended() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/regressions"));
    let mut count = 0;
    for target in std::fs::read_dir(folder).expect("the folder of regressions") {
        let target = target.expect("an entry").path();
        let name = target.file_name().and_then(|n| n.to_str()).expect("a name");
        let body = BODIES.iter().find(|b| b.0 == name).unwrap_or_else(|| panic!("{name} is no target")).1;
        for file in std::fs::read_dir(&target).expect("inputs") {
            let file = file.expect("an entry").path();
            println!("{}", file.display());
            body(&std::fs::read(&file).expect("an input"));
            count += 1;
        }
    }
    assert!(count > 0);
}

/// Nothing, and a little of everything, is an input like any other.
#[test]
fn every_target_takes_any_bytes() {
    for (name, body) in BODIES {
        println!("{name}");
        for length in [0, 1, 4, 13, 80, 300] {
            body(&(0..length).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect::<Vec<_>>());
        }
    }
}
