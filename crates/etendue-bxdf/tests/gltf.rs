//! The glTF surface beyond what `verify` asks of every model.
//!
//! By default some dozens of random surfaces; with `ETENDUE_FULL=1` some thousands.

use etendue_bxdf::{
    Bsdf, Gltf, GltfParams, MetalRough, MetalRoughParams,
    laws::{Rng, chi2::chi2, furnace::furnace, grid::wo_at, reciprocity, sidak},
    model::{Incidence, ModelParams, Transport},
    multiscatter::Compensation,
    quadrature::directional_albedo,
    thin_film::Lanes,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

fn count(quick: usize, full: usize) -> usize {
    if std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1") { full } else { quick }
}

/// 0 or 1 often, anything between else.
fn strength(rng: &mut Rng) -> f32 {
    match rng.bits() % 4 {
        0 => 0.0,
        1 => 1.0,
        _ => rng.uniform(),
    }
}

/// White often: the worst case for energy.
fn colour(rng: &mut Rng) -> Spectrum {
    if rng.bits().is_multiple_of(2) {
        Spectrum::rgb(1.0, 1.0, 1.0)
    } else {
        Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform())
    }
}

/// A feature is on every other time.
fn sometimes(rng: &mut Rng) -> f32 {
    if rng.bits().is_multiple_of(2) { 0.0 } else { strength(rng) }
}

/// Further bounces or none.
fn way(rng: &mut Rng) -> Compensation {
    [Compensation::None, Compensation::KullaConty][(rng.bits() % 2) as usize]
}

/// Any surface whose coat keeps the base's normal.
fn random(rng: &mut Rng) -> GltfParams {
    GltfParams {
        base_color: colour(rng),
        metallic: sometimes(rng),
        roughness: strength(rng),
        ior: [0.0, 1.0, 1.33, 1.5, 2.42, 4.0][(rng.bits() % 6) as usize],
        specular: strength(rng),
        specular_color: colour(rng) * (1.0 + 3.0 * rng.uniform()),
        clearcoat: sometimes(rng),
        clearcoat_roughness: strength(rng),
        clearcoat_normal: Vec3A::Z,
        coat_ior: 1.0 + 1.5 * rng.uniform(),
        coat_color: colour(rng),
        coat_darkening: sometimes(rng),
        coat_anisotropy_strength: sometimes(rng) * 0.7,
        coat_tangent: vec3a(rng.uniform() - 0.5, rng.uniform() - 0.5, 0.0),
        fuzz: sometimes(rng),
        fuzz_color: colour(rng),
        fuzz_roughness: strength(rng),
        sheen_color: colour(rng) * sometimes(rng),
        sheen_roughness: strength(rng),
        transmission: sometimes(rng),
        thickness: strength(rng),
        attenuation_color: colour(rng),
        attenuation_distance: 1.0,
        scatter_strength: sometimes(rng),
        multiscatter_color: colour(rng),
        scatter_anisotropy: 2.0 * rng.uniform() - 1.0,
        iridescence: sometimes(rng),
        iridescence_ior: 1.0 + 1.5 * rng.uniform(),
        iridescence_thickness: 1200.0 * rng.uniform(),
        // Within what quadrature can resolve; a line in place of a lobe is a case of `verify`.
        anisotropy_strength: sometimes(rng) * 0.7,
        dispersion: sometimes(rng),
        diffuse_transmission: sometimes(rng),
        diffuse_transmission_color: colour(rng),
        diffuse_roughness: sometimes(rng),
        compensation: way(rng),
    }
}

fn power(front: bool) -> Incidence {
    Incidence { front, transport: Transport::Importance, ..Default::default() }
}

/// Without extensions the closure is the plain one, to the bit.
#[test]
fn a_plain_surface_is_metal_rough() {
    let mut rng = Rng::new(1);
    for _ in 0..20_000 {
        let p = MetalRoughParams {
            base_color: colour(&mut rng),
            metallic: strength(&mut rng),
            roughness: strength(&mut rng),
            ior: 1.0 + rng.uniform(),
            specular: strength(&mut rng),
            specular_color: colour(&mut rng),
            compensation: way(&mut rng),
        };
        let plain = MetalRough::new(&p);
        // What an extension would need without the extension that uses it changes nothing.
        let full = GltfParams { thickness: 1.0, dispersion: 0.5, sheen_roughness: 0.3, ..p.into() };
        let closure = full.closure(&Incidence::default());
        let (wo, wi) = (wo_at(89.0 * rng.uniform()), wo_at(89.0 * rng.uniform()) * vec3a(-1.0, 1.0, 1.0));
        assert_eq!(closure.eval_pdf(wo, wi), plain.eval_pdf(wo, wi));
        let (uc, u) = (rng.uniform(), rng.square());
        assert_eq!(closure.sample(wo, uc, u), plain.sample(wo, uc, u));
        assert_eq!(closure.albedo(wo), plain.albedo(wo));
        assert_eq!(closure.deltas(wo), plain.deltas(wo));
    }
}

/// A white metal returns all light at each roughness and angle, plain or with an anisotropy that does not show; without
/// compensation it loses what theory says.
#[test]
fn a_white_metal_loses_nothing() {
    for roughness in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0] {
        for degrees in [0.0f32, 30.0, 60.0, 75.0, 85.0] {
            let wo = wo_at(degrees);
            let p = MetalRoughParams { metallic: 1.0, roughness, ..Default::default() };
            let general = GltfParams { anisotropy_strength: 1e-7, ..p.into() };
            let general = general.closure(&Incidence::default());
            for albedo in [directional_albedo(&MetalRough::new(&p), wo), directional_albedo(&general, wo)] {
                assert!((albedo[0] - 1.0).abs() < 1e-3, "{roughness} {degrees}: {albedo:?}");
            }
        }
    }
    let bare = MetalRoughParams { metallic: 1.0, compensation: Compensation::None, ..Default::default() };
    let kept = directional_albedo(&MetalRough::new(&bare), Vec3A::Z)[0];
    assert!((kept - (1.0 - std::f32::consts::LN_2)).abs() < 1e-3, "{kept}");
}

/// An extension of vanishing strength is no extension: the general closure meets the plain one.
#[test]
fn a_vanishing_extension_changes_nothing() {
    let mut rng = Rng::new(2);
    let least = 1e-7;
    for i in 0..6000 {
        let p = MetalRoughParams {
            base_color: colour(&mut rng),
            metallic: strength(&mut rng),
            roughness: 0.05 + 0.95 * rng.uniform(),
            ior: 1.0 + rng.uniform(),
            specular: strength(&mut rng),
            specular_color: colour(&mut rng),
            compensation: way(&mut rng),
        };
        let q = GltfParams { clearcoat_roughness: 0.5, sheen_roughness: 0.5, ..p.into() };
        let q = match i % 6 {
            0 => GltfParams { clearcoat: least, ..q },
            1 => GltfParams { sheen_color: Spectrum::splat(least), ..q },
            2 => GltfParams { transmission: least, ..q },
            3 => GltfParams { iridescence: least, ..q },
            4 => GltfParams { anisotropy_strength: least, ..q },
            _ => GltfParams { diffuse_transmission: least, ..q },
        };
        let (wo, wi) = (wo_at(80.0 * rng.uniform()), wo_at(80.0 * rng.uniform()) * vec3a(-1.0, 0.3, 1.0));
        let wi = wi.normalize();
        let (a, b) =
            (q.closure(&Incidence::default()).eval_pdf(wo, wi), MetalRough::new(&p).eval_pdf(wo, wi));
        for lane in 0..3 {
            // Under a film the mean of Fresnel's term comes from a rule, right to 1e-3; elsewhere from the same table.
            let tolerance = if i % 6 == 3 { 3e-3 } else { 2e-4 };
            let close = |x: f32, y: f32| (x - y).abs() <= tolerance * x.max(y) + 1e-6;
            assert!(close(a.diffuse[lane], b.diffuse[lane]), "{i} {q:?}: {a:?} {b:?}");
            assert!(close(a.specular[lane], b.specular[lane]), "{i} {q:?}: {a:?} {b:?}");
        }
    }
}

/// Any combination of all extensions, seen from both sides, returns at most the sky.
#[test]
fn no_combination_makes_light() {
    let mut rng = Rng::new(3);
    let mut brightest = (0.0f32, String::new());
    let n = count(40, 5000);
    for i in 0..n {
        let p = random(&mut rng);
        let closure = p.closure(&power(i % 3 != 0));
        let angle = [0.0, 30.0, 60.0, 80.0, 87.0][(rng.bits() % 5) as usize];
        let albedo = directional_albedo(&closure, wo_at(angle)).max_element();
        if albedo > brightest.0 {
            brightest = (albedo, format!("{angle}° {p:?}"));
        }
    }
    println!("{n} surfaces, brightest {brightest:?}");
    assert!(brightest.0 <= 1.001, "{brightest:?}");
}

/// Samples of random surfaces, coats with normals of their own among them, follow their density; the mean of their weights is
/// the albedo by quadrature and does not exceed one.
#[test]
fn samples_of_any_combination_follow_their_density() {
    let mut rng = Rng::new(4);
    let n = count(12, 1000);
    let level = sidak(0.01, n);
    for i in 0..n {
        let mut p = random(&mut rng);
        // Widths that quadrature's bins resolve together.
        p.roughness = 0.25 + 0.75 * p.roughness;
        p.clearcoat_roughness = 0.3 + 0.7 * p.clearcoat_roughness;
        if i % 3 == 1 {
            (p.anisotropy_strength, p.transmission) = (0.6, 0.0);
        }
        if i % 2 == 0 {
            p.clearcoat_normal = vec3a(0.6 * rng.uniform(), 0.6 * rng.uniform() - 0.3, 1.0);
        }
        let closure = p.closure(&power(i % 3 != 0));
        let wo = wo_at(80.0 * rng.uniform());
        let c = chi2(&closure, wo, count(20_000, 200_000), i as u64);
        assert!(c.p >= level, "{p:?} {wo}: {c:?}");
        let f = furnace(&closure, wo, count(5_000, 100_000), i as u64);
        let most = f.sampled.max_element() - 4.0 * f.error.max_element();
        assert!(most <= 1.001, "{p:?} {wo}: {f:?}");
    }
}

/// Reflection is reciprocal as long as the coat keeps the base's normal and does not darken, and without fuzz.
#[test]
fn light_may_turn_round() {
    let mut rng = Rng::new(5);
    for i in 0..count(60, 3000) {
        let p = GltfParams { fuzz: 0.0, coat_darkening: 0.0, ..random(&mut rng) };
        let closure = p.closure(&power(i % 3 != 0));
        let r = reciprocity::reciprocity(&closure, 400, i as u64);
        assert!(r.error <= 2e-4, "{p:?}: {r:?}");
        // Through thin sheets and clear boundaries too.
        let diffuse = p.transmission < 1.0 && p.diffuse_transmission > 0.0;
        let solid = p.transmission > 0.0 && p.thickness > 0.0;
        // A refracted lobe of α = 1e-4 has no more than three digits in `f32`, other ones from the other side.
        let resolved = p.roughness >= 0.1 || p.roughness == 0.0 && p.anisotropy_strength == 0.0;
        if resolved && !(solid && diffuse) {
            // Seen from behind the frame is turned about x, and the brushing with it.
            let tangent = vec3a(p.coat_tangent.x, -p.coat_tangent.y, p.coat_tangent.z);
            let behind = GltfParams { coat_tangent: tangent, ..p };
            let (near, far) = (p.closure(&power(true)), behind.closure(&power(false)));
            let r = reciprocity::reciprocity_through(&near, &far, Transport::Importance, 400, i as u64);
            assert!(r.error <= 2e-3, "{p:?}: {r:?}");
        }
    }
}

/// The terms of the extensions that have one value: coat, sheen, diffuse transmission, tint, anisotropy, interior.
#[test]
fn extensions_mean_what_they_say() {
    let at = Incidence::default();
    let wo = wo_at(40.0);
    let mirrored = vec3a(-wo.x, -wo.y, wo.z);
    // Anisotropy: αx = mix(α, 1, strength²), αy = α.
    let p = GltfParams { roughness: 0.5, metallic: 1.0, anisotropy_strength: 0.6, ..Default::default() };
    let [ax, ay] = p.closure(&at).narrowest_alpha();
    assert!((ax - (0.25 + 0.75 * 0.36)).abs() < 1e-6 && ay == 0.25);
    // A perfect coat over black: Schlick with F0 = 0.04 at the mirror direction.
    let black = GltfParams { base_color: Spectrum::ZERO, specular: 0.0, ..Default::default() };
    let coat = GltfParams { clearcoat: 0.5, ..black }.closure(&at).deltas(wo)[0].expect("a mirror");
    let w = (1.0 - wo.z).powi(5);
    assert!((coat.wi - mirrored).length() < 1e-6);
    assert!((coat.reflectance[0] - 0.5 * (0.04 + 0.96 * w)).abs() < 1e-6);
    // Its own normal turns the mirror.
    let tilted = GltfParams { clearcoat: 1.0, clearcoat_normal: vec3a(0.3, 0.0, 1.0), ..black };
    let d = tilted.closure(&at).deltas(wo)[0].expect("a mirror");
    let n = vec3a(0.3, 0.0, 1.0).normalize();
    assert!((d.wi - (n * (2.0 * n.dot(wo)) - wo)).length() < 1e-5);
    // Diffuse transmission: the colour, behind.
    let leaf = GltfParams {
        specular: 0.0,
        diffuse_transmission: 0.25,
        diffuse_transmission_color: Spectrum::rgb(0.2, 0.8, 0.1),
        base_color: Spectrum::rgb(0.5, 0.5, 0.5),
        ..Default::default()
    };
    let (front, behind) = (leaf.closure(&at).eval(wo, mirrored), leaf.closure(&at).eval(wo, -wo));
    let inv_pi = core::f32::consts::FRAC_1_PI;
    assert!((front[0] - 0.75 * 0.5 * inv_pi).abs() < 1e-6 && (behind[1] - 0.25 * 0.8 * inv_pi).abs() < 1e-6);
    // A clear thin pane of colour: straight through, tinted, what is not reflected.
    let pane = GltfParams {
        transmission: 1.0,
        roughness: 0.0,
        base_color: Spectrum::rgb(0.9, 0.5, 0.1),
        ..Default::default()
    };
    let [_, through] = pane.closure(&at).deltas(wo);
    let through = through.expect("a pane");
    let f = 0.04 + 0.96 * w;
    assert!((through.wi + wo).length() < 1e-6 && (through.reflectance[1] - 0.5 * (1.0 - f)).abs() < 1e-6);
    assert!(pane.interior().is_none());
    // With a volume it is refracted, by Snell; the interior absorbs its colour at its distance.
    let ball = GltfParams {
        thickness: 1.0,
        attenuation_color: Spectrum::rgb(0.25, 0.5, 1.0),
        attenuation_distance: 2.0,
        dispersion: 0.5,
        ..pane
    };
    let [_, refracted] = ball.closure(&at).deltas(wo);
    let sin = |w: Vec3A| w.x.hypot(w.y);
    assert!((sin(refracted.expect("a boundary").wi) * 1.5 - sin(wo)).abs() < 1e-5);
    let interior = ball.interior().expect("a volume");
    assert!((interior.absorption[0] - 4f32.ln() / 2.0).abs() < 1e-5 && interior.absorption[2] < 1e-6);
    assert!(interior.ior == 1.5 && interior.dispersive);
    // Dispersion: red bends less than blue, green as without.
    let bent = |lane| {
        let at = Incidence { lane: Some(lane), ..at };
        sin(ball.closure(&at).deltas(wo)[1].expect("a boundary").wi)
    };
    assert!((sin(wo) / bent(0) - (1.5 - 0.5 * 0.025 * 0.5)).abs() < 1e-4);
    assert!(
        (sin(wo) / bent(1) - 1.5).abs() < 1e-4
            && (sin(wo) / bent(2) - (1.5 + 0.5 * 0.025 * 0.5)).abs() < 1e-4
    );
    // By wavelength: Cauchy's equation; at the d line the index itself.
    let nm = [486.13, 587.56, 656.27, 420.0];
    let index = |lane| {
        let at = Incidence { lane: Some(lane), ..at };
        let closure = Gltf::new(&ball, &at, Lanes::Wavelengths(nm));
        sin(wo) / sin(closure.deltas(wo)[1].expect("a boundary").wi)
    };
    // V = (n_d − 1) / (n_F − n_C) = 20 / dispersion.
    assert!((index(1) - 1.5).abs() < 1e-4 && (0.5 / (index(0) - index(2)) - 40.0).abs() < 0.5);
    // Total reflection is complete even where `specular` lowers the Fresnel term.
    let inside = Incidence { front: false, ..at };
    let weak = GltfParams { specular: 0.3, ..ball }.closure(&inside);
    let d = weak.deltas(wo_at(60.0))[0].expect("total reflection");
    assert!((d.reflectance[0] - 1.0).abs() < 1e-6 && weak.deltas(wo_at(60.0))[1].is_none());
    // Specular-glossiness: F0 itself, and a diffuse part that it leaves room for.
    let old =
        GltfParams::specular_glossiness(Spectrum::rgb(0.5, 0.5, 0.5), Spectrum::rgb(0.3, 0.1, 0.6), 1.0);
    let d = old.closure(&at).deltas(Vec3A::Z)[0].expect("fully glossy");
    assert!((d.reflectance[0] - 0.3).abs() < 1e-6 && (d.reflectance[2] - 0.6).abs() < 1e-6);
}
