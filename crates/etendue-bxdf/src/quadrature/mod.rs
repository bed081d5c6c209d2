//! Integrals over directions, by Gauss-Legendre panels placed where a scattering lobe needs them.
//!
//! A tight lobe is a spike of unknown place in the space of `wi`, but a known bump in the space of half vectors: for a
//! GGX lobe the slopes of the half vector, divided by α, have the same fixed distribution for each α and `wo`. So
//! the upper hemisphere is integrated over the polar coordinates (s, ψ) of those stretched slopes:
//!
//! ```text
//! m ∝ (αx s cos ψ, αy s sin ψ, 1),   wi = 2 (wo·m) m − wo,   dωi = 4 (wo·m) · cos³θm · αx αy s ds dψ
//! ```
//!
//! `wi` lies above the horizon exactly for s below a limit s*(ψ) with a closed form, so no integrand has a step in it.
//! The lower hemisphere has coordinates of the same kind around the refracted direction ([`RefractionMap`]), or the
//! upper one's, mirrored, where the indices on both sides are equal. Everything here is in `f64`; only the scattering
//! function itself is asked in `f32`.

mod half_vector;
mod refraction;

pub use half_vector::HalfVectorMap;
pub use refraction::RefractionMap;

use crate::{bsdf::Bsdf, reflectance};
use core::f64::consts::{PI, TAU};
use etendue_color::Spectrum;
use glam::{DVec3, Vec3A};

/// Nodes and weights of Gauss-Legendre quadrature on 0..1, exact for polynomials of degree 2n − 1.
///
/// The nodes are the roots of the Legendre polynomial Pₙ, by Newton's method from Tricomi's estimate; `n` is clamped to 1..=64.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let n = n.clamp(1, 64);
    (0..n)
        .map(|i| {
            let mut x = ((i as f64 + 0.75) / (n as f64 + 0.5) * PI).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                // Bonnet's recurrence gives Pₙ and Pₙ₋₁, and these the derivative.
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// GGX over stretched slopes, up to a constant: (1 + s²)⁻².
fn lobe_shape(s: f64) -> f64 {
    let q = 1.0 / (1.0 + s * s);
    q * q
}

/// Calls `f` for each interval between neighbouring `breaks`, cut to `range`.
fn for_panels(breaks: &[f64], range: (f64, f64), mut f: impl FnMut(f64, f64)) {
    for w in breaks.windows(2) {
        let (a, b) = (w[0].max(range.0), w[1].min(range.1));
        if a < b {
            f(a, b);
        }
    }
}

/// The coordinates of one hemisphere of directions: of the side of `wo`, or of the far side.
#[derive(Clone, Copy, Debug)]
pub enum HemisphereMap {
    /// Reflected directions.
    Upper(HalfVectorMap),
    /// The same, turned down: for the far side where the indices on both sides are equal.
    Mirrored(HalfVectorMap),
    /// Refracted directions.
    Lower(RefractionMap),
}

impl HemisphereMap {
    /// Of the side of `wo`.
    pub fn upper<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A) -> Self {
        Self::Upper(HalfVectorMap::new(wo, bsdf.narrowest_alpha()))
    }

    /// Of the far side; `None` if no light passes there.
    pub fn lower<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A) -> Option<Self> {
        let eta = bsdf.refraction()?;
        let alpha = bsdf.narrowest_alpha();
        Some(if (eta - 1.0).abs() < 1e-4 {
            Self::Mirrored(HalfVectorMap::new(wo, alpha))
        } else {
            Self::Lower(RefractionMap::new(wo, alpha, eta))
        })
    }

    /// The radial coordinate, 0 at the peak of a tight lobe, in widths of it; and the angle about the peak in 0..2π.
    pub fn coordinates_exact(&self, wi: DVec3) -> (f64, f64) {
        match self {
            Self::Upper(m) => m.coordinates_exact(wi),
            Self::Mirrored(m) => m.coordinates_exact(DVec3 { z: -wi.z, ..wi }),
            Self::Lower(m) => m.coordinates_exact(wi),
        }
    }

    /// Integral of `f(wi)` dωi over the rectangle `radius` × `psi` of the coordinates; `nodes` from [`gauss_legendre`].
    pub fn integrate(
        &self,
        radius: (f64, f64),
        psi: (f64, f64),
        nodes: &[(f64, f64)],
        f: impl Fn(Vec3A) -> [f32; 4],
    ) -> [f64; 4] {
        match self {
            Self::Upper(m) => m.integrate(radius, psi, nodes, f),
            Self::Mirrored(m) => m.integrate(radius, psi, nodes, |wi| f(Vec3A::new(wi.x, wi.y, -wi.z))),
            Self::Lower(m) => m.integrate(radius, psi, nodes, f),
        }
    }

    /// [`HemisphereMap::integrate`] with panels of rising order until the change of each lane is within `tolerance` of its value.
    ///
    /// For a lobe that the coordinates fit the least order does; a fibre's ridge or a step takes more, at most 24.
    pub fn integrate_within(
        &self,
        radius: (f64, f64),
        psi: (f64, f64),
        tolerance: impl Fn(f64) -> f64,
        f: impl Fn(Vec3A) -> [f32; 4],
    ) -> [f64; 4] {
        let mut last = self.integrate(radius, psi, &gauss_legendre(ORDERS[0]), &f);
        for order in &ORDERS[1..] {
            let now = self.integrate(radius, psi, &gauss_legendre(*order), &f);
            let settled = now.iter().zip(last).all(|(a, b)| (a - b).abs() <= tolerance(*a));
            last = now;
            if settled {
                break;
            }
        }
        last
    }

    /// Integral over the whole hemisphere; see [`HemisphereMap::integrate_within`].
    pub fn integrate_all(&self, tolerance: f64, f: impl Fn(Vec3A) -> [f32; 4]) -> [f64; 4] {
        self.integrate_within((0.0, f64::INFINITY), (0.0, TAU), |_| tolerance, f)
    }
}

/// Orders of panels that are tried one after another. From 4 to 24 the albedo of isotropic GGX lobes changes by 1e-6.
const ORDERS: [usize; 4] = [4, 6, 12, 24];

/// The change from one order to the next that is small enough for albedos and total densities. The error that is left is
/// that of the higher order, a tenth of the change or less.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// The part of the light from `wo` that is scattered anywhere: [`reflectance::hemispherical_directional`], reflection
/// plus transmission. What a surface returns under a sky of radiance 1 on both sides.
///
/// In radiance mode what passes an interface is scaled by 1/η² and the sum is no balance of energy; ask a closure made
/// for [`crate::model::Transport::Importance`] for that. Takes some milliseconds. Zero for `wo` below the surface.
pub fn directional_albedo<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A) -> Spectrum {
    reflectance::hemispherical_directional(bsdf, wo).total()
}

/// ∫ pdf(wo, wi) dωi over all directions: one minus the probability that `sample` returns nothing or a perfectly
/// specular direction.
pub fn pdf_integral<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A) -> f64 {
    if !(wo.z > 0.0) {
        return 0.0;
    }
    [Some(HemisphereMap::upper(bsdf, wo)), HemisphereMap::lower(bsdf, wo)]
        .into_iter()
        .flatten()
        .map(|map| map.integrate_all(TOLERANCE, |wi| [bsdf.pdf(wo, wi), 0.0, 0.0, 0.0])[0])
        .sum()
}

/// Average albedo: [`reflectance::bihemispherical`], reflection plus transmission, for a scattering function that does
/// not change when the surface is turned about its normal.
pub fn average_albedo<B: Bsdf + ?Sized>(bsdf: &B) -> Spectrum {
    reflectance::bihemispherical(bsdf).total()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_integrates_polynomials() {
        for n in [1, 2, 5, 8, 16, 64] {
            let nodes = gauss_legendre(n);
            for degree in 0..(2 * n).min(40) {
                let got: f64 = nodes.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!(
                    (got - 1.0 / (degree as f64 + 1.0)).abs() < 1e-13,
                    "{n} nodes, degree {degree}: {got}"
                );
            }
        }
    }
}
