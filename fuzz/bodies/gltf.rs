//! glTF and GLB: any bytes are a scene that holds together and a file that can be written again, or an error.

use etendue_import::{AnimationChoice, Form, ImportOptions, Limits, ModelFile, import_bytes};

/// One input.
pub fn run(data: &[u8]) {
    // Small, so that a claim beyond them is a finding and not a slow run.
    let limits = Limits {
        image_pixels: 1 << 20,
        image_bytes: 1 << 24,
        vertices: 1 << 18,
        nodes: 1 << 14,
        instances: 1 << 14,
        geometry_bytes: 1 << 25,
        ..Limits::default()
    };
    let mut options = ImportOptions { limits, conformance: true, drafts: true, ..ImportOptions::default() };
    for at in [None, Some(0.5)] {
        options.at = at;
        options.animation = AnimationChoice::All;
        if let Ok(model) = import_bytes(data, "fuzz", &options) {
            assert_eq!(model.scene.validate(), Ok(()));
        }
    }
    // What is written again is written the same once more, unless it has grown beyond the limits.
    let rewrite = |bytes: &[u8]| ModelFile::from_bytes(bytes, "fuzz", &options).rewrite(Form::Binary);
    if let Ok(Some(again)) = rewrite(data)
        && let Ok(Some(twice)) = rewrite(&again.bytes)
    {
        assert!(again.bytes == twice.bytes);
    }
}
