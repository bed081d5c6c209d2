//! Meshes that stand in several places: which they are, and the way of a ray into their space.

use crate::ray::{BOX_ROUNDINGS, Ray, UNIT};
use etendue_scene::{Bounds, Scene};
use glam::{DMat3, DVec3, Vec3A};

/// Transforms that amplify rounding errors more than this are treated as if they amplified this much: beyond it
/// next to nothing of `f32` is left, and boxes would grow without end.
const MAX_AMPLIFICATION: f64 = 65536.0;

/// |det| below this part of the product of the columns' lengths counts as singular: what is left of it is rounding.
const SINGULAR: f64 = 1e-7;

/// An instance of a mesh that has a tree of its own.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the list of mesh trees.
    pub tree: u32,
    /// Whether the instance's material has alpha.
    pub alpha: bool,
    /// ‖M‖∞ · ‖M⁻¹‖∞ and a little: how much larger errors get on the way to the mesh and back.
    pub amplification: f32,
    matrix: DMat3,
    inverse: DMat3,
    translation: DVec3,
}

impl Placement {
    /// The ray in the mesh's space, with the same `t`. Computed in `f64`: one rounding per component.
    #[inline(always)]
    pub fn to_mesh(&self, ray: &Ray, t_max: f32) -> Ray {
        let wide = |v: Vec3A| DVec3::new(v.x as f64, v.y as f64, v.z as f64);
        let narrow = |v: DVec3| Vec3A::new(v.x as f32, v.y as f32, v.z as f32);
        Ray {
            origin: narrow(self.inverse * (wide(ray.origin) - self.translation)),
            direction: narrow(self.inverse * wide(ray.direction)),
            t_min: ray.t_min,
            t_max,
        }
    }

    /// A world-space box around the mesh's box `b`, grown for rays with coordinates up to `covered`; `None` if it is
    /// empty or not finite.
    pub fn world_bounds(&self, b: &Bounds, covered: f32) -> Option<(Vec3A, Vec3A)> {
        if b.is_empty() {
            return None;
        }
        let wide = |v: Vec3A| DVec3::new(v.x as f64, v.y as f64, v.z as f64);
        let (lo, hi) = (wide(b.min), wide(b.max));
        let center = self.matrix * ((lo + hi) * 0.5) + self.translation;
        let m = self.matrix;
        let abs = DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
        let half = abs * ((hi - lo) * 0.5);
        // A little larger than `f32` rounding of the corners, and the error of the ray in the mesh's space.
        let error = self.amplification as f64 * covered as f64 * (BOX_ROUNDINGS * UNIT) as f64;
        let grow = (center.abs() + half) * 1e-6 + DVec3::splat(error);
        let narrow = |v: DVec3| Vec3A::new(v.x as f32, v.y as f32, v.z as f32);
        let (lo, hi) = (narrow(center - half - grow), narrow(center + half + grow));
        (lo.is_finite() && hi.is_finite()).then_some((lo, hi))
    }
}

/// Sorts instances into those to place (of meshes with several users), those to bake (the only user of their
/// mesh) and, third, gives the meshes that need trees of their own. Singular instances are in neither list.
pub(crate) fn placements(scene: &Scene, users: &[u32]) -> (Vec<Placement>, Vec<u32>, Vec<u32>) {
    let (mut placed, mut baked, mut shared) = (Vec::new(), Vec::new(), Vec::new());
    let mut tree_of = vec![None; scene.meshes.len()];
    for (n, i) in scene.instances.iter().enumerate() {
        let Some(&users) = users.get(i.mesh as usize) else { continue };
        if !i.transform.is_finite() {
            continue;
        }
        let wide = |v: Vec3A| DVec3::new(v.x as f64, v.y as f64, v.z as f64);
        let t = i.transform;
        let m = DMat3::from_cols(wide(t.matrix3.x_axis), wide(t.matrix3.y_axis), wide(t.matrix3.z_axis));
        let volume = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
        let det = m.determinant();
        if det.abs() <= SINGULAR * volume || !det.is_normal() {
            continue;
        }
        if users == 1 {
            baked.push(n as u32);
            continue;
        }
        let inverse = m.inverse();
        if !inverse.is_finite() {
            continue;
        }
        let tree = *tree_of[i.mesh as usize].get_or_insert_with(|| {
            shared.push(i.mesh);
            shared.len() as u32 - 1
        });
        let norm = |m: &DMat3| (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()).max_element();
        let amplification = 1.25 * norm(&m) * norm(&inverse);
        placed.push(Placement {
            instance: n as u32,
            tree,
            alpha: false,
            amplification: amplification.min(MAX_AMPLIFICATION) as f32,
            matrix: m,
            inverse,
            translation: wide(t.translation),
        });
    }
    (placed, baked, shared)
}
