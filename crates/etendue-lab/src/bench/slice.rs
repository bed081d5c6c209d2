//! The lobe in the plane of incidence, as a polar figure and over the angle.

use super::{Subject, in_plane, mean, peaks};
use crate::draw::{Anchor, Axis, Chart, Drawing, FAINT, GREY, Item, LINES, Series};
use etendue_bxdf::{Bsdf, model::Closure};

/// Angles of `wo`.
const ANGLES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

pub(super) fn plot(s: &Subject) -> Drawing {
    let closure = s.closure();
    let passes = closure.refraction().is_some();
    let mut d = Drawing::new(1240, if passes { 760 } else { 620 });
    let caption = "Light that arrives from wi and leaves towards wo, f |cos θ|, in the plane of incidence; mean of \
                   red, green and blue. On the left each curve is scaled to its own \
                   largest value; strokes inside the rim mark wo; dashes are perfectly \
                   specular parts, as long as their share of the light.";
    d.frame(&s.title("lobe in the plane of incidence"), &s.caption(caption));

    let radius = 255.0;
    let centre = [300.0, if passes { 370.0 } else { 400.0 }];
    let rim = if passes { 180 } else { 90 };
    for r in [0.25, 0.5, 0.75, 1.0] {
        let arc = (-rim..=rim).step_by(3).map(|a| {
            let w = in_plane(a as f64);
            [centre[0] + radius * r * w.x, centre[1] - radius * r * w.z]
        });
        d.line(arc.collect(), 1.0, FAINT);
    }
    d.line(vec![[centre[0] - radius, centre[1]], [centre[0] + radius, centre[1]]], 1.0, GREY);
    let all: &[i32] = if passes {
        &[-180, -150, -120, -90, -60, -30, 0, 30, 60, 90, 120, 150]
    } else {
        &[-90, -60, -30, 0, 30, 60, 90]
    };
    for &degrees in all {
        let w = in_plane(degrees as f64);
        let at = [centre[0] + (radius + 22.0) * w.x, centre[1] - (radius + 16.0) * w.z];
        d.text(at, format!("{degrees}°"), GREY, Anchor::Middle);
    }
    let mut series = Vec::new();
    for (i, degrees) in ANGLES.into_iter().enumerate() {
        let curve = curve(&closure, degrees, passes);
        let most = curve.iter().map(|p| p[1]).fold(0.0, f64::max);
        if most > 0.0 {
            let points = curve
                .iter()
                .map(|[angle, v]| {
                    let (w, r) = (in_plane(*angle), (v / most) as f32 * radius);
                    [centre[0] + r * w.x, centre[1] - r * w.z]
                })
                .collect();
            d.line(points, 2.0, LINES[i]);
        }
        for part in closure.deltas(in_plane(degrees)).into_iter().flatten() {
            let r = radius * (mean(part.reflectance) as f32).min(1.0);
            let points = vec![centre, [centre[0] + r * part.wi.x, centre[1] - r * part.wi.z]];
            d.items.push(Item::Line { points, width: 2.0, color: LINES[i], dash: Some([6.0, 4.0]) });
        }
        let w = in_plane(degrees);
        let along = |r: f32| [centre[0] + r * radius * w.x, centre[1] - r * radius * w.z];
        d.line(vec![along(0.9), along(1.0)], 4.0, LINES[i]);
        let name = format!("wo at {degrees}°: largest {most:.3}");
        series.push(Series::new(name, i, curve));
    }
    let top = Chart::top(&series);
    let (low, high) = (if passes { -180.0 } else { -90.0 }, if passes { 180.0 } else { 90.0 });
    let chart = Chart {
        title: "the same over the angle, logarithmic".into(),
        x: Axis::linear("angle of wi to the normal, degrees (negative: away from wo)", low, high),
        y: Axis::log("f |cos θ|, 1/sr", (top * 1e-5).max(1e-9), (top * 2.0).max(1e-6)),
        series,
    };
    let height = if passes { 620.0 } else { 490.0 };
    chart.draw(&mut d, [620.0, 50.0], [604.0, height]);
    d
}

/// f |cos θ| over the angle, dense where it bends.
fn curve(closure: &Closure, degrees: f64, passes: bool) -> Vec<[f64; 2]> {
    let wo = in_plane(degrees);
    let value = |angle: f64| {
        let wi = in_plane(angle);
        mean(closure.eval(wo, wi)) * wi.z.abs() as f64
    };
    let end: i32 = if passes { 180 } else { 90 };
    let mut angles: Vec<f64> = (-end * 4..=end * 4).map(|i| i as f64 * 0.25).collect();
    let [ax, ay] = closure.narrowest_alpha();
    let width = (ax.min(ay) as f64).to_degrees();
    for peak in peaks(closure, degrees) {
        for k in -24..=24i32 {
            // From a thirtieth of the lobe's width to degrees.
            let step = width * 0.03 * (k.unsigned_abs() as f64 * 0.35).exp();
            let at = if k == 0 { peak } else { peak + step * k.signum() as f64 };
            if at.abs() <= end as f64 {
                angles.push(at);
            }
        }
    }
    angles.sort_by(f64::total_cmp);
    angles.into_iter().map(|a| [a, value(a)]).collect()
}
