//! The split sum.

use super::{Entry, error};
use crate::draw::{Axis, Chart, Series};
use etendue_bxdf::{GgxReflection, Schlick, quadrature::directional_albedo};
use etendue_color::Spectrum;
use glam::vec3a;

pub(super) fn entries() -> Vec<Entry> {
    vec![fresnel_twice(), fit()]
}

/// Scale and bias of F0 under even light, by quadrature of the GGX lobe: albedo = F0 · A + B.
fn scale_bias(roughness: f64, cos: f64) -> [f64; 2] {
    let alpha = (roughness * roughness) as f32;
    let wo = vec3a((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32);
    let of = |f0: f32| {
        let f = Schlick { f0: Spectrum::splat(f0), f90: Spectrum::ONE };
        directional_albedo(&GgxReflection::new(alpha, alpha, f), wo)[0] as f64
    };
    let b = of(0.0);
    [of(1.0) - b, b]
}

/// Schlick's form for image-based light: toward max(1 − roughness, F0) instead of 1.
fn rough_fresnel(f0: f64, roughness: f64, cos: f64) -> f64 {
    f0 + ((1.0 - roughness).max(f0) - f0) * (1.0 - cos).powi(5)
}

fn cosines() -> Vec<f64> {
    (0..=24).map(|i| 0.02 + 0.98 * i as f64 / 24.0).collect()
}

fn fresnel_twice() -> Entry {
    let f0 = 0.04;
    let mut series = Vec::new();
    let mut pairs = Vec::new();
    for (i, roughness) in [0.1, 0.4, 0.8].into_iter().enumerate() {
        let values: Vec<(f64, f64, f64)> = cosines()
            .into_iter()
            .map(|c| {
                let [a, b] = scale_bias(roughness, c);
                (c, f0 * a + b, rough_fresnel(f0, roughness, c) * a + b)
            })
            .collect();
        pairs.extend(values.iter().map(|(_, right, noted)| (*noted, *right)));
        let right = values.iter().map(|(c, v, _)| [*c, *v]).collect();
        let noted = values.iter().map(|(c, _, v)| [*c, *v]).collect();
        series.push(Series::new(format!("roughness {roughness}, right"), i, right));
        series.push(Series::new("noted", i, noted).dashed());
    }
    let (max, rms) = error(pairs.into_iter());
    Entry {
        title: "Fresnel counted twice in the split sum",
        fault: "The second sum's scale and bias already hold Fresnel's rise toward grazing angles: what they multiply is F0. \
                The notes put the rough Fresnel of the view's angle there, so that it counts twice and edges are too \
                bright.",
        noted: "Specular = prefiltered · (F_SchlickRoughness(n·v, F0, roughness) · A + B)",
        right: "Specular = prefiltered · (F0 · A + B)",
        source: "Karis 2013, Real Shading in Unreal Engine 4, section “Environment BRDF”; A and B here by quadrature",
        measure: "albedo under even light, F0 = 0.04; roughness 0.1, 0.4, 0.8, n·v 0.02..1",
        max,
        rms,
        chart: Chart {
            title: "reflected part of even light, F0 = 0.04".into(),
            x: Axis::linear("n·v", 0.0, 1.0),
            y: Axis::linear("albedo", 0.0, 1.05 * Chart::top(&series)),
            series,
        },
    }
}

fn fit() -> Entry {
    // The polynomial fit of the helmet's shader (Karis 2014, after Lazarov 2013).
    let noted = |roughness: f64, cos: f64| {
        let r = [
            1.0 - roughness,
            0.0425 - 0.0275 * roughness,
            1.04 - 0.572 * roughness,
            -0.04 + 0.022 * roughness,
        ];
        let a004 = (r[0] * r[0]).min((-9.28 * cos).exp2()) * r[0] + r[1];
        [-1.04 * a004 + r[2], 1.04 * a004 + r[3]]
    };
    let mut series = Vec::new();
    let mut pairs = Vec::new();
    for (i, roughness) in [0.1, 0.4, 0.8].into_iter().enumerate() {
        let (mut right_line, mut noted_line) = (Vec::new(), Vec::new());
        for c in cosines() {
            let ([a, b], [fa, fb]) = (scale_bias(roughness, c), noted(roughness, c));
            for f0 in [0.04, 1.0] {
                pairs.push((f0 * fa + fb, f0 * a + b));
            }
            right_line.push([c, 0.04 * a + b]);
            noted_line.push([c, 0.04 * fa + fb]);
        }
        series.push(Series::new(format!("roughness {roughness}, integral"), i, right_line));
        series.push(Series::new("fit", i, noted_line).dashed());
    }
    let (max, rms) = error(pairs.into_iter());
    Entry {
        title: "The analytic fit of scale and bias",
        fault: "No mistake: the fit that the notes use in place of the table, and the price of it. It was made for \
                Schlick-GGX masking with k = α/2, not for Smith's.",
        noted: "a004 = min((1 − r)², 2^(−9.28 n·v)) (1 − r) + 0.0425 − 0.0275 r\nA = −1.04 a004 + 1.04 − 0.572 r,   \
                B = 1.04 a004 − 0.04 + 0.022 r",
        right: "A, B by quadrature of the GGX lobe with height-correlated Smith masking",
        source: "Karis 2014, Physically Based Shading on Mobile, after Lazarov 2013",
        measure: "albedo under even light, F0 = 0.04 and 1; roughness 0.1, 0.4, 0.8, n·v 0.02..1",
        max,
        rms,
        chart: Chart {
            title: "reflected part of even light, F0 = 0.04".into(),
            x: Axis::linear("n·v", 0.0, 1.0),
            y: Axis::linear("albedo", 0.0, 1.05 * Chart::top(&series)),
            series,
        },
    }
}
