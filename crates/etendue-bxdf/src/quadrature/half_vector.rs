//! The upper hemisphere by stretched half vectors; see the module above.

use super::{for_panels, lobe_shape};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::{DVec2, DVec3, Vec3A, dvec2, dvec3};

/// The map between reflected directions and stretched half-vector slopes, for one `wo`.
#[derive(Clone, Copy, Debug)]
pub struct HalfVectorMap {
    wo: DVec3,
    ax: f64,
    ay: f64,
}

impl HalfVectorMap {
    /// `wo` above the horizon (its z is raised to 1e-9 otherwise), α along x and y > 0.
    ///
    /// `wo` keeps the length that it has in `f32`: at α = 1e-4 and grazing angles a difference of 6e-8 between this map
    /// and the function integrated would shift the lobe by a hundredth of its width.
    pub fn new(wo: Vec3A, alpha: [f32; 2]) -> Self {
        let wo = dvec3(wo.x as f64, wo.y as f64, (wo.z as f64).max(1e-9));
        Self { wo, ax: alpha[0].max(1e-9) as f64, ay: alpha[1].max(1e-9) as f64 }
    }

    /// The direction at (s, ψ) and dωi / (ds dψ).
    pub fn direction(&self, s: f64, psi: f64) -> (Vec3A, f64) {
        let h = dvec3(self.ax * s * psi.cos(), self.ay * s * psi.sin(), 1.0);
        let len2 = h.length_squared();
        let dot = self.wo.dot(h);
        let wi = h * (2.0 * dot / len2) - self.wo;
        // 4 (wo·m) cos³θm with the normalisations of m written out.
        let jacobian = 4.0 * dot * self.ax * self.ay * s / (len2 * len2);
        (wi.as_vec3a(), jacobian)
    }

    /// (s, ψ) of a reflected direction above the horizon; ψ in 0..2π.
    pub fn coordinates(&self, wi: Vec3A) -> (f64, f64) {
        self.coordinates_exact(wi.as_dvec3())
    }

    /// [`HalfVectorMap::coordinates`] of a direction with more digits.
    pub fn coordinates_exact(&self, wi: DVec3) -> (f64, f64) {
        super::polar(self.slopes(wi))
    }

    /// The stretched slopes (s cos ψ, s sin ψ) of a reflected direction above the horizon.
    #[inline]
    pub fn slopes(&self, wi: DVec3) -> DVec2 {
        let h = self.wo + wi;
        let inv = 1.0 / h.z;
        dvec2(h.x * inv / self.ax, h.y * inv / self.ay)
    }

    /// s*(ψ): `wi` lies above the horizon for 0 ≤ s < s*.
    pub fn horizon(&self, psi: f64) -> f64 {
        // wi.z > 0 is −wz b s² + 2 a s + wz > 0; the positive root, in the form without cancellation.
        let (x, y) = (self.ax * psi.cos(), self.ay * psi.sin());
        let a = self.wo.x * x + self.wo.y * y;
        let b = x * x + y * y;
        let z = self.wo.z;
        let root = (a * a + z * z * b).sqrt();
        if a > 0.0 { (a + root) / (z * b) } else { z / (root - a) }
    }

    /// Where a panel in ψ should end: dense around the two angles at which s* passes from one regime to the other.
    fn psi_breaks(&self) -> Vec<f64> {
        // a(ψ) = 0, and the quarter turns between.
        let zero = (-(self.ax * self.wo.x)).atan2(self.ay * self.wo.y);
        // Across a lobe that is wide one way and narrow the other the horizon moves within the ratio of the two.
        let aspect = (self.ax / self.ay).max(self.ay / self.ax);
        let levels = 10 + aspect.log2().max(0.0).min(30.0) as i32;
        let mut breaks = vec![0.0, TAU];
        for quarter in 0..4 {
            let at = zero + quarter as f64 * FRAC_PI_2;
            breaks.push(at.rem_euclid(TAU));
            for j in 1..levels {
                let d = FRAC_PI_2 * 0.5f64.powi(j);
                breaks.push((at + d).rem_euclid(TAU));
                breaks.push((at - d).rem_euclid(TAU));
            }
        }
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        breaks
    }

    /// The directions of one angle ψ, for [`super::table`].
    pub(super) fn ray(&self, psi: f64) -> UpperRay {
        let (sin, cos) = psi.sin_cos();
        UpperRay { map: *self, x: self.ax * cos, y: self.ay * sin, end: self.horizon(psi) }
    }

    /// Angles at which what a ray gives may change its course: where s* passes from one regime to the other, and along the
    /// narrow axis of an elongated lobe, as narrow in ψ as the ratio of the axes.
    pub(super) fn turns(&self) -> Vec<f64> {
        let zero = (-(self.ax * self.wo.x)).atan2(self.ay * self.wo.y);
        let mut out: Vec<f64> = (0..4).map(|i| (zero + i as f64 * FRAC_PI_2).rem_euclid(TAU)).collect();
        // At grazing angles it passes within an angle of wo.z, and where it does, the far ends of ridges lie.
        super::around(&[zero, zero + PI], self.wo.z.max(1e-3), &mut out);
        super::along_narrow_axis(self.ax, self.ay, &mut out);
        out
    }

    /// Where a panel in s should end: doubling from the bump outwards, and halving towards the horizon.
    fn s_breaks(&self, psi: f64) -> Vec<f64> {
        let end = self.horizon(psi);
        let mut breaks = vec![0.0];
        let mut s = (0.25f64).min(end / 64.0).max(1e-12 * end);
        while s < end {
            breaks.push(s);
            s *= 2.0;
        }
        breaks.extend((1..9).map(|j| end * (1.0 - 0.5f64.powi(j))));
        breaks.push(end);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * end);
        breaks
    }

    /// Integral over the rectangle `s` × `psi` of `f(wi)` dωi, as far as it lies above the horizon; `nodes` from
    /// [`super::gauss_legendre`]. Four independent lanes.
    pub fn integrate(
        &self,
        s: (f64, f64),
        psi: (f64, f64),
        nodes: &[(f64, f64)],
        f: impl Fn(Vec3A) -> [f32; 4],
    ) -> [f64; 4] {
        let mut sum = [0.0f64; 4];
        for_panels(&self.psi_breaks(), psi, |p0, p1| {
            for &(x, w) in nodes {
                let angle = p0 + (p1 - p0) * x;
                let w_psi = w * (p1 - p0);
                for_panels(&self.s_breaks(angle), s, |s0, s1| {
                    for &(x, w) in nodes {
                        let s = s0 + (s1 - s0) * x;
                        let (wi, jacobian) = self.direction(s, angle);
                        // Rounding wi to f32 moves the point by up to a few hundredths of a tight lobe's width at
                        // grazing angles; a lobe's steepest factor is undone by its known shape.
                        let moved = lobe_shape(s) / lobe_shape(self.coordinates(wi).0);
                        let weight = w * (s1 - s0) * w_psi * jacobian * moved;
                        for (sum, v) in sum.iter_mut().zip(f(wi)) {
                            *sum += weight * v as f64;
                        }
                    }
                });
            }
        });
        sum
    }

    /// Integral over the whole upper hemisphere.
    pub fn integrate_all(&self, nodes: &[(f64, f64)], f: impl Fn(Vec3A) -> [f32; 4]) -> [f64; 4] {
        self.integrate((0.0, f64::INFINITY), (0.0, TAU), nodes, f)
    }
}

/// The directions of one angle about the peak.
#[derive(Clone, Copy, Debug)]
pub(super) struct UpperRay {
    map: HalfVectorMap,
    x: f64,
    y: f64,
    /// s*.
    pub end: f64,
}

impl UpperRay {
    /// The direction at s and dωi / (ds dψ), with what rounding the direction to `f32` does to a tight lobe undone.
    #[inline]
    pub fn at(&self, s: f64) -> (Vec3A, f64) {
        let map = &self.map;
        let h = dvec3(self.x * s, self.y * s, 1.0);
        let len2 = h.length_squared();
        let dot = map.wo.dot(h);
        let wi = (h * (2.0 * dot / len2) - map.wo).as_vec3a();
        let jacobian = 4.0 * dot * map.ax * map.ay * s / (len2 * len2);
        let g = map.wo + wi.as_dvec3();
        let (p, q) = (g.x / (map.ax * g.z), g.y / (map.ay * g.z));
        // lobe_shape(s) over that of the rounded direction.
        let moved = (1.0 + p * p + q * q) / (1.0 + s * s);
        (wi, jacobian * moved * moved)
    }

    /// Doubling from the bump outwards, and towards the horizon.
    pub fn breaks(&self, out: &mut Vec<f64>) {
        let mut s = 0.5f64.min(0.25 * self.end);
        while s < self.end {
            out.push(s);
            s *= 2.0;
        }
        out.extend((1..4).map(|j| self.end * (1.0 - 0.25f64.powi(j))));
    }
}

#[cfg(test)]
mod tests {
    use super::{super::gauss_legendre, *};

    #[test]
    fn the_map_covers_the_hemisphere_once() {
        let nodes = gauss_legendre(6);
        for angle in [0.0f32, 30.0, 60.0, 85.0, 89.0] {
            let (sin, cos) = angle.to_radians().sin_cos();
            let wo = Vec3A::new(sin * 0.6, sin * 0.8, cos);
            for alpha in [[1.0, 1.0], [0.3, 0.05], [1e-2, 1e-2], [1e-4, 1e-4]] {
                let map = HalfVectorMap::new(wo, alpha);
                // Solid angle 2π, projected π; ∫ x² over the hemisphere 2π/3.
                let got = map.integrate_all(&nodes, |w| [1.0, w.z.max(0.0), w.x * w.x, w.y]);
                for (got, want) in got.into_iter().zip([TAU, PI, TAU / 3.0, 0.0]) {
                    assert!((got - want).abs() < 1e-5 * TAU, "{angle}° {alpha:?}: {got} for {want}");
                }
                for (s, psi) in [(0.3, 0.2), (1.0, 3.0), (4.0, 5.0)] {
                    let (wi, _) = map.direction(s, psi);
                    if wi.z > 0.05 {
                        let (s2, psi2) = map.coordinates(wi);
                        // wi is rounded to f32: what is left of it at small α.
                        let tolerance = 1e-6 / alpha[0].min(alpha[1]) as f64 / cos as f64 + 1e-5;
                        assert!((s - s2).abs() < tolerance && (psi - psi2).abs() < tolerance);
                    }
                    let end = map.horizon(psi);
                    assert!(map.direction(end * 0.999, psi).0.z > 0.0);
                    assert!(map.direction(end * 1.001, psi).0.z < 0.0);
                }
            }
        }
    }
}
