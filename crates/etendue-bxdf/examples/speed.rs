//! Nanoseconds per call of the verbs that a path tracer asks at each hit; for people, never a test.
//!
//! `cargo run --release -p etendue-bxdf --example speed`

use etendue_bxdf::{
    Bsdf, Gltf, GltfParams, MetalRough, MetalRoughParams,
    laws::Rng,
    math::sin_cos_tau,
    model::{Incidence, ModelParams},
    openpbr::{OpenPbr, OpenPbrParams},
    sampling::{cosine_hemisphere, uniform_hemisphere},
};
use etendue_color::Spectrum;
use glam::Vec3A;
use std::{hint::black_box, time::Instant};

const N: usize = 4096;

/// Best of some runs over `N` inputs: what the code costs when nothing else runs.
fn time(name: &str, mut f: impl FnMut(usize) -> f32) {
    let mut best = f64::INFINITY;
    for _ in 0..60 {
        let start = Instant::now();
        let mut sum = 0.0;
        for i in 0..N {
            sum += f(i);
        }
        black_box(sum);
        best = best.min(start.elapsed().as_secs_f64() / N as f64);
    }
    println!("{name:40} {:7.1} ns", best * 1e9);
}

fn main() {
    let mut rng = Rng::new(1);
    let wo: Vec<Vec3A> = (0..N).map(|_| uniform_hemisphere(rng.square())).collect();
    let wi: Vec<Vec3A> = (0..N).map(|_| uniform_hemisphere(rng.square())).collect();
    let u: Vec<[f32; 3]> = (0..N).map(|_| [rng.uniform(), rng.uniform(), rng.uniform()]).collect();
    for (name, metallic) in [("dielectric", 0.0), ("half metal", 0.5), ("metal", 1.0)] {
        let params: Vec<MetalRoughParams> = (0..N)
            .map(|_| MetalRoughParams {
                base_color: Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform()),
                metallic,
                roughness: rng.uniform(),
                specular_color: Spectrum::rgb(1.0, 1.0, 1.0),
                ..Default::default()
            })
            .collect();
        let closures: Vec<MetalRough> = params.iter().map(MetalRough::new).collect();
        time(&format!("{name}: new"), |i| {
            black_box(MetalRough::new(black_box(&params[i])));
            0.0
        });
        time(&format!("{name}: eval_pdf"), |i| {
            let e = closures[i].eval_pdf(wo[i], wi[i]);
            e.diffuse[0] + e.specular[1] + e.pdf
        });
        time(&format!("{name}: sample"), |i| {
            closures[i].sample(wo[i], u[i][0], [u[i][1], u[i][2]]).map_or(0.0, |s| s.weight[0] + s.pdf)
        });
        time(&format!("{name}: new + 2 eval_pdf + sample"), |i| {
            let m = MetalRough::new(&params[i]);
            let a = m.eval_pdf(wo[i], wi[i]);
            let b = m.eval_pdf(wo[i], wi[(i + 1) % N]);
            let s = m.sample(wo[i], u[i][0], [u[i][1], u[i][2]]).map_or(0.0, |s| s.weight[0] + s.pdf);
            a.diffuse[0] + a.specular[1] + a.pdf + b.diffuse[0] + b.specular[1] + b.pdf + s
        });
    }
    // What each extension adds.
    let plain = GltfParams { base_color: Spectrum::rgb(0.8, 0.5, 0.2), roughness: 0.4, ..Default::default() };
    let metal = GltfParams { metallic: 1.0, ..plain };
    for (name, p) in [
        ("gltf plain", plain),
        ("gltf clearcoat", GltfParams { clearcoat: 1.0, clearcoat_roughness: 0.1, ..plain }),
        (
            "gltf sheen",
            GltfParams { sheen_color: Spectrum::rgb(0.5, 0.5, 0.5), sheen_roughness: 0.4, ..plain },
        ),
        ("gltf iridescent metal", GltfParams { iridescence: 1.0, ..metal }),
        ("gltf iridescent dielectric", GltfParams { iridescence: 1.0, ..plain }),
        ("gltf anisotropic metal", GltfParams { anisotropy_strength: 0.6, ..metal }),
        ("gltf anisotropic dielectric", GltfParams { anisotropy_strength: 0.6, ..plain }),
        ("gltf thin glass", GltfParams { transmission: 1.0, ..plain }),
        ("gltf solid glass", GltfParams { transmission: 1.0, thickness: 1.0, ..plain }),
        ("gltf leaf", GltfParams { diffuse_transmission: 0.5, ..plain }),
    ] {
        let at = Incidence::default();
        let closure: Gltf = p.closure(&at);
        time(&format!("{name}: new"), |_| {
            black_box(black_box(&p).closure(&at));
            0.0
        });
        time(&format!("{name}: eval_pdf"), |i| {
            let e = black_box(&closure).eval_pdf(wo[i], wi[i]);
            e.diffuse[0] + e.specular[1] + e.pdf
        });
        time(&format!("{name}: sample"), |i| {
            black_box(&closure)
                .sample(wo[i], u[i][0], [u[i][1], u[i][2]])
                .map_or(0.0, |s| s.weight[0] + s.pdf)
        });
    }
    let named: [(&str, OpenPbrParams); 5] = [
        ("openpbr default", OpenPbrParams::default()),
        ("openpbr metal", OpenPbrParams { base_metalness: 1.0, ..Default::default() }),
        ("openpbr coated", OpenPbrParams { coat_weight: 1.0, coat_roughness: 0.2, ..Default::default() }),
        ("openpbr glass", OpenPbrParams { transmission_weight: 1.0, ..Default::default() }),
        (
            "openpbr everything",
            OpenPbrParams {
                base_metalness: 0.5,
                transmission_weight: 0.3,
                subsurface_weight: 0.5,
                specular_roughness_anisotropy: 0.5,
                coat_weight: 0.8,
                coat_roughness: 0.2,
                coat_color: Spectrum::rgb(0.9, 0.5, 0.2),
                fuzz_weight: 0.5,
                thin_film_weight: 0.5,
                ..Default::default()
            },
        ),
    ];
    for (name, p) in named {
        let params: Vec<OpenPbrParams> =
            (0..N).map(|_| OpenPbrParams { specular_roughness: rng.uniform(), ..p }).collect();
        let at = Incidence::default();
        let closures: Vec<OpenPbr> = params.iter().map(|p| OpenPbr::new(p, &at)).collect();
        time(&format!("{name}: new"), |i| {
            black_box(OpenPbr::new(black_box(&params[i]), &at));
            0.0
        });
        time(&format!("{name}: eval_pdf"), |i| {
            let e = closures[i].eval_pdf(wo[i], wi[i]);
            e.diffuse[0] + e.specular[1] + e.pdf
        });
        time(&format!("{name}: sample"), |i| {
            closures[i].sample(wo[i], u[i][0], [u[i][1], u[i][2]]).map_or(0.0, |s| s.weight[0] + s.pdf)
        });
    }
    println!("openpbr: {} bytes a closure, metal-rough {}", size_of::<OpenPbr>(), size_of::<MetalRough>());
    time("sin_cos_tau", |i| {
        let (s, c) = sin_cos_tau(u[i][0]);
        s + c
    });
    time("std sin_cos", |i| {
        let (s, c) = (u[i][0] * core::f32::consts::TAU).sin_cos();
        s + c
    });
    time("cosine_hemisphere", |i| cosine_hemisphere([u[i][0], u[i][1]]).z);
}
