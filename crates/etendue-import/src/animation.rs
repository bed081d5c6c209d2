//! Animations, evaluated at one moment (glTF 2.0, 3.11 and appendix C).

use crate::accessor::{Accessors, Elements};
use crate::document::{Animation, Document, Interpolation, Local, Path, Shape, get};
use crate::error::Fault;
use crate::nodes::rotation;
use crate::warning::Warnings;
use glam::DQuat;
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
}

impl Pose {
    /// The local transform of node `i`.
    pub fn local(&self, doc: &Document<'_>, i: u32) -> Local {
        let rest = || doc.nodes[i as usize].local.as_deref().copied().unwrap_or(Local::IDENTITY);
        self.locals.get(&i).copied().unwrap_or_else(rest)
    }

    /// The morph weights of node `i`, if anything but its mesh gives them.
    pub fn weights<'a>(&'a self, doc: &'a Document<'_>, i: u32) -> Option<&'a [f64]> {
        let rest = || doc.nodes[i as usize].weights.as_deref();
        self.weights.get(&i).map(Vec::as_slice).or_else(rest)
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
                let pointer = || format!("/animations/{n}/channels/{k}");
                let (Some(node), Some(path)) = (channel.node, channel.path) else { continue };
                get(&doc.nodes, node, "node", || format!("{}/target/node", pointer()))?;
                let keys = get(&animation.samplers, channel.sampler, "sampler", || {
                    format!("{}/sampler", pointer())
                })?;
                let at = || format!("/animations/{n}/samplers/{}", channel.sampler);
                let input =
                    accessors.open(keys.input, "the keyframe time", &[Shape::Scalar], || at() + "/input")?;
                if input.len() == 0 {
                    warnings.add(at() + "/input", "an animation without keyframes; ignored");
                    continue;
                }
                let track = Track { input: &input, seconds, interpolation: keys.interpolation };
                let shape = match path {
                    Path::Translation | Path::Scale => Shape::Vec3,
                    Path::Rotation => Shape::Vec4,
                    Path::Weights => Shape::Scalar,
                };
                let output =
                    accessors.open(keys.output, "the keyframe value", &[shape], || at() + "/output")?;
                pose.apply(doc, node, path, &track, &output, pointer, warnings)?;
            }
        }
        Ok(pose)
    }

    fn apply(
        &mut self,
        doc: &Document<'_>,
        node: u32,
        path: Path,
        track: &Track<'_>,
        output: &Elements<'_>,
        pointer: impl Fn() -> String,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        let bad =
            |w: &mut Warnings| w.add(pointer(), "the animation gives values that are not finite; ignored");
        if path == Path::Weights {
            let mesh = doc.nodes[node as usize].mesh.and_then(|m| doc.meshes.get(m as usize));
            let targets = mesh.and_then(|m| m.primitives.first()).map_or(0, |p| p.targets.len());
            if targets == 0 {
                warnings
                    .add(pointer(), "animates the morph weights of a node without morph targets; ignored");
                return Ok(());
            }
            track.check(output.len(), targets, &pointer)?;
            let w: Vec<f64> = (0..targets)
                .map(|t| {
                    let [v] = track.sample::<1>(|k| output.floats(Some(&[(k * targets + t) as u32]))[0]);
                    v
                })
                .collect();
            if w.iter().all(|v| v.is_finite()) {
                self.weights.insert(node, w);
            } else {
                bad(warnings)
            }
            return Ok(());
        }
        track.check(output.len(), 1, &pointer)?;
        let Local::Trs(mut t, mut q, mut s) = self.local(doc, node) else {
            warnings
                .add(pointer(), "animates a node that is placed by a matrix, which glTF forbids; ignored");
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
            bad(warnings);
        }
        Ok(())
    }
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

/// Keyframe times and the moment that is looked for in them.
struct Track<'a> {
    input: &'a Elements<'a>,
    seconds: f64,
    interpolation: Interpolation,
}

/// Between which keyframes a moment lies.
struct Span {
    /// The keyframe before.
    k: usize,
    /// How far on the way to the next one, 0..1; 0 at the ends of the animation.
    t: f64,
    /// Seconds between the two.
    length: f64,
}

impl Track<'_> {
    /// Checks that there are as many values as keyframes need.
    fn check(&self, values: usize, per_key: usize, pointer: impl Fn() -> String) -> Result<(), Fault> {
        let per_key = if self.interpolation == Interpolation::CubicSpline { 3 * per_key } else { per_key };
        let needed = self.input.len().saturating_mul(per_key);
        if values < needed {
            let keys = self.input.len();
            return Err(Fault::invalid(
                format!("{}/sampler", pointer()),
                format!("{values} values for {keys} keyframes that need {needed}"),
            ));
        }
        Ok(())
    }

    fn time(&self, k: usize) -> f64 {
        let [t] = self.input.floats::<1>(Some(&[k as u32]))[0];
        t.into()
    }

    /// Finds the keyframes around the moment by bisection; outside their range the nearest one holds.
    fn span(&self) -> Span {
        let last = self.input.len() - 1;
        let hold = |k| Span { k, t: 0.0, length: 0.0 };
        let first = self.time(0);
        // A time that is not a number holds the first keyframe.
        if last == 0 || self.seconds.is_nan() || first.is_nan() || self.seconds <= first {
            return hold(0);
        }
        if self.seconds >= self.time(last) {
            return hold(last);
        }
        let (mut lo, mut hi) = (0, last);
        while hi - lo > 1 {
            let mid = lo + (hi - lo) / 2;
            if self.time(mid) <= self.seconds { lo = mid } else { hi = mid }
        }
        let (a, b) = (self.time(lo), self.time(hi));
        let length = b - a;
        let t = (self.seconds - a) / length;
        if length > 0.0 && (0.0..=1.0).contains(&t) { Span { k: lo, t, length } } else { hold(lo) }
    }

    /// The value at the moment; `value(k)` is output element `k`. In a cubic spline each keyframe has three: in-tangent,
    /// value, out-tangent (glTF 2.0, appendix C.5).
    fn sample<const N: usize>(&self, value: impl Fn(usize) -> [f32; N]) -> [f64; N] {
        let s = self.span();
        let wide = |v: [f32; N]| v.map(f64::from);
        match self.interpolation {
            Interpolation::Step => wide(value(s.k)),
            Interpolation::Linear if s.t == 0.0 => wide(value(s.k)),
            Interpolation::Linear => {
                let (a, b) = (wide(value(s.k)), wide(value(s.k + 1)));
                std::array::from_fn(|i| a[i] + (b[i] - a[i]) * s.t)
            }
            Interpolation::CubicSpline => self.cubic(&s, value),
        }
    }

    fn cubic<const N: usize>(&self, s: &Span, value: impl Fn(usize) -> [f32; N]) -> [f64; N] {
        let wide = |v: [f32; N]| v.map(f64::from);
        let v0 = wide(value(3 * s.k + 1));
        if s.t == 0.0 {
            return v0;
        }
        let out0 = wide(value(3 * s.k + 2));
        let (in1, v1) = (wide(value(3 * (s.k + 1))), wide(value(3 * (s.k + 1) + 1)));
        let (t, t2, t3) = (s.t, s.t * s.t, s.t * s.t * s.t);
        std::array::from_fn(|i| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * v0[i]
                + s.length * (t3 - 2.0 * t2 + t) * out0[i]
                + (-2.0 * t3 + 3.0 * t2) * v1[i]
                + s.length * (t3 - t2) * in1[i]
        })
    }

    /// [`Track::sample`] for unit quaternions: linear means along the shorter great arc (appendix C.4), and a spline is
    /// normalised afterwards (C.5).
    fn rotation(&self, value: impl Fn(usize) -> [f32; 4]) -> DQuat {
        let s = self.span();
        let unit = |v: [f64; 4]| {
            if v.iter().all(|c| c.is_finite()) {
                rotation(v, || {})
            } else {
                DQuat::from_array([f64::NAN; 4])
            }
        };
        if self.interpolation == Interpolation::Linear && s.t > 0.0 {
            let (a, b) = (unit(value(s.k).map(f64::from)), unit(value(s.k + 1).map(f64::from)));
            return if a.is_nan() || b.is_nan() { DQuat::from_array([f64::NAN; 4]) } else { a.slerp(b, s.t) };
        }
        unit(self.sample(value))
    }
}
