//! The lobe over both hemispheres, as a heat map.

use super::{Subject, in_plane, mean};
use crate::draw::{Anchor, Drawing, GREY, HEAT, INK, Item, Rgb, scale};
use etendue_bxdf::{Bsdf, model::Closure};
use glam::{Vec3A, vec3a};

const ANGLES: [f64; 3] = [0.0, 45.0, 75.0];
/// Cells across a disk.
const CELLS: usize = 300;
/// Decades of the colour scale.
const DECADES: f64 = 4.0;

pub(super) fn plot(s: &Subject) -> Drawing {
    let closure = s.closure();
    let passes = closure.refraction().is_some();
    let rows = if passes { 2 } else { 1 };
    let mut d = Drawing::new(1120, 130 + 350 * rows + 40);
    let caption = "f |cos θ| over wi, mean of red, green and blue, logarithmic; disks in Lambert's equal-area \
                   projection: the normal in the middle, the horizon at the rim, rings at 30° and 60°. The cross is wo, \
                   or the direction straight on.";
    d.frame(&s.title("lobe over the sphere"), &s.caption(caption));
    let maps: Vec<Vec<Vec<f64>>> = ANGLES
        .iter()
        .map(|a| (0..rows as usize).map(|row| map(&closure, in_plane(*a), row == 1)).collect())
        .collect();
    let most = maps.iter().flatten().flatten().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = if most > 0.0 { most.log10() } else { 0.0 };
    for (column, degrees) in ANGLES.into_iter().enumerate() {
        for row in 0..rows as usize {
            let at = [24.0 + 340.0 * column as f32, 70.0 + 350.0 * row as f32];
            let size = [310.0, 310.0];
            let pixels = maps[column][row].iter().map(|v| color(*v, top)).collect();
            d.items.push(Item::Picture { at, size, cells: [CELLS, CELLS], pixels });
            let centre = [at[0] + 155.0, at[1] + 155.0];
            for ring in [30.0f32, 60.0, 90.0] {
                let r = (1.0 - ring.to_radians().cos()).sqrt();
                d.circle(centre, 155.0 * r, 1.0, if ring == 90.0 { GREY } else { [0x99; 3] });
            }
            let wo = in_plane(degrees);
            let r = (1.0 - wo.z).sqrt() * if row == 0 { 1.0 } else { -1.0 };
            let [x, y] = [centre[0] + 155.0 * r, centre[1]];
            for (dx, dy) in [(6.0, 6.0), (6.0, -6.0)] {
                d.line(vec![[x - dx, y - dy], [x + dx, y + dy]], 3.5, [255; 3]);
                d.line(vec![[x - dx, y - dy], [x + dx, y + dy]], 1.5, INK);
            }
            let side = if row == 0 { "reflection" } else { "transmission" };
            d.text([centre[0], at[1] - 14.0], format!("{side}, wo at {degrees}°"), INK, Anchor::Middle);
        }
    }
    let label = |t: f64| format!("{:.1e}", 10f64.powf(top - DECADES * (1.0 - t)));
    d.color_bar([1056.0 - 10.0, 90.0], 270.0, &HEAT, [label(0.0), label(0.5), label(1.0)], "f |cos θ|, 1/sr");
    d
}

fn color(v: f64, top: f64) -> Option<Rgb> {
    if v.is_nan() {
        return None;
    }
    Some(scale(&HEAT, (1.0 - (top - v.max(1e-30).log10()) / DECADES) as f32))
}

/// Values row by row; NaN outside the disk.
fn map(closure: &Closure, wo: Vec3A, below: bool) -> Vec<f64> {
    let place = |i: usize| (i as f64 + 0.5) / CELLS as f64 * 2.0 - 1.0;
    (0..CELLS * CELLS)
        .map(|i| {
            let (x, y) = (place(i % CELLS), -place(i / CELLS));
            let r2 = x * x + y * y;
            if r2 > 1.0 {
                return f64::NAN;
            }
            // r² = 1 − cos θ.
            let sin_over_r = (2.0 - r2).sqrt();
            let z = if below { r2 - 1.0 } else { 1.0 - r2 };
            let wi = vec3a((x * sin_over_r) as f32, (y * sin_over_r) as f32, z as f32);
            mean(closure.eval(wo, wi)) * wi.z.abs() as f64
        })
        .collect()
}
