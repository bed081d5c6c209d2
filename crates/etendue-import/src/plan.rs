//! What the visible nodes show: which meshes have to be built, and where they stand.

use crate::accessor::{Accessors, Elements};
use crate::animation::Pose;
use crate::changed::Changed;
use crate::document::{Component, Node, Primitive, Shape, get};
use crate::error::Fault;
use crate::geometry::{Job, MeshKey, SkinKey, TangentSpace};
use crate::ies;
use crate::limits::Budget;
use crate::material;
use crate::nodes::rotation;
use crate::place;
use crate::skin::narrow;
use crate::texture::Textures;
use crate::warning::Warnings;
use etendue_scene::{Camera, Instance, Light, Material, TextureRef, Variant};
use glam::{Affine2, Affine3A, DAffine3, DVec3};
use std::collections::{BTreeSet, HashMap};

/// More UV sets than any exporter writes.
const MAX_UV_SETS: u32 = 16;

/// The scene before its meshes are built and its images decoded.
pub(crate) struct Plan<'a> {
    accessors: Accessors<'a>,
    pose: &'a Pose,
    changed: &'a Changed<'a>,
    globals: &'a [DAffine3],
    occlusion: bool,
    pub jobs: Vec<Job>,
    by_key: HashMap<MeshKey, u32>,
    /// `Instance::mesh` is the number of a job.
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    by_material: HashMap<u32, u32>,
    /// The unlit form of each material that has one.
    by_lit: HashMap<Option<u32>, u32>,
    pub variants: Vec<Variant>,
    pub textures: Textures<'a>,
    pub lights: Vec<Light>,
    pub ies: ies::Loaded,
    /// With the camera's number in the file.
    pub cameras: Vec<(u32, Camera)>,
    pub budget: Budget,
    pub warnings: Warnings,
}

impl<'a> Plan<'a> {
    pub fn new(
        accessors: Accessors<'a>,
        pose: &'a Pose,
        changed: &'a Changed<'a>,
        globals: &'a [DAffine3],
        occlusion: bool,
        budget: Budget,
        warnings: Warnings,
    ) -> Self {
        Self {
            accessors,
            pose,
            changed,
            globals,
            occlusion,
            jobs: Vec::new(),
            by_key: HashMap::new(),
            instances: Vec::new(),
            materials: Vec::new(),
            by_material: HashMap::new(),
            by_lit: HashMap::new(),
            variants: accessors
                .doc
                .variants
                .iter()
                .map(|&n| Variant { name: n.to_owned(), materials: Vec::new() })
                .collect(),
            textures: Textures::new(accessors.doc),
            lights: Vec::new(),
            ies: ies::Loaded::default(),
            cameras: Vec::new(),
            budget,
            warnings,
        }
    }

    /// Adds what stands at node `i`; if it is `hidden`, only a camera, which visibility does not affect.
    pub fn node(&mut self, i: u32, hidden: bool) -> Result<(), Fault> {
        let doc = self.accessors.doc;
        let node = &doc.nodes[i as usize];
        let m = &self.globals[i as usize];
        if let Some(c) = node.camera {
            let camera = get(&doc.cameras, c, "camera", || format!("/nodes/{i}/camera"))?;
            let camera = self.changed.cameras.get(&c).unwrap_or(camera);
            self.budget.bytes(camera.name.len() as u64, || format!("/nodes/{i}/camera"))?;
            let made = place::camera(camera, &format!("/cameras/{c}"), node.name, m, &mut self.warnings);
            self.cameras.extend(made.map(|camera| (c, camera)));
        }
        if hidden {
            return Ok(());
        }
        if let Some(l) = node.light {
            let from = || format!("/nodes/{i}/extensions/KHR_lights_punctual/light");
            let light = get(&doc.lights, l, "light", from)?;
            let light = self.changed.lights.get(&l).unwrap_or(light);
            self.budget.bytes(light.name.len() as u64, from)?;
            let pointer = format!("/extensions/KHR_lights_punctual/lights/{l}");
            self.lights.extend(place::light(light, &pointer, node.name, m, &mut self.warnings));
        }
        if let Some(l) = &node.ies {
            let pointer = format!("/nodes/{i}/extensions/EXT_lights_ies");
            self.budget.bytes(node.name.len() as u64, || pointer.clone())?;
            self.lights.extend(ies::light(l, &self.ies, &pointer, node, m, &mut self.warnings)?);
        }
        if let Some(mesh) = node.mesh {
            self.mesh(i, node, mesh)?;
        }
        Ok(())
    }

    fn mesh(&mut self, i: u32, node: &Node<'a>, index: u32) -> Result<(), Fault> {
        let doc = self.accessors.doc;
        let mesh = get(&doc.meshes, index, "mesh", || format!("/nodes/{i}/mesh"))?;
        let weights = self.pose.weights(doc, i, index);
        let placements = self.placements(i, node)?;
        for (n, p) in mesh.primitives.iter().enumerate() {
            let pointer = format!("/meshes/{index}/primitives/{n}");
            let material = match p.material {
                Some(m) => Some(self.material(m, || format!("{pointer}/material"))?),
                None => None,
            };
            let mut others = self.other_materials(p, &pointer)?;
            let material = if p.mode.is_stroke() && p.attribute("NORMAL").is_none() {
                others.iter_mut().for_each(|(_, m)| *m = self.unlit(Some(*m)));
                Some(self.unlit(material))
            } else {
                material
            };
            let name = if node.name.is_empty() { mesh.name } else { node.name };
            // Also what turns out to be nothing to see costs time.
            let at = || format!("/nodes/{i}");
            let bytes = (size_of::<Instance>() + name.len() + size_of_val(&others[..])) as u64;
            self.budget.instances(
                placements.len() as u64,
                bytes.saturating_mul(placements.len().max(1) as u64),
                at,
            )?;
            let Some((job, skinned)) =
                self.job(i, node, mesh.name, p, pointer, material, &others, weights)?
            else {
                continue;
            };
            let here = [Affine3A::IDENTITY];
            // A skin carries its vertices to the world by itself (glTF 2.0, 3.7.3.1).
            let placements = if skinned { &here[..] } else { &placements[..] };
            for &transform in placements {
                if transform.is_finite() {
                    let number = self.instances.len() as u32;
                    for &(variant, material) in &others {
                        self.variants[variant as usize].materials.push([number, material]);
                    }
                    self.instances.push(Instance { name: name.to_owned(), mesh: job, material, transform });
                } else {
                    self.warnings.add(at(), "the transform is not finite; left out");
                }
            }
        }
        Ok(())
    }

    /// Where the meshes of node `i` stand: once, or as often as `EXT_mesh_gpu_instancing` says.
    fn placements(&mut self, i: u32, node: &Node<'a>) -> Result<Vec<Affine3A>, Fault> {
        let global = &self.globals[i as usize];
        let Some(attributes) = &node.instancing else { return Ok(vec![narrow(global)]) };
        let pointer = format!("/nodes/{i}/extensions/EXT_mesh_gpu_instancing/attributes");
        let (mut t, mut q, mut s) = (None, None, None);
        let mut count = None;
        for &(name, accessor) in attributes {
            let from = || format!("{pointer}/{name}");
            let (slot, shape) = match name {
                "TRANSLATION" => (&mut t, Shape::Vec3),
                "ROTATION" => (&mut q, Shape::Vec4),
                "SCALE" => (&mut s, Shape::Vec3),
                // Custom attributes, allowed and meaningless here.
                _ => continue,
            };
            let e = self.accessors.open(accessor, name, &[shape], from)?;
            if *count.get_or_insert(e.len()) != e.len() {
                return Err(Fault::invalid(from(), "the instancing attributes differ in length"));
            }
            *slot = Some(e);
        }
        let count = count.unwrap_or(0);
        self.budget.bytes(count as u64 * size_of::<Affine3A>() as u64 * 2, || pointer.clone())?;
        let read3 = |e: Option<Elements<'_>>, default: f32| -> Vec<[f32; 3]> {
            e.map_or_else(|| vec![[default; 3]; count], |e| e.floats(None))
        };
        let (t, s) = (read3(t, 0.0), read3(s, 1.0));
        let q: Vec<[f32; 4]> =
            q.map_or_else(|| vec![[0.0, 0.0, 0.0, 1.0]; count], |e: Elements<'_>| e.floats(None));
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        Ok((0..count)
            .map(|k| {
                let q = rotation(q[k].map(f64::from), || {
                    self.warnings
                        .add(format!("{pointer}/ROTATION"), "a quaternion is not of unit length; normalised");
                });
                narrow(&(*global * DAffine3::from_scale_rotation_translation(wide(s[k]), q, wide(t[k]))))
            })
            .collect())
    }

    /// The scene's number of the file's material `index`.
    fn material(&mut self, index: u32, from: impl Fn() -> String) -> Result<u32, Fault> {
        if let Some(&known) = self.by_material.get(&index) {
            return Ok(known);
        }
        let m = get(&self.accessors.doc.materials, index, "material", from)?;
        let m = self.changed.materials.get(&index).unwrap_or(m);
        let made = material::convert(index, m, &mut self.textures, self.occlusion, &mut self.warnings)?;
        let number = self.materials.len() as u32;
        self.materials.push(made);
        self.by_material.insert(index, number);
        Ok(number)
    }

    /// The scene's number of a material (none: the default one) as it is for points and lines that have no normals: unlit (glTF 2.0,
    /// 3.9.7).
    fn unlit(&mut self, number: Option<u32>) -> u32 {
        if let Some(&known) = self.by_lit.get(&number) {
            return known;
        }
        let m = number.map_or_else(Material::default, |n| self.materials[n as usize].clone());
        let unlit = self.materials.len() as u32;
        self.materials.push(Material { unlit: true, extensions: None, normal_texture: None, ..m });
        self.by_lit.insert(number, unlit);
        unlit
    }

    /// The variants in which primitive `p` has a material of their own, each with the scene's number of it.
    fn other_materials(&mut self, p: &Primitive<'_>, pointer: &str) -> Result<Vec<(u32, u32)>, Fault> {
        let doc = self.accessors.doc;
        let mut out = Vec::with_capacity(p.mappings.len());
        for m in &p.mappings {
            let at = || format!("{pointer}/extensions/KHR_materials_variants/mappings/{}", m.entry);
            if m.variant as usize >= self.variants.len() {
                self.warnings
                    .add(format!("{}/variants", at()), "refers to a variant that does not exist; ignored");
            } else if m.material as usize >= doc.materials.len() {
                self.warnings
                    .add(format!("{}/material", at()), "refers to a material that does not exist; ignored");
            } else {
                out.push((m.variant, self.material(m.material, at)?));
            }
        }
        Ok(out)
    }

    /// The job that builds primitive `p` on node `i`, and whether a skin carries it; `None` if there is nothing to see.
    fn job(
        &mut self,
        i: u32,
        node: &Node<'a>,
        name: &str,
        p: &Primitive<'_>,
        pointer: String,
        material: Option<u32>,
        others: &[(u32, u32)],
        weights: &[f64],
    ) -> Result<Option<(u32, bool)>, Fault> {
        let Some(position) = p.attribute("POSITION") else {
            self.warnings.add(format!("{pointer}/attributes"), "no POSITION; nothing to show");
            return Ok(None);
        };
        let (uvs, tangent_space, wants_tangents) = self.texture_space(p, material, others, &pointer);
        let normal = p.attribute("NORMAL");
        // Along strokes nothing can be bent.
        let tangent_space = tangent_space.filter(|_| !p.mode.is_stroke());
        let wants_tangents = wants_tangents && !p.mode.is_stroke();
        let tangent = p.attribute("TANGENT").filter(|_| wants_tangents && normal.is_some());
        let skin = self.skin(i, node, p, &pointer)?;
        let key = MeshKey {
            mode: p.mode,
            indices: p.indices,
            position,
            normal,
            tangent,
            color: p.attribute("COLOR_0"),
            uvs,
            tangent_space: tangent_space.filter(|_| tangent.is_none()),
            morph: self.morph(p, weights, &pointer),
            skin,
        };
        let skinned = key.skin.is_some();
        if let Some(&known) = self.by_key.get(&key) {
            return Ok(Some((known, skinned)));
        }
        let from = || format!("{pointer}/attributes/POSITION");
        let positions = self.accessors.open(position, "POSITION", &[Shape::Vec3], from)?;
        if positions.component() == Component::U32 {
            return Err(Fault::invalid(from(), "positions of unsigned 32-bit integers are not allowed"));
        }
        let job = Job { key: key.clone(), name: name.to_owned(), pointer };
        let estimate = job.estimate(self.accessors)?;
        let bytes = estimate.bytes.saturating_add(name.len() as u64);
        self.budget.vertices(estimate.vertices, bytes, || job.pointer.clone())?;
        let number = self.jobs.len() as u32;
        self.jobs.push(job);
        self.by_key.insert(key, number);
        Ok(Some((number, skinned)))
    }

    /// The UV sets that a primitive needs for its materials, for which texture coordinates tangents have to be generated
    /// if the file has none, and whether any are needed. `others` are its materials in variants: one mesh serves all.
    fn texture_space(
        &mut self,
        p: &Primitive<'_>,
        material: Option<u32>,
        others: &[(u32, u32)],
        pointer: &str,
    ) -> (Vec<Option<u32>>, Option<TangentSpace>, bool) {
        // The same few materials may stand in many variants.
        let mut numbers: Vec<u32> = others.iter().map(|&(_, m)| m).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.retain(|&m| Some(m) != material);
        let numbers = material.into_iter().chain(numbers);
        let materials: Vec<&Material> = numbers.map(|m| &self.materials[m as usize]).collect();

        let sets: BTreeSet<u32> =
            materials.iter().flat_map(|m| m.textures()).map(|t: &TextureRef| t.uv_set).collect();
        let highest = sets.last().map_or(0, |&s| s.min(MAX_UV_SETS - 1));
        let mut uvs: Vec<Option<u32>> = (0..=highest)
            .map(|set| {
                let wanted = set == 0 || sets.contains(&set);
                if wanted { p.attribute(&format!("TEXCOORD_{set}")) } else { None }
            })
            .collect();
        while uvs.last() == Some(&None) {
            uvs.pop();
        }
        let missing = sets.iter().find(|&&s| uvs.get(s as usize).is_none_or(Option::is_none));
        if let Some(set) = missing {
            self.warnings.add(
                // The place is the first of possibly many; the message is shared by them.
                "/meshes",
                format!("a material uses texture coordinate set {set} that its mesh does not have; looked up at 0, 0"),
            );
        }
        let mut spaces = materials.iter().filter_map(|m| tangent_space(m));
        let space = spaces.next();
        let has_own = p.attribute("TANGENT").is_some() && p.attribute("NORMAL").is_some();
        if !has_own && spaces.any(|s| Some(s) != space) {
            self.warnings.add(
                pointer,
                "materials of different variants need different tangents; they run along the first one's texture coordinates",
            );
        }
        (uvs, space, space.is_some())
    }

    /// The targets of `p` with weights other than zero.
    fn morph(
        &mut self,
        p: &Primitive<'_>,
        weights: &[f64],
        pointer: &str,
    ) -> Vec<(crate::document::Target, u32)> {
        let mut out = Vec::new();
        for (target, &w) in p.targets.iter().zip(weights) {
            let w = w as f32;
            if !w.is_finite() {
                self.warnings.add(pointer, "a morph weight is not finite; taken as 0");
            } else if w != 0.0 {
                out.push((*target, w.to_bits()));
            }
        }
        out
    }

    fn skin(
        &mut self,
        i: u32,
        node: &Node<'a>,
        p: &Primitive<'_>,
        pointer: &str,
    ) -> Result<Option<SkinKey>, Fault> {
        let Some(skin) = node.skin else { return Ok(None) };
        let s = get(&self.accessors.doc.skins, skin, "skin", || format!("/nodes/{i}/skin"))?;
        let influences: Vec<(u32, u32)> = (0..p.attributes.len())
            .map_while(|n| {
                Some((p.attribute(&format!("JOINTS_{n}"))?, p.attribute(&format!("WEIGHTS_{n}"))?))
            })
            .collect();
        if influences.is_empty() || s.joints.is_empty() {
            let why = "the node has a skin, but its mesh has no joints and weights; placed by its node";
            self.warnings.add(pointer, why);
            return Ok(None);
        }
        if node.instancing.is_some() {
            self.warnings
                .add(pointer, "EXT_mesh_gpu_instancing of a skinned mesh is not supported; shown once");
        }
        Ok(Some(SkinKey { skin, influences }))
    }
}

/// Along what tangents have to run for a material; `None` if it needs none. Normal texture, coat's normal texture and
/// anisotropy share one tangent space (glTF 2.0, 3.9.3; KHR_materials_clearcoat, KHR_materials_coat, KHR_materials_anisotropy): the first of
/// them that is there determines it.
pub(crate) fn tangent_space(m: &Material) -> Option<TangentSpace> {
    let extensions = m.extensions.as_deref();
    let coat = extensions.and_then(|e| e.clearcoat?.normal_texture);
    let along = |t: TextureRef| TangentSpace::new(t.uv_set, &t.transform);
    if let Some(n) = m.normal_texture.or(coat) {
        return Some(along(n.texture));
    }
    let brushed = extensions?.clearcoat.map(|c| c.anisotropy).filter(|a| a.strength > 0.0);
    let anisotropy = extensions?.anisotropy.or(brushed)?;
    Some(anisotropy.texture.map_or_else(|| TangentSpace::new(0, &Affine2::IDENTITY), along))
}
