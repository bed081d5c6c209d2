//! Files of measured materials, made from a known function: what a reader's answers are compared with.

use core::f64::consts::{FRAC_PI_2, PI};
use glam::{DVec3, dvec3};

/// A field of a tensor file, as its writer needs it.
pub struct Array {
    pub name: &'static str,
    pub kind: u8,
    pub shape: Vec<u64>,
    pub bytes: Vec<u8>,
}

pub fn floats(name: &'static str, shape: &[usize], values: &[f64]) -> Array {
    assert_eq!(shape.iter().product::<usize>(), values.len(), "{name}");
    let bytes = values.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect();
    Array { name, kind: 10, shape: shape.iter().map(|&n| n as u64).collect(), bytes }
}

pub fn bytes(name: &'static str, values: &[u8]) -> Array {
    Array { name, kind: 1, shape: vec![values.len() as u64], bytes: values.to_vec() }
}

pub fn tensor_file(arrays: &[Array]) -> Vec<u8> {
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
pub struct Known {
    pub base: [f64; 3],
    pub gloss: f64,
    pub alpha: [f64; 2],
}

pub const ISOTROPIC: Known = Known { base: [0.24, 0.12, 0.06], gloss: 0.15, alpha: [0.35, 0.35] };
pub const ANISOTROPIC: Known = Known { base: [0.2, 0.2, 0.1], gloss: 0.15, alpha: [0.5, 0.3] };

impl Known {
    fn ndf(&self, m: DVec3) -> f64 {
        let [ax, ay] = self.alpha;
        let q = (m.x / ax).powi(2) + (m.y / ay).powi(2) + m.z * m.z;
        1.0 / (PI * ax * ay * q * q)
    }

    pub fn f(&self, wo: DVec3, wi: DVec3) -> [f64; 3] {
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
pub struct Layout {
    pub known: Known,
    /// Places of φo and θo.
    pub phi: Vec<f64>,
    pub theta: Vec<f64>,
    /// Nodes of the warp, along u and v.
    pub vndf: [usize; 2],
    /// Nodes of the values, along both.
    pub side: usize,
    /// With wavelengths instead of colours.
    pub spectral: bool,
}

/// The adaptive layout as Dupuy and Jakob 2018 describe it, from a known function.
pub fn rgl_file(l: &Layout) -> Vec<u8> {
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

pub fn even(n: usize, low: f64, high: f64) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * node(i, n)).collect()
}

pub fn isotropic() -> Layout {
    let theta = even(12, 0.0, 89f64.to_radians());
    Layout { known: ISOTROPIC, phi: vec![0.0], theta, vndf: [48, 24], side: 28, spectral: false }
}

/// The polarised layout from a known isotropic function; the other elements of a matrix are what must not be read.
pub fn pbsdf_file(known: Known, [np, nd, nh]: [usize; 3], with_angles: bool) -> Vec<u8> {
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
