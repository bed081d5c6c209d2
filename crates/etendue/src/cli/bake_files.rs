//! Baked files: encoded whole before the first is written.

use super::CliError;
use super::bake_args::{BakeArgs, CubeFormat};
use super::output::unwritten;
use crate::ibl::faces::{self, Turn};
use crate::ibl::manifest::ProbeEntry;
use crate::ibl::{Baked, CubeMap, TexelFormat, dds, ktx2};
use crate::image::{Image, Metadata, PictureFormat, WriteOptions, encode_picture, write_atomic};
use std::path::{Path, PathBuf};

/// A file that is ready to be written.
pub(crate) struct File {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

/// What a file says about itself.
pub(crate) fn metadata(sky: &str, probe: Option<&ProbeEntry>, baked: &Baked, args: &BakeArgs) -> Metadata {
    let mut metadata = Metadata::default();
    let roughness: Vec<String> = baked.roughness.iter().map(ToString::to_string).collect();
    metadata.set("Software", crate::ibl::manifest::GENERATOR);
    metadata.set("Sky", sky);
    if let Some(p) = probe {
        let numbers = |v: &[f32]| v.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        metadata.set("Scene", p.scene.clone());
        metadata.set("At", numbers(&p.at));
        if let Some(b) = p.volume {
            metadata.set("Box", numbers(b.as_flattened()));
        }
    }
    metadata.set("Roughness", roughness.join(" "));
    metadata.set("Samples", args.samples.to_string());
    metadata.set("Mapping", args.mapping.to_string());
    metadata.set("Kernel", args.kernel.to_string());
    metadata
}

/// A cube in one file, or in one for each mip where a format has none: `x.exr`, `x-mip1.exr` …
pub(crate) fn cube_files(
    path: &Path,
    format: CubeFormat,
    encoding: TexelFormat,
    cube: &CubeMap,
    metadata: &Metadata,
) -> Result<Vec<File>, CliError> {
    let single = |bytes| Ok(vec![File { path: path.to_path_buf(), bytes }]);
    let format = match format {
        CubeFormat::Ktx2 => return single(ktx2::encode(cube, encoding, metadata)),
        CubeFormat::Dds => return single(dds::encode(cube, encoding)),
        CubeFormat::Exr => PictureFormat::Exr,
        CubeFormat::Hdr => PictureFormat::Hdr,
    };
    (0..cube.mip_count())
        .map(|mip| {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let extension = path.extension().unwrap_or_default().to_string_lossy();
            let name = if mip == 0 {
                path.to_path_buf()
            } else {
                path.with_file_name(format!("{stem}-mip{mip}.{extension}"))
            };
            let mut options = WriteOptions { metadata: metadata.clone(), ..Default::default() };
            let turn = if format == PictureFormat::Exr {
                options.metadata.set("envmap", "cube");
                Turn::OpenExr
            } else {
                Turn::Texture
            };
            encoded(&name, format, &faces::strip(cube, mip, turn), &options)
        })
        .collect()
}

/// A picture of numbers: 32-bit floats where the format has them.
pub(crate) fn picture(path: &Path, format: PictureFormat, image: &Image) -> Result<File, CliError> {
    let mut metadata = Metadata::default();
    metadata.set("Software", crate::ibl::manifest::GENERATOR);
    encoded(path, format, image, &WriteOptions { half: false, metadata, ..Default::default() })
}

fn encoded(
    path: &Path,
    format: PictureFormat,
    image: &Image,
    options: &WriteOptions,
) -> Result<File, CliError> {
    let mut bytes = Vec::new();
    encode_picture(&mut bytes, format, image, options).map_err(|e| unwritten(path, e))?;
    Ok(File { path: path.to_path_buf(), bytes })
}

/// Writes the files one after another, each whole or not at all. If one fails, those that are new are taken away again, and the folder
/// with them if it is new too.
pub(crate) fn write(files: Vec<File>, folder: Option<&Path>) -> Result<(), CliError> {
    let mut made_folder = None;
    if let Some(folder) = folder
        && !folder.is_dir()
    {
        std::fs::create_dir(folder)
            .map_err(|source| CliError::Write { path: folder.to_path_buf(), source })?;
        made_folder = Some(folder);
    }
    let mut made = Vec::new();
    for file in &files {
        let new = !file.path.exists();
        let result = write_atomic::<std::io::Error>(&file.path, |w| w.write_all(&file.bytes));
        if let Err(source) = result {
            // What cannot be removed now is left: the error that counts is the first.
            for path in made {
                let _ = std::fs::remove_file(path);
            }
            if let Some(folder) = made_folder {
                let _ = std::fs::remove_dir(folder);
            }
            return Err(CliError::Write { path: file.path.clone(), source });
        }
        if new {
            made.push(&file.path);
        }
    }
    Ok(())
}
