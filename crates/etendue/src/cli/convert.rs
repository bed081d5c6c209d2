//! `etendue convert`: any model into glTF.

use super::model_args::ConvertArgs;
use super::output::bytes;
use super::{CliError, load, note_line, say};
use crate::image::write_atomic;
use crate::import::{ExportOptions, Form, export};
use std::ffi::OsStr;

pub(crate) fn run(args: &ConvertArgs) -> Result<(), CliError> {
    let extension = args.output.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    let form = match &extension[..] {
        "glb" => Form::Binary,
        "gltf" => Form::Text,
        _ => {
            return Err(CliError::Usage(format!(
                "cannot tell what to write into {}: give it the extension .glb or .gltf",
                args.output.display()
            )));
        }
    };
    super::target::check_writable(&args.output)?;
    let model = load::model_with_files(args.model.as_deref(), args.at, &args.limits)?;
    let options = ExportOptions {
        form,
        copyright: model.info.copyright.clone(),
        name: model.info.scene.clone(),
        xmp: model.info.xmp.clone(),
        xmp_of_asset: model.info.xmp_of_asset,
    };
    let file =
        export(&model.scene, &model.image_files, &options).map_err(|e| CliError::Other(e.to_string()))?;
    write_atomic::<std::io::Error>(&args.output, |w| w.write_all(&file.bytes))
        .map_err(|source| CliError::Write { path: args.output.clone(), source })?;
    if args.quiet {
        return Ok(());
    }
    model.warnings.iter().for_each(|w| note_line(&format!("warning: {w}")));
    file.notes.iter().for_each(|n| note_line(&format!("warning: not written: {n}")));
    // What a scene, which is one moment, does not have.
    let i = &model.info;
    let morphs = i.meshes.iter().flat_map(|m| &m.primitives).any(|p| p.morph_targets > 0);
    for (what, lost) in
        [("animations", !i.animations.is_empty()), ("skins", i.counts.skins > 0), ("morph targets", morphs)]
    {
        if lost {
            note_line(&format!(
                "warning: not written: {what}; the model stands as it is at {}",
                match args.at {
                    Some(at) => format!("{at} s"),
                    None => "rest".into(),
                }
            ));
        }
    }
    let s = &model.scene;
    say(&format!(
        "{}: {}, {} triangles in {} meshes, {} materials, {} images",
        args.output.display(),
        bytes(file.bytes.len() as u64),
        super::output::count(s.triangle_count() as f64),
        s.meshes.len(),
        s.materials.len(),
        s.images.len()
    ));
    Ok(())
}
