//! The model with other choices: presets, and each approximation changed in turn.

use super::{Job, Judge, Look};
use etendue_ibl::BadSky;
use etendue_image::Image;
use etendue_realtime::choices::{Occlusion, Shadows, Specular};
use etendue_realtime::{Choices, Frame, Lighting, Preset, Twin, TwinSettings};
use etendue_render::Counters;
use serde_json::{Value, json};
use std::time::Instant;

/// Which reference a variant is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// Lights and sky alone; the model draws neither shadows nor occlusion.
    LightOnly,
    /// The whole truth; the model draws what shadows and occlusion its choices give it.
    Whole,
}

impl Against {
    /// As JSON has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::LightOnly => "light-only",
            Self::Whole => "whole",
        }
    }
}

/// A picture of the model with some choices, judged.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The key that was changed, or empty.
    pub key: &'static str,
    /// Its value; for a preset its name.
    pub value: &'static str,
    /// All choices.
    pub choices: Choices,
    /// By which reference.
    pub against: Against,
    /// Mean FLIP of the developed pictures.
    pub flip: f64,
    /// Relative mean squared error of the light.
    pub rel_mse: f64,
    /// Thread time for a sample of a pixel, camera ray included, nanoseconds.
    pub nanoseconds: f64,
    /// Time that was spent on the sky before, seconds.
    pub bake_seconds: f64,
    /// The value is the key's exact form: the one called so, or else that of the preset `exact`.
    pub exact: bool,
    /// The picture has the same bits as its base's.
    pub no_effect: bool,
    /// Index of the row that it is to be compared with; its own for a base.
    pub base: usize,
}

impl Variant {
    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        json!({
            "key": self.key, "value": self.value, "choices": self.choices.to_string(),
            "against": self.against.name(), "flip": self.flip, "rel_mse": self.rel_mse,
            "nanoseconds": self.nanoseconds, "bake_seconds": self.bake_seconds, "exact": self.exact,
            "no_effect": self.no_effect, "base": self.base,
        })
    }
}

/// True if a key has no value that is more exact.
fn is_exact(key: &str, value: &str) -> bool {
    let named = Choices::KEYS.iter().any(|k| k.name == key && k.values.contains(&"exact"));
    if named { value == "exact" } else { Preset::Exact.choices().get(key) == Some(value) }
}

/// The same choices without shadows and without occlusion, for comparison with the reference that knows neither.
pub(crate) fn unoccluded(choices: &Choices) -> Choices {
    Choices { occlusion: Occlusion::None, shadows: Shadows::None, ..*choices }
}

/// Draws pictures, and keeps the last sky that was integrated.
pub(crate) struct Studio<'a> {
    job: &'a Job<'a>,
    lighting: Option<(String, Lighting, f64)>,
}

/// What was drawn and what it took.
pub(crate) struct Drawn {
    pub frame: Frame,
    pub nanoseconds: f64,
    pub bake_seconds: f64,
}

impl<'a> Studio<'a> {
    pub fn new(job: &'a Job<'a>) -> Self {
        Self { job, lighting: None }
    }

    /// What the integrated sky depends on.
    fn sky_key(choices: &Choices) -> String {
        let keys = ["diffuse", "specular", "prefilter", "kernel", "resolution"];
        keys.map(|k| choices.get(k).unwrap_or("")).join(",")
    }

    /// Draws the picture that `choices` give, `samples` to a pixel.
    pub fn draw(
        &mut self,
        choices: &Choices,
        samples: u32,
        passes: etendue_realtime::passes::PassSet,
    ) -> Result<Drawn, BadSky> {
        let job = self.job;
        let key = Self::sky_key(choices);
        let lighting = match self.lighting.take() {
            Some(l) if l.0 == key => l,
            old => {
                // The old one goes first: both together may not fit.
                drop(old);
                let start = Instant::now();
                let lighting = Lighting::new(job.world.scene(), choices)?;
                (key, lighting, start.elapsed().as_secs_f64())
            }
        };
        let (_, lighting, bake_seconds) = self.lighting.insert(lighting);
        let s = &job.settings;
        let settings = TwinSettings {
            width: s.width,
            height: s.height,
            samples,
            filter: s.filter,
            seed: s.seed,
            sky_visible: s.path.sky_visible,
            passes,
        };
        let start = Instant::now();
        let frame =
            Twin::new(job.world, &job.camera, lighting, *choices, settings).render(&Counters::default());
        let count = f64::from(s.width) * f64::from(s.height) * f64::from(samples);
        let thread_time = start.elapsed().as_secs_f64() * rayon::current_num_threads() as f64;
        Ok(Drawn { frame, nanoseconds: thread_time / count * 1e9, bake_seconds: *bake_seconds })
    }
}

/// The presets, and the choices of the job where they are none of them, each judged by both references.
pub(crate) fn presets(
    job: &Job,
    studio: &mut Studio,
    references: [&Image; 2],
    look: &Look,
    progress: &dyn Fn(f64),
) -> Result<Vec<Variant>, BadSky> {
    let mut out = Vec::new();
    let rows: Vec<(&'static str, Choices)> = Preset::ALL.iter().map(|p| (p.name(), p.choices())).collect();
    for (i, (name, choices)) in rows.iter().enumerate() {
        for against in [Against::LightOnly, Against::Whole] {
            let drawn = match against {
                Against::LightOnly => unoccluded(choices),
                Against::Whole => *choices,
            };
            let d = studio.draw(&drawn, job.twin_samples, Default::default())?;
            let judge = Judge::new(references[against as usize], &d.frame.picture(false), look);
            let base = out.len();
            out.push(Variant {
                key: "",
                value: name,
                choices: drawn,
                against,
                flip: judge.flip.mean,
                rel_mse: judge.rel_mse,
                nanoseconds: d.nanoseconds,
                bake_seconds: d.bake_seconds,
                exact: *choices == Preset::Exact.choices(),
                no_effect: false,
                base,
            });
        }
        progress((i + 1) as f64 / rows.len() as f64);
    }
    Ok(out)
}

/// Each choice changed in turn, after the rows that they are compared with: the job's own choices by either reference, and, where
/// the job does not use it, the split sum.
pub(crate) fn ablations(
    job: &Job,
    studio: &mut Studio,
    references: [&Image; 2],
    look: &Look,
    progress: &dyn Fn(f64),
) -> Result<Vec<Variant>, BadSky> {
    struct Row {
        key: &'static str,
        value: &'static str,
        choices: Choices,
        against: Against,
        base: usize,
    }
    let split = Choices { specular: Specular::SplitSum, ..job.choices };
    let apart = split != job.choices;
    let own = job.choices.get("specular").unwrap_or("");
    let mut rows = vec![
        Row { key: "", value: own, choices: unoccluded(&job.choices), against: Against::LightOnly, base: 0 },
        Row { key: "", value: own, choices: job.choices, against: Against::Whole, base: 1 },
    ];
    let split_row = if apart { 2 } else { 0 };
    let mut later = Vec::new();
    for a in job.choices.ablations().into_iter().filter(|a| (job.ablate)(a.key)) {
        let of_shadow = matches!(a.key, "occlusion" | "shadows");
        let (choices, against) = if of_shadow {
            (a.choices, Against::Whole)
        } else {
            (unoccluded(&a.choices), Against::LightOnly)
        };
        let base = match (of_shadow, Choices::is_of_split_sum(a.key)) {
            (true, _) => 1,
            (_, true) => split_row,
            _ => 0,
        };
        later.push(Row { key: a.key, value: a.value, choices, against, base });
    }
    if apart && later.iter().any(|r| r.base == split_row) {
        let choices = unoccluded(&split);
        rows.push(Row { key: "specular", value: "split-sum", choices, against: Against::LightOnly, base: 0 });
        later.retain(|r| !(r.key == "specular" && r.value == "split-sum"));
    }
    if later.is_empty() {
        return Ok(Vec::new());
    }
    rows.extend(later);

    // Those that share a sky one after another.
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by_key(|i| Studio::sky_key(&rows[*i].choices));
    let mut drawn: Vec<Option<(Image, Variant)>> = rows.iter().map(|_| None).collect();
    for (done, i) in order.into_iter().enumerate() {
        let row = &rows[i];
        let d = studio.draw(&row.choices, job.ablation_samples, Default::default())?;
        let picture = d.frame.picture(false);
        let judge = Judge::new(references[row.against as usize], &picture, look);
        let variant = Variant {
            key: row.key,
            value: row.value,
            choices: row.choices,
            against: row.against,
            flip: judge.flip.mean,
            rel_mse: judge.rel_mse,
            nanoseconds: d.nanoseconds,
            bake_seconds: d.bake_seconds,
            exact: is_exact(row.key, row.value),
            no_effect: false,
            base: row.base,
        };
        drawn[i] = Some((picture, variant));
        progress((done + 1) as f64 / rows.len() as f64);
    }
    let drawn: Vec<(Image, Variant)> = drawn.into_iter().flatten().collect();
    let same: Vec<bool> =
        drawn.iter().enumerate().map(|(i, (p, v))| i != v.base && *p == drawn[v.base].0).collect();
    Ok(drawn.into_iter().zip(same).map(|((_, v), same)| Variant { no_effect: same, ..v }).collect())
}
