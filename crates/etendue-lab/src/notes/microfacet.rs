//! Distribution and masking.

use super::{Entry, error};
use crate::draw::{Axis, Chart, Series};
use core::f64::consts::PI;
use etendue_bxdf::quadrature::gauss_legendre;

pub(super) fn entries() -> Vec<Entry> {
    vec![lambda(), factor(), clamp(), schlick_ggx()]
}

fn angles() -> impl Iterator<Item = f64> + Clone {
    (0..=178).map(|i| i as f64 * 0.5)
}

/// Smith's G1 for GGX.
fn g1(alpha: f64, degrees: f64) -> f64 {
    let tan = degrees.to_radians().tan();
    1.0 / (1.0 + 0.5 * ((1.0 + alpha * alpha * tan * tan).sqrt() - 1.0))
}

fn lambda() -> Entry {
    let noted = |alpha: f64| 1.0 / (1.0 + 0.5 * (1.0 + 1.0 / alpha).sqrt());
    let mut series = Vec::new();
    for (i, alpha) in [0.05, 0.25, 1.0].into_iter().enumerate() {
        series.push(Series::new(
            format!("α = {alpha}, right"),
            i,
            angles().map(|a| [a, g1(alpha, a)]).collect(),
        ));
        series.push(Series::new("noted", i, angles().map(|a| [a, noted(alpha)]).collect()).dashed());
    }
    let grid = (1..=20).flat_map(|k| angles().step_by(4).map(move |a| (k as f64 / 20.0, a)));
    let (max, rms) = error(grid.map(|(alpha, a)| (noted(alpha), g1(alpha, a))));
    Entry {
        title: "Smith's Λ without its tangent",
        fault: "The isotropic Λ has lost the tangent of the angle, the square of α and the −1: it does not depend on the \
                direction, and even along the normal hides more than half of all facets. (The anisotropic form beside it \
                in the notes is right.)",
        noted: "Λ(ω) = √(1 + 1/α) / 2",
        right: "Λ(ω) = (√(1 + α² tan²θ) − 1) / 2",
        source: "Heitz 2014, Understanding the Masking-Shadowing Function, eq. 72 and 86",
        measure: "G1 = 1/(1 + Λ); α 0.05..1, angle 0..88°",
        max,
        rms,
        chart: Chart {
            title: "G1: the visible part of the facets".into(),
            x: Axis::linear("angle to the normal, degrees", 0.0, 90.0),
            y: Axis::linear("G1", 0.0, 1.05),
            series,
        },
    }
}

/// ∫ D cos over the hemisphere for GGX times a factor.
fn projected_area(alpha: f64, factor: f64) -> f64 {
    let a2 = alpha * alpha;
    let nodes = gauss_legendre(16);
    let mut sum = 0.0;
    // u = sin²θ: D cos dω = π D du; panels halve towards 0, where the lobe is.
    for k in 0..24 {
        let (low, high) = (if k == 23 { 0.0 } else { 0.5f64.powi(k + 1) }, 0.5f64.powi(k));
        for &(x, w) in &nodes {
            let u = low + (high - low) * x;
            let q = (1.0 - u) * (a2 - 1.0) + 1.0;
            sum += w * (high - low) * PI * factor * a2 / (PI * q * q);
        }
    }
    sum
}

fn factor() -> Entry {
    let k = |alpha: f64| {
        let a2 = alpha * alpha;
        if alpha >= 1.0 { 1.0 / PI } else { (a2 - 1.0) / a2.ln() }
    };
    let xs = || (1..=99).map(|i| i as f64 / 100.0);
    let series = vec![
        Series::new("right", 0, xs().map(|a| [a, projected_area(a, 1.0)]).collect()),
        Series::new("noted", 1, xs().map(|a| [a, projected_area(a, k(a))]).collect()).dashed(),
    ];
    let (max, rms) = error(xs().map(|a| (projected_area(a, k(a)), projected_area(a, 1.0))));
    Entry {
        title: "GGX with the factor of another distribution",
        fault: "The factor k(α) normalises GTR with γ = 1, the clearcoat's distribution, whose denominator is not squared. \
                GGX (γ = 2) is normalised as it stands; with the factor its facets do not cover the surface, and a \
                smooth highlight loses nine tenths of its light.",
        noted: "D = k(α) α² / (π (1 + (n·h)²(α² − 1))²)\nk = 1/π if α ≥ 1, (α² − 1)/ln α² otherwise",
        right: "D = α² / (π (1 + (n·h)²(α² − 1))²)",
        source: "Burley 2012, appendix B, eq. 4 and 8; Walter et al. 2007, eq. 33",
        measure: "∫ D(m) (n·m) dm, which must be 1; α 0.01..0.99",
        max,
        rms,
        chart: Chart {
            title: "projected area of the facets".into(),
            x: Axis::linear("α", 0.0, 1.0),
            y: Axis::linear("∫ D cos", 0.0, 1.1),
            series,
        },
    }
}

fn clamp() -> Entry {
    // At the peak n·h = 1: the denominator is π α⁴.
    let right = |r: f64| 1.0 / (PI * r.powi(4));
    let noted = |r: f64| {
        let a2 = r.powi(4);
        a2 / (PI * a2 * a2).max(1e-5)
    };
    let xs = || (20..=1000).map(|i| i as f64 / 1000.0);
    let (max, rms) = error(xs().map(|r| (noted(r) / right(r), 1.0)));
    let series = vec![
        Series::new("right", 0, xs().map(|r| [r, right(r)]).collect()),
        Series::new("noted", 1, xs().map(|r| [r, noted(r)]).collect()).dashed(),
    ];
    Entry {
        title: "Distribution with a clamped denominator",
        fault: "max(0.00001, …) guards against division by zero, but the denominator at the peak is π α⁴ and falls below \
                that for every roughness under 0.206: smooth highlights vanish instead of growing sharp. The true value \
                is finite for every roughness above 0.",
        noted: "D = α² / max(0.00001, π ((n·h)²(α² − 1) + 1)²),   α = roughness²",
        right: "D = α² / (π ((n·h)²(α² − 1) + 1)²)",
        source: "Walter et al. 2007, eq. 33",
        measure: "relative error at the peak of the highlight; roughness 0.02..1",
        max,
        rms,
        chart: Chart {
            title: "D at n·h = 1".into(),
            x: Axis::linear("roughness", 0.0, 1.0),
            y: Axis::log("D, 1/sr", 0.1, 1e7),
            series,
        },
    }
}

fn schlick_ggx() -> Entry {
    let noted = |r: f64, a: f64| {
        let k = (r + 1.0) * (r + 1.0) / 8.0;
        let c = a.to_radians().cos();
        c / (c * (1.0 - k) + k)
    };
    let mut series = Vec::new();
    for (i, r) in [0.0, 0.5, 1.0].into_iter().enumerate() {
        series.push(Series::new(
            format!("roughness {r}, Smith"),
            i,
            angles().map(|a| [a, g1(r * r, a)]).collect(),
        ));
        series.push(Series::new("noted", i, angles().map(|a| [a, noted(r, a)]).collect()).dashed());
    }
    let grid = (0..=20).flat_map(|k| angles().step_by(4).map(move |a| (k as f64 / 20.0, a)));
    let (max, rms) = error(grid.map(|(r, a)| (noted(r, a), g1(r * r, a))));
    Entry {
        title: "Direct light's Schlick-GGX masking",
        fault: "No mistake, but an artistic change that is often taken for one of physics: k = (r + 1)²/8 was chosen to \
                soften highlights of point lights. A perfect mirror (r = 0) hides facets under it. Image-based light \
                uses k = α/2.",
        noted: "G1 = n·v / (n·v (1 − k) + k),   k = (roughness + 1)² / 8",
        right: "G1 = 1 / (1 + Λ),   Λ = (√(1 + α² tan²θ) − 1) / 2,   α = roughness²",
        source: "Karis 2013, Real Shading in Unreal Engine 4; Heitz 2014",
        measure: "G1; roughness 0..1, angle 0..88°",
        max,
        rms,
        chart: Chart {
            title: "G1: the visible part of the facets".into(),
            x: Axis::linear("angle to the normal, degrees", 0.0, 90.0),
            y: Axis::linear("G1", 0.0, 1.05),
            series,
        },
    }
}
