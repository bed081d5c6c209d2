//! Measured materials by name: metals by colour and complex index, dielectrics by index.
//!
//! The metals' numbers are linear Rec.709 for the CIE 1931 2° observer under D65, relative to a perfect reflector: the exact
//! Fresnel reflectance of the measured spectrum, integrated, at normal incidence (F0) and at cos θ = 1/7 (F82). η and k are
//! effective ones: per channel the pair that has this F0 and comes nearest to this F82; no physical wavelength has them.
//! The example `ior_table` derives them and prints how far each curve is from the integrated spectrum.
//!
//! Zinc is not here: the public-domain spectrum (Querry 1987) gives n = 13 in the visible, which no other measurement of the
//! metal comes near. Gold's red is 1.04 of a perfect reflector, outside of what Rec.709 can show: it is held at 1.

use crate::{conductor::Conductor, f82::F82Tint, fresnel_term::Dielectric};
use etendue_color::Spectrum;

pub use crate::ior_metals::METALS;

/// A measured metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Its name, as a user writes it.
    pub name: &'static str,
    /// Its chemical symbol, which is a name for it too.
    pub symbol: &'static str,
    /// Reflectance at normal incidence, linear Rec.709.
    pub f0: [f32; 3],
    /// Reflectance at cos θ = 1/7, linear Rec.709.
    pub f82: [f32; 3],
    /// Effective real part of the index, by channel.
    pub eta: [f32; 3],
    /// Effective imaginary part of the index, by channel.
    pub k: [f32; 3],
    /// Where the spectrum comes from.
    pub source: &'static str,
}

impl Metal {
    /// Its Fresnel curve by complex index.
    pub fn conductor(&self) -> Conductor {
        Conductor::new(Spectrum::from_rgb(self.eta), Spectrum::from_rgb(self.k))
    }

    /// Its Fresnel curve by two colours.
    pub fn f82(&self) -> F82Tint {
        F82Tint::from_f82(Spectrum::from_rgb(self.f0), Spectrum::from_rgb(self.f82))
    }
}

/// A measured dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricMaterial {
    /// Its name, as a user writes it.
    pub name: &'static str,
    /// Index of refraction at the yellow sodium line, 589 nm (at 587.6 nm for glasses).
    pub ior: f32,
    /// Abbe number (n_d − 1) / (n_F − n_C), where the source gives the dispersion.
    pub abbe: Option<f32>,
    /// Where the number comes from.
    pub source: &'static str,
}

impl DielectricMaterial {
    /// Its Fresnel curve, from air.
    pub fn dielectric(&self) -> Dielectric {
        Dielectric::new(self.ior)
    }
}

/// A measured material of either kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Absorbs what it does not reflect.
    Metal(&'static Metal),
    /// Lets light in.
    Dielectric(&'static DielectricMaterial),
}

/// The material of that name, or a metal of that chemical symbol; letter case does not count.
///
/// ```
/// use etendue_bxdf::ior_table::{Measured, by_name};
///
/// let Some(Measured::Metal(gold)) = by_name("gold") else { panic!("listed") };
/// assert!(gold.f0[0] > gold.f0[2]);
/// assert!(by_name("unobtainium").is_none());
/// ```
pub fn by_name(name: &str) -> Option<Measured> {
    let is = |n: &str| n.eq_ignore_ascii_case(name);
    let metal = METALS.iter().find(|m| is(m.name) || is(m.symbol)).map(Measured::Metal);
    metal.or_else(|| DIELECTRICS.iter().find(|d| is(d.name)).map(Measured::Dielectric))
}

/// The names of all materials, metals first.
pub fn names() -> impl Iterator<Item = &'static str> {
    METALS.iter().map(|m| m.name).chain(DIELECTRICS.iter().map(|d| d.name))
}

/// The measured dielectrics.
pub const DIELECTRICS: &[DielectricMaterial] = &[
    DielectricMaterial {
        name: "diamond",
        ior: 2.4173,
        abbe: Some(55.3),
        source: "Peter 1923, Über Brechungsindizes und Absorptionskonstanten des Diamanten",
    },
    DielectricMaterial {
        name: "fused-silica",
        ior: 1.4584,
        abbe: Some(67.8),
        source: "Malitson 1965, Interspecimen comparison of the refractive index of fused silica",
    },
    DielectricMaterial {
        name: "glass",
        ior: 1.5168,
        abbe: Some(64.2),
        source: "Schott, data sheet of N-BK7 (borosilicate crown)",
    },
    DielectricMaterial {
        name: "hair",
        ior: 1.55,
        abbe: None,
        source: "Marschner et al. 2003, Light Scattering from Human Hair Fibers, table 1",
    },
    DielectricMaterial {
        name: "ice",
        ior: 1.3097,
        abbe: None,
        source: "Warren, Brandt 2008, Optical constants of ice from the ultraviolet to the microwave, at 590 nm",
    },
    DielectricMaterial {
        name: "plastic",
        ior: 1.4925,
        abbe: Some(59.4),
        source: "Beadie et al. 2015, Refractive index measurements of poly(methyl methacrylate) (PMMA)",
    },
    DielectricMaterial {
        name: "quartz",
        ior: 1.5442,
        abbe: Some(69.7),
        source: "Ghosh 1999, Dispersion-equation coefficients of calcite and quartz crystals (ordinary ray)",
    },
    DielectricMaterial {
        name: "sapphire",
        ior: 1.7681,
        abbe: Some(72.3),
        source: "Malitson, Dodge 1972, Refractive index and birefringence of synthetic sapphire (ordinary ray)",
    },
    DielectricMaterial {
        name: "skin",
        ior: 1.4,
        abbe: None,
        source: "d'Eon, Luebke 2007, Advanced Techniques for Realistic Real-Time Skin Rendering, section 14.3",
    },
    DielectricMaterial {
        name: "water",
        ior: 1.333,
        abbe: None,
        source: "Hale, Querry 1973, Optical constants of water in the 200-nm to 200-µm wavelength region",
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{f82::F82_COS, fresnel::f0_from_ior, fresnel_term::Fresnel};

    /// The complex indices have the colours that stand beside them, and no lane is outside of what light can do.
    #[test]
    fn indices_meet_the_colours() {
        assert!(METALS.len() >= 10);
        for m in METALS {
            let (exact, tint) = (m.conductor(), m.f82());
            for i in 0..3 {
                // A red at the edge of Rec.709 is held at 0.995, and its F82 cannot be met beside it.
                let bound = if m.f0[i] > 0.995 { 6e-3 } else { 1e-3 };
                let (f0, f82) = (exact.eval(1.0)[i], exact.eval(F82_COS)[i]);
                // No metal has a larger index in visible light.
                assert!(m.eta[i] > 0.0 && m.eta[i] < 10.0 && m.k[i] < 10.0, "{} {i}", m.name);
                assert!((f0 - m.f0[i]).abs() < bound, "{} {i}: {f0} {}", m.name, m.f0[i]);
                assert!((f82 - m.f82[i]).abs() < bound, "{} {i}: {f82} {}", m.name, m.f82[i]);
                assert!((tint.eval(F82_COS)[i] - m.f82[i]).abs() < 1e-5);
                assert!(Fresnel::average(&exact)[i] <= 1.0 && m.f0[i] <= 1.0 && m.f0[i] >= 0.3);
            }
        }
    }

    /// Reflectances by hand from single rows of the measurements (near the middle of a channel).
    #[test]
    fn metals_have_their_colours() {
        let Some(Measured::Metal(gold)) = by_name("gold") else { panic!("listed") };
        // Johnson, Christy 1972 at 617 nm and 451 nm: (n − 1)² + k² over (n + 1)² + k².
        let at = |n: f32, k: f32| ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
        assert!((gold.f0[0] - at(0.21, 3.272)).abs() < 0.08 && (gold.f0[2] - at(1.38, 1.914)).abs() < 0.08);
        let Some(Measured::Metal(silver)) = by_name("AG") else { panic!("by symbol, any case") };
        assert!(silver.f0.iter().all(|&v| v > 0.95));
        let Some(Measured::Metal(copper)) = by_name("Copper") else { panic!("listed") };
        assert!(copper.f0[0] > copper.f0[1] && copper.f0[1] > copper.f0[2]);
    }

    #[test]
    fn names_are_found_and_differ() {
        let all: Vec<_> = names().collect();
        for (i, name) in all.iter().enumerate() {
            assert!(by_name(name).is_some() && !all[..i].contains(name), "{name}");
        }
        let Some(Measured::Dielectric(water)) = by_name("water") else { panic!("listed") };
        assert!((f0_from_ior(water.ior) - 0.02).abs() < 1e-3 && water.dielectric().eta() == water.ior);
        for d in DIELECTRICS {
            assert!(d.ior > 1.0 && d.ior < 3.0 && !d.source.is_empty());
        }
    }
}
