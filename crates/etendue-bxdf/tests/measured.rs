//! Laws of measured materials: a table made from a known function gives that function back, samples have the density that is
//! said, and no bytes make the reader panic.

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use etendue_bxdf::{
    Bsdf,
    laws::{Rng, chi2::chi2, furnace::furnace, grid::wo_at, sampling::samples, sidak},
    measured::{Measured, MeasuredError},
    sampling::{cosine_hemisphere, uniform_hemisphere},
};
use etendue_color::Spectrum;
use glam::{DVec3, Vec3A, dvec3};

/// A field of a tensor file, as its writer needs it.
struct Array {
    name: &'static str,
    kind: u8,
    shape: Vec<u64>,
    bytes: Vec<u8>,
}

fn floats(name: &'static str, shape: &[usize], values: &[f64]) -> Array {
    assert_eq!(shape.iter().product::<usize>(), values.len(), "{name}");
    let bytes = values.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect();
    Array { name, kind: 10, shape: shape.iter().map(|&n| n as u64).collect(), bytes }
}

fn bytes(name: &'static str, values: &[u8]) -> Array {
    Array { name, kind: 1, shape: vec![values.len() as u64], bytes: values.to_vec() }
}

fn tensor_file(arrays: &[Array]) -> Vec<u8> {
    let directory: usize =
        18 + arrays.iter().map(|a| 2 + a.name.len() + 2 + 1 + 8 + 8 * a.shape.len()).sum::<usize>();
    let mut out = b"tensor_file\0\x01\x00".to_vec();
    out.extend((arrays.len() as u32).to_le_bytes());
    let mut offset = directory;
    for a in arrays {
        out.extend((a.name.len() as u16).to_le_bytes());
        out.extend(a.name.as_bytes());
        out.extend((a.shape.len() as u16).to_le_bytes());
        out.push(a.kind);
        out.extend((offset as u64).to_le_bytes());
        a.shape.iter().for_each(|n| out.extend(n.to_le_bytes()));
        offset += a.bytes.len();
    }
    arrays.iter().for_each(|a| out.extend(&a.bytes));
    out
}

/// The known material: a matt base under a GGX-shaped gloss of α along x and y (without masking: nothing here needs it).
#[derive(Clone, Copy)]
struct Known {
    base: [f64; 3],
    gloss: f64,
    alpha: [f64; 2],
}

const ISOTROPIC: Known = Known { base: [0.24, 0.12, 0.06], gloss: 0.15, alpha: [0.35, 0.35] };
const ANISOTROPIC: Known = Known { base: [0.2, 0.2, 0.1], gloss: 0.15, alpha: [0.5, 0.3] };

impl Known {
    fn ndf(&self, m: DVec3) -> f64 {
        let [ax, ay] = self.alpha;
        let q = (m.x / ax).powi(2) + (m.y / ay).powi(2) + m.z * m.z;
        1.0 / (PI * ax * ay * q * q)
    }

    fn f(&self, wo: DVec3, wi: DVec3) -> [f64; 3] {
        let gloss = self.gloss * self.ndf((wo + wi).normalize());
        self.base.map(|b| b / PI + gloss)
    }
}

/// u = √(2θ/π), v = (φ + π)/2π.
fn half(u: f64, v: f64) -> DVec3 {
    let (theta, phi) = (u * u * FRAC_PI_2, (2.0 * v - 1.0) * PI);
    dvec3(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn node(i: usize, n: usize) -> f64 {
    i as f64 / (n - 1) as f64
}

/// A bilinear density on nodes in `f64`, sampled by bisection of its distribution functions: another way than the reader's.
struct Bilinear<'a> {
    width: usize,
    height: usize,
    values: &'a [f64],
    /// ∫₀ˣ along each row, at the nodes.
    rows: Vec<f64>,
    /// ∫₀ʸ of the rows, at the nodes.
    columns: Vec<f64>,
}

impl<'a> Bilinear<'a> {
    fn new(width: usize, height: usize, values: &'a [f64]) -> Self {
        let mut rows = Vec::new();
        for row in values.chunks_exact(width) {
            let mut sum = 0.0;
            rows.push(0.0);
            for w in row.windows(2) {
                sum += 0.5 * (w[0] + w[1]) / (width - 1) as f64;
                rows.push(sum);
            }
        }
        let mut columns = vec![0.0];
        for j in 1..height {
            let (low, high) = (rows[j * width - 1], rows[(j + 1) * width - 1]);
            columns.push(columns[j - 1] + 0.5 * (low + high) / (height - 1) as f64);
        }
        Self { width, height, values, rows, columns }
    }

    fn cell(n: usize, x: f64) -> (usize, f64) {
        let i = ((x * (n - 1) as f64) as usize).min(n - 2);
        (i, x * (n - 1) as f64 - i as f64)
    }

    fn mixed(&self, table: &[f64], i: usize, y: f64) -> f64 {
        let (j, t) = Self::cell(self.height, y);
        table[j * self.width + i] * (1.0 - t) + table[(j + 1) * self.width + i] * t
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        let (i, s) = Self::cell(self.width, x);
        self.mixed(self.values, i, y) * (1.0 - s) + self.mixed(self.values, i + 1, y) * s
    }

    fn along(&self, x: f64, y: f64) -> f64 {
        let (i, s) = Self::cell(self.width, x);
        let from = self.mixed(self.values, i, y);
        self.mixed(&self.rows, i, y) + 0.5 * s / (self.width - 1) as f64 * (from + self.at(x, y))
    }

    fn up(&self, y: f64) -> f64 {
        let (j, t) = Self::cell(self.height, y);
        let from = self.rows[(j + 1) * self.width - 1];
        self.columns[j] + 0.5 * t / (self.height - 1) as f64 * (from + self.along(1.0, y))
    }

    fn sample(&self, u: [f64; 2]) -> [f64; 2] {
        let bisect = |f: &dyn Fn(f64) -> f64, target: f64| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if f(middle) < target { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        let y = bisect(&|y| self.up(y), u[1] * self.up(1.0));
        let x = bisect(&|x| self.along(x, y), u[0] * self.along(1.0, y));
        [x, y]
    }
}

/// What the writer lays out, and at which resolution.
struct Layout {
    known: Known,
    /// Places of φo and θo.
    phi: Vec<f64>,
    theta: Vec<f64>,
    /// Nodes of the warp, along u and v.
    vndf: [usize; 2],
    /// Nodes of the values, along both.
    side: usize,
    /// With wavelengths instead of colours.
    spectral: bool,
}

/// The adaptive layout as Dupuy and Jakob 2018 describe it, from a known function.
fn rgl_file(l: &Layout) -> Vec<u8> {
    let ndf_size = [64, 33];
    let ndf: Vec<f64> = (0..ndf_size[0] * ndf_size[1])
        .map(|k| l.known.ndf(half(node(k % ndf_size[0], ndf_size[0]), node(k / ndf_size[0], ndf_size[1]))))
        .collect();
    let sigma: Vec<f64> = (0..32).map(|k| 0.2 + 0.8 * half(node(k % 16, 16), 0.0).z).collect();
    let ndf_at = Bilinear::new(ndf_size[0], ndf_size[1], &ndf);
    let sigma_at = Bilinear::new(16, 2, &sigma);
    let isotropic = l.phi.len() <= 2;
    let bands = if l.spectral { 4 } else { 3 };
    let [w, h] = l.vndf;
    let (mut vndf, mut luminance, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for &phi in &l.phi {
        for &theta in &l.theta {
            let phi = if isotropic { 0.0 } else { phi };
            let wo = dvec3(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let jacobian = |m: DVec3, u: f64| 2.0 * PI * PI * u * m.x.hypot(m.y);
            let slice: Vec<f64> = (0..w * h)
                .map(|k| {
                    let (u, v) = (node(k % w, w), node(k / w, h));
                    let m = half(u, v);
                    l.known.ndf(m) * wo.dot(m).max(0.0) * jacobian(m, u)
                })
                .collect();
            let warp = Bilinear::new(w, h, &slice);
            let total = warp.up(1.0);
            let u_wo = (theta / FRAC_PI_2).sqrt();
            let mut planes = vec![vec![0.0; l.side * l.side]; bands];
            for k in 0..l.side * l.side {
                let s = [node(k % l.side, l.side), node(k / l.side, l.side)];
                let at = warp.sample(s);
                let m = half(at[0], at[1]);
                let wi = m * (2.0 * wo.dot(m)) - wo;
                let scale = ndf_at.at(at[0], at[1]) / (4.0 * sigma_at.at(u_wo, 0.5));
                let f = l.known.f(wo, wi).map(|f| f * wi.z.max(0.0) / scale);
                for (b, plane) in planes.iter_mut().enumerate() {
                    // As a spectrum: grey of the first colour.
                    plane[k] = if l.spectral { f[0] } else { f[b] };
                }
                // What a sample weighs. At the rim of the square the density of the warp is zero: taken from a little within.
                let rim = 0.3 / (l.side - 1) as f64;
                let at = warp.sample(s.map(|s| s.clamp(rim, 1.0 - rim)));
                let m = half(at[0], at[1]);
                let wi = m * (2.0 * wo.dot(m)) - wo;
                let density =
                    warp.at(at[0], at[1]) / total / (jacobian(m, at[0]) * 4.0 * wo.dot(m)).max(1e-9);
                let f: f64 = l.known.f(wo, wi).iter().sum::<f64>() * wi.z.max(0.0);
                // A floor, so that no place is never drawn.
                luminance.push((f / density.max(1e-4)).clamp(0.02, 20.0));
            }
            vndf.extend(slice);
            values.extend(planes.concat());
        }
    }
    let (np, nt) = (l.phi.len(), l.theta.len());
    let mut arrays = vec![
        bytes("description", b"a known function"),
        floats("phi_i", &[np], &l.phi),
        floats("theta_i", &[nt], &l.theta),
        floats("ndf", &[ndf_size[1], ndf_size[0]], &ndf),
        floats("sigma", &[2, 16], &sigma),
        floats("vndf", &[np, nt, h, w], &vndf),
        floats("luminance", &[np, nt, l.side, l.side], &luminance),
        floats(if l.spectral { "spectra" } else { "rgb" }, &[np, nt, bands, l.side, l.side], &values),
        bytes("jacobian", &[1]),
    ];
    if l.spectral {
        arrays.push(floats("wavelengths", &[4], &[400.0, 500.0, 600.0, 700.0]));
    }
    tensor_file(&arrays)
}

fn even(n: usize, low: f64, high: f64) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * node(i, n)).collect()
}

fn isotropic() -> Layout {
    let theta = even(12, 0.0, 89f64.to_radians());
    Layout { known: ISOTROPIC, phi: vec![0.0], theta, vndf: [48, 24], side: 28, spectral: false }
}

/// The polarised layout from a known isotropic function; the other elements of a matrix are what must not be read.
fn pbsdf_file(known: Known, [np, nd, nh]: [usize; 3], with_angles: bool) -> Vec<u8> {
    let (phi, theta_d, theta_h) = (even(np, -PI, PI), even(nd, 0.0, FRAC_PI_2), even(nh, 0.0, FRAC_PI_2));
    let mut m = Vec::new();
    for &pd in &phi {
        for &td in &theta_d {
            for &th in &theta_h {
                let h = dvec3(th.sin(), 0.0, th.cos());
                let (b, t) = (DVec3::Y, dvec3(th.cos(), 0.0, -th.sin()));
                let wi = h * td.cos() + (t * pd.cos() + b * pd.sin()) * td.sin();
                let wo = h * (2.0 * wi.dot(h)) - wi;
                for _ in 0..5 {
                    // In the plane of the horizon the function goes on: a reader interpolates there.
                    m.push(known.f(wo, wi)[0]);
                    m.extend([7.0; 15]);
                }
            }
        }
    }
    let angles = |name, values: &[f64]| {
        if with_angles {
            floats(name, &[1, values.len()], values)
        } else {
            Array { name, kind: 10, shape: vec![0, values.len() as u64], bytes: Vec::new() }
        }
    };
    let bands = [450u16, 500, 550, 600, 650].iter().flat_map(|v| v.to_le_bytes()).collect();
    tensor_file(&[
        angles("phi_d", &phi),
        angles("theta_d", &theta_d),
        angles("theta_h", &theta_h),
        Array { name: "wvls", kind: 3, shape: vec![5], bytes: bands },
        floats("M", &[np, nd, nh, 5, 4, 4], &m),
    ])
}

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
    let full = std::env::var_os("ETENDUE_FULL").is_some();
    let n = if full { 1_000_000 } else { 100_000 };
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
            let f = furnace(&measured, wo, 20_000, 5);
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
        for end in (0..file.len()).filter(|&n| n < 900 || n % 61 == 0) {
            assert!(survive(&file[..end], &mut rng).is_err(), "cut at {end}");
        }
        let mut read = 0;
        for i in 0..600 {
            let mut broken = file.clone();
            // Mostly the directory, where most can go wrong.
            let range = if i % 3 == 0 { broken.len() } else { 700.min(broken.len()) };
            for _ in 0..1 + i % 3 {
                let at = (rng.bits() % range as u64) as usize;
                broken[at] ^= 1 << (rng.bits() % 8);
            }
            read += survive(&broken, &mut rng).is_ok() as usize;
        }
        println!("{read} of 600 damaged files were read");
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
