//! How much light comes back, over the angle and over roughness.

use super::{Subject, in_plane, mean, with_roughness};
use crate::draw::{Axis, Chart, Drawing, Series};
use etendue_bxdf::{Bsdf, reflectance::hemispherical_directional};

pub(super) fn plot(s: &Subject) -> Drawing {
    let closure = Subject::power(s.model);
    let angles: Vec<f64> = (0..30).map(|i| i as f64 * 3.0).chain([88.0, 89.0]).collect();
    let measured: Vec<_> =
        angles.iter().map(|a| (*a, hemispherical_directional(&closure, in_plane(*a)))).collect();
    let mut series =
        vec![Series::new("reflected", 0, measured.iter().map(|(a, r)| [*a, mean(r.reflection)]).collect())];
    if closure.refraction().is_some() {
        let through = measured.iter().map(|(a, r)| [*a, mean(r.transmission)]).collect();
        let total = measured.iter().map(|(a, r)| [*a, mean(r.total())]).collect();
        series.push(Series::new("transmitted", 1, through));
        series.push(Series::new("together", 6, total));
    }
    let claimed = angles.iter().map(|a| [*a, mean(closure.albedo(in_plane(*a)))]).collect();
    series.push(Series::new("as the model says", 2, claimed).dashed());
    let mut charts = vec![Chart {
        title: "over the angle".into(),
        x: Axis::linear("angle of wo to the normal, degrees", 0.0, 90.0),
        y: Axis::linear("albedo", 0.0, 1.05f64.max(1.05 * Chart::top(&series))),
        series,
    }];
    if with_roughness(s.model, 0.5).is_some() {
        let series: Vec<Series> = [0.0, 60.0, 80.0]
            .into_iter()
            .enumerate()
            .map(|(i, angle)| {
                let points = (0..=20)
                    .filter_map(|k| {
                        let r = k as f32 / 20.0;
                        let closure = Subject::power(&with_roughness(s.model, r)?);
                        let a = hemispherical_directional(&closure, in_plane(angle));
                        Some([r as f64, mean(a.total())])
                    })
                    .collect();
                Series::new(format!("wo at {angle}°"), i, points)
            })
            .collect();
        charts.push(Chart {
            title: "over roughness, reflected and transmitted".into(),
            x: Axis::linear("roughness", 0.0, 1.0),
            y: Axis::linear("albedo", 0.0, 1.05f64.max(1.05 * Chart::top(&series))),
            series,
        });
    }
    let mut d = Drawing::new(if charts.len() == 2 { 1240 } else { 640 }, 560);
    let caption = "The part of the light from wo that is scattered, by quadrature, perfectly specular parts included; \
                   mean of red, green and blue; what passes is counted as power.";
    d.frame(&s.title("albedo"), &s.caption(caption));
    for (i, chart) in charts.iter().enumerate() {
        chart.draw(&mut d, [10.0 + 612.0 * i as f32, 52.0], [604.0, 430.0]);
    }
    d
}
