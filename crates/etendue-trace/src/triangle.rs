//! Eight triangles against one ray: the watertight test of Woop, Benthin and Wald (2013).
//!
//! Vertices are moved by the ray's origin and sheared so that the ray is the +z axis; the signs of three 2-D edge
//! functions then decide. Two triangles that share an edge see the same two sheared vertices, so their edge
//! functions are exact negatives of each other. In `f32` a sign can collapse to zero but never turn, so only zeros
//! are looked at again, in `f64`, where products of `f32` are exact.

use crate::lanes::{F32x8, Lanes};
use crate::ray::Prepared;

/// Marks, in [`Packet::instance`], a triangle whose material has alpha.
pub(crate) const ALPHA: u32 = 1 << 31;

/// Up to eight triangles, component by component. Unused lanes hold NaN, which no test accepts.
#[repr(C, align(64))]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Packet {
    /// By vertex, then axis.
    pub vertices: [[F32x8; 3]; 3],
    pub triangle: [u32; 8],
    /// Instance, with [`ALPHA`] where the material has it.
    pub instance: [u32; 8],
    /// Fills the last cache line.
    unused: [u32; 8],
}

impl Packet {
    pub fn empty() -> Self {
        Self {
            vertices: [[F32x8([f32::NAN; 8]); 3]; 3],
            triangle: [!0; 8],
            instance: [!ALPHA; 8],
            unused: [0; 8],
        }
    }

    pub fn set(&mut self, lane: usize, vertices: [[f32; 3]; 3], instance: u32, triangle: u32) {
        for (to, from) in self.vertices.iter_mut().zip(vertices) {
            for (to, from) in to.iter_mut().zip(from) {
                to.0[lane] = from;
            }
        }
        self.triangle[lane] = triangle;
        self.instance[lane] = instance;
    }

    /// One vertex of each triangle in the frame where the ray is the z axis; z is not yet scaled to `t`.
    #[inline(always)]
    fn shear<S: Lanes>(&self, vertex: usize, ray: &Prepared, origin: [S; 3], sx: S, sy: S) -> (S, S, S) {
        let p = &self.vertices[vertex];
        let z = S::load(&p[ray.kz]).sub(origin[2]);
        let x = S::load(&p[ray.kx]).sub(origin[0]).sub(sx.mul(z));
        let y = S::load(&p[ray.ky]).sub(origin[1]).sub(sy.mul(z));
        (x, y, z)
    }

    /// The triangles that the ray may meet with `t_min < t ≤ t_max`: [`Candidates::next`] gives the hits.
    #[inline(always)]
    pub fn intersect<S: Lanes>(&self, ray: &Prepared, t_max: f32) -> Option<Candidates> {
        // Spelled out: `array::map` is not inlined here, and outside it there is no AVX2.
        let at = |k: usize| S::splat(ray.origin[k]);
        let origin = [at(ray.kx), at(ray.ky), at(ray.kz)];
        let (sx, sy) = (S::splat(ray.sx), S::splat(ray.sy));
        let (ax, ay, az) = self.shear(0, ray, origin, sx, sy);
        let (bx, by, bz) = self.shear(1, ray, origin, sx, sy);
        let (cx, cy, cz) = self.shear(2, ray, origin, sx, sy);
        let u = cx.mul(by).sub(cy.mul(bx));
        let v = ax.mul(cy).sub(ay.mul(cx));
        let w = bx.mul(ay).sub(by.mul(ax));
        let zero = S::splat(0.0);
        let inside = zero.le(u.min(v).min(w)).or(u.max(v).max(w).le(zero));
        if inside.signs() == 0 {
            return None;
        }

        let det = u.add(v).add(w);
        let t = u.mul(az).add(v.mul(bz)).add(w.mul(cz)).mul(S::splat(ray.sz)).div(det);
        // The edge functions' rounding errors, at most 2 units of `extent²` each, spread the distance by at most
        // 6 units · extent² · depth / |det| along z. Where that is too much (slivers, grazing rays), or a sign is
        // unsure, the lane is done again in `f64`.
        let extent_x = ax.abs().max(bx.abs()).max(cx.abs());
        let extent_y = ay.abs().max(by.abs()).max(cy.abs());
        let extent = extent_x.max(extent_y);
        let depth = az.max(bz).max(cz).sub(az.min(bz).min(cz));
        let error = extent.mul(extent).mul(depth).mul(S::splat(6.0 / (1u32 << 24) as f32));
        let trusted = error.lt(det.abs().mul(S::splat(ray.tolerance)));
        let nonzero = zero.lt(u.abs().min(v.abs()).min(w.abs()));
        let sure = trusted.and(nonzero).signs();
        let within = S::splat(ray.t_min).lt(t).and(t.le(S::splat(t_max)));
        let lanes = inside.signs() & (within.signs() | !sure);
        if lanes == 0 {
            return None;
        }
        Some(Candidates { lanes, sure, t: t.store(), det: det.store(), v: v.store(), w: w.store() })
    }

    /// One lane with edge functions in `f64`: their signs are exact for the sheared `f32` vertices.
    #[cold]
    #[inline(never)]
    fn intersect_exact(&self, lane: usize, ray: &Prepared) -> Option<(f32, f32, f32)> {
        let shear = |v: usize| {
            let component = |k: usize| self.vertices[v][k].0[lane] - ray.origin[k];
            let z = component(ray.kz);
            let x = component(ray.kx) - ray.sx * z;
            let y = component(ray.ky) - ray.sy * z;
            (x as f64, y as f64, z as f64)
        };
        let (ax, ay, az) = shear(0);
        let (bx, by, bz) = shear(1);
        let (cx, cy, cz) = shear(2);
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let t = (u * az + v * bz + w * cz) / det * ray.sz as f64;
        Some((t as f32, (v / det) as f32, (w / det) as f32))
    }
}

/// What is left of a packet after the test of all lanes at once.
pub(crate) struct Candidates {
    lanes: u32,
    /// Lanes whose `f32` result stands.
    sure: u32,
    t: F32x8,
    det: F32x8,
    v: F32x8,
    w: F32x8,
}

impl Candidates {
    /// The next hit with `t_min < t ≤ t_max`: lane, t, u, v.
    #[inline(always)]
    pub fn next(&mut self, packet: &Packet, ray: &Prepared, t_max: f32) -> Option<(usize, f32, f32, f32)> {
        while self.lanes != 0 {
            let lane = self.lanes.trailing_zeros() as usize & 7;
            self.lanes &= self.lanes - 1;
            let (t, u, v) = if self.sure >> lane & 1 != 0 {
                let det = self.det.0[lane];
                (self.t.0[lane], self.v.0[lane] / det, self.w.0[lane] / det)
            } else {
                match packet.intersect_exact(lane, ray) {
                    Some(hit) => hit,
                    None => continue,
                }
            };
            if t > ray.t_min && t <= t_max {
                return Some((lane, t, u, v));
            }
        }
        None
    }
}
