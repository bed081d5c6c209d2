//! Light that is scattered in a body, as a plate of the same thickness shows it to a point of its surface.
//!
//! Kubelka and Munk's two streams ("Ein Beitrag zur Optik der Farbanstriche", 1931; closed forms: Kubelka 1948, "New Contributions
//! to the Optics of Intensely Light-Scattering Materials") between two boundaries that reflect light from inside (Saunderson 1942).
//! With R∞ the colour and x = ½ S d (1 − R∞²) / R∞ a plate returns R∞ (1 − e⁻²ˣ) / (1 − R∞² e⁻²ˣ) and lets through
//! (1 − R∞²) e⁻ˣ / (1 − R∞² e⁻²ˣ); S d is ¾ of the optical thickness of scattering. A path follows the body's real form; a rasteriser does not know it. The deep plate returns the
//! colour that the extension names, as a deep body does.

/// The part of diffuse light from inside that a boundary of an index (≥ 1) reflects: 1 − (1 − F) / n², F being what it reflects of
/// diffuse light from outside, by Schlick's curve.
pub(crate) fn inner_reflectance(ior: f32) -> f32 {
    let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let outer = f0 + (1.0 - f0) / 21.0;
    if ior > 1.0 { 1.0 - (1.0 - outer) / (ior * ior) } else { 0.0 }
}

/// What of the light that has entered a plate leaves it where it came in, and on the other side. `color` (0..1) is what a plate without
/// end and boundary returns, `scattering` the optical thickness of scattering without its forward part, σs (1 − g) d; `k` is what
/// the boundaries reflect from inside. Both add up to at most 1.
pub(crate) fn plate(color: f32, scattering: f32, k: f32) -> [f32; 2] {
    let c = color.clamp(0.0, 1.0);
    if !(c > 0.0 && scattering > 0.0) {
        return [0.0; 2];
    }
    // Two streams scatter back ¾ of what isotropic events do.
    let per = 0.75 * scattering / (2.0 * c);
    let lost = (1.0 - c) * (1.0 + c);
    let x = per * lost;
    // (1 − e⁻²ˣ) over 1 − c², and its limit where nothing is absorbed.
    let back = if lost > 0.0 { -(-2.0 * x).exp_m1() / lost } else { 2.0 * per };
    let inv = 1.0 / (1.0 + c * c * back);
    let (r, t) = (c * back * inv, (-x).exp() * inv);
    // To and fro between the plate and its boundaries: the lower one first.
    let below = t / (1.0 - k * r);
    let all = r + t * k * below;
    let entered = 1.0 / (1.0 - k * all);
    [(1.0 - k) * all * entered, (1.0 - k) * below * entered]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_absorbs_nothing_loses_nothing() {
        for scattering in [1e-3, 0.3, 2.0, 50.0] {
            for k in [0.0, inner_reflectance(1.5)] {
                let [near, far] = plate(1.0, scattering, k);
                assert!((near + far - 1.0).abs() < 1e-4, "{scattering} {k}: {near} {far}");
            }
            // 1 / (1 + ¾ τ) of it passes.
            let [_, far] = plate(1.0, scattering, 0.0);
            assert!((far - 1.0 / (1.0 + 0.75 * scattering)).abs() < 1e-5, "{far}");
        }
    }

    /// A deep plate returns its colour, and through a boundary of index 1.5 less of it (596 of 1000 is reflected from inside, by
    /// Fresnel's own equations).
    #[test]
    fn a_deep_plate_has_its_colour() {
        assert!((inner_reflectance(1.5) - 0.596).abs() < 4e-3 && inner_reflectance(1.0) == 0.0);
        for c in [0.05f32, 0.3, 0.8] {
            let [near, far] = plate(c, 1e3, 0.0);
            assert!((near - c).abs() < 1e-4 && far < 1e-4, "{c}: {near} {far}");
            let [near, _] = plate(c, 1e3, 0.5);
            assert!((near - 0.5 * c / (1.0 - 0.5 * c)).abs() < 1e-4);
            let [near, far] = plate(c, 1e-3, 0.0);
            assert!(near < 1e-3 && far > 0.97, "{c}: {near} {far}");
        }
        assert_eq!(plate(0.0, 1.0, 0.5), [0.0; 2]);
    }
}
