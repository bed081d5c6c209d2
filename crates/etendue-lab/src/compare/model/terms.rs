//! The error, term by term: where the model goes wrong, and what it has no way to know.

use super::truth::{Truth, add, mean};
use super::{Judge, Look};
use etendue_image::Image;
use etendue_realtime::Frame;
use etendue_realtime::passes::Pass as Term;
use etendue_render::Pass;
use serde_json::{Value, json};

/// The model's terms, and the parts of the reference that they stand for.
pub(crate) const TERMS: [(&str, Term, Pass); 7] = [
    ("direct diffuse", Term::DirectDiffuse, Pass::LightDiffuse),
    ("direct specular", Term::DirectSpecular, Pass::LightSpecular),
    ("indirect diffuse", Term::IndirectDiffuse, Pass::SkyDiffuse),
    ("indirect specular", Term::IndirectSpecular, Pass::SkySpecular),
    ("transmission", Term::Transmission, Pass::Transmission),
    ("emission", Term::Emission, Pass::Emission),
    ("environment", Term::Environment, Pass::Environment),
];

/// One term of the model beside the same part of the reference that only sees lights and sky.
#[derive(Clone, Debug)]
pub struct TermError {
    /// What it is.
    pub name: &'static str,
    /// Mean light of the reference's part, R, G, B.
    pub reference: [f64; 3],
    /// Mean light of the model's term.
    pub model: [f64; 3],
    /// Root mean square difference of the light.
    pub rmse: f64,
    /// Relative mean squared error of the term by itself.
    pub rel_mse: f64,
    /// Mean FLIP of the term as a picture of its own.
    pub flip: f64,
    /// Mean FLIP that this term's error alone makes in the whole picture.
    pub effect: f64,
    /// The pictures: reference, model.
    pub(crate) pictures: [Image; 2],
}

impl TermError {
    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        json!({
            "name": self.name, "reference": self.reference, "model": self.model, "rmse": self.rmse,
            "rel_mse": self.rel_mse, "flip": self.flip, "effect": self.effect,
        })
    }

    /// True if neither has any of it.
    pub fn is_absent(&self) -> bool {
        self.reference == [0.0; 3] && self.model == [0.0; 3]
    }
}

/// Compares each term of `frame` with its part of `truth`.
pub(crate) fn terms(truth: &Truth, frame: &Frame, look: &Look) -> Vec<TermError> {
    let whole = truth.picture();
    let one = |(name, term, part): (&'static str, Term, Pass)| {
        let reference = truth.parts(&[part]);
        let mut model = reference.clone();
        if let (etendue_image::Pixels::F32(p), Some(v)) =
            (&mut model.pixels, frame.pass(term, &look.development))
        {
            *p = v;
        }
        let mut changed = whole.clone();
        add(&mut changed, &model, 1.0);
        add(&mut changed, &reference, -1.0);
        let judge = Judge::new(&reference, &model, look);
        TermError {
            name,
            reference: mean(&reference),
            model: mean(&model),
            rmse: judge.rmse,
            rel_mse: judge.rel_mse,
            flip: judge.flip.mean,
            effect: Judge::new(&whole, &changed, look).flip.mean,
            pictures: [reference, model],
        }
    };
    TERMS.into_iter().map(one).collect()
}

/// Something of the whole reference that the reference of lights alone has not, or the other way round.
#[derive(Clone, Debug)]
pub struct Unknown {
    /// What it is.
    pub name: &'static str,
    /// In a sentence.
    pub about: &'static str,
    /// Mean light that it adds to the picture (negative: takes away), R, G, B.
    pub change: [f64; 3],
    /// Mean FLIP between the whole picture and the same without it.
    pub effect: f64,
}

impl Unknown {
    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        json!({"name": self.name, "change": self.change, "effect": self.effect})
    }
}

/// What the model cannot know, by comparing the whole reference with that of lights alone.
pub(crate) fn unknowns(whole: &Truth, alone: &Truth, look: &Look) -> Vec<Unknown> {
    let picture = whole.picture();
    let kinds: [(&str, &str, &[Pass]); 4] = [
        (
            "shadows",
            "light of directional, point and spot lights that something hides",
            &[Pass::LightDiffuse, Pass::LightSpecular],
        ),
        (
            "occlusion of the sky",
            "light of the sky that the scene itself hides",
            &[Pass::SkyDiffuse, Pass::SkySpecular],
        ),
        (
            "interreflection",
            "light of other surfaces, which shine or scatter",
            &[Pass::BounceDiffuse, Pass::BounceSpecular],
        ),
        (
            "the way through",
            "what transmissive surfaces show of the scene instead of the sky",
            &[Pass::Transmission],
        ),
    ];
    kinds
        .into_iter()
        .map(|(name, about, passes)| {
            let mut change = whole.parts(passes);
            add(&mut change, &alone.parts(passes), -1.0);
            let mut without = picture.clone();
            add(&mut without, &change, -1.0);
            let effect = Judge::new(&picture, &without, look).flip.mean;
            Unknown { name, about, change: mean(&change), effect }
        })
        .collect()
}
