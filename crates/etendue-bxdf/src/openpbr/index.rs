//! Indices of refraction and roughness: the specification's formulas between parameters and lobes.

/// 0..1, NaN to 0.
#[inline(always)]
pub(super) fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

/// An index of refraction as the formulas take it: 10⁻²..10², NaN as 1.
#[inline(always)]
pub(super) fn index(n: f32) -> f32 {
    if n.is_nan() { 1.0 } else { n.max(1e-2).min(1e2) }
}

/// αx and αy of a perceptual roughness and an anisotropy, both 0..1 (OpenPBR 1.1, "Microfacet model"):
/// αx = r² √(2 / (1 + (1 − a)²)), αy = (1 − a) αx, so that αx² + αy² = 2 r⁴. αx may exceed 1; lobes clamp it.
#[inline(always)]
pub fn anisotropic_alpha(roughness: f32, anisotropy: f32) -> [f32; 2] {
    let (r, b) = (unit(roughness), 1.0 - unit(anisotropy));
    let ax = r * r * (2.0 / (1.0 + b * b)).sqrt();
    [ax, b * ax]
}

/// The base's roughness under a coat that covers the part `weight` (OpenPBR 1.1, "Roughening"):
/// lerp(r, min(1, r⁴ + 2 c⁴)^¼, weight). All 0..1.
#[inline(always)]
pub fn roughened(roughness: f32, coat_roughness: f32, weight: f32) -> f32 {
    let (r2, c2) = (roughness * roughness, coat_roughness * coat_roughness);
    let under = (r2 * r2 + 2.0 * c2 * c2).min(1.0).sqrt().sqrt();
    roughness + (under - roughness) * weight
}

/// Index of the base over that of what lies above it, of which the part `weight` is coat (OpenPBR 1.1, equations
/// "specular_ior_ratio" and "specular_ior_ratio_with_tir_fix"): lerp(base / outside, max(base / coat, coat / base), weight).
///
/// Under a denser coat the ratio is turned over: it reflects as much at normal incidence, and not totally at angles that
/// light from outside never has within the coat.
#[inline(always)]
pub fn relative_index(base: f32, coat: f32, outside: f32, weight: f32) -> f32 {
    let under = if coat > base { coat / base } else { base / coat };
    let bare = base / outside;
    bare + (under - bare) * weight
}

/// The relative index whose reflectance at normal incidence is `weight` ≥ 0 times that of `eta` (OpenPBR 1.1, equation
/// "modulated_ior"): (1 + ε) / (1 − ε), ε = sgn(η − 1) √(weight · F).
///
/// The reflectance is held below 0.9999, the index within 1/400..400 thereby.
#[inline(always)]
pub fn modulated_index(eta: f32, weight: f32) -> f32 {
    let root = (eta - 1.0) / (eta + 1.0);
    let f = (root * root * weight.max(0.0)).min(0.99);
    let epsilon = f.sqrt().copysign(root);
    (1.0 + epsilon) / (1.0 - epsilon)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::f0_from_ior;

    #[test]
    fn anisotropy_keeps_the_mean_square() {
        for r in [0.0, 0.3, 1.0] {
            for a in [0.0, 0.5, 1.0] {
                let [x, y] = anisotropic_alpha(r, a);
                assert!((x * x + y * y - 2.0 * r * r * r * r).abs() < 1e-6);
                assert!((y - (1.0 - a) * x).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn weight_scales_the_reflectance() {
        for eta in [0.5f32, 1.0, 1.33, 1.5, 3.0] {
            for weight in [0.0, 0.25, 1.0, 2.0] {
                let f = f0_from_ior(modulated_index(eta, weight));
                assert!((f - f0_from_ior(eta) * weight).abs() < 1e-6, "{eta} {weight}: {f}");
            }
            assert!((modulated_index(eta, 1.0) - eta).abs() < 1e-5);
            assert!((modulated_index(eta, 1.0) >= 1.0) == (eta >= 1.0));
        }
        // No weight takes the reflectance to one.
        assert!(modulated_index(1.5, 1e30).is_finite() && modulated_index(1.5, f32::INFINITY) > 100.0);
    }

    #[test]
    fn coats_never_reflect_totally() {
        assert_eq!(relative_index(1.5, 1.6, 1.0, 0.0), 1.5);
        assert!((relative_index(1.5, 1.6, 1.0, 1.0) - 1.6 / 1.5).abs() < 1e-6);
        assert!((relative_index(1.6, 1.5, 1.0, 1.0) - 1.6 / 1.5).abs() < 1e-6);
        assert!((relative_index(1.5, 1.0, 1.33, 0.5) - 0.5 * (1.5 / 1.33 + 1.5)).abs() < 1e-6);
    }

    #[test]
    fn a_coat_roughens() {
        assert_eq!(roughened(0.3, 0.0, 1.0), 0.3);
        assert!((roughened(0.0, 0.5, 1.0) - (2.0f32 * 0.0625).powf(0.25)).abs() < 1e-6);
        assert!((roughened(0.2, 1.0, 1.0) - 1.0).abs() < 1e-6);
        assert!((roughened(0.2, 1.0, 0.5) - 0.6).abs() < 1e-6);
    }
}
