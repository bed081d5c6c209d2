//! Which mip of a prefiltered cube stands for which roughness.

use std::fmt;
use std::str::FromStr;

/// The curve from perceptual roughness to level of detail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MipMapping {
    /// Level = roughness × steps.
    #[default]
    Linear,
    /// Level = roughness (1.7 − 0.7 roughness) × steps: Unity's, and the founding notes' with 6 steps
    /// (`UNITY_SPECCUBE_LOD_STEPS`). More of the mips go to smooth surfaces.
    Notes,
}

impl MipMapping {
    /// Steps of the founding notes: seven mips, the last for roughness 1.
    pub const NOTES_STEPS: u32 = 6;

    /// The level of detail of a perceptual roughness (clamped to 0..1) when mip `steps` stands for roughness 1.
    pub fn lod(self, roughness: f32, steps: u32) -> f32 {
        let r = roughness.max(0.0).min(1.0);
        let x = match self {
            Self::Linear => r,
            Self::Notes => r * (1.7 - 0.7 * r),
        };
        x * steps as f32
    }

    /// The perceptual roughness that a mip stands for: the inverse of [`MipMapping::lod`]; 1 from `steps` on.
    pub fn roughness(self, mip: u32, steps: u32) -> f32 {
        if mip >= steps {
            return 1.0;
        }
        let x = mip as f32 / steps as f32;
        match self {
            Self::Linear => x,
            // 0.7 r² − 1.7 r + x = 0.
            Self::Notes => ((1.7 - (2.89 - 2.8 * x).max(0.0).sqrt()) / 1.4).max(0.0).min(1.0),
        }
    }
}

impl fmt::Display for MipMapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Notes => "notes",
        })
    }
}

impl FromStr for MipMapping {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "linear" => Ok(Self::Linear),
            "notes" | "unity" => Ok(Self::Notes),
            _ => Err("give linear or notes".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mips_and_roughness_are_inverse() {
        for mapping in [MipMapping::Linear, MipMapping::Notes] {
            for steps in [1, 5, 6] {
                for mip in 0..=steps {
                    let r = mapping.roughness(mip, steps);
                    assert!((mapping.lod(r, steps) - mip as f32).abs() < 1e-5, "{mapping} {mip}/{steps}");
                }
                assert_eq!((mapping.roughness(0, steps), mapping.roughness(steps, steps)), (0.0, 1.0));
            }
        }
        // The notes' formula as written.
        assert!((MipMapping::Notes.lod(0.5, 6) - 0.5 * (1.7 - 0.35) * 6.0).abs() < 1e-6);
        assert_eq!(MipMapping::Linear.lod(f32::NAN, 6), 0.0);
    }
}
