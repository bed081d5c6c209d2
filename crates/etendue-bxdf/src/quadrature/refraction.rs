//! The lower hemisphere, with nodes where a refracted lobe needs them.
//!
//! Refraction by a microfacet m, half way between the directions in the sense of Walter et al. 2007 (eq. 16),
//!
//! ```text
//! m ∝ ∓(wo + η wi),   dωi = (wo·m + η wi·m)² / (η² |wi·m|) dωm      (Walter et al. 2007, eq. 17)
//! ```
//!
//! reaches only directions within a cone, and leaves out all that a diffuse transmission lights. So the half vector's
//! slopes are not themselves the coordinates here, but set their scale. A direction below the horizon is a point p =
//! (wi.x, wi.y) of the unit disk; the half vector's slopes are zero at p₀ = −(wo.x, wo.y)/η, Snell's direction, and for
//! tight lobes η (p − p₀) / (wo.z + η wi.z) around it. With that factor's value at p₀ in β,
//!
//! ```text
//! p = p₀ + ρ (βx cos ψ, βy sin ψ),   β = α |wo.z + η wi₀.z| / η,   dωi = βx βy ρ dρ dψ / |wi.z|
//! ```
//!
//! covers every wi.z < 0 once, ρ being for a tight lobe what s is to [`super::HalfVectorMap`]: in (ρ, ψ) it has the
//! same shape for each α, `wo` and η. Under total reflection p₀ lies outside the disk and the nearest point of its rim
//! takes its place. Panels end where a scattering function may have a step or a kink: at the rim (where 1/|wi.z| grows
//! without bound; a square-root substitution undoes it), at the border of the cone that refraction reaches,
//! wo·wi = −min(η, 1/η), and where the half vector is horizontal, wo.z = η |wi.z|. All are quadratic in ρ.

use super::lobe_shape;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::{DVec2, DVec3, Vec3A, dvec2, dvec3};

/// The map between directions below the horizon and coordinates around Snell's, for one `wo` and η ≠ 1.
#[derive(Clone, Copy, Debug)]
pub struct RefractionMap {
    wo: DVec3,
    eta: f64,
    alpha: DVec2,
    /// p₀, or the nearest point of the rim.
    centre: DVec2,
    /// 1 − |centre|²: the squared z of the direction at the centre.
    centre_z2: f64,
    beta: DVec2,
}

impl RefractionMap {
    /// `wo` above the horizon (its z is raised to 1e-9 otherwise), α along x and y > 0, `eta` the far side's index over
    /// the near side's, > 0. An `eta` nearer to 1 than 1e-5 counts as that far from it: at 1 the slopes' scale is zero,
    /// and the mirrored [`super::HalfVectorMap`] is the map to use.
    pub fn new(wo: Vec3A, alpha: [f32; 2], eta: f32) -> Self {
        let wo = dvec3(wo.x as f64, wo.y as f64, (wo.z as f64).max(1e-9));
        let eta = eta as f64;
        let eta = if eta >= 1.0 { eta.max(1.0 + 1e-5) } else { eta.max(1e-3).min(1.0 - 1e-5) };
        let alpha = dvec2(alpha[0].max(1e-9) as f64, alpha[1].max(1e-9) as f64);
        let snell = wo.truncate() / -eta;
        let (centre, centre_z2) = if snell.length_squared() < 1.0 {
            (snell, 1.0 - snell.length_squared())
        } else {
            (snell.normalize(), 0.0)
        };
        let scale = ((wo.z - eta * centre_z2.sqrt()).abs() / eta).max(1e-9);
        Self { wo, eta, alpha, centre, centre_z2, beta: alpha * scale }
    }

    /// The displacement of p by one unit of ρ.
    fn ray_vector(&self, psi: f64) -> DVec2 {
        self.beta * dvec2(psi.cos(), psi.sin())
    }

    /// The roots ρ of |p|² = 1, least first; the least is not positive.
    fn rim(&self, psi: f64) -> (f64, f64) {
        let b = self.ray_vector(psi);
        let (b2, cb) = (b.length_squared(), self.centre.dot(b));
        let root = (cb * cb + self.centre_z2 * b2).sqrt();
        // The form without cancellation for each.
        if cb <= 0.0 {
            let end = (root - cb) / b2;
            (if end > 0.0 { -self.centre_z2 / (b2 * end) } else { 0.0 }, end)
        } else {
            (-(cb + root) / b2, self.centre_z2 / (cb + root))
        }
    }

    /// ρ*(ψ): every 0 ≤ ρ < ρ* is a direction below the horizon.
    pub fn horizon(&self, psi: f64) -> f64 {
        self.rim(psi).1
    }

    /// (ρ, ψ) of a direction below the horizon; ψ in 0..2π.
    pub fn coordinates(&self, wi: Vec3A) -> (f64, f64) {
        self.coordinates_exact(wi.as_dvec3())
    }

    /// [`RefractionMap::coordinates`] of a direction with more digits.
    pub fn coordinates_exact(&self, wi: DVec3) -> (f64, f64) {
        super::polar(self.offset(wi))
    }

    /// (ρ cos ψ, ρ sin ψ) of a direction below the horizon.
    #[inline]
    pub fn offset(&self, wi: DVec3) -> DVec2 {
        (wi.truncate() - self.centre) / self.beta
    }

    /// The half vector's slopes over α.
    fn slope(&self, wi: DVec3) -> f64 {
        let h = self.wo + wi * self.eta;
        (h.truncate() / self.alpha).length() / h.z.abs().max(1e-30)
    }

    /// The curves at which a scattering function may have a step or a kink, as a ρ² + b ρ + c = 0.
    fn kinks(&self, psi: f64) -> [[f64; 3]; 2] {
        let b = self.ray_vector(psi);
        // A horizontal half vector, wo.z = η |wi.z|: |p|² = 1 − (wo.z/η)².
        let z = self.wo.z / self.eta;
        let horizontal = [b.length_squared(), 2.0 * self.centre.dot(b), z * z - self.centre_z2];
        // The border of the cone, wo·wi = −k: (k + wo.xy·p)² = wo.z² (1 − p²).
        let k = self.eta.min(1.0 / self.eta);
        let (c, d) = (k + self.wo.truncate().dot(self.centre), self.wo.truncate().dot(b));
        let z2 = self.wo.z * self.wo.z;
        let cone = [
            d * d + z2 * b.length_squared(),
            2.0 * (c * d + z2 * self.centre.dot(b)),
            c * c - z2 * self.centre_z2,
        ];
        [horizontal, cone]
    }

    /// The angles ψ at which a ray is tangent to one of [`RefractionMap::kinks`].
    fn tangents(&self) -> Vec<f64> {
        let mut out = Vec::new();
        for curve in 0..2 {
            // The discriminant is a quadratic form in (cos ψ, sin ψ): three values give it, and its zeros are two lines.
            let form = |psi: f64| {
                let [a, b, c] = self.kinks(psi)[curve];
                b * b - 4.0 * a * c
            };
            let (xx, yy) = (form(0.0), form(FRAC_PI_2));
            let xy = form(0.5 * FRAC_PI_2) - 0.5 * (xx + yy);
            let d = xy * xy - xx * yy;
            if d > 0.0 {
                for root in [d.sqrt(), -d.sqrt()] {
                    let psi = (-xy + root).atan2(yy);
                    out.extend([psi, psi + PI]);
                }
            }
        }
        out
    }

    /// The directions of one angle ψ, for [`super::table`].
    pub(super) fn ray(&self, psi: f64) -> LowerRay {
        let (start, end) = self.rim(psi);
        LowerRay { map: *self, psi, b: self.ray_vector(psi), start, end }
    }

    /// Angles at which what a ray gives may change its course: where ρ* passes from one regime to the other, where a ray
    /// is tangent to a kink, and along the narrow axis of an elongated lobe.
    pub(super) fn turns(&self) -> Vec<f64> {
        let zero = (-(self.beta.x * self.centre.x)).atan2(self.beta.y * self.centre.y);
        let mut out: Vec<f64> = (0..4).map(|i| (zero + i as f64 * FRAC_PI_2).rem_euclid(TAU)).collect();
        out.extend(self.tangents().into_iter().map(|at| at.rem_euclid(TAU)));
        super::around(&[zero, zero + PI], self.centre_z2.sqrt().max(1e-3), &mut out);
        super::along_narrow_axis(self.beta.x, self.beta.y, &mut out);
        out
    }

    /// What rounding a direction from `exact` to `wi` does to a tight lobe, undone by its known shape.
    #[inline]
    fn rounding(&self, exact: DVec3, wi: Vec3A) -> f64 {
        let shape = lobe_shape(self.slope(exact)) / lobe_shape(self.slope(wi.as_dvec3()));
        // Where the half vector is horizontal its slopes say nothing, and nothing is tight there.
        if (0.5..2.0).contains(&shape) { shape } else { 1.0 }
    }
}

/// The directions of one angle about the peak.
#[derive(Clone, Copy, Debug)]
pub(super) struct LowerRay {
    map: RefractionMap,
    psi: f64,
    b: DVec2,
    start: f64,
    /// ρ*.
    pub end: f64,
}

impl LowerRay {
    /// The parameter of a ρ: √(ρ* − ρ), in which the direction's z has no root.
    #[inline]
    pub fn parameter(&self, rho: f64) -> f64 {
        (self.end - rho).max(0.0).sqrt()
    }

    /// The direction at a parameter and dωi / (dt dψ), with what rounding the direction to `f32` does to a tight lobe undone.
    #[inline]
    pub fn at(&self, t: f64) -> (Vec3A, f64) {
        let map = &self.map;
        let rho = self.end - t * t;
        let p = map.centre + self.b * rho;
        let z = self.b.length() * t * (rho - self.start).max(0.0).sqrt();
        let exact = dvec3(p.x, p.y, -z.max(1e-12));
        let wi = exact.as_vec3a();
        // 2 t dt = −dρ; z is proportional to t.
        let weight = 2.0 * map.beta.x * map.beta.y * rho * t / z.max(1e-12);
        (wi, weight * map.rounding(exact, wi))
    }

    /// Doubling from the bump outwards, towards the rim, and at the kinks.
    pub fn breaks(&self, out: &mut Vec<f64>) {
        let mut rho = (1.0 / 16.0f64).min(0.25 * self.end);
        while rho > 0.0 && rho < self.end {
            out.push(rho);
            rho *= if rho < 0.5 { 4.0 } else { 2.0 };
        }
        out.extend((1..4).map(|j| self.end * (1.0 - 0.25f64.powi(j))));
        let from = out.len();
        for [a, b, c] in self.map.kinks(self.psi) {
            let d = b * b - 4.0 * a * c;
            if d > 0.0 && a > 0.0 {
                let q = -0.5 * (b + d.sqrt().copysign(b));
                out.push(q / a);
                if q != 0.0 {
                    out.push(c / q);
                }
            }
        }
        let mut kept = from;
        for i in from..out.len() {
            if out[i] > 0.0 && out[i] < self.end {
                out[kept] = out[i];
                kept += 1;
            }
        }
        out.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::{HemisphereMap, gauss_legendre},
        *,
    };

    const ETAS: [f32; 7] = [0.4, 1.0 / 1.5, 0.95, 1.0, 1.05, 1.5, 2.5];

    fn wo(degrees: f32) -> Vec3A {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3A::new(sin * 0.6, sin * 0.8, cos)
    }

    #[test]
    fn the_map_covers_the_lower_hemisphere_once() {
        for eta in ETAS {
            for angle in [0.0f32, 30.0, 41.8, 60.0, 85.0, 89.0] {
                for alpha in [[1.0, 1.0], [0.3, 0.05], [1e-2, 1e-2], [1e-4, 1e-4]] {
                    let map = RefractionMap::new(wo(angle), alpha, eta);
                    let got = HemisphereMap::Lower(map).integrate_all(1e-6, |w| [1.0, -w.z, w.x * w.x, w.y]);
                    for (got, want) in got.into_iter().zip([TAU, PI, TAU / 3.0, 0.0]) {
                        assert!(
                            (got - want).abs() < 1e-5 * TAU,
                            "η {eta} {angle}° {alpha:?}: {got} for {want}"
                        );
                    }
                    for (rho, psi) in [(0.3, 0.2), (1.0, 3.0), (4.0, 5.0)] {
                        let end = map.horizon(psi);
                        assert!(end >= 0.0);
                        if rho < end {
                            let ray = map.ray(psi);
                            let (wi, _) = ray.at(ray.parameter(rho));
                            assert!((wi.as_dvec3().length() - 1.0).abs() < 2e-7 && wi.z < 0.0);
                            let (rho2, psi2) = map.coordinates(wi);
                            // wi is rounded to f32: what is left of it for tight lobes.
                            let tolerance = 1e-7 / map.beta.min_element() + 1e-5;
                            let turned = (psi - psi2).sin().abs() * rho;
                            assert!((rho - rho2).abs() < tolerance && turned < tolerance);
                        }
                    }
                }
            }
        }
    }

    /// ∫ over refracted half vectors, in the map and in the half vector's own slopes, for the GGX distribution.
    #[test]
    fn the_map_agrees_with_walters_jacobian() {
        let nodes = gauss_legendre(6);
        let fine = gauss_legendre(24);
        for eta in [1.0f32 / 1.5, 1.5, 2.5] {
            for angle in [0.0f32, 35.0, 60.0, 85.0] {
                for a in [1.0f32, 0.3, 1e-2, 1e-4] {
                    let wo = wo(angle);
                    let map = RefractionMap::new(wo, [a, a], eta);
                    let (a, e, o) = (a as f64, eta as f64, wo.as_dvec3());
                    let d = |m: DVec3| {
                        let q = (m.x * m.x + m.y * m.y) / (a * a) + m.z * m.z;
                        1.0 / (core::f64::consts::PI * a * a * q * q)
                    };
                    // Any smooth factor that vanishes where refraction ends serves: (wo·m)² (wi·m)².
                    let here_by = |tolerance: f64| {
                        HemisphereMap::Lower(map).integrate_all(tolerance, |wi| {
                            let i = wi.as_dvec3();
                            let h = o + i * e;
                            let m = h.normalize() * if e > 1.0 { -1.0 } else { 1.0 };
                            let (om, im) = (o.dot(m), i.dot(m));
                            if !(m.z > 0.0 && om > 0.0 && im < 0.0) {
                                return [0.0];
                            }
                            let jacobian = e * e * -im / (om + e * im).powi(2);
                            [(d(m) * jacobian * om * om * im * im) as f32]
                        })[0]
                    };
                    let here = here_by(1e-6);
                    let finer = here_by(1e-8);
                    let mut there = 0.0;
                    for i in 0..64 {
                        for &(x, w) in &nodes {
                            let psi = (i as f64 + x) / 64.0 * TAU;
                            for j in 0..96 {
                                for &(y, v) in &fine[..] {
                                    let v0 = (j as f64 + y) / 96.0;
                                    let s = a * v0 / (1.0 - v0);
                                    let m = dvec3(s * psi.cos(), s * psi.sin(), 1.0).normalize();
                                    // dωm = cos³θm s ds dψ
                                    let area = d(m) * m.z.powi(3) * s * a / (1.0 - v0).powi(2) * TAU;
                                    let om = o.dot(m);
                                    let sin2 = (1.0 - om * om) / (e * e);
                                    let wi = m * (om / e - (1.0 - sin2).max(0.0).sqrt()) - o / e;
                                    if om > 0.0 && sin2 < 1.0 && wi.z < 0.0 {
                                        there += w * v / 64.0 / 96.0 * area * om * om * (1.0 - sin2);
                                    }
                                }
                            }
                        }
                    }
                    assert!((here - there).abs() < 2e-5, "η {eta} {angle}° α {a}: {here} and {there}");
                    assert!((here - finer).abs() < 1e-6, "η {eta} {angle}° α {a}: {here} and {finer}");
                }
            }
        }
    }
}
