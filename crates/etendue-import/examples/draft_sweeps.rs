//! Models to look at the drafts of material extensions with: rows of spheres, each row one property from one end to the other.
//!
//! `cargo run -p etendue-import --example draft_sweeps -- FOLDER` writes `coat.glb`, `fuzz.glb`, `diffuse_roughness.glb` and
//! `scatter.glb`; `etendue render --drafts FOLDER/coat.glb` shows one.

use etendue_import::{ExportOptions, export};
use etendue_scene::{
    Anisotropy, Clearcoat, DiffuseRoughness, DiffuseTransmission, Extensions, Fuzz, Instance, Material, Mesh,
    Scatter, Scene, Sheen, Transmission, Volume,
};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::f32::consts::{PI, TAU};
use std::path::Path;

/// Spheres in a row.
const STEPS: u16 = 8;
/// Rings of a sphere, and half of its segments.
const RINGS: u32 = 32;

/// A sphere of radius 0.45 with tangents along its circles of latitude.
fn sphere() -> Mesh {
    let mut m = Mesh { name: "sphere".into(), uvs: vec![Vec::new()], ..Mesh::default() };
    for j in 0..=RINGS {
        for i in 0..=2 * RINGS {
            let (v, u) = (j as f32 / RINGS as f32, i as f32 / (2 * RINGS) as f32);
            let (t, p) = (PI * v, TAU * u);
            let d = Vec3::new(t.sin() * p.sin(), t.cos(), t.sin() * p.cos());
            m.positions.push(d * 0.45);
            m.normals.push(d);
            m.tangents.push(Vec4::new(p.cos(), 0.0, -p.sin(), 1.0));
            m.uvs[0].push(Vec2::new(u, v));
        }
    }
    let w = 2 * RINGS + 1;
    for j in 0..RINGS {
        for i in 0..2 * RINGS {
            let a = j * w + i;
            if j > 0 {
                m.indices.push([a, a + w, a + 1]);
            }
            if j + 1 < RINGS {
                m.indices.push([a + 1, a + w, a + w + 1]);
            }
        }
    }
    m
}

type Row = (&'static str, fn(f32) -> Material);

fn of(color: Vec3, metallic: f32, roughness: f32, extensions: Extensions) -> Material {
    Material {
        base_color: color,
        metallic,
        roughness,
        extensions: Some(Box::new(extensions)),
        ..Material::default()
    }
}

const RED: Vec3 = Vec3::new(0.6, 0.15, 0.1);
const GREY: Vec3 = Vec3::splat(0.35);

fn coated(color: Vec3, metallic: f32, coat: Clearcoat) -> Material {
    of(color, metallic, 0.5, Extensions { clearcoat: Some(coat), ..Extensions::default() })
}

const COAT: &[Row] = &[
    ("coatFactor", |t| coated(RED, 0.0, Clearcoat { factor: t, darkening: 1.0, ..Clearcoat::default() })),
    ("coatRoughnessFactor", |t| {
        coated(RED, 0.0, Clearcoat { factor: 1.0, roughness: t, ..Clearcoat::default() })
    }),
    ("coatIor", |t| coated(RED, 0.0, Clearcoat { factor: 1.0, ior: 1.0 + 1.5 * t, ..Clearcoat::default() })),
    ("coatColorFactor", |t| {
        let color = Vec3::ONE.lerp(Vec3::new(0.9, 0.35, 0.05), t);
        coated(Vec3::splat(0.8), 1.0, Clearcoat { factor: 1.0, color, ..Clearcoat::default() })
    }),
    ("coatDarkeningFactor", |t| {
        coated(RED, 0.0, Clearcoat { factor: 1.0, ior: 1.8, darkening: t, ..Clearcoat::default() })
    }),
    ("coatAnisotropyStrength", |t| {
        let anisotropy = Anisotropy { strength: t, ..Anisotropy::default() };
        coated(GREY, 0.0, Clearcoat { factor: 1.0, roughness: 0.3, anisotropy, ..Clearcoat::default() })
    }),
    ("coatAnisotropyRotation", |t| {
        let anisotropy = Anisotropy { strength: 0.8, rotation: PI * t, texture: None };
        coated(GREY, 0.0, Clearcoat { factor: 1.0, roughness: 0.3, anisotropy, ..Clearcoat::default() })
    }),
];

fn fuzzy(color: Vec3, fuzz: Fuzz) -> Material {
    of(color, 0.0, 0.6, Extensions { fuzz: Some(fuzz), ..Extensions::default() })
}

const FUZZ: &[Row] = &[
    ("fuzzFactor", |t| fuzzy(RED, Fuzz { factor: t, ..Fuzz::default() })),
    ("fuzzFactor, black", |t| {
        fuzzy(RED, Fuzz { factor: t, color: Vec3::ZERO, roughness: 0.8, ..Fuzz::default() })
    }),
    ("fuzzRoughnessFactor", |t| fuzzy(RED, Fuzz { factor: 1.0, roughness: t, ..Fuzz::default() })),
    ("sheen of the same roughness", |t| {
        let sheen = Some(Sheen { color: Vec3::ONE, roughness: t, ..Sheen::default() });
        of(RED, 0.0, 0.6, Extensions { sheen, ..Extensions::default() })
    }),
    ("fuzzFactor over a coat", |t| {
        let mut m = fuzzy(RED, Fuzz { factor: t, roughness: 0.7, ..Fuzz::default() });
        if let Some(e) = &mut m.extensions {
            e.clearcoat = Some(Clearcoat { factor: 1.0, ..Clearcoat::default() });
        }
        m
    }),
];

fn rough(color: Vec3, roughness: f32, factor: f32) -> Material {
    let diffuse_roughness = Some(DiffuseRoughness { factor, texture: None });
    of(color, 0.0, roughness, Extensions { diffuse_roughness, ..Extensions::default() })
}

const DIFFUSE_ROUGHNESS: &[Row] = &[
    ("diffuseRoughnessFactor", |t| rough(Vec3::splat(0.7), 1.0, t)),
    ("diffuseRoughnessFactor, red", |t| rough(RED, 1.0, t)),
    ("diffuseRoughnessFactor, glossy", |t| rough(RED, 0.3, t)),
];

fn body(color: Vec3, density: f32, anisotropy: f32, diffuse: bool) -> Material {
    let mut e = Extensions {
        volume: Some(Volume {
            thickness: 0.9,
            attenuation_distance: 0.9 / density,
            attenuation_color: Vec3::splat(0.37),
            ..Volume::default()
        }),
        scatter: Some(Scatter { strength: 1.0, color, anisotropy, ..Scatter::default() }),
        ..Extensions::default()
    };
    if diffuse {
        e.diffuse_transmission = Some(DiffuseTransmission { factor: 1.0, ..DiffuseTransmission::default() });
    } else {
        e.transmission = Some(Transmission { factor: 1.0, texture: None });
    }
    of(Vec3::ONE, 0.0, 0.1, e)
}

const SKIN: Vec3 = Vec3::new(0.8, 0.45, 0.3);

fn sheet_of(color: Vec3, strength: f32, anisotropy: f32) -> Material {
    let e = Extensions {
        transmission: Some(Transmission { factor: 1.0, texture: None }),
        scatter: Some(Scatter { strength, color, anisotropy, ..Scatter::default() }),
        ..Extensions::default()
    };
    of(Vec3::ONE, 0.0, 0.1, e)
}

const SCATTER: &[Row] = &[
    ("multiscatterColorFactor", |t| body(SKIN * t, 10.0, 0.0, false)),
    ("density", |t| body(SKIN, 0.3 * 300f32.powf(t), 0.0, false)),
    ("density, entered diffusely", |t| body(SKIN, 0.3 * 300f32.powf(t), 0.0, true)),
    ("scatterAnisotropy", |t| body(SKIN, 4.0, 1.9 * t - 0.95, false)),
    ("scatterStrengthFactor", |t| {
        let mut m = body(SKIN, 10.0, 0.0, false);
        if let Some(s) = m.extensions.as_mut().and_then(|e| e.scatter.as_mut()) {
            s.strength = t;
        }
        m
    }),
    ("scatterStrengthFactor of a sheet", |t| sheet_of(SKIN, t, 0.0)),
    ("scatterAnisotropy of a sheet", |t| sheet_of(SKIN, 1.0, 2.0 * t - 1.0)),
];

fn sheet(rows: &[Row]) -> Scene {
    let mut s = Scene { meshes: vec![sphere().into()], ..Scene::default() };
    for (y, (name, make)) in rows.iter().enumerate() {
        for x in 0..STEPS {
            let t = f32::from(x) / f32::from(STEPS - 1);
            let name = format!("{name} {x}");
            s.materials.push(Material { name: name.clone(), ..make(t) });
            let place = Vec3::new(f32::from(x), -(y as f32), 0.0);
            let material = Some(s.materials.len() as u32 - 1);
            s.instances.push(Instance {
                name,
                mesh: 0,
                material,
                transform: Affine3A::from_translation(place),
            });
        }
    }
    s
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("give a folder")?;
    std::fs::create_dir_all(&folder)?;
    for (name, rows) in
        [("coat", COAT), ("fuzz", FUZZ), ("diffuse_roughness", DIFFUSE_ROUGHNESS), ("scatter", SCATTER)]
    {
        let file = export(&sheet(rows), &[], &ExportOptions::default())?;
        let path = Path::new(&folder).join(format!("{name}.glb"));
        std::fs::write(&path, &file.bytes)?;
        println!("{}: rows of {}", path.display(), rows.iter().map(|r| r.0).collect::<Vec<_>>().join("; "));
    }
    Ok(())
}
