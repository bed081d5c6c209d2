//! STL: any bytes are a scene that holds together, or an error.

use etendue_import::{ImportOptions, Limits, import_bytes};

/// One input.
pub fn run(data: &[u8]) {
    // Small, so that a claim beyond them is a finding and not a slow run.
    let limits =
        Limits { vertices: 1 << 18, instances: 1 << 14, geometry_bytes: 1 << 25, ..Limits::default() };
    if let Ok(model) = import_bytes(data, "fuzz.stl", &ImportOptions { limits, ..ImportOptions::default() }) {
        assert_eq!(model.scene.validate(), Ok(()));
    }
}
