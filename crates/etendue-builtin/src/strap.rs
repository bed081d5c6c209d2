//! The straps that hold the mouthpiece: webbing between mouthpiece and ear, with a buckle each.

use crate::form::{direction, normal, on_shell, shell};
use crate::shape::{Mesh, outline};
use crate::sweep::{Frame, frames_on_surface, sweep};
use glam::{Mat4, Vec2, Vec3};

/// Webbing: width and thickness, metres.
const WIDTH: f32 = 0.020;
const THICK: f32 = 0.0018;
/// Length of one repeat of the weave's picture, metres.
const REPEAT: f32 = 0.020;

/// The strap's run on the wearer's left: from the mouthpiece up to the ear, lifted off the shell.
pub fn strap_frames(steps: u32) -> Vec<Frame> {
    let points: Vec<_> = (0..=steps)
        .map(|i| {
            let t = i as f32 / steps as f32;
            // A quadratic curve in the angles.
            let (a, b, c) = (Vec2::new(0.36, -0.60), Vec2::new(0.85, -0.52), Vec2::new(1.45, -0.18));
            let q = a * (1.0 - t) * (1.0 - t) + b * 2.0 * t * (1.0 - t) + c * t * t;
            let d = direction(q.x, q.y);
            let n = normal(d, shell);
            // It stands off where the buckle is and lies on the shell at its ends.
            let lift = 0.0022 + 0.004 * (-((t - 0.52) / 0.20).powi(2)).exp();
            (on_shell(d) + n * lift, n)
        })
        .collect();
    frames_on_surface(&points, false)
}

/// Both straps' webbing, a flat band with round edges; the texture repeats along and once across.
pub fn strap_mesh() -> Mesh {
    let (w, h) = (WIDTH * 0.5, THICK);
    let o = outline(
        &[
            (w - 0.001, -h, 0.0),
            (w, -h, 0.0008),
            (w, h, 0.0009),
            (-w, h, 0.0009),
            (-w, -h, 0.0008),
            (-w + 0.001, -h, 0.0),
        ],
        2,
    );
    let frames = strap_frames(40);
    let mut left = sweep(&frames, &o, |_, _| Vec2::ONE);
    for (uv, aux) in left.uv.iter_mut().zip(&left.aux) {
        *uv = Vec2::new(aux.x / REPEAT, (aux.y - (0.5 * o[o.len() - 1].len - w)) / WIDTH);
    }
    // The second layer: the free end that runs back from the buckle, a little above and shorter.
    let end: Vec<Frame> = frames[14..21]
        .iter()
        .enumerate()
        .map(|(i, f)| Frame {
            p: f.p + f.up * (0.0036 + 0.0004 * (6 - i) as f32),
            len: f.len - frames[14].len,
            ..*f
        })
        .collect();
    let mut tail = sweep(&end, &o, |_, _| Vec2::new(0.98, 1.0));
    for (uv, aux) in tail.uv.iter_mut().zip(&tail.aux) {
        *uv = Vec2::new(aux.x / REPEAT + 0.37, (aux.y - (0.5 * o[o.len() - 1].len - w)) / WIDTH);
    }
    left.append(&tail);
    let right = left.clone().transform(Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
    left.append(&right);
    left
}

/// Where the buckle sits on the wearer's left: its x runs along the strap, its z away from the head.
pub fn buckle_place() -> Mat4 {
    let frames = strap_frames(40);
    let f = frames[21];
    let along = f.up.cross(f.side);
    Mat4::from_cols(
        along.extend(0.0),
        (-f.side).extend(0.0),
        f.up.extend(0.0),
        (f.p + f.up * 0.001).extend(1.0),
    )
}

/// The metal buckle: a rounded ladder frame of a closed tube and one bar, around the origin in the xy plane, +Z outward.
pub fn buckle_mesh() -> Mesh {
    let (hx, hy) = (0.0105, 0.0145);
    // The frame's centre line: a rounded rectangle.
    let corner = outline(
        &[
            (hx, 0.0, 0.0),
            (hx, hy, 0.004),
            (-hx, hy, 0.004),
            (-hx, -hy, 0.004),
            (hx, -hy, 0.004),
            (hx, 0.0, 0.0),
        ],
        5,
    );
    let points: Vec<_> = corner.iter().map(|q| (q.p.extend(0.0), Vec3::Z)).collect();
    let tube = outline(
        &[
            (0.0022, -0.0022, 0.0),
            (0.0022, 0.0022, 0.0013),
            (-0.0022, 0.0022, 0.0013),
            (-0.0022, -0.0022, 0.0),
        ],
        3,
    );
    let mut m = sweep(&frames_on_surface(&points, true), &tube, |_, _| Vec2::ONE);
    let bar: Vec<_> = [-hy, hy].iter().map(|y| (Vec3::new(0.0, *y, 0.0022), Vec3::Z)).collect();
    m.append(&sweep(&frames_on_surface(&bar, false), &tube, |_, _| Vec2::new(0.9, 0.9)));
    m
}
