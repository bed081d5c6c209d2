//! Bouguer, Beer and Lambert's law: light that travels a distance d in a medium is multiplied by exp(−σ d).

use crate::math;
use etendue_color::Spectrum;

/// The darkest lane that a colour may have where it becomes an absorption coefficient: 1e-6 of the light. Black would
/// absorb without bound, and turn 0 · ∞ into NaN.
pub const DARKEST: f32 = 1e-6;

/// The absorption coefficient, per unit of length, of a medium that lets `color` of the light through over `distance`:
/// σ = −ln(color) / distance (`KHR_materials_volume`: `attenuationColor` and `attenuationDistance`; OpenPBR 1.1:
/// `transmission_color` and `transmission_depth`).
///
/// Lanes are clamped to [`DARKEST`]..1 (NaN to black). A `distance` that is infinite, zero, negative or NaN absorbs
/// nothing.
pub fn coefficient(color: Spectrum, distance: f32) -> Spectrum {
    if !(distance > 0.0 && distance < f32::INFINITY) {
        return Spectrum::ZERO;
    }
    color.map(|c| (-math::ln(c.max(DARKEST).min(1.0)) / distance).max(0.0).min(f32::MAX))
}

/// The part of the light that is left after `distance`: exp(−σ d), each lane 0..1. What is not a number counts as zero.
#[inline]
pub fn transmittance(absorption: Spectrum, distance: f32) -> Spectrum {
    absorption.map(|a| math::exp(-(a.max(0.0) * distance.max(0.0)).max(0.0)).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colour_comes_back_at_its_distance() {
        let color = Spectrum::rgb(0.9, 0.2, 1.0);
        for d in [1e-3, 0.5, 30.0] {
            let a = coefficient(color, d);
            let back = transmittance(a, d);
            let twice = transmittance(a, 2.0 * d);
            for lane in 0..3 {
                assert!((back[lane] - color[lane]).abs() < 1e-5);
                assert!((twice[lane] - color[lane] * color[lane]).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn any_input_gives_a_number() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-38, 1.0, 1e38];
        for c in odd {
            for d in odd {
                let a = coefficient(Spectrum::splat(c), d);
                assert!(a.is_finite() && a[0] >= 0.0, "{c} {d}: {a:?}");
                for x in odd {
                    let t = transmittance(Spectrum::splat(c), x)[0];
                    assert!((0.0..=1.0).contains(&t), "{c} {x}: {t}");
                    assert!((0.0..=1.0).contains(&transmittance(a, x)[0]));
                }
            }
        }
    }
}
