//! What shading models outside of the renderer get of a surface.
mod common;
use common::*;
use etendue_bxdf::{Bsdf, MetalRough};
use etendue_image::{Image, Pixels};
use etendue_render::{Counters, Pass, PassSet, Renderer, Settings, World};
use etendue_scene::{AlphaMode, Camera, Extensions, Material, Scene, Texture, TextureRef, Volume};
use etendue_trace::Ray;
use glam::{Affine3A, Vec3, Vec3A};
use std::sync::Arc;

const DOWN: Ray =
    Ray { origin: Vec3A::new(0.1, 3.0, 0.2), direction: Vec3A::NEG_Y, t_min: 0.0, t_max: f32::INFINITY };

/// One texel of the given bytes.
fn texel(scene: &mut Scene, bytes: [u8; 4]) -> TextureRef {
    let image = Image { width: 1, height: 1, channels: 4, pixels: Pixels::U8(bytes.to_vec()) };
    scene.images.push(Arc::new(image));
    scene.textures.push(Texture { image: scene.images.len() as u32 - 1, sampler: Default::default() });
    TextureRef::new(scene.textures.len() as u32 - 1)
}

/// The albedo that the path tracer records is that of the parameters that are handed out.
#[test]
fn the_path_tracer_and_others_see_one_material() {
    let mut s = Scene::default();
    let base = texel(&mut s, [200, 100, 50, 255]);
    let rough = texel(&mut s, [9, 120, 180, 255]);
    let material = Material {
        base_color_texture: Some(base),
        metallic_roughness_texture: Some(rough),
        roughness: 0.7,
        metallic: 0.9,
        ior: 1.8,
        specular: 0.6,
        specular_color: Vec3::new(0.9, 0.5, 0.7),
        ..Material::default()
    };
    add(&mut s, rectangle(Vec3::ZERO, 1.0, 1.0), material);
    let w = World::new(s).expect("sound");
    let hit = w.seen(&DOWN).expect("a surface");
    let p = w.shading_point(&hit, DOWN.direction);
    let closure = MetalRough::new(&p.params.metal_rough());
    assert!((p.params.roughness - 0.7 * 120.0 / 255.0).abs() < 1e-6);
    let expected = closure.albedo(p.frame.transpose() * Vec3A::Y).to_rgb();

    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, Vec3::Z, 1e-3);
    let passes = PassSet::default().with(Pass::Albedo);
    let r = Renderer::new(&w, camera, Settings { width: 1, height: 1, passes, ..settings(0, 1) });
    let mut film = r.film();
    r.render(&mut film, 0, 1, &Counters::default());
    (0..3).for_each(|c| assert!((film.mean(0, 5 + c) - expected[c]).abs() < 1e-5, "{expected:?}"));
}

#[test]
fn backs_and_holes_are_not_seen() {
    let mut s = Scene::default();
    // From the top: the back of a one-sided sheet, a clear blended one, a masked hole, a veil, the floor.
    let down = |y: f32| {
        let mut m = rectangle(Vec3::new(0.0, y, 0.0), 1.0, 1.0);
        m.indices.iter_mut().for_each(|t| t.swap(1, 2));
        m
    };
    let up = |y: f32| rectangle(Vec3::new(0.0, y, 0.0), 1.0, 1.0);
    let one_sided = Material { double_sided: false, ..lambert(0.5) };
    let blend = |alpha: f32| Material { alpha, alpha_mode: AlphaMode::Blend, ..one_sided.clone() };
    add(&mut s, down(2.5), one_sided.clone());
    add(&mut s, up(2.0), blend(0.0));
    add(&mut s, up(1.5), Material { alpha: 0.3, alpha_mode: AlphaMode::Mask(0.5), ..one_sided.clone() });
    add(&mut s, up(1.0), blend(0.25));
    add(&mut s, up(0.0), one_sided.clone());
    let w = World::new(s).expect("sound");
    let veil = w.seen(&DOWN).expect("a surface");
    assert_eq!(veil.instance, 3);
    assert_eq!(w.shading_point(&veil, DOWN.direction).alpha, 0.25);
    let floor = w.seen(&Ray { t_min: veil.t, ..DOWN }).expect("a surface");
    let p = w.shading_point(&floor, DOWN.direction);
    assert_eq!((floor.instance, p.alpha, p.front), (4, 1.0, true));
    // The masked hole lets light through, a veil of a quarter three quarters of it, the clear sheet all; the back that nobody
    // sees stops it.
    let up_to = |t_max: f32| Ray { t_max, ..Ray::new(p.ray_origin(Vec3A::Y), Vec3A::Y) };
    assert_eq!(w.transmittance(&up_to(0.9)), 1.0, "a point does not shadow itself");
    assert!((w.transmittance(&up_to(2.1)) - 0.75).abs() < 1e-4, "{}", w.transmittance(&up_to(2.1)));
    assert_eq!(w.transmittance(&up_to(9.0)), 0.0);
}

/// Thickness is given in the mesh's space: the instance's scale makes metres of it, wherever its vertices are kept.
#[test]
fn thickness_is_in_metres() {
    for instances in [1, 2] {
        let mut s = Scene::default();
        let half = texel(&mut s, [0, 128, 0, 255]);
        let volume = Volume { thickness: 0.5, thickness_texture: Some(half), ..Volume::default() };
        let extensions = Some(Box::new(Extensions { volume: Some(volume), ..Extensions::default() }));
        add(&mut s, rectangle(Vec3::ZERO, 1.0, 1.0), Material { extensions, ..Material::default() });
        s.instances[0].transform = Affine3A::from_scale(Vec3::splat(4.0));
        let mut other = s.instances[0].clone();
        other.transform.translation.y = -9.0;
        s.instances.extend((1..instances).map(|_| other.clone()));
        let w = World::new(s).expect("sound");
        let hit = w.seen(&DOWN).expect("a surface");
        let p = w.shading_point(&hit, DOWN.direction);
        assert!((p.params.thickness - 2.0 * 128.0 / 255.0).abs() < 1e-5, "{}", p.params.thickness);
    }
}
