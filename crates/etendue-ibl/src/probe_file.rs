//! Grids of light probes in files: JSON that says itself what it holds.
//!
//! ```json
//! {
//!   "kind": "etendue light probes", "version": 1,
//!   "generator": "…", "scene": "…", "frame": "…", "convention": "…",
//!   "first": [x, y, z], "last": [x, y, z], "counts": [nx, ny, nz],
//!   "radiance": [[[r, g, b], … nine], … nx ny nz of them, x fastest, then y, then z],
//!   "backs": [share for each probe]
//! }
//! ```
//!
//! Probe (i, j, k) stands at first + (last − first) (i, j, k) / (n − 1). `radiance` are the coefficients of [`Sh9`] in its order, undamped.
//! `backs` is the share of directions in which the probe sees the back of a one-sided surface first: in the open it is 0, inside of a closed body 1.
//! Readers leave out probes above [`HIDDEN`]. `backs` may be missing or empty: then all are in the open.

use crate::manifest::{FRAME, GENERATOR, SH_CONVENTION};
use crate::probe_grid::ProbeGrid;
use crate::sh::Sh9;
use etendue_color::Spectrum;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// The share of backs above which a probe is taken to stand inside of something.
pub const HIDDEN: f32 = 0.25;

const KIND: &str = "etendue light probes";
const VERSION: u32 = 1;

/// A grid with what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeFile {
    /// Where the light was taken, as it was named.
    pub scene: String,
    /// The probes; those with too many backs are hidden.
    pub grid: ProbeGrid,
    /// For each probe, in the grid's order, the share of directions in which it sees the back of a surface; or empty.
    pub backs: Vec<f32>,
}

/// Why a file holds no light probes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BadProbes {
    /// No JSON, or other fields.
    #[error("it is no JSON of light probes: {0}")]
    Json(#[from] serde_json::Error),
    /// Something else, or a later version.
    #[error("it is {0:?} version {1}, not {KIND:?} version {VERSION}")]
    Kind(String, u32),
    /// Corners, counts and lengths contradict each other, or numbers are not finite.
    #[error("its grid is none: {0}")]
    Grid(&'static str),
}

#[derive(Serialize, Deserialize)]
struct Stored {
    kind: String,
    version: u32,
    #[serde(default)]
    generator: String,
    #[serde(default)]
    scene: String,
    #[serde(default)]
    frame: String,
    #[serde(default)]
    convention: String,
    first: [f32; 3],
    last: [f32; 3],
    counts: [u32; 3],
    radiance: Vec<[[f32; 3]; 9]>,
    #[serde(default)]
    backs: Vec<f32>,
}

impl ProbeFile {
    /// A grid of probes with their shares of backs; those above [`HIDDEN`] are hidden. `None` as in [`ProbeGrid::from_probes`].
    pub fn new(
        scene: String,
        [first, last]: [Vec3; 2],
        counts: [u32; 3],
        probes: Vec<Sh9>,
        backs: Vec<f32>,
    ) -> Option<Self> {
        let hidden = backs.iter().map(|b| *b > HIDDEN).collect();
        let grid = ProbeGrid::from_probes(first, last, counts, probes, hidden)?;
        Some(Self { scene, grid, backs })
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        let [first, last] = self.grid.corners().map(|c| c.to_array());
        let stored = Stored {
            kind: KIND.into(),
            version: VERSION,
            generator: GENERATOR.into(),
            scene: self.scene.clone(),
            frame: FRAME.into(),
            convention: SH_CONVENTION.into(),
            first,
            last,
            counts: self.grid.counts(),
            radiance: self.grid.probes().iter().map(|p| p.0.map(|c| c.to_rgb())).collect(),
            backs: self.backs.clone(),
        };
        // Numbers and texts alone cannot fail to be written.
        serde_json::to_string(&stored).unwrap_or_default() + "\n"
    }

    /// Reads a file's text. Memory in proportion to it.
    ///
    /// # Errors
    /// [`BadProbes`].
    pub fn from_json(text: &str) -> Result<Self, BadProbes> {
        let s: Stored = serde_json::from_str(text)?;
        if s.kind != KIND || s.version != VERSION {
            return Err(BadProbes::Kind(s.kind, s.version));
        }
        let finite = s.radiance.iter().flatten().flatten().chain(&s.backs).all(|v| v.is_finite());
        if !finite {
            return Err(BadProbes::Grid("a number is not finite"));
        }
        let probes: Vec<Sh9> = s.radiance.iter().map(|p| Sh9(p.map(Spectrum::from_rgb))).collect();
        let corners = [s.first, s.last].map(Vec3::from);
        Self::new(s.scene, corners, s.counts, probes, s.backs)
            .ok_or(BadProbes::Grid("corners, counts and lengths do not fit together"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> ProbeFile {
        let probe =
            |i: usize| Sh9(std::array::from_fn(|k| Spectrum::rgb(i as f32 / 3.0, -0.1 * k as f32, 7.1e-9)));
        let corners = [Vec3::new(-1.0, 0.1, 2.0), Vec3::new(0.3, 0.1, 5.0)];
        let backs = vec![0.0, 0.1, 1.0, 0.0, 0.0, 0.3];
        ProbeFile::new("room.glb".into(), corners, [3, 1, 2], (0..6).map(probe).collect(), backs).unwrap()
    }

    /// Every bit comes back, and what is hidden stays hidden.
    #[test]
    fn files_read_back() {
        let file = file();
        let back = ProbeFile::from_json(&file.to_json()).unwrap();
        assert_eq!(back.grid.probes(), file.grid.probes());
        assert_eq!((&back.backs, &back.scene), (&file.backs, &file.scene));
        assert!(
            back.grid.is_hidden([2, 0, 0])
                && back.grid.is_hidden([2, 0, 1])
                && !back.grid.is_hidden([1, 0, 0])
        );
        let (a, b) = (back.grid.corners(), file.grid.corners());
        assert!((a[0] - b[0]).length() + (a[1] - b[1]).length() < 1e-6);
    }

    #[test]
    fn other_files_are_errors() {
        let good = file().to_json();
        for (from, to, part) in [
            ("probes\",\"version\":1", "probes\",\"version\":2", "version 2"),
            ("light probes", "dark probes", "dark"),
            ("[3,1,2]", "[3,1,3]", "do not fit"),
            ("[3,1,2]", "[4294967295,4294967295,4294967295]", "do not fit"),
            ("[3,1,2]", "[0,1,2]", "do not fit"),
            ("\"last\":[0.3", "\"last\":[-9.0", "do not fit"),
            ("\"backs\":[0.0,", "\"backs\":[", "do not fit"),
            ("\"backs\":[0.0,", "\"backs\":[1e60,", "finite"),
            ("{", "{{", "JSON"),
        ] {
            let bad = good.replacen(from, to, 1);
            assert_ne!(bad, good, "{from}");
            let e = ProbeFile::from_json(&bad).unwrap_err().to_string();
            assert!(e.contains(part), "{from} → {to}: {e}");
        }
        assert!(ProbeFile::from_json("").is_err());
    }
}
