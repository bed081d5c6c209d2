//! Metals: rough or smooth, brushed or not, by name, by complex index or by two colours.

use crate::{
    choices,
    conductor::Conductor,
    f82::F82Tint,
    fresnel_term::Fresnel,
    ggx::anisotropic_alpha,
    ior_table::{METALS, Metal},
    model::{Claims, Incidence, ModelParams},
    multiscatter::{CompensatedGgx, Compensation},
    parameters,
};
use etendue_color::Spectrum;

choices! {
    /// A metal of [`crate::ior_table`], or one's own.
    pub enum MetalName {
        /// What `eta` and `k`, or `f0` and `f82`, say.
        Custom = "custom",
        /// Aluminium.
        Aluminium = "aluminium",
        /// Chromium.
        Chromium = "chromium",
        /// Copper.
        Copper = "copper",
        /// Gold.
        Gold = "gold",
        /// Iron.
        Iron = "iron",
        /// Nickel.
        Nickel = "nickel",
        /// Platinum.
        Platinum = "platinum",
        /// Silver.
        Silver = "silver",
        /// Titanium.
        Titanium = "titanium",
        /// Tungsten.
        Tungsten = "tungsten",
    }
}

impl MetalName {
    /// Its measured numbers; `None` for `custom`.
    #[inline]
    pub fn metal(self) -> Option<&'static Metal> {
        // The names stand in the order of the table, after `custom`; a test below holds them to it.
        METALS.get((self as usize).wrapping_sub(1))
    }
}

choices! {
    /// Which numbers say what a metal reflects.
    pub enum MetalCurve {
        /// The complex index, `eta` and `k`.
        Index = "index",
        /// The colours `f0` and `f82`.
        Colors = "colors",
    }
}

parameters! {
    /// What a metal surface is at a point.
    pub struct ConductorParams {
        /// A measured metal, which takes the place of the four colours below; `custom` for those.
        material: MetalName = MetalName::Custom, 0.0..1.0;
        /// Which numbers say what it reflects.
        curve: MetalCurve = MetalCurve::Index, 0.0..1.0;
        /// Real part of the index of refraction, by lane, 0..10⁴.
        eta: Spectrum = Spectrum::rgb(1.5, 0.98, 0.6), 0.0..10.0;
        /// Imaginary part of the index of refraction, by lane, 0..10⁴.
        k: Spectrum = Spectrum::rgb(7.7, 6.6, 5.4), 0.0..10.0;
        /// Reflectance at normal incidence, each lane 0..1.
        f0: Spectrum = Spectrum::rgb(0.91, 0.92, 0.92), 0.0..1.0;
        /// Reflectance at cos θ = 1/7, each lane 0..1.
        f82: Spectrum = Spectrum::rgb(0.83, 0.86, 0.89), 0.0..1.0;
        /// Perceptual roughness, 0..1; α = roughness².
        roughness: f32 = 0.3, 0.0..1.0;
        /// How much longer a highlight is along the tangent, 0..1 (Burley 2012).
        anisotropy: f32 = 0.0, 0.0..1.0;
        /// What is done about light that meets several microfacets.
        compensation: Compensation = Compensation::KullaConty, 0.0..1.0;
    }
}

impl ModelParams for ConductorParams {
    type Closure = CompensatedGgx<MetalFresnel>;
    const ABOUT: &'static str = "a metal of GGX microfacets by complex index of refraction or F0 and F82, with the light of several bounces";

    #[inline]
    fn closure(&self, at: &Incidence) -> CompensatedGgx<MetalFresnel> {
        let alpha = anisotropic_alpha(self.roughness, self.anisotropy);
        CompensatedGgx::new(alpha, self.fresnel(at.exterior_ior), self.compensation)
    }

    fn claims(&self) -> Claims {
        self.compensation.claims()
    }
}

impl ConductorParams {
    /// The Fresnel term in surroundings of index `exterior_ior` (colours are taken as they are seen there).
    pub fn fresnel(&self, exterior_ior: f32) -> MetalFresnel {
        let measured = self.material.metal();
        match self.curve {
            MetalCurve::Index => {
                let (eta, k) = measured
                    .map_or((self.eta, self.k), |m| (Spectrum::from_rgb(m.eta), Spectrum::from_rgb(m.k)));
                let inv = 1.0 / exterior_ior.max(1e-3).min(1e3);
                MetalFresnel::Index(Conductor::new(eta * inv, k * inv))
            }
            MetalCurve::Colors => {
                MetalFresnel::Colors(measured.map_or(F82Tint::from_f82(self.f0, self.f82), |m| m.f82()))
            }
        }
    }
}

/// What a metal reflects, by either description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MetalFresnel {
    /// By complex index.
    Index(Conductor),
    /// By two colours.
    Colors(F82Tint),
}

impl Fresnel for MetalFresnel {
    #[inline(always)]
    fn eval(&self, cos: f32) -> Spectrum {
        match self {
            Self::Index(f) => f.eval(cos),
            Self::Colors(f) => f.eval(cos),
        }
    }

    #[inline]
    fn average(&self) -> Spectrum {
        match self {
            Self::Index(f) => f.average(),
            Self::Colors(f) => f.average(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Bsdf,
        model::{Field, Value},
    };
    use glam::Vec3A;

    #[test]
    fn names_are_those_of_the_table() {
        assert_eq!(MetalName::CHOICES.len(), METALS.len() + 1);
        for (name, metal) in MetalName::CHOICES[1..].iter().zip(METALS) {
            assert_eq!(*name, metal.name);
            let choice = MetalName::from_value(Value::Choice(name)).expect("a choice");
            assert_eq!(choice.metal().map(|m| m.name), Some(*name));
        }
        assert!(MetalName::Custom.metal().is_none());
    }

    #[test]
    fn a_metal_looks_darker_under_water() {
        let p = ConductorParams { material: MetalName::Copper, roughness: 0.0, ..Default::default() };
        let at = |ior| p.closure(&Incidence { exterior_ior: ior, ..Default::default() }).albedo(Vec3A::Z);
        let (air, water) = (at(1.0), at(1.333));
        assert!((0..3).all(|i| water[i] < air[i]), "{air:?} {water:?}");
        let colors = ConductorParams { curve: MetalCurve::Colors, ..p };
        let f0 = colors.closure(&Incidence::default()).albedo(Vec3A::Z);
        assert!((0..3).all(|i| (f0[i] - air[i]).abs() < 2e-3), "{f0:?} {air:?}");
    }
}
