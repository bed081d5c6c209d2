//! OBJ with its material library: any two texts are a scene that holds together, or an error.
//!
//! What follows a line `=== mtl` is the library `m.mtl`, which stands beside the model in a folder of this process.

use etendue_import::{ImportOptions, Limits, import, import_bytes};
use std::fs;

/// One input.
pub fn run(data: &[u8]) {
    // Small, so that a claim beyond them is a finding and not a slow run.
    let limits = Limits {
        image_pixels: 1 << 20,
        image_bytes: 1 << 24,
        vertices: 1 << 18,
        instances: 1 << 14,
        geometry_bytes: 1 << 25,
        ..Limits::default()
    };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    const MARK: &[u8] = b"=== mtl\n";
    let model = match data.windows(MARK.len()).position(|w| w == MARK) {
        None => import_bytes(data, "fuzz.obj", &options),
        Some(at) => {
            let folder = std::env::temp_dir().join(format!("etendue-fuzz-{}", std::process::id()));
            let write = |name: &str, bytes: &[u8]| {
                fs::create_dir_all(&folder)
                    .and_then(|()| fs::write(folder.join(name), bytes))
                    .expect("a folder to write to");
            };
            // A picture for the materials to find.
            if !folder.exists() {
                write("p.png", include_bytes!("pixel.png"));
            }
            write("m.obj", &data[..at]);
            write("m.mtl", &data[at + MARK.len()..]);
            import(&folder.join("m.obj"), &options)
        }
    };
    if let Ok(model) = model {
        assert_eq!(model.scene.validate(), Ok(()));
    }
}
