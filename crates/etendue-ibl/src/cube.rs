//! Cube maps: six square pictures of all directions, with mips.
//!
//! Faces in the order +X, −X, +Y, −Y, +Z, −Z and oriented as OpenGL, Vulkan, Direct3D, KTX2 and DDS have them (Khronos,
//! "OpenGL 4.6 Specification", table 8.19): with s to the right and t down, each −1..1, a texel of each face looks along
//!
//! ```text
//! +X (1, −t, −s)   −X (−1, −t, s)   +Y (s, 1, t)   −Y (s, −1, −t)   +Z (s, −t, 1)   −Z (−s, −t, −1)
//! ```
//!
//! Directions are the house's (right-handed, +Y up): a shader that looks the cube up with a world direction of a glTF
//! scene gets the light from there. Seen as pictures the faces are therefore mirrored, which is the convention's doing.

use crate::sh::Sh9;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use rayon::prelude::*;

/// Names of the faces in their order, as files call them.
pub const FACES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];

/// A cube map.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    size: u32,
    /// Faces one after another, rows from the top, for each mip from the largest.
    mips: Vec<Vec<Spectrum>>,
}

/// The direction, not normalised, of a point of a face; `s` and `t` in −1..1.
#[inline(always)]
pub fn face_direction(face: usize, s: f32, t: f32) -> Vec3A {
    match face {
        0 => vec3a(1.0, -t, -s),
        1 => vec3a(-1.0, -t, s),
        2 => vec3a(s, 1.0, t),
        3 => vec3a(s, -1.0, -t),
        4 => vec3a(s, -t, 1.0),
        _ => vec3a(-s, -t, -1.0),
    }
}

/// The face that a direction (any length) meets, and where: the inverse of [`face_direction`].
#[inline(always)]
pub fn face_of(d: Vec3A) -> (usize, f32, f32) {
    let a = d.abs();
    if a.x >= a.y && a.x >= a.z {
        let r = 1.0 / a.x;
        if d.x > 0.0 { (0, -d.z * r, -d.y * r) } else { (1, d.z * r, -d.y * r) }
    } else if a.y >= a.z {
        let r = 1.0 / a.y;
        if d.y > 0.0 { (2, d.x * r, d.z * r) } else { (3, d.x * r, -d.z * r) }
    } else {
        let r = 1.0 / a.z;
        if d.z > 0.0 { (4, d.x * r, -d.y * r) } else { (5, -d.x * r, -d.y * r) }
    }
}

/// The coordinate −1..1 of the middle of texel `i` of `n`.
#[inline(always)]
pub fn texel_centre(i: u32, n: u32) -> f32 {
    (2.0 * i as f32 + 1.0) / n as f32 - 1.0
}

/// The solid angle of texel (`x`, `y`) of a face of `n`² texels, steradians; all 6n² add up to 4π.
///
/// The quadrant from a face's middle to (s, t) has the solid angle atan(st / √(s² + t² + 1)); a texel is four of them.
pub fn texel_solid_angle(x: u32, y: u32, n: u32) -> f64 {
    let edge = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let quadrant = |s: f64, t: f64| (s * t).atan2((s * s + t * t + 1.0).sqrt());
    let (s0, s1, t0, t1) = (edge(x), edge(x + 1), edge(y), edge(y + 1));
    quadrant(s1, t1) - quadrant(s0, t1) - quadrant(s1, t0) + quadrant(s0, t0)
}

impl CubeMap {
    /// A cube without mips from its texels: faces one after another, rows from the top. `None` if there are not 6 `size`².
    pub fn new(size: u32, texels: Vec<Spectrum>) -> Option<Self> {
        let n = size as usize;
        (size > 0 && texels.len() == 6 * n * n).then(|| Self { size, mips: vec![texels] })
    }

    /// A cube without mips whose texels are `f` of their middles' unit directions; in parallel.
    pub fn from_fn(size: u32, f: impl Fn(Vec3A) -> Spectrum + Sync) -> Self {
        let size = size.max(1);
        Self { size, mips: vec![face_texels(size, f)] }
    }

    /// Texels along an edge of the largest mip.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Mips that there are, at least 1.
    pub fn mip_count(&self) -> usize {
        self.mips.len()
    }

    /// Texels along an edge of a mip: size / 2^mip, 1 at least.
    pub fn mip_size(&self, mip: usize) -> u32 {
        (self.size >> mip).max(1)
    }

    /// Texels of a mip: faces one after another, rows from the top.
    pub fn mip(&self, mip: usize) -> &[Spectrum] {
        &self.mips[mip]
    }

    /// Texels of one face of a mip.
    pub fn face(&self, mip: usize, face: usize) -> &[Spectrum] {
        let n = self.mip_size(mip) as usize;
        &self.mips[mip][face * n * n..(face + 1) * n * n]
    }

    /// Appends the next mip; `false`, and nothing done, if it has not the texels that belong there.
    pub fn push_mip(&mut self, texels: Vec<Spectrum>) -> bool {
        let n = self.mip_size(self.mips.len()) as usize;
        let fits = texels.len() == 6 * n * n;
        if fits {
            self.mips.push(texels);
        }
        fits
    }

    /// The chain of mips down to one texel per face, each texel the mean of the four below it weighted by their solid angles:
    /// light is neither lost nor made.
    pub fn with_mips(mut self) -> Self {
        self.mips.truncate(1);
        let mut fine = self.size;
        while fine > 1 && fine.is_multiple_of(2) {
            let n = fine / 2;
            let (w, below) = (weights(fine), &self.mips[self.mips.len() - 1]);
            let at = |face: u32, x: u32, y: u32| ((face * fine + y) * fine + x) as usize;
            let texels = (0..6 * n * n)
                .into_par_iter()
                .map(|i| {
                    let (face, y, x) = (i / (n * n), i / n % n, i % n);
                    let (mut sum, mut total) = (Spectrum::ZERO, 0.0);
                    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        let (x, y) = (2 * x + dx, 2 * y + dy);
                        let weight = w[(y * fine + x) as usize];
                        sum += below[at(face, x, y)] * weight;
                        total += weight;
                    }
                    sum / total
                })
                .collect();
            self.mips.push(texels);
            fine = n;
        }
        self
    }

    /// The largest mip's radiance as harmonics: each texel's radiance times its solid angle times the harmonics in its middle, which differ from their
    /// means over the texel by terms of the order of 1/size².
    pub fn project(&self) -> Sh9 {
        let n = self.size;
        let weights: Vec<f64> = (0..n * n).map(|i| texel_solid_angle(i % n, i / n, n)).collect();
        Sh9::from_samples(self.mips[0].iter().enumerate().map(|(i, l)| {
            let (face, i) = ((i as u32 / (n * n)) as usize, i as u32 % (n * n));
            let d = face_direction(face, texel_centre(i % n, n), texel_centre(i / n, n)).normalize();
            (d.into(), *l, weights[i as usize])
        }))
    }

    /// The mean of a mip over the sphere, by exact solid angles: radiance in, radiance out.
    pub fn mean(&self, mip: usize) -> Spectrum {
        let n = self.mip_size(mip);
        let mut sum = [0.0f64; 4];
        for (i, l) in self.mips[mip].iter().enumerate() {
            let i = i as u32 % (n * n);
            let w = texel_solid_angle(i % n, i / n, n) / (4.0 * std::f64::consts::PI);
            (0..4).for_each(|c| sum[c] += w * f64::from(l[c]));
        }
        Spectrum(sum.map(|v| v as f32))
    }
}

/// `f` of the unit direction of each texel of six faces of `n`².
pub(crate) fn face_texels(n: u32, f: impl Fn(Vec3A) -> Spectrum + Sync) -> Vec<Spectrum> {
    (0..6 * n)
        .into_par_iter()
        .flat_map_iter(|row| {
            let f = &f;
            let (face, y) = ((row / n) as usize, row % n);
            (0..n).map(move |x| f(face_direction(face, texel_centre(x, n), texel_centre(y, n)).normalize()))
        })
        .collect()
}

/// Solid angles of a face's texels, row by row.
fn weights(n: u32) -> Vec<f32> {
    (0..n * n).map(|i| texel_solid_angle(i % n, i / n, n) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;

    #[test]
    fn faces_and_directions_are_inverse() {
        let mut rng = Rng::new(2);
        for face in 0..6 {
            for _ in 0..200 {
                let (s, t) = (1.98 * rng.uniform() - 0.99, 1.98 * rng.uniform() - 0.99);
                let (f, s2, t2) = face_of(face_direction(face, s, t) * (0.1 + rng.uniform()));
                assert_eq!(f, face);
                assert!((s - s2).abs() < 1e-6 && (t - t2).abs() < 1e-6);
            }
        }
    }

    /// OpenGL 4.6, table 8.19: major axis, sc, tc.
    #[test]
    fn faces_are_those_of_the_standard() {
        type Row = (Vec3A, fn(Vec3A) -> [f32; 2]);
        let rows: [Row; 6] = [
            (Vec3A::X, |r| [-r.z, -r.y]),
            (Vec3A::NEG_X, |r| [r.z, -r.y]),
            (Vec3A::Y, |r| [r.x, r.z]),
            (Vec3A::NEG_Y, |r| [r.x, -r.z]),
            (Vec3A::Z, |r| [r.x, -r.y]),
            (Vec3A::NEG_Z, |r| [-r.x, -r.y]),
        ];
        for (face, (axis, table)) in rows.iter().enumerate() {
            let r = *axis + vec3a(0.3, 0.2, -0.1) * (Vec3A::ONE - axis.abs());
            let [s, t] = table(r);
            assert_eq!(face_of(r), (face, s, t));
        }
    }

    #[test]
    fn solid_angles_fill_the_sphere() {
        for n in [1, 2, 7, 64] {
            let sum: f64 = (0..n * n).map(|i| texel_solid_angle(i % n, i / n, n)).sum();
            assert!((6.0 * sum - 4.0 * std::f64::consts::PI).abs() < 1e-11, "{n}: {sum}");
        }
        assert!(texel_solid_angle(0, 0, 64) < 0.3 * texel_solid_angle(32, 32, 64));
    }

    #[test]
    fn mips_keep_the_light() {
        let cube = CubeMap::from_fn(32, |d| {
            let sun = if d.dot(vec3a(0.6, 0.64, 0.48)) > 0.99 { 500.0 } else { 0.0 };
            Spectrum::rgb(1.0 + d.x, sun, d.y.abs())
        })
        .with_mips();
        assert_eq!(cube.mip_count(), 6);
        let want = cube.mean(0);
        for mip in 1..6 {
            let got = cube.mean(mip);
            for c in 0..3 {
                assert!((got[c] / want[c] - 1.0).abs() < 1e-5, "mip {mip}: {got:?} {want:?}");
            }
        }
    }
}
