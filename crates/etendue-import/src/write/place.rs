//! Transforms as translation, rotation and scale.

use glam::{Affine3A, DMat3, DQuat, DVec3};
use serde_json::{Map, Value, json};

/// Translation, rotation and scale, and, for what these cannot say, a rotation before the scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
    /// Of a child that carries the mesh.
    pub first: Option<DQuat>,
}

impl Place {
    /// The parts of `m`: directly if its axes are at right angles, else by its singular values M = R₁ S R₂.
    pub fn of(m: &Affine3A) -> Self {
        let a = DMat3::from_cols(
            m.matrix3.x_axis.as_dvec3(),
            m.matrix3.y_axis.as_dvec3(),
            m.matrix3.z_axis.as_dvec3(),
        );
        let translation = m.translation.as_dvec3();
        let c = [a.x_axis, a.y_axis, a.z_axis];
        let skew = |i: usize, j: usize| c[i].dot(c[j]).abs() > 1e-6 * c[i].length() * c[j].length();
        if !skew(0, 1) && !skew(1, 2) && !skew(2, 0) {
            let (rotation, scale) = frame(c);
            return Self { translation, rotation, scale, first: None };
        }
        // M V has orthogonal columns if V holds the eigenvectors of MᵀM.
        let v = eigenvectors(a.transpose() * a);
        let b = a * v;
        let (rotation, scale) = frame([b.x_axis, b.y_axis, b.z_axis]);
        let first = DQuat::from_mat3(&v.transpose()).normalize();
        Self { translation, rotation, scale, first: Some(first) }
    }

    /// The node's properties, without those that change nothing.
    pub fn node(&self) -> Map<String, Value> {
        let mut out = Map::new();
        if self.translation != DVec3::ZERO {
            out.insert("translation".into(), json!(self.translation.to_array()));
        }
        if self.rotation != DQuat::IDENTITY {
            out.insert("rotation".into(), json!(self.rotation.to_array()));
        }
        if self.scale != DVec3::ONE {
            out.insert("scale".into(), json!(self.scale.to_array()));
        }
        out
    }
}

/// Rotation and scale whose product has the columns `c`, which are at right angles or zero. One scale is negative if they
/// are left-handed.
fn frame(c: [DVec3; 3]) -> (DQuat, DVec3) {
    // As near to 1 as single precision can tell is 1: a rotation does not scale.
    let length = |v: DVec3| if (v.length() - 1.0).abs() < 2e-7 { 1.0 } else { v.length() };
    let mut scale = DVec3::from_array(c.map(length));
    let mut unit = c.map(|v| v.try_normalize());
    // The longest ones first: what is zero gets a direction from them.
    for i in 0..3 {
        if unit[i].is_none() {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            unit[i] = Some(match (unit[j], unit[k]) {
                (Some(a), Some(b)) => a.cross(b).normalize(),
                (Some(a), None) | (None, Some(a)) => a.any_orthonormal_vector(),
                (None, None) => [DVec3::X, DVec3::Y, DVec3::Z][i],
            });
        }
    }
    let [x, y, z] = unit.map(Option::unwrap_or_default);
    let mut m = DMat3::from_cols(x, y, z);
    if m.determinant() < 0.0 {
        m.x_axis = -m.x_axis;
        scale.x = -scale.x;
    }
    let q = DQuat::from_mat3(&m).normalize();
    // Exactly none where there is nearly none.
    (if q.w > 1.0 - 1e-15 { DQuat::IDENTITY } else { q }, scale)
}

/// Eigenvectors of a symmetric matrix as a rotation, by Jacobi's method (Golub, Van Loan 2013, §8.5).
fn eigenvectors(mut a: DMat3) -> DMat3 {
    let mut v = DMat3::IDENTITY;
    // Convergence is quadratic: six sweeps reach the last bit.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let apq = a.col(q)[p];
            if apq == 0.0 {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * apq);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let mut j = DMat3::IDENTITY;
            j.col_mut(p)[p] = c;
            j.col_mut(q)[q] = c;
            j.col_mut(q)[p] = s;
            j.col_mut(p)[q] = -s;
            a = j.transpose() * a * j;
            v *= j;
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat3A, Vec3A};

    #[test]
    fn parts_make_the_whole() {
        let turn = Mat3A::from_quat(glam::Quat::from_xyzw(0.1, -0.7, 0.3, 0.4).normalize());
        let shear = Mat3A::from_cols(Vec3A::X, Vec3A::new(0.5, 2.0, 0.0), Vec3A::new(0.0, 0.3, -0.4));
        let flat = Mat3A::from_diagonal(glam::Vec3::new(0.0, 2.0, 3.0));
        let line = Mat3A::from_diagonal(glam::Vec3::new(0.0, 2.0, 0.0));
        let mirror = Mat3A::from_diagonal(glam::Vec3::new(1.0, -2.0, 3.0));
        for m in [
            Mat3A::IDENTITY,
            turn,
            turn * mirror,
            shear,
            turn * shear * turn,
            turn * flat,
            line,
            Mat3A::ZERO,
            shear * flat * turn,
        ] {
            let m = Affine3A { matrix3: m, translation: Vec3A::new(1.0, 2.0, 3.0) };
            let p = Place::of(&m);
            let mut made = DMat3::from_quat(p.rotation) * DMat3::from_diagonal(p.scale);
            if let Some(q) = p.first {
                made *= DMat3::from_quat(q);
            }
            for k in 0..3 {
                let error = (made.col(k) - m.matrix3.col(k).as_dvec3()).length();
                assert!(error < 1e-6, "{m:?}: {error}");
            }
        }
        assert!(Place::of(&Affine3A::IDENTITY).node().is_empty());
        assert!(Place::of(&Affine3A { matrix3: shear, translation: Vec3A::ZERO }).first.is_some());
    }
}
