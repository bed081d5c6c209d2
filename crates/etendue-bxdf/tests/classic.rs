//! Cook-Torrance as shaders write it, Phong, Blinn-Phong, metals by name: each against its formula, and what is wrong with it
//! in figures. (The laws are run over these models with all others by `tests/verify.rs`.)

use core::f32::consts::PI;
use etendue_bxdf::{
    Bsdf,
    classic::{
        BlinnPhongParams, BlinnPhongSurface, CookTorrance, CookTorranceDistribution, CookTorranceFresnel,
        CookTorranceMasking, CookTorranceParams, PhongParams, PhongSurface,
    },
    laws::{Rng, chi2::chi2, furnace::furnace, grid::wo_at, reciprocity::reciprocity, sidak},
    model::{Incidence, Model, ModelParams},
    multiscatter::Compensation,
    quadrature::directional_albedo,
    rough_conductor::{ConductorParams, MetalName},
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The shader of the notes, in its own words: straightforward `f64`.
fn notes(p: &CookTorranceParams, v: Vec3A, l: Vec3A) -> [f64; 3] {
    let h = (v.as_dvec3() + l.as_dvec3()).normalize();
    let (nv, nl, nh, vh) = (v.z as f64, l.z as f64, h.z, v.as_dvec3().dot(h));
    let (r, metallic) = (p.roughness as f64, p.metallic as f64);
    let a = r * r;
    let a2 = a * a;
    let denominator = nh * nh * (a2 - 1.0) + 1.0;
    let d = a2 / (core::f64::consts::PI * denominator * denominator).max(0.00001);
    let k = (r + 1.0) * (r + 1.0) / 8.0;
    let g1 = |c: f64| c / (c * (1.0 - k) + k).max(0.00001);
    let g = g1(nv) * g1(nl);
    core::array::from_fn(|i| {
        let base = p.base_color[i] as f64;
        let f0 = 0.04 + (base - 0.04) * metallic;
        let ks = f0 + (1.0 - f0) * (1.0 - vh).powi(5);
        let kd = (1.0 - ks) * (1.0 - metallic);
        let diffuse = kd * base / if p.divide_by_pi { core::f64::consts::PI } else { 1.0 };
        diffuse + d * ks * g / (4.0 * nv * nl).max(0.0001)
    })
}

#[test]
fn cook_torrance_is_the_notes_line_by_line() {
    let mut rng = Rng::new(3);
    for i in 0..20_000 {
        let p = CookTorranceParams {
            base_color: Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform()),
            metallic: rng.uniform(),
            roughness: rng.uniform(),
            divide_by_pi: i % 2 == 0,
            ..Default::default()
        };
        let v = wo_at(89.9 * rng.uniform());
        // Near the mirror direction every other time.
        let l = if i % 4 < 2 {
            Vec3A::new(-v.x, -v.y, v.z) + 0.1 * wo_at(90.0 * rng.uniform())
        } else {
            wo_at(-89.0 * rng.uniform())
        };
        let l = l.normalize();
        let (got, want) = (CookTorrance::new(&p).eval(v, l), notes(&p, v, l));
        for c in 0..3 {
            assert!(
                (got[c] as f64 - want[c]).abs() <= 1e-4 * want[c] + 1e-7,
                "{p:?} {v} {l}: {got:?} {want:?}"
            );
        }
    }
}

/// The figures in the documentation of [`CookTorrance`].
#[test]
fn cook_torrance_errs_as_documented() {
    let metal = |roughness: f32, clamps: bool| {
        CookTorrance::new(&CookTorranceParams {
            metallic: 1.0,
            roughness,
            clamps,
            base_color: Spectrum::ONE,
            ..Default::default()
        })
    };
    // At the mirror direction along the normal f = D G / 4 with F = 1, G = 1.
    let peak = |m: CookTorrance| 4.0 * m.eval(Vec3A::Z, Vec3A::Z)[0];
    assert!((peak(metal(0.1, true)) - 10.0).abs() < 0.01 && (peak(metal(0.1, false)) - 3183.1).abs() < 1.0);
    assert_eq!(peak(metal(0.0, true)), 0.0);
    // The clamp begins where π a⁴ = 10⁻⁵, at r = 0.2055.
    assert!((peak(metal(0.207, true)) - peak(metal(0.207, false))).abs() < 1e-2);
    assert!(peak(metal(0.2, true)) < 0.95 * peak(metal(0.2, false)));
    // A white dielectric without ÷π is about π times as bright.
    let white = |divide_by_pi: bool, roughness: f32| {
        let p =
            CookTorranceParams { divide_by_pi, roughness, base_color: Spectrum::ONE, ..Default::default() };
        move |wo| directional_albedo(&CookTorrance::new(&p), wo)[0]
    };
    let (with, without) = (white(true, 1.0)(Vec3A::Z), white(false, 1.0)(Vec3A::Z));
    println!("white dielectric, r = 1, along the normal: {with:.3}, without ÷π {without:.3}");
    assert!(with < 1.0 && (2.9..3.2).contains(&without));
    let worst = white(true, 0.3)(wo_at(85.0));
    println!("white dielectric, r = 0.3, 85°: {worst:.3}");
    assert!(worst > 1.0, "the half-vector coupling makes light at grazing angles: {worst}");
    // Smith's masking and F = 1 never make light, whatever the distribution with an exact Λ.
    for distribution in [CookTorranceDistribution::Ggx, CookTorranceDistribution::Beckmann] {
        let p = CookTorranceParams {
            distribution,
            metallic: 1.0,
            clamps: false,
            base_color: Spectrum::ONE,
            masking: CookTorranceMasking::Smith,
            ..Default::default()
        };
        assert!(directional_albedo(&CookTorrance::new(&p), wo_at(70.0)).max_element() <= 1.0);
    }
}

/// Reciprocal with the half vector's Fresnel, with every distribution and masking; not with the view's.
#[test]
fn cook_torrance_turns_round_where_it_says() {
    use CookTorranceDistribution as D;
    use CookTorranceMasking as M;
    for distribution in [D::Ggx, D::Beckmann, D::Gtr, D::BlinnPhong] {
        for masking in [M::SchlickDirect, M::SchlickIndirect, M::Smith, M::SmithSeparable, M::VCavity] {
            let p = CookTorranceParams { distribution, masking, gamma: 1.3, ..Default::default() };
            let found = reciprocity(&CookTorrance::new(&p), 2000, 7);
            assert!(found.error < 1e-4, "{p:?}: {found:?}");
        }
    }
    let p = CookTorranceParams { fresnel: CookTorranceFresnel::SchlickView, ..Default::default() };
    assert!(reciprocity(&CookTorrance::new(&p), 2000, 7).error > 0.1);
}

#[test]
fn phong_and_blinn_phong_meet_their_formulas() {
    let mut rng = Rng::new(4);
    for i in 0..5000 {
        let exponent = (rng.uniform() * 7.0).exp();
        let normalized = i % 2 == 0;
        let (diffuse, specular) = (Spectrum::rgb(0.3, 0.2, 0.1), Spectrum::rgb(0.1, 0.5, 0.6));
        let (wo, wi) = (wo_at(85.0 * rng.uniform()), wo_at(-85.0 * rng.uniform()));
        let r = Vec3A::new(-wo.x, -wo.y, wo.z).as_dvec3();
        let n = exponent as f64;
        let (kd, ks) = if normalized { (1.0 / PI as f64, (n + 2.0) / (2.0 * PI as f64)) } else { (1.0, 1.0) };
        let phong = PhongSurface::new(&PhongParams { diffuse, specular, exponent, normalized });
        let want = 0.3 * kd + 0.1 * ks * r.dot(wi.as_dvec3()).max(0.0).powf(n);
        let got = phong.eval(wo, wi)[0] as f64;
        assert!((got - want).abs() < 3e-4 * want, "phong {n} {wo} {wi}: {got} {want}");
        let blinn = BlinnPhongSurface::new(&BlinnPhongParams { diffuse, specular, exponent, normalized });
        let h = (wo.as_dvec3() + wi.as_dvec3()).normalize();
        let ks = if normalized {
            (n + 2.0) * (n + 4.0) / (8.0 * PI as f64 * (2f64.powf(-n / 2.0) + n))
        } else {
            1.0
        };
        let want = 0.3 * kd + 0.1 * ks * h.z.powf(n);
        let got = blinn.eval(wo, wi)[0] as f64;
        assert!((got - want).abs() < 3e-4 * want, "blinn-phong {n} {wo} {wi}: {got} {want}");
    }
}

/// Normalised, a highlight alone returns at most the sky, and all of it along the normal.
#[test]
fn normalised_highlights_keep_energy() {
    for exponent in [1.0, 5.0, 50.0, 1000.0, 10_000.0] {
        let (diffuse, specular) = (Spectrum::ZERO, Spectrum::ONE);
        let phong = PhongSurface::new(&PhongParams { diffuse, specular, exponent, normalized: true });
        let blinn =
            BlinnPhongSurface::new(&BlinnPhongParams { diffuse, specular, exponent, normalized: true });
        let both: [(&str, &dyn Bsdf); 2] = [("phong", &phong), ("blinn-phong", &blinn)];
        for (name, bsdf) in both {
            let along = directional_albedo(bsdf, Vec3A::Z)[0];
            assert!((along - 1.0).abs() < 1e-3, "{name} {exponent}: {along}");
            for angle in [30.0, 60.0, 80.0, 89.0] {
                let a = directional_albedo(bsdf, wo_at(angle))[0];
                assert!(a <= 1.001, "{name} {exponent} {angle}°: {a}");
            }
        }
    }
    // Not normalised the same highlight returns what its exponent makes of it: 2π/(n + 2).
    let p =
        PhongParams { diffuse: Spectrum::ZERO, specular: Spectrum::ONE, exponent: 1.0, normalized: false };
    assert!((directional_albedo(&PhongSurface::new(&p), Vec3A::Z)[0] - 2.0 * PI / 3.0).abs() < 1e-3);
}

/// Drawn directions follow their density, and weights average to the integral, at the corners of the parameters.
#[test]
fn sampling_is_sound_at_the_corners() {
    let mut models = Vec::new();
    for text in [
        "phong exponent=3",
        "phong exponent=3000",
        "phong normalized=false exponent=20",
        "blinn-phong exponent=3",
        "blinn-phong exponent=9000",
        "blinn-phong normalized=false",
        "cook-torrance roughness=0.05",
        "cook-torrance roughness=0.05 clamps=false",
        "cook-torrance distribution=beckmann masking=smith roughness=0.2 clamps=false",
        "cook-torrance distribution=gtr gamma=1 masking=v-cavity roughness=0.4",
        "cook-torrance distribution=blinn-phong metallic=1",
        "cook-torrance divide_by_pi=false fresnel=rough-view",
        "conductor material=gold roughness=0.5 anisotropy=0.9",
        "conductor curve=colors roughness=0.02",
        "conductor material=tungsten roughness=1",
    ] {
        let mut words = text.split(' ');
        let mut model = Model::by_name(words.next().expect("a name")).expect(text);
        for (name, value) in words.filter_map(|w| w.split_once('=')) {
            model.set_text(name, value).expect(text);
        }
        models.push((text, model));
    }
    let level = sidak(0.01, models.len() * 3);
    for (i, (text, model)) in models.iter().enumerate() {
        let closure = model.closure(&Incidence::default());
        for angle in [0.0, 50.0, 88.0] {
            let found = chi2(&closure, wo_at(angle), 40_000, i as u64);
            assert!(found.p >= level, "{text} {angle}°: {found:?}");
            let f = furnace(&closure, wo_at(angle), 20_000, 0x77 + i as u64);
            assert!(f.z < 4.7, "{text} {angle}°: {f:?}");
            // A lobe that is badly drawn shows as a variance far above this.
            let relative = f.variance.max_element() / f.albedo.max_element().powi(2).max(1e-4);
            assert!(relative < 12.0, "{text} {angle}°: {f:?}");
        }
    }
}

/// What a named metal reflects is its table's curve.
#[test]
fn named_metals_have_their_curves() {
    for (material, name) in [(MetalName::Gold, "gold"), (MetalName::Iron, "iron"), (MetalName::Custom, "")] {
        let p = ConductorParams { material, roughness: 0.0, ..Default::default() };
        let closure = p.closure(&Incidence::default());
        for angle in [0.0, 45.0, 82.0] {
            let wo = wo_at(angle);
            let got = directional_albedo(&closure, wo);
            let want = match etendue_bxdf::ior_table::by_name(name) {
                Some(etendue_bxdf::ior_table::Measured::Metal(m)) => m.conductor().eval(wo.z),
                _ => etendue_bxdf::Conductor::new(p.eta, p.k).eval(wo.z),
            };
            assert!((got - want).map(f32::abs).max_element() < 1e-6, "{name} {angle}°: {got:?} {want:?}");
        }
    }
    // Rough gold gets back what its microfacets lose, and no more than came in.
    let p = ConductorParams { material: MetalName::Gold, roughness: 0.6, ..Default::default() };
    let gold = directional_albedo(&p.closure(&Incidence::default()), wo_at(40.0));
    let single = ConductorParams { compensation: Compensation::None, ..p };
    let single = directional_albedo(&single.closure(&Incidence::default()), wo_at(40.0));
    assert!((0..3).all(|i| gold[i] > single[i] && gold[i] <= 1.001), "{gold:?} {single:?}");
    assert!(gold[0] > 2.0 * gold[2], "{gold:?}");
}
