//! Derives the table of metals from measured spectra, and prints the chart of reflectances.
//!
//! ```text
//! cargo run --release -p etendue-bxdf --example ior_table -- DIRECTORY          # prints the chart
//! cargo run --release -p etendue-bxdf --example ior_table -- DIRECTORY --write  # and rewrites src/ior_metals.rs
//! ```
//!
//! DIRECTORY holds `refractiveindex-info/main/{Ag,Al,Au,Cu,Fe,Ti}/nk/*.yml` of the public-domain database
//! refractiveindex.info, and `colour-science/{cmf_cie1931_2deg,illum_D65}.csv`; without it, the example says so and ends.
//!
//! For each metal: the exact Fresnel reflectance at each nanometre of 380..780, seen by the CIE 1931 2° observer under
//! D65, as linear Rec.709 relative to a perfect reflector; at normal incidence (F0) and at cos θ = 1/7 (F82). Then for
//! each channel the η and k that have this F0 and come nearest to this F82.

mod spectra;

use etendue_bxdf::{
    conductor::{Conductor, conductor, k_from_f0},
    f82::{F82_COS, F82Tint},
    fresnel::{Schlick, dielectric, f0_from_ior},
    ior_table::DIELECTRICS,
};
use etendue_color::Spectrum;
use spectra::{Rows, SPECTRA, Source};
use std::{fmt::Write, fs, path::Path};

type Failure = Box<dyn std::error::Error>;

/// Nanometres that are summed over.
const VISIBLE: core::ops::RangeInclusive<u32> = 380..=780;

/// The linear value at `x` between rows sorted by their first column; the end rows go on beyond the ends.
fn interpolate<const N: usize>(rows: &[[f64; N]], x: f64) -> [f64; N] {
    let after = rows.partition_point(|r| r[0] < x).clamp(1, rows.len() - 1);
    let (a, b) = (&rows[after - 1], &rows[after]);
    let t = ((x - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
    core::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Rows of numbers between commas, after a line of names.
fn csv<const N: usize>(path: &Path) -> Result<Vec<[f64; N]>, Failure> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut rows = Vec::new();
    for line in text.lines().skip(1) {
        let mut row = [0.0; N];
        for (v, t) in row.iter_mut().zip(line.split(',')) {
            *v = t.trim().parse()?;
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Rows of wavelength in micrometres, n and k: the indented lines of three numbers.
fn yaml_rows(path: &Path) -> Result<Vec<[f64; 3]>, Failure> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let rows: Vec<[f64; 3]> = text
        .lines()
        .filter_map(|line| {
            let v: Vec<f64> = line.split_whitespace().map(|t| t.parse().ok()).collect::<Option<_>>()?;
            v.try_into().ok()
        })
        .collect();
    if rows.len() < 2 { Err(format!("{}: no table of n and k", path.display()).into()) } else { Ok(rows) }
}

/// How a reflectance spectrum looks: weights of each nanometre for linear Rec.709, such that a perfect reflector is white.
struct Observer(Vec<[f64; 3]>);

impl Observer {
    fn new(directory: &Path) -> Result<Self, Failure> {
        let cmf: Vec<[f64; 4]> = csv(&directory.join("colour-science/cmf_cie1931_2deg.csv"))?;
        let d65: Vec<[f64; 2]> = csv(&directory.join("colour-science/illum_D65.csv"))?;
        // XYZ to linear Rec.709 (ITU-R BT.709-6 primaries, D65).
        const M: [[f64; 3]; 3] = [
            [3.2409699419, -1.5373831776, -0.4986107603],
            [-0.9692436363, 1.8759675015, 0.0415550574],
            [0.0556300797, -0.2039769589, 1.0569715142],
        ];
        let mut weights: Vec<[f64; 3]> = VISIBLE
            .map(|nm| {
                let light = interpolate(&d65, nm as f64)[1];
                let [_, x, y, z] = interpolate(&cmf, nm as f64);
                M.map(|m| light * (m[0] * x + m[1] * y + m[2] * z))
            })
            .collect();
        let white: [f64; 3] = core::array::from_fn(|i| weights.iter().map(|w| w[i]).sum());
        weights.iter_mut().for_each(|w| *w = core::array::from_fn(|i| w[i] / white[i]));
        Ok(Self(weights))
    }

    /// Linear Rec.709 of a metal's reflectance at an angle.
    fn see(&self, rows: &[[f64; 3]], cos: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (nm, w) in VISIBLE.zip(&self.0) {
            let [_, n, k] = interpolate(rows, nm as f64 * 1e-3);
            let r = conductor(cos as f32, n as f32, k as f32) as f64;
            (0..3).for_each(|i| sum[i] += w[i] * r);
        }
        sum
    }
}

/// The η and k with reflectance `f0` at normal incidence, and nearest to `f82` at cos θ = 1/7: the k is exact for each
/// η, and η is searched between the two that need no k.
fn effective(f0: f64, f82: f64) -> (f64, f64) {
    // Above this no k of a metal is left: copper's or gold's red may exceed it by being outside of Rec.709.
    let f0 = f0.min(0.995);
    let root = f0.sqrt();
    let (low, high) = ((1.0 - root) / (1.0 + root), (1.0 + root) / (1.0 - root));
    let error = |eta: f64| {
        let k = k_from_f0(eta as f32, f0 as f32);
        (conductor(F82_COS, eta as f32, k) as f64 - f82).abs()
    };
    let mut best = (f64::INFINITY, low);
    let mut range = (low, high);
    for _ in 0..4 {
        let ratio = range.1 / range.0;
        for i in 0..=2000 {
            let eta = range.0 * ratio.powf(i as f64 / 2000.0);
            if error(eta) < best.0 {
                best = (error(eta), eta);
            }
        }
        let step = ratio.powf(2.0 / 2000.0);
        range = ((best.1 / step).max(low), (best.1 * step).min(high));
    }
    (best.1, k_from_f0(best.1 as f32, f0 as f32) as f64)
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let directory = arguments.next().ok_or("usage: ior_table DIRECTORY [--write]")?;
    let directory = Path::new(&directory);
    let write = arguments.next().as_deref() == Some("--write");
    let observer = Observer::new(directory)?;

    println!(
        "Metals: linear Rec.709 under D65, CIE 1931 2°; largest error over angles and channels of the three curves"
    );
    println!("{:<10} {:<23} {:<23} {:<23} {:<23} nk     F82    Schlick", "", "F0", "F82", "eta", "k");
    let mut source = String::from(
        "//! Metals: made by the example `ior_table`, not by hand.\n\nuse super::ior_table::Metal;\n\n\
         /// Linear Rec.709 under D65 of measured spectra; see [`super::ior_table`].\n\
         pub const METALS: &[Metal] = &[\n",
    );
    for Source { name, symbol, citation, rows } in SPECTRA {
        let rows = match rows {
            Rows::File(file) => yaml_rows(&directory.join("refractiveindex-info/main").join(file))?,
            Rows::Here(rows) => rows.to_vec(),
        };
        let (f0, f82) = (observer.see(&rows, 1.0), observer.see(&rows, F82_COS as f64));
        let seen = f0;
        // The primaries of Rec.709 cannot show every metal: a channel above 1 is held there.
        let (f0, f82) = (f0.map(|v| v.clamp(0.0, 1.0)), f82.map(|v| v.clamp(0.0, 1.0)));
        let nk: [(f64, f64); 3] = core::array::from_fn(|i| effective(f0[i], f82[i]));
        let (eta, k) = (nk.map(|v| v.0), nk.map(|v| v.1));
        let rgb = |v: [f64; 3]| Spectrum::from_rgb(v.map(|v| v as f32));
        let exact = Conductor::new(rgb(eta), rgb(k));
        let tint = F82Tint::from_f82(rgb(f0), rgb(f82));
        let schlick = Schlick { f0: rgb(f0), f90: Spectrum::ONE };
        let mut errors = [0.0f64; 3];
        for i in 0..=90 {
            let cos = (i as f64).to_radians().cos();
            let seen = observer.see(&rows, cos);
            for (e, v) in errors.iter_mut().zip([
                exact.eval(cos as f32),
                tint.eval(cos as f32),
                schlick.eval(cos as f32),
            ]) {
                (0..3).for_each(|c| *e = e.max((v[c] as f64 - seen[c]).abs()));
            }
        }
        let show = |v: [f64; 3]| format!("{:.4} {:.4} {:.4}", v[0], v[1], v[2]);
        println!(
            "{name:<10} {:<23} {:<23} {:<23} {:<23} {:.4} {:.4} {:.4}",
            show(seen),
            show(f82),
            show(eta),
            show(k),
            errors[0],
            errors[1],
            errors[2]
        );
        let list = |v: [f64; 3]| format!("[{:.4}, {:.4}, {:.4}]", v[0], v[1], v[2]);
        write!(
            source,
            "    Metal {{\n        name: {name:?},\n        symbol: {symbol:?},\n        f0: {},\n        f82: {},\n        eta: {},\n        k: {},\n        source: {citation:?},\n    }},\n",
            list(f0),
            list(f82),
            list(eta),
            list(k)
        )?;
    }
    source.push_str("];\n");

    println!(
        "\nDielectrics: index at 589 nm, reflectance at normal incidence and at cos θ = 1/7, Abbe number"
    );
    for d in DIELECTRICS {
        let abbe = d.abbe.map_or("-".into(), |v| format!("{v:.1}"));
        println!(
            "{:<14} {:.4} {:.4} {:.4} {abbe:>5}  {}",
            d.name,
            d.ior,
            f0_from_ior(d.ior),
            dielectric(F82_COS, d.ior),
            d.source
        );
    }
    println!("\nFrom Sellmeier's formula: n at 486.1, 587.6, 589.3, 656.3 nm and Abbe number");
    for (name, constant, terms) in spectra::SELLMEIER {
        let n = |nm: f64| spectra::sellmeier(*constant, terms, nm * 1e-3);
        let abbe = (n(587.56) - 1.0) / (n(486.13) - n(656.27));
        println!("{name:<14} {:.5} {:.5} {:.5} {:.5} {abbe:.2}", n(486.13), n(587.56), n(589.29), n(656.27));
    }
    if write {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/ior_metals.rs");
        fs::write(&path, source)?;
        println!("\nwrote {}", path.display());
    }
    Ok(())
}
