//! What is screwed onto the shell: ear pods, mouthpiece, connectors, hose, bolts, lamp.

use crate::form::{direction, normal, on_shell, shell};
use crate::lathe::lathe;
use crate::noise::smoothstep;
use crate::rim::visor_frames;
use crate::shape::{Mesh, outline};
use crate::sweep::{frames_in_space, sweep};
use glam::{Mat4, Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Place on the shell: origin at the surface, +Z along its normal, +Y as near to up as it goes.
pub fn place_on_shell(d: Vec3, sink: f32) -> Mat4 {
    let z = normal(d, shell);
    let x = Vec3::Y.cross(z).normalize();
    let y = z.cross(x);
    Mat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), (on_shell(d) - z * sink).extend(1.0))
}

/// The ear pod: rubber foot, metal ring, glowing groove, painted cap with a dished centre. +Z is away from the head.
pub fn pod_mesh() -> Mesh {
    let o = outline(
        &[
            (0.0400, -0.012, 0.0),
            (0.0400, 0.0060, 0.0020),
            (0.0365, 0.0062, 0.0008),
            (0.0362, 0.0130, 0.0016),
            (0.0318, 0.0136, 0.0012),
            (0.0312, 0.0108, 0.0006),
            (0.0286, 0.0108, 0.0006),
            (0.0280, 0.0152, 0.0016),
            (0.0150, 0.0172, 0.0014),
            (0.0135, 0.0140, 0.0010),
            (0.0085, 0.0140, 0.0010),
            (0.0078, 0.0166, 0.0010),
            (0.0000, 0.0170, 0.0),
        ],
        1,
    );
    lathe(&o, 48)
}

/// Where the left ear's pod sits.
pub fn pod_place() -> Mat4 {
    let d = direction(1.62, -0.06);
    place_on_shell(d, 0.0005) * Mat4::from_rotation_z(0.3)
}

/// A domed bolt with a hexagonal socket's shadow left to paint; the foot is sunk.
pub fn bolt_mesh() -> Mesh {
    let o = outline(
        &[
            (0.0036, -0.001, 0.0),
            (0.0036, 0.0012, 0.0004),
            (0.0029, 0.0019, 0.0006),
            (0.0016, 0.0021, 0.0002),
            (0.0014, 0.0009, 0.0002),
            (0.0, 0.0008, 0.0),
        ],
        1,
    );
    lathe(&o, 12)
}

/// Where the visor frame's bolts sit: on its flange, at even distances.
pub fn bolt_places() -> Vec<Mat4> {
    let n = 14u32;
    let frames = visor_frames(1.0, n * 2);
    (0..n)
        .map(|i| {
            let f = frames[(2 * i + 1) as usize];
            let p = f.p + f.side * 0.0112 + f.up * 0.0034;
            let x = f.up.cross(f.side);
            let m = Mat4::from_cols(x.extend(0.0), (-f.side).extend(0.0), f.up.extend(0.0), p.extend(1.0));
            m * Mat4::from_rotation_z(crate::noise::unit(crate::noise::hash(i)) * TAU)
        })
        .collect()
}

/// Outline of the mouthpiece in its own plane: a rounded trapezoid, narrower below; metres at relative radius `t`.
fn mouth_shape(phi: f32, t: f32) -> Vec2 {
    let (s, c) = phi.sin_cos();
    let k = 3.2f32;
    let r = t / (c.abs().powf(k) + s.abs().powf(k)).powf(1.0 / k);
    let y = r * s;
    Vec2::new(r * c * 0.047 * (1.0 + 0.16 * y), y * 0.0255)
}

/// Centre of the mouthpiece on the chin.
const MOUTH: f32 = -0.62;

/// A point over the chin at the mouthpiece's own coordinates (metres), `h` above the shell.
fn over_chin(q: Vec2, h: f32) -> (Vec3, Vec3) {
    let r = shell(direction(0.0, MOUTH));
    let d = direction(q.x / (r * 0.86), MOUTH + q.y / r);
    let n = normal(d, shell);
    (on_shell(d) + n * h, n)
}

/// The mouthpiece: a bevelled block that follows the chin, with a recessed grille.
pub fn mouth_mesh() -> Mesh {
    // Relative radius and height of its rings, from the foot to the middle.
    let rings = outline(
        &[
            (0.0470, -0.004, 0.0),
            (0.0465, 0.0090, 0.0030),
            (0.0370, 0.0135, 0.0022),
            (0.0345, 0.0095, 0.0010),
            (0.0000, 0.0105, 0.0),
        ],
        3,
    );
    let around = 60u32;
    let mut m = Mesh::default();
    let mut radii: Vec<(f32, f32, Vec2)> = rings.iter().map(|q| (q.p.x / 0.047, q.p.y, q.n)).collect();
    let last = radii.len() - 1;
    let (edge, centre) = (radii[last - 1], radii[last]);
    radii.truncate(last);
    // The grille's floor: rings down to the middle.
    for k in 1..=3 {
        let t = k as f32 / 3.0;
        radii.push((edge.0 * (1.0 - t).max(1e-3), edge.1 + (centre.1 - edge.1) * t, Vec2::Y));
    }
    for &(t, h, n2) in &radii {
        for i in 0..=around {
            let phi = TAU * (i % around) as f32 / around as f32;
            let q = mouth_shape(phi, t);
            let (p, up) = over_chin(q, h);
            let e = 1e-3;
            let (q0, q1) = (mouth_shape(phi - e, t.max(0.05)), mouth_shape(phi + e, t.max(0.05)));
            let along = (over_chin(q1, h).0 - over_chin(q0, h).0).normalize();
            let out = along.cross(up).normalize();
            let n = (out * n2.x + up * n2.y).normalize();
            m.push(p, n, Vec2::new(0.5 + q.x / 0.116, 0.5 - q.y / 0.062), q.extend(0.0));
        }
    }
    m.connect(0, around + 1, radii.len() as u32);
    // The sides are steep: in a flat projection they would smear. Spread them outward by the height they climb.
    let row = (around + 1) as usize;
    for (j, &(t, h, _)) in radii.iter().enumerate() {
        for i in 0..row {
            let drop = if t > 0.8 { 0.010 * smoothstep(0.0135, -0.004, h) } else { 0.0 };
            let v = j * row + i;
            let dir = (m.uv[v] - 0.5) * Vec2::new(0.116, 0.062);
            let spread = dir + dir.normalize_or_zero() * drop * 0.45;
            m.uv[v] = Vec2::splat(0.5) + spread / Vec2::new(0.132, 0.076);
        }
    }
    m
}

/// The grille: slats with round edges in the mouthpiece's recess.
pub fn grille_mesh() -> Mesh {
    let o = outline(
        &[(0.0011, -0.004, 0.0), (0.0011, 0.0018, 0.0007), (-0.0011, 0.0018, 0.0007), (-0.0011, -0.004, 0.0)],
        2,
    );
    let mut m = Mesh::default();
    for k in 0..7 {
        let x = (k as f32 - 3.0) * 0.0095;
        let points: Vec<_> = (0..=6)
            .map(|j| {
                let y = (j as f32 / 6.0 - 0.5) * 2.0 * 0.0195;
                over_chin(Vec2::new(x * (1.0 + 0.16 * y / 0.0255), y), 0.0105)
            })
            .collect();
        m.append(&sweep(&crate::sweep::frames_on_surface(&points, false), &o, |_, _| Vec2::ONE));
    }
    m
}

/// A threaded connector: flange, ribbed collar, pipe end.
pub fn connector_mesh() -> Mesh {
    let o = outline(
        &[
            (0.0185, -0.008, 0.0),
            (0.0185, 0.0040, 0.0012),
            (0.0150, 0.0046, 0.0006),
            (0.0148, 0.0070, 0.0006),
            (0.0172, 0.0072, 0.0008),
            (0.0172, 0.0145, 0.0010),
            (0.0142, 0.0150, 0.0010),
            (0.0140, 0.0200, 0.0010),
            (0.0100, 0.0205, 0.0008),
            (0.0095, 0.0180, 0.0006),
            (0.0, 0.0178, 0.0),
        ],
        1,
    );
    lathe(&o, 28)
}

/// Where the connector on one side of the mouthpiece sits; `side` is +1 for the wearer's left.
pub fn connector_place(side: f32) -> Mat4 {
    place_on_shell(direction(0.62 * side, -0.66), 0.001)
}

/// Where the hose ends: low behind the right ear.
pub fn hose_end() -> Mat4 {
    place_on_shell(direction(-2.5, -0.40), 0.001)
}

/// The breathing hose: corrugated, from the right connector down, back and up to the shell behind the ear.
pub fn hose_mesh() -> Mesh {
    let place = connector_place(-1.0);
    let start = place.transform_point3(Vec3::new(0.0, 0.0, 0.015));
    let out = place.transform_vector3(Vec3::Z);
    let place = hose_end();
    let end = place.transform_point3(Vec3::new(0.0, 0.0, 0.015));
    let n = place.transform_vector3(Vec3::Z);
    // A cubic through air: leaves along the connector, arrives along the shell's normal.
    let controls = [start, start + out * 0.105, end + n * 0.10 + Vec3::new(0.0, -0.035, 0.02), end];
    let ribs = 38;
    let steps = ribs * 3;
    let points: Vec<Vec3> = (0..=steps)
        .map(|i| {
            let t = i as f32 / steps as f32;
            let u = 1.0 - t;
            controls[0] * (u * u * u)
                + controls[1] * (3.0 * u * u * t)
                + controls[2] * (3.0 * u * t * t)
                + controls[3] * (t * t * t)
        })
        .collect();
    let around = 14;
    let circle: Vec<_> = (0..=around)
        .map(|i| {
            let a = TAU * (i % around) as f32 / around as f32;
            let n = Vec2::new(a.cos(), a.sin());
            crate::shape::ProfilePoint { p: n * 0.0118, n, len: TAU * 0.0118 * i as f32 / around as f32 }
        })
        .collect();
    let swell = |i: usize| [0.86, 1.0, 1.0][i % 3];
    let frames = frames_in_space(&points, Vec3::Y);
    let mut m = sweep(&frames, &circle, |i, _| Vec2::splat(swell(i)));
    // The circle's points run counter-clockwise about the tangent's opposite: tilt normals along the ribs.
    for j in 0..=around {
        for i in 0..frames.len() {
            let v = j * frames.len() + i;
            let (a, b) = (i.max(1) - 1, (i + 1).min(frames.len() - 1));
            let slope = (swell(b) - swell(a)) * 0.0118 / (frames[b].len - frames[a].len);
            let along = (frames[b].p - frames[a].p).normalize();
            m.nrm[v] = (m.nrm[v] - along * slope).normalize();
        }
    }
    m
}

/// The lamp on the brow: a small rounded block on the crest, with a lens.
pub fn lamp_mesh() -> Mesh {
    let o = outline(
        &[
            (0.0135, -0.014, 0.0),
            (0.0135, 0.0070, 0.0018),
            (0.0105, 0.0080, 0.0010),
            (0.0098, 0.0058, 0.0008),
            (0.0, 0.0068, 0.0),
        ],
        2,
    );
    lathe(&o, 26)
}

/// Where the lamp sits: over the brow, turned to the front.
pub fn lamp_place() -> Mat4 {
    place_on_shell(direction(0.0, 0.92), -0.0035) * Mat4::from_quat(Quat::from_rotation_x(0.42))
}

/// The far ear's pod: the near one's place turned half around the vertical axis and front to back.
pub fn mirrored(place: Mat4) -> Mat4 {
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    // Mirrored twice is a rotation: no negative scale reaches the file.
    mirror * place * Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0))
}
