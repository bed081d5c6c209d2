//! Tangents for primitives whose materials need some (a normal texture, that of a coat, anisotropy) and that have none. Vertices
//! whose corners get different ones are split, with everything that they have.

use super::arrays::{Arrays, Elements};
use super::compressed::{ANY, set_entry, vertices};
use super::refs;
use super::tree::{Tree, name};
use super::views::Purpose;
use crate::accessor::Accessors;
use crate::document::{Component, Document, Mode, Primitive, Shape};
use crate::error::Fault;
use crate::geometry::{Job, MeshKey, TangentSpace};
use crate::limits::Budget;
use crate::material;
use crate::plan::tangent_space;
use crate::tangents::{Splitter, of_corners};
use crate::texture::Textures;
use crate::warning::Warnings;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// What was done.
#[derive(Clone, Copy, Default)]
pub(super) struct Added {
    /// Primitives that got tangents.
    pub primitives: u64,
    /// Vertices that were added.
    pub vertices: u64,
}

/// Accessors with the names of what they hold.
type Named = Vec<(String, u32)>;

/// Primitives over the same vertices.
#[derive(Default)]
struct Group {
    /// Of attributes, as the tree has them.
    attributes: Named,
    /// Of morph targets.
    targets: Vec<Named>,
    /// Numbers of meshes and of primitives in them.
    members: Vec<(usize, usize)>,
    /// Which members need tangents, and how they are made.
    wanting: Vec<(usize, Job)>,
    /// Whether extensions that are not known may count on the vertices.
    strangers: bool,
}

/// The tangents of a group.
struct Made {
    splitter: Splitter,
    /// Per member that got tangents: its corners, if some of them have copied vertices.
    members: Vec<(usize, Option<Vec<u32>>)>,
}

/// Adds tangents wherever they are missing.
pub(super) fn add(
    out: &mut Arrays<'_, '_>,
    accessors: Accessors<'_>,
    occlusion: bool,
    budget: &mut Budget,
    notes: &mut Vec<String>,
) -> Result<Added, Fault> {
    let spaces = spaces(accessors.doc, occlusion);
    if spaces.iter().all(Option::is_none) {
        return Ok(Added::default());
    }
    let groups = groups(&out.tree, accessors.doc, &spaces);
    for g in &groups {
        g.book(accessors, budget)?;
    }
    let made: Vec<Option<Made>> = groups.par_iter().map(|g| g.make(accessors)).collect();
    let mut added = Added::default();
    for (g, made) in groups.iter().zip(made) {
        if g.wanting.is_empty() {
            continue;
        }
        let written = match made.filter(|m| !m.members.is_empty()) {
            Some(made) => g.write(made, out, accessors, budget)?,
            None => None,
        };
        let Some(a) = written else {
            notes.push(format!("{}: no tangents could be added", g.wanting[0].1.pointer));
            continue;
        };
        added.primitives += a.primitives;
        added.vertices += a.vertices;
    }
    Ok(added)
}

/// Along what each material of the document needs tangents.
fn spaces(doc: &Document<'_>, occlusion: bool) -> Vec<Option<TangentSpace>> {
    let mut textures = Textures::new(doc);
    // The import has told of them.
    let mut warnings = Warnings::default();
    let space = |(i, m)| {
        let made = material::convert(i, m, &mut textures, occlusion, &mut warnings).ok()?;
        tangent_space(&made)
    };
    (0..).zip(&doc.materials).map(space).collect()
}

/// The primitives of the document by their vertices, in the order of the first of each.
fn groups(tree: &Tree<'_>, doc: &Document<'_>, spaces: &[Option<TangentSpace>]) -> Vec<Group> {
    let mut out: Vec<Group> = Vec::new();
    let mut by_vertices: HashMap<(Named, Vec<Named>), usize> = HashMap::new();
    let list = |t: &Tree<'_>| -> Named {
        t.entries().iter().filter_map(|(k, v)| Some((name(k), v.index()?))).collect()
    };
    for (m, mesh) in tree.list("meshes").iter().enumerate() {
        for (n, json) in mesh.list("primitives").iter().enumerate() {
            let Some(attributes) = json.get("attributes").map(list) else { continue };
            let targets: Vec<_> = json.list("targets").iter().map(list).collect();
            let number = *by_vertices.entry((attributes.clone(), targets.clone())).or_insert_with(|| {
                out.push(Group { attributes, targets, ..Group::default() });
                out.len() - 1
            });
            let g = &mut out[number];
            let p = &doc.meshes[m].primitives[n];
            if let Some(job) = job(p, spaces, format!("/meshes/{m}/primitives/{n}")) {
                g.wanting.push((g.members.len(), job));
            }
            g.members.push((m, n));
            g.strangers |= refs::has_unknown(json);
        }
    }
    out
}

/// How the mesh is built along which the tangents of `p` run; `None` if it needs none or there is nothing to make them from.
fn job(p: &Primitive<'_>, spaces: &[Option<TangentSpace>], pointer: String) -> Option<Job> {
    if matches!(p.mode, Mode::Points | Mode::Lines) || p.attribute("TANGENT").is_some() {
        return None;
    }
    let materials = p.material.into_iter().chain(p.mappings.iter().map(|m| m.material));
    let space = materials.filter_map(|m| *spaces.get(m as usize)?).next()?;
    let set = space.uv_set as usize;
    let coordinates = p.attribute(&format!("TEXCOORD_{set}")).filter(|_| set <= LAST_SET)?;
    let mut uvs = vec![None; set];
    uvs.push(Some(coordinates));
    let key = MeshKey {
        mode: p.mode,
        indices: p.indices,
        position: p.attribute("POSITION")?,
        normal: Some(p.attribute("NORMAL")?),
        tangent: None,
        color: None,
        uvs,
        tangent_space: Some(space),
        morph: Vec::new(),
        skin: None,
    };
    Some(Job { key, name: String::new(), pointer })
}

/// The last set of texture coordinates that an import looks at.
const LAST_SET: usize = 15;

impl Group {
    /// The accessor of an attribute whose data can be read: that of what was decoded, if it was compressed.
    fn readable(&self, doc: &Document<'_>, name: &str, accessor: u32) -> u32 {
        let (m, n) = self.members[0];
        doc.meshes[m].primitives[n].attribute(name).unwrap_or(accessor)
    }

    /// Every accessor of the vertices once: its number in the tree, the one to read, and in how many places it stands.
    fn accessors(&self, doc: &Document<'_>) -> Vec<(u32, u32, u32)> {
        let mut out: Vec<(u32, u32, u32)> = Vec::new();
        let mut at = HashMap::new();
        let attributes = self.attributes.iter().map(|(n, a)| (*a, self.readable(doc, n, *a)));
        let targets = self.targets.iter().flatten().map(|(_, a)| (*a, *a));
        for (there, read) in attributes.chain(targets) {
            let k = *at.entry(there).or_insert_with(|| {
                out.push((there, read, 0));
                out.len() - 1
            });
            out[k].2 += self.members.len() as u32;
        }
        out
    }

    /// Books what making the tangents takes.
    fn book(&self, accessors: Accessors<'_>, budget: &mut Budget) -> Result<(), Fault> {
        let Some((_, first)) = self.wanting.first() else { return Ok(()) };
        // Tangents, once as numbers and once as bytes, and normals of what no triangle uses.
        let count = accessors.doc.accessors.get(first.key.position as usize).map_or(0, |a| a.count);
        budget.vertices(count, count.saturating_mul(48), || first.pointer.clone())?;
        for (_, job) in &self.wanting {
            // What is wrong with it was said when it was imported, or nothing shows it.
            if let Ok(estimate) = job.estimate(accessors) {
                budget.bytes(estimate.bytes, || job.pointer.clone())?;
            }
        }
        Ok(())
    }

    /// The tangents of the members that want some; `None` if the vertices contradict themselves.
    fn make(&self, accessors: Accessors<'_>) -> Option<Made> {
        let first = &self.wanting.first()?.1;
        let open = |a: u32| accessors.open(a, "an attribute", ANY, String::new).ok();
        let count = open(first.key.position)?.len();
        if self.accessors(accessors.doc).iter().any(|a| open(a.1).is_none_or(|e| e.len() != count)) {
            return None;
        }
        let mut made = Made { splitter: Splitter::new(count), members: Vec::new() };
        // Several meshes may share a primitive.
        let mut done: HashMap<&MeshKey, Option<Vec<u32>>> = HashMap::new();
        for (member, job) in &self.wanting {
            if let Some(known) = done.get(&job.key) {
                made.members.push((*member, known.clone()));
                continue;
            }
            let Some(corners) = corners(job, accessors, &mut made.splitter) else { continue };
            let copied = corners.iter().any(|&i| i as usize >= count).then_some(corners);
            done.insert(&job.key, copied.clone());
            made.members.push((*member, copied));
        }
        self.fill_up(&mut made.splitter, count, accessors)?;
        Some(made)
    }

    /// Vertices that none of the members use get some unit vector.
    fn fill_up(&self, splitter: &mut Splitter, count: usize, accessors: Accessors<'_>) -> Option<()> {
        let rest: Vec<u32> = (0..count as u32).filter(|&v| splitter.tangents[v as usize].is_nan()).collect();
        let normal = self.wanting.first()?.1.key.normal?;
        let normals = accessors.open(normal, "NORMAL", &[Shape::Vec3], String::new).ok()?;
        for (&v, n) in rest.iter().zip(normals.floats::<3>(Some(&rest))) {
            let n = Vec3::from_array(n).try_normalize().unwrap_or(Vec3::Z);
            splitter.tangents[v as usize] = n.any_orthonormal_vector().extend(1.0);
        }
        Some(())
    }

    /// Writes the tangents, and the vertices that were split; `None` if they had to be and must not.
    fn write(
        &self,
        made: Made,
        out: &mut Arrays<'_, '_>,
        accessors: Accessors<'_>,
        budget: &mut Budget,
    ) -> Result<Option<Added>, Fault> {
        let (tangents, copied) = (made.splitter.tangents, made.splitter.copied);
        if !copied.is_empty() && self.strangers {
            return Ok(None);
        }
        let mut moved = HashMap::new();
        if !copied.is_empty() {
            let pointer = || self.wanting[0].1.pointer.clone();
            for (there, read, refs) in self.accessors(accessors.doc) {
                let e = accessors.open(read, "an attribute", ANY, pointer)?;
                let size = e.shape().size(e.component()).next_multiple_of(4);
                budget.bytes(size.saturating_mul((e.len() + copied.len()) as u64), pointer)?;
                let new = out.replace(there, refs, vertices(&e, Some(&copied)));
                moved.insert(there, new);
            }
        }
        let list = Elements {
            bytes: tangents.iter().flat_map(|t| t.to_array()).flat_map(f32::to_le_bytes).collect(),
            component: Component::F32,
            components: 4,
            count: tangents.len(),
            purpose: Purpose::Vertices { stride: 16, size: 16 },
        };
        let tangent = out.add("VEC4", made.members.len() as u32, list);
        let indices = self.indices(&made.members, tangents.len() - copied.len(), out);
        let named: HashSet<usize> = made.members.iter().map(|&(k, _)| k).collect();
        for (k, &(m, n)) in self.members.iter().enumerate() {
            let Some(json) = out.tree.list_mut("meshes")[m].list_mut("primitives").get_mut(n) else {
                continue;
            };
            for (name, a) in &self.attributes {
                if let Some(&new) = moved.get(a) {
                    set_entry(json, "attributes", name, new);
                }
            }
            for (t, target) in json.list_mut("targets").iter_mut().zip(&self.targets) {
                for (name, a) in target {
                    if let (Some(&new), Some(v)) = (moved.get(a), t.get_mut(name)) {
                        *v = Tree::number(new.into());
                    }
                }
            }
            if let (true, Some(attributes)) = (named.contains(&k), json.get_mut("attributes")) {
                attributes.set("TANGENT", Tree::number(tangent.into()));
            }
            if let Some(&(number, as_list)) = indices.get(&k) {
                json.set("indices", Tree::number(number.into()));
                if as_list && json.get("mode").and_then(Tree::index).is_some_and(|m| m != 4) {
                    json.remove("mode");
                }
            }
        }
        Ok(Some(Added { primitives: made.members.len() as u64, vertices: copied.len() as u64 }))
    }

    /// Which members get other indices, and whether these make a list of triangles: those with split vertices, and, as there are
    /// more vertices now, those without indices.
    fn indices(
        &self,
        members: &[(usize, Option<Vec<u32>>)],
        count: usize,
        out: &mut Arrays<'_, '_>,
    ) -> HashMap<usize, (u32, bool)> {
        let split: HashMap<usize, &Vec<u32>> =
            members.iter().filter_map(|(k, corners)| Some((*k, corners.as_ref()?))).collect();
        let mut out_of = HashMap::new();
        if split.is_empty() {
            return out_of;
        }
        // Members by the indices that they have and the corners that they get.
        type Change<'c> = (Option<u32>, Option<&'c Vec<u32>>);
        let mut changes: Vec<(Change<'_>, Vec<usize>)> = Vec::new();
        let mut at: HashMap<Change<'_>, usize> = HashMap::new();
        for (k, &(m, n)) in self.members.iter().enumerate() {
            let json = &out.tree.list("meshes")[m].list("primitives")[n];
            let old = json.get("indices").and_then(Tree::index);
            let corners = split.get(&k).copied();
            if old.is_some() && corners.is_none() {
                continue;
            }
            let place = *at.entry((old, corners)).or_insert_with(|| {
                changes.push(((old, corners), Vec::new()));
                changes.len() - 1
            });
            changes[place].1.push(k);
        }
        let every: Vec<u32> = (0..count as u32).collect();
        for ((old, corners), who) in changes {
            let described = old.and_then(|a| out.tree.list("accessors").get(a as usize));
            let component = match described.and_then(|a| a.get("componentType")?.index()) {
                Some(5121) => Component::U8,
                Some(5125) => Component::U32,
                _ => Component::U16,
            };
            let list = Elements::indices(corners.unwrap_or(&every), component);
            let refs = who.len() as u32;
            let number = match old {
                Some(a) => out.replace(a, refs, list),
                None => out.add("SCALAR", refs, list),
            };
            out_of.extend(who.into_iter().map(|k| (k, (number, corners.is_some()))));
        }
        out_of
    }
}

/// The corners of a primitive's triangles, each with a vertex that has its tangent; `None` if there are none, or broken ones.
fn corners(job: &Job, accessors: Accessors<'_>, splitter: &mut Splitter) -> Option<Vec<u32>> {
    // The import has told of what is odd.
    let mut warnings = Warnings::default();
    let mut key = job.key.clone();
    let space = key.tangent_space.take()?;
    let plain = Job { key, name: String::new(), pointer: job.pointer.clone() };
    let triangles = plain.triangles(accessors, &mut warnings).ok()?;
    let mesh = plain.build(accessors, None, &mut warnings).ok()?;
    let set = mesh.uvs.len().checked_sub(1)?;
    // Triangles whose corners are nowhere are left out of the mesh; their file is not worth guessing at.
    if triangles.is_empty() || mesh.indices.len() != triangles.len() || mesh.normals.is_empty() {
        return None;
    }
    let tangents = of_corners(&mesh, set, &space.transform());
    let corners = triangles.as_flattened().iter().zip(&tangents);
    Some(corners.map(|(&v, &t)| splitter.corner(v, t)).collect())
}
