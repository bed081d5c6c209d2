//! Diffuse terms.

use super::{Entry, error};
use crate::draw::{Axis, Chart, Series};
use core::f64::consts::PI;

/// Angles of the light, with that of the view fixed, within one plane.
fn angles() -> impl Iterator<Item = f64> + Clone {
    (0..=178).map(|i| i as f64 * 0.5)
}

/// Cosine between the half vector and either direction, for directions on opposite sides of the normal.
fn cos_half(view: f64, light: f64) -> f64 {
    (0.5 * (view + light)).to_radians().cos()
}

pub(super) fn entries() -> Vec<Entry> {
    vec![fifth_power(), twice_the_same(), without_pi(), twice_pi()]
}

/// Burley's diffuse surface times π over the base colour.
fn burley(roughness: f64, view: f64, light: f64) -> f64 {
    let f90 = 0.5 + 2.0 * roughness * cos_half(view, light).powi(2);
    let f = |a: f64| 1.0 + (f90 - 1.0) * (1.0 - a.to_radians().cos()).powi(5);
    f(view) * f(light)
}

/// The same as the notes have it: linear, and with the view's cosine in F90.
fn burley_noted(roughness: f64, view: f64, light: f64) -> f64 {
    let f90 = 0.5 + 2.0 * roughness * view.to_radians().cos().powi(2);
    let f = |a: f64| 1.0 + (f90 - 1.0) * (1.0 - a.to_radians().cos());
    f(view) * f(light)
}

fn fifth_power() -> Entry {
    let mut series = Vec::new();
    for (i, roughness) in [0.0, 0.5, 1.0].into_iter().enumerate() {
        let line = |f: fn(f64, f64, f64) -> f64| angles().map(|a| [a, f(roughness, 45.0, a)]).collect();
        series.push(Series::new(format!("roughness {roughness}, right"), i, line(burley)));
        series.push(Series::new("noted", i, line(burley_noted)).dashed());
    }
    let grid = (0..=10).flat_map(|r| {
        angles().step_by(6).flat_map(move |v| angles().step_by(6).map(move |l| (r as f64 / 10.0, v, l)))
    });
    let (max, rms) = error(grid.map(|(r, v, l)| (burley_noted(r, v, l), burley(r, v, l))));
    Entry {
        title: "Disney diffuse without its fifth power",
        fault: "The Schlick weight (1 − cos θ)⁵ has lost its exponent, and F90 is taken at the view's angle to the normal \
                instead of the half vector's to the light. Surfaces of low roughness lose light already at moderate \
                angles, and the result is no longer reciprocal.",
        noted: "F_D(ω)  = 1 + (F_D90 − 1) (1 − |n·ω|)\nF_D90   = 1/2 + 2 roughness |n·ω_out|²",
        right: "F_D(ω)  = 1 + (F_D90 − 1) (1 − |n·ω|)⁵\nF_D90   = 1/2 + 2 roughness |h·ω_out|²",
        source: "Burley 2012, Physically Based Shading at Disney, section 5.3",
        measure: "π f / base colour, which is 1 for Lambert; roughness 0..1, both angles 0..87°",
        max,
        rms,
        chart: Chart {
            title: "π f / base colour, view at 45°".into(),
            x: Axis::linear("angle of the light to the normal, degrees", 0.0, 90.0),
            y: Axis::linear("relative to Lambert", 0.0, 1.05 * Chart::top(&series)),
            series,
        },
    }
}

/// The Lommel-Seeliger form times π over the base colour; `same` uses the incident factor twice.
fn subsurface(roughness: f64, view: f64, light: f64, same: bool) -> f64 {
    let f90 = roughness * cos_half(view, light).powi(2);
    let f = |a: f64| 1.0 + (f90 - 1.0) * (1.0 - a.to_radians().cos()).powi(5);
    let product = if same { f(light) * f(light) } else { f(light) * f(view) };
    let sum = view.to_radians().cos() + light.to_radians().cos();
    1.25 * (product * (1.0 / sum - 0.5) + 0.5)
}

fn twice_the_same() -> Entry {
    let mut series = Vec::new();
    for (i, view) in [0.0, 45.0, 80.0].into_iter().enumerate() {
        let line = |same| angles().map(|a| [a, subsurface(0.5, view, a, same)]).collect();
        series.push(Series::new(format!("view {view}°, right"), i, line(false)));
        series.push(Series::new("noted", i, line(true)).dashed());
    }
    let grid = (0..=10).flat_map(|r| {
        angles().step_by(6).flat_map(move |v| angles().step_by(6).map(move |l| (r as f64 / 10.0, v, l)))
    });
    let (max, rms) = error(grid.map(|(r, v, l)| (subsurface(r, v, l, true), subsurface(r, v, l, false))));
    Entry {
        title: "Subsurface term with one factor twice",
        fault: "The Fresnel-like factor of the incident direction stands twice; the outgoing one is missing. The term is \
                not reciprocal, and too dark or too bright where the two angles differ.",
        noted: "1.25/π (F_ss(ω_in) F_ss(ω_in) (1/(|n·ω_in| + |n·ω_out|) − 0.5) + 0.5)",
        right: "1.25/π (F_ss(ω_in) F_ss(ω_out) (1/(|n·ω_in| + |n·ω_out|) − 0.5) + 0.5)",
        source: "Burley 2012, section 5.3, after Hanrahan, Krueger 1993",
        measure: "π f / base colour; roughness 0..1, both angles 0..87°",
        max,
        rms,
        chart: Chart {
            title: "π f / base colour, roughness 0.5".into(),
            x: Axis::linear("angle of the light to the normal, degrees", 0.0, 90.0),
            y: Axis::linear("relative to Lambert", 0.0, 1.05 * Chart::top(&series)),
            series,
        },
    }
}

fn without_pi() -> Entry {
    // A white surface in a white furnace: ∫ f cos dω with f = 1 and with f = 1/π.
    let right = |albedo: f64| albedo;
    let noted = |albedo: f64| albedo * PI;
    let xs = || (0..=100).map(|i| i as f64 / 100.0);
    let (max, rms) = error(xs().map(|a| (noted(a), right(a))));
    let series = vec![
        Series::new("right", 0, xs().map(|a| [a, right(a)]).collect()),
        Series::new("noted", 1, xs().map(|a| [a, noted(a)]).collect()).dashed(),
    ];
    Entry {
        title: "Direct diffuse light without 1/π",
        fault: "Diffuse = Kd · BaseColor, “without dividing by π, a little brighter”: the surface returns π times its base \
                colour while the specular part beside it keeps its scale, so the balance of the two is wrong. It is \
                consistent only where a light's intensity has been divided by π beforehand, for both parts.",
        noted: "Diffuse = Kd · BaseColor",
        right: "Diffuse = Kd · BaseColor / π",
        source: "Lambert 1760; the integral of cos θ over the hemisphere is π",
        measure: "part of the light returned in a white furnace, base colour 0..1 and Kd = 1",
        max,
        rms,
        chart: Chart {
            title: "light returned in a white furnace".into(),
            x: Axis::linear("base colour", 0.0, 1.0),
            y: Axis::linear("albedo", 0.0, 3.3),
            series,
        },
    }
}

fn twice_pi() -> Entry {
    let right = |albedo: f64| albedo;
    let noted = |albedo: f64| albedo / PI;
    let xs = || (0..=100).map(|i| i as f64 / 100.0);
    let (max, rms) = error(xs().map(|a| (noted(a), right(a))));
    let series = vec![
        Series::new("right", 0, xs().map(|a| [a, right(a)]).collect()),
        Series::new("noted", 1, xs().map(|a| [a, noted(a)]).collect()).dashed(),
    ];
    Entry {
        title: "Indirect diffuse light divided by π twice",
        fault: "ShadeSH9 returns irradiance already divided by π (the coefficients are convolved with cos θ / π); the \
                helmet's shader divides once more. Under even light a white surface then shows 0.318 of it.",
        noted: "Diffuse = ShadeSH9(N) · BaseColor · Kd / π",
        right: "Diffuse = ShadeSH9(N) · BaseColor · Kd        (ShadeSH9 = E / π)",
        source: "Ramamoorthi, Hanrahan 2001, An Efficient Representation for Irradiance Environment Maps",
        measure: "radiance under even light of radiance 1, base colour 0..1 and Kd = 1",
        max,
        rms,
        chart: Chart {
            title: "radiance under even light of radiance 1".into(),
            x: Axis::linear("base colour", 0.0, 1.0),
            y: Axis::linear("radiance", 0.0, 1.05),
            series,
        },
    }
}
