//! Cube maps looked up without seams.

use crate::cube::{CubeMap, face_direction, face_of, texel_centre};
use etendue_color::Spectrum;
use glam::Vec3A;
use rayon::prelude::*;

/// A cube map with a border around each face, ready for bilinear and trilinear lookup.
///
/// The border holds the neighbouring faces' texels, so that a lookup near an edge takes two from each side, and gives
/// the same on both. At a corner, where three faces meet, the missing fourth texel is the mean of the three. This is what
/// graphics processors do (`GL_TEXTURE_CUBE_MAP_SEAMLESS`, Vulkan's cube map edge handling).
#[derive(Clone, Debug)]
pub struct CubeLookup {
    /// Per mip: texels along an edge, and faces of (n + 2)² texels.
    mips: Vec<(u32, Vec<Spectrum>)>,
}

impl CubeLookup {
    /// Prepares all mips of `cube`.
    pub fn new(cube: &CubeMap) -> Self {
        let mips = (0..cube.mip_count())
            .into_par_iter()
            .map(|mip| (cube.mip_size(mip), with_border(cube.mip(mip), cube.mip_size(mip))))
            .collect();
        Self { mips }
    }

    /// Mips that there are.
    pub fn mip_count(&self) -> usize {
        self.mips.len()
    }

    /// Texels along an edge of the largest mip.
    pub fn size(&self) -> u32 {
        self.mips[0].0
    }

    /// Bilinear within one mip, from direction `d` (any length but 0); a mip beyond the last is the last.
    #[inline]
    pub fn bilinear(&self, d: Vec3A, mip: usize) -> Spectrum {
        let (face, s, t) = face_of(d);
        self.at(face, s, t, mip.min(self.mips.len() - 1))
    }

    /// Trilinear, at a level of detail clamped to the mips that there are; NaN is the largest mip.
    #[inline(always)]
    pub fn trilinear(&self, d: Vec3A, lod: f32) -> Spectrum {
        let (face, s, t) = face_of(d);
        let lod = lod.max(0.0).min((self.mips.len() - 1) as f32);
        let mip = lod as usize;
        let fraction = lod - mip as f32;
        let fine = self.at(face, s, t, mip);
        if fraction == 0.0 {
            return fine;
        }
        fine.lerp(self.at(face, s, t, mip + 1), fraction)
    }

    #[inline(always)]
    fn at(&self, face: usize, s: f32, t: f32, mip: usize) -> Spectrum {
        let (n, texels) = &self.mips[mip];
        let (half, stride) = (*n as f32 * 0.5, *n as usize + 2);
        // In texels of the bordered face, whose middles lie at whole numbers: −1 → ½, 1 → n + ½. Both are above 0, so that
        // truncation is the floor.
        let (x, y) = ((s + 1.0) * half + 0.5, (t + 1.0) * half + 0.5);
        let (ix, iy) = ((x as usize).min(*n as usize), (y as usize).min(*n as usize));
        let (fx, fy) = (x - ix as f32, y - iy as f32);
        let i = (face * stride + iy) * stride + ix;
        let (top, bottom) = (&texels[i..i + 2], &texels[i + stride..i + stride + 2]);
        let a = top[0] + (top[1] - top[0]) * fx;
        let b = bottom[0] + (bottom[1] - bottom[0]) * fx;
        a + (b - a) * fy
    }
}

fn with_border(texels: &[Spectrum], n: u32) -> Vec<Spectrum> {
    let (m, stride) = (n as usize, n as usize + 2);
    let texel = |face: usize, x: usize, y: usize| texels[(face * m + y) * m + x];
    // The neighbour's texel that touches the edge: a direction a little beyond it finds face and texel.
    let beyond = |face: usize, s: f32, t: f32| {
        let (f, s, t) = face_of(face_direction(face, s, t));
        let index = |c: f32| (((c + 1.0) * 0.5 * n as f32).max(0.0) as usize).min(m - 1);
        texel(f, index(s), index(t))
    };
    let out = 1.0 + 0.25 / n as f32;
    let mut all = vec![Spectrum::ZERO; 6 * stride * stride];
    for face in 0..6 {
        let at = |x: usize, y: usize| (face * stride + y) * stride + x;
        for y in 0..m {
            for x in 0..m {
                all[at(x + 1, y + 1)] = texel(face, x, y);
            }
            let c = texel_centre(y as u32, n);
            all[at(0, y + 1)] = beyond(face, -out, c);
            all[at(m + 1, y + 1)] = beyond(face, out, c);
            all[at(y + 1, 0)] = beyond(face, c, -out);
            all[at(y + 1, m + 1)] = beyond(face, c, out);
        }
        for (x, y, ix, iy) in [(0, 0, 1, 1), (m + 1, 0, m, 1), (0, m + 1, 1, m), (m + 1, m + 1, m, m)] {
            all[at(x, y)] = (all[at(ix, iy)] + all[at(x, iy)] + all[at(ix, y)]) / 3.0;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_bxdf::laws::Rng;
    use glam::vec3a;

    /// A cube of random texels: no accident makes neighbours agree.
    fn noise(n: u32) -> CubeLookup {
        let mut rng = Rng::new(9);
        let texels = (0..6 * n * n).map(|_| Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform()));
        CubeLookup::new(&CubeMap::new(n, texels.collect()).unwrap().with_mips())
    }

    #[test]
    fn no_seams() {
        let cube = noise(8);
        let mut rng = Rng::new(4);
        for mip in 0..cube.mip_count() {
            for _ in 0..400 {
                // A point of an edge: two coordinates of equal size, approached from both faces; now and then a corner.
                let a = if rng.uniform() < 0.2 { 1.0 } else { 2.0 * rng.uniform() - 1.0 };
                let sign = |u: f32| if u < 0.5 { -1.0 } else { 1.0 };
                let (p, q) = (sign(rng.uniform()), sign(rng.uniform()));
                let e = 1e-5;
                let (u, v) = match (rng.uniform() * 3.0) as u32 {
                    0 => (vec3a(p * (1.0 + e), q, a), vec3a(p, q * (1.0 + e), a)),
                    1 => (vec3a(p * (1.0 + e), a, q), vec3a(p, a, q * (1.0 + e))),
                    _ => (vec3a(a, p * (1.0 + e), q), vec3a(a, p, q * (1.0 + e))),
                };
                assert_ne!(face_of(u).0, face_of(v).0);
                let d = cube.bilinear(u, mip) - cube.bilinear(v, mip);
                assert!(d.map(f32::abs).max_element() < 5e-4, "mip {mip} at {u}: {d:?}");
            }
        }
    }

    #[test]
    fn texel_centres_give_their_texels() {
        let mut rng = Rng::new(9);
        let texels: Vec<_> = (0..6 * 16).map(|_| Spectrum::splat(rng.uniform())).collect();
        let cube = CubeLookup::new(&CubeMap::new(4, texels.clone()).unwrap());
        for i in 0..96u32 {
            let (face, y, x) = (i / 16, i / 4 % 4, i % 4);
            let d = face_direction(face as usize, texel_centre(x, 4), texel_centre(y, 4));
            let got = cube.bilinear(d.normalize(), 0);
            assert!((got[0] - texels[i as usize][0]).abs() < 1e-5);
        }
    }

    #[test]
    fn levels_are_joined() {
        let cube = noise(8);
        let d = vec3a(0.3, -0.9, 0.2);
        let (a, b) = (cube.bilinear(d, 1), cube.bilinear(d, 2));
        assert!((cube.trilinear(d, 1.25) - a.lerp(b, 0.25)).map(f32::abs).max_element() < 1e-6);
        assert_eq!(cube.trilinear(d, 99.0), cube.bilinear(d, 3));
        assert_eq!(cube.trilinear(d, f32::NAN), cube.bilinear(d, 0));
        for bad in [Vec3A::ZERO, Vec3A::NAN, Vec3A::INFINITY] {
            // No direction at all: any value, but no panic.
            let _ = cube.trilinear(bad, 0.5);
        }
    }
}
