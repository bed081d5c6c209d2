//! What drafts of extensions add to the glTF surface, beyond what `verify` asks of every model.

use core::f32::consts::FRAC_1_PI;
use etendue_bxdf::{
    Bsdf, GltfParams, MetalRough, MetalRoughParams,
    diffuse::eon::EonParams,
    laws::{Rng, grid::wo_at},
    model::{Incidence, ModelParams},
    quadrature::directional_albedo,
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

fn closure(p: &GltfParams) -> impl Bsdf + use<> {
    p.closure(&Incidence::default())
}

/// At roughness 0 the surface is the one without the extension, to the bit; near it, nearly.
#[test]
fn diffuse_roughness_begins_at_lambert() {
    let mut rng = Rng::new(1);
    for _ in 0..2000 {
        let p = MetalRoughParams {
            roughness: 0.05 + 0.95 * rng.uniform(),
            base_color: Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform()),
            ..Default::default()
        };
        let (wo, wi) = (wo_at(80.0 * rng.uniform()), wo_at(80.0 * rng.uniform()) * vec3a(-1.0, 0.5, 1.0));
        let wi = wi.normalize();
        let plain = MetalRough::new(&p).eval_pdf(wo, wi);
        assert_eq!(closure(&GltfParams { diffuse_roughness: 0.0, ..p.into() }).eval_pdf(wo, wi), plain);
        let near = closure(&GltfParams { diffuse_roughness: 1e-6, ..p.into() }).eval_pdf(wo, wi);
        for lane in 0..3 {
            let (a, b) = (near.diffuse[lane], plain.diffuse[lane]);
            assert!((a - b).abs() <= 2e-4 * b + 1e-6, "{p:?}: {a} {b}");
        }
    }
}

/// Under nothing that reflects it is EON itself.
#[test]
fn a_bare_rough_surface_is_eon() {
    for r in [0.1, 0.5, 1.0] {
        let color = Spectrum::rgb(0.9, 0.5, 0.1);
        let p = GltfParams { specular: 0.0, base_color: color, diffuse_roughness: r, ..Default::default() };
        let (bare, eon) =
            (closure(&p), EonParams { base_color: color, roughness: r }.closure(&Incidence::default()));
        for (wo, wi) in [(10.0, 70.0), (60.0, 30.0), (80.0, 75.0)].map(|(a, b)| (wo_at(a), wo_at(b))) {
            for wi in [wi, wi * vec3a(-1.0, 1.0, 1.0)] {
                let (a, b) = (bare.eval_pdf(wo, wi).diffuse, eon.eval_pdf(wo, wi).diffuse);
                // The six nodes of the mean find EON's own mean within this.
                assert!(
                    (a - b).map(f32::abs).max_element() < 2e-3 * b.max_element(),
                    "{r} {wo}: {a:?} {b:?}"
                );
            }
        }
    }
}

/// A rough white base under its gloss, a coat, sheen or a film: never brighter than the sky, and little darker.
#[test]
fn rough_diffuse_light_is_not_gained_under_layers() {
    let white = GltfParams { diffuse_roughness: 1.0, roughness: 0.3, ..Default::default() };
    let layered = [
        ("gloss", white),
        ("mirror", GltfParams { roughness: 0.0, ..white }),
        ("dense gloss", GltfParams { ior: 2.4, ..white }),
        ("half rough", GltfParams { diffuse_roughness: 0.5, ..white }),
        ("coat", GltfParams { clearcoat: 1.0, clearcoat_roughness: 0.2, ..white }),
        ("coat, no gloss", GltfParams { clearcoat: 1.0, specular: 0.0, ..white }),
        ("sheen", GltfParams { sheen_color: Spectrum::ONE, sheen_roughness: 0.3, ..white }),
        ("film", GltfParams { iridescence: 1.0, ..white }),
        ("brushed", GltfParams { anisotropy_strength: 0.6, ..white }),
        (
            "coat over sheen",
            GltfParams { clearcoat: 1.0, sheen_color: Spectrum::ONE, sheen_roughness: 0.1, ..white },
        ),
    ];
    for (name, p) in layered {
        let (mut most, mut darkest) = (0.0f32, 1.0f32);
        for degrees in [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 87.0] {
            let wo = wo_at(degrees);
            let rough = directional_albedo(&closure(&p), wo)[0];
            let even = directional_albedo(&closure(&GltfParams { diffuse_roughness: 0.0, ..p }), wo)[0];
            most = most.max(rough);
            darkest = darkest.min(rough / even);
        }
        println!("{name}: at most {most:.5}, at least {darkest:.4} of the even surface");
        assert!(most <= 1.001 && darkest > 0.97, "{name}: {most} {darkest}");
    }
}

/// Light that comes out behind a rough sheet leaves by the mirror image of where it would be reflected to.
#[test]
fn what_passes_a_rough_sheet_is_mirrored() {
    let p =
        GltfParams { specular: 0.0, diffuse_transmission: 0.5, diffuse_roughness: 0.7, ..Default::default() };
    let c = closure(&p);
    let wo = wo_at(50.0);
    for wi in [wo_at(30.0), wo_at(70.0), vec3a(-0.6, 0.0, 0.8), vec3a(0.0, 0.6, 0.8)] {
        let (near, far) = (c.eval_pdf(wo, wi), c.eval_pdf(wo, wi * vec3a(1.0, 1.0, -1.0)));
        assert!((near.diffuse[0] - far.diffuse[0]).abs() < 1e-5 * near.diffuse[0], "{near:?} {far:?}");
    }
    assert!(
        c.eval_pdf(wo, wo_at(70.0)).diffuse[0]
            > c.eval_pdf(wo, wo_at(70.0) * Vec3A::new(-1.0, 1.0, 1.0)).diffuse[0]
    );
}

/// A coat of index 1.5, clear and without darkening, is the clearcoat: the parameters that only other coats use change nothing.
#[test]
fn a_plain_coat_is_a_clearcoat() {
    let mut rng = Rng::new(7);
    for _ in 0..500 {
        let p = GltfParams {
            clearcoat: rng.uniform(),
            clearcoat_roughness: rng.uniform(),
            clearcoat_normal: vec3a(0.4 * rng.uniform(), 0.0, 1.0),
            roughness: rng.uniform(),
            ..Default::default()
        };
        let same = GltfParams { coat_tangent: vec3a(0.0, 1.0, 0.0), coat_ior: 1.5, ..p };
        let near = GltfParams {
            coat_color: Spectrum::splat(1.0 - 1e-6),
            coat_darkening: 1e-6,
            coat_ior: 1.500_001,
            ..p
        };
        let (wo, wi) = (wo_at(80.0 * rng.uniform()), wo_at(80.0 * rng.uniform()) * vec3a(-1.0, 1.0, 1.0));
        let [a, b, c] = [p, same, near].map(|p| closure(&p).eval_pdf(wo, wi));
        assert_eq!(a, b);
        for (x, y) in [(a.diffuse, c.diffuse), (a.specular, c.specular)] {
            assert!((x - y).map(f32::abs).max_element() < 1e-4 * y.max_element() + 1e-5, "{p:?} {a:?} {c:?}");
        }
    }
}

/// What a mirror of index 1 and a colour does is absorb: the colour at normal incidence, a power of it elsewhere. (At index 1 the path
/// through the coat is 1 / cos long, there and back.)
#[test]
fn a_coat_absorbs_by_the_length_of_the_path() {
    let color = Spectrum::rgb(0.9, 0.5, 0.1);
    let base = GltfParams { specular: 0.0, ..Default::default() };
    let coat = GltfParams { clearcoat: 1.0, coat_ior: 1.0, coat_color: color, ..base };
    let clear = GltfParams { coat_color: Spectrum::ONE, ..coat };
    for (a, b) in [(0.0f32, 0.0f32), (0.0, 60.0), (60.0, 0.0), (45.0, 70.0)] {
        let (wo, wi) = (wo_at(a), wo_at(b) * vec3a(-1.0, 1.0, 1.0));
        let ratio = |lane: usize| {
            closure(&coat).eval_pdf(wo, wi).diffuse[lane] / closure(&clear).eval_pdf(wo, wi).diffuse[lane]
        };
        let power = 0.5 * (1.0 / wo.z + 1.0 / wi.z);
        for lane in 0..3 {
            let expected = color[lane].powf(power);
            assert!((ratio(lane) - expected).abs() < 1e-4, "{a} {b} {lane}: {} {expected}", ratio(lane));
        }
    }
    // Half covered, it absorbs half.
    let half = GltfParams { clearcoat: 0.5, ..coat };
    let half_clear = GltfParams { clearcoat: 0.5, ..clear };
    let [a, b] = [half, half_clear].map(|p| closure(&p).eval_pdf(Vec3A::Z, wo_at(1.0)).diffuse[1]);
    assert!((a / b - 0.75).abs() < 1e-3, "{}", a / b);
}

/// Light to and fro darkens a coloured base, saturates it, and leaves black and white as they are.
#[test]
fn darkening_is_that_of_the_base() {
    let returned = |base: f32, darkening: f32| {
        let p = GltfParams {
            base_color: Spectrum::splat(base),
            specular: 0.0,
            clearcoat: 1.0,
            coat_darkening: darkening,
            ..Default::default()
        };
        directional_albedo(&closure(&p), wo_at(30.0))[0]
    };
    let coat = returned(0.0, 1.0);
    let [white, grey, dark] = [1.0, 0.5, 0.1].map(|b| (returned(b, 1.0) - coat) / (returned(b, 0.0) - coat));
    assert!((white - 1.0).abs() < 1e-3, "{white}");
    // (1 − K) / (1 − E K) with K = 1 − (1 − 0.0918) / 2.25 = 0.5964 of a rough base under index 1.5.
    for (found, e) in [(grey, 0.5), (dark, 0.1)] {
        let k = 0.5964;
        let expected = (1.0 - k) / (1.0 - e * k);
        assert!((found / expected - 1.0).abs() < 5e-3, "{found} {expected}");
    }
    // A metal of the same colour is smoother to the light within: it darkens less.
    let metal = |darkening: f32| {
        let p = GltfParams {
            base_color: Spectrum::splat(0.5),
            metallic: 1.0,
            roughness: 0.2,
            clearcoat: 1.0,
            coat_darkening: darkening,
            ..Default::default()
        };
        directional_albedo(&closure(&p), wo_at(30.0))[0] - coat
    };
    let ratio = metal(1.0) / metal(0.0);
    assert!(ratio > grey && ratio < 1.0, "{ratio} {grey}");
}

/// The fuzz lies on top of the coat, dims it, and may be black.
#[test]
fn fuzz_lies_over_the_coat() {
    let coated =
        GltfParams { clearcoat: 1.0, clearcoat_roughness: 0.3, roughness: 0.4, ..Default::default() };
    let soot = GltfParams { fuzz: 1.0, fuzz_color: Spectrum::ZERO, fuzz_roughness: 0.8, ..coated };
    let lint = GltfParams { fuzz_color: Spectrum::ONE, ..soot };
    for degrees in [10.0, 50.0, 80.0] {
        let wo = wo_at(degrees);
        let left = 1.0 - etendue_bxdf::sheen::Fuzz::new(Spectrum::ONE, 0.8).reflectance(wo.z);
        for wi in [wo_at(40.0) * vec3a(-1.0, 1.0, 1.0), wo_at(70.0)] {
            let (a, b) = (closure(&coated).eval_pdf(wo, wi), closure(&soot).eval_pdf(wo, wi));
            // All that lies below, the coat's reflection with it.
            assert!((b.specular[0] - left * a.specular[0]).abs() < 1e-5 * a.specular[0], "{a:?} {b:?}");
            assert!((b.diffuse[0] - left * a.diffuse[0]).abs() < 1e-5 * a.diffuse[0], "{a:?} {b:?}");
        }
        let [plain, black, white] = [coated, soot, lint].map(|p| directional_albedo(&closure(&p), wo)[0]);
        assert!(
            (black - left * plain).abs() < 2e-3 && (white - black - (1.0 - left)).abs() < 2e-3,
            "{plain} {black} {white}"
        );
        assert!(white <= 1.001, "{white}");
    }
}

/// The medium of a volume that scatters: its colour returns from a half space, and without a colour it only absorbs.
#[test]
fn a_volume_scatters_by_its_colour() {
    let p = GltfParams {
        transmission: 1.0,
        thickness: 1.0,
        attenuation_color: Spectrum::splat(0.5),
        attenuation_distance: 2.0,
        ..Default::default()
    };
    assert_eq!(p.interior().expect("an inside").scatter, None);
    let color = Spectrum::rgb(1.0, 0.5, 0.0);
    let milk = GltfParams { scatter_strength: 1.0, multiscatter_color: color, scatter_anisotropy: 0.3, ..p };
    let inside = milk.interior().expect("an inside");
    let scatter = inside.scatter.expect("it scatters");
    assert_eq!(inside.absorption, p.interior().expect("an inside").absorption);
    assert!((inside.absorption[0] - 0.5 * core::f32::consts::LN_2).abs() < 1e-6);
    // 1 − s² over 1 − g s² with s = 4.09712 + 4.20863 c − √(9.59217 + 41.6808 c + 17.7126 c²): 0.3144 at c = ½.
    let s2 = (4.09712f32 + 2.104315 - (9.59217f32 + 20.8404 + 4.42815).sqrt()).powi(2);
    let expected = [1.0, (1.0 - s2) / (1.0 - 0.3 * s2), 0.0];
    for (lane, e) in expected.into_iter().enumerate() {
        assert!((scatter.albedo[lane] - e).abs() < 2e-3, "{lane} {scatter:?} {e}");
    }
    assert_eq!(scatter.anisotropy, 0.3);
    // The strength is a factor of the colour, and leaves the boundary as it is.
    let weak = GltfParams { scatter_strength: 0.5, multiscatter_color: color * 2.0, ..milk };
    assert_eq!(weak.interior().expect("an inside").scatter.map(|s| s.albedo[1]), Some(scatter.albedo[1]));
    let at = Incidence::default();
    assert_eq!(milk.closure(&at), p.closure(&at));
    let clear = GltfParams { attenuation_distance: f32::INFINITY, ..milk };
    assert_eq!(clear.interior().expect("an inside").scatter, None);
}

/// A sheet that scatters all that enters is Lambert's, (1 + g) / 2 of it on the far side; one that scatters a part has that part of it
/// and the rest of the clear sheet.
#[test]
fn a_sheet_scatters_to_both_sides() {
    let at = Incidence::default();
    let color = Spectrum::rgb(0.9, 0.5, 0.2);
    let clear = GltfParams { transmission: 0.8, roughness: 0.4, ..Default::default() };
    for g in [-1.0f32, -0.4, 0.0, 0.6, 1.0] {
        // Nothing is mirrored, so that all enters.
        let p = GltfParams {
            specular: 0.0,
            transmission: 1.0,
            scatter_strength: 1.0,
            multiscatter_color: color,
            scatter_anisotropy: g,
            ..clear
        };
        let c = p.closure(&at);
        let wo = vec3a(0.3, 0.2, 0.93).normalize();
        for side in [1.0f32, -1.0] {
            let wi = vec3a(-0.5, 0.1, side * 0.7).normalize();
            let e = c.eval_pdf(wo, wi);
            let expected = color * ((1.0 + if side > 0.0 { -g } else { g }) / 2.0 * FRAC_1_PI);
            for lane in 0..3 {
                assert!((e.value()[lane] - expected[lane]).abs() < 1e-5, "{g} {side}: {e:?} {expected:?}");
            }
        }
        // In parts: of what is mirrored and passes straight, and of what is scattered.
        let part = |strength: f32| GltfParams {
            scatter_strength: strength,
            multiscatter_color: color,
            scatter_anisotropy: g,
            ..clear
        };
        let [none, some, all] = [0.0, 0.3, 1.0].map(|s| part(s).closure(&at));
        assert_eq!(none, clear.closure(&at));
        for wi in [vec3a(-0.5, 0.1, 0.7), vec3a(-0.35, -0.2, -0.9), vec3a(0.6, 0.5, -0.2)] {
            let [a, b, c] = [none, some, all].map(|c| c.eval_pdf(wo, wi.normalize()).value());
            let between = a.lerp(c, 0.3);
            for lane in 0..3 {
                assert!((b[lane] - between[lane]).abs() < 1e-5, "{g} {wi}: {b:?} {between:?}");
            }
        }
    }
    // A deep body's boundary and a surface that lets nothing through know nothing of it.
    let other = GltfParams { transmission: 0.0, clearcoat: 0.5, ..clear };
    let with = GltfParams { scatter_strength: 1.0, ..other };
    assert_eq!(with.closure(&at), other.closure(&at));
}
