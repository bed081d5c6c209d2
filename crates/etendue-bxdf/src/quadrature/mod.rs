//! Integrals over directions, by adaptive panels in coordinates that fit a scattering lobe.
//!
//! A tight lobe is a spike of unknown place in the space of `wi`, but a known bump in the space of half vectors: for a
//! GGX lobe the slopes of the half vector, divided by α, have the same fixed distribution for each α and `wo`. So
//! the upper hemisphere is integrated over the polar coordinates (s, ψ) of those stretched slopes:
//!
//! ```text
//! m ∝ (αx s cos ψ, αy s sin ψ, 1),   wi = 2 (wo·m) m − wo,   dωi = 4 (wo·m) · cos³θm · αx αy s ds dψ
//! ```
//!
//! `wi` lies above the horizon exactly for s below a limit s*(ψ) with a closed form, so that step is no part of an
//! integrand. Other steps and kinks (total reflection, the horizon of a coat with a normal of its own, a fibre's ridges)
//! are found by halving along rays of constant ψ, and what the rays give by halving between them ([`Table`]).
//! The lower hemisphere has coordinates of the same kind around the refracted direction ([`RefractionMap`]), or the
//! upper one's, mirrored, where the indices on both sides are equal. Everything here is in `f64`; only the scattering
//! function itself is asked in `f32`.

mod adaptive;
mod half_vector;
mod refraction;
mod table;

pub use half_vector::HalfVectorMap;
pub use refraction::RefractionMap;
pub use table::Table;

use crate::{bsdf::Bsdf, reflectance};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use etendue_color::Spectrum;
use glam::{DVec2, DVec3, Vec3A};

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

/// Radius and angle in 0..2π of a point.
fn polar(p: DVec2) -> (f64, f64) {
    (p.length(), p.y.atan2(p.x).rem_euclid(TAU))
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

/// Adds angles, within 0..2π, around each of `centres`: ever nearer by quarters, down to `least`.
fn around(centres: &[f64], least: f64, out: &mut Vec<f64>) {
    for at in centres {
        out.push(at.rem_euclid(TAU));
        let mut d = 0.5 * FRAC_PI_4;
        while d > least {
            out.extend([(at + d).rem_euclid(TAU), (at - d).rem_euclid(TAU)]);
            d *= 0.25;
        }
    }
}

/// The same around the narrow axis of a lobe with widths `x` and `y`, down to the ratio of the two.
fn along_narrow_axis(x: f64, y: f64, out: &mut Vec<f64>) {
    let axis = if x > y { FRAC_PI_2 } else { 0.0 };
    around(&[axis, axis + PI], (x / y).min(y / x), out);
}

/// The directions of one angle about the peak, in order of the radius.
enum Ray {
    Upper(half_vector::UpperRay),
    Mirrored(half_vector::UpperRay),
    Lower(refraction::LowerRay),
}

impl Ray {
    /// The radius at the horizon.
    fn end(&self) -> f64 {
        match self {
            Self::Upper(r) | Self::Mirrored(r) => r.end,
            Self::Lower(r) => r.end,
        }
    }

    /// Radii at which an interval should end.
    fn breaks(&self, out: &mut Vec<f64>) {
        match self {
            Self::Upper(r) | Self::Mirrored(r) => r.breaks(out),
            Self::Lower(r) => r.breaks(out),
        }
    }

    /// What stands for a radius in [`Ray::at`].
    fn parameter(&self, radius: f64) -> f64 {
        match self {
            Self::Upper(_) | Self::Mirrored(_) => radius,
            Self::Lower(r) => r.parameter(radius),
        }
    }

    /// The direction and dωi over the parameter's step and the angle's.
    #[inline]
    fn at(&self, parameter: f64) -> (Vec3A, f64) {
        match self {
            Self::Upper(r) => r.at(parameter),
            Self::Mirrored(r) => {
                let (wi, weight) = r.at(parameter);
                (Vec3A::new(wi.x, wi.y, -wi.z), weight)
            }
            Self::Lower(r) => r.at(parameter),
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
        polar(self.offset(wi))
    }

    /// The same as a point of the plane: (radius · cos, radius · sin) of the angle.
    #[inline]
    pub fn offset(&self, wi: DVec3) -> DVec2 {
        match self {
            Self::Upper(m) => m.slopes(wi),
            Self::Mirrored(m) => m.slopes(DVec3 { z: -wi.z, ..wi }),
            Self::Lower(m) => m.offset(wi),
        }
    }

    fn ray(&self, psi: f64) -> Ray {
        match self {
            Self::Upper(m) => Ray::Upper(m.ray(psi)),
            Self::Mirrored(m) => Ray::Mirrored(m.ray(psi)),
            Self::Lower(m) => Ray::Lower(m.ray(psi)),
        }
    }

    fn psi_breaks(&self) -> Vec<f64> {
        match self {
            Self::Upper(m) | Self::Mirrored(m) => m.turns(),
            Self::Lower(m) => m.turns(),
        }
    }

    /// Integrals of `f(wi)` dωi over the rectangles between radial `edges` (rising, from 0 to ∞) and `sectors` equal angles,
    /// each lane within `tolerance` of the rectangle's integral.
    pub fn table<const N: usize>(
        &self,
        edges: &[f64],
        sectors: usize,
        tolerance: impl Fn(f64) -> f64,
        f: impl Fn(Vec3A) -> [f32; N],
    ) -> Table<N> {
        table::table(self, edges, sectors, tolerance, BUDGET, f)
    }

    /// Integral over the whole hemisphere, each lane within about `tolerance`.
    pub fn integrate_all<const N: usize>(&self, tolerance: f64, f: impl Fn(Vec3A) -> [f32; N]) -> [f64; N] {
        // Of the dozens of intervals some err, and by less than they are allowed.
        self.table(&RADII, 16, |_| 0.05 * tolerance, f).total()
    }
}

/// Where intervals of the radius end at least when a whole hemisphere is integrated.
const RADII: [f64; 10] = [0.0, 0.3, 0.6, 1.0, 1.5, 2.2, 3.3, 5.0, 10.0, f64::INFINITY];

/// Calls of a function after which integrals over a hemisphere are refined no more: a second or two.
const BUDGET: usize = 10_000_000;

/// The error of albedos and of whole densities.
pub(crate) const TOLERANCE: f64 = 1e-6;

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
        .map(|map| map.integrate_all(TOLERANCE, |wi| [bsdf.pdf(wo, wi)])[0])
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
