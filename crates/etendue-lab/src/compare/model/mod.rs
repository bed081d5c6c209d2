//! The report on a model: real-time shading beside the path tracer.

mod page;
mod terms;
mod truth;
mod variants;

pub use terms::{TermError, Unknown};
pub use variants::{Against, Variant};

use super::figures::{Figures, FlipFigures, Metric, compare};
use etendue_ibl::BadSky;
use etendue_image::{Depth, Development, Image, ImageError, develop, hdr_flip, ldr_flip, rel_mse, rmse};
use etendue_realtime::passes::PassSet;
use etendue_realtime::{Choices, Frame};
use etendue_render::{Settings, World};
use etendue_scene::Camera;
use serde_json::{Value, json};
use terms::{TERMS, terms, unknowns};
use truth::Truth;
use variants::{Studio, ablations, presets, unoccluded};

/// What is to be compared, and how closely.
pub struct Job<'a> {
    /// The scene.
    pub world: &'a World,
    /// Who looks at it.
    pub camera: Camera,
    /// Size, filter, seed and limits of both pictures; its passes are not looked at.
    pub settings: Settings,
    /// The real-time model's choices.
    pub choices: Choices,
    /// Path-traced samples of a pixel, for each of the two references.
    pub samples: u32,
    /// Samples of a pixel of the real-time picture.
    pub twin_samples: u32,
    /// The same for the pictures of the ablations.
    pub ablation_samples: u32,
    /// Whether the presets are drawn, too.
    pub presets: bool,
    /// Which keys are changed in turn.
    pub ablate: &'a (dyn Fn(&str) -> bool + Sync),
    /// How light is shown, and developed for FLIP.
    pub development: Development,
    /// Resolution at which FLIP looks.
    pub pixels_per_degree: f32,
}

/// How pictures are looked at.
pub(crate) struct Look {
    pub development: Development,
    pub pixels_per_degree: f32,
}

/// A picture of light beside its reference: FLIP as developed, the rest of the light.
pub(crate) struct Judge {
    pub flip: FlipFigures,
    pub map: Vec<f32>,
    pub rmse: f64,
    pub rel_mse: f64,
}

impl Judge {
    /// Both pictures are of one renderer and so of one size; if not, there is nothing to see.
    pub fn new(reference: &Image, test: &Image, look: &Look) -> Self {
        let development = Development { depth: Depth::Eight, dither: false, ..look.development };
        let [r, t] = [reference, test].map(|i| develop(i, &development));
        let map = ldr_flip(&r, &t, look.pixels_per_degree).map_or(vec![1.0], |f| f.map);
        Self {
            flip: FlipFigures::of(&map, reference.width, Metric::Ldr, look.pixels_per_degree),
            map,
            rmse: rmse(reference, test).unwrap_or(f64::NAN),
            rel_mse: rel_mse(reference, test).unwrap_or(f64::NAN),
        }
    }
}

/// The real-time picture beside one of the references.
#[derive(Clone, Debug)]
pub struct Side {
    /// Which reference.
    pub against: Against,
    /// FLIP of the developed pictures.
    pub flip: FlipFigures,
    /// Its mean over the pixels that show a surface: it does not depend on how much sky is around.
    pub flip_of_surfaces: f64,
    /// Mean HDR-FLIP of the light: at the worst of a range of exposures.
    pub hdr_flip: f64,
    /// Figures of the light.
    pub light: Figures,
    /// Mean FLIP that the reference's own noise makes.
    pub noise: f64,
    pub(crate) map: Vec<f32>,
    pub(crate) pictures: [Image; 2],
}

impl Side {
    fn new(against: Against, truth: &Truth, test: Image, look: &Look) -> Result<Self, ImageError> {
        let reference = truth.picture();
        let judge = Judge::new(&reference, &test, look);
        let covered = truth.covered();
        let count = covered.iter().filter(|c| **c).count().max(1) as f64;
        let on_surfaces = judge.map.iter().zip(&covered).filter(|(_, c)| **c).map(|(v, _)| f64::from(*v));
        let light = compare(&reference, &test, look.pixels_per_degree).map_err(|e| match e {
            super::CompareError::Image(e) => e,
            e => ImageError::Io(std::io::Error::other(e.to_string())),
        })?;
        Ok(Self {
            against,
            flip: judge.flip,
            flip_of_surfaces: on_surfaces.sum::<f64>() / count,
            hdr_flip: hdr_flip(&reference, &test, look.pixels_per_degree)?.mean,
            light: light.figures,
            noise: Judge::new(&reference, truth.half(), look).flip.mean,
            map: judge.map,
            pictures: [reference, test],
        })
    }

    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        json!({
            "against": self.against.name(), "flip": self.flip.to_json(),
            "flip_of_surfaces": self.flip_of_surfaces, "hdr_flip": self.hdr_flip, "noise_flip": self.noise,
            "rmse": self.light.rmse, "rel_mse": self.light.rel_mse, "bias": self.light.bias,
        })
    }
}

/// Real-time shading beside the path tracer, term by term and choice by choice.
#[derive(Clone, Debug)]
pub struct ModelReport {
    /// What is shown, for the heading.
    pub title: String,
    /// The command that made the report.
    pub command: String,
    /// The model's choices.
    pub choices: Choices,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples of a pixel: references, real-time picture, ablations.
    pub samples: [u32; 3],
    /// Changes all random numbers.
    pub seed: u32,
    /// How light was developed.
    pub development: Development,
    /// The model without shadows and occlusion beside the reference of lights and sky alone: the error of the shading.
    pub shading: Side,
    /// The model beside the whole truth.
    pub whole: Side,
    /// The error of the shading by terms.
    pub terms: Vec<TermError>,
    /// What stands between the two references.
    pub unknowns: Vec<Unknown>,
    /// The named sets of choices.
    pub presets: Vec<Variant>,
    /// Each choice changed in turn.
    pub ablations: Vec<Variant>,
    /// Samples that were not numbers, of all pictures.
    pub rejected: u64,
    /// Mean FLIP up to which the pictures count as alike, and by which reference.
    pub max_flip: Option<(f64, Against)>,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The sky cannot be integrated.
    #[error("the sky: {0}")]
    Sky(#[from] BadSky),
    /// A picture cannot be compared.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// Draws everything and compares it. `progress` is told what is being done and which share of it is done.
///
/// # Errors
/// See [`ModelError`].
pub fn model_report(job: &Job, progress: &dyn Fn(&str, f64)) -> Result<ModelReport, ModelError> {
    let look = Look { development: job.development, pixels_per_degree: job.pixels_per_degree };
    let truth = |light_only: bool, what: &str| {
        let done = |share: f64| progress(what, share);
        Truth::render(job.world, &job.camera, &job.settings, light_only, job.samples, &done)
    };
    let alone = truth(true, "lights alone");
    let whole = truth(false, "path tracer");
    let mut studio = Studio::new(job);
    progress("real time", 0.0);
    let parts = TERMS.iter().fold(PassSet::default(), |set, (_, term, _)| set.with(*term));
    let bare: Frame = studio.draw(&unoccluded(&job.choices), job.twin_samples, parts)?.frame;
    progress("real time", 0.5);
    let full = studio.draw(&job.choices, job.twin_samples, PassSet::default())?.frame;
    progress("real time", 1.0);

    let references = [alone.picture(), whole.picture()];
    let references = [&references[0], &references[1]];
    let mut presets_drawn = Vec::new();
    if job.presets {
        presets_drawn = presets(job, &mut studio, references, &look, &|s| progress("presets", s))?;
    }
    let ablations = ablations(job, &mut studio, references, &look, &|s| progress("ablations", s))?;
    progress("figures", 0.0);
    Ok(ModelReport {
        title: String::new(),
        command: String::new(),
        choices: job.choices,
        size: [job.settings.width, job.settings.height],
        samples: [job.samples.max(2), job.twin_samples, job.ablation_samples],
        seed: job.settings.seed,
        development: job.development,
        shading: Side::new(Against::LightOnly, &alone, bare.picture(false), &look)?,
        whole: Side::new(Against::Whole, &whole, full.picture(false), &look)?,
        terms: terms(&alone, &bare, &look),
        unknowns: unknowns(&whole, &alone, &look),
        presets: presets_drawn,
        ablations,
        rejected: alone.rejected() + whole.rejected() + bare.rejected + full.rejected,
        max_flip: None,
    })
}

impl ModelReport {
    /// The side that a limit is for.
    pub fn side(&self, against: Against) -> &Side {
        match against {
            Against::LightOnly => &self.shading,
            Against::Whole => &self.whole,
        }
    }

    /// False if the mean FLIP is above [`ModelReport::max_flip`].
    pub fn passes(&self) -> bool {
        self.max_flip.is_none_or(|(max, against)| self.side(against).flip.mean <= max)
    }

    /// The figures as JSON:
    ///
    /// | key | value |
    /// |---|---|
    /// | `kind` | `"model"` |
    /// | `title`, `command`, `choices` | text |
    /// | `width`, `height`, `seed`, `samples` (`reference`, `realtime`, `ablations`), `rejected_samples` | numbers |
    /// | `exposure`, `curve` | how light was developed for FLIP |
    /// | `whole`, `shading` | the two comparisons: `against` (`"whole"`, `"light-only"`), `flip` (as in [`super::PictureReport::to_json`]), `flip_of_surfaces`, `hdr_flip`, `noise_flip` (what the reference's noise makes), `rmse`, `rel_mse`, `bias` |
    /// | `terms` | array: `name`, `reference` and `model` (mean light, R G B), `rmse`, `rel_mse`, `flip` (of the term by itself), `effect` (FLIP that its error makes in the picture) |
    /// | `unknowns` | array: `name`, `change` (mean light that the whole reference has more, R G B), `effect` |
    /// | `presets`, `ablations` | arrays: `key`, `value`, `choices`, `against`, `flip`, `rel_mse`, `nanoseconds` (thread time per sample), `bake_seconds`, `exact`, `no_effect`, `base` (index of the row to compare with) |
    /// | `max_flip`, `max_flip_against` | the limit and its side, or `null` |
    /// | `passes` | true unless the mean FLIP is above the limit |
    pub fn to_json(&self) -> Value {
        let all = |v: &[Variant]| v.iter().map(Variant::to_json).collect::<Vec<_>>();
        let [reference, realtime, ablations] = self.samples;
        json!({
            "kind": "model", "title": self.title, "command": self.command,
            "choices": self.choices.to_string(), "width": self.size[0], "height": self.size[1],
            "seed": self.seed,
            "samples": {"reference": reference, "realtime": realtime, "ablations": ablations},
            "rejected_samples": self.rejected, "exposure": self.development.exposure_ev,
            "curve": self.development.curve.to_string(), "whole": self.whole.to_json(),
            "shading": self.shading.to_json(),
            "terms": self.terms.iter().map(TermError::to_json).collect::<Vec<_>>(),
            "unknowns": self.unknowns.iter().map(Unknown::to_json).collect::<Vec<_>>(),
            "presets": all(&self.presets), "ablations": all(&self.ablations),
            "max_flip": self.max_flip.map(|m| m.0), "max_flip_against": self.max_flip.map(|m| m.1.name()),
            "passes": self.passes(),
        })
    }

    /// A few lines for a terminal.
    pub fn to_text(&self) -> String {
        let line = |name: &str, s: &Side| {
            format!(
                "{name}  FLIP {:.4} (surfaces {:.4}, 95 % {:.4}; HDR {:.4}; noise of the reference {:.4}), relMSE {:.2e}\n",
                s.flip.mean, s.flip_of_surfaces, s.flip.p95, s.hdr_flip, s.noise, s.light.rel_mse
            )
        };
        let mut out = line("shading, beside lights alone:   ", &self.shading);
        out += &line("picture, beside the path tracer:", &self.whole);
        for t in self.terms.iter().filter(|t| !t.is_absent()) {
            out += &format!(
                "  {:20} {:.4} of {:.4}  relMSE {:.2e}, FLIP in the picture {:.4}\n",
                t.name,
                brightness(t.model),
                brightness(t.reference),
                t.rel_mse,
                t.effect
            );
        }
        for u in self.unknowns.iter().filter(|u| u.change != [0.0; 3]) {
            out += &format!(
                "  {:20} {:+.4} unknown to the model, FLIP in the picture {:.4}\n",
                u.name,
                brightness(u.change),
                u.effect
            );
        }
        out
    }
}

/// Luminance (Rec. 709) of mean light.
pub(crate) fn brightness([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
