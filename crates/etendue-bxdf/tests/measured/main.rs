//! Laws of measured materials: a table made from a known function gives that function back, samples have the density that is
//! said, and no bytes make the reader panic.

mod files;

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use etendue_bxdf::{
    Bsdf,
    laws::{Rng, chi2::chi2, furnace::furnace, grid::wo_at, sampling::samples, sidak},
    measured::{Measured, MeasuredError},
    sampling::{cosine_hemisphere, uniform_hemisphere},
};
use etendue_color::Spectrum;
use files::{
    ANISOTROPIC, Array, ISOTROPIC, Known, Layout, even, floats, isotropic, pbsdf_file, rgl_file, tensor_file,
};
use glam::{DVec3, Vec3A, dvec3};

fn spectralon() -> Option<Vec<u8>> {
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/spectral/spectralon_lowres.pbsdf");
    let bytes = std::fs::read(path).ok();
    if bytes.is_none() {
        println!("skipped: {path} is not there");
    }
    bytes
}

/// Root mean square and largest error of f cosθi, relative to its mean over the pairs, first lane.
fn compare(measured: &Measured, known: Known, lanes: usize) -> (f64, f64) {
    let mut rng = Rng::new(12);
    let (mut square, mut worst, mut mean, mut n) = (0.0, 0.0f64, 0.0, 0.0);
    for _ in 0..20_000 {
        let wo = uniform_hemisphere(rng.square());
        let wi = cosine_hemisphere(rng.square());
        if wo.z < 0.05 || wi.z < 0.05 {
            continue;
        }
        let got = measured.eval(wo, wi);
        let want = known.f(wo.as_dvec3(), wi.as_dvec3());
        for lane in 0..lanes {
            let error = (got[lane] as f64 - want[lane]) * wi.z as f64;
            square += error * error;
            worst = worst.max(error.abs());
            mean += want[lane] * wi.z as f64;
            n += 1.0;
        }
    }
    (f64::sqrt(square / n) / (mean / n), worst / (mean / n))
}

#[test]
fn a_table_of_a_known_function_gives_it_back() {
    let measured = Measured::from_bytes(&rgl_file(&isotropic())).expect("well-formed");
    assert!(measured.is_isotropic());
    assert_eq!(measured.description(), "a known function");
    let (rms, worst) = compare(&measured, ISOTROPIC, 3);
    println!("isotropic: rms {rms:.4}, worst {worst:.3}");
    assert!(rms < 0.02 && worst < 0.3);
    let alpha = measured.narrowest_alpha()[0];
    assert!((0.3..0.7).contains(&alpha), "the lobe's width is seen: {alpha}");

    // The whole turn, and a quarter of it for a material with two mirror planes.
    for (phi, folded) in [(even(17, -PI, PI), false), (even(5, -PI, -FRAC_PI_2), true)] {
        let theta = even(8, 0.0, 85f64.to_radians());
        let l = Layout { known: ANISOTROPIC, phi, theta, vndf: [32, 32], side: 20, spectral: false };
        let measured = Measured::from_bytes(&rgl_file(&l)).expect("well-formed");
        assert!(!measured.is_isotropic());
        let (rms, worst) = compare(&measured, ANISOTROPIC, 3);
        println!("anisotropic, folded {folded}: rms {rms:.4}, worst {worst:.3}");
        assert!(rms < 0.06 && worst < 1.0);
    }
}

#[test]
fn spectra_become_colours() {
    let measured =
        Measured::from_bytes(&rgl_file(&Layout { spectral: true, ..isotropic() })).expect("well-formed");
    let grey = Known { base: [ISOTROPIC.base[0]; 3], ..ISOTROPIC };
    let (rms, _) = compare(&measured, grey, 3);
    assert!(rms < 0.02, "an even spectrum is grey: {rms}");
}

#[test]
fn polarised_tables_give_their_intensity() {
    for with_angles in [true, false] {
        let file = pbsdf_file(ISOTROPIC, [37, 31, 46], with_angles);
        let measured = Measured::from_bytes(&file).expect("well-formed");
        let grey = Known { base: [ISOTROPIC.base[0]; 3], ..ISOTROPIC };
        let (rms, worst) = compare(&measured, grey, 3);
        println!("polarised: rms {rms:.4}, worst {worst:.3}");
        assert!(rms < 0.01 && worst < 0.05);
    }
    // The side of φd: light that comes in steeper than it leaves must not be taken for the other way round.
    let (np, nd, nh) = (5, 3, 3);
    let mut m = vec![0.0; np * nd * nh * 16];
    for i in 0..np {
        for j in 0..nd * nh {
            // φd = ±π in the table is where wi lies nearer to the normal than the half vector.
            m[(i * nd * nh + j) * 16] = if i == 0 || i == np - 1 { 1.0 } else { 0.0 };
        }
    }
    let empty = |name, n: usize| Array { name, kind: 10, shape: vec![0, n as u64], bytes: Vec::new() };
    let file = tensor_file(&[
        empty("phi_d", np),
        empty("theta_d", nd),
        empty("theta_h", nh),
        Array { name: "wvls", kind: 3, shape: vec![1], bytes: 550u16.to_le_bytes().to_vec() },
        floats("M", &[np, nd, nh, 1, 4, 4], &m),
    ]);
    let measured = Measured::from_bytes(&file).expect("well-formed");
    let (steep, low) = (wo_at(10.0), wo_at(60.0));
    assert!(measured.eval(low, steep)[0] > 0.9 && measured.eval(steep, low)[0] < 0.1);
}

fn subjects() -> Vec<(&'static str, Measured)> {
    let mut out = vec![
        ("adaptive", Measured::from_bytes(&rgl_file(&isotropic())).expect("well-formed")),
        ("polarised", Measured::from_bytes(&pbsdf_file(ISOTROPIC, [37, 31, 46], true)).expect("well-formed")),
    ];
    if let Some(bytes) = spectralon() {
        out.push(("spectralon", Measured::from_bytes(&bytes).expect("a file of the data set")));
    }
    out
}

#[test]
fn samples_have_the_density_that_is_said() {
    let full = std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1");
    let n = if full { 1_000_000 } else { 40_000 };
    let subjects = subjects();
    let angles = [0.0, 30.0, 60.0, 80.0];
    let level = sidak(0.01, subjects.len() * angles.len());
    for (name, measured) in &subjects {
        for (i, angle) in angles.into_iter().enumerate() {
            let wo = wo_at(angle);
            let t = chi2(&measured, wo, n, 40 + i as u64);
            println!(
                "{name} {angle}°: χ² {:.1} of {}, p {:.3}, ∫ pdf {:.4}",
                t.statistic, t.dof, t.p, t.pdf_integral
            );
            assert!(t.p > level, "{name} {angle}°: {t:?}");
            let s = samples(&measured, wo, 5_000, 3);
            assert!(!s.broken && s.weight_error < 1e-4 && s.pdf_error < 1e-4, "{name} {angle}°: {s:?}");
            let f = furnace(&measured, wo, n / 4, 5);
            println!("   albedo {:?}, claimed {:?}, variance {:?}", f.albedo, f.claimed, f.variance);
            // Tables have kinks, which the quadrature does not know of: 0.5 % are let in.
            let difference = (f.sampled - f.albedo).map(f32::abs) - (f.error * 4.0 + f.albedo * 0.005);
            assert!(difference.max_element() <= 0.0, "{name} {angle}°: {f:?}");
            let claimed = (f.claimed - f.albedo).map(f32::abs).max_element();
            assert!(claimed < 0.04 * f.albedo.max_element().max(0.1), "{name} {angle}°: {f:?}");
        }
    }
}

#[test]
fn spectralon_is_white_and_nearly_matt() {
    let Some(bytes) = spectralon() else { return };
    let measured = Measured::from_bytes(&bytes).expect("a file of the data set");
    let [r, g, b] = measured.albedo(wo_at(30.0)).to_rgb();
    println!("albedo {r} {g} {b}");
    assert!((r / g - 1.0).abs() < 0.1 && (b / g - 1.0).abs() < 0.1);
    assert!(measured.narrowest_alpha()[0] > 0.5);
    // M00 for a pair on the grid, taken from the file's bytes: θh = θd = 22.5°, φd = 10 · 360°/21 − 180°.
    let (td, th) = (22.5f64.to_radians(), 22.5f64.to_radians());
    let pd = (10.0 * 360.0 / 21.0 - 180.0f64).to_radians();
    let h = dvec3(th.sin(), 0.0, th.cos());
    let t = dvec3(th.cos(), 0.0, -th.sin());
    let wi = h * td.cos() + (t * pd.cos() + DVec3::Y * pd.sin()) * td.sin();
    let wo = h * (2.0 * wi.dot(h)) - wi;
    let data = bytes.len() - 22 * 9 * 9 * 5 * 16 * 4;
    let band = |k: usize| {
        let at = data + ((((10 * 9 + 2) * 9 + 2) * 5 + k) * 16) * 4;
        f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    };
    let f = measured.eval(wo.as_vec3a(), wi.as_vec3a());
    let (low, high) = (0..5).map(band).fold((f32::MAX, 0.0f32), |(l, h), v| (l.min(v), h.max(v)));
    assert!(f[1] > 0.97 * low && f[1] < 1.03 * high, "{f:?} {low} {high}");
}

/// Whatever happened to a file: an error or a material that answers with numbers.
fn survive(bytes: &[u8], rng: &mut Rng) -> Result<(), MeasuredError> {
    let measured = Measured::from_bytes(bytes)?;
    for _ in 0..20 {
        let (wo, wi) = (uniform_hemisphere(rng.square()), uniform_hemisphere(rng.square()));
        let e = measured.eval_pdf(wo, wi);
        assert!(e.value().is_finite() && e.pdf.is_finite() && e.pdf >= 0.0);
        assert!(e.value().0.iter().all(|v| *v >= 0.0));
        if let Some(s) = measured.sample(wo, rng.uniform(), rng.square()) {
            assert!(s.weight.is_finite() && s.pdf > 0.0);
        }
        assert!(measured.albedo(wo).is_finite());
    }
    Ok(())
}

#[test]
fn no_bytes_panic() {
    let small = Layout { theta: even(3, 0.0, 1.5), vndf: [6, 5], side: 4, ..isotropic() };
    let files = [rgl_file(&small), pbsdf_file(ISOTROPIC, [5, 4, 4], true)];
    let mut rng = Rng::new(77);
    for file in &files {
        assert!(survive(file, &mut rng).is_ok());
        for end in (0..file.len()).filter(|&n| n < 900 || n % 211 == 0) {
            assert!(survive(&file[..end], &mut rng).is_err(), "cut at {end}");
        }
        let mut read = 0;
        for i in 0..250 {
            let mut broken = file.clone();
            // Mostly the directory, where most can go wrong.
            let range = if i % 3 == 0 { broken.len() } else { 700.min(broken.len()) };
            for _ in 0..1 + i % 3 {
                let at = (rng.bits() % range as u64) as usize;
                broken[at] ^= 1 << (rng.bits() % 8);
            }
            read += survive(&broken, &mut rng).is_ok() as usize;
        }
        println!("{read} of 250 damaged files were read");
    }
    // Numbers that fill the largest sizes.
    let mut huge = files[0].clone();
    huge[18 + 2 + 11 + 2 + 1..][..8].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(survive(&huge, &mut rng).is_err());
    assert_eq!(survive(b"", &mut rng), Err(MeasuredError::NotATensorFile));
    assert_eq!(
        survive(b"tensor_file\0\x02\x00", &mut rng),
        Err(MeasuredError::Version { major: 2, minor: 0 })
    );
}

#[test]
fn odd_directions_give_nothing() {
    for (name, measured) in subjects() {
        let odd = [f32::NAN, f32::INFINITY, 0.0, 1e-7, -0.5];
        for z in odd {
            let bad = Vec3A::new(0.6, 0.0, z);
            assert_eq!(measured.eval(bad, Vec3A::Z), Spectrum::ZERO, "{name} {z}");
            assert_eq!(measured.eval(Vec3A::Z, bad), Spectrum::ZERO, "{name} {z}");
            assert!(measured.sample(bad, 0.5, [0.5; 2]).is_none() && measured.albedo(bad) == Spectrum::ZERO);
        }
        for angle in [0.0, 45.0, 89.99] {
            for u in [[0.0, 0.0], [1.0, 1.0], [f32::NAN, 0.5], [0.5, f32::INFINITY]] {
                if let Some(s) = measured.sample(wo_at(angle), u[0], u) {
                    assert!(s.weight.is_finite() && s.pdf.is_finite(), "{name}");
                }
            }
        }
        // At the normal and in retro-reflection the angles are degenerate.
        assert!(measured.eval(Vec3A::Z, Vec3A::Z).max_element() > 0.01, "{name}");
        let w = wo_at(TAU.to_degrees() as f32 / 10.0);
        assert!(measured.eval(w, w).is_finite());
    }
}
