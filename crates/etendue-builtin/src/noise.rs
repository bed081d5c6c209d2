//! Noise that is the same on every machine: integer hashes and arithmetic, no table, no generator state.

use glam::{IVec3, Vec3};

/// A well-mixed 32-bit hash of one word (the finaliser with constants found by search: Wellons, "hash-prospector", 2018).
pub fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A hash of a lattice point and a salt.
pub fn hash3(c: IVec3, salt: u32) -> u32 {
    hash(c.x as u32 ^ hash(c.y as u32 ^ hash(c.z as u32 ^ hash(salt))))
}

/// The upper 24 bits of a hash as a number in [0, 1).
pub fn unit(h: u32) -> f32 {
    (h >> 8) as f32 / 16_777_216.0
}

/// 0 below `a`, 1 above `b`, the cubic 3t² − 2t³ between; works for `a > b` too.
pub fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Linear interpolation.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Gradient noise (Perlin 2002, with the quintic fade), about −1..1, one feature per unit length.
pub fn perlin(p: Vec3, salt: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let c = cell.as_ivec3();
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |dx: i32, dy: i32, dz: i32| {
        let h = hash3(c + IVec3::new(dx, dy, dz), salt);
        let d = f - Vec3::new(dx as f32, dy as f32, dz as f32);
        // The gradient: a point of the cube, close enough to isotropic for paint.
        let g = Vec3::new(
            (h & 1023) as f32 / 511.5 - 1.0,
            ((h >> 10) & 1023) as f32 / 511.5 - 1.0,
            ((h >> 20) & 1023) as f32 / 511.5 - 1.0,
        );
        g.dot(d)
    };
    let x00 = mix(corner(0, 0, 0), corner(1, 0, 0), w.x);
    let x10 = mix(corner(0, 1, 0), corner(1, 1, 0), w.x);
    let x01 = mix(corner(0, 0, 1), corner(1, 0, 1), w.x);
    let x11 = mix(corner(0, 1, 1), corner(1, 1, 1), w.x);
    mix(mix(x00, x10, w.y), mix(x01, x11, w.y), w.z) * 1.4
}

/// `octaves` layers of [`perlin`], each twice as fine and half as strong; about −1..1.
pub fn fbm(mut p: Vec3, octaves: u32, salt: u32) -> f32 {
    let (mut sum, mut amplitude, mut total) = (0.0, 1.0, 0.0);
    for i in 0..octaves {
        sum += amplitude * perlin(p, salt.wrapping_add(i * 101));
        total += amplitude;
        amplitude *= 0.5;
        p = p * 2.03 + Vec3::splat(7.31);
    }
    sum / total
}

/// Distances to the nearest and second nearest of one random point per cell (Worley 1996), and the nearest one's hash.
pub fn worley(p: Vec3, salt: u32) -> (f32, f32, u32) {
    let c = p.floor().as_ivec3();
    let (mut d1, mut d2, mut id) = (f32::MAX, f32::MAX, 0);
    for z in -1..=1 {
        for y in -1..=1 {
            for x in -1..=1 {
                let k = c + IVec3::new(x, y, z);
                let h = hash3(k, salt);
                let q = k.as_vec3()
                    + Vec3::new(unit(h), unit(hash(h ^ 0x9e37_79b9)), unit(hash(h ^ 0x85eb_ca6b)));
                let d = q.distance(p);
                if d < d1 {
                    (d2, d1, id) = (d1, d, h);
                } else if d < d2 {
                    d2 = d;
                }
            }
        }
    }
    (d1, d2, id)
}
