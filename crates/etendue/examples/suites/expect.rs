//! What a suite expects of its files.

use std::path::Path;

/// What a reader should make of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// It is to be read, and there is nothing to say.
    Valid,
    /// It is to be read; the suite does not say that nothing is wrong with it.
    Readable,
    /// It breaks its format's rules: to be refused, or read with a warning.
    Invalid,
    /// The suite does not say; whatever comes, it must come in time and within bounds.
    Either,
}

/// Whether the file is one of the cases, and not a part of another or a note about them.
pub fn is_meant(suite: &str, path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if suite.starts_with("gltf-") {
        return matches!(extension.as_str(), "gltf" | "glb");
    }
    let notes = ["txt", "md", "rst", "list", "py", "toml", "bin", "tiff", "readme", "sh", "ini"];
    !notes.contains(&extension.as_str())
}

/// What `suite` says of the file that lies at `inside` in it.
pub fn expected(suite: &str, inside: &Path, path: &Path) -> Expected {
    let name = inside.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let broken_if = |broken: bool| if broken { Expected::Invalid } else { Expected::Readable };
    match suite {
        // The validator's report says how many rules are broken.
        // A buffer without data is none of them, but there is nothing to show.
        "gltf-khronos-validator"
            if ["named_objects.gltf", "unused_objects.gltf"].contains(&name.as_str()) =>
        {
            Expected::Either
        }
        "gltf-khronos-validator" => match errors(path) {
            Some([0, 0]) => Expected::Valid,
            Some([0, _]) => Expected::Readable,
            Some(_) => Expected::Invalid,
            None => Expected::Either,
        },
        // Files are named after what is wrong with them; some are about what that importer does not support, or about its own
        // extensions.
        "gltf-magnum" if name.starts_with("image-basis") || name.contains("ktx") => Expected::Either,
        // Animations without channels, rows of three bytes, C's suffix of numbers in JSON: that importer does not look at them.
        "gltf-magnum"
            if ["escaped-strings", "mesh-morph-target", "scene-custom-fields"]
                .iter()
                .any(|n| name.starts_with(n)) =>
        {
            Expected::Invalid
        }
        // Both of the extensions that it requires are read here.
        "gltf-magnum" if name == "required-extensions-unsupported.gltf" => Expected::Readable,
        "gltf-magnum" => broken_if(["invalid", "unsupported", "oob"].iter().any(|w| name.contains(w))),
        "gltf-cesium" | "gltf-tinygltf" if name.contains("issue") => Expected::Either,
        "gltf-cesium" | "gltf-tinygltf" => broken_if(name.contains("invalid")),
        // Scenes without nodes are valid, but not to that importer.
        "gltf-assimp-invalid" if name == "scenewithoutnodes.gltf" => Expected::Readable,
        // These two are only more than that reader knows: OpenEXR's own tests read them (testBackwardCompatibility, read_scans).
        "exr-exrs-invalid" if name.starts_with("v1.7.test.") => Expected::Readable,
        "gltf-assimp-invalid" | "png-pngsuite-corrupt" | "exr-exrs-invalid" => Expected::Invalid,
        "ktx2-khronos-cts-validate" if name.starts_with("valid_") => Expected::Valid,
        "ktx2-khronos-cts-validate" => broken_if(name.starts_with("error_") || name.starts_with("fatal_")),
        "png-imagepng-bugfixes" => broken_if(name.starts_with("x_")),
        // Other formats than any that is read here.
        "image-rs-bad" if !name.ends_with(".png") => Expected::Invalid,
        "image-magnum" if name.contains("incomplete") || name == "version1.ktx" => Expected::Either,
        "image-magnum" | "image-rs-bad" => Expected::Readable,
        "exr-openexr-damaged" | "image-openimageio-corrupt" | "gltf-draco" => Expected::Either,
        _ if suite.contains("fuzz") || suite.contains("crash") || suite.contains("seeds") => Expected::Either,
        // What is left stands among the valid pictures.
        _ => Expected::Valid,
    }
}

/// Errors and warnings in the validator's report beside the file.
fn errors(path: &Path) -> Option<[u64; 2]> {
    let mut report = path.as_os_str().to_owned();
    report.push(".report.json");
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(report).ok()?).ok()?;
    Some([json["issues"]["numErrors"].as_u64()?, json["issues"]["numWarnings"].as_u64()?])
}
