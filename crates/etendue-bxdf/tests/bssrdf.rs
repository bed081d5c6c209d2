//! Laws of the separable BSSRDF: its light adds up to the albedo wherever that is known in closed form, and probes find
//! points with the density that they say.

use etendue_bxdf::{
    Bsdf, Lambert,
    bssrdf::{
        Distance, EntryLobe, Probe, Subsurface, SubsurfaceParams, profile, single_scattering_albedo,
        surface_albedo,
    },
    laws::{Rng, furnace::furnace, gamma::chi2_p_value},
    quadrature::directional_albedo,
    sampling::Frame,
};
use etendue_color::Spectrum;
use glam::{DVec3, Vec3A, vec3a};

fn skin() -> Subsurface {
    Subsurface::new(&SubsurfaceParams {
        color: Spectrum::rgb(0.85, 0.55, 0.3),
        radius: Spectrum::rgb(0.004, 0.0013, 0.0006),
        ..Default::default()
    })
}

fn count() -> usize {
    if std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1") { 1_000_000 } else { 100_000 }
}

/// Sums and sums of squares by lane.
#[derive(Default)]
struct Mean {
    sum: [f64; 4],
    square: [f64; 4],
    n: f64,
}

impl Mean {
    fn add(&mut self, v: Spectrum) {
        for lane in 0..4 {
            self.sum[lane] += v[lane] as f64;
            self.square[lane] += (v[lane] as f64).powi(2);
        }
        self.n += 1.0;
    }

    /// Asserts that the mean of each lane lies within 4 standard errors of `want`.
    fn expect(&self, want: [f64; 4], what: &str) {
        for lane in 0..4 {
            let mean = self.sum[lane] / self.n;
            let sigma = ((self.square[lane] / self.n - mean * mean).max(0.0) / self.n).sqrt();
            println!("{what} lane {lane}: {mean:.5} ± {sigma:.5}, want {:.5}", want[lane]);
            assert!(
                (mean - want[lane]).abs() <= 4.0 * sigma + 2e-5,
                "{what} lane {lane}: {mean} for {}",
                want[lane]
            );
        }
    }
}

#[test]
fn the_profile_integrates_to_the_albedo() {
    let s = skin();
    // ∫ R 2πr dr in r = t²: the singularity at zero is gone; many panels for the narrowest lane.
    let nodes = etendue_bxdf::quadrature::gauss_legendre(16);
    let mut sum = [0.0f64; 4];
    let end = (s.reach() as f64).sqrt();
    for panel in 0..64 {
        for &(x, w) in &nodes {
            let t = end * (panel as f64 + x) / 64.0;
            let value = s.eval((t * t) as f32);
            for lane in 0..4 {
                sum[lane] += w * end / 64.0 * 2.0 * t * std::f64::consts::TAU * t * t * value[lane] as f64;
            }
        }
    }
    for lane in 0..4 {
        // The cuts of the narrower lanes fall within a panel: what is there is 1e-5 of the light.
        assert!((sum[lane] - s.albedo()[lane] as f64).abs() < 2e-5, "lane {lane}: {}", sum[lane]);
    }
}

#[test]
fn radii_are_drawn_from_the_profile() {
    // Bins of equal probability: χ² without an integral.
    const BINS: usize = 64;
    let mut rng = Rng::new(11);
    let mut observed = [0u64; BINS];
    let n = count();
    for _ in 0..n {
        let x = profile::sample(rng.uniform()) as f64;
        let f = |x: f64| 1.0 - 0.25 * (-x).exp() - 0.75 * (-x / 3.0).exp();
        let u = f(x) / f(profile::CUT as f64);
        observed[((u * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    let expected = n as f64 / BINS as f64;
    let statistic: f64 = observed.iter().map(|&o| (o as f64 - expected).powi(2) / expected).sum();
    let p = chi2_p_value(statistic, BINS - 1);
    println!("p = {p}");
    assert!(p > 0.01);
}

/// The hit of a probe with the plane through the origin of the frame.
fn tilted_hit(p: &Probe, normal: Vec3A) -> Option<Vec3A> {
    let (o, d) = (p.origin.as_dvec3().dot(normal.as_dvec3()), p.direction.as_dvec3().dot(normal.as_dvec3()));
    let t = -o / d;
    (d != 0.0 && (0.0..=p.length as f64).contains(&t))
        .then(|| (p.origin.as_dvec3() + p.direction.as_dvec3() * t).as_vec3a())
}

fn plane_hit(p: &Probe) -> Option<Vec3A> {
    tilted_hit(p, Vec3A::Z)
}

/// A frame that leans against the plane, as a shading frame does: each axis finds what the others find, with its own density.
#[test]
fn probes_on_a_tilted_plane_return_the_albedo() {
    let s = skin();
    for normal in [vec3a(0.9, 0.2, 0.4), vec3a(-0.1, 0.8, -0.3), vec3a(1.0, 0.0, 0.0), vec3a(0.0, 1.0, 0.0)] {
        let normal = normal.normalize();
        let mut rng = Rng::new(29);
        let mut mean = Mean::default();
        for _ in 0..count() {
            let hit = s.sample_probe(rng.uniform(), rng.square()).and_then(|p| tilted_hit(&p, normal));
            mean.add(hit.map_or(Spectrum::ZERO, |hit| {
                let found = s.found(hit, normal);
                found.value / found.pdf
            }));
        }
        mean.expect(s.albedo().0.map(f64::from), &format!("plane {normal}"));
    }
}

#[test]
fn probes_on_a_plane_return_the_albedo() {
    for (name, s) in [
        ("skin", skin()),
        ("narrow", Subsurface::from_shape(Spectrum::splat(0.5), Spectrum::rgb(2e-7, 2e-7, 2e-7))),
        ("wide apart", Subsurface::from_shape(Spectrum::rgb(0.9, 0.9, 0.1), Spectrum::rgb(10.0, 0.01, 1.0))),
    ] {
        let mut rng = Rng::new(3);
        let mut mean = Mean::default();
        for _ in 0..count() {
            let hit = s.sample_probe(rng.uniform(), rng.square()).as_ref().and_then(plane_hit);
            mean.add(hit.map_or(Spectrum::ZERO, |hit| {
                let found = s.found(hit, Vec3A::Z);
                assert!(found.pdf > 0.0);
                found.value / found.pdf
            }));
        }
        mean.expect(s.albedo().0.map(f64::from), name);
    }
}

/// The hits of a segment with a sphere of radius `radius` whose top is the origin of the frame.
fn sphere_hits(p: &Probe, radius: f64) -> Vec<(Vec3A, Vec3A)> {
    let centre = DVec3::new(0.0, 0.0, -radius);
    let (o, d) = (p.origin.as_dvec3() - centre, p.direction.as_dvec3());
    let b = o.dot(d);
    let q = b * b - (o.length_squared() - radius * radius);
    if q < 0.0 {
        return Vec::new();
    }
    [-b - q.sqrt(), -b + q.sqrt()]
        .into_iter()
        .filter(|t| (0.0..=p.length as f64).contains(t))
        .map(|t| {
            let n = (o + d * t) / radius;
            ((n * radius + centre).as_vec3a(), n.as_vec3a())
        })
        .collect()
}

/// On a sphere of radius ρ the part within the chord r has the area πr² (Archimedes), so that ∫ Sp dA = A · cdf(2ρ): the
/// albedo of a small ball in closed form. It needs all three axes, and each of several hits.
#[test]
fn probes_on_a_sphere_return_the_closed_form() {
    let s = skin();
    for radius in [0.02, 0.003, 0.0005f64] {
        let mut rng = Rng::new(5);
        let mut mean = Mean::default();
        for _ in 0..count() {
            let mut sum = Spectrum::ZERO;
            if let Some(p) = s.sample_probe(rng.uniform(), rng.square()) {
                for (hit, normal) in sphere_hits(&p, radius) {
                    let found = s.found(hit, normal);
                    assert!(found.pdf > 0.0, "{hit} {}", hit.length());
                    sum += found.value / found.pdf;
                }
            }
            mean.add(sum);
        }
        let want = core::array::from_fn(|i| {
            let x = (2.0 * radius) as f32 / s.shape()[i];
            s.albedo()[i] as f64 * profile::cdf(x) as f64
        });
        mean.expect(want, &format!("sphere {radius}"));
    }
}

/// χ² of the found points on a sphere against the density, over rings of equal chord and both halves of azimuth.
#[test]
fn probes_find_points_with_their_density() {
    let s = skin();
    let radius = 0.003f64;
    const RINGS: usize = 24;
    let (mut observed, mut expected) = ([0u64; RINGS], [0.0f64; RINGS]);
    let n = count();
    let mut rng = Rng::new(8);
    let ring =
        |hit: Vec3A| ((hit.length() as f64 / (2.0 * radius)).powi(2).min(0.999_999) * RINGS as f64) as usize;
    let mut hits = 0;
    for _ in 0..n {
        if let Some(p) = s.sample_probe(rng.uniform(), rng.square()) {
            for (hit, _) in sphere_hits(&p, radius) {
                observed[ring(hit)] += 1;
                hits += 1;
            }
        }
    }
    // Even points of the sphere, by rings of equal area: n · ∫ pdf dA.
    let per_ring = 20_000;
    for (k, expected) in expected.iter_mut().enumerate() {
        for i in 0..per_ring {
            let chord2 =
                4.0 * radius * radius * (k as f64 + (i as f64 + 0.5) / per_ring as f64) / RINGS as f64;
            let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
            let z = -chord2 / (2.0 * radius);
            let r = (chord2 - z * z).max(0.0).sqrt();
            let hit = DVec3::new(r * cos, r * sin, z);
            let normal = (hit + DVec3::new(0.0, 0.0, radius)) / radius;
            let area = 4.0 * std::f64::consts::PI * radius * radius / RINGS as f64;
            *expected +=
                s.found(hit.as_vec3a(), normal.as_vec3a()).pdf as f64 * area / per_ring as f64 * n as f64;
        }
    }
    // The inmost ring holds the singularity of the density, which even points do not integrate; it is left out. One probe can
    // hit twice, which makes counts no multinomial: each ring's z is judged instead, with the larger of both variances.
    for k in 1..RINGS {
        let sigma = (2.0 * expected[k]).sqrt();
        let z = (observed[k] as f64 - expected[k]).abs() / sigma;
        assert!(z < 4.0, "ring {k}: {} for {:.1}", observed[k], expected[k]);
    }
    println!("{hits} hits of {n} probes");
}

/// An even stripe pattern of light is seen with the contrast of the profile's Hankel transform; for small radii with the contrast
/// of Lambert's surface.
#[test]
fn contrast_is_the_transform_and_tends_to_lambert() {
    let k = 1000.0f64;
    let mut last = 0.0;
    for d in [1e-2f32, 1e-3, 1e-4, 1e-5, 1e-6] {
        let s = Subsurface::from_shape(Spectrum::splat(0.8), Spectrum::splat(d));
        let mut rng = Rng::new(17);
        let mut mean = Mean::default();
        for _ in 0..count() {
            let hit = s.sample_probe(rng.uniform(), rng.square()).as_ref().and_then(plane_hit);
            mean.add(hit.map_or(Spectrum::ZERO, |hit| {
                let found = s.found(hit, Vec3A::Z);
                found.value * ((1.0 + (k * hit.x as f64).cos()) as f32 / found.pdf)
            }));
        }
        let kd2 = (k * d as f64).powi(2);
        let contrast = 0.25 / (1.0 + kd2).sqrt() + 0.75 / (1.0 + 9.0 * kd2).sqrt();
        // The cut moves 2.5e-4 of the light.
        let seen = mean.sum[0] / mean.n / 0.8 - 1.0;
        assert!((seen - contrast).abs() < 0.012, "{d}: {seen} for {contrast}");
        assert!(contrast > last);
        last = contrast;
    }
    assert!(last > 0.9999, "the narrowest is not Lambert's: {last}");
    // Lanes without a radius are Lambert's lobe itself, and take no part in the profile.
    let s = Subsurface::from_shape(Spectrum::rgb(0.3, 0.6, 0.9), Spectrum::rgb(0.0, 1e-3, f32::NAN));
    assert_eq!(s.local(), Spectrum::rgb(0.3, 0.0, 0.9));
    assert_eq!(s.albedo(), Spectrum::rgb(0.0, 0.6, 0.0));
    let lambert = Lambert { color: s.local() };
    assert_eq!(lambert.albedo(Vec3A::Z) + s.albedo(), Spectrum::rgb(0.3, 0.6, 0.9));
}

#[test]
fn the_entry_lobe_loses_nothing() {
    for eta in [1.0, 1.05, 1.3, 1.4, 1.5, 2.0, 4.0] {
        let lobe = EntryLobe::new(eta);
        for wo in [Vec3A::Z, vec3a(0.6, 0.0, 0.8), vec3a(0.0, 0.999, 0.0447)] {
            let albedo = directional_albedo(&lobe, wo).max_element();
            assert!((albedo - 1.0).abs() < 2e-4, "{eta}: {albedo}");
            assert!(furnace(&lobe, wo, 10_000, 1).z < 4.0);
        }
        // External diffuse reflectance of a dielectric in closed form (Duntley 1942).
        let n = eta as f64;
        if eta > 1.0 {
            let (n2, n4) = (n * n, n.powi(4));
            let f = 0.5
                + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
                + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
                - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
                + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln();
            assert!(
                (lobe.entering() as f64 - (1.0 - f)).abs() < 2e-4,
                "{eta}: {} {}",
                lobe.entering(),
                1.0 - f
            );
        }
    }
    // Without an interface it is Lambert's.
    let (wo, wi) = (Vec3A::Z, vec3a(0.6, 0.0, 0.8));
    let white = Lambert { color: Spectrum::ONE };
    let d = EntryLobe::new(1.0).eval(wo, wi) - white.eval(wo, wi);
    assert!(d.map(f32::abs).max_element() < 1e-6);
}

#[test]
fn inversion_is_its_own_inverse() {
    for g in [-0.9, -0.3, 0.0, 0.5, 0.9, 0.99] {
        let mut last = -1.0;
        for i in 0..=100 {
            let a = i as f32 / 100.0;
            let alpha = single_scattering_albedo(a, g);
            assert!((0.0..=1.0).contains(&alpha) && alpha >= last, "{a} {g}: {alpha}");
            last = alpha;
            // What the last bit of alpha makes of A: dA/ds is at most 2.4, and 1 − α = s² (1 − αg).
            let s = ((1.0 - alpha) / (1.0 - alpha * g)).sqrt().max(1e-3);
            let tolerance = 1e-5 + 3.0 * 1.2e-7 / (s * (1.0 - alpha * g));
            assert!((surface_albedo(alpha, g) - a).abs() < tolerance, "{a} {g}: {tolerance}");
        }
    }
    assert_eq!((surface_albedo(1.0, 0.0), single_scattering_albedo(1.0, 0.0)), (1.0, 1.0));
    assert!(surface_albedo(f32::NAN, f32::NAN).is_finite());
}

/// A random walk in a half space under even light: what van de Hulst's formula approximates.
#[test]
fn inversion_meets_a_random_walk() {
    for alpha in [0.5f64, 0.9, 0.99] {
        let mut rng = Rng::new(23);
        let n = count() / 5;
        let mut escaped = 0.0;
        for _ in 0..n {
            // Cosine-distributed entry, isotropic scattering, weight by albedo.
            let mut mu = -(rng.uniform() as f64).sqrt();
            let (mut depth, mut weight) = (0.0f64, 1.0f64);
            loop {
                depth -= mu * -(1.0 - rng.uniform() as f64).ln();
                if depth < 0.0 {
                    escaped += weight;
                    break;
                }
                weight *= alpha;
                if weight < 1e-4 {
                    break;
                }
                mu = 2.0 * rng.uniform() as f64 - 1.0;
            }
        }
        let walked = escaped / n as f64;
        let formula = surface_albedo(alpha as f32, 0.0) as f64;
        println!("alpha {alpha}: walk {walked:.4}, van de Hulst {formula:.4}");
        assert!((walked - formula).abs() < 0.01);
    }
}

#[test]
fn nonsense_gives_something_finite() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-30, 1e30, 0.5, 1.0, 2.0];
    let mut rng = Rng::new(31);
    let mut pick = move || odd[(rng.bits() % odd.len() as u64) as usize];
    let distances =
        [Distance::MeanFreePath, Distance::DiffuseEntry, Distance::DiffuseMeanFreePath, Distance::Shape];
    for i in 0..20_000 {
        let s = Subsurface::new(&SubsurfaceParams {
            color: Spectrum([pick(), pick(), pick(), pick()]),
            radius: Spectrum([pick(), pick(), pick(), pick()]),
            distance: distances[i % 4],
            ior: pick(),
            roughness: pick(),
        });
        assert!(s.albedo().is_finite() && s.local().is_finite() && s.reach().is_finite());
        if let Some(p) = s.sample_probe(pick(), [pick(), pick()]) {
            assert!(p.origin.is_finite() && p.length > 0.0 && p.length.is_finite(), "{p:?}");
        }
        let f = s.found(vec3a(pick(), pick(), pick()), vec3a(pick(), pick(), pick()));
        assert!(f.value.is_finite() && f.pdf >= 0.0 && f.pdf.is_finite(), "{s:?} {f:?}");
        let e = EntryLobe::new(pick()).eval(Vec3A::Z, Frame::from_normal(Vec3A::Z).x + Vec3A::Z * pick());
        assert!(e.is_finite());
    }
}
