//! What lies behind the surface: the volumes that the transmission and subsurface parameters describe.

use super::{
    OpenPbrParams,
    index::{self, unit},
};
use crate::dielectric::absorption;
use etendue_color::Spectrum;

/// A homogeneous medium with Henyey-Greenstein scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Absorption coefficient, per metre.
    pub absorption: Spectrum,
    /// Scattering coefficient, per metre.
    pub scattering: Spectrum,
    /// Mean cosine of the scattering, −1..1.
    pub anisotropy: f32,
}

/// The shortest mean free path, metres: the specification leaves it open how a length of zero is kept finite.
const SHORTEST_PATH: f32 = 1e-6;

/// −1..1, NaN to −1.
fn signed(x: f32) -> f32 {
    x.max(-1.0).min(1.0)
}

impl OpenPbrParams {
    /// The medium behind a translucent base (OpenPBR 1.1, "Translucent base"); clear if `transmission_depth` is zero.
    ///
    /// µt = −ln T / λ, µs = S / λ, µa = µt − µs; where a lane of µa is negative all lanes are raised by as much.
    pub fn transmission_medium(&self) -> Medium {
        let depth = self.transmission_depth;
        let anisotropy = signed(self.transmission_scatter_anisotropy);
        if !(depth > 0.0 && depth < f32::INFINITY) {
            return Medium { absorption: Spectrum::ZERO, scattering: Spectrum::ZERO, anisotropy };
        }
        let extinction = absorption::coefficient(self.transmission_color, depth);
        // Lengths too short for f32 are as short as the shortest.
        let scattering = self.transmission_scatter.map(unit) * (1.0 / depth.max(SHORTEST_PATH));
        let difference = extinction - scattering;
        let least = difference.0.into_iter().fold(0.0, f32::min);
        Medium { absorption: difference.map(|a| (a - least).max(0.0)), scattering, anisotropy }
    }

    /// The medium of the subsurface (OpenPBR 1.1, "Subsurface"): extinction 1 / radius, and the single-scattering albedo that
    /// returns `subsurface_color`, by van de Hulst's approximation for a half space without a boundary.
    pub fn subsurface_medium(&self) -> Medium {
        let g = signed(self.subsurface_scatter_anisotropy);
        let radius = self.subsurface_radius_scale.map(unit) * self.subsurface_radius.max(0.0).min(f32::MAX);
        let extinction = radius.map(|r| 1.0 / r.max(SHORTEST_PATH).min(1.0 / SHORTEST_PATH));
        let albedo = self.subsurface_color.map(|c| single_scattering_albedo(unit(c), g));
        Medium {
            absorption: extinction * (Spectrum::ONE - albedo),
            scattering: extinction * albedo,
            anisotropy: g,
        }
    }

    /// Index of refraction of the dielectric behind the surface, as `specular_weight` changes it, in surroundings of index
    /// `outside`; of one lane if there is dispersion (OpenPBR 1.1, "Translucent base", by Cauchy's formula), or the middle.
    ///
    /// Lanes 0, 1, 2 stand for the Fraunhofer lines C, d and F, whose indices the Abbe number is made of; lane 3 has the
    /// middle.
    pub fn interior_ior(&self, outside: f32, lane: Option<u8>) -> f32 {
        let bare = index::relative_index(index::index(self.specular_ior), 1.0, outside, 0.0);
        let middle = index::modulated_index(bare, self.specular_weight) * outside;
        // (λ⁻² − λd⁻²) / (λF⁻² − λC⁻²) at 656.3, 587.6 and 486.1 nm.
        let line = match lane {
            Some(0) => -0.300_77,
            Some(2) => 0.699_23,
            _ => 0.0,
        };
        if line == 0.0 || !self.is_dispersive() {
            return middle;
        }
        let abbe = self.transmission_dispersion_abbe_number / unit(self.transmission_dispersion_scale);
        // An Abbe number below 1 would turn indices over.
        middle + (middle - 1.0) * line / abbe.max(1.0)
    }

    /// True if the indices of refraction of the lanes differ.
    pub fn is_dispersive(&self) -> bool {
        self.transmission_weight > 0.0
            && !self.geometry_thin_walled
            && self.transmission_dispersion_scale > 0.0
            && self.transmission_dispersion_abbe_number > 0.0
    }
}

/// The single-scattering albedo of a half space that reflects `color` (0..1), for scattering of mean cosine `g` (van de Hulst,
/// as Kulla, Conty 2017 invert it; OpenPBR 1.1, "Subsurface").
pub fn single_scattering_albedo(color: f32, g: f32) -> f32 {
    let c = color;
    let s = 4.09712 + 4.20863 * c - (9.59217 + 41.6808 * c + 17.7126 * c * c).max(0.0).sqrt();
    let s2 = unit(s) * unit(s);
    // g s² reaches one only for g = 1 and a black subsurface, which does not scatter.
    unit((1.0 - s2) / (1.0 - g * s2).max(1e-6))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedo_inverts_van_de_hulst() {
        for g in [-0.9f32, 0.0, 0.5, 0.9] {
            for i in 0..=20 {
                let color = i as f32 / 20.0;
                let a = single_scattering_albedo(color, g);
                let s = ((1.0 - a) / (1.0 - a * g)).sqrt();
                let back = (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s);
                assert!((back - color).abs() < 2e-3, "g {g}: {color} gives {a}, and that {back}");
            }
        }
    }

    #[test]
    fn volumes_follow_the_specification() {
        let p = OpenPbrParams {
            transmission_color: Spectrum::rgb(0.5, 1.0, 0.25),
            transmission_depth: 2.0,
            transmission_scatter: Spectrum::rgb(0.1, 0.4, 0.0),
            ..Default::default()
        };
        let m = p.transmission_medium();
        // µt − µs is (0.2966, −0.2, 0.6931); raised by 0.2.
        let ln2 = core::f32::consts::LN_2;
        for (lane, want) in [0.5 * ln2 - 0.05 + 0.2, 0.0, ln2 + 0.2].into_iter().enumerate() {
            assert!((m.absorption[lane] - want).abs() < 1e-5, "{m:?}");
        }
        assert!((m.scattering[1] - 0.2).abs() < 1e-6);
        // Lossless: a white volume that scatters.
        let white = OpenPbrParams {
            transmission_color: Spectrum::ONE,
            transmission_depth: 0.1,
            transmission_scatter: Spectrum::ONE,
            ..Default::default()
        };
        assert_eq!(white.transmission_medium().absorption, Spectrum::ZERO);
        assert_eq!(OpenPbrParams::default().transmission_medium().absorption, Spectrum::ZERO);
        let s = OpenPbrParams { subsurface_color: Spectrum::ONE, ..Default::default() }.subsurface_medium();
        assert!(s.absorption.max_element() < 2e-3 && (s.scattering[1] - 2.0).abs() < 2e-3, "{s:?}");
    }
}
