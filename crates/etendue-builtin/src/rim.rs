//! What borders the openings: the visor's frame and gasket, the neck's ring and the lining.

use crate::form::{direction, neck_edge, normal, on_shell, shell, visor_angles};
use crate::shape::{Mesh, outline};
use crate::sweep::{Frame, frames_on_surface, sweep};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Frames along the visor's opening at relative extent `t`, `steps` around.
pub fn visor_frames(t: f32, steps: u32) -> Vec<Frame> {
    // Points at even steps of the parameter crowd at the corners of a superellipse: take them at even lengths instead.
    let fine: Vec<Vec3> = (0..=2048)
        .map(|i| {
            let a = visor_angles(TAU * (i % 2048) as f32 / 2048.0, t);
            direction(a.x, a.y)
        })
        .collect();
    let mut length = vec![0.0f32];
    for w in fine.windows(2) {
        let l = length[length.len() - 1] + on_shell(w[0]).distance(on_shell(w[1]));
        length.push(l);
    }
    let total = length[length.len() - 1];
    let points: Vec<_> = (0..=steps)
        .map(|i| {
            let want = total * (i % steps) as f32 / steps as f32;
            let k = length.partition_point(|l| *l <= want).clamp(1, 2048) - 1;
            let f = (want - length[k]) / (length[k + 1] - length[k]);
            let d = fine[k].lerp(fine[k + 1], f).normalize();
            (on_shell(d), normal(d, shell))
        })
        .collect();
    frames_on_surface(&points, true)
}

/// The visor's moulded frame, on the shell around the opening: a flat, screwed flange and a lip.
pub fn frame_mesh() -> Mesh {
    let o = outline(
        &[
            (0.0165, -0.004, 0.0),
            (0.0165, 0.0030, 0.0014),
            (0.0060, 0.0042, 0.0010),
            (0.0045, 0.0075, 0.0014),
            (-0.0015, 0.0085, 0.0016),
            (-0.0030, 0.0040, 0.0012),
            (-0.0032, -0.004, 0.0),
        ],
        2,
    );
    sweep(&visor_frames(1.0, 112), &o, |_, _| Vec2::ONE)
}

/// The rubber between frame and visor.
pub fn gasket_mesh() -> Mesh {
    let o = outline(
        &[
            (-0.0015, -0.003, 0.0),
            (-0.0015, 0.0058, 0.002),
            (-0.0075, 0.0052, 0.0025),
            (-0.0085, -0.004, 0.0),
        ],
        2,
    );
    sweep(&visor_frames(1.0, 112), &o, |_, _| Vec2::ONE)
}

/// Frames along the neck's opening, from the front to the wearer's left; `up` points away from the head.
fn neck_frames(steps: u32) -> Vec<Frame> {
    let points: Vec<_> = (0..=steps)
        .map(|i| {
            let d = neck_edge(TAU * (i % steps) as f32 / steps as f32);
            // Out of the neck's plane rather than the shell: horizontal, so that the ring stands upright.
            let n = normal(d, shell);
            (on_shell(d), Vec3::new(n.x, 0.25 * n.y, n.z).normalize())
        })
        .collect();
    frames_on_surface(&points, true)
}

/// The neck's ring: a rubber roll over the shell's edge and a metal band below it.
pub fn neck_mesh() -> Mesh {
    // The first axis points down, the second away from the head; the outline runs from inside below to the top.
    let o = outline(
        &[
            (-0.0040, -0.0080, 0.0),
            (0.0040, -0.0085, 0.0020),
            (0.0130, -0.0060, 0.0020),
            (0.0125, 0.0005, 0.0012),
            (0.0040, 0.0005, 0.0008),
            (0.0035, 0.0046, 0.0022),
            (-0.0050, 0.0040, 0.0022),
            (-0.0050, -0.0030, 0.0),
        ],
        2,
    );
    sweep(&neck_frames(88), &o, |_, _| Vec2::ONE)
}

/// The padded lining, seen through the neck's opening: the shell's inside, brought in by the padding.
pub fn lining_mesh() -> Mesh {
    let (around, up) = (48u32, 11u32);
    let mut m = Mesh::default();
    for j in 0..=up {
        for i in 0..=around {
            // Clockwise from above: the inside faces us.
            let azimuth = -TAU * (i % around) as f32 / around as f32;
            let e0 = crate::form::angles(neck_edge(azimuth)).y;
            let t = j as f32 / up as f32;
            let elevation = e0 + (FRAC_PI_2 - 1e-3 - e0) * t;
            let d = direction(azimuth, elevation);
            let at = |d: Vec3| {
                let depth = 0.006 + 0.014 * crate::noise::smoothstep(0.0, 0.12, t);
                cranium_or_shell(d) - depth
            };
            let uv = Vec2::new(12.0 * i as f32 / around as f32, 6.0 * (1.0 - t));
            m.push(d * at(d), -normal(d, cranium_or_shell), uv, Vec3::ZERO);
        }
    }
    m.connect(0, around + 1, up + 1);
    m
}

/// The form without the crest: the smaller of cranium and shell.
fn cranium_or_shell(d: Vec3) -> f32 {
    crate::form::cranium(d).min(shell(d))
}
