//! Meshes, materials and animations that no picture at rest shows, read as if one did.

use super::{Case, list};
use crate::animation::{AnimationChoice, Pose};
use crate::changed::Changed;
use crate::document::{Component, Primitive, Shape};
use crate::limits::Budget;
use crate::material;
use crate::plan::Plan;
use crate::warning::Warnings;
use glam::DAffine3;
use std::collections::HashSet;

/// Deviation from unit length that is let through, as by the Khronos validator.
const UNIT_LENGTH: f32 = 0.00674;

impl Case<'_> {
    /// The nodes from `first` on are such that show one mesh each.
    pub(super) fn unused(&mut self, first: u32) {
        let (accessors, doc) = (self.accessors, self.accessors.doc);
        self.announced();
        let mut warnings = Warnings::default();
        // At their first moment animations are read as at any other.
        if !doc.animations.is_empty()
            && let Err(e) = Pose::at(0.0, &AnimationChoice::All, accessors, &mut warnings)
        {
            self.fault(e);
        }
        let globals = vec![DAffine3::IDENTITY; doc.nodes.len()];
        let (pose, changed) = (Pose::default(), Changed::default());
        let budget = Budget::new(self.source.limits, self.source.used);
        let mut plan = Plan::new(accessors, &pose, &changed, &globals, true, budget, warnings);
        let mut faults = Vec::new();
        for i in first..doc.nodes.len() as u32 {
            faults.extend(plan.node(i, false).err());
        }
        for job in &plan.jobs {
            // One after another, and none is kept.
            faults.extend(job.build(accessors, None, &mut plan.warnings).err());
        }
        let primitives = doc.meshes.iter().flat_map(|m| &m.primitives);
        let used: HashSet<u32> = primitives.filter_map(|p| p.material).collect();
        for (i, m) in (0..).zip(&doc.materials).filter(|(i, _)| !used.contains(i)) {
            let made = material::convert(i, m, &mut plan.textures, true, &mut plan.warnings);
            faults.extend(made.err());
        }
        // A texture may have no picture; only who uses it is told.
        let told = plan.warnings.into_vec().into_iter().filter(|w| !w.pointer.starts_with("/textures/"));
        told.for_each(|w| self.out.join(w));
        faults.into_iter().for_each(|e| self.fault(e));
    }

    /// What meshes say of themselves and the reader does not ask.
    fn announced(&mut self) {
        let doc = self.accessors.doc;
        let json = list(self.root, "accessors");
        for (i, m) in doc.meshes.iter().enumerate() {
            let targets = m.primitives.first().map_or(0, |p| p.targets.len());
            if m.primitives.iter().any(|p| p.targets.len() != targets) {
                self.out.add(format!("/meshes/{i}"), "primitives with different numbers of morph targets");
            }
            if !m.weights.is_empty() && m.weights.len() != targets {
                self.out.add(format!("/meshes/{i}/weights"), "as many weights as morph targets are needed");
            }
            for (k, p) in m.primitives.iter().enumerate() {
                let at = || format!("/meshes/{i}/primitives/{k}");
                self.directions(p, &at());
                let material = p.material.and_then(|m| doc.materials.get(m as usize));
                let bends =
                    material.filter(|m| m.normal_texture.is_none()).and_then(|m| m.surface.as_deref());
                let needs = bends.is_some_and(|s| {
                    s.anisotropy.is_some() || s.clearcoat.as_ref().is_some_and(|c| c.normal_texture.is_some())
                });
                if needs && p.attribute("TANGENT").is_none() {
                    self.out.add(
                        format!("{}/material", at()),
                        "needs tangents, but the mesh has none, nor the material a normal texture to make them for",
                    );
                }
                let Some(position) = p.attribute("POSITION") else { continue };
                let bounds = json.get(position as usize);
                if bounds.is_some_and(|a| a.get("min").is_none() || a.get("max").is_none()) {
                    self.out.add(
                        format!("{}/attributes/POSITION", at()),
                        "positions need `min` and `max` of their accessor",
                    );
                }
            }
        }
    }

    /// Normals and tangents as floats: of unit length, tangents with a sign.
    fn directions(&mut self, p: &Primitive<'_>, at: &str) {
        let long = |[x, y, z]: [f32; 3]| ((x * x + y * y + z * z).sqrt() - 1.0).abs() > UNIT_LENGTH;
        for (name, shape) in [("NORMAL", Shape::Vec3), ("TANGENT", Shape::Vec4)] {
            let Some(a) = p.attribute(name) else { continue };
            // Whoever reads them says what is wrong with the accessor.
            let Ok(e) = self.accessors.open(a, name, &[shape], String::new) else { continue };
            if e.component() != Component::F32 || e.is_plain_zero() {
                continue;
            }
            let at = format!("{at}/attributes/{name}");
            let lengths = match shape {
                Shape::Vec3 => e.floats::<3>(None).into_iter().any(long),
                _ => e.floats::<4>(None).into_iter().any(|[x, y, z, _]| long([x, y, z])),
            };
            if lengths {
                self.out.add(at.clone(), "directions that are not of unit length");
            }
            if shape == Shape::Vec4 && e.floats::<4>(None).iter().any(|t| t[3].abs() != 1.0) {
                self.out.add(at, "tangents whose sign is neither 1 nor −1");
            }
        }
    }
}
