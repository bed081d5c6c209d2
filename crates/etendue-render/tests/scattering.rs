//! Light that is scattered in bodies, against an independent walk and against what must come out.
mod common;
use common::*;
use etendue_image::{Image, Pixels};
use etendue_render::World;
use etendue_scene::{
    DiffuseTransmission, Extensions, Material, Mesh, Scatter, Scene, Texture, TextureRef, Transmission,
    Volume,
};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// A white body that scatters: light is attenuated to `attenuation` over a metre, of which `color` comes back from a deep one.
fn body(attenuation: Vec3, color: Vec3, anisotropy: f32, entrance: Extensions) -> Material {
    Material {
        base_color: Vec3::ONE,
        metallic: 0.0,
        roughness: 0.0,
        double_sided: true,
        extensions: Some(Box::new(Extensions {
            volume: Some(Volume {
                thickness: 1.0,
                attenuation_distance: 1.0,
                attenuation_color: attenuation,
                ..Volume::default()
            }),
            scatter: Some(Scatter { strength: 1.0, color, anisotropy, ..Scatter::default() }),
            ..entrance
        })),
        ..Material::default()
    }
}

fn clear() -> Extensions {
    Extensions { transmission: Some(Transmission { factor: 1.0, texture: None }), ..Extensions::default() }
}

fn milky() -> Extensions {
    let d = DiffuseTransmission { factor: 1.0, ..DiffuseTransmission::default() };
    Extensions { diffuse_transmission: Some(d), ..Extensions::default() }
}

/// Mean of a lane over the picture, and its standard error by how much pixels differ, of which each sees the same.
fn lane_mean(film: &etendue_render::Film, lane: usize) -> (f64, f64) {
    let n = film.pixels() as f64;
    let values: Vec<f64> = film.beauty().iter().map(|p| f64::from(p[lane])).collect();
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// What only scatters is not seen under an even sky, however dense it is and whatever its surface does.
#[test]
fn a_body_that_absorbs_nothing_vanishes() {
    for (name, entrance, ior, density, g) in [
        ("matched", clear(), 1.0, 0.2f32, 0.0),
        ("glass", clear(), 1.5, 0.2, 0.5),
        ("dense glass", clear(), 1.5, 1e-3, -0.3),
        ("milk", milky(), 1.5, 0.01, 0.7),
    ] {
        // Another density in each lane.
        let attenuation = Vec3::new(density.powf(0.5), density, density.powf(2.0).max(1e-6));
        let m = Material { ior, ..body(attenuation, Vec3::ONE, g, entrance) };
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, sphere(Vec3::ZERO, 1.0, 16, false), m);
        let w = World::new(s).expect("sound");
        let camera = parallel(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), 1.2);
        let film = render(&w, &camera, &settings(16, 4096), 64);
        for lane in 0..3 {
            let (mean, error) = lane_mean(&film, lane);
            println!("{name}, lane {lane}: {mean:.5} ± {error:.5}");
            assert!((mean - 1.0).abs() < 4.0 * error + 5e-3, "{name} {lane}: {mean} ± {error}");
        }
    }
}

/// Uniform numbers of another kind than the renderer's.
struct Lehmer(u128);

impl Lehmer {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xda94_2042_e4dd_58b5);
        ((self.0 >> 75) as f64 + 0.5) / (1u64 << 53) as f64
    }
}

/// The light that a slab without a boundary, `thickness` thick, scatters back of what falls on it straight down; and its standard
/// error. Written in depth and cosine only.
fn returned(sigma: f64, albedo: f64, g: f64, thickness: f64, walks: u32) -> (f64, f64) {
    let mut rng = Lehmer(0x1234_5678_9abc_def1);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..walks {
        let (mut depth, mut down, mut weight) = (0.0, 1.0, 1.0);
        let back = loop {
            depth += down * -rng.uniform().ln() / sigma;
            if depth < 0.0 {
                break weight;
            }
            if depth > thickness || weight < 1e-5 {
                break 0.0;
            }
            weight *= albedo;
            let u = rng.uniform();
            let cos: f64 = if g == 0.0 {
                2.0 * u - 1.0
            } else {
                let s = (1.0 - g * g) / (1.0 + g * (2.0 * u - 1.0));
                (1.0 + g * g - s * s) / (2.0 * g)
            };
            let around = (std::f64::consts::TAU * rng.uniform()).cos();
            down = cos * down + ((1.0 - cos * cos) * (1.0 - down * down)).max(0.0).sqrt() * around;
        };
        sum += back;
        squares += back * back;
    }
    let n = f64::from(walks);
    (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt())
}

/// A closed plate below y = 0: open sides would let light out that is not attenuated.
fn plate(half: f32, thickness: f32) -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
        Vec3::new(side(0, -half, half), side(1, -thickness, 0.0), side(2, -half, half))
    };
    let faces = [[2, 6, 7, 3], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [4, 5, 7, 6], [0, 2, 3, 1]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        indices: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

/// What a slab scatters back to the sky above it, over a black floor, for each lane's density and colour.
#[test]
fn a_slab_returns_what_an_independent_walk_does() {
    let (attenuation, color) = (Vec3::new(0.5, 0.2, 0.02), Vec3::new(0.9, 0.6, 0.3));
    for g in [0.0f32, 0.7, -0.5] {
        // No reflection at the surface, and no bend.
        let m = Material { ior: 1.0, specular: 0.0, ..body(attenuation, color, g, clear()) };
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, plate(100.0, 1.5), m);
        add(&mut s, rectangle(Vec3::new(0.0, -2.0, 0.0), 400.0, 400.0), lambert(0.0));
        let w = World::new(s).expect("sound");
        let film = render(&w, &parallel(Vec3::ZERO, Vec3::Y, 0.1), &settings(16, 64), 512);
        for lane in 0..3 {
            let (found, error) = lane_mean(&film, lane);
            // Kulla, Conty 2017, by itself.
            let (c, g) = (f64::from(color[lane]), f64::from(g));
            let s = 4.09712 + 4.20863 * c - (9.59217 + 41.6808 * c + 17.7126 * c * c).sqrt();
            let albedo = (1.0 - s * s) / (1.0 - g * s * s);
            let (expected, own) = returned(-f64::from(attenuation[lane]).ln(), albedo, g, 1.5, 200_000);
            println!("g {g}, lane {lane}: {found:.5} ± {error:.5}, the walk {expected:.5} ± {own:.5}");
            let sigma = (error * error + own * own).sqrt();
            assert!(
                (found - expected).abs() < 3.5 * sigma + 2e-4,
                "g {g} {lane}: {found} {expected} ± {sigma}"
            );
            assert!(found > 0.0 && found < 1.0);
        }
    }
}

/// A sheet that scatters and absorbs nothing is not seen under an even sky, whatever part of the light it scatters and where to. (What
/// goes straight through a rough sheet loses light between the facets.)
#[test]
fn a_white_sheet_vanishes() {
    for (strength, anisotropy, roughness) in
        [(1.0f32, 0.0f32, 0.5f32), (0.4, 0.7, 0.0), (0.8, -0.9, 0.0), (1.0, -0.4, 0.8)]
    {
        let scatter = Scatter { strength, anisotropy, ..Scatter::default() };
        let e = Extensions { scatter: Some(scatter), ..clear() };
        let m = Material { roughness, extensions: Some(Box::new(e)), ..lambert(1.0) };
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        add(&mut s, sphere(Vec3::ZERO, 1.0, 16, false), m);
        let w = World::new(s).expect("sound");
        let film = render(&w, &parallel(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), 1.2), &settings(16, 4096), 64);
        for lane in 0..3 {
            let (mean, error) = lane_mean(&film, lane);
            println!("{strength} {anisotropy} {roughness}, lane {lane}: {mean:.5} ± {error:.5}");
            assert!((mean - 1.0).abs() < 4.0 * error + 5e-3, "{strength} {lane}: {mean} ± {error}");
        }
    }
}

/// A texture of `width` texels.
fn strip(scene: &mut Scene, width: u32, bytes: &[u8]) -> TextureRef {
    scene.images.push(Arc::new(Image { width, height: 1, channels: 4, pixels: Pixels::U8(bytes.to_vec()) }));
    scene.textures.push(Texture { image: scene.images.len() as u32 - 1, sampler: Default::default() });
    TextureRef::new(scene.textures.len() as u32 - 1)
}

/// Textures of a body's scattering are factors of it, taken where light enters.
#[test]
fn bodies_are_mottled() {
    let film = |texels: Option<(u32, &[u8])>, strength: f32, color: Vec3| {
        let mut s = Scene { environment: sky(1.0), ..Scene::default() };
        let mut m = Material { ior: 1.0, specular: 0.0, ..body(Vec3::splat(1e-3), color, 0.0, clear()) };
        let texture = texels.map(|(width, bytes)| strip(&mut s, width, bytes));
        if let Some(scatter) = m.extensions.as_mut().and_then(|e| e.scatter.as_mut()) {
            *scatter = Scatter { strength, texture, color_texture: texture, ..*scatter };
        }
        let mut mesh = plate(2.0, 1.5);
        mesh.uvs = vec![mesh.positions.iter().map(|p| Vec2::new(0.5 + 0.25 * p.x, 0.5)).collect()];
        add(&mut s, mesh, m);
        let w = World::new(s).expect("sound");
        render(&w, &parallel(Vec3::ZERO, Vec3::Y, 1.5), &settings(16, 64), 64)
    };
    // Full and no red, green, blue, and a strength of 128 / 255.
    let strength = 128.0 / 255.0;
    let even = film(Some((1, &[255, 0, 255, 128])), 1.0, Vec3::new(0.8, 0.7, 0.2));
    let same = film(None, strength, Vec3::new(0.8, 0.0, 0.2));
    assert_eq!(even.beauty(), same.beauty());
    // Of two halves each is as bright as a body of its own colour; light that enters in one leaves in the other with its colour.
    let halves: Vec<u8> = (0..8).flat_map(|i| if i < 4 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    let both = film(Some((8, &halves)), 1.0, Vec3::ONE);
    let sides = |film: &etendue_render::Film| {
        let mut sums = [0.0f64; 2];
        for (i, p) in film.beauty().iter().enumerate() {
            // Rows, for the picture is turned; away from where texels are mixed.
            match i / 16 {
                0..3 => sums[0] += f64::from(p[1]) / 48.0,
                13.. => sums[1] += f64::from(p[1]) / 48.0,
                _ => {}
            }
        }
        sums
    };
    let (mottled, white) = (sides(&both), sides(&film(None, 1.0, Vec3::ONE)));
    println!("{mottled:?} of {white:?}");
    let (dark, bright) = (mottled[0].min(mottled[1]), mottled[0].max(mottled[1]));
    assert!(dark < 0.01 && (bright / white[0] - 1.0).abs() < 0.05, "{mottled:?} of {white:?}");
}
