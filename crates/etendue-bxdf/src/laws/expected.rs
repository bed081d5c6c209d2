//! What quadrature says of a closure seen from one direction, for the statistical laws to hold samples against.
//!
//! One pass over each hemisphere gives the expected counts of the χ² test, ∫ pdf and the directional albedo. It asks the
//! closure for [`Bsdf::eval_pdf`] and for where its lobes lie, never for a sample.
//!
//! Bins lie in the coordinates of [`HemisphereMap`], stretched half vectors or their like for refraction, so that they
//! fit a lobe of any width; those of the far side are there if [`Bsdf::refraction`] says that light passes.

use crate::{
    bsdf::{Bsdf, MIN_COS},
    quadrature::HemisphereMap,
};
use core::f64::consts::{FRAC_PI_2, SQRT_2, TAU};
use etendue_color::Spectrum;
use glam::{DVec2, DVec3, Vec3A, vec3a};

/// Bins in ψ.
const PSI_BINS: usize = 16;
/// Bins by quantiles of the slope distribution of the narrowest lobe.
const LOBE_BINS: usize = 14;
/// Further rings, evenly in the half vector's angle, for lobes that are wider.
const WIDE_BINS: usize = 8;
/// Expected counts that are a bin of their own; see [`super::chi2`].
pub(super) const LEAST_EXPECTED: f64 = 5.0;

/// Densities and albedos over the bins around a closure's lobes.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The side of `wo`, and the far side if light passes.
    sides: Vec<HemisphereMap>,
    /// Radial edges of the bins, from 0 to ∞.
    edges: Vec<f64>,
    /// ∫ pdf over each bin, side by side, ring by ring.
    pub bins: Vec<f64>,
    /// ∫ pdf over all directions: one minus the probability of no sample or a perfectly specular one.
    pub pdf_integral: f64,
    /// Directional albedo, reflection and transmission, with perfectly specular parts.
    pub albedo: Spectrum,
    /// About what of ∫ pdf lies within [`MIN_COS`] of the horizon, where no sample may be: quadrature does not see the gap.
    pub gap: f64,
    /// How often the closure was asked.
    pub calls: usize,
}

impl Expected {
    /// Integrals good enough for a χ² test of `samples` directions: each bin's error is a tenth of its count's spread or
    /// less, the whole's less than one in 10⁶.
    pub fn new<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A, samples: usize) -> Self {
        let edges = radial_edges(bsdf.narrowest_alpha());
        let sides = [Some(HemisphereMap::upper(bsdf, wo)), HemisphereMap::lower(bsdf, wo)];
        let sides: Vec<HemisphereMap> = sides.into_iter().flatten().collect();
        let mut out = Self {
            sides,
            edges,
            bins: Vec::new(),
            pdf_integral: 0.0,
            albedo: Spectrum::ZERO,
            gap: 0.0,
            calls: 0,
        };
        if !(wo.z > 0.0) {
            out.bins = vec![0.0; out.sides.len() * (out.edges.len() - 1) * PSI_BINS];
            return out;
        }
        let n = samples.max(1) as f64;
        let tolerance = |mass: f64| (0.1 * (n * mass.abs()).max(LEAST_EXPECTED).sqrt() / n).min(1e-5);
        let mut albedo = [0.0f64; 4];
        for map in &out.sides {
            let table = map.table(&out.edges, PSI_BINS, tolerance, |wi| {
                let e = bsdf.eval_pdf(wo, wi);
                let [a, b, c, d] = (e.value() * wi.z.abs()).0;
                [e.pdf, a, b, c, d]
            });
            out.bins.extend(table.cells.iter().map(|c| c[0]));
            let total = table.total();
            out.pdf_integral += total[0];
            for lane in 0..4 {
                albedo[lane] += total[lane + 1];
            }
            out.calls += table.calls;
        }
        out.gap = gap(bsdf, wo);
        out.albedo = Spectrum(albedo.map(|v| v as f32));
        for d in bsdf.deltas(wo).into_iter().flatten() {
            out.albedo += d.reflectance;
        }
        out
    }

    /// The bin of a direction; `None` on a side to which nothing passes.
    pub fn bin(&self, wi: DVec3) -> Option<usize> {
        let side = usize::from(wi.z < 0.0);
        let p = self.sides.get(side)?.offset(wi);
        let rings = self.edges.len() - 1;
        let r2 = p.length_squared();
        let ring = self.edges.partition_point(|&e| e * e <= r2).clamp(1, rings) - 1;
        let sector = sector(p);
        Some((side * rings + ring) * PSI_BINS + sector)
    }
}

/// Which sixteenth of the turn, from the x axis on, a point lies in.
#[inline]
fn sector(p: DVec2) -> usize {
    const _: () = assert!(PSI_BINS == 16);
    // Turned back into the first quarter, and by its slope there: tan 22.5° and tan 67.5° are √2 ∓ 1.
    let (quarter, x, y) = match (p.x >= 0.0, p.y >= 0.0) {
        (true, true) => (0, p.x, p.y),
        (false, true) => (1, p.y, -p.x),
        (false, false) => (2, -p.x, -p.y),
        (true, false) => (3, -p.y, p.x),
    };
    let beyond = |slope: f64| usize::from(y >= slope * x);
    4 * quarter + beyond(SQRT_2 - 1.0) + beyond(1.0) + beyond(SQRT_2 + 1.0)
}

/// ∫ pdf over the directions within [`MIN_COS`] of the horizon, from its values next to them.
fn gap<B: Bsdf + ?Sized>(bsdf: &B, wo: Vec3A) -> f64 {
    const AZIMUTHS: usize = 720;
    let step = TAU / AZIMUTHS as f64;
    let mut sum = 0.0;
    for k in 0..AZIMUTHS {
        let (sin, cos) = ((k as f64 + 0.5) * step).sin_cos();
        for z in [2.0 * MIN_COS, -2.0 * MIN_COS] {
            sum += f64::from(bsdf.eval_pdf(wo, vec3a(cos as f32, sin as f32, z)).pdf);
        }
    }
    sum * step * f64::from(MIN_COS)
}

/// Radial edges: quantiles of the narrowest lobe's slopes, then even steps of the half vector's angle.
fn radial_edges(alpha: [f32; 2]) -> Vec<f64> {
    let a = (alpha[0] as f64 * alpha[1] as f64).sqrt();
    // Slopes of GGX have the distribution function s² / (1 + s²).
    let lobe = (0..LOBE_BINS).map(|i| {
        let u = i as f64 / LOBE_BINS as f64;
        (u / (1.0 - u)).sqrt()
    });
    let mut edges: Vec<f64> = lobe.collect();
    let last = edges[LOBE_BINS - 1];
    edges.extend(
        (1..WIDE_BINS)
            .map(|i| (i as f64 / WIDE_BINS as f64 * FRAC_PI_2).tan() / a)
            .filter(|&s| s > 1.2 * last),
    );
    edges.push(f64::INFINITY);
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::{Rng, grid::wo_at};
    use core::f64::consts::TAU;

    #[test]
    fn bins_are_rings_and_sectors_of_the_map() {
        let bsdf = crate::GgxReflection::new(0.3, 0.1, crate::fresnel::Schlick::ONE);
        let expected = Expected::new(&bsdf, wo_at(40.0), 1_000);
        let mut rng = Rng::new(3);
        for _ in 0..10_000 {
            let wi = crate::sampling::uniform_hemisphere(rng.square()).as_dvec3();
            let (radius, psi) = expected.sides[0].coordinates_exact(wi);
            let bin = expected.bin(wi).expect("above");
            let (ring, sector) = (bin / PSI_BINS, bin % PSI_BINS);
            assert!((expected.edges[ring]..expected.edges[ring + 1]).contains(&radius), "{radius} in {ring}");
            assert_eq!(sector, (psi / TAU * PSI_BINS as f64) as usize);
        }
    }
}
