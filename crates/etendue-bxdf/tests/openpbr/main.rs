//! OpenPBR before the laws: the specification's white furnaces, random surfaces, sampling, and what parameters mean.
//!
//! By default some hundred cells; with `ETENDUE_FULL=1` all of them, χ² with 10⁶ samples.

mod furnace;

use etendue_bxdf::{
    Bsdf,
    laws::{Rng, chi2::chi2, furnace::furnace, grid::wo_at, sidak},
    model::{Incidence, ModelParams, Parameters, Transport, Value},
    openpbr::{OpenPbr, OpenPbrParams, index},
    quadrature::directional_albedo,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use std::sync::Mutex;

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

/// `f` of every item, on all processors, in order.
fn parallel<T: Sync, R: Send>(items: &[T], f: impl Fn(usize, &T) -> R + Sync) -> Vec<R> {
    let next = Mutex::new(0usize);
    let out = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, |n| n.get()) {
            scope.spawn(|| {
                loop {
                    let i = {
                        let mut next = next.lock().expect("no thread panics here");
                        *next += 1;
                        *next - 1
                    };
                    let Some(item) = items.get(i) else { break };
                    let r = f(i, item);
                    out.lock().expect("no thread panics here").push((i, r));
                }
            });
        }
    });
    let mut out = out.into_inner().expect("no thread panics here");
    out.sort_by_key(|o| o.0);
    out.into_iter().map(|o| o.1).collect()
}

/// White wherever the specification's list says so.
fn white() -> OpenPbrParams {
    OpenPbrParams { base_color: Spectrum::ONE, subsurface_color: Spectrum::ONE, ..Default::default() }
}

fn closure(p: &OpenPbrParams, front: bool) -> OpenPbr {
    OpenPbr::new(p, &Incidence { front, transport: Transport::Importance, ..Default::default() })
}

/// All parameters at random: a third of the features off, so that each also stands without the others.
fn random(rng: &mut Rng) -> OpenPbrParams {
    let mut p = OpenPbrParams::default();
    for parameter in OpenPbrParams::table() {
        let [low, high] = parameter.range;
        let number = |rng: &mut Rng| low + (high - low) * rng.uniform();
        let value = match parameter.default {
            Value::Number(_) if parameter.name.ends_with("_weight") || parameter.name == "base_metalness" => {
                Value::Number(match rng.bits() % 3 {
                    0 => 0.0,
                    1 => 1.0,
                    _ => number(rng),
                })
            }
            Value::Number(_) => Value::Number(number(rng)),
            Value::Color(_) if rng.bits().is_multiple_of(3) => Value::Color([1.0; 3]),
            Value::Color(_) => Value::Color([number(rng), number(rng), number(rng)]),
            Value::Flag(_) => Value::Flag(rng.bits().is_multiple_of(4)),
            // The coat's frame: tests of its own.
            _ => continue,
        };
        assert!(p.set(parameter.name, value), "{}", parameter.name);
    }
    p
}

#[test]
fn samples_follow_the_density() {
    let mut rng = Rng::new(31);
    let (sets, samples) = if full() { (60, 1_000_000) } else { (8, 20_000) };
    let mut cells: Vec<_> =
        (0..sets).map(|i| (random(&mut rng), i % 4 != 3, [0.0, 30.0, 60.0, 80.0, 89.0][i % 5])).collect();
    // A coat with a frame of its own.
    for angle in [20.0, 60.0] {
        let tilted = OpenPbrParams {
            coat_weight: 1.0,
            coat_roughness: 0.4,
            coat_roughness_anisotropy: 0.5,
            geometry_coat_normal: vec3a(0.3, 0.1, 1.0),
            geometry_coat_tangent: vec3a(0.5, 1.0, 0.0),
            base_diffuse_roughness: 0.5,
            ..Default::default()
        };
        cells.push((tilted, true, angle));
    }
    let level = sidak(0.01, cells.len());
    let got =
        parallel(&cells, |i, (p, front, angle)| chi2(&closure(p, *front), wo_at(*angle), samples, i as u64));
    for ((p, front, angle), c) in cells.iter().zip(&got) {
        assert!(c.p > level, "{angle}° front {front}: {c:?}\n{p:?}");
    }
}

/// The variance of a furnace's weights: what the choice of lobes costs a path.
#[test]
fn weights_vary_little() {
    let p = white();
    let named = [
        ("diffuse", p, 0.02),
        ("metal", OpenPbrParams { base_metalness: 1.0, ..p }, 0.02),
        ("coated diffuse", OpenPbrParams { coat_weight: 1.0, coat_roughness: 0.2, ..p }, 0.03),
        ("fuzzy", OpenPbrParams { fuzz_weight: 1.0, fuzz_roughness: 0.3, ..p }, 0.05),
        ("filmed metal", OpenPbrParams { base_metalness: 1.0, thin_film_weight: 1.0, ..p }, 0.05),
        ("pane", OpenPbrParams { transmission_weight: 1.0, geometry_thin_walled: true, ..p }, 0.05),
        ("glass", OpenPbrParams { transmission_weight: 1.0, ..p }, 0.1),
    ];
    for (name, p, most) in named {
        let mut sum = 0.0;
        for angle in [0.0, 45.0, 75.0] {
            let f = furnace(&closure(&p, true), wo_at(angle), 20_000, 3);
            assert!(f.z < 5.0, "{name} {angle}°: {f:?}");
            sum += f.variance[0] / 3.0;
        }
        println!("{name:16} variance {sum:.4}");
        assert!(sum < most, "{name}: variance {sum}");
    }
}

/// The claimed albedo is near the integral where the closure says so.
#[test]
fn claimed_albedo_is_near_the_integral() {
    let mut rng = Rng::new(8);
    let sets = if full() { 300 } else { 12 };
    let cells: Vec<_> = (0..sets)
        .map(|_| {
            let p = OpenPbrParams {
                transmission_weight: 0.0,
                coat_color: Spectrum::ONE,
                specular_roughness_anisotropy: 0.0,
                coat_roughness_anisotropy: 0.0,
                ..random(&mut rng)
            };
            (p, [0.0, 50.0, 75.0, 85.0][(rng.bits() % 4) as usize])
        })
        .collect();
    let got = parallel(&cells, |_, (p, angle)| {
        let c = closure(p, true);
        (directional_albedo(&c, wo_at(*angle)), c.albedo(wo_at(*angle)))
    });
    for ((p, angle), (exact, claimed)) in cells.iter().zip(&got) {
        let error = (*exact - *claimed).map(f32::abs).to_rgb().into_iter().fold(0.0, f32::max);
        let bound = if p.thin_film_weight > 0.0 { 1e-2 } else { 2e-3 };
        assert!(error < bound, "{angle}°: {exact:?}, claimed {claimed:?}\n{p:?}");
    }
}

/// Defaults and names, as the specification's tables have them.
#[test]
fn parameters_are_the_specifications() {
    let want = [
        ("base_weight", 1.0),
        ("base_diffuse_roughness", 0.0),
        ("base_metalness", 0.0),
        ("specular_weight", 1.0),
        ("specular_roughness", 0.3),
        ("specular_roughness_anisotropy", 0.0),
        ("specular_ior", 1.5),
        ("transmission_weight", 0.0),
        ("transmission_depth", 0.0),
        ("transmission_scatter_anisotropy", 0.0),
        ("transmission_dispersion_scale", 0.0),
        ("transmission_dispersion_abbe_number", 20.0),
        ("subsurface_weight", 0.0),
        ("subsurface_radius", 1.0),
        ("subsurface_scatter_anisotropy", 0.0),
        ("coat_weight", 0.0),
        ("coat_roughness", 0.0),
        ("coat_roughness_anisotropy", 0.0),
        ("coat_ior", 1.6),
        ("coat_darkening", 1.0),
        ("fuzz_weight", 0.0),
        ("fuzz_roughness", 0.5),
        ("emission_luminance", 0.0),
        ("thin_film_weight", 0.0),
        ("thin_film_thickness", 0.5),
        ("thin_film_ior", 1.4),
    ];
    let p = OpenPbrParams::default();
    for (name, v) in want {
        assert_eq!(p.get(name), Some(Value::Number(v)), "{name}");
    }
    let colors = [
        ("base_color", [0.8; 3]),
        ("specular_color", [1.0; 3]),
        ("transmission_color", [1.0; 3]),
        ("transmission_scatter", [0.0; 3]),
        ("subsurface_color", [0.8; 3]),
        ("subsurface_radius_scale", [1.0, 0.5, 0.25]),
        ("coat_color", [1.0; 3]),
        ("fuzz_color", [1.0; 3]),
        ("emission_color", [1.0; 3]),
    ];
    for (name, c) in colors {
        assert_eq!(p.get(name), Some(Value::Color(c)), "{name}");
    }
    assert_eq!(OpenPbrParams::table().len(), want.len() + colors.len() + 3);
}

/// A smooth coat over a matte base returns what the specification's equation for interfaced Lambertian surfaces says, but for
/// what its recommended K leaves of it: at normal incidence F + E (1 − F) Δ.
#[test]
fn coats_darken() {
    let matte = |albedo: f32, darkening: f32| OpenPbrParams {
        base_color: Spectrum::splat(albedo),
        specular_weight: 0.0,
        coat_weight: 1.0,
        coat_ior: 1.5,
        coat_darkening: darkening,
        ..Default::default()
    };
    // Mean reflectance of a boundary of index 1.5, from inside: 1 − (1 − 0.0918) / 2.25.
    let k = 0.5963f32;
    for e in [0.0f32, 0.2, 0.5, 0.8, 1.0] {
        let delta = (1.0 - k) / (1.0 - e * k);
        let want = 0.04 + e * 0.96 * delta;
        let got = directional_albedo(&closure(&matte(e, 1.0), true), Vec3A::Z)[0];
        assert!((got - want).abs() < 2e-3, "albedo {e}: {got}, {want}");
        let bright = directional_albedo(&closure(&matte(e, 0.0), true), Vec3A::Z)[0];
        assert!((bright - (0.04 + e * 0.96)).abs() < 1e-3, "albedo {e}: {bright}");
    }
}

/// A coloured coat tints by its colour at normal incidence, and by the longer way at an angle; itself it is not tinted.
#[test]
fn coats_absorb_by_path_length() {
    let p = OpenPbrParams {
        base_color: Spectrum::ONE,
        coat_weight: 1.0,
        coat_color: Spectrum::rgb(0.25, 1.0, 0.5),
        coat_darkening: 0.0,
        ..white()
    };
    let clear = OpenPbrParams { coat_color: Spectrum::ONE, ..p };
    for (o, i) in [(0.0, 0.0), (60.0, 0.0), (60.0, -40.0)] {
        let (wo, wi) = (wo_at(o), wo_at(i));
        let e = closure(&p, true).eval_pdf(wo, wi);
        let bare = closure(&clear, true).eval_pdf(wo, wi);
        let inside = |w: Vec3A| (1.0 - (1.0 - w.z * w.z) / 2.56).sqrt();
        let crossings = 0.5 * (1.0 / inside(wo) + 1.0 / inside(wi));
        for (lane, color) in [0.25f32, 1.0, 0.5].into_iter().enumerate() {
            let want = bare.diffuse[lane] * color.powf(crossings);
            assert!((e.diffuse[lane] - want).abs() < 1e-4, "{o}° {i}°: {e:?}, {want}");
        }
    }
}

/// Emission comes through coat and fuzz, tinted once.
#[test]
fn emission_is_tinted() {
    let p = OpenPbrParams {
        emission_luminance: 100.0,
        emission_color: Spectrum::rgb(1.0, 0.5, 2.0),
        coat_weight: 0.5,
        coat_color: Spectrum::rgb(0.25, 1.0, 1.0),
        ..Default::default()
    };
    let e = closure(&p, true).emission(Vec3A::Z);
    for (got, want) in e.to_rgb().into_iter().zip([75.0, 50.0, 200.0]) {
        assert!((got - want).abs() < 1e-3, "{e:?}");
    }
    assert_eq!(closure(&p, true).emission(-Vec3A::Z), Spectrum::ZERO);
    // At an angle the way through the coat is longer, and the fuzz hides more.
    let fuzzy = closure(&OpenPbrParams { fuzz_weight: 1.0, ..p }, true);
    assert!(closure(&p, true).emission_tint(wo_at(70.0))[0] < 0.75);
    assert!(fuzzy.emission_tint(wo_at(80.0))[1] < fuzzy.emission_tint(wo_at(10.0))[1]);
    assert_eq!(closure(&OpenPbrParams::default(), true).emission(Vec3A::Z), Spectrum::ZERO);
}

/// Refraction goes where Snell's law says, with and without a coat, and each lane its own way where there is dispersion.
#[test]
fn light_is_bent_by_the_base() {
    let glass = OpenPbrParams { transmission_weight: 1.0, specular_roughness: 0.0, ..white() };
    let coated = OpenPbrParams { coat_weight: 1.0, ..glass };
    let wo = wo_at(40.0);
    for p in [glass, coated] {
        let d = closure(&p, true).deltas(wo)[1].expect("glass lets light through");
        let sine = (1.0 - d.wi.z * d.wi.z).sqrt();
        assert!((sine * 1.5 - 40.0f32.to_radians().sin()).abs() < 1e-5, "{d:?}");
    }
    let prism = OpenPbrParams { transmission_dispersion_scale: 1.0, ..glass };
    let ior = |lane| prism.interior_ior(1.0, lane);
    let interior = prism.interior().expect("light passes");
    assert!(interior.dispersive && (interior.ior - 1.5).abs() < 1e-5);
    // Abbe's number from the indices.
    let abbe = (ior(None) - 1.0) / (ior(Some(2)) - ior(Some(0)));
    assert!((abbe - 20.0).abs() < 0.01, "{abbe}");
    let at = Incidence { lane: Some(2), ..Default::default() };
    let d = OpenPbr::new(&prism, &at).deltas(wo)[1].expect("glass lets light through");
    let sine = (1.0 - d.wi.z * d.wi.z).sqrt();
    assert!((sine * ior(Some(2)) - 40.0f32.to_radians().sin()).abs() < 1e-5);
    assert!(!glass.interior().expect("light passes").dispersive);
    assert!(OpenPbrParams { geometry_thin_walled: true, ..glass }.interior().is_none());
}

/// A thin sheet splits its subsurface by the anisotropy, and looks the same from both sides.
#[test]
fn sheets_split_light() {
    let p = OpenPbrParams {
        geometry_thin_walled: true,
        subsurface_weight: 1.0,
        subsurface_color: Spectrum::rgb(0.8, 0.4, 0.2),
        subsurface_scatter_anisotropy: 0.5,
        specular_weight: 0.0,
        ..Default::default()
    };
    let (wo, up) = (wo_at(30.0), wo_at(50.0));
    let c = closure(&p, true);
    let (above, below) = (c.eval(wo, up), c.eval(wo, vec3a(up.x, up.y, -up.z)));
    for lane in 0..3 {
        let all = p.subsurface_color[lane] * core::f32::consts::FRAC_1_PI;
        assert!((above[lane] - 0.25 * all).abs() < 1e-5 && (below[lane] - 0.75 * all).abs() < 1e-5);
    }
    assert_eq!(c, closure(&p, false));
    assert_eq!(c.refraction(), Some(1.0));
}

/// The base's index under a coat and by its weight shows in the reflection.
#[test]
fn specular_weight_scales_the_reflectance() {
    let smooth = |weight: f32, coat: f32| OpenPbrParams {
        specular_weight: weight,
        specular_roughness: 0.0,
        coat_weight: coat,
        coat_roughness: 0.5,
        ..Default::default()
    };
    for weight in [0.0, 0.5, 1.0, 3.0] {
        let d = closure(&smooth(weight, 0.0), true).deltas(Vec3A::Z)[0];
        let got = d.map_or(0.0, |d| d.reflectance[0]);
        assert!((got - 0.04 * weight).abs() < 1e-5, "{weight}: {got}");
    }
    assert!((index::relative_index(1.5, 1.6, 1.0, 1.0) - 1.6 / 1.5).abs() < 1e-6);
}

/// The same surface from its parts: dielectric's diffuse and specular values, straight from the formulas.
#[test]
fn the_default_surface_is_a_sum_of_its_lobes() {
    let c = closure(&OpenPbrParams::default(), true);
    let (wo, wi) = (wo_at(40.0), wo_at(25.0));
    let h = (wo + wi).normalize();
    let a2 = 0.09f32 * 0.09;
    let d = a2 / (core::f32::consts::PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2));
    let smith = |a: Vec3A, b: Vec3A| a.z * (a2 + (1.0 - a2) * b.z * b.z).sqrt();
    let lobe = d * 0.5 / (smith(wo, wi) + smith(wi, wo));
    let specular = lobe * etendue_bxdf::fresnel::dielectric(wo.dot(h), 1.5);
    let e = c.eval_pdf(wo, wi);
    // Compensation adds less than a thousandth at this roughness.
    assert!((e.specular[0] / specular - 1.0).abs() < 2e-3, "{e:?} {specular}");
    let reflected =
        directional_albedo(&closure(&OpenPbrParams { base_weight: 0.0, ..Default::default() }, true), wo)[0];
    let diffuse = 0.8 * core::f32::consts::FRAC_1_PI * (1.0 - reflected);
    assert!((e.diffuse[0] - diffuse).abs() < 1e-4, "{e:?} {diffuse}");
}
