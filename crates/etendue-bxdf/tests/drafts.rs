//! What drafts of extensions add to the glTF surface, beyond what `verify` asks of every model.

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
