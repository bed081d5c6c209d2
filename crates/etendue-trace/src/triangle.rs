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
#[derive(Clone)]
pub(crate) struct Packet {
    /// By vertex, then axis.
    pub vertices: [[F32x8; 3]; 3],
    pub triangle: [u32; 8],
    /// Instance, with [`ALPHA`] where the material has it.
    pub instance: [u32; 8],
}

impl Packet {
    pub fn empty() -> Self {
        Self { vertices: [[F32x8([f32::NAN; 8]); 3]; 3], triangle: [!0; 8], instance: [!ALPHA; 8] }
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

    /// Calls `found(lane, t, u, v)` for each triangle that the ray meets with `t_min < t ≤ t_max`, lowest lane first,
    /// until it returns true.
    #[inline(always)]
    pub fn intersect<S: Lanes>(
        &self,
        ray: &Prepared,
        t_max: f32,
        mut found: impl FnMut(usize, f32, f32, f32) -> bool,
    ) {
        let shear = |v: usize| {
            let p = &self.vertices[v];
            let component = |k: usize| S::load(&p[k]).sub(S::splat(ray.origin[k]));
            let z = component(ray.kz);
            let x = component(ray.kx).sub(S::splat(ray.sx).mul(z));
            let y = component(ray.ky).sub(S::splat(ray.sy).mul(z));
            (x, y, z)
        };
        let (ax, ay, az) = shear(0);
        let (bx, by, bz) = shear(1);
        let (cx, cy, cz) = shear(2);
        let u = cx.mul(by).sub(cy.mul(bx));
        let v = ax.mul(cy).sub(ay.mul(cx));
        let w = bx.mul(ay).sub(by.mul(ax));
        let zero = S::splat(0.0);
        let inside = zero.le(u.min(v).min(w)).or(u.max(v).max(w).le(zero));
        if inside.signs() == 0 {
            return;
        }

        let det = u.add(v).add(w);
        let t = u.mul(az).add(v.mul(bz)).add(w.mul(cz)).mul(S::splat(ray.sz)).div(det);
        // The edge functions' rounding errors, at most 2 units of `extent²` each, spread the distance by at most
        // 6 units · extent² · depth / |det| along z. Where that is too much (slivers, grazing rays), or a sign is
        // unsure, the lane is done again in `f64`.
        let extent = |a: S, b: S, c: S| a.abs().max(b.abs()).max(c.abs());
        let extent = extent(ax, ay, bx).max(extent(by, cx, cy));
        let depth = az.max(bz).max(cz).sub(az.min(bz).min(cz));
        let error = extent.mul(extent).mul(depth).mul(S::splat(6.0 / (1u32 << 24) as f32));
        let trusted = error.lt(det.abs().mul(S::splat(ray.tolerance)));
        let nonzero = zero.lt(u.abs().min(v.abs()).min(w.abs()));
        let sure = trusted.and(nonzero).signs();
        let within = S::splat(ray.t_min).lt(t).and(t.le(S::splat(t_max)));
        let mut lanes = inside.signs() & (within.signs() | !sure);
        if lanes == 0 {
            return;
        }
        let (t, det, v, w) = (t.store().0, det.store().0, v.store().0, w.store().0);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let done = if sure >> lane & 1 != 0 {
                found(lane, t[lane], v[lane] / det[lane], w[lane] / det[lane])
            } else {
                match self.intersect_exact(lane, ray) {
                    Some((t, u, v)) if t > ray.t_min && t <= t_max => found(lane, t, u, v),
                    _ => false,
                }
            };
            if done {
                return;
            }
        }
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
