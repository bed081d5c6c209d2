//! How far glTF's albedo-scaled layers are from a random walk between the interfaces.
//!
//! `cargo run --release -p etendue-bxdf --example layering [WALKS]` prints the table of `etendue_bxdf::layered`: directional
//! albedo of a coat (coverage 1) over a base, at three angles: by [`GltfParams`], by a walk under a coat that does not refract, and
//! by a walk under a coat of index 1.5 that does.

use etendue_bxdf::{
    Bsdf, GltfParams, MetalRough, MetalRoughParams, Schlick,
    dielectric::{Dielectric, GgxDielectric, Interface, SchlickInterface},
    laws::{Rng, grid::wo_at},
    layered::{Layered, Slab},
    model::{Incidence, ModelParams},
    quadrature::directional_albedo,
};
use etendue_color::Spectrum;

/// Albedo of a walk under a coat of interface `face`.
fn walk<I: Interface + PartialEq + core::fmt::Debug>(
    face: impl Fn(&Incidence) -> I,
    alpha: f32,
    base: MetalRough,
    angle: f32,
    walks: usize,
) -> f32 {
    let coat = |at: &Incidence| GgxDielectric::new([alpha; 2], face(at), at.transport);
    let (mean, error) = Layered::new(coat, base, Slab::EMPTY).albedo(wo_at(angle), walks, &mut Rng::new(7));
    assert!(error[0] < 0.01, "too few walks: {error:?}");
    mean[0]
}

fn main() {
    let walks = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(100_000);
    println!("| base | coat's roughness | angle | glTF | walk, no refraction | walk, refraction |");
    println!("|---|---|---|---|---|---|");
    let grey = |v: f32| Spectrum::splat(v);
    let diffuse = |v| MetalRoughParams { base_color: grey(v), specular: 0.0, ..Default::default() };
    let metal = |v, roughness| MetalRoughParams {
        base_color: grey(v),
        metallic: 1.0,
        roughness,
        ..Default::default()
    };
    for (name, base) in [
        ("diffuse 1", diffuse(1.0)),
        ("diffuse 0.8", diffuse(0.8)),
        ("diffuse 0.2", diffuse(0.2)),
        ("metal 1, smooth", metal(1.0, 0.0)),
        ("metal 0.5, smooth", metal(0.5, 0.0)),
        ("metal 0.9, roughness 0.4", metal(0.9, 0.4)),
    ] {
        for roughness in [0.0f32, 0.4] {
            for angle in [0.0, 60.0, 80.0] {
                let p = GltfParams { clearcoat: 1.0, clearcoat_roughness: roughness, ..base.into() };
                let closure = p.closure(&Incidence::default());
                assert!(closure.albedo(wo_at(angle)).is_finite());
                let ours = directional_albedo(&closure, wo_at(angle))[0];
                let alpha = roughness * roughness;
                let lower = MetalRough::new(&base);
                let schlick = Schlick { f0: grey(0.04), f90: Spectrum::ONE };
                let straight = walk(|_| SchlickInterface::new(schlick, 1.0), alpha, lower, angle, walks);
                let index = |at: &Incidence| Dielectric::new(if at.front { 1.5 } else { 1.0 / 1.5 });
                let bent = walk(index, alpha, lower, angle, walks);
                println!("| {name} | {roughness} | {angle}° | {ours:.3} | {straight:.3} | {bent:.3} |");
            }
        }
    }
}
