//! Animations, evaluated at one moment (glTF 2.0, 3.11 and appendix C).

use crate::accessor::{Accessors, Elements};
use crate::changed::Changes;
use crate::document::{Animation, Channel, Document, Interpolation, Local, Path, Shape, get};
use crate::error::Fault;
use crate::keyframes::Track;
use crate::pointer::{Owner, Property, resolve};
use crate::uri::shorten;
use crate::warning::Warnings;
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// Which of a file's animations play.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AnimationChoice {
    /// The first.
    #[default]
    First,
    /// All at once; where two move the same thing the later one wins.
    All,
    /// By number, from 0.
    Index(u32),
    /// By name.
    Name(String),
}

/// The state of the hierarchy at one moment: what the file says, overwritten by what animations say.
#[derive(Default)]
pub(crate) struct Pose {
    locals: HashMap<u32, Local>,
    weights: HashMap<u32, Vec<f64>>,
    mesh_weights: HashMap<u32, Vec<f64>>,
    visible: HashMap<u32, bool>,
    /// Values of materials, cameras and lights.
    pub changes: Changes,
}

impl Pose {
    /// The local transform of node `i`.
    pub fn local(&self, doc: &Document<'_>, i: u32) -> Local {
        let rest = || doc.nodes[i as usize].local.as_deref().copied().unwrap_or(Local::IDENTITY);
        self.locals.get(&i).copied().unwrap_or_else(rest)
    }

    /// The morph weights of node `i`: its own, or else those of its `mesh`.
    pub fn weights<'a>(&'a self, doc: &'a Document<'_>, i: u32, mesh: u32) -> &'a [f64] {
        let rest = || doc.nodes[i as usize].weights.as_deref();
        let own = self.weights.get(&i).map(Vec::as_slice).or_else(rest);
        own.or_else(|| self.mesh_weights.get(&mesh).map(Vec::as_slice))
            .unwrap_or_else(|| doc.meshes.get(mesh as usize).map_or(&[], |m| &m.weights))
    }

    /// Whether node `i` is shown, as far as it is concerned itself.
    pub fn visible(&self, doc: &Document<'_>, i: u32) -> bool {
        self.visible.get(&i).copied().unwrap_or(doc.nodes[i as usize].visible)
    }

    /// The pose at `seconds` of the chosen animations.
    pub fn at(
        seconds: f64,
        choice: &AnimationChoice,
        accessors: Accessors<'_>,
        warnings: &mut Warnings,
    ) -> Result<Self, Fault> {
        let doc = accessors.doc;
        let mut pose = Self::default();
        let chosen = choose(doc, choice)?;
        if chosen.is_empty() {
            warnings.add("", "the file has no animation; shown at rest");
        }
        for (n, animation) in chosen {
            for (k, channel) in animation.channels.iter().enumerate() {
                let place = format!("/animations/{n}/channels/{k}");
                let Some(property) = property(doc, channel, &place, warnings)? else { continue };
                let keys =
                    get(&animation.samplers, channel.sampler, "sampler", || format!("{place}/sampler"))?;
                let at = || format!("/animations/{n}/samplers/{}", channel.sampler);
                let input =
                    accessors.open(keys.input, "the keyframe time", &[Shape::Scalar], || at() + "/input")?;
                if input.len() == 0 {
                    warnings.add(at() + "/input", "an animation without keyframes; ignored");
                    continue;
                }
                let (mut interpolation, shape) = (keys.interpolation, shape_of(&property));
                if matches!(property, Property::Visible(_)) {
                    // There is nothing between yes and no.
                    interpolation = Interpolation::Step;
                }
                let track = Track { input: &input, seconds, interpolation };
                let output =
                    accessors.open(keys.output, "the keyframe value", &[shape], || at() + "/output")?;
                pose.apply(doc, property, &track, &output, &place, warnings)?;
            }
        }
        Ok(pose)
    }

    fn apply(
        &mut self,
        doc: &Document<'_>,
        property: Property<'_>,
        track: &Track<'_>,
        output: &Elements<'_>,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        match property {
            Property::Node(node, Path::Weights) => {
                let targets = doc.nodes[node as usize].mesh.map_or(0, |m| targets(doc, m));
                let weights = weights(track, output, targets, place, warnings)?;
                self.weights.extend(weights.map(|w| (node, w)));
            }
            Property::Node(node, path) => return self.place(doc, node, path, track, output, place, warnings),
            Property::NodeWeight(node, k) => {
                let mesh = doc.nodes[node as usize].mesh.unwrap_or(u32::MAX);
                let mut all = self.weights(doc, node, mesh).to_vec();
                if one_weight(&mut all, k, targets(doc, mesh), track, output, place, warnings)? {
                    self.weights.insert(node, all);
                }
            }
            Property::MeshWeights(mesh, None) => {
                let weights = weights(track, output, targets(doc, mesh), place, warnings)?;
                self.mesh_weights.extend(weights.map(|w| (mesh, w)));
            }
            Property::MeshWeights(mesh, Some(k)) => {
                let rest = || doc.meshes[mesh as usize].weights.clone();
                let mut all = self.mesh_weights.get(&mesh).cloned().unwrap_or_else(rest);
                if one_weight(&mut all, k, targets(doc, mesh), track, output, place, warnings)? {
                    self.mesh_weights.insert(mesh, all);
                }
            }
            Property::Visible(node) => {
                track.check(output.len(), 1, || place.to_owned())?;
                let [v] = track.sample::<1>(|k| output.floats(Some(&[k as u32]))[0]);
                self.visible.insert(node, v != 0.0);
            }
            Property::Value(owner, path, count) => {
                track.check(output.len(), 1, || place.to_owned())?;
                let value = match count {
                    // A quaternion, as a node's rotation is.
                    4 if matches!(owner, Owner::Sky(_)) => {
                        track.rotation(|k| output.floats(Some(&[k as u32]))[0]).to_array().to_vec()
                    }
                    1 => track.sample::<1>(|k| output.floats(Some(&[k as u32]))[0]).to_vec(),
                    2 => track.sample::<2>(|k| output.floats(Some(&[k as u32]))[0]).to_vec(),
                    3 => track.sample::<3>(|k| output.floats(Some(&[k as u32]))[0]).to_vec(),
                    _ => track.sample::<4>(|k| output.floats(Some(&[k as u32]))[0]).to_vec(),
                };
                if value.iter().all(|v| v.is_finite()) {
                    self.changes.add(owner, &path, value);
                } else {
                    not_finite(place, warnings);
                }
            }
        }
        Ok(())
    }

    /// Translation, rotation or scale of a node.
    fn place(
        &mut self,
        doc: &Document<'_>,
        node: u32,
        path: Path,
        track: &Track<'_>,
        output: &Elements<'_>,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        track.check(output.len(), 1, || place.to_owned())?;
        let Local::Trs(mut t, mut q, mut s) = self.local(doc, node) else {
            warnings.add(place, "animates a node that is placed by a matrix, which glTF forbids; ignored");
            return Ok(());
        };
        match path {
            Path::Translation => t = track.sample(|k| output.floats(Some(&[k as u32]))[0]),
            Path::Scale => s = track.sample(|k| output.floats(Some(&[k as u32]))[0]),
            Path::Rotation => q = track.rotation(|k| output.floats(Some(&[k as u32]))[0]).to_array(),
            Path::Weights => {}
        }
        if t.iter().chain(&q).chain(&s).all(|v| v.is_finite()) {
            self.locals.insert(node, Local::Trs(t, q, s));
        } else {
            not_finite(place, warnings);
        }
        Ok(())
    }
}

fn not_finite(place: &str, warnings: &mut Warnings) {
    warnings.add(place, "the animation gives values that are not finite; ignored");
}

/// What a channel moves, if it is known and there; else a warning says what is not, or nothing where that has been said.
fn property<'v>(
    doc: &Document<'_>,
    channel: &Channel<'v>,
    place: &str,
    warnings: &mut Warnings,
) -> Result<Option<Property<'v>>, Fault> {
    if let (Some(node), Some(path)) = (channel.node, channel.path) {
        get(&doc.nodes, node, "node", || format!("{place}/target/node"))?;
        return Ok(Some(Property::Node(node, path)));
    }
    let Some(pointer) = channel.pointer else { return Ok(None) };
    let Some(property) = resolve(pointer) else {
        let what = format!("animates `{}`, which is no property that is known; ignored", shorten(pointer));
        warnings.add(place, what);
        return Ok(None);
    };
    let there = match property {
        Property::Node(i, _) | Property::NodeWeight(i, _) | Property::Visible(i) => {
            (i as usize) < doc.nodes.len()
        }
        Property::MeshWeights(i, _) => (i as usize) < doc.meshes.len(),
        Property::Value(Owner::Material(i), ..) => (i as usize) < doc.materials.len(),
        Property::Value(Owner::Camera(i), ..) => (i as usize) < doc.cameras.len(),
        Property::Value(Owner::Light(i), ..) => (i as usize) < doc.lights.len(),
        Property::Value(Owner::Sky(i), ..) => (i as usize) < doc.image_lights.len(),
    };
    if !there {
        let what = format!("animates `{}`, which is not in the file; ignored", shorten(pointer));
        warnings.add(place, what);
    }
    Ok(there.then_some(property))
}

/// The shape of a property's keyframe values.
fn shape_of(property: &Property<'_>) -> Shape {
    match property {
        Property::Node(_, Path::Translation | Path::Scale) | Property::Value(_, _, 3) => Shape::Vec3,
        Property::Node(_, Path::Rotation) | Property::Value(_, _, 4) => Shape::Vec4,
        Property::Value(_, _, 2) => Shape::Vec2,
        _ => Shape::Scalar,
    }
}

/// Morph targets of a mesh.
fn targets(doc: &Document<'_>, mesh: u32) -> usize {
    let first = doc.meshes.get(mesh as usize).and_then(|m| m.primitives.first());
    first.map_or(0, |p| p.targets.len())
}

/// The weights of all targets at the moment.
fn weights(
    track: &Track<'_>,
    output: &Elements<'_>,
    targets: usize,
    place: &str,
    warnings: &mut Warnings,
) -> Result<Option<Vec<f64>>, Fault> {
    if targets == 0 {
        warnings.add(place, "animates the morph weights of a node without morph targets; ignored");
        return Ok(None);
    }
    track.check(output.len(), targets, || place.to_owned())?;
    let w: Vec<f64> = (0..targets)
        .map(|t| {
            let [v] = track.sample::<1>(|k| output.floats(Some(&[(k * targets + t) as u32]))[0]);
            v
        })
        .collect();
    if w.iter().all(|v| v.is_finite()) {
        return Ok(Some(w));
    }
    not_finite(place, warnings);
    Ok(None)
}

/// Puts the weight of target `k` at the moment among `all` weights; false if it cannot be.
fn one_weight(
    all: &mut Vec<f64>,
    k: usize,
    targets: usize,
    track: &Track<'_>,
    output: &Elements<'_>,
    place: &str,
    warnings: &mut Warnings,
) -> Result<bool, Fault> {
    if k >= targets {
        warnings.add(place, format!("animates the weight of morph target {k} of {targets}; ignored"));
        return Ok(false);
    }
    track.check(output.len(), 1, || place.to_owned())?;
    let [v] = track.sample::<1>(|k| output.floats(Some(&[k as u32]))[0]);
    if !v.is_finite() {
        not_finite(place, warnings);
        return Ok(false);
    }
    all.resize(targets, 0.0);
    all[k] = v;
    Ok(true)
}

/// From the first keyframe of the chosen animations to the last, seconds; `None` if there are none.
pub(crate) fn duration(
    choice: &AnimationChoice,
    accessors: Accessors<'_>,
) -> Result<Option<RangeInclusive<f64>>, Fault> {
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for (n, animation) in choose(accessors.doc, choice)? {
        for (k, keys) in animation.samplers.iter().enumerate() {
            let at = || format!("/animations/{n}/samplers/{k}/input");
            let input = accessors.open(keys.input, "the keyframe time", &[Shape::Scalar], at)?;
            if input.len() > 0 {
                for [t] in input.floats::<1>(Some(&[0, input.len() as u32 - 1])) {
                    (first, last) = (first.min(t.into()), last.max(t.into()));
                }
            }
        }
    }
    Ok((first <= last && last.is_finite() && first.is_finite()).then_some(first..=last))
}

fn choose<'a>(
    doc: &'a Document<'_>,
    choice: &AnimationChoice,
) -> Result<Vec<(usize, &'a Animation<'a>)>, Fault> {
    let all = || doc.animations.iter().enumerate();
    let missing = |wanted: String| Fault::NoSuchAnimation {
        wanted,
        available: if doc.animations.is_empty() {
            "none".into()
        } else {
            let names: Vec<String> = all().take(32).map(|(i, a)| format!("{i} `{}`", a.name)).collect();
            names.join(", ")
        },
    };
    match choice {
        AnimationChoice::First => Ok(all().take(1).collect()),
        AnimationChoice::All => Ok(all().collect()),
        AnimationChoice::Index(i) => match doc.animations.get(*i as usize) {
            Some(a) => Ok(vec![(*i as usize, a)]),
            None => Err(missing(i.to_string())),
        },
        AnimationChoice::Name(name) => match all().find(|(_, a)| a.name == name) {
            Some(found) => Ok(vec![found]),
            None => Err(missing(format!("`{name}`"))),
        },
    }
}
