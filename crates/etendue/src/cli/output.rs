//! Films into files.

use super::CliError;
use super::args::DevelopArgs;
use crate::color::ToneCurve;
use crate::image::{
    Depth, Development, Image, ImageError, Metadata, PictureFormat, Pixels, WriteOptions, write_atomic,
    write_layers_exr, write_picture,
};
use crate::render::{Film, FilmInfo};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

impl DevelopArgs {
    /// The development that the arguments ask for.
    pub fn development(&self) -> Development {
        Development {
            exposure_ev: self.exposure,
            curve: if self.linear { ToneCurve::None } else { self.curve },
            linear: self.linear,
            depth: if self.bits.is_some_and(|b| b > 8) { Depth::Sixteen } else { Depth::Eight },
            dither: false,
        }
    }

    /// These options where they were given, and `then`'s elsewhere.
    pub fn over(&self, then: &Self, given: &BTreeSet<String>) -> Self {
        let has = |name: &str| given.contains(name);
        Self {
            exposure: if has("exposure") { self.exposure } else { then.exposure },
            curve: if has("curve") { self.curve } else { then.curve },
            // A curve that is given anew is not undone by an older `--linear`.
            linear: if has("linear") || has("curve") { self.linear } else { then.linear },
            bits: if has("bits") { self.bits } else { then.bits },
            quality: if has("quality") { self.quality } else { then.quality },
        }
    }

    /// The same with file options.
    pub fn write_options(&self, metadata: Metadata) -> WriteOptions {
        WriteOptions {
            development: self.development(),
            jpeg_quality: self.quality,
            half: self.bits != Some(32),
            metadata,
        }
    }
}

/// Multiplies light by 2 to the power of `ev`, for files that keep light.
pub(crate) fn expose(image: &mut Image, ev: f32) {
    if let (Pixels::F32(p), true) = (&mut image.pixels, ev != 0.0) {
        let gain = ev.exp2();
        let n = image.channels as usize;
        for pixel in p.chunks_exact_mut(n) {
            for v in &mut pixel[..n.min(3)] {
                *v *= gain;
            }
        }
    }
}

/// Writes a film as a picture: layered if it has passes and the format is OpenEXR.
pub(crate) fn write_film_picture(
    path: &Path,
    film: &Film,
    info: &FilmInfo,
    develop: &DevelopArgs,
    transparent: bool,
) -> Result<(), CliError> {
    let format = PictureFormat::from_path(path)?;
    let mut metadata = Metadata::default();
    metadata.set("Software", concat!("etendue ", env!("CARGO_PKG_VERSION")));
    for (k, v) in info.notes.iter().filter(|(k, _)| *k != ARGUMENTS && *k != NAMES) {
        metadata.set(k.clone(), v.clone());
    }
    metadata.set("Picture", info.picture.clone());
    metadata.set("Samples", film.samples().to_string());
    let light = matches!(format, PictureFormat::Exr | PictureFormat::Hdr);
    if format == PictureFormat::Exr && !film.passes.is_empty() {
        let names = info.notes.get(NAMES).and_then(|n| serde_json::from_str(n).ok()).unwrap_or_default();
        let (layers, more) = film.layers(transparent, &names);
        more.entries.into_iter().for_each(|(k, v)| metadata.set(k, v));
        let half = develop.bits != Some(32);
        return write_layers_exr(path, &layers, (film.width, film.height), &metadata, half)
            .map_err(|e| unwritten(path, e));
    }
    let mut picture = film.picture(transparent);
    if light {
        expose(&mut picture, develop.exposure);
    }
    write_picture(path, &picture, &develop.write_options(metadata)).map_err(|e| unwritten(path, e))
}

/// An error of writing `path`, in words that say so.
pub(crate) fn unwritten(path: &Path, e: ImageError) -> CliError {
    match e {
        ImageError::Io(source) => CliError::Write { path: path.to_path_buf(), source },
        e => e.into(),
    }
}

/// Note of a film: the arguments that rendered it, as JSON.
pub(crate) const ARGUMENTS: &str = "arguments";
/// Note of a film and entry of a picture's metadata: the frame's number.
pub(crate) const FRAME: &str = "Frame";
/// The same: seconds into the animation.
pub(crate) const TIME: &str = "Time";
/// Note of a film: names of objects and materials, as JSON.
pub(crate) const NAMES: &str = "names";

/// Writes a film file.
pub(crate) fn write_film(path: &Path, film: &Film, info: &FilmInfo) -> Result<(), CliError> {
    let bytes = film.to_bytes(info);
    write_atomic::<std::io::Error>(path, |w| w.write_all(&bytes))
        .map_err(|source| CliError::Write { path: path.to_path_buf(), source })
}

/// Reads a film file.
pub(crate) fn read_film(path: &Path) -> Result<(Film, FilmInfo), CliError> {
    let bytes = read_whole(path)?;
    Film::from_bytes(&bytes).map_err(|source| CliError::Film { path: path.to_path_buf(), source })
}

/// Reads a file that may be large but must have an end: a device has none.
pub(crate) fn read_whole(path: &Path) -> Result<Vec<u8>, CliError> {
    let fail = |source| CliError::Read { path: path.to_path_buf(), source };
    let kind = std::fs::metadata(path).map_err(fail)?.file_type();
    #[cfg(unix)]
    let endless = std::os::unix::fs::FileTypeExt::is_char_device(&kind);
    #[cfg(not(unix))]
    let endless = false;
    if endless || kind.is_dir() {
        let what = if endless { "it is a device" } else { "it is a folder" };
        return Err(fail(std::io::Error::new(std::io::ErrorKind::InvalidInput, what)));
    }
    std::fs::read(path).map_err(fail)
}

/// Memory that programs can still take, bytes, where the system tells.
pub(crate) fn available_memory() -> Option<u64> {
    system_kilobytes("/proc/meminfo", "MemAvailable:")
}

fn system_kilobytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| k * 1024)
}

/// Peak memory of this process so far, bytes, where the system tells.
pub(crate) fn peak_memory() -> Option<u64> {
    system_kilobytes("/proc/self/status", "VmHWM:")
}

/// `1234567` as `1.23 M`.
pub(crate) fn count(n: f64) -> String {
    match n {
        n if n >= 1e9 => format!("{:.2} G", n / 1e9),
        n if n >= 1e6 => format!("{:.2} M", n / 1e6),
        n if n >= 1e4 => format!("{:.1} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}

/// Bytes in the unit that suits them.
pub(crate) fn bytes(n: u64) -> String {
    match n {
        n if n >= 1 << 20 => format!("{:.1} MiB", n as f64 / f64::from(1 << 20)),
        n if n >= 1 << 10 => format!("{:.1} KiB", n as f64 / 1024.0),
        n => format!("{n} B"),
    }
}

/// Notes for a film's file.
pub(crate) fn notes<const N: usize>(entries: [(&str, String); N]) -> BTreeMap<String, String> {
    entries.into_iter().map(|(k, v)| (k.to_string(), v)).collect()
}
