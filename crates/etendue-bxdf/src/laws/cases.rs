//! The cases that a model is put to: its parameters over a grid, and each of its features switched on.
//!
//! | kind | parameters |
//! |---|---|
//! | grid | roughness × anisotropy, the rest as by default |
//! | ends | one parameter at a time at either end of its range, flags turned, each choice; roughness 0.3, anisotropy 0.5 |
//! | named | the combinations of [`NAMED`], features that only speak together, over three roughnesses |
//! | random | all parameters at random within their ranges |
//!
//! Each from the outside, and, if light passes, from the inside and for either kind of transport.

use super::{Rng, finite::shake};
use crate::{
    bsdf::Bsdf,
    model::{Closure, Incidence, Model, Transport, Value},
};

/// What a run covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Perceptual roughness of the grid, for models that have one.
    pub roughness: Vec<f32>,
    /// Anisotropy of the grid, for models that have one.
    pub anisotropy: Vec<f32>,
    /// Angles of `wo` to the normal, in degrees.
    pub angles: Vec<f32>,
    /// Angles of the cases that are not of the grid.
    pub feature_angles: Vec<f32>,
    /// Random sets of parameters.
    pub random: usize,
    /// Samples of the χ² test; the other statistical laws use a part of them.
    pub samples: usize,
    /// Probability that a run over sound models finds a fault by chance.
    pub significance: f64,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Settings {
    /// A part of everything in seconds per model: 3 × 2 grid, two angles, 2·10⁴ samples.
    pub fn quick() -> Self {
        Self {
            roughness: vec![0.0, 0.1, 0.6],
            anisotropy: vec![0.0, 0.9],
            angles: vec![30.0, 80.0],
            feature_angles: vec![60.0],
            random: 2,
            samples: 20_000,
            significance: 0.01,
            seed: 1,
        }
    }

    /// The whole grid: 6 × 3, five angles, 10⁶ samples; minutes to an hour per model.
    pub fn full() -> Self {
        Self {
            roughness: super::grid::ROUGHNESS.into(),
            anisotropy: super::grid::ANISOTROPY.into(),
            angles: super::grid::ANGLES.into(),
            feature_angles: super::grid::ANGLES.into(),
            random: 8,
            samples: 1_000_000,
            ..Self::quick()
        }
    }
}

/// One closure to be tested, with all that it was made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The model with its parameters.
    pub model: Model,
    /// Which kind of case it is and what is special in it.
    pub variant: String,
    /// Roughness of the grid, if it is a parameter here.
    pub roughness: Option<f32>,
    /// Anisotropy of the grid, if it is a parameter here.
    pub anisotropy: Option<f32>,
    /// The side that it is seen from.
    pub front: bool,
    /// What the path carries.
    pub transport: Transport,
    /// Angles of `wo`, in degrees.
    pub angles: Vec<f32>,
}

/// What the grid's roughness is called, by model; the first that a model has.
const ROUGHNESS_NAMES: [&str; 4] = ["roughness", "specular_roughness", "base_roughness", "beta_m"];
/// What the grid's anisotropy is called.
const ANISOTROPY_NAMES: [&str; 5] = [
    "anisotropy",
    "anisotropic",
    "anisotropy_strength",
    "specular_roughness_anisotropy",
    "specular_anisotropy",
];

/// A combination of parameters: the model, what is special in it, and the parameters as text.
pub type Named = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

/// Combinations in which features act together.
pub const NAMED: &[Named] = &[
    ("gltf", "coated metal", &[("metallic", "1"), ("clearcoat", "1"), ("clearcoat_roughness", "0.2")]),
    (
        "gltf",
        "sheen under a coat",
        &[
            ("sheen_color", "1"),
            ("sheen_roughness", "0.4"),
            ("clearcoat", "0.5"),
            ("clearcoat_roughness", "0.3"),
        ],
    ),
    (
        "gltf",
        "brushed, tinted varnish that darkens",
        &[
            ("clearcoat", "0.9"),
            ("clearcoat_roughness", "0.3"),
            ("coat_ior", "2"),
            ("coat_color", "0.9,0.5,0.2"),
            ("coat_darkening", "1"),
            ("coat_anisotropy_strength", "0.6"),
            ("coat_tangent", "1,1,0"),
            ("metallic", "0.3"),
        ],
    ),
    (
        "gltf",
        "white under a clear varnish that darkens",
        &[("clearcoat", "1"), ("coat_ior", "1.8"), ("coat_darkening", "1"), ("diffuse_roughness", "1")],
    ),
    (
        "gltf",
        "fuzz over a tilted coat",
        &[
            ("fuzz", "0.8"),
            ("fuzz_roughness", "0.3"),
            ("clearcoat", "0.7"),
            ("clearcoat_roughness", "0.3"),
            ("clearcoat_normal", "0.2,0.1,1"),
        ],
    ),
    (
        "gltf",
        "dusty rough leaf under tinted varnish",
        &[
            ("fuzz", "1"),
            ("fuzz_color", "0"),
            ("fuzz_roughness", "0.9"),
            ("diffuse_transmission", "0.6"),
            ("diffuse_roughness", "0.8"),
            ("clearcoat", "0.5"),
            ("coat_color", "0.2,0.5,0.9"),
        ],
    ),
    (
        "gltf",
        "glass under tinted varnish and fuzz",
        &[
            ("transmission", "1"),
            ("thickness", "1"),
            ("clearcoat", "1"),
            ("coat_color", "0.9,0.5,0.2"),
            ("coat_darkening", "1"),
            ("fuzz", "0.5"),
        ],
    ),
    ("gltf", "film on metal", &[("metallic", "1"), ("base_color", "1,0.8,0.3"), ("iridescence", "1")]),
    ("gltf", "film on a dielectric", &[("iridescence", "1"), ("iridescence_ior", "2")]),
    ("gltf", "tinted pane", &[("transmission", "1"), ("base_color", "0.9,0.5,0.2")]),
    ("gltf", "solid glass", &[("transmission", "1"), ("thickness", "1")]),
    (
        "gltf",
        "cloudy glass under a coat",
        &[("transmission", "0.5"), ("thickness", "1"), ("clearcoat", "1"), ("clearcoat_roughness", "0.3")],
    ),
    (
        "gltf",
        "frosted sheet that scatters forward",
        &[
            ("transmission", "0.9"),
            ("scatter_strength", "0.7"),
            ("scatter_anisotropy", "0.6"),
            ("multiscatter_color", "0.9,0.6,0.3"),
            ("roughness", "0.3"),
        ],
    ),
    ("gltf", "leaf", &[("diffuse_transmission", "0.6"), ("base_color", "0.5,0.8,0.2")]),
    ("gltf", "specular-glossiness", &[("ior", "0"), ("specular_color", "0.3,0.6,0.1")]),
    (
        "disney-brdf",
        "everything on",
        &[
            ("subsurface", "0.5"),
            ("specular_tint", "0.5"),
            ("anisotropic", "0.9"),
            ("sheen", "1"),
            ("clearcoat", "1"),
            ("clearcoat_gloss", "0.5"),
            ("metallic", "0.3"),
        ],
    ),
    ("disney-bsdf", "coated glass", &[("spec_trans", "0.7"), ("clearcoat", "1"), ("metallic", "0.2")]),
    (
        "disney-bsdf",
        "thin, everything passes",
        &[
            ("thin", "true"),
            ("spec_trans", "0.4"),
            ("diff_trans", "1.5"),
            ("flatness", "0.5"),
            ("sheen", "1"),
            ("anisotropic", "0.9"),
        ],
    ),
    ("metal-rough", "ior 0", &[("ior", "0"), ("specular_color", "0.3,0.6,0.1"), ("base_color", "1")]),
    (
        "metal-rough",
        "half metal, red specular",
        &[("metallic", "0.5"), ("specular", "0.5"), ("specular_color", "9,0.2,0.2"), ("base_color", "1")],
    ),
    (
        "openpbr",
        "coated glass with a film, seen through fuzz",
        &[
            ("transmission_weight", "0.7"),
            ("transmission_dispersion_scale", "0.5"),
            ("coat_weight", "0.8"),
            ("coat_color", "0.9,0.5,0.2"),
            ("thin_film_weight", "0.5"),
            ("fuzz_weight", "0.3"),
        ],
    ),
    (
        "openpbr",
        "half metal under a rough, tilted coat",
        &[
            ("base_metalness", "0.5"),
            ("base_diffuse_roughness", "0.5"),
            ("coat_weight", "1"),
            ("coat_roughness", "0.4"),
            ("coat_roughness_anisotropy", "0.5"),
            ("geometry_coat_normal", "0.2,0.1,1"),
            ("geometry_coat_tangent", "1,1,0"),
        ],
    ),
    (
        "openpbr",
        "sheet, everything passes",
        &[
            ("geometry_thin_walled", "true"),
            ("transmission_weight", "0.5"),
            ("transmission_color", "0.9,0.6,0.3"),
            ("subsurface_weight", "0.7"),
            ("thin_film_weight", "1"),
            ("coat_weight", "0.5"),
            ("base_diffuse_roughness", "0.7"),
        ],
    ),
];

/// The parameter of the grid's roughness, if `model` has one.
pub fn roughness_name(model: &Model) -> Option<&'static str> {
    ROUGHNESS_NAMES.into_iter().find(|n| model.get(n).is_some())
}

/// The parameter of the grid's anisotropy, if `model` has one.
pub fn anisotropy_name(model: &Model) -> Option<&'static str> {
    ANISOTROPY_NAMES.into_iter().find(|n| model.get(n).is_some())
}

/// All cases of a model; `model` says what "by default" means.
pub fn cases(model: &Model, settings: &Settings) -> Vec<Case> {
    let mut out = Cases { out: Vec::new(), angles: &settings.angles };
    for &r in &settings.roughness {
        for &a in &settings.anisotropy {
            out.add(model, "grid", Some(r), Some(a));
            if anisotropy_name(model).is_none() {
                break;
            }
        }
        if roughness_name(model).is_none() {
            break;
        }
    }
    out.angles = &settings.feature_angles;
    for p in model.parameters() {
        if Some(p.name) == roughness_name(model) || Some(p.name) == anisotropy_name(model) {
            continue;
        }
        for value in ends(&p) {
            let mut m = *model;
            if Some(value) != model.get(p.name) && m.set(p.name, value) {
                out.add(&m, &format!("{} = {}", p.name, text(value)), Some(0.3), Some(0.5));
            }
        }
    }
    for (_, what, parameters) in NAMED.iter().filter(|n| n.0 == model.name()) {
        let mut m = *model;
        for (parameter, value) in *parameters {
            // That each is there and is a value is a test below.
            let _ = m.set_text(parameter, value);
        }
        for r in [0.0, 0.3, 1.0] {
            out.add(&m, what, Some(r), Some(0.5));
            if roughness_name(model).is_none() {
                break;
            }
        }
    }
    let mut rng = Rng::new(settings.seed);
    for i in 0..settings.random {
        let m = shake(model, 0.0, &mut rng);
        out.add(&m, &format!("random {i}"), None, None);
    }
    out.out
}

/// The values at which a parameter is tested apart from its default.
fn ends(p: &crate::model::Parameter) -> Vec<Value> {
    // An open end is a large number, but one that a user might write.
    let [mut low, high] = p.range.map(|v| v.clamp(-1e3, 1e3));
    // A fibre's ridges around its axis are nearly lines below this, along which quadrature has no coordinates: at 0.01 it
    // finds 0.988 for a density of 1.
    if p.name == "beta_n" {
        low = low.max(0.1);
    }
    match p.default {
        Value::Number(_) => vec![Value::Number(low), Value::Number(high)],
        // Each lane another value, so that an exchange shows.
        Value::Color(_) => {
            vec![
                Value::Color([high; 3]),
                Value::Color([0.8, 0.3, 0.05].map(|t| low + (high.min(1.0) - low) * t)),
            ]
        }
        Value::Vector(_) => vec![Value::Vector([0.48, 0.36, 0.8])],
        Value::Flag(b) => vec![Value::Flag(!b)],
        Value::Choice(_) => p.choices.iter().map(|c| Value::Choice(c)).collect(),
    }
}

/// A value as a user writes it on the command line.
pub fn text(value: Value) -> String {
    match value {
        Value::Number(v) => format!("{v}"),
        Value::Color([r, g, b]) if r == g && g == b => format!("{r}"),
        Value::Color([a, b, c]) | Value::Vector([a, b, c]) => format!("{a},{b},{c}"),
        Value::Flag(b) => format!("{b}"),
        Value::Choice(c) => c.into(),
    }
}

struct Cases<'a> {
    out: Vec<Case>,
    angles: &'a [f32],
}

impl Cases<'_> {
    /// The case from each side and for each transport in which it differs.
    fn add(&mut self, model: &Model, variant: &str, roughness: Option<f32>, anisotropy: Option<f32>) {
        let mut model = *model;
        let names = (roughness_name(&model), anisotropy_name(&model));
        let mut put = |name: Option<&'static str>, value: Option<f32>| {
            let (name, value) = (name?, value?);
            model.set(name, Value::Number(value)).then_some(value)
        };
        let (roughness, anisotropy) = (put(names.0, roughness), put(names.1, anisotropy));
        let front = Case {
            model,
            variant: variant.into(),
            roughness,
            anisotropy,
            front: true,
            transport: Transport::Radiance,
            angles: self.angles.into(),
        };
        let passes = front.closure().refraction();
        let sides: &[bool] = if passes.is_some() { &[true, false] } else { &[true] };
        let refracts = passes.is_some_and(|eta| eta != 1.0);
        let both: &[Transport] =
            if refracts { &[Transport::Radiance, Transport::Importance] } else { &[Transport::Radiance] };
        for &side in sides {
            for &transport in both {
                self.out.push(Case { front: side, transport, ..front.clone() });
            }
        }
    }
}

impl Case {
    /// The closure that is tested.
    pub fn closure(&self) -> Closure {
        self.closure_from(self.front)
    }

    /// The closure of the other side.
    pub fn other_side(&self) -> Closure {
        self.closure_from(!self.front)
    }

    fn closure_from(&self, front: bool) -> Closure {
        self.model.closure(&Incidence { front, transport: self.transport, ..Default::default() })
    }

    /// The parameters that are not the defaults, as a user would write them.
    pub fn parameters(&self) -> String {
        let changed = |p: &crate::model::Parameter| {
            let value = self.model.get(p.name)?;
            (value != p.default).then(|| format!("{}={}", p.name, text(value)))
        };
        self.model.parameters().iter().filter_map(changed).collect::<Vec<_>>().join(" ")
    }

    /// Everything that tells it from other cases, in words.
    pub fn label(&self) -> String {
        let mut out = format!("{} {}", self.model.name(), self.variant);
        for (name, value) in [("roughness", self.roughness), ("anisotropy", self.anisotropy)] {
            if let Some(v) = value {
                out += &format!(", {name} {v}");
            }
        }
        if self.closure().refraction().is_some() {
            out += if self.front { ", from outside" } else { ", from inside" };
            if self.transport == Transport::Importance {
                out += ", importance";
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_combination_is_one_of_its_model() {
        for (model, what, parameters) in NAMED {
            let Ok(mut m) = Model::by_name(model) else { panic!("{what}: there is no model {model}") };
            for (name, value) in *parameters {
                m.set_text(name, value).unwrap_or_else(|e| panic!("{what}: {e}"));
            }
        }
    }

    #[test]
    fn the_full_grid_is_what_it_says() {
        for name in Model::NAMES {
            let model = Model::by_name(name).expect("listed");
            let all = cases(&model, &Settings::full());
            let grid =
                all.iter().filter(|c| c.variant == "grid" && c.front && c.transport == Transport::Radiance);
            let roughness = if roughness_name(&model).is_some() { 6 } else { 1 };
            let anisotropy = if anisotropy_name(&model).is_some() { 3 } else { 1 };
            assert_eq!(grid.count(), roughness * anisotropy, "{name}");
            assert!(all.iter().all(|c| c.angles.len() == 5));
        }
    }
}
