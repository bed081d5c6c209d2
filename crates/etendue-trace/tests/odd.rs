//! Odd geometry, odd rays: no panic, no hang, no NaN, and the promised answer.

use etendue_scene::{Instance, Mesh, Scene};
use etendue_trace::{Accel, Hit, Ray};
use glam::{Affine3A, DVec3, Vec3, Vec3A};

fn scene(triangles: &[[Vec3; 3]], places: &[Affine3A]) -> Scene {
    let mesh = Mesh {
        positions: triangles.as_flattened().to_vec(),
        indices: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    let place = |&transform| Instance { name: String::new(), mesh: 0, material: None, transform };
    Scene { meshes: vec![mesh.into()], instances: places.iter().map(place).collect(), ..Scene::default() }
}

fn closest(accel: &Accel, ray: &Ray) -> Option<Hit> {
    let hit = accel.closest(ray, &|_, _, _, _| panic!("nothing here has alpha"));
    assert_eq!(hit.is_some(), accel.any(ray, &|_, _, _, _| panic!("nothing here has alpha")));
    hit
}

const UNIT: [Vec3; 3] = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(3.0, -1.0, 0.0), Vec3::new(-1.0, 3.0, 0.0)];

fn down() -> Ray {
    Ray::new(Vec3A::new(0.0, 0.0, 1.0), Vec3A::NEG_Z)
}

#[test]
fn the_lower_bound_is_open_and_the_upper_closed() {
    let accel = Accel::build(&scene(&[UNIT], &[Affine3A::IDENTITY]));
    let hit = closest(&accel, &down()).expect("in front");
    assert_eq!((hit.t, hit.u, hit.v, hit.instance, hit.triangle), (1.0, 0.25, 0.25, 0, 0));
    assert!(closest(&accel, &Ray { t_min: 1.0, ..down() }).is_none());
    assert!(closest(&accel, &Ray { t_min: 1f32.next_down(), ..down() }).is_some());
    assert!(closest(&accel, &Ray { t_max: 1.0, ..down() }).is_some());
    assert!(closest(&accel, &Ray { t_max: 1f32.next_down(), ..down() }).is_none());
    assert!(closest(&accel, &Ray { t_min: f32::NAN, ..down() }).is_some());
    assert!(closest(&accel, &Ray { t_min: -5.0, direction: Vec3A::Z, ..down() }).is_none());
    assert!(closest(&accel, &Ray { t_max: f32::NAN, ..down() }).is_none());
    let hit = closest(&accel, &Ray { direction: Vec3A::NEG_Z * 4.0, ..down() }).expect("in front");
    assert_eq!(hit.t, 0.25);
}

#[test]
fn an_empty_scene_is_never_hit() {
    for s in [Scene::default(), scene(&[], &[]), scene(&[], &[Affine3A::IDENTITY; 2]), scene(&[UNIT], &[])] {
        let accel = Accel::build(&s);
        assert!(closest(&accel, &down()).is_none());
        assert!(accel.bounds().is_empty());
        assert_eq!(accel.triangle_count(), 0);
    }
}

#[test]
fn rays_that_are_none_hit_nothing_and_return() {
    let accel =
        Accel::build(&scene(&[UNIT; 100], &[Affine3A::IDENTITY, Affine3A::from_scale(Vec3::splat(2.0))]));
    let odd =
        [0.0, -0.0, 1.0, -1.0, 1e-40, 1e-20, 1e30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX];
    for x in odd {
        for y in odd {
            for z in odd {
                let v = Vec3A::new(x, y, z);
                for ray in [Ray { direction: v, ..down() }, Ray { origin: v, ..down() }, Ray::new(v, v)] {
                    let hit = closest(&accel, &ray);
                    if let Some(h) = hit {
                        assert!(ray.origin.is_finite() && ray.direction.is_finite(), "{ray:?}");
                        assert!(h.t.is_finite() && h.u.is_finite() && h.v.is_finite(), "{ray:?}: {h:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn triangles_without_area_are_left_out() {
    let (a, b) = (Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
    let flat = [
        [a, a, a],
        [a, b, b],
        [a, b, (a + b) * 0.5],
        [a, b, b * 3.0],
        [a * 1e-25, b * 1e-25, Vec3::Y * 1e-25],
    ];
    let odd = [[a, b, Vec3::NAN], [a, b, Vec3::INFINITY]];
    let all: Vec<_> = flat.iter().chain(&odd).copied().collect();
    for places in [&[Affine3A::IDENTITY][..], &[Affine3A::IDENTITY; 2]] {
        let mut s = scene(&all, places);
        std::sync::Arc::make_mut(&mut s.meshes[0]).indices.push([0, 1, 1_000_000]);
        let accel = Accel::build(&s);
        assert_eq!(accel.triangle_count(), 0);
        assert!(closest(&accel, &down()).is_none());
    }
}

#[test]
fn instances_may_be_mirrored_and_singular_ones_are_not_seen() {
    let flat = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
    for places in [&[flat][..], &[flat, flat]] {
        let accel = Accel::build(&scene(&[UNIT], places));
        assert!(closest(&accel, &down()).is_none());
        assert_eq!(accel.triangle_count(), 0);
    }
    let at =
        |z: f32| Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * Affine3A::from_translation(Vec3::Z * z);
    let accel = Accel::build(&scene(&[UNIT], &[flat, at(-1.0), at(-0.5), at(-1.0)]));
    let hit = closest(&accel, &down()).expect("the mirrored ones");
    assert_eq!((hit.t, hit.instance), (1.5, 2));
    // Equal distances: the lower instance.
    let accel = Accel::build(&scene(&[UNIT, UNIT], &[at(-1.0), at(-1.0)]));
    let hit = closest(&accel, &down()).expect("both");
    assert_eq!((hit.t, hit.instance, hit.triangle), (2.0, 0, 0));
}

#[test]
fn trees_stay_shallow_on_input_made_to_deepen_them() {
    // Sizes and distances that double: every split by area takes one off.
    let doubling: Vec<_> = (-60..60).map(|i| UNIT.map(|p| (p + Vec3::splat(2.0)) * 2f32.powi(i))).collect();
    let many: Vec<_> = doubling.iter().copied().cycle().take(20_000).collect();
    let same = vec![UNIT; 20_000];
    let accel = Accel::build(&scene(&many, &[Affine3A::IDENTITY]));
    assert!(closest(&accel, &Ray::new(Vec3A::new(2.0, 2.0, -9.0), Vec3A::Z)).is_some());
    let accel = Accel::build(&scene(&same, &[Affine3A::IDENTITY]));
    assert_eq!(closest(&accel, &down()).map(|h| h.triangle), Some(0));
    let accel = Accel::build(&scene(&[UNIT], &vec![Affine3A::IDENTITY; 5000]));
    assert_eq!(closest(&accel, &down()).map(|h| h.instance), Some(0));
}

#[test]
fn distances_and_weights_match_the_textbook_in_double_precision() {
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut vec = || Vec3::new(unit(), unit(), unit()) * 2.0 - 1.0;
    let mut hits = 0;
    for _ in 0..20_000 {
        let triangle = [vec(), vec(), vec()];
        let ray = Ray::new(vec().into(), vec().into());
        let accel = Accel::build(&scene(&[triangle], &[Affine3A::IDENTITY]));
        // Möller and Trumbore 1997.
        let [a, b, c] = triangle.map(|p| p.as_dvec3());
        let wide = |v: Vec3A| DVec3::new(v.x as f64, v.y as f64, v.z as f64);
        let (o, d) = (wide(ray.origin), wide(ray.direction));
        let (e, f) = (b - a, c - a);
        let p = d.cross(f);
        let det = e.dot(p);
        let s = o - a;
        let q = s.cross(e);
        let (t, u, v) = (f.dot(q) / det, s.dot(p) / det, d.dot(q) / det);
        let margin = u.min(v).min(1.0 - u - v).min(t);
        let hit = closest(&accel, &ray);
        if margin > 1e-3 {
            let h = hit.expect("well inside");
            let error = (h.t as f64 - t).abs().max((h.u as f64 - u).abs()).max((h.v as f64 - v).abs());
            assert!(error < 2e-6 / det.abs().min(1.0) * (1.0 + t.abs()), "{h:?} for {t} {u} {v}, det {det}");
            hits += 1;
        } else if margin < -1e-3 {
            assert!(hit.is_none(), "{hit:?} for {t} {u} {v}");
        }
    }
    assert!(hits > 500, "{hits}");
}
