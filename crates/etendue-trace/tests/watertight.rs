//! Rays from inside a closed mesh, aimed exactly at its edges and vertices, never leave it.
//!
//! One million rays; ten million with `ETENDUE_FULL=1`.

use etendue_scene::{Instance, Mesh, Scene};
use etendue_trace::{Accel, Kernel, Ray};
use glam::{Affine3A, Quat, Vec3, Vec3A};
use rayon::prelude::*;

/// SplitMix64 (Steele, Lea, Flood 2014), in [0, 1).
fn unit(state: &mut u64) -> f32 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
}

/// A bumpy sphere with radii from 0.8 to 1.2 around `center`, vertices shared.
fn sphere(rings: u32, sectors: u32, center: Vec3) -> Mesh {
    let mut m = Mesh::default();
    let pi = std::f32::consts::PI;
    for ring in 0..=rings {
        let (sin, cos) = (ring as f32 / rings as f32 * pi).sin_cos();
        let around = if ring == 0 || ring == rings { 1 } else { sectors };
        for sector in 0..around {
            let phi = sector as f32 / sectors as f32 * 2.0 * pi;
            let d = Vec3::new(sin * phi.cos(), cos, sin * phi.sin());
            m.positions.push(center + d * (1.0 + 0.2 * (d.x * 9.0).sin() * (d.y * 7.0 + d.z * 5.0).cos()));
        }
    }
    let at = |ring: u32, sector: u32| match ring {
        0 => 0,
        r if r == rings => (rings - 1) * sectors + 1,
        r => 1 + (r - 1) * sectors + sector % sectors,
    };
    for ring in 0..rings {
        for s in 0..sectors {
            if ring > 0 {
                m.indices.push([at(ring, s), at(ring, s + 1), at(ring + 1, s)]);
            }
            if ring + 1 < rings {
                m.indices.push([at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s)]);
            }
        }
    }
    m
}

/// A box of twelve triangles from −1 to 1 on x and z and from 0 to 0.01 on y, scaled.
fn flat_box(scale: f32) -> Mesh {
    let corner = |i: u32| {
        let f = |b: u32| if i >> b & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(f(0), if i & 2 == 2 { 0.01 } else { 0.0 }, f(2)) * scale
    };
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        indices: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

fn instance(transform: Affine3A) -> Instance {
    Instance { name: String::new(), mesh: 0, material: None, transform }
}

/// Counts rays from `inside` (mesh space) through `place` that miss.
fn misses(
    mesh: Mesh,
    place: &[Affine3A],
    kernel: Kernel,
    rays: u64,
    inside: impl Fn(&mut u64) -> Vec3 + Sync,
) -> u64 {
    let scene = Scene {
        meshes: vec![mesh.into()],
        instances: place.iter().copied().map(instance).collect(),
        ..Scene::default()
    };
    let accel = Accel::build(&scene).with_kernel(kernel);
    let mesh = &scene.meshes[0];
    (0..rays)
        .into_par_iter()
        .filter(|&n| {
            let mut s = n.wrapping_mul(0x2545_f491_4f6c_dd1d);
            let triangle =
                mesh.indices[(unit(&mut s) * mesh.indices.len() as f32) as usize % mesh.indices.len()];
            let [a, b] = [triangle[0], triangle[1]].map(|i| mesh.positions[i as usize]);
            let target = if n % 4 == 0 { a } else { a.lerp(b, unit(&mut s)) };
            let to_world = place[(n % place.len() as u64) as usize];
            let origin = to_world.transform_point3a(inside(&mut s).into());
            let direction = to_world.transform_point3a(target.into()) - origin;
            // Exactly along an axis plane now and then.
            let direction = if n % 16 == 1 { direction * Vec3A::new(1.0, 0.0, 1.0) } else { direction };
            if direction == Vec3A::ZERO {
                return false;
            }
            let ray = Ray::new(origin, direction);
            accel.closest(&ray, &|_, _, _, _| true).is_none() || !accel.any(&ray, &|_, _, _, _| true)
        })
        .count() as u64
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    let full = std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1");
    let share = if full { 10_000_000 } else { 1_000_000 } / 10;
    let ball = |r: f32, c: Vec3| move |s: &mut u64| c + (Vec3::new(unit(s), unit(s), unit(s)) - 0.5) * r;
    let here = [Affine3A::IDENTITY];
    let far = Vec3::new(100.0, -30.0, 7.0);
    let turned = [
        Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 3.0, -0.2),
            Quat::from_rotation_y(0.7),
            Vec3::X * 9.0,
        ),
        Affine3A::from_rotation_translation(Quat::from_rotation_z(2.1), Vec3::new(-5.0, 7.0, 0.3)),
    ];
    let best = Kernel::available()[0];
    let rows: [(&str, u64); 4] = [
        ("sphere", misses(sphere(60, 80, Vec3::ZERO), &here, best, 4 * share, ball(0.5, Vec3::ZERO))),
        ("sphere far from the origin", misses(sphere(60, 80, far), &here, best, 2 * share, ball(0.5, far))),
        ("instances", misses(sphere(60, 80, Vec3::ZERO), &turned, best, 2 * share, ball(0.5, Vec3::ZERO))),
        (
            "corners of a flat box",
            misses(flat_box(20.0), &here, best, 2 * share, |s| {
                // From next to a corner of the box to anywhere in it.
                let near = |x: f32| 1.0 - x.powi(8);
                Vec3::new(
                    near(unit(s)) * 19.999,
                    0.19999 * (0.0001 + 0.9998 * unit(s)),
                    -near(unit(s)) * 19.999,
                )
            }),
        ),
    ];
    for (name, missed) in rows {
        assert_eq!(missed, 0, "{name}: rays that left");
    }
    for kernel in Kernel::available() {
        let missed = misses(sphere(30, 40, Vec3::ZERO), &here, kernel, share / 2, ball(0.5, Vec3::ZERO));
        assert_eq!(missed, 0, "{kernel:?}: rays that left");
    }
}
