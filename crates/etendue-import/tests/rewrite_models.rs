//! Models of other programs, written again: they show the same at every moment, and are then written as they are.
mod common;
use common::scenes::{Tangents, assert_same};
use etendue_import::{AnimationChoice, Form, ImportOptions, ModelFile};
use std::path::{Path, PathBuf};

/// Models that have between them all that moves, all compressions, external files and variants; and whether they are posed
/// meshes that get tangents.
const MODELS: &[&str] = &[
    "AnimatedMorphCube/AnimatedMorphCube.glb",
    "AnimatedMorphCube-glTF-Quantized/AnimatedMorphCube.gltf",
    "AnimatedTriangle/AnimatedTriangle.gltf",
    "Box-glTF-Draco/Box.gltf",
    "Cameras/Cameras.gltf",
    "CesiumMan-glTF-Draco/CesiumMan.gltf",
    "CesiumMilkTruck/CesiumMilkTruck.glb",
    "ClearCoatTest/ClearCoatTest.glb",
    "Cube/Cube.gltf",
    "Duck-glTF-Draco/Duck.gltf",
    "Fox/Fox.glb",
    "InterpolationTest/InterpolationTest.glb",
    "MaterialsVariantsShoe/MaterialsVariantsShoe.gltf",
    "MorphStressTest/MorphStressTest.glb",
    "NormalTangentTest/NormalTangentTest.glb",
    "RiggedSimple/RiggedSimple.glb",
    "SheenChair/SheenChair.gltf",
    "SimpleInstancing/SimpleInstancing.glb",
    "SimpleMorph/SimpleMorph.gltf",
    "SimpleSkin/SimpleSkin.gltf",
    "SimpleSparseAccessor/SimpleSparseAccessor.gltf",
    "bio-24_animation_pointer/24_animation_pointer.gltf",
    "cesium-DuckMeshopt-12bit/Duck-vp-12-vt-12-vn-12.glb",
    "gk-stanford-bunny-bunny/bunny.glb",
    "gltftransform-BoxMeshopt/BoxMeshopt.glb",
    "gltftransform-DenseSphere/DenseSphere.glb",
    "gltftransform-DracoSparseMesh/DracoSparseMesh.gltf",
    "khr-lights/lights.gltf",
    "nanogl-CesiumBoxWebp/CesiumBoxWebp.gltf",
    "pc-carbon-sphere/carbon-sphere.glb",
    "tinygltf-UriSpaces/CubeImageUriSpaces.gltf",
];

#[test]
fn models_of_other_programs_stay_what_they_are() {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/models"));
    if !root.exists() {
        println!("skipped: {} is absent", root.display());
        return;
    }
    let options = ImportOptions { animation: AnimationChoice::All, ..ImportOptions::default() };
    let (mut seen, mut moving, mut split) = (0, 0, 0);
    for name in MODELS {
        let Ok(file) = ModelFile::read(&root.join(name), &options) else {
            println!("skipped: {name}");
            continue;
        };
        let again = file.rewrite(Form::Binary).unwrap().unwrap();
        assert_eq!(again.notes, Vec::<String>::new(), "{name}");
        // Without its neighbours.
        let written = ModelFile::from_bytes(&again.bytes, "written", &options);
        assert!(
            written.rewrite(Form::Binary).unwrap().unwrap().bytes == again.bytes,
            "{name}: no fixed point"
        );

        let (before, after) = (file.open().unwrap(), written.open().unwrap());
        let duration = before.duration().unwrap();
        assert_eq!(duration, after.duration().unwrap(), "{name}");
        let mut times = vec![None];
        times.extend(
            duration.iter().flat_map(|d| [0.31, 0.77].map(|k| Some(d.start() + k * (d.end() - d.start())))),
        );
        let posed = again.info.counts.skins > 0
            || again.info.meshes.iter().flat_map(|m| &m.primitives).any(|p| p.morph_targets > 0);
        let tangents = match again.changes.tangents {
            0 => Tangents::Same,
            _ if posed => Tangents::Any,
            _ => Tangents::Near,
        };
        for at in &times {
            let (a, b) = (before.at(*at).unwrap(), after.at(*at).unwrap());
            assert_same(&a.scene, &b.scene, tangents, &format!("{name} at {at:?}"));
        }
        let text = file.rewrite(Form::Text).unwrap().unwrap().bytes;
        let back = ModelFile::from_bytes(&text, "text", &options).rewrite(Form::Binary).unwrap().unwrap();
        assert!(back.bytes == again.bytes, "{name}: the text form holds something else");
        seen += 1;
        moving += usize::from(times.len() > 1);
        split += again.changes.split_vertices;
    }
    println!("{seen} models, {moving} of them at three times, {split} vertices split");
    assert!(2 * seen > MODELS.len(), "{seen} of {} models were found", MODELS.len());
}

#[test]
fn what_is_broken_is_refused_as_by_the_importer() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/malformed"));
    if !root.exists() {
        println!("skipped: {} is absent", root.display());
        return;
    }
    let mut folders = vec![root.to_path_buf()];
    let (mut both, mut neither, mut only) = (0, 0, Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if matches!(path.extension().and_then(|e| e.to_str()), Some("gltf" | "glb")) {
                let options = ImportOptions::default();
                let shown = etendue_import::import(&path, &options).map(|_| ());
                let again = ModelFile::read(&path, &options)
                    .map_err(|e| e.to_string())
                    .and_then(|f| f.rewrite(Form::Binary).map_err(|e| e.to_string()));
                match (shown, again) {
                    (Err(e), Err(f)) => {
                        assert_eq!(e.to_string(), f);
                        neither += 1;
                    }
                    (Err(e), Ok(_)) => panic!("{}: {e}, but written", path.display()),
                    (Ok(()), Ok(again)) => {
                        let bytes = again.unwrap().bytes;
                        let options = ImportOptions::default();
                        let file = ModelFile::from_bytes(&bytes, "again", &options);
                        let twice = file.rewrite(Form::Binary);
                        let twice = twice.unwrap_or_else(|e| panic!("{}: {e}", path.display())).unwrap();
                        assert!(twice.bytes == bytes, "{}: no fixed point", path.display());
                        both += 1;
                    }
                    (Ok(()), Err(e)) => only.push(e),
                }
            }
        }
    }
    println!("{both} written, {neither} refused by both, {} shown but not written:", only.len());
    only.iter().for_each(|e| println!("  {e}"));
    // Views that nothing shows, and that lie outside of their buffers or in such that there are not; references to nothing.
    let known = ["/buffers/", "/bufferViews/", "something refers to"];
    assert!(only.iter().all(|e| known.iter().any(|k| e.contains(k))), "{only:?}");
}
