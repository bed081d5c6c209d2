//! Lettering and insignia: strokes of constant width, as a stencil cutter would make them.

use crate::noise::smoothstep;
use glam::{Vec2, Vec3};

/// What a mark is sprayed with.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Ink {
    /// Near black.
    Dark,
    /// The shell's white.
    Light,
    /// The stripe's red.
    Signal,
}

/// Strokes of a letter in a cell 4 wide and 6 high, y up: polylines.
fn strokes(c: char) -> &'static [&'static [(f32, f32)]] {
    match c {
        'A' => &[
            &[(0.0, 0.0), (0.0, 4.5), (1.5, 6.0), (2.5, 6.0), (4.0, 4.5), (4.0, 0.0)],
            &[(0.0, 2.6), (4.0, 2.6)],
        ],
        'C' => &[&[(4.0, 0.0), (1.5, 0.0), (0.0, 1.5), (0.0, 4.5), (1.5, 6.0), (4.0, 6.0)]],
        'D' => &[&[(0.0, 0.0), (0.0, 6.0), (2.5, 6.0), (4.0, 4.5), (4.0, 1.5), (2.5, 0.0), (0.0, 0.0)]],
        'E' => &[&[(4.0, 0.0), (0.0, 0.0), (0.0, 6.0), (4.0, 6.0)], &[(0.0, 3.1), (3.0, 3.1)]],
        'G' => &[&[
            (4.0, 6.0),
            (1.5, 6.0),
            (0.0, 4.5),
            (0.0, 1.5),
            (1.5, 0.0),
            (4.0, 0.0),
            (4.0, 2.8),
            (2.4, 2.8),
        ]],
        'I' => &[&[(2.0, 0.0), (2.0, 6.0)]],
        'L' => &[&[(0.0, 6.0), (0.0, 0.0), (4.0, 0.0)]],
        'M' => &[&[(0.0, 0.0), (0.0, 6.0), (2.0, 3.2), (4.0, 6.0), (4.0, 0.0)]],
        'N' => &[&[(0.0, 0.0), (0.0, 6.0), (4.0, 0.0), (4.0, 6.0)]],
        'O' | '0' => &[&[
            (1.5, 0.0),
            (0.0, 1.5),
            (0.0, 4.5),
            (1.5, 6.0),
            (2.5, 6.0),
            (4.0, 4.5),
            (4.0, 1.5),
            (2.5, 0.0),
            (1.5, 0.0),
        ]],
        'R' => &[
            &[(0.0, 0.0), (0.0, 6.0), (2.8, 6.0), (4.0, 5.0), (4.0, 3.8), (2.8, 2.8), (0.0, 2.8)],
            &[(2.2, 2.8), (4.0, 0.0)],
        ],
        'S' => &[&[
            (0.0, 0.0),
            (2.8, 0.0),
            (4.0, 1.0),
            (4.0, 2.2),
            (3.0, 3.1),
            (1.0, 3.1),
            (0.0, 4.0),
            (0.0, 5.0),
            (1.2, 6.0),
            (4.0, 6.0),
        ]],
        'T' => &[&[(0.0, 6.0), (4.0, 6.0)], &[(2.0, 6.0), (2.0, 0.0)]],
        'U' => &[&[(0.0, 6.0), (0.0, 0.8), (0.8, 0.0), (3.2, 0.0), (4.0, 0.8), (4.0, 6.0)]],
        'V' => &[&[(0.0, 6.0), (2.0, 0.0), (4.0, 6.0)]],
        'X' => &[&[(0.0, 0.0), (4.0, 6.0)], &[(0.0, 6.0), (4.0, 0.0)]],
        'Y' => &[&[(0.0, 6.0), (2.0, 3.0), (4.0, 6.0)], &[(2.0, 3.0), (2.0, 0.0)]],
        'B' => &[
            &[(0.0, 0.0), (0.0, 6.0), (2.8, 6.0), (3.8, 5.2), (3.8, 4.0), (2.8, 3.1), (0.0, 3.1)],
            &[(2.8, 3.1), (4.0, 2.2), (4.0, 0.9), (2.8, 0.0), (0.0, 0.0)],
        ],
        'F' => &[&[(0.0, 0.0), (0.0, 6.0), (4.0, 6.0)], &[(0.0, 3.1), (3.0, 3.1)]],
        'H' => &[&[(0.0, 0.0), (0.0, 6.0)], &[(4.0, 0.0), (4.0, 6.0)], &[(0.0, 3.1), (4.0, 3.1)]],
        'K' => &[&[(0.0, 0.0), (0.0, 6.0)], &[(4.0, 6.0), (0.0, 2.6)], &[(1.4, 3.8), (4.0, 0.0)]],
        'P' => &[&[(0.0, 0.0), (0.0, 6.0), (2.8, 6.0), (4.0, 5.0), (4.0, 3.6), (2.8, 2.6), (0.0, 2.6)]],
        'W' => &[&[(0.0, 6.0), (0.6, 0.0), (2.0, 2.8), (3.4, 0.0), (4.0, 6.0)]],
        '1' => &[&[(0.8, 4.8), (2.0, 6.0), (2.0, 0.0)]],
        '2' => &[&[(0.0, 6.0), (2.8, 6.0), (4.0, 5.0), (4.0, 3.6), (0.0, 0.0), (4.0, 0.0)]],
        '3' => &[&[(0.0, 6.0), (4.0, 6.0), (2.0, 3.6), (4.0, 2.4), (4.0, 1.0), (2.8, 0.0), (0.0, 0.0)]],
        '4' => &[&[(3.0, 0.0), (3.0, 6.0), (0.0, 2.0), (4.0, 2.0)]],
        '7' => &[&[(0.0, 6.0), (4.0, 6.0), (1.4, 0.0)]],
        '-' => &[&[(0.6, 3.0), (3.4, 3.0)]],
        _ => &[],
    }
}

fn distance_to_segment(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_squared().max(1e-12)).clamp(0.0, 1.0);
    p.distance(a + ab * t)
}

/// Distance from `p` to the centre lines of `text`, whose capitals are `height` high and stand on y = 0, centred on x = 0.
pub fn text_distance(p: Vec2, text: &str, height: f32) -> f32 {
    let scale = height / 6.0;
    let advance = 6.0;
    let n = text.chars().count() as f32;
    let q = p / scale + Vec2::new(0.5 * (n * advance - 2.0), 0.0);
    let mut best = f32::MAX;
    for (i, c) in text.chars().enumerate() {
        let local = q - Vec2::new(i as f32 * advance, 0.0);
        if local.x < -2.0 || local.x > 6.0 || local.y < -2.0 || local.y > 8.0 {
            continue;
        }
        for line in strokes(c) {
            for w in line.windows(2) {
                best = best.min(distance_to_segment(
                    local,
                    Vec2::new(w[0].0, w[0].1),
                    Vec2::new(w[1].0, w[1].1),
                ));
            }
        }
    }
    best * scale
}

/// How much a shape at signed distance `d` covers, with an edge about a texel wide.
fn cover(d: f32) -> f32 {
    smoothstep(0.00022, -0.00022, d)
}

/// The insignia: a ring, and rays that pass a waist, as wide and as steep before as behind it. `size` is the radius.
pub fn insignia(p: Vec2, size: f32) -> f32 {
    let q = p / size;
    let ring = (q.length() - 0.90).abs() - 0.075;
    let inner = (q.length() - 0.74).abs() - 0.02;
    let bounds = q.length() - 0.64;
    // The bundle of rays: hyperbolas around the waist.
    let mut rays = f32::MAX;
    for k in [-1.0f32, -0.5, 0.0, 0.5, 1.0] {
        let y = k * (0.14 * 0.14 + 0.46 * q.x * q.x).sqrt();
        let slope = k * 0.46 * q.x / (0.14 * 0.14 + 0.46 * q.x * q.x).sqrt();
        rays = rays.min((q.y - y).abs() / (1.0 + slope * slope).sqrt() - 0.042);
    }
    let waist = (q.x.abs() - 0.035).max(q.y.abs() - 0.34).max(0.20 - q.y.abs());
    ring.min(inner).min(rays.min(waist).max(bounds)) * size
}

/// Signed distance to a capsule of half length `half` along x and radius `r`.
fn capsule(q: Vec2, half: f32, r: f32) -> f32 {
    Vec2::new((q.x.abs() - half).max(0.0), q.y).length() - r
}

/// Signed distance to a rectangle.
fn rectangle(q: Vec2, half: Vec2) -> f32 {
    let e = q.abs() - half;
    e.max(Vec2::ZERO).length() + e.max_element().min(0.0)
}

/// Signed distance to an arrow that points along +x, its tip at the origin, `size` long.
fn arrow(q: Vec2, size: f32) -> f32 {
    let head = (q.x + q.y.abs() * 0.9).max(-q.x - 0.5 * size);
    let shaft = rectangle(q + Vec2::new(0.72 * size, 0.0), Vec2::new(0.28 * size, 0.09 * size));
    head.min(shaft)
}

/// The air slots over the temples: signed distance of a place to the nearest slot, metres.
pub fn slots(p: Vec3) -> f32 {
    let side = p.x.signum();
    let centre = Vec3::new(0.46 * side, 0.82, -0.10).normalize();
    let d = p.normalize();
    if d.dot(centre) < 0.9 {
        return 1.0;
    }
    // Along the crown from front to back, across towards the ear.
    let back = (Vec3::NEG_Z - centre * -centre.z).normalize();
    let across = centre.cross(back);
    let q = Vec2::new(d.dot(back), d.dot(across)) * p.length();
    let mut best = 1.0f32;
    for k in -1i32..=1 {
        let half = 0.0125 - 0.002 * k.abs() as f32;
        best = best.min(capsule(q - Vec2::new(0.0, 0.0085 * k as f32), half, 0.0021));
    }
    best
}

/// A direction in the tangent plane at an azimuth and elevation, metres on a sphere as large as the shell, x to the right and
/// y up as seen from outside; `None` on the far side.
fn from_outside(d: Vec3, azimuth: f32, elevation: f32) -> Option<Vec2> {
    let centre = crate::form::direction(azimuth, elevation);
    let ahead = d.dot(centre);
    let x = Vec3::Y.cross(centre).normalize();
    (ahead > 0.8).then(|| Vec2::new(d.dot(x), d.dot(centre.cross(x))) * (0.140 / ahead))
}

/// The marks that cover a place of the shell, each with its ink and cover 0..1, in the order of spraying.
pub fn shell_marks(p: Vec3) -> Vec<(Ink, f32)> {
    let mut out = Vec::new();
    let d = p.normalize();
    // On the sides, marks lie in the plane seen from there: x towards the reader's right.
    let side = p.x.signum();
    // x of a place that lies `front` metres before the ear, as read from that side.
    let at = |front: f32, y: f32| Vec2::new(-front * side, y);
    if d.x.abs() > 0.22 {
        let q = Vec2::new(-p.z * side, p.y);
        let text = |place: Vec2, s: &str, h: f32, stroke: f32| cover(text_distance(q - place, s, h) - stroke);
        if p.y > -0.012 {
            out.push((Ink::Signal, cover(insignia(q - at(-0.090, 0.030), 0.020))));
            out.push((Ink::Dark, text(at(-0.090, 0.0030), "LIGHT CREW", 0.0036, 0.00042)));
            // The rescue arrow points at the ear's release.
            let tip = q - at(-0.022, 0.030);
            out.push((Ink::Signal, cover(arrow(Vec2::new(-tip.y, tip.x), 0.012))));
            out.push((Ink::Dark, text(at(-0.022, 0.0435), "RESCUE", 0.0040, 0.00046)));
        } else {
            // A data plate and a row of warning bars on the jaw.
            let place = at(-0.048, -0.068);
            let frame = rectangle(q - place, Vec2::new(0.0225, 0.0085)).abs() - 0.0004;
            out.push((Ink::Light, cover(frame)));
            out.push((Ink::Light, text(place + Vec2::new(0.0, 0.0016), "VISOR LOCK", 0.0040, 0.00044)));
            out.push((Ink::Light, text(place + Vec2::new(0.0, -0.0052), "PULL DOWN", 0.0036, 0.00040)));
            let bars = q - at(0.020, -0.078);
            let slant = (bars.x + bars.y).rem_euclid(0.0090) - 0.0045;
            let block = rectangle(bars, Vec2::new(0.0225, 0.0042));
            out.push((Ink::Signal, cover((slant.abs() - 0.00225).max(block))));
        }
    }
    // On the brow, beside the stripe, upright for a reader in front.
    if let Some(q) = from_outside(d, 0.96 * side, 0.90) {
        let text = |y: f32, s: &str, h: f32, stroke: f32| {
            (Ink::Dark, cover(text_distance(q - Vec2::new(0.0, y), s, h) - stroke))
        };
        out.push(text(-0.010, "07", 0.031, 0.0031));
        out.push(text(-0.0215, "ETENDUE", 0.0064, 0.00062));
        out.push(text(-0.0280, "N2 A OMEGA", 0.0034, 0.00040));
    }
    // At the nape, on the stripe.
    if d.z < -0.5 && d.y.abs() < 0.6 {
        out.push((Ink::Light, cover(text_distance(Vec2::new(-p.x, p.y + 0.006), "07", 0.020) - 0.0020)));
        out.push((
            Ink::Light,
            cover(text_distance(Vec2::new(-p.x, p.y + 0.014), "ETENDUE", 0.0036) - 0.00042),
        ));
    }
    out
}
