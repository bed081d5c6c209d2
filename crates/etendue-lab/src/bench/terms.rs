//! What a microfacet model is made of: distribution, masking, Fresnel.

use super::{Subject, in_plane, with_roughness};
use crate::draw::{Axis, Chart, Drawing, Series};
use etendue_bxdf::{Bsdf, Ggx, model::Value};
use glam::vec3a;

/// `None` if the model has no GGX lobe and no mirror at roughness 0.
pub(super) fn plot(s: &Subject) -> Option<Drawing> {
    let mut charts = Vec::new();
    let [ax, ay] = s.closure().narrowest_alpha();
    let other = s.model.parameters().iter().any(|p| match s.model.get(p.name) {
        Some(Value::Choice(c)) => ["ndf", "distribution"].contains(&p.name) && !c.contains("ggx"),
        _ => false,
    });
    let rough = etendue_bxdf::laws::cases::roughness_name(s.model)
        .is_some_and(|n| matches!(s.model.get(n), Some(Value::Number(r)) if r > 0.0));
    if rough && !other && s.model.name() != "hair" {
        let ggx = Ggx::new(ax, ay);
        let [ax, ay] = ggx.alpha();
        let wide = if ax.max(ay) > 0.2 { 90.0 } else { (8.0 * ax.max(ay)).atan().to_degrees() as f64 };
        let axes: &[(usize, &str)] = if ax == ay { &[(0, "")] } else { &[(0, " along x"), (1, " along y")] };
        let curves = |f: &dyn Fn(glam::Vec3A) -> f32, end: f64| -> Vec<Series> {
            axes.iter()
                .map(|(i, name)| {
                    let points = (0..=360)
                        .map(|k| {
                            let angle = k as f64 / 360.0 * end;
                            let w = in_plane(angle);
                            let w = if *i == 0 { w } else { vec3a(0.0, w.x, w.z) };
                            [angle, f(w) as f64]
                        })
                        .collect();
                    Series::new(format!("α = {:.4}{name}", [ax, ay][*i]), *i, points)
                })
                .collect()
        };
        let d = curves(&|m| ggx.d(m), wide);
        charts.push(Chart {
            title: "D: distribution of normals (GGX)".into(),
            x: Axis::linear("angle of m to the normal, degrees", 0.0, wide),
            y: Axis::linear("D(m), 1/sr", 0.0, Chart::top(&d) * 1.05),
            series: d,
        });
        charts.push(Chart {
            title: "G1: visible part of the facets (Smith)".into(),
            x: Axis::linear("angle of w to the normal, degrees", 0.0, 90.0),
            y: Axis::linear("G1(w)", 0.0, 1.05),
            series: curves(&|w| ggx.g1(w), 90.0),
        });
    }
    let f = fresnel(s);
    if !f.is_empty() {
        charts.push(Chart {
            title: "F: mirror reflectance at roughness 0".into(),
            x: Axis::linear("angle of wo to the normal, degrees", 0.0, 90.0),
            y: Axis::linear("reflectance", 0.0, 1.05f64.max(Chart::top(&f))),
            series: f,
        });
    }
    if charts.is_empty() {
        return None;
    }
    let mut d = Drawing::new(1260, 520);
    let caption = "D is Trowbridge and Reitz's distribution and G1 Smith's masking of the narrowest lobe; F is what the \
                   model reflects as a mirror when its roughness is 0.";
    d.frame(&s.title("distribution, masking, Fresnel"), &s.caption(caption));
    for (i, chart) in charts.iter().enumerate() {
        chart.draw(&mut d, [8.0 + 416.0 * i as f32, 52.0], [412.0, 400.0]);
    }
    Some(d)
}

/// The reflectance of the smooth model by angle: one line, or three if it has a colour.
fn fresnel(s: &Subject) -> Vec<Series> {
    let Some(smooth) = with_roughness(s.model, 0.0) else { return Vec::new() };
    let closure = smooth.closure(&Default::default());
    let samples: Vec<(f64, [f32; 3])> = (0..=178)
        .filter_map(|i| {
            let angle = i as f64 * 0.5;
            let wo = in_plane(angle);
            let parts = closure.deltas(wo);
            let part = parts.into_iter().flatten().find(|d| d.wi.z > 0.0)?;
            Some((angle, part.reflectance.to_rgb()))
        })
        .collect();
    let lane = |k: usize| samples.iter().map(|(a, c)| [*a, c[k] as f64]).collect::<Vec<_>>();
    if samples.is_empty() {
        return Vec::new();
    }
    let grey = samples.iter().all(|(_, c)| (c[0] - c[1]).abs() < 1e-4 && (c[1] - c[2]).abs() < 1e-4);
    if grey {
        vec![Series::new("", 0, lane(0))]
    } else {
        vec![
            Series::new("red", 1, lane(0)),
            Series::new("green", 2, lane(1)),
            Series::new("blue", 0, lane(2)),
        ]
    }
}
