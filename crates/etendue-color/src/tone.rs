//! Tone curves: scene light, which has no upper end, into the 0..1 of a display.

use std::fmt;
use std::str::FromStr;

/// How scene light is brought into the range of a display.
///
/// Every curve takes linear Rec.709 light and returns linear Rec.709 light in 0..1, ready for [`crate::srgb_encode`].
/// NaN and negative light are taken as 0, infinite light as very bright: no input yields NaN.
///
/// ```
/// use etendue_color::ToneCurve;
/// let curve: ToneCurve = "neutral".parse().unwrap();
/// assert_eq!(curve.to_string(), "neutral");
/// assert!(curve.apply([8.0, 0.5, f32::NAN]).iter().all(|v| (0.0..=1.0).contains(v)));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ToneCurve {
    /// Clips at 1.
    #[default]
    None,
    /// `x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14)` per channel: Krzysztof Narkowicz, "ACES Filmic Tone Mapping Curve"
    /// (2016). A fit of the ACES look with exposure folded in: 0.18 becomes 0.267, 1 becomes 0.804, and light saturates at x = 6.7.
    Aces,
    /// Stephen Hill's fit of the ACES reference rendering and sRGB output transforms (2015, "ACES.hlsl" in MJP's
    /// BakingLab): into AP1 with desaturation, `(v (v + 0.0245786) − 0.000090537) / (v (0.983729 v + 0.4329510) + 0.238081)`,
    /// and back to Rec.709. 0.18 becomes 0.106.
    ///
    /// three.js' `ACESFilmicToneMapping` is this curve of the light divided by 0.6: the same as this one at an exposure
    /// of log₂(1/0.6) = 0.737 EV.
    AcesFitted,
    /// AgX (Troy Sobotka, 2022), base look: desaturates bright colours towards white, as film does. 0.18 becomes 0.218
    /// (half of the encoded range at gamma 2.2).
    Agx,
    /// Khronos PBR Neutral (Khronos Group, "PBR Neutral Tone Mapper", 2024): keeps base colours as they are below 0.8 and
    /// compresses only highlights. Made for product pictures. 0.18 becomes 0.14: 0.04, the Fresnel reflection of a white sky, is taken off.
    Neutral,
    /// `x / (1 + x)` per channel: Reinhard, Stark, Shirley, Ferwerda, "Photographic Tone Reproduction for Digital Images"
    /// (2002), equation 3 (there of the luminance, here of each channel, which keeps the result in range).
    Reinhard,
}

impl ToneCurve {
    /// All curves, in the order in which they are listed to users.
    pub const ALL: [Self; 6] =
        [Self::None, Self::Aces, Self::AcesFitted, Self::Agx, Self::Neutral, Self::Reinhard];

    /// The name by which users choose it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Aces => "aces",
            Self::AcesFitted => "aces-fitted",
            Self::Agx => "agx",
            Self::Neutral => "neutral",
            Self::Reinhard => "reinhard",
        }
    }

    /// Display light, linear in 0..1, of linear scene light.
    pub fn apply(self, scene: [f32; 3]) -> [f32; 3] {
        // Far above where the last curve is flat to a float, far below where its square overflows.
        const BRIGHT: f32 = 1e9;
        let c = scene.map(|v| clip(v, BRIGHT));
        let display = match self {
            Self::None => c,
            Self::Aces => c.map(narkowicz),
            Self::AcesFitted => hill(c),
            Self::Agx => crate::agx::agx(c),
            Self::Neutral => khronos_neutral(c),
            Self::Reinhard => c.map(|v| v / (1.0 + v)),
        };
        display.map(|v| clip(v, 1.0))
    }
}

/// Between 0 and `end`; NaN becomes 0, which `clamp` would let through.
#[allow(clippy::manual_clamp)]
fn clip(v: f32, end: f32) -> f32 {
    v.max(0.0).min(end)
}

fn narkowicz(x: f32) -> f32 {
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

fn hill(c: [f32; 3]) -> [f32; 3] {
    // Rec.709 → XYZ → D60 → AP1 → saturation of the reference rendering transform, in one matrix.
    const INPUT: [[f32; 3]; 3] =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    // Saturation of the output transform → XYZ → D65 → Rec.709.
    const OUTPUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let mul = |m: &[[f32; 3]; 3], v: [f32; 3]| m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2]);
    let fit =
        |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    mul(&OUTPUT, mul(&INPUT, c).map(fit))
}

fn khronos_neutral(c: [f32; 3]) -> [f32; 3] {
    /// The reflection of a dielectric at normal incidence, which a base colour is seen on top of.
    const F90: f32 = 0.04;
    const START: f32 = 0.8 - F90;
    const DESATURATION: f32 = 0.15;
    let x = c[0].min(c[1]).min(c[2]);
    // Takes off 0.04, and a smoothly vanishing part of it near black: 0.04 − (x − 0.08)² · 6.25.
    let offset = if x < 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let c = c.map(|v| v - offset);
    let peak = c[0].max(c[1]).max(c[2]);
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    c.map(|v| v * (new_peak / peak) * g + new_peak * (1.0 - g))
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that belongs to no [`ToneCurve`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownToneCurve(
    /// The name as given.
    pub String,
);

impl fmt::Display for UnknownToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no tone curve is called {:?}; there are", self.0)?;
        for (i, c) in ToneCurve::ALL.iter().enumerate() {
            write!(f, "{}{c}", if i == 0 { " " } else { ", " })?;
        }
        Ok(())
    }
}

impl std::error::Error for UnknownToneCurve {}

impl FromStr for ToneCurve {
    type Err = UnknownToneCurve;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|c| c.name() == s).ok_or_else(|| UnknownToneCurve(s.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ToneCurve::*;

    #[test]
    fn names_round_trip() {
        for c in ToneCurve::ALL {
            assert_eq!(c.to_string().parse(), Ok(c));
        }
        let e = "filmic".parse::<ToneCurve>().unwrap_err().to_string();
        assert_eq!(
            e,
            "no tone curve is called \"filmic\"; there are none, aces, aces-fitted, agx, neutral, reinhard"
        );
    }

    #[test]
    fn known_greys() {
        // By hand from the formulas of the sources, in double precision.
        for (curve, x, y) in [
            (None, 0.18, 0.18),
            (None, 3.0, 1.0),
            (Aces, 0.18, 0.266_896),
            (Aces, 1.0, 0.803_797),
            (Aces, 100.0, 1.0),
            (AcesFitted, 0.18, 0.105_591),
            (AcesFitted, 1.0, 0.619_115),
            (Agx, 0.18, 0.217_638),
            (Agx, 1000.0, 1.0),
            (Neutral, 0.18, 0.14),
            (Neutral, 0.5, 0.46),
            (Neutral, 1.0, 0.869_091),
            (Neutral, 0.04, 0.01),
            (Reinhard, 1.0, 0.5),
            (Reinhard, 0.18, 0.152_542),
        ] {
            let got = curve.apply([x; 3]);
            // Wrensch's rounded matrices leave white off by 1.4e-4 before the power of 2.2.
            let eps = if curve == Agx { 4e-4 } else { 3e-5 };
            for v in got {
                assert!((v - y).abs() < eps, "{curve} of {x}: {got:?} not {y}");
            }
        }
    }

    #[test]
    fn neutral_colour_follows_the_specification() {
        // (2, 0.5, 0.1): offset 0.04 → (1.96, 0.46, 0.06); peak 1.96 → 1 − 0.24²/(1.96 + 0.24 − 0.76) = 0.96;
        // scaled by 0.96/1.96 and mixed towards 0.96 by 1 − 1/(0.15 + 1).
        let got = Neutral.apply([2.0, 0.5, 0.1]);
        let want = [0.96, 0.321_136, 0.150_772];
        assert!((0..3).all(|i| (got[i] - want[i]).abs() < 1e-5), "{got:?}");
    }

    #[test]
    fn grey_is_monotone_and_stays_in_range() {
        for c in ToneCurve::ALL {
            let mut last = -1.0;
            for i in 0..4000 {
                let x = (-14.0 + i as f32 * (44.0 / 4000.0)).exp2();
                let [r, g, b] = c.apply([x; 3]);
                let v = (r + g + b) / 3.0;
                assert!((0.0..=1.0).contains(&v) && v >= last - 1e-6, "{c} at {x}: {v} after {last}");
                last = v;
            }
        }
    }

    #[test]
    fn nothing_yields_nan() {
        let odd = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            -0.0,
            1e-40,
            1.0,
        ];
        for c in ToneCurve::ALL {
            for r in odd {
                for g in odd {
                    for b in odd {
                        let v = c.apply([r, g, b]);
                        assert!(v.iter().all(|v| (0.0..=1.0).contains(v)), "{c} of {:?}: {v:?}", [r, g, b]);
                    }
                }
            }
            assert!(c.apply([f32::INFINITY; 3])[1] > 0.99, "{c}");
        }
    }
}
