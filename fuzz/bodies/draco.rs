//! Draco: any bytes are a mesh that holds together, or an error.

use etendue_import::draco::{DracoLimits, decode};

/// Small, so that a claim beyond them is a finding and not a slow run.
const LIMITS: DracoLimits = DracoLimits { triangles: 1 << 16, bytes: 1 << 22 };

/// One input.
pub fn run(data: &[u8]) {
    let Ok(m) = decode(data, &LIMITS) else { return };
    let points = m.points();
    assert!(m.triangles().flatten().all(|p| (p as usize) < points));
    for id in m.attributes() {
        if let Ok((values, n)) = m.floats(id) {
            assert_eq!(values.len(), n * points);
        }
    }
}
