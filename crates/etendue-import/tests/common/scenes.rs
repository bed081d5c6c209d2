//! Whether two scenes show the same, however their vertices are numbered.

use etendue_scene::{Instance, Mesh, Scene};

/// What is demanded of tangents.
#[derive(Clone, Copy, PartialEq)]
pub enum Tangents {
    /// The same bits.
    Same,
    /// Rounded once more.
    Near,
    /// Nothing: those of a posed mesh were made in another pose.
    Any,
}

/// Everything about the corners of a mesh's triangles but their tangents, bit by bit.
fn corners(m: &Mesh) -> Vec<u32> {
    let mut out = Vec::new();
    for &v in m.indices.as_flattened() {
        let v = v as usize;
        out.extend(m.positions[v].to_array().map(f32::to_bits));
        out.extend(m.normals.get(v).iter().flat_map(|n| n.to_array()).map(f32::to_bits));
        out.extend(m.uvs.iter().flat_map(|uv| uv[v].to_array()).map(f32::to_bits));
        out.extend(m.colors.get(v).iter().flat_map(|c| c.to_array()).map(f32::to_bits));
    }
    out
}

fn tangents(m: &Mesh) -> Vec<f32> {
    let of = |&v: &u32| m.tangents.get(v as usize).map(|t| t.to_array());
    m.indices.as_flattened().iter().filter_map(of).flatten().collect()
}

/// Panics with `what` if the scenes differ.
pub fn assert_same(a: &Scene, b: &Scene, demanded: Tangents, what: &str) {
    assert_eq!(a.instances.len(), b.instances.len(), "{what}");
    let mut compared = std::collections::HashSet::new();
    for (i, j) in a.instances.iter().zip(&b.instances) {
        let text = |i: &Instance| format!("{} {:?} {:?}", i.name, i.material, i.transform);
        assert_eq!(text(i), text(j), "{what}");
        if !compared.insert((i.mesh, j.mesh)) {
            continue;
        }
        let (m, n) = (&a.meshes[i.mesh as usize], &b.meshes[j.mesh as usize]);
        assert_eq!(m.name, n.name, "{what}");
        assert!(corners(m) == corners(n), "{what}: the corners of mesh {} differ", m.name);
        let (s, t) = (tangents(m), tangents(n));
        assert_eq!(s.len(), t.len(), "{what}: tangents of {}", m.name);
        let tolerance = match demanded {
            Tangents::Same => 0.0,
            Tangents::Near => 1e-6,
            Tangents::Any => f32::MAX,
        };
        let worst = s.iter().zip(&t).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
        assert!(worst <= tolerance, "{what}: tangents of {} differ by {worst}", m.name);
    }
    let text = |s: &Scene| format!("{:?}", (&s.materials, &s.textures, &s.lights, &s.cameras, &s.variants));
    assert_eq!(text(a), text(b), "{what}");
    assert_eq!(a.images.len(), b.images.len(), "{what}");
    assert!(a.images.iter().zip(&b.images).all(|(x, y)| x == y), "{what}: pictures");
    assert!(format!("{:?}", a.profiles) == format!("{:?}", b.profiles), "{what}: profiles");
    assert!(format!("{:?}", a.environment) == format!("{:?}", b.environment), "{what}: sky");
}
