//! Disney's BRDF of 2012 and BSDF of 2015 against the published formulas, and how much light they make.
//!
//! χ², weights, reciprocity and odd inputs of both are run with all other models by `tests/verify.rs`.

use core::f64::consts::{FRAC_1_PI, PI};
use etendue_bxdf::{
    Bsdf,
    disney::{DisneyBrdf, DisneyBrdfParams, DisneyBsdf, DisneyBsdfParams},
    laws::{Rng, grid::wo_at},
    model::{Incidence, ModelParams, Transport},
    quadrature::directional_albedo,
    sampling::uniform_hemisphere,
};
use etendue_color::Spectrum;
use glam::{DVec3, Vec3A};

fn full() -> bool {
    std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1")
}

/// Both directions at least 3° above the surface.
fn pair(rng: &mut Rng) -> (Vec3A, Vec3A) {
    loop {
        let (a, b) = (uniform_hemisphere(rng.square()), uniform_hemisphere(rng.square()));
        if a.z > 0.05 && b.z > 0.05 {
            return (a, b);
        }
    }
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

fn pow5(x: f64) -> f64 {
    (1.0 - x).powi(5)
}

/// GTR of exponent 1, normalised (Burley 2012, eq. 4).
fn gtr1(h: DVec3, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    (a2 - 1.0) / (PI * a2.ln() * (1.0 + (a2 - 1.0) * h.z * h.z))
}

/// Anisotropic GTR of exponent 2 (Burley 2012, eq. 13).
fn gtr2(h: DVec3, ax: f64, ay: f64) -> f64 {
    1.0 / (PI * ax * ay * ((h.x / ax).powi(2) + (h.y / ay).powi(2) + h.z * h.z).powi(2))
}

/// Smith's masking for GGX over twice the cosine.
fn masking(cos: f64, alpha: f64) -> f64 {
    1.0 / (cos + (alpha * alpha + cos * cos * (1.0 - alpha * alpha)).sqrt())
}

#[test]
fn the_brdf_is_the_published_one() {
    let mut rng = Rng::new(21);
    for _ in 0..4000 {
        let mut u = || rng.uniform();
        let p = DisneyBrdfParams {
            base_color: Spectrum::rgb(u(), u(), u()),
            subsurface: u(),
            metallic: u(),
            specular: u(),
            specular_tint: u(),
            roughness: 0.1 + 0.85 * u(),
            anisotropic: 0.3 * u(),
            sheen: u(),
            sheen_tint: u(),
            clearcoat: u(),
            clearcoat_gloss: 0.9 * u(),
        };
        let (wo, wi) = pair(&mut rng);
        let (v, l) = (wo.as_dvec3(), wi.as_dvec3());
        let h = (v + l).normalize();
        let d = |x: f32| x as f64;
        let [r, m] = [d(p.roughness), d(p.metallic)];
        let (fl, fv, fh) = (pow5(l.z), pow5(v.z), pow5(h.dot(l)));
        let f90 = 0.5 + 2.0 * r * h.dot(l).powi(2);
        let base = mix(1.0, f90, fl) * mix(1.0, f90, fv);
        let fss = mix(1.0, r * h.dot(l).powi(2), fl) * mix(1.0, r * h.dot(l).powi(2), fv);
        let flat = 1.25 * (fss * (1.0 / (l.z + v.z) - 0.5) + 0.5);
        let aspect = (1.0 - 0.9 * d(p.anisotropic)).sqrt();
        let (ax, ay) = ((r * r / aspect).clamp(0.001, 1.0), (r * r * aspect).max(0.001));
        let ag = (0.5 + 0.5 * r).powi(2);
        let specular = gtr2(h, ax, ay) * masking(l.z, ag) * masking(v.z, ag);
        let coat = 0.25
            * d(p.clearcoat)
            * gtr1(h, mix(0.1, 0.001, d(p.clearcoat_gloss)))
            * mix(0.04, 1.0, fh)
            * masking(l.z, 0.25)
            * masking(v.z, 0.25);
        let c = p.base_color.to_rgb().map(d);
        let luminance = 0.3 * c[0] + 0.6 * c[1] + 0.1 * c[2];
        let got = DisneyBrdf::new(&p).eval(wo, wi);
        for lane in 0..3 {
            let hue = c[lane] / luminance;
            let c0 = mix(d(p.specular) * 0.08 * mix(1.0, hue, d(p.specular_tint)), c[lane], m).min(1.0);
            let sheen = fh * d(p.sheen) * mix(1.0, hue, d(p.sheen_tint));
            let want = (FRAC_1_PI * mix(base, flat, d(p.subsurface)) * c[lane] + sheen) * (1.0 - m)
                + specular * mix(c0, 1.0, fh)
                + coat;
            let error = (got[lane] as f64 - want).abs();
            // The tail of the narrowest coat loses digits in `f32`.
            assert!(error < 2e-4 * want + 1e-6, "{p:?} {wo} {wi} lane {lane}: {} for {want}", got[lane]);
        }
    }
}

/// The BSDF's parts that have a closed form: diffuse on both sides of a sheet, sheen, coat, and the smooth limit of what
/// passes a solid.
#[test]
fn the_bsdf_has_the_published_parts() {
    let mut rng = Rng::new(22);
    let at = Incidence::default();
    for _ in 0..2000 {
        let (wo, wi) = pair(&mut rng);
        let color = Spectrum::rgb(0.8, 0.5, 0.2);
        let [clear, dt] = [rng.uniform(), 2.0 * rng.uniform()];
        let p = DisneyBsdfParams {
            base_color: color,
            thin: true,
            spec_trans: clear,
            diff_trans: dt,
            flatness: rng.uniform(),
            roughness: rng.uniform(),
            ..Default::default()
        };
        let bsdf = DisneyBsdf::new(&p, &at);
        let below = Vec3A::new(wi.x, wi.y, -wi.z);
        let e = bsdf.eval_pdf(wo, below);
        let want = (1.0 - clear) * 0.5 * dt / core::f32::consts::PI;
        for lane in 0..3 {
            assert!((e.diffuse[lane] - want * color[lane]).abs() < 1e-6);
        }
        let pair = etendue_bxdf::diffuse::disney::DisneyPair::new(wo, wi);
        let shape = pair.base(p.roughness) * (1.0 - p.flatness) + pair.flat(p.roughness) * p.flatness;
        let want = (1.0 - clear) * (1.0 - 0.5 * dt) * shape / core::f32::consts::PI;
        let got = bsdf.eval_pdf(wo, wi).diffuse[0];
        assert!((got - 0.8 * want).abs() < 1e-5 * want.abs().max(1.0), "{got} {want}");
    }
    // A polished body: what passes is 1 − F times the root of the colour.
    let p = DisneyBsdfParams {
        base_color: Spectrum::rgb(0.25, 0.81, 1.0),
        spec_trans: 1.0,
        roughness: 0.0,
        ..Default::default()
    };
    let importance = Incidence { transport: Transport::Importance, ..at };
    let f = 0.04f32;
    for at in [importance, Incidence { front: false, ..importance }] {
        let got = directional_albedo(&DisneyBsdf::new(&p, &at), Vec3A::Z);
        for (lane, root) in [0.5f32, 0.9, 1.0].into_iter().enumerate() {
            let want = f + (1.0 - f) * root;
            assert!((got[lane] - want).abs() < 2e-3, "lane {lane}: {} for {want}", got[lane]);
        }
    }
    assert_eq!(p.interior().map(|i| i.ior), Some(1.5));
    assert!(DisneyBsdfParams { thin: true, ..p }.interior().is_none());
}

/// Where light is scattered under the surface.
#[test]
fn a_scatter_distance_gives_a_profile() {
    let p = DisneyBsdfParams { scatter_distance: Spectrum::rgb(0.01, 0.002, 0.0), ..Default::default() };
    let s = p.subsurface().expect("light travels");
    assert_eq!((s.radius, s.color, s.ior), (p.scatter_distance, p.base_color, p.ior));
    assert!(DisneyBsdfParams { thin: true, ..p }.subsurface().is_none());
    assert!(DisneyBsdfParams { clearcoat: 0.5, ..p }.subsurface().is_none());
    assert!(DisneyBsdfParams::default().subsurface().is_none());
}

/// The largest albedo of white surfaces over roughness × features × angles, which the claims state.
#[test]
fn the_claims_state_how_much_light_is_made() {
    let angles: &[f32] =
        if full() { &[0.0, 45.0, 60.0, 70.0, 80.0, 85.0, 88.0, 89.0] } else { &[60.0, 85.0, 89.0] };
    let white = Spectrum::ONE;
    let mut brightest = [const { (0.0f32, String::new()) }; 3];
    let inside = Incidence { front: false, transport: Transport::Importance, ..Incidence::default() };
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        for feature in 0..6 {
            let on = |k: usize| if feature == k || feature == 5 { 1.0 } else { 0.0 };
            let brdf = DisneyBrdfParams {
                base_color: white,
                roughness,
                specular: if feature == 4 { 1.0 } else { 0.5 },
                subsurface: on(1),
                sheen: on(2),
                clearcoat: on(3),
                ..Default::default()
            };
            let bsdf = DisneyBsdfParams {
                base_color: white,
                roughness,
                thin: feature == 1 || feature == 4,
                flatness: on(1),
                diff_trans: if feature == 4 { 1.0 } else { 0.0 },
                sheen: on(2),
                clearcoat: on(3),
                ..Default::default()
            };
            // A body that is hardly clear, from inside: total reflection beside the diffuse lobe.
            let clear = DisneyBsdfParams { thin: false, spec_trans: 0.01, ..bsdf };
            for &angle in angles {
                let wo = wo_at(angle);
                let found = [
                    directional_albedo(&DisneyBrdf::new(&brdf), wo)[0],
                    directional_albedo(&DisneyBsdf::new(&bsdf, &Incidence::default()), wo)[0],
                    directional_albedo(&DisneyBsdf::new(&clear, &inside), wo)[0],
                ];
                for k in 0..3 {
                    if found[k] > brightest[k].0 {
                        brightest[k] =
                            (found[k], format!("roughness {roughness} feature {feature} {angle}°"));
                    }
                }
            }
        }
    }
    println!("brightest: 2012 {:?}, 2015 {:?}, from inside {:?}", brightest[0], brightest[1], brightest[2]);
    assert!((brightest[0].0 - 1.655).abs() < 0.005, "{:?}", brightest[0]);
    assert!((brightest[1].0 - 1.715).abs() < 0.005, "{:?}", brightest[1]);
    assert!((brightest[2].0 - 2.145).abs() < 0.005, "{:?}", brightest[2]);
}
