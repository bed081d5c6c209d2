//! Skins: vertices carried by joints (glTF 2.0, 3.7.3).

use crate::accessor::Accessors;
use crate::document::{Component, Shape, get};
use crate::error::Fault;
use crate::warning::Warnings;
use glam::{Affine3A, DAffine3, DMat3, DMat4, Mat3A, Vec3, Vec3A, Vec4};

/// The matrices of a skin's joints: mesh space at rest to world space.
pub(crate) fn joint_matrices(
    skin: u32,
    globals: &[DAffine3],
    accessors: Accessors<'_>,
    warnings: &mut Warnings,
) -> Result<Vec<Affine3A>, Fault> {
    let pointer = || format!("/skins/{skin}");
    let s = get(&accessors.doc.skins, skin, "skin", pointer)?;
    let inverse_bind = match s.inverse_bind_matrices {
        None => None,
        Some(a) => {
            let from = || format!("{}/inverseBindMatrices", pointer());
            let e = accessors.open(a, "an inverse bind matrix", &[Shape::Mat4], from)?;
            if e.len() < s.joints.len() {
                return Err(Fault::invalid(
                    from(),
                    format!("{} matrices for {} joints", e.len(), s.joints.len()),
                ));
            }
            if e.component() != Component::F32 {
                return Err(Fault::invalid(from(), "inverse bind matrices are floats (5126)"));
            }
            let used: Vec<u32> = (0..s.joints.len() as u32).collect();
            Some(e.floats::<16>(Some(&used)))
        }
    };
    let mut out = Vec::with_capacity(s.joints.len());
    for (k, &j) in s.joints.iter().enumerate() {
        let from = || format!("{}/joints/{k}", pointer());
        get(&accessors.doc.nodes, j, "node", from)?;
        let mut m = globals[j as usize];
        if let Some(ibm) = &inverse_bind {
            let b = DMat4::from_cols_array(&ibm[k].map(f64::from));
            m *= DAffine3 { matrix3: DMat3::from_mat4(b), translation: b.w_axis.truncate() };
        }
        let m = narrow(&m);
        out.push(if m.is_finite() {
            m
        } else {
            warnings.add(from(), "the joint's transform is not finite; its vertices stay at rest");
            Affine3A::IDENTITY
        });
    }
    Ok(out)
}

/// To single precision.
pub(crate) fn narrow(m: &DAffine3) -> Affine3A {
    Affine3A {
        matrix3: Mat3A::from_cols(
            m.matrix3.x_axis.as_vec3a(),
            m.matrix3.y_axis.as_vec3a(),
            m.matrix3.z_axis.as_vec3a(),
        ),
        translation: m.translation.as_vec3a(),
    }
}

/// Which joints carry each vertex, and how much: one list per `JOINTS_n`/`WEIGHTS_n` pair.
pub(crate) struct Influences {
    pub joints: Vec<Vec<[u32; 4]>>,
    pub weights: Vec<Vec<[f32; 4]>>,
}

impl Influences {
    /// Checks that every joint with a weight exists, and scales the weights of every vertex to sum to one.
    pub fn normalise(
        &mut self,
        joint_count: usize,
        pointer: impl Fn() -> String,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        let vertices = self.joints.iter().map(Vec::len).min().unwrap_or(0);
        for v in 0..vertices {
            let mut sum = 0.0;
            for (joints, weights) in self.joints.iter_mut().zip(&mut self.weights) {
                for (j, w) in joints[v].iter_mut().zip(&mut weights[v]) {
                    // Also catches what is not a number.
                    if !(*w > 0.0 && w.is_finite()) {
                        if *w != 0.0 {
                            warnings.add(pointer(), "negative or non-finite joint weights; taken as 0");
                        }
                        (*w, *j) = (0.0, 0);
                    } else if *j as usize >= joint_count {
                        return Err(Fault::invalid(
                            pointer(),
                            format!("vertex {v} hangs on joint {j}; the skin has {joint_count}"),
                        ));
                    }
                    sum += *w;
                }
            }
            if sum > 0.0 && sum.is_finite() {
                let scale = 1.0 / sum;
                self.weights.iter_mut().for_each(|w| w[v].iter_mut().for_each(|w| *w *= scale));
            } else if let Some(w) = self.weights.first_mut() {
                warnings.add(pointer(), "vertices without joint weights; they follow the skin's first joint");
                w[v] = [1.0, 0.0, 0.0, 0.0];
                self.joints[0][v][0] = 0;
            }
        }
        Ok(())
    }

    /// The blended matrix of vertex `v`.
    fn matrix(&self, v: usize, joints: &[Affine3A]) -> Affine3A {
        let mut m = Mat3A::ZERO;
        let mut t = Vec3A::ZERO;
        for (js, ws) in self.joints.iter().zip(&self.weights) {
            for (&j, &w) in js[v].iter().zip(&ws[v]) {
                if w > 0.0 {
                    let a = &joints[j as usize];
                    m += a.matrix3 * w;
                    t += a.translation * w;
                }
            }
        }
        Affine3A { matrix3: m, translation: t }
    }

    /// Moves vertices to where their joints carry them; `normals` and `tangents` may be empty. Returns whether most of
    /// the vertices were mirrored, so that the triangles' winding has to be turned over.
    pub fn deform(
        &self,
        joints: &[Affine3A],
        positions: &mut [Vec3],
        normals: &mut [Vec3],
        tangents: &mut [Vec4],
    ) -> bool {
        let mut mirrored = 0usize;
        for v in 0..positions.len() {
            let m = self.matrix(v, joints);
            positions[v] = m.transform_point3(positions[v]);
            let cofactor = cofactor(&m.matrix3);
            let det = m.matrix3.x_axis.dot(cofactor.x_axis);
            mirrored += usize::from(det < 0.0);
            if let Some(n) = normals.get_mut(v) {
                // The inverse transpose is the cofactor matrix over the determinant; only its sign matters, and the
                // cofactor exists also where a joint flattens space.
                *n = Vec3::from(cofactor * Vec3A::from(*n)) * det.signum();
            }
            if let Some(t) = tangents.get_mut(v) {
                let w = t.w * if det < 0.0 { -1.0 } else { 1.0 };
                *t = Vec3::from(m.matrix3 * Vec3A::from(t.truncate())).extend(w);
            }
        }
        2 * mirrored > positions.len()
    }
}

fn cofactor(m: &Mat3A) -> Mat3A {
    Mat3A::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}
