//! The node hierarchy: that it is a forest, where each node stands, which ones a scene shows.
//!
//! Nothing here recurses, so depth costs no stack.

use crate::document::{Document, Local, get};
use crate::error::Fault;
use crate::limits::Limits;
use crate::warning::Warnings;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

/// Who is whose parent.
pub(crate) struct Hierarchy {
    parent: Vec<Option<u32>>,
    /// All nodes, parents before children.
    order: Vec<u32>,
}

impl Hierarchy {
    /// Checks that every node has at most one parent and that no node is its own ancestor.
    pub fn new(doc: &Document<'_>, limits: &Limits) -> Result<Self, Fault> {
        let n = doc.nodes.len();
        let mut parent: Vec<Option<u32>> = vec![None; n];
        for (i, node) in doc.nodes.iter().enumerate() {
            for (k, &c) in node.children.iter().enumerate() {
                let pointer = || format!("/nodes/{i}/children/{k}");
                get(&doc.nodes, c, "node", pointer)?;
                if let Some(other) = parent[c as usize] {
                    return Err(Fault::invalid(
                        pointer(),
                        format!("node {c} is already a child of node {other}"),
                    ));
                }
                parent[c as usize] = Some(i as u32);
            }
        }
        let mut order: Vec<u32> = (0..n as u32).filter(|&i| parent[i as usize].is_none()).collect();
        let mut depth = vec![1u32; n];
        let mut next = 0;
        while let Some(&i) = order.get(next) {
            next += 1;
            for &c in &doc.nodes[i as usize].children {
                depth[c as usize] = depth[i as usize] + 1;
                if depth[c as usize] > limits.node_depth {
                    return Err(Fault::TooLarge {
                        pointer: format!("/nodes/{c}"),
                        what: format!("more than {} nodes above one another", limits.node_depth),
                        limit: "node_depth",
                    });
                }
                order.push(c);
            }
        }
        // Every node has at most one parent, so what no root reaches hangs on a cycle.
        if order.len() < n {
            let mut reached = vec![false; n];
            order.iter().for_each(|&i| reached[i as usize] = true);
            let i = reached.iter().position(|r| !r).unwrap_or_default();
            return Err(Fault::invalid(format!("/nodes/{i}"), "the node is on a cycle of children"));
        }
        Ok(Self { parent, order })
    }

    /// Node space to world space, for every node. In double precision: chains of large offsets are common in exported
    /// drawings.
    pub fn globals(&self, locals: &[DAffine3]) -> Vec<DAffine3> {
        let mut out = locals.to_vec();
        for &i in &self.order {
            if let Some(p) = self.parent[i as usize] {
                out[i as usize] = out[p as usize] * locals[i as usize];
            }
        }
        out
    }

    /// Per node whether it or one above it is not to be seen.
    pub fn hidden(&self, visible: impl Fn(u32) -> bool) -> Vec<bool> {
        let mut out = vec![false; self.parent.len()];
        for &i in &self.order {
            let above = self.parent[i as usize].is_some_and(|p| out[p as usize]);
            out[i as usize] = above || !visible(i);
        }
        out
    }

    /// The nodes that the file's default scene shows, parents before children, in the order of the file.
    pub fn shown(&self, doc: &Document<'_>, warnings: &mut Warnings) -> Result<Vec<u32>, Fault> {
        let scene = match doc.scene {
            Some(s) => Some((s, get(&doc.scenes, s, "scene", || "/scene".into())?)),
            None => doc.scenes.first().map(|s| (0, s)),
        };
        let roots = match scene {
            Some((n, s)) => {
                for (k, &i) in s.nodes.iter().enumerate() {
                    let pointer = || format!("/scenes/{n}/nodes/{k}");
                    get(&doc.nodes, i, "node", pointer)?;
                    if self.parent[i as usize].is_some() {
                        warnings
                            .add(pointer(), "the scene's node has a parent; shown where its parent puts it");
                    }
                }
                s.nodes.clone()
            }
            None => {
                if !doc.nodes.is_empty() {
                    warnings.add("", "the file has no scene; all its nodes are shown");
                }
                self.order.iter().copied().filter(|&i| self.parent[i as usize].is_none()).collect()
            }
        };
        let mut seen = vec![false; doc.nodes.len()];
        let mut out = Vec::new();
        let mut stack: Vec<u32> = roots.into_iter().rev().collect();
        while let Some(i) = stack.pop() {
            if !std::mem::replace(&mut seen[i as usize], true) {
                out.push(i);
                stack.extend(doc.nodes[i as usize].children.iter().rev());
            }
        }
        Ok(out)
    }
}

/// A node's own transform as the file says it; `pointer` is the node's.
pub(crate) fn local(l: &Local, pointer: impl Fn() -> String, warnings: &mut Warnings) -> DAffine3 {
    match *l {
        Local::Trs(t, q, s) => {
            let q = rotation(q, || {
                warnings.add(
                    format!("{}/rotation", pointer()),
                    "the quaternion is not of unit length; normalised",
                )
            });
            DAffine3::from_scale_rotation_translation(s.into(), q, t.into())
        }
        Local::Matrix(m) => {
            let m = DMat4::from_cols_array(&m);
            if m.row(3) != glam::DVec4::W {
                warnings
                    .add(format!("{}/matrix", pointer()), "the last row is not 0 0 0 1; taken as if it were");
            }
            DAffine3 { matrix3: DMat3::from_mat4(m), translation: m.w_axis.truncate() }
        }
    }
}

/// The unit quaternion along `q`; identity if it has no direction. Calls `odd` if `q` was noticeably not of unit length.
pub(crate) fn rotation(q: [f64; 4], odd: impl FnOnce()) -> DQuat {
    let q = DQuat::from_array(q);
    let length = q.length();
    // Bytes hold a quaternion to about one part in a hundred.
    if !(length - 1.0).abs().le(&0.02) {
        odd();
    }
    if length.is_finite() && length > 1e-12 { q / length } else { DQuat::IDENTITY }
}

/// The rotation of `m` without its scale: the view axis keeps its direction, up is made square to it. A mirrored frame
/// is made right-handed by turning X over.
pub(crate) fn without_scale(m: &DAffine3) -> Option<DMat3> {
    let z = m.matrix3.z_axis.try_normalize()?;
    let y: DVec3 = m.matrix3.y_axis;
    let y = (y - z * z.dot(y)).try_normalize()?;
    Some(DMat3::from_cols(y.cross(z), y, z))
}
