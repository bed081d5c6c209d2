//! From a surface's colour to the medium under it, and back.

/// Diffuse reflectance of a half space without a boundary under even light, from its single-scattering albedo and mean cosine g
/// of its phase function:
///
/// ```text
/// A = (1 − s)(1 − 0.139 s) / (1 + 1.17 s),   s² = (1 − α) / (1 − α g)
/// ```
///
/// Van de Hulst 1980, "Multiple Light Scattering", as Kulla, Conty 2017 ("Revisiting Physically Based Shading at
/// Imageworks") use it. `alpha` is clamped to 0..1, `g` to −0.99..0.99; NaN counts as the lower end.
pub fn surface_albedo(alpha: f32, g: f32) -> f32 {
    let (alpha, g) = (alpha.max(0.0).min(1.0), g.max(-0.99).min(0.99));
    let s = ((1.0 - alpha) / (1.0 - alpha * g)).sqrt();
    ((1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)).max(0.0)
}

/// The single-scattering albedo of the medium whose surface has the diffuse reflectance `albedo`: the inverse of
/// [`surface_albedo`], exact, by the quadratic equation in s. The same ranges.
pub fn single_scattering_albedo(albedo: f32, g: f32) -> f32 {
    let (a, g) = (albedo.max(0.0).min(1.0), g.max(-0.99).min(0.99));
    // 0.139 s² − (1.139 + 1.17 A) s + (1 − A) = 0; the smaller root, in the form without cancellation.
    let b = 1.139 + 1.17 * a;
    let s = 2.0 * (1.0 - a) / (b + (b * b - 0.556 * (1.0 - a)).max(0.0).sqrt());
    let s2 = (s * s).min(1.0);
    ((1.0 - s2) / (1.0 - g * s2)).max(0.0)
}
