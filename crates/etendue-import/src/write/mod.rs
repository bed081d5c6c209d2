//! Scenes back into files: glTF 2.0 as one file, GLB or JSON with everything in it.
//!
//! Pictures are written as they were read where their files were kept ([`crate::ImportOptions::image_files`]) and glTF
//! knows the format; others become PNG, which loses nothing. Meshes have the tangents that the import gave them. The scene's
//! instances become nodes under their names; many of one mesh in a row become one node with `EXT_mesh_gpu_instancing`.
//!
//! A scene is one moment, so there are no animations, skins or morph targets in what is written, and no hierarchy. Whoever has a
//! glTF file and wants a glTF file keeps them with [`crate::ModelFile::rewrite`].

mod document;
mod material;
mod place;
mod scene;

pub use document::{Document, Sampling};

use crate::ImageFile;
use crate::extensions as ext;
use etendue_image::{ImageError, PictureFormat, WriteOptions, encode_picture};
use etendue_scene::Scene;
use serde_json::{Value, json};

/// The two forms of a glTF file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// GLB: JSON and bytes in one container.
    #[default]
    Binary,
    /// `.gltf`: JSON that holds its bytes as a data URI.
    Text,
}

/// What is said in the file beside the scene.
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    /// GLB or JSON.
    pub form: Form,
    /// Whose it is.
    pub copyright: Option<String>,
    /// Name of the scene.
    pub name: Option<String>,
    /// Packets of JSON-LD about it (`KHR_xmp_json_ld`), as in [`crate::Info::xmp`].
    pub xmp: Vec<Value>,
    /// The packet that is about the whole file.
    pub xmp_of_asset: Option<u32>,
}

/// A written file.
#[derive(Clone, Debug)]
pub struct Exported {
    /// The file.
    pub bytes: Vec<u8>,
    /// What could not be said in glTF, and was left out or approximated; each once.
    pub notes: Vec<String>,
}

/// Why a scene cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// GLB counts its bytes in 32 bits.
    #[error("{0} bytes are more than glTF can hold in one file (4 GiB)")]
    TooLarge(u64),
    /// A picture cannot be encoded.
    #[error("image {image} cannot be written: {source}")]
    Image {
        /// Its number in the scene.
        image: usize,
        /// Why not.
        source: ImageError,
    },
    /// The scene contradicts itself.
    #[error(transparent)]
    Scene(#[from] etendue_scene::InvalidScene),
}

/// Writes `scene` as glTF. `files` are the files of its images, as in [`crate::Imported::image_files`]; it may be shorter or
/// empty.
///
/// ```no_run
/// use etendue_import::{ExportOptions, ImportOptions, export, import};
/// let options = ImportOptions { image_files: true, ..ImportOptions::default() };
/// let model = import("chair.obj".as_ref(), &options)?;
/// let file = export(&model.scene, &model.image_files, &ExportOptions::default())?;
/// std::fs::write("chair.glb", file.bytes)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ExportError`].
pub fn export(
    scene: &Scene,
    files: &[Option<ImageFile>],
    options: &ExportOptions,
) -> Result<Exported, ExportError> {
    scene.validate()?;
    let mut doc = Document::new(concat!("etendue ", env!("CARGO_PKG_VERSION")));
    if let Some(c) = &options.copyright {
        doc.asset("copyright", json!(c));
    }
    if !options.xmp.is_empty() {
        doc.extension(ext::XMP, json!({ "packets": options.xmp }));
        if let Some(packet) = options.xmp_of_asset {
            doc.asset("extensions", json!({ ext::XMP: { "packet": packet } }));
        }
    }
    let mut notes = Vec::new();
    if matches!(scene.environment, etendue_scene::Environment::LatLong { .. }) {
        notes.push("the sky".to_owned());
    }
    let textures = textures(scene, files, &mut doc)?;
    for m in &scene.materials {
        let value = material::json(m, &textures, &mut doc, &mut notes);
        doc.material(value);
    }
    let roots = scene::nodes(scene, &mut doc);
    doc.scene(options.name.as_deref(), roots);
    notes.dedup();
    let bytes = match options.form {
        Form::Binary => doc.glb()?,
        Form::Text => doc.embedded()?,
    };
    Ok(Exported { bytes, notes })
}

/// Adds the scene's textures that its materials use; returns their numbers in the file.
fn textures(
    scene: &Scene,
    files: &[Option<ImageFile>],
    doc: &mut Document,
) -> Result<Vec<Option<usize>>, ExportError> {
    let mut used = vec![false; scene.textures.len()];
    for t in scene.materials.iter().flat_map(|m| m.textures()) {
        used[t.texture as usize] = true;
    }
    let mut images = vec![None; scene.images.len()];
    let mut out = vec![None; used.len()];
    for (i, t) in scene.textures.iter().enumerate().filter(|&(i, _)| used[i]) {
        let number = t.image as usize;
        let image = match images[number] {
            Some(known) => known,
            None => {
                let file = files.get(number).and_then(Option::as_ref);
                let kept = file.and_then(|f| Some((mime(f.format)?, &f.bytes)));
                let added = match kept {
                    Some((mime, bytes)) => doc.image("", mime, bytes),
                    None => doc.image("", "image/png", &png(&scene.images[number], number)?),
                };
                images[number] = Some(added);
                added
            }
        };
        out[i] = Some(doc.texture("", image, Sampling::of(&t.sampler)));
    }
    Ok(out)
}

/// The picture formats of glTF: two of its own, one by an extension.
fn mime(format: &str) -> Option<&'static str> {
    Some(match format {
        "PNG" => "image/png",
        "JPEG" => "image/jpeg",
        "WebP" => "image/webp",
        _ => return None,
    })
}

fn png(image: &etendue_image::Image, number: usize) -> Result<Vec<u8>, ExportError> {
    let mut out = Vec::new();
    encode_picture(&mut out, PictureFormat::Png, image, &WriteOptions::default())
        .map_err(|source| ExportError::Image { image: number, source })?;
    Ok(out)
}
