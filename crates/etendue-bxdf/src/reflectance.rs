//! The reflectances of Nicodemus et al. 1977 ("Geometrical Considerations and Nomenclature for Reflectance", NBS
//! Monograph 160, table 2) by quadrature, for any scattering function, reflection and transmission apart.
//!
//! | function | integral | Nicodemus |
//! |---|---|---|
//! | [`hemispherical_directional`] | ∫ f(wo, wi) \|cos θi\| dωi | ρ(2π; θr, φr) for even light: the *reflectance factor* |
//! | [`directional_hemispherical`] | ∫ f(wo, wi) \|cos θo\| dωo | ρ(θi, φi; 2π) |
//! | [`bihemispherical`] | 1/π ∫∫ f \|cos θi\| \|cos θo\| dωi dωo | ρ(2π; 2π) |
//!
//! For a reciprocal function the first two are the same number for reflection. For transmission they are not, if the
//! indices on the two sides differ: under even light the radiance behind an interface is what it was in front times
//! the transmittance times (n₂/n₁)², so that [`hemispherical_directional`] of a closure made for
//! [`crate::model::Transport::Radiance`] counts what passes 1/η² times (η: far index over near), while
//! [`directional_hemispherical`] is a part of the energy, never above 1. Of a closure made for
//! [`crate::model::Transport::Importance`] the first is a part of the energy too: this is what the furnace law asks.
//!
//! Accuracy: the order of the panels rises until the result changes by less than 1e-4, which leaves an error of some
//! 1e-5 (mostly 1e-6) for the lobes of this crate down to α = 1e-4 on either side; perfectly specular parts are exact. One direction
//! takes some milliseconds.

use crate::{
    bsdf::Bsdf,
    quadrature::{HemisphereMap, TOLERANCE, gauss_legendre},
};
use core::f32::consts::TAU;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// A reflectance and the transmittance of the same kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reflectance {
    /// What stays on the side that it came from.
    pub reflection: Spectrum,
    /// What goes to the other side.
    pub transmission: Spectrum,
}

impl Reflectance {
    /// Reflection plus transmission.
    pub fn total(&self) -> Spectrum {
        self.reflection + self.transmission
    }

    fn scaled(self, by: f32) -> Self {
        Self { reflection: self.reflection * by, transmission: self.transmission * by }
    }

    fn add(self, o: Self) -> Self {
        Self { reflection: self.reflection + o.reflection, transmission: self.transmission + o.transmission }
    }
}

/// The same direction seen from the other side of the surface: half a turn about the x axis.
///
/// A closure made for the far side ([`crate::model::Incidence::front`] turned) is asked about such directions.
#[inline]
pub fn from_behind(w: Vec3A) -> Vec3A {
    vec3a(w.x, -w.y, -w.z)
}

/// What a surface under even light of radiance 1 from all directions sends towards `wo`: ∫ f(wo, wi) |cos θi| dωi.
///
/// Zero for `wo` below the surface.
pub fn hemispherical_directional<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A) -> Reflectance {
    if !(wo.z > 0.0) {
        return Reflectance::default();
    }
    let over = |map: HemisphereMap| {
        let sum = map.integrate_all(TOLERANCE, |wi| (bsdf.eval(wo, wi) * wi.z.abs()).0);
        Spectrum(sum.map(|v| v as f32))
    };
    let mut out = Reflectance {
        reflection: over(HemisphereMap::upper(bsdf, wo)),
        transmission: HemisphereMap::lower(bsdf, wo).map_or(Spectrum::ZERO, over),
    };
    for d in bsdf.deltas(wo).into_iter().flatten() {
        if d.wi.z > 0.0 {
            out.reflection += d.reflectance;
        } else {
            out.transmission += d.reflectance;
        }
    }
    out
}

/// The part of the light arriving from `wi` that leaves in any direction: ∫ f(wo, wi) |cos θo| dωo.
///
/// `far` is the closure of the same point for `wo` on the far side; without it the transmission is zero. Both must be
/// made for [`crate::model::Transport::Radiance`]. Zero for `wi` below the surface.
pub fn directional_hemispherical<B: Bsdf + ?Sized>(near: &B, far: Option<&B>, wi: Vec3A) -> Reflectance {
    if !(wi.z > 0.0) {
        return Reflectance::default();
    }
    // A lobe around the mirror direction or Snell's is one seen from either end.
    let reflected =
        HemisphereMap::upper(near, wi).integrate_all(TOLERANCE, |wo| (near.eval(wo, wi) * wo.z.max(0.0)).0);
    let mut out = Reflectance { reflection: Spectrum(reflected.map(|v| v as f32)), ..Default::default() };
    let below = from_behind(wi);
    if let (Some(far), Some(map)) = (far, HemisphereMap::lower(near, wi)) {
        let sum = map.integrate_all(TOLERANCE, |wo| (far.eval(from_behind(wo), below) * wo.z.abs()).0);
        out.transmission = Spectrum(sum.map(|v| v as f32));
    }
    // Where `wi` goes when it is taken for `wo` is where its light goes.
    for there in near.deltas(wi).into_iter().flatten() {
        if there.wi.z > 0.0 {
            out.reflection += returned(near, there.wi, wi);
        } else if let Some(far) = far {
            // cos θo dωo = η² cos θi dωi, η the index on the light's side over that on the other (conserved étendue).
            let eta = far.refraction().unwrap_or(1.0);
            out.transmission += returned(far, from_behind(there.wi), below) * (eta * eta);
        }
    }
    out
}

/// The perfectly specular reflectance from `wi` to `wo`.
fn returned<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A, wi: Vec3A) -> Spectrum {
    let parts = bsdf.deltas(wo);
    let same = parts.into_iter().flatten().filter(|d| (d.wi - wi).length() < 1e-3);
    same.fold(Spectrum::ZERO, |a, d| a + d.reflectance)
}

/// The part of even light that a surface scatters, also called average or spherical albedo: ∫ ρ(2π; µ) 2µ dµ.
///
/// `wo` is taken in one azimuth: for a function that does not change when the surface is turned about its normal; see
/// [`bihemispherical_anisotropic`] for others.
pub fn bihemispherical<B: Bsdf + ?Sized>(bsdf: &B) -> Reflectance {
    bihemispherical_anisotropic(bsdf, 1)
}

/// [`bihemispherical`] as the mean over `azimuths` of `wo`, evenly over the turn; 8 give 1e-4 for anisotropy 0.9.
pub fn bihemispherical_anisotropic<B: Bsdf + ?Sized>(bsdf: &B, azimuths: usize) -> Reflectance {
    let n = azimuths.max(1);
    let mut sum = Reflectance::default();
    for (mu, w) in cosines(bsdf.refraction()) {
        let sin = (1.0 - mu * mu).sqrt() as f32;
        for i in 0..n {
            // Half a step off the axes, so that few azimuths tell the axes apart; along x if there is one.
            let phi = if n == 1 { 0.0 } else { (i as f32 + 0.5) / n as f32 * TAU };
            let wo = vec3a(sin * phi.cos(), sin * phi.sin(), mu as f32);
            sum = sum.add(hemispherical_directional(bsdf, wo).scaled((2.0 * mu * w) as f32 / n as f32));
        }
    }
    sum
}

/// Nodes and weights for 0 ≤ µ ≤ 1. A smooth interface reflects all below µ² = 1 − η², and above it all but the root
/// of the distance: a panel ends there, and the next one's variable is that root.
fn cosines(eta: Option<f32>) -> Vec<(f64, f64)> {
    let nodes = gauss_legendre(16);
    match eta {
        Some(eta) if eta < 1.0 => {
            let critical = (1.0 - (eta as f64).powi(2)).sqrt();
            let below = nodes.iter().map(|&(x, w)| (critical * x, critical * w));
            let rest = 1.0 - critical;
            below.chain(nodes.iter().map(|&(x, w)| (critical + rest * x * x, rest * 2.0 * x * w))).collect()
        }
        _ => nodes,
    }
}
