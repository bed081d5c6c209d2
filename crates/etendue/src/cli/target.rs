//! Where results go, and finding out before the work what would fail after it.

use super::CliError;
use super::args::RenderArgs;
use super::output::available_memory;
use crate::image::{ImageError, PictureFormat};
use crate::render::{Film, Pass, PassSet};
use std::ffi::OsString;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// The picture's path: as given, or named after the model in the current folder.
pub(crate) fn output_path(args: &RenderArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| match args.model.as_ref().and_then(|m| m.file_stem()) {
        // Not `with_extension`, which would take the 2 from `v1.2.glb`.
        Some(stem) => {
            let mut name = OsString::from(stem);
            name.push(".png");
            name.into()
        }
        None => "etendue.png".into(),
    })
}

/// Where the samples are kept if the user names no film: beside the picture, under a name that is free, because an older
/// film may hold hours of work.
pub(crate) fn unnamed_film(output: &Path) -> PathBuf {
    let first = output.with_extension("film");
    let stem = first.file_stem().unwrap_or_default();
    let numbered = (2..1000).map(|n| {
        let mut name = stem.to_os_string();
        name.push(format!("-{n}.film"));
        output.with_file_name(name)
    });
    std::iter::once(first.clone()).chain(numbered).find(|p| !p.exists()).unwrap_or(first)
}

/// The format of a path; an unknown extension is wrong usage.
pub(crate) fn format(path: &Path) -> Result<PictureFormat, CliError> {
    PictureFormat::from_path(path).map_err(|e| match e {
        ImageError::UnknownExtension { .. } => CliError::Usage(e.to_string()),
        e => e.into(),
    })
}

/// Checks the picture's path and format.
pub(crate) fn check_output(args: &RenderArgs, output: &Path) -> Result<(), CliError> {
    if !args.path_passes()?.is_empty() && format(output)? != PictureFormat::Exr {
        return Err(CliError::Usage(format!(
            "passes of traced paths are layers of an .exr file, and {} is none; write to a .exr, or leave --passes out",
            output.display()
        )));
    }
    format(output)?;
    check_writable(output)
}

/// Checks that a file can be made at `path`, without touching what is there.
pub(crate) fn check_writable(path: &Path) -> Result<(), CliError> {
    let fail = |source: Error| CliError::Write { path: path.to_path_buf(), source };
    match std::fs::metadata(path) {
        Ok(m) if m.is_dir() => {
            return Err(fail(Error::new(ErrorKind::IsADirectory, "it is a folder")));
        }
        // A pipe or a device: there is no telling but by writing.
        Ok(m) if !m.is_file() => return Ok(()),
        _ => {}
    }
    let real = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = real.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let text = format!("there is no folder {}", folder.display());
        return Err(fail(Error::new(ErrorKind::NotFound, text)));
    }
    // The picture is written beside its place and then renamed, so what counts is whether files can be made here.
    let probe = folder.join(format!(".etendue-{}.probe", std::process::id()));
    std::fs::File::create(&probe).map_err(fail)?;
    std::fs::remove_file(&probe).map_err(fail)
}

/// Most pixels of a film: what a film file may hold.
const MOST_PIXELS: u64 = 1 << 30;

/// Checks that a picture of that many pixels is possible.
pub(crate) fn check_pixels((width, height): (u32, u32)) -> Result<(), CliError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MOST_PIXELS {
        return Err(CliError::Usage(format!(
            "{width} × {height} are {:.1} G pixels; at most {:.1} G are possible",
            pixels as f64 / 1e9,
            MOST_PIXELS as f64 / 1e9
        )));
    }
    Ok(())
}

/// Checks that the film fits into memory before anything is allocated.
pub(crate) fn check_size((width, height): (u32, u32), passes: PassSet) -> Result<(), CliError> {
    check_pixels((width, height))?;
    let pixels = u64::from(width) * u64::from(height);
    // An id pass keeps a small map for each pixel.
    let ids = [Pass::ObjectId, Pass::MaterialId].iter().filter(|p| passes.has(**p)).count() as u64;
    let sums = pixels * Film::stride_of(passes) as u64 * size_of::<crate::render::Fixed>() as u64;
    // The sums, and the picture as floats while it is written.
    let needed = sums + pixels * (ids * 160 + 32);
    match available_memory() {
        Some(free) if needed > free => Err(CliError::Other(format!(
            "a picture of {width} × {height} needs {:.1} GB of memory and {:.1} GB are free; choose a smaller --size or fewer --passes",
            needed as f64 / 1e9,
            free as f64 / 1e9
        ))),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_named_after_models() {
        let args = |m: &str| RenderArgs { model: Some(m.into()), ..RenderArgs::builtin() };
        assert_eq!(output_path(&args("models/helmet.glb")), Path::new("helmet.png"));
        assert_eq!(output_path(&args("v1.2.glb")), Path::new("v1.2.png"));
        assert_eq!(output_path(&RenderArgs::builtin()), Path::new("etendue.png"));
    }

    #[test]
    fn sizes_are_bounded() {
        assert!(matches!(check_size((65536, 65536), PassSet::default()), Err(CliError::Usage(_))));
        assert!(check_size((64, 64), PassSet::all()).is_ok());
    }
}
