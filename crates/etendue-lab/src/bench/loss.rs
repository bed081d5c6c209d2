//! What is lost between microfacets, with and without compensation.

use super::{Subject, in_plane, mean, with_roughness};
use crate::draw::{Axis, Chart, Drawing, Series};
use etendue_bxdf::{model::Model, model::Value, reflectance::hemispherical_directional};

/// What the parameter is called.
const NAMES: [&str; 4] = ["compensation", "energy_compensation", "multiple_scattering", "energy_preserving"];

/// `None` if the model has no such parameter.
pub(super) fn plot(s: &Subject) -> Option<Drawing> {
    let parameter = s.model.parameters().into_iter().find(|p| NAMES.contains(&p.name))?;
    let values: Vec<(String, Value)> = match parameter.default {
        Value::Flag(_) => [("off", false), ("on", true)].map(|(n, b)| (n.into(), Value::Flag(b))).into(),
        Value::Choice(_) => parameter.choices.iter().map(|c| ((*c).into(), Value::Choice(c))).collect(),
        Value::Number(_) => parameter.range.map(|v| (format!("{v}"), Value::Number(v))).into(),
        _ => return None,
    };
    with_roughness(s.model, 0.5)?;
    let charts: Vec<Chart> = [0.0, 75.0]
        .into_iter()
        .map(|angle| {
            let line = |(i, (name, value)): (usize, &(String, Value))| {
                let mut m: Model = *s.model;
                m.set(parameter.name, *value);
                let points = (0..=20)
                    .filter_map(|k| {
                        let r = k as f32 / 20.0;
                        let closure = Subject::power(&with_roughness(&m, r)?);
                        Some([r as f64, mean(hemispherical_directional(&closure, in_plane(angle)).total())])
                    })
                    .collect();
                Series::new(format!("{} {name}", parameter.name), i, points)
            };
            let series: Vec<Series> = values.iter().enumerate().map(line).collect();
            Chart {
                title: format!("wo at {angle}°"),
                x: Axis::linear("roughness", 0.0, 1.0),
                y: Axis::linear("albedo", 0.0, 1.05f64.max(1.05 * Chart::top(&series))),
                series,
            }
        })
        .collect();
    let mut d = Drawing::new(1240, 560);
    let caption = "Albedo by quadrature over roughness. What is missing from 1 was absorbed, or lost because light that \
                   bounces between microfacets is left out.";
    d.frame(&s.title("energy with and without compensation"), &s.caption(caption));
    for (i, chart) in charts.iter().enumerate() {
        chart.draw(&mut d, [10.0 + 612.0 * i as f32, 52.0], [604.0, 430.0]);
    }
    Some(d)
}
