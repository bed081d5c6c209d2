//! Writes the built-in helmet and sky into a directory.
#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(dir) = std::env::args_os().nth(1) else {
        eprintln!("usage: etendue-builtin OUTDIR");
        return ExitCode::from(2);
    };
    let dir = Path::new(&dir);
    for (name, bytes) in
        [("studio.hdr", etendue_builtin::studio()), ("helmet.glb", etendue_builtin::helmet())]
    {
        let path = dir.join(name);
        if let Err(e) = std::fs::write(&path, &bytes) {
            eprintln!("{}: {e}", path.display());
            return ExitCode::FAILURE;
        }
        println!("{}: {} bytes", path.display(), bytes.len());
    }
    ExitCode::SUCCESS
}
