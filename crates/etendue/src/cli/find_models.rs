//! Models in folders.

use super::CliError;
use std::path::{Path, PathBuf};

/// Extensions of models.
const EXTENSIONS: [&str; 5] = ["glb", "gltf", "obj", "ply", "stl"];

/// Folders within one another that are looked through.
const MOST_DEPTH: u32 = 64;

/// The files among `paths` as they stand, and the models in those that are folders, however deep, in the order of their
/// paths. Links to folders are not followed.
///
/// # Errors
/// If a folder cannot be read, or holds no model.
pub(crate) fn find_models(paths: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut out = Vec::new();
    for path in paths {
        if !path.is_dir() {
            out.push(path.clone());
            continue;
        }
        let before = out.len();
        walk(path, MOST_DEPTH, &mut out)?;
        if out.len() == before {
            return Err(CliError::Usage(format!(
                "there is no model (.{}) in {}",
                EXTENSIONS.join(", ."),
                path.display()
            )));
        }
        out[before..].sort();
    }
    Ok(out)
}

fn walk(folder: &Path, depth: u32, out: &mut Vec<PathBuf>) -> Result<(), CliError> {
    let fail = |source| CliError::Read { path: folder.to_path_buf(), source };
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        let path = entry.path();
        if entry.file_type().map_err(fail)?.is_dir() {
            if depth > 1 {
                walk(&path, depth - 1, out)?;
            }
        } else if is_model(&path) {
            out.push(path);
        }
    }
    Ok(())
}

fn is_model(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    EXTENSIONS.iter().any(|e| extension == *e)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_found_in_order_however_deep() {
        let dir = tempfile::tempdir().expect("a folder");
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir_all(at("b/c")).expect("folders");
        std::fs::create_dir_all(at("empty")).expect("folders");
        for name in ["z.glb", "b/c/a.GLTF", "b/a.bin", "b/x.stl", "a.png"] {
            std::fs::write(at(name), "").expect("a file");
        }
        let found = find_models(&[at("a.png"), dir.path().to_path_buf()]).expect("readable");
        assert_eq!(found, ["a.png", "b/c/a.GLTF", "b/x.stl", "z.glb"].map(at));
        assert!(matches!(find_models(&[at("empty")]), Err(CliError::Usage(_))));
    }
}
