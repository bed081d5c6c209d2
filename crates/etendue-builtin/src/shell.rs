//! The painted shell: a grid around each ear, cut at the visor's and the neck's opening.

use crate::form::{CREST, above_neck, normal, on_shell, shell, visor_extent};
use crate::shape::{Mesh, Rect};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_2, TAU};

/// The relative part of a half's square that its disc fills: leaves a border for filtering.
const FILL: f32 = 0.985;

/// Steps around an ear.
const AROUND: u32 = 112;

/// A vertex before the cut: the angle from the ear's axis and the angle around it.
#[derive(Clone, Copy)]
struct Polar {
    theta: f32,
    psi: f32,
}

/// One half of the shell. `side` is +1 for the wearer's left (+X), −1 for the right.
struct Half {
    side: f32,
    rect: Rect,
}

impl Half {
    /// The direction; on the seam x is exactly 0, so that both halves share their edge.
    fn direction(&self, q: Polar) -> Vec3 {
        let (s, c) = q.theta.sin_cos();
        let (sp, cp) = q.psi.sin_cos();
        let x = if q.theta >= FRAC_PI_2 { 0.0 } else { c * self.side };
        // Seen from outside, psi runs counter-clockwise: the image's right is −Z on the left half, +Z on the right one.
        Vec3::new(x, s * sp, -s * cp * self.side).normalize()
    }

    /// Azimuthal equidistant projection around the ear's axis, as seen from outside.
    fn uv(&self, q: Polar) -> Vec2 {
        let r = 0.5 * FILL * q.theta / FRAC_PI_2;
        self.rect.at(Vec2::new(0.5 + r * q.psi.cos(), 0.5 - r * q.psi.sin()))
    }
}

/// Positive where the shell stays. The cut lies under the visor's frame and the neck's ring.
fn keep(d: Vec3) -> f32 {
    (visor_extent(d) - 1.02).min(above_neck(on_shell(d)) * 8.0)
}

/// The shell's mesh; its texture is twice as wide as high, the left half on the left.
pub fn shell_mesh() -> Mesh {
    let mut mesh = Mesh::default();
    for (side, x) in [(1.0, 0.0), (-1.0, 0.5)] {
        let rect = Rect { min: Vec2::new(x, 0.0), max: Vec2::new(x + 0.5, 1.0) };
        mesh.append(&half_mesh(&Half { side, rect }));
    }
    mesh
}

/// The rings' angles from the ear's axis: even, and closer where the crest rises.
fn rings() -> Vec<f32> {
    let (foot, top) = (CREST[1].acos(), CREST[0].acos());
    let mut out: Vec<f32> = (0..=24).map(|i| foot * (i as f32 / 24.0).max(0.004)).collect();
    out.extend((1..=6).map(|i| foot + (top - foot) * i as f32 / 6.0));
    out.extend((1..=3).map(|i| top + (FRAC_PI_2 - top) * i as f32 / 3.0));
    *out.last_mut().expect("rings") = FRAC_PI_2;
    out
}

fn half_mesh(half: &Half) -> Mesh {
    let rings = rings();
    let step = TAU / AROUND as f32;
    let mut points = Vec::new();
    for &theta in &rings {
        points.extend((0..=AROUND).map(|i| Polar { theta, psi: i as f32 * step }));
    }
    let kept: Vec<f32> = points.iter().map(|q| keep(half.direction(*q))).collect();

    let mut mesh = Mesh::default();
    let mut made: HashMap<(u32, u32), u32> = HashMap::new();
    let mut add = |mesh: &mut Mesh, key: (u32, u32), q: Polar| {
        *made.entry(key).or_insert_with(|| {
            let d = half.direction(q);
            mesh.push(on_shell(d), normal(d, shell), half.uv(q), Vec3::ZERO)
        })
    };
    // The cut of a grid edge, always from its lower to its higher index, so that neighbours agree on it.
    let cut = |a: u32, b: u32| {
        let (p, q) = (points[a as usize], points[b as usize]);
        let at =
            |t: f32| Polar { theta: p.theta + (q.theta - p.theta) * t, psi: p.psi + (q.psi - p.psi) * t };
        let (mut low, mut high) = (0.0, 1.0);
        let sign = kept[a as usize] > 0.0;
        for _ in 0..16 {
            let t = 0.5 * (low + high);
            if (keep(half.direction(at(t))) > 0.0) == sign {
                low = t;
            } else {
                high = t;
            }
        }
        at(0.5 * (low + high))
    };
    let row = AROUND + 1;
    for j in 0..rings.len() as u32 - 1 {
        for i in 0..AROUND {
            let quad = [j * row + i, (j + 1) * row + i, (j + 1) * row + i + 1, j * row + i + 1];
            let mut polygon = Vec::with_capacity(8);
            for k in 0..4 {
                let (a, b) = (quad[k], quad[(k + 1) % 4]);
                let (ka, kb) = (kept[a as usize] > 0.0, kept[b as usize] > 0.0);
                if ka {
                    polygon.push(add(&mut mesh, (a, a), points[a as usize]));
                }
                if ka != kb {
                    let (low, high) = (a.min(b), a.max(b));
                    polygon.push(add(&mut mesh, (low, high), cut(low, high)));
                }
            }
            for k in 2..polygon.len() {
                mesh.tri(polygon[0], polygon[k - 1], polygon[k]);
            }
        }
    }
    mesh
}
