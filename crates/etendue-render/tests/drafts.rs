//! What a path finds of the surface that drafts of extensions describe.
mod common;
use common::*;
use etendue_bxdf::GltfParams;
use etendue_image::{Image, Pixels};
use etendue_render::World;
use etendue_scene::{
    Anisotropy, Clearcoat, DiffuseRoughness, Extensions, Fuzz, Material, Scene, Texture, TextureRef,
};
use etendue_trace::Ray;
use glam::{Vec3, Vec3A};
use std::sync::Arc;

const DOWN: Ray =
    Ray { origin: Vec3A::new(0.1, 3.0, 0.2), direction: Vec3A::NEG_Y, t_min: 0.0, t_max: f32::INFINITY };

/// A texture of one texel, each channel another value.
const TEXEL: [u8; 4] = [51, 102, 153, 204];

/// What channel `c` of it says where it is data.
fn data(c: usize) -> f32 {
    f32::from(TEXEL[c]) / 255.0
}

/// The parameters of a surface with `extensions`, whose textures all are the texel.
fn params(extensions: impl FnOnce(Option<TextureRef>) -> Extensions) -> GltfParams {
    let mut s = Scene::default();
    let image = Image { width: 1, height: 1, channels: 4, pixels: Pixels::U8(TEXEL.to_vec()) };
    s.images.push(Arc::new(image));
    s.textures.push(Texture { image: 0, sampler: Default::default() });
    let extensions = Some(Box::new(extensions(Some(TextureRef::new(0)))));
    add(&mut s, rectangle(Vec3::ZERO, 1.0, 1.0), Material { extensions, ..Material::default() });
    let w = World::new(s).expect("sound");
    let hit = w.seen(&DOWN).expect("a surface");
    w.shading_point(&hit, DOWN.direction).params
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-5
}

#[test]
fn diffuse_roughness_is_in_red() {
    let p = params(|texture| Extensions {
        diffuse_roughness: Some(DiffuseRoughness { factor: 0.5, texture }),
        ..Default::default()
    });
    assert!(near(p.diffuse_roughness, 0.5 * data(0)), "{p:?}");
}

/// What channel `c` of the texel says where it is a colour.
fn colour(c: usize) -> f32 {
    let v = data(c);
    ((v + 0.055) / 1.055).powf(2.4)
}

#[test]
fn fuzz_is_in_red_colours_and_alpha() {
    let p = params(|t| Extensions {
        fuzz: Some(Fuzz {
            factor: 0.5,
            texture: t,
            color: Vec3::new(1.0, 0.5, 0.25),
            color_texture: t,
            roughness: 0.8,
            roughness_texture: t,
        }),
        ..Default::default()
    });
    assert!(near(p.fuzz, 0.5 * data(0)) && near(p.fuzz_roughness, 0.8 * data(3)), "{p:?}");
    for (c, factor) in [1.0, 0.5, 0.25].into_iter().enumerate() {
        assert!((p.fuzz_color[c] - factor * colour(c)).abs() < 1e-4, "{c} {p:?}");
    }
}

#[test]
fn a_coat_is_in_red_green_and_colours() {
    let p = params(|t| Extensions {
        clearcoat: Some(Clearcoat {
            factor: 0.5,
            texture: t,
            roughness: 0.8,
            roughness_texture: t,
            ior: 1.7,
            color: Vec3::new(1.0, 0.5, 0.25),
            color_texture: t,
            darkening: 0.3,
            anisotropy: Anisotropy { strength: 0.5, rotation: 0.0, texture: t },
            ..Default::default()
        }),
        ..Default::default()
    });
    assert!(near(p.clearcoat, 0.5 * data(0)) && near(p.clearcoat_roughness, 0.8 * data(1)), "{p:?}");
    assert_eq!((p.coat_ior, p.coat_darkening), (1.7, 0.3));
    assert!(near(p.coat_anisotropy_strength, 0.5 * data(2)), "{p:?}");
    for (c, factor) in [1.0, 0.5, 0.25].into_iter().enumerate() {
        assert!((p.coat_color[c] - factor * colour(c)).abs() < 1e-4, "{c} {p:?}");
    }
}
