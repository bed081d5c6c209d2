//! Maps from the unit square to the domains that light is sampled over, frames, and MIS weights.
//!
//! All maps are continuous and keep area up to a constant (or the stated density), so that stratified points stay
//! stratified. Inputs are in 0..1; a 1 itself is allowed.

use crate::math::sin_cos_tau;
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::{Vec3A, vec3a};

/// A point of the unit disk, uniform: the concentric map (Shirley, Chiu 1997).
#[inline(always)]
pub fn concentric_disk(u: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let wide = a.abs() > b.abs();
    let (r, q) = if wide { (a, b) } else { (b, a) };
    if r == 0.0 {
        return [0.0, 0.0];
    }
    // The angle is an eighth of a turn times the ratio, measured from the longer coordinate's axis.
    let eighth = 0.125 * (q / r);
    let (s, c) = sin_cos_tau(if wide { eighth } else { 0.25 - eighth });
    [r * c, r * s]
}

/// A direction of the upper hemisphere (+Z) with density cos θ / π per steradian.
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3A {
    let [x, y] = concentric_disk(u);
    // The disk's radius is the larger of the two centred coordinates: (1−r)(1+r) keeps its digits near the rim.
    let r = (2.0 * u[0] - 1.0).abs().max((2.0 * u[1] - 1.0).abs());
    vec3a(x, y, ((1.0 - r) * (1.0 + r)).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`], per steradian.
#[inline(always)]
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos.max(0.0) * FRAC_1_PI
}

/// A direction of the whole sphere, density 1 / 4π per steradian.
#[inline(always)]
pub fn uniform_sphere(u: [f32; 2]) -> Vec3A {
    // 1 − |z| and 1 + |z| from u, not from z: the sine keeps its digits near the poles.
    let r = 2.0 * (u[0] * (1.0 - u[0])).max(0.0).sqrt();
    let (s, c) = sin_cos_tau(u[1]);
    vec3a(r * c, r * s, 1.0 - 2.0 * u[0])
}

/// A direction of the upper hemisphere (+Z), density 1 / 2π per steradian.
#[inline(always)]
pub fn uniform_hemisphere(u: [f32; 2]) -> Vec3A {
    uniform_cone(u, 1.0)
}

/// A direction of the cone around +Z whose half angle has the cosine 1 − `one_minus_cos`; uniform by solid angle.
///
/// The cone is given by 1 − cos θ (0..2) because cos θ of a small light, the sun say, has no digits left in `f32`.
#[inline(always)]
pub fn uniform_cone(u: [f32; 2], one_minus_cos: f32) -> Vec3A {
    let d = u[0] * one_minus_cos;
    let r = (d * (2.0 - d)).max(0.0).sqrt();
    let (s, c) = sin_cos_tau(u[1]);
    vec3a(r * c, r * s, 1.0 - d)
}

/// Density of [`uniform_cone`] inside the cone, per steradian.
#[inline(always)]
pub fn uniform_cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (TAU * one_minus_cos)
}

/// Barycentric weights of a triangle's three corners, uniform by area: Heitz 2019, "A Low-Distortion Map Between
/// Triangle and Square". They are not negative and sum to one.
#[inline(always)]
pub fn uniform_triangle(u: [f32; 2]) -> [f32; 3] {
    let (b0, b1) =
        if u[0] < u[1] { (0.5 * u[0], u[1] - 0.5 * u[0]) } else { (u[0] - 0.5 * u[1], 0.5 * u[1]) };
    [b0, b1, (1.0 - b0 - b1).max(0.0)]
}

/// Two unit vectors that complete a unit normal to a right-handed orthonormal frame, without a branch (Duff, Burgess,
/// Christensen, Hery, Kensler, Liani, Villemin 2017, "Building an Orthonormal Basis, Revisited").
#[inline(always)]
pub fn basis(n: Vec3A) -> (Vec3A, Vec3A) {
    let sign = 1.0f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (vec3a(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3a(b, sign + n.y * n.y * a, -n.y))
}

/// A right-handed orthonormal frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local +X.
    pub x: Vec3A,
    /// Local +Y.
    pub y: Vec3A,
    /// Local +Z, the normal.
    pub z: Vec3A,
}

impl Frame {
    /// Any frame around a unit normal.
    #[inline(always)]
    pub fn from_normal(n: Vec3A) -> Self {
        let (x, y) = basis(n);
        Self { x, y, z: n }
    }

    /// The frame around a unit normal whose +X lies as near to `tangent` as it can; any frame if they are parallel
    /// or `tangent` is not finite.
    #[inline(always)]
    pub fn from_normal_tangent(n: Vec3A, tangent: Vec3A) -> Self {
        let t = tangent - n * n.dot(tangent);
        let len2 = t.length_squared();
        if len2 > 1e-12 && len2.is_finite() {
            let x = t * (1.0 / len2.sqrt());
            Self { x, y: n.cross(x), z: n }
        } else {
            Self::from_normal(n)
        }
    }

    /// From the world to this frame.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3A) -> Vec3A {
        vec3a(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// From this frame to the world.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3A) -> Vec3A {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// MIS weight of a sample drawn with density `a` where another strategy would have drawn it with density `b`: the
/// balance heuristic a / (a + b) (Veach 1997, eq. 9.8), for equal numbers of samples. Zero if both are zero.
#[inline(always)]
pub fn balance_heuristic(a: f32, b: f32) -> f32 {
    // By the ratio, so that infinite densities and those whose sum would leave f32 need no case of their own.
    if a > 0.0 { 1.0 / (1.0 + b / a) } else { 0.0 }
}

/// MIS weight by the power heuristic with exponent 2: a² / (a² + b²) (Veach 1997, section 9.2.3). Zero if both are zero.
#[inline(always)]
pub fn power_heuristic(a: f32, b: f32) -> f32 {
    // By the ratio: squares of densities of tight lobes would leave f32.
    if a >= b {
        if !(a > 0.0) || a.is_infinite() {
            return if a > 0.0 { 1.0 } else { 0.0 };
        }
        let r = b / a;
        1.0 / (1.0 + r * r)
    } else {
        let r = a / b;
        let r2 = r * r;
        r2 / (1.0 + r2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> impl Iterator<Item = [f32; 2]> {
        (0..n * n).map(move |i| [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32])
    }

    /// Mean over a regular grid of the square: an integral over the domain, divided by its measure.
    fn mean(f: impl Fn([f32; 2]) -> f32) -> f64 {
        let n = 512;
        grid(n).map(|u| f(u) as f64).sum::<f64>() / (n * n) as f64
    }

    #[test]
    fn disk_is_uniform_and_within_the_rim() {
        for u in grid(64).chain([[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [0.0, 1.0], [0.5, 0.0]]) {
            let [x, y] = concentric_disk(u);
            assert!(x * x + y * y <= 1.0 + 1e-6);
        }
        // Moments of the uniform disk: E[x²] = 1/4, E[x⁴] = 1/8, E[xy] = 0, E[x] = 0.
        assert!((mean(|u| concentric_disk(u)[0].powi(2)) - 0.25).abs() < 1e-4);
        assert!((mean(|u| concentric_disk(u)[1].powi(4)) - 0.125).abs() < 1e-4);
        assert!(mean(|u| concentric_disk(u)[0] * concentric_disk(u)[1]).abs() < 1e-4);
        assert!(mean(|u| concentric_disk(u)[0]).abs() < 1e-4);
        // Same quadrants, no fold: the centre of the right edge lies at (1, 0), of the top edge at (0, 1).
        assert_eq!(concentric_disk([1.0, 0.5]), [1.0, 0.0]);
        let top = concentric_disk([0.5, 1.0]);
        assert!(top[0].abs() < 1e-6 && (top[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn directions_have_unit_length_and_their_moments() {
        for u in grid(64).chain([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) {
            for v in [cosine_hemisphere(u), uniform_sphere(u), uniform_hemisphere(u), uniform_cone(u, 1e-5)] {
                assert!((v.length() - 1.0).abs() < 1e-6, "{u:?} {v}");
            }
            assert!(cosine_hemisphere(u).z >= 0.0);
            assert!(uniform_cone(u, 1e-5).z >= 1.0 - 1.1e-5);
        }
        assert!((mean(|u| cosine_hemisphere(u).z) - 2.0 / 3.0).abs() < 1e-4);
        assert!((mean(|u| cosine_hemisphere(u).z.powi(2)) - 0.5).abs() < 1e-4);
        assert!((mean(|u| uniform_sphere(u).z.powi(2)) - 1.0 / 3.0).abs() < 1e-4);
        assert!((mean(|u| uniform_sphere(u).x.powi(2)) - 1.0 / 3.0).abs() < 1e-4);
        assert!((mean(|u| uniform_hemisphere(u).z) - 0.5).abs() < 1e-4);
        // A cone of half angle 60°: E[cos] = (1 + cos 60°)/2.
        assert!((mean(|u| uniform_cone(u, 0.5).z) - 0.75).abs() < 1e-4);
        assert!((uniform_cone_pdf(0.5) - 1.0 / core::f32::consts::PI).abs() < 1e-7);
    }

    #[test]
    fn triangle_is_uniform() {
        for u in grid(64).chain([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0]]) {
            let b = uniform_triangle(u);
            assert!(b.iter().all(|v| (0.0..=1.0).contains(v)));
            assert!((b[0] + b[1] + b[2] - 1.0).abs() < 1e-6);
        }
        // Moments of the uniform triangle: E[b] = 1/3, E[b²] = 1/6, E[b b'] = 1/12.
        for i in 0..3 {
            assert!((mean(|u| uniform_triangle(u)[i]) - 1.0 / 3.0).abs() < 1e-3);
            assert!((mean(|u| uniform_triangle(u)[i].powi(2)) - 1.0 / 6.0).abs() < 1e-3);
            let j = (i + 1) % 3;
            assert!((mean(|u| uniform_triangle(u)[i] * uniform_triangle(u)[j]) - 1.0 / 12.0).abs() < 1e-3);
        }
    }

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        let normals = grid(40).map(uniform_sphere).chain([
            Vec3A::Z,
            -Vec3A::Z,
            Vec3A::X,
            vec3a(1e-4, -1e-4, -1.0).normalize(),
            vec3a(0.0, 1.0, -0.0),
        ]);
        for n in normals {
            for f in [Frame::from_normal(n), Frame::from_normal_tangent(n, vec3a(0.3, 0.2, 1.0))] {
                assert!(f.x.dot(f.y).abs() < 2e-6 && f.y.dot(f.z).abs() < 2e-6 && f.z.dot(f.x).abs() < 2e-6);
                assert!((f.x.cross(f.y) - f.z).length() < 2e-6, "{n}");
                let v = vec3a(0.36, 0.48, 0.8);
                assert!((f.to_world(f.to_local(v)) - v).length() < 2e-6);
            }
        }
        // Parallel and broken tangents still give a frame.
        for t in [Vec3A::Z, Vec3A::ZERO, Vec3A::splat(f32::NAN), Vec3A::splat(f32::INFINITY)] {
            assert!((Frame::from_normal_tangent(Vec3A::Z, t).x.length() - 1.0).abs() < 1e-6);
        }
        let f = Frame::from_normal_tangent(Vec3A::Z, vec3a(3.0, 0.0, 5.0));
        assert_eq!(f.x, Vec3A::X);
    }

    #[test]
    fn heuristics_sum_to_one() {
        for (a, b) in
            [(1.0, 3.0), (1e30, 1.0), (1e-30, 1e-30), (0.0, 2.0), (3e38, 3e38), (f32::INFINITY, 1.0)]
        {
            let p = power_heuristic(a, b) + power_heuristic(b, a);
            assert!((p - 1.0).abs() < 1e-6, "{a} {b}: {p}");
            let p = balance_heuristic(a, b) + balance_heuristic(b, a);
            assert!((p - 1.0).abs() < 1e-6, "{a} {b}: {p}");
        }
        assert_eq!(power_heuristic(0.0, 0.0), 0.0);
        assert_eq!(balance_heuristic(0.0, 0.0), 0.0);
        assert!((power_heuristic(1.0, 3.0) - 0.1).abs() < 1e-7);
        assert!((balance_heuristic(1.0, 3.0) - 0.25).abs() < 1e-7);
    }
}
