//! Films against the transfer-matrix method, Fresnel's formulas, and the CIE observer.

use etendue_bxdf::{
    fresnel::dielectric,
    laws::Rng,
    thin_film::{Lanes, Stack, ThinFilm},
};
use etendue_color::Spectrum;

type C = [f64; 2];

fn mul(a: C, b: C) -> C {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}
fn add(a: C, b: C) -> C {
    [a[0] + b[0], a[1] + b[1]]
}
fn div(a: C, b: C) -> C {
    let n = b[0] * b[0] + b[1] * b[1];
    let c = mul(a, [b[0], -b[1]]);
    [c[0] / n, c[1] / n]
}
fn root(a: C) -> C {
    let length = a[0].hypot(a[1]);
    [((length + a[0]) / 2.0).max(0.0).sqrt(), ((length - a[0]) / 2.0).max(0.0).sqrt()]
}

/// Reflectance by Abelès' characteristic matrix (Born, Wolf, section 1.6.2): another way to the same number.
fn characteristic_matrix(s: &Stack, cos: f64, thickness: f64, wavelength: f64) -> f64 {
    let (n1, n2) = (s.outside as f64, s.film as f64);
    let n3 = [s.base as f64, s.base_k as f64];
    let sin2 = n1 * n1 * (1.0 - cos * cos);
    let q = |n: C| root(add(mul(n, n), [-sin2, 0.0]));
    let mut sum = 0.0;
    for p in [false, true] {
        // Tilted admittances: n cos θ for s, n / cos θ for p.
        let admittance = |n: C| if p { div(mul(n, n), q(n)) } else { q(n) };
        let (y1, y2, y3) = (admittance([n1, 0.0]), admittance([n2, 0.0]), admittance(n3));
        let delta = mul(q([n2, 0.0]), [std::f64::consts::TAU * thickness / wavelength, 0.0]);
        // cos and −i sin of a complex phase (time goes as e^{−iωt}).
        let cosine = [delta[0].cos() * delta[1].cosh(), -delta[0].sin() * delta[1].sinh()];
        let sine = [delta[0].sin() * delta[1].cosh(), delta[0].cos() * delta[1].sinh()];
        let minus_i_sine = [sine[1], -sine[0]];
        let b = add(cosine, mul(div(minus_i_sine, y2), y3));
        let c = add(mul(minus_i_sine, y2), mul(cosine, y3));
        let y1b = mul(y1, b);
        let r = div(add(y1b, [-c[0], -c[1]]), add(y1b, c));
        sum += 0.5 * (r[0] * r[0] + r[1] * r[1]);
    }
    sum
}

#[test]
fn airy_meets_the_characteristic_matrix() {
    let mut rng = Rng::new(3);
    let mut worst = 0.0f64;
    for i in 0..20_000 {
        let mut u = || rng.uniform();
        let metal = i % 2 == 0;
        let stack = Stack {
            outside: 1.0 + 0.8 * u(),
            film: 1.0 + 1.5 * u(),
            base: if metal { 0.1 + 3.0 * u() } else { 1.0 + 2.0 * u() },
            base_k: if metal { 6.0 * u() } else { 0.0 },
        };
        let (cos, thickness, wavelength) = (0.02 + 0.98 * u(), 1000.0 * u(), 380.0 + 340.0 * u());
        let got = stack.reflectance(cos, thickness, wavelength) as f64;
        let want = characteristic_matrix(&stack, cos as f64, thickness as f64, wavelength as f64);
        assert!(
            (got - want).abs() < 5e-5,
            "{stack:?} cos {cos} {thickness} nm at {wavelength}: {got} {want}"
        );
        worst = worst.max((got - want).abs());
    }
    println!("Airy against the characteristic matrix: worst difference {worst:.1e}");
}

#[test]
fn no_film_is_no_film() {
    for i in 1..=100 {
        let cos = i as f32 / 100.0;
        let bare = dielectric(cos, 1.8);
        let thin = Stack { outside: 1.0, film: 1.4, base: 1.8, base_k: 0.0 };
        assert!((thin.reflectance(cos, 0.0, 550.0) - bare).abs() < 1e-5, "{cos}");
        let same = Stack { outside: 1.0, film: 1.8, base: 1.8, base_k: 0.0 };
        assert!((same.reflectance(cos, 300.0, 550.0) - bare).abs() < 1e-5, "{cos}");
        let film = ThinFilm::new(1.4, 0.0, 1.0, Lanes::Rgb).at(cos);
        let n = Spectrum::splat(1.8);
        for lane in film.exact(n, Spectrum::ZERO).to_rgb() {
            // Three terms of the series.
            assert!((lane - bare).abs() < 1e-3, "{cos}: {lane} {bare}");
        }
    }
    // A quarter wave of index √n does not reflect.
    let quarter = Stack { outside: 1.0, film: 1.5, base: 2.25, base_k: 0.0 };
    assert!(quarter.reflectance(1.0, 550.0 / 6.0, 550.0) < 1e-6);
}

/// Rows of (nm, x̄, ȳ, z̄); `None` if the file is not there.
fn observer() -> Option<Vec<[f64; 4]>> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets/spectral/colour-science/cmf_cie1931_2deg.csv"
    );
    let Ok(text) = std::fs::read_to_string(path) else {
        println!("skipped: {path} is not there");
        return None;
    };
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|t| t.parse().expect("a number")).collect();
        [v[0], v[1], v[2], v[3]]
    };
    Some(text.lines().skip(1).map(row).collect())
}

const XYZ_TO_REC709: [[f64; 3]; 3] = [
    [3.2404542, -1.5371385, -0.4985314],
    [-0.9692660, 1.8760108, 0.0415560],
    [0.0556434, -0.2040259, 1.0572252],
];

/// Linear Rec.709 of a reflectance under equal energy, before any white balance, and that of a white.
fn colour(observer: &[[f64; 4]], reflectance: impl Fn(f32) -> f32) -> [[f64; 3]; 2] {
    let (mut xyz, mut white, mut norm) = ([0.0; 3], [0.0; 3], 0.0);
    for row in observer {
        let r = reflectance(row[0] as f32) as f64;
        for k in 0..3 {
            xyz[k] += r * row[k + 1];
            white[k] += row[k + 1];
        }
        norm += row[2];
    }
    [xyz, white].map(|c| XYZ_TO_REC709.map(|m| (0..3).map(|k| m[k] * c[k] / norm).sum()))
}

#[derive(Default)]
struct Distance {
    sum: f64,
    count: f64,
    worst: f64,
}

impl Distance {
    fn add(&mut self, a: f64, b: f64) {
        self.sum += (a - b).abs();
        self.count += 1.0;
        self.worst = self.worst.max((a - b).abs());
    }
    fn mean(&self) -> f64 {
        self.sum / self.count
    }
}

/// Both forms against ∫ Airy over the CIE observer, white-balanced: how far three Gaussians and Schlick's curve are from it.
#[test]
fn three_colours_are_near_the_observer() {
    let Some(cmf) = observer() else { return };
    let mut rng = Rng::new(11);
    let dielectrics = [1.2f32, 1.5, 2.0].map(|n| (n, 0.0f32));
    // Aluminium, gold-like and titanium-like, grey over wavelength.
    let metals = [(1.1, 6.6), (0.35, 2.8), (2.5, 3.3)];
    for (what, bases, exact_mean, exact_worst, gltf_mean) in
        [("dielectrics", dielectrics, 4e-3, 0.03, 0.03), ("metals", metals, 7e-3, 0.12, 0.09)]
    {
        let [mut exact, mut gltf] = [Distance::default(), Distance::default()];
        for (n, k) in bases {
            for _ in 0..150 {
                let film = 1.1 + 0.9 * rng.uniform();
                let thickness = 50.0 + 950.0 * rng.uniform();
                let cos = 0.1 + 0.9 * rng.uniform();
                let stack = Stack { outside: 1.0, film, base: n, base_k: k };
                let [got, white] = colour(&cmf, |nm| stack.reflectance(cos, thickness, nm));
                let view = ThinFilm::new(film, thickness, 1.0, Lanes::Rgb);
                let f0 = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
                let extension = view.at(cos).gltf_unclamped(&view.base(Spectrum::splat(f0)));
                let ours = view.at(cos).exact_unclamped(Spectrum::splat(n), Spectrum::splat(k));
                for lane in 0..3 {
                    let want = got[lane] / white[lane];
                    exact.add(ours[lane] as f64, want);
                    gltf.add(extension[lane] as f64, want);
                }
            }
        }
        println!(
            "{what}: |colour − ∫ Airy|: exact mean {:.4} worst {:.4}; extension mean {:.4} worst {:.4}",
            exact.mean(),
            exact.worst,
            gltf.mean(),
            gltf.worst
        );
        assert!(exact.mean() < exact_mean && exact.worst < exact_worst, "{what}");
        assert!(gltf.mean() < gltf_mean, "{what}");
    }
}

/// Where the clamp to 0..1 bites.
#[test]
fn the_clamp_bites_where_it_is_said() {
    let mut rng = Rng::new(12);
    let n = 20_000;
    for (what, low, high) in [("F0 ≤ 0.1", 0.0, 0.1), ("F0 0.1..1", 0.1, 1.0)] {
        let (mut bitten, mut least, mut most) = (0, 0.0f32, 0.0f32);
        for _ in 0..n {
            let f0 = low + (high - low) * rng.uniform();
            let film = ThinFilm::new(1.0 + rng.uniform(), 1200.0 * rng.uniform(), 1.0, Lanes::Rgb);
            let r = film.at(rng.uniform()).gltf_unclamped(&film.base(Spectrum::splat(f0))).to_rgb();
            bitten += r.iter().any(|v| !(0.0..=1.0).contains(v)) as u32;
            least = r.into_iter().fold(least, f32::min);
            most = r.into_iter().fold(most, f32::max);
        }
        println!("{what}: clamped {:.2} %, range {least:.3}..{most:.3}", 100.0 * bitten as f64 / n as f64);
        assert!(least > -0.3 && most < 1.4, "{what}: {least} {most}");
    }
}

/// The extension's own code for grey bases, written out anew: what [`etendue_bxdf::thin_film::FilmView::gltf`] must say.
#[test]
fn the_extension_is_met() {
    let (pi, mut rng) = (std::f64::consts::PI, Rng::new(13));
    for _ in 0..2000 {
        let (film_ior, f0) = (1.01 + 1.5 * rng.uniform(), rng.uniform());
        let (thickness, cos) = (1200.0 * rng.uniform(), rng.uniform());
        let sq = |x: f64| x * x;
        let (n, c) = (film_ior as f64, cos as f64);
        let fresnel0 = |a: f64, b: f64| sq((a - b) / (a + b));
        let curve = |f0: f64, c: f64| f0 + (1.0 - f0) * (1.0 - c).powi(5);
        let cos2 = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
        let r12 = curve(fresnel0(n, 1.0), c);
        let base_root = (f0 as f64 + 1e-4).min(0.9999).sqrt();
        let base = (1.0 + base_root) / (1.0 - base_root);
        let r23 = curve(fresnel0(base, n), cos2);
        let phi = pi + if base < n { pi } else { 0.0 };
        let opd = 2.0 * n * thickness as f64 * cos2;
        let r123 = (r12 * r23).clamp(1e-5, 0.9999);
        let rs = sq(1.0 - r12) * r23 / (1.0 - r123);
        let mut want = [r12 + rs; 3];
        for m in 1..=2 {
            let cm = (rs - (1.0 - r12)) * r123.sqrt().powi(m);
            let phase = 2.0 * pi * m as f64 * opd * 1e-9;
            let shift = m as f64 * phi;
            let g = |val: f64, pos: f64, var: f64| {
                val * (2.0 * pi * var).sqrt() * (pos * phase + shift).cos() * (-sq(phase) * var).exp()
                    / 1.0685e-7
            };
            let xyz = [
                g(5.4856e-13, 1.6810e6, 4.3278e9) + g(9.7470e-14, 2.2399e6, 4.5282e9),
                g(4.4201e-13, 1.7953e6, 9.3046e9),
                g(5.2481e-13, 2.2084e6, 6.6121e9),
            ];
            for lane in 0..3 {
                want[lane] += 2.0 * cm * (0..3).map(|k| XYZ_TO_REC709[lane][k] * xyz[k]).sum::<f64>();
            }
        }
        let film = ThinFilm::new(film_ior, thickness, 1.0, Lanes::Rgb);
        let got = film.at(cos).gltf_unclamped(&film.base(Spectrum::splat(f0)));
        for lane in 0..3 {
            assert!(
                (got[lane] as f64 - want[lane]).abs() < 1e-4,
                "{film:?} f0 {f0} cos {cos}: {got:?} {want:?}"
            );
        }
    }
}

#[test]
fn wavelengths_are_airys_own() {
    let nm = [420.0, 500.0, 580.0, 660.0];
    let film = ThinFilm::new(1.4, 350.0, 1.0, Lanes::Wavelengths(nm));
    let (n, k) = (Spectrum([0.2, 0.5, 1.1, 2.0]), Spectrum([3.0, 2.0, 5.0, 0.0]));
    for cos in [0.0, 0.1, 0.7, 1.0] {
        let got = film.at(cos).exact(n, k);
        for lane in 0..4 {
            let stack = Stack { outside: 1.0, film: 1.4, base: n[lane], base_k: k[lane] };
            assert_eq!(got[lane], stack.reflectance(cos, 350.0, nm[lane]));
        }
        let base = film.base(Spectrum::splat(0.04));
        let f = film.at(cos).gltf(&base);
        assert!(f.is_finite() && f.max_element() <= 1.0);
    }
}

#[test]
fn no_input_breaks_anything() {
    const ODD: [f32; 9] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -1.0, 1.0, 1e30, 1e-30, 0.5];
    let mut rng = Rng::new(14);
    let mut pick = || {
        let i = (rng.bits() % 12) as usize;
        if i < 9 { ODD[i] } else { rng.uniform() }
    };
    for i in 0..50_000 {
        let lanes = if i % 2 == 0 { Lanes::Rgb } else { Lanes::Wavelengths([pick(), pick(), 500.0, pick()]) };
        let film = ThinFilm::new(pick(), pick() * 1000.0, pick(), lanes);
        let base = film.base(Spectrum([pick(), pick(), pick(), pick()]));
        let view = film.at(pick());
        let (n, k) = (Spectrum::splat(pick()), Spectrum::splat(pick()));
        for r in [view.gltf(&base), view.exact(n, k)] {
            assert!(r.0.iter().all(|v| (0.0..=1.0).contains(v)), "{film:?} {view:?} {r:?}");
        }
    }
}
