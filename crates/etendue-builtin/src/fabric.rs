//! Tiles of cloth: the strap's webbing and the lining's quilt. Both repeat without a seam.

use crate::bake::{Atlas, Maps, Paint, Texel, paint};
use crate::noise::{hash, smoothstep, unit};
use glam::{Vec3, Vec4};
use std::f32::consts::{PI, TAU};

/// Noise per thread: a number 0..1 for a lattice point that repeats every `n`.
fn thread(x: i32, y: i32, n: i32) -> f32 {
    unit(hash(x.rem_euclid(n) as u32 ^ hash(y.rem_euclid(n) as u32 ^ 77)))
}

/// A flat atlas of `size` texels a side that shows a square of `metres`.
fn tile(size: usize, metres: f32) -> Atlas {
    let mut a = Atlas::new(size, size);
    let step = metres / size as f32;
    for (i, t) in a.texels.iter_mut().enumerate() {
        let (x, y) = ((i % size) as f32 + 0.5, (i / size) as f32 + 0.5);
        *t = Texel {
            pos: Vec3::new(x / size as f32, y / size as f32, 0.0),
            nrm: Vec3::Z,
            right: Vec3::X * step,
            up: Vec3::Y * step,
            tangent: Vec4::new(1.0, 0.0, 0.0, 1.0),
            aux: Vec3::ZERO,
            part: 1,
            open: 1.0,
            ridge: 0.0,
        };
    }
    a
}

/// Webbing: a twill of flat threads along and across, edges rolled, a coloured track in the middle.
pub fn webbing() -> Maps {
    let n = 16;
    let mut atlas = tile(256, 0.020);
    let weave = |p: Vec3| {
        let (u, v) = (p.x * n as f32, p.y * n as f32);
        let (i, j) = (u.floor() as i32, v.floor() as i32);
        // Two over, two under, shifted by one from row to row.
        let phase = (i + j).rem_euclid(4);
        let warp_on_top = phase < 2;
        let (fu, fv) = (u - u.floor(), v - v.floor());
        let round = |x: f32| (PI * x).sin().max(0.0).sqrt();
        let along = if warp_on_top { (fu + phase as f32) * 0.5 } else { (fv + (phase - 2) as f32) * 0.5 };
        let across = if warp_on_top { fv } else { fu };
        let h = round(across) * (0.55 + 0.45 * (PI * along.fract()).sin());
        (h, warp_on_top, thread(if warp_on_top { 0 } else { i }, if warp_on_top { j } else { 99 }, n))
    };
    for t in &mut atlas.texels {
        t.open = 0.45 + 0.55 * weave(t.pos).0;
    }
    paint(&atlas, Vec3::ZERO, |t| {
        let (h, warp, shade) = weave(t.pos);
        let edge = (t.pos.y - 0.5).abs();
        let track = smoothstep(0.20, 0.18, edge) * smoothstep(0.10, 0.12, edge);
        let base = Vec3::new(0.055, 0.057, 0.052).lerp(Vec3::new(0.50, 0.060, 0.018), track);
        let fray = if warp { 1.0 } else { 0.86 };
        Paint {
            base: base * (0.55 + 0.45 * h) * fray * (0.85 + 0.3 * shade),
            metallic: 0.0,
            roughness: 0.82 - 0.10 * h,
            height: 2.2e-4 * h - 3.0e-4 * smoothstep(0.455, 0.49, edge),
            emissive: Vec3::ZERO,
        }
    })
}

/// The lining's quilt: diamonds of padding, stitched.
pub fn quilt() -> Maps {
    let mut atlas = tile(256, 0.045);
    let pad = |p: Vec3| {
        let (a, b) = ((p.x + p.y) * 2.0, (p.x - p.y) * 2.0);
        let seam = |x: f32| (x - x.round()).abs();
        (seam(a), seam(b))
    };
    let height = |p: Vec3| {
        let (a, b) = pad(p);
        (a * b).sqrt().min(0.5) * 2.0
    };
    for t in &mut atlas.texels {
        t.open = 0.35 + 0.65 * smoothstep(0.0, 0.6, height(t.pos));
    }
    paint(&atlas, Vec3::ZERO, |t| {
        let h = height(t.pos);
        let knit = 0.5 + 0.25 * ((t.pos.x * 64.0 * TAU).sin() + (t.pos.y * 64.0 * TAU).sin());
        let (a, b) = pad(t.pos);
        let stitch = smoothstep(0.035, 0.02, a.min(b));
        let dash = if ((t.pos.x - t.pos.y) * 16.0).rem_euclid(1.0) < 0.6 { stitch } else { 0.0 };
        let base = Vec3::new(0.30, 0.215, 0.14) * (0.75 + 0.4 * knit);
        Paint {
            base: base.lerp(Vec3::new(0.55, 0.10, 0.03), 0.8 * dash),
            metallic: 0.0,
            roughness: 0.9,
            height: 2.2e-3 * h + 1.0e-4 * knit,
            emissive: Vec3::ZERO,
        }
    })
}
