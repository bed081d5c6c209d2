//! The visor's coat: gold vapour on a dark shield, darker towards the brow; fingerprints and hairlines in its gloss.

use crate::bake::{Paint, Texel};
use crate::noise::{fbm, mix, perlin, smoothstep};
use glam::{Vec2, Vec3};

const GOLD: Vec3 = Vec3::new(1.0, 0.68, 0.24);
const COPPER: Vec3 = Vec3::new(0.88, 0.44, 0.13);
const BRONZE: Vec3 = Vec3::new(0.46, 0.17, 0.055);

/// Ridges of a fingertip's print around `at` (metres in the visor's chart), 0..1.
fn print(q: Vec2, at: Vec2, turn: f32, salt: u32) -> f32 {
    let (s, c) = turn.sin_cos();
    let d = q - at;
    let p = Vec2::new(d.x * c + d.y * s, d.y * c - d.x * s);
    let oval = smoothstep(1.0, 0.6, (p / Vec2::new(0.0075, 0.0105)).length());
    if oval <= 0.0 {
        return 0.0;
    }
    let warp = 0.0016 * perlin(p.extend(0.0) * 160.0, salt);
    let whorl = (p * Vec2::new(1.0, 0.75) - Vec2::new(0.0, -0.002)).length() + warp;
    let ridges = 0.5 + 0.5 * (whorl * 9500.0).sin();
    oval * (0.35 + 0.65 * ridges) * smoothstep(-0.5, 0.3, perlin(p.extend(1.0) * 300.0, salt + 1))
}

/// Paints a place of the visor; paint coordinates are azimuth, elevation, relative extent.
pub fn visor_paint(t: &Texel) -> Paint {
    let p = t.pos;
    let (a, e, extent) = (t.aux.x, t.aux.y, t.aux.z);
    let n = fbm(p * 12.0, 3, 201);
    let up = smoothstep(-0.06, 0.40, e + 0.02 * n);
    let base = GOLD.lerp(COPPER, up).lerp(BRONZE, smoothstep(0.26, 0.56, e + 0.01 * n));
    let base = base * (1.0 - 0.10 * smoothstep(0.6, 1.2, a.abs()));

    let q = Vec2::new(a, e) * 0.15;
    let touch = print(q, Vec2::new(0.118, 0.020), 0.5, 211)
        .max(0.8 * print(q, Vec2::new(0.131, 0.006), 0.7, 221))
        .max(0.7 * print(q, Vec2::new(-0.070, -0.028), -0.6, 231));
    let smear = smoothstep(0.15, 0.7, fbm(Vec3::new(p.x * 20.0, p.y * 55.0, p.z * 20.0), 4, 241))
        * smoothstep(0.2, 0.8, fbm(p * 9.0, 2, 242));
    let mut hair = 0.0f32;
    for k in 0..2u32 {
        let turn = [Vec2::new(0.94, 0.34), Vec2::new(0.5, -0.87)][k as usize];
        let along = q.dot(turn);
        let across = q.perp_dot(turn) + 0.002 * perlin(q.extend(k as f32) * 30.0, 251);
        let line = perlin(Vec3::new(across * 900.0, along * 14.0, k as f32 * 9.0), 252 + k).abs();
        hair = hair.max(
            smoothstep(0.03, 0.0, line) * smoothstep(0.25, 0.6, perlin(q.extend(5.0 + k as f32) * 40.0, 254)),
        );
    }
    let dust = smoothstep(0.90, 1.0, extent) * smoothstep(-0.3, 0.5, fbm(p * 45.0, 2, 261));
    let mut rough = 0.045 + 0.012 * n.abs();
    rough += 0.16 * touch + 0.07 * smear + 0.10 * hair;
    rough = mix(rough, 0.4, 0.3 * dust);
    Paint {
        base: base * (1.0 - 0.25 * dust - 0.05 * touch),
        metallic: 1.0 - 0.2 * dust,
        roughness: rough.clamp(0.03, 0.8),
        height: 0.0,
        emissive: Vec3::ZERO,
    }
}
