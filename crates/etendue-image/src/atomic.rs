//! Files that are either the old ones or the new ones, never half of each.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file so that whoever looks at `path` sees the whole old content or the whole new one.
///
/// The bytes go into a temporary file in the same folder, which is flushed to the disk and then renamed over `path`.
/// When `write` fails, or the disk is full, the temporary file is removed and the old file stays as it was. A symbolic
/// link is followed; the permissions of an existing file are kept; what is not a regular file (a pipe, `/dev/null`) is
/// written directly.
///
/// # Errors
/// Those of `write`, and those of the operating system with the path in their message.
pub fn write_atomic<E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let named = |e: io::Error| io::Error::new(e.kind(), format!("{}: {e}", path.display()));
    let existing = match fs::metadata(path) {
        Ok(m) => Some(m),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(named(e).into()),
    };
    if existing.as_ref().is_some_and(|m| m.is_dir()) {
        return Err(named(io::Error::new(io::ErrorKind::IsADirectory, "is a folder")).into());
    }
    if existing.as_ref().is_some_and(|m| !m.is_file()) {
        let mut out = BufWriter::new(File::options().write(true).open(path).map_err(named)?);
        write(&mut out)?;
        return out.flush().map_err(|e| named(e).into());
    }
    // A link is followed, so that it stays a link; one that points nowhere yet is replaced.
    let target = if existing.is_some() { fs::canonicalize(path).map_err(named)? } else { path.to_path_buf() };
    let folder = match target.parent() {
        Some(p) if !p.as_os_str().is_empty() => p.to_path_buf(),
        _ => PathBuf::from("."),
    };

    let mut builder = tempfile::Builder::new();
    builder.prefix(".etendue-").suffix(".part");
    // Temporary files are private by default; the result should have the permissions of any new file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(&folder).map_err(named)?;
    let mut out = BufWriter::with_capacity(1 << 16, temporary);
    write(&mut out)?;
    let temporary = out.into_inner().map_err(|e| named(e.into_error()))?;
    temporary.as_file().sync_all().map_err(named)?;
    if let Some(m) = existing {
        fs::set_permissions(temporary.path(), m.permissions()).map_err(named)?;
    }
    temporary.persist(&target).map_err(|e| named(e.error))?;
    // The rename itself reaches the disk with the folder. Where folders cannot be opened this is left to the system.
    if let Ok(f) = File::open(&folder) {
        let _ = f.sync_all();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut n: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        n.sort();
        n
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write_atomic::<io::Error>(&path, |w| w.write_all(b"old")).unwrap();
        // Fails after more than a buffer of bytes, as a full disk would.
        let r = write_atomic::<io::Error>(&path, |w| {
            w.write_all(&vec![b'x'; 200_000])?;
            Err(io::Error::new(io::ErrorKind::StorageFull, "no space left"))
        });
        assert_eq!(r.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["a.txt"]);
        write_atomic::<io::Error>(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn the_path_is_named_when_the_folder_is_missing() {
        let e = write_atomic::<io::Error>(Path::new("/nowhere/at/all.png"), |_| Ok(())).unwrap_err();
        assert!(e.to_string().contains("/nowhere/at/all.png"), "{e}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error() {
        // /dev/full accepts nothing: every write fails with "no space left on device".
        let r = write_atomic::<io::Error>(Path::new("/dev/full"), |w| w.write_all(b"x"));
        assert_eq!(r.unwrap_err().kind(), io::ErrorKind::StorageFull);
        write_atomic::<io::Error>(Path::new("/dev/null"), |w| w.write_all(b"x")).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_survive() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let dir = tempfile::tempdir().unwrap();
        let (file, link) = (dir.path().join("real"), dir.path().join("link"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_atomic::<io::Error>(&link, |w| w.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
