//! Which reader a file is for: by what it contains where that can be told, by its name else.

use crate::error::Fault;
use crate::import::{ImportOptions, Imported};
use crate::text::{Lines, split_word};
use crate::{gltf, obj, ply, stl};
use std::path::Path;

/// The formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Gltf,
    Obj,
    Ply,
    Stl,
}

/// Reads a model of any known format.
pub(crate) fn read(
    bytes: &[u8],
    name: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, Fault> {
    match kind(bytes, name)? {
        Kind::Gltf => gltf::read(bytes, name, folder, options),
        Kind::Obj => obj::read(bytes, name, folder, options),
        Kind::Ply => ply::read(bytes, name, folder, options),
        Kind::Stl => stl::read(bytes, name, options),
    }
}

/// The format of a model.
pub(crate) fn kind(bytes: &[u8], name: &str) -> Result<Kind, Fault> {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if bytes.starts_with(b"glTF") || start.starts_with(b"{") {
        return Ok(Kind::Gltf);
    }
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Ok(Kind::Ply);
    }
    if stl::is_binary(bytes) {
        return Ok(Kind::Stl);
    }
    let extension = Path::new(name).extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("obj") => return Ok(Kind::Obj),
        Some("ply") => return Ok(Kind::Ply),
        Some("stl") => return Ok(Kind::Stl),
        // What their reader says of the content is to the point.
        Some("gltf" | "glb") => return Ok(Kind::Gltf),
        _ => {}
    }
    if split_word(&start[..start.len().min(1 << 10)]).0 == b"solid" {
        return Ok(Kind::Stl);
    }
    if is_obj(bytes) {
        return Ok(Kind::Obj);
    }
    Err(Fault::byte(
        0,
        if start.is_empty() {
            "the file is empty"
        } else {
            "not a model that is known: neither glTF (starts with `{`), GLB (`glTF`), PLY (`ply`) nor STL (`solid`), and no OBJ; a file with the extension .obj, .ply or .stl is read as such"
        },
    ))
}

/// True if the first lines that say anything say what only OBJ says.
fn is_obj(bytes: &[u8]) -> bool {
    let mut said = false;
    for (_, line) in Lines::new(&bytes[..bytes.len().min(1 << 14)]).take(200) {
        match split_word(&line).0 {
            [] | [b'#', ..] => {}
            b"mtllib" | b"v" | b"vn" | b"vt" | b"o" | b"g" | b"usemtl" | b"s" | b"f" => said = true,
            _ => return false,
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_goes_before_the_name() {
        let of = |bytes: &[u8], name: &str| kind(bytes, name).ok();
        assert_eq!(of(b" {\"asset\":{}}", "a.obj"), Some(Kind::Gltf));
        assert_eq!(of(b"ply\nformat ascii 1.0\n", "a.stl"), Some(Kind::Ply));
        let mut stl = vec![b's'; 84 + 50];
        stl[..5].copy_from_slice(b"solid");
        stl[80..84].copy_from_slice(&1u32.to_le_bytes());
        assert_eq!(of(&stl, "a"), Some(Kind::Stl), "binary in spite of its first word");
        assert_eq!(of(b"solid x\n", "a"), Some(Kind::Stl));
        assert_eq!(of(b"# Blender\nmtllib a.mtl\no Cube\nv 1 2 3\n", "a"), Some(Kind::Obj));
        assert_eq!(of(b"anything", "a.OBJ"), Some(Kind::Obj));
        assert_eq!(of(b"anything", "a.glb"), Some(Kind::Gltf));
        assert_eq!((of(b"anything", "a.fbx"), of(b"", "a")), (None, None));
    }
}
