//! What a fibre absorbs.
//!
//! Absorption is per fibre radius, by lane: light that crosses the fibre through its axis is multiplied by e^{−2σ}.

use crate::math::ln;
use etendue_color::Spectrum;

/// The darkest colour that is told from black: its absorption is 3.7 and more.
const DARKEST: f32 = 1e-5;

/// Absorption of hair that looks, as a whole head of it, like `color` (each lane 0..1), for the azimuthal roughness `beta_n` (0..1).
///
/// ```text
/// σ = (ln C / (5.969 − 0.215 β + 2.532 β² − 10.73 β³ + 5.574 β⁴ + 0.245 β⁵))²
/// ```
///
/// Chiang, Bitterli, Tappan, Burley 2016, eq. 9: a fit to path-traced references.
pub fn absorption_from_color(color: Spectrum, beta_n: f32) -> Spectrum {
    let b = beta_n.max(0.0).min(1.0);
    let fit = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    color.map(|c| {
        let x = ln(c.max(DARKEST).min(1.0)) / fit;
        x * x
    })
}

/// Absorption of hair that contains these concentrations of the two melanins, not negative.
///
/// The unit absorptions are d'Eon, Francois, Hill, Letteri, Aubry 2011, section 6.1, for red, green and blue; the model knows
/// here, and only here, what its lanes mean. The spare lane has green's. Black hair has some 8 of eumelanin, brown 1.3,
/// blond 0.3; red hair has pheomelanin.
pub fn absorption_from_melanin(eumelanin: f32, pheomelanin: f32) -> Spectrum {
    let clamp = |c: f32| c.max(0.0).min(1e3);
    Spectrum([0.419, 0.697, 1.37, 0.697]) * clamp(eumelanin)
        + Spectrum([0.187, 0.4, 1.05, 0.4]) * clamp(pheomelanin)
}
