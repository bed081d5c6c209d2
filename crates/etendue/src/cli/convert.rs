//! `etendue convert`: any model into glTF. A glTF file keeps everything that it holds; other models, scene files, and a model at a
//! moment of its animation are written as the scene that they show.

use super::model_args::ConvertArgs;
use super::output::bytes;
use super::{CliError, load, note_line, say};
use crate::builtin::HELMET_GLB;
use crate::image::write_atomic;
use crate::import::scene_file::is_scene_file;
use crate::import::{ExportOptions, Form, ImportOptions, ModelFile, RewriteError, Rewritten, export};
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
    if args.at.is_none()
        && let Some(again) = rewritten(args, form)?
    {
        return kept(args, &again);
    }
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
    write(args, &file.bytes)?;
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

/// The model's file again, if it is glTF.
fn rewritten(args: &ConvertArgs, form: Form) -> Result<Option<Rewritten>, CliError> {
    // What drafts say is kept like all else, whether or not they are to be shown.
    let options = ImportOptions { limits: args.limits.limits(), drafts: true, ..ImportOptions::default() };
    let file = match args.model.as_deref() {
        Some(path) if is_scene_file(path) => return Ok(None),
        Some(path) => ModelFile::read(path, &options)?,
        None => ModelFile::from_bytes(HELMET_GLB, "built-in helmet", &options),
    };
    file.rewrite(form).map_err(|e| match e {
        RewriteError::Import(e) => e.into(),
        other => CliError::Other(other.to_string()),
    })
}

/// Writes a file with everything that was in the one before, and says what is different.
fn kept(args: &ConvertArgs, again: &Rewritten) -> Result<(), CliError> {
    write(args, &again.bytes)?;
    if args.quiet {
        return Ok(());
    }
    again.notes.iter().for_each(|n| note_line(&format!("warning: {n}")));
    if !again.warnings.is_empty() {
        note_line(&format!(
            "note: kept as it was, though odd: {}; `etendue info` tells",
            some(again.warnings.len() as u64, "thing", "things")
        ));
    }
    let (i, c) = (&again.info, &again.changes);
    let morphs = i.meshes.iter().flat_map(|m| &m.primitives).filter(|p| p.morph_targets > 0).count();
    let mut line = format!(
        "{}: {}, {} triangles in {} meshes, {} materials, {} images",
        args.output.display(),
        bytes(again.bytes.len() as u64),
        super::output::count(i.counts.triangles as f64),
        i.counts.meshes,
        i.counts.materials,
        i.counts.images
    );
    let more = [
        (i.animations.len() as u64, "animation", "animations"),
        (i.counts.skins, "skin", "skins"),
        (morphs as u64, "morphing primitive", "morphing primitives"),
        (i.cameras.len() as u64, "camera", "cameras"),
        (i.variants.len() as u64, "variant", "variants"),
    ];
    for (n, one, several) in more.into_iter().filter(|m| m.0 > 0) {
        line += &format!(", {}", some(n, one, several));
    }
    say(&line);
    if c.embedded > 0 {
        say(&format!(
            "taken into the file: {}",
            some(c.embedded, "picture or profile", "pictures and profiles")
        ));
    }
    if c.mended_textures > 0 {
        let what = some(c.mended_textures, "texture", "textures");
        say(&format!("mended: {what} of a format that only an extension allows, and that did not name it"));
    }
    for (n, one, several) in [
        (c.decompressed_views, "buffer view", "buffer views"),
        (c.decompressed_primitives, "primitive", "primitives"),
    ] {
        if n > 0 {
            say(&format!("decompressed: {}", some(n, one, several)));
        }
    }
    if !c.dropped_extensions.is_empty() {
        say(&format!("not needed any more: {}", c.dropped_extensions.join(", ")));
    }
    if c.tangents > 0 {
        let split = match c.split_vertices {
            0 => String::new(),
            n => format!(", with {} more", some(n, "vertex", "vertices")),
        };
        say(&format!("tangents added: {}{split}", some(c.tangents, "primitive", "primitives")));
    }
    Ok(())
}

fn write(args: &ConvertArgs, bytes: &[u8]) -> Result<(), CliError> {
    write_atomic::<std::io::Error>(&args.output, |w| w.write_all(bytes))
        .map_err(|source| CliError::Write { path: args.output.clone(), source })
}

/// A number of things.
fn some(n: u64, one: &str, several: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { several })
}
