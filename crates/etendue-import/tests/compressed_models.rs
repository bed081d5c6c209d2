//! Compressed variants of a model beside the model itself: the same triangles within the quantisation.
//!
//! Skips with a message where the assets are not there; `-- --nocapture` prints the distances.
use etendue_import::{ImportOptions, import};
use etendue_scene::Scene;
use glam::{Vec2, Vec3};
use std::path::Path;

/// A corner of a triangle in the world.
#[derive(Clone, Copy)]
struct Corner {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
}

/// The triangles of a model of the shared assets; `None` where it is missing.
fn triangles(path: &str) -> Option<Vec<[Corner; 3]>> {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/models")).join(path);
    if !file.exists() {
        println!("skipped: no {}", file.display());
        return None;
    }
    let i = import(&file, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(i.warnings.iter().all(|w| !w.to_string().contains("not supported")), "{path}: {:?}", i.warnings);
    Some(flat(&i.scene))
}

fn flat(scene: &Scene) -> Vec<[Corner; 3]> {
    let mut out = Vec::new();
    for i in &scene.instances {
        let m = &scene.meshes[i.mesh as usize];
        let texture = scene.materials[i.material.unwrap() as usize].base_color_texture;
        let normals = i.transform.matrix3.inverse().transpose();
        out.extend(m.indices.iter().map(|t| {
            t.map(|k| Corner {
                position: i.transform.transform_point3(m.positions[k as usize]),
                normal: m.normals.get(k as usize).map_or(Vec3::ZERO, |&n| (normals * n).normalize()),
                uv: match (texture, m.uvs.first()) {
                    // Where quantised coordinates need a transform, it is the texture's.
                    (Some(t), Some(uv)) => t.transform.transform_point2(uv[k as usize]),
                    _ => Vec2::ZERO,
                },
            })
        }));
    }
    out
}

/// How far a triangle is from another at most: in space, in the angle of normals (radians), on the texture.
fn apart(a: &[Corner; 3], b: &[Corner; 3], turn: usize) -> [f32; 3] {
    let mut d = [0f32; 3];
    for k in 0..3 {
        let (a, b) = (&a[k], &b[(k + turn) % 3]);
        d[0] = d[0].max(a.position.distance(b.position));
        d[1] = d[1].max(a.normal.angle_between(b.normal));
        d[2] = d[2].max(a.uv.distance(b.uv));
    }
    d
}

/// Finds each triangle of `a` in `b` and returns the largest distances; the order of triangles is the codec's.
fn compare(name: &str, a: &[[Corner; 3]], b: &[[Corner; 3]], bounds: [f32; 3]) {
    assert_eq!(a.len(), b.len(), "{name}");
    let mut worst = [0f32; 3];
    for t in a {
        let near = b.iter().flat_map(|u| (0..3).map(move |turn| (u, turn)));
        let near = near.filter(|(u, turn)| t[0].position.distance(u[*turn].position) <= bounds[0]);
        let cost = |d: &[f32; 3]| (0..3).map(|k| d[k] / bounds[k]).fold(0.0, f32::max);
        let best = near.map(|(u, turn)| apart(t, u, turn)).min_by(|d, e| cost(d).total_cmp(&cost(e)));
        let best = best.unwrap_or_else(|| panic!("{name}: nothing near {:?}", t[0].position));
        for k in 0..3 {
            worst[k] = worst[k].max(best[k]);
        }
    }
    println!("{name}: {} triangles, at most {worst:?} apart, allowed {bounds:?}", a.len());
    assert!((0..3).all(|k| worst[k] <= bounds[k]), "{name}: {worst:?} {bounds:?}");
}

/// Longest edge of the box around all triangles, and of the box around their texture coordinates.
fn extent(t: &[[Corner; 3]]) -> (f32, f32) {
    let corners = || t.iter().flatten();
    let (lo, hi) = corners().fold((Vec3::MAX, Vec3::MIN), |(l, h), c| (l.min(c.position), h.max(c.position)));
    let (ulo, uhi) = corners().fold((Vec2::MAX, Vec2::MIN), |(l, h), c| (l.min(c.uv), h.max(c.uv)));
    ((hi - lo).max_element(), (uhi - ulo).max_element())
}

#[test]
fn meshopt_duck() {
    let (Some(a), Some(b)) =
        (triangles("Duck/Duck.glb"), triangles("cesium-DuckMeshopt-12bit/Duck-vp-12-vt-12-vn-12.glb"))
    else {
        return;
    };
    // Twelve bits each, rounded: half a step per axis.
    let (size, uv) = extent(&a);
    let step = |extent: f32| extent / 4095.0;
    compare("meshopt, 12 bits", &b, &a, [step(size) * 0.87 * 1.01, 0.01, step(uv.max(1.0)) * 0.71 * 1.01]);
}

/// The files were made with 11 bits of positions, 10 of texture coordinates and 8 of normals.
#[test]
fn draco_duck_and_box() {
    for (plain, compressed) in
        [("Duck/Duck.glb", "Duck-glTF-Draco/Duck.gltf"), ("Box/Box.glb", "Box-glTF-Draco/Box.gltf")]
    {
        let (Some(a), Some(b)) = (triangles(plain), triangles(compressed)) else { return };
        let (size, uv) = extent(&a);
        let step = |extent: f32, bits: u32| extent / ((1 << bits) - 1) as f32;
        let bounds = [step(size, 11) * 0.87 * 1.01, 0.03, step(uv.max(1e-3), 10) * 0.71 * 1.01];
        compare(compressed, &b, &a, bounds);
    }
}
