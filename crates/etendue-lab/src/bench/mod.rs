//! The plots of one model: what its lobe looks like, what it is made of, and how well it is sampled.

mod albedo;
mod loss;
mod sampling;
mod slice;
mod sphere;
mod terms;

use crate::draw::Drawing;
use etendue_bxdf::{
    Bsdf,
    laws::cases::text,
    model::{Closure, Incidence, Model, Transport, Value},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// One plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What it is called, as a file's name without ending.
    pub name: &'static str,
    /// The drawing.
    pub drawing: Drawing,
}

/// What is plotted, and how to plot it again.
pub(crate) struct Subject<'a> {
    pub model: &'a Model,
    pub command: &'a str,
}

impl Subject<'_> {
    /// The closure for light that arrives from outside and a path from the camera.
    pub fn closure(&self) -> Closure {
        self.model.closure(&Incidence::default())
    }

    /// The closure whose albedo is a part of the energy; see [`etendue_bxdf::laws::furnace`].
    pub fn power(model: &Model) -> Closure {
        model.closure(&Incidence { transport: Transport::Importance, ..Incidence::default() })
    }

    /// The parameters that were changed, and the command: the last lines of every plot.
    pub fn caption(&self, what: &str) -> String {
        let changed: Vec<String> = self
            .model
            .parameters()
            .iter()
            .filter_map(|p| {
                let value = self.model.get(p.name)?;
                (value != p.default).then(|| format!("{}={}", p.name, text(value)))
            })
            .collect();
        let parameters = if changed.is_empty() { "default parameters".into() } else { changed.join(" ") };
        format!("{what} Model {}, {parameters}. Made by: {}", self.model.name(), self.command)
    }

    pub fn title(&self, what: &str) -> String {
        format!("{}: {what}", self.model.name())
    }
}

/// All plots that make sense for `model`; `command` is what a user would type to get them again.
///
/// Takes some seconds.
pub fn plots(model: &Model, command: &str) -> Vec<Plot> {
    let s = Subject { model, command };
    let mut out = vec![
        Plot { name: "slice", drawing: slice::plot(&s) },
        Plot { name: "sphere", drawing: sphere::plot(&s) },
    ];
    out.extend(terms::plot(&s).map(|drawing| Plot { name: "terms", drawing }));
    out.push(Plot { name: "albedo", drawing: albedo::plot(&s) });
    out.push(Plot { name: "sampling", drawing: sampling::plot(&s) });
    out.extend(loss::plot(&s).map(|drawing| Plot { name: "loss", drawing }));
    out
}

/// The mean of red, green and blue.
pub(crate) fn mean(s: Spectrum) -> f64 {
    let [r, g, b] = s.to_rgb();
    (r as f64 + g as f64 + b as f64) / 3.0
}

/// The direction at an angle to the normal in the plane of x and z: positive towards +x, beyond ±90° below the surface.
pub(crate) fn in_plane(degrees: f64) -> Vec3A {
    let (sin, cos) = degrees.to_radians().sin_cos();
    vec3a(sin as f32, 0.0, cos as f32)
}

/// The angles within the plane at which a closure's lobes may peak for `wo` at `degrees`: the mirror direction's, Snell's,
/// straight on, and back.
pub(crate) fn peaks(closure: &Closure, degrees: f64) -> Vec<f64> {
    let mut out = vec![-degrees, degrees];
    if let Some(eta) = closure.refraction() {
        let sin = degrees.to_radians().sin() / eta as f64;
        if sin < 1.0 {
            out.push(sin.asin().to_degrees() - 180.0);
        }
        out.push(degrees - 180.0);
    }
    out
}

/// `model` with its grid's roughness set; `None` if it has none.
pub(crate) fn with_roughness(model: &Model, roughness: f32) -> Option<Model> {
    let name = etendue_bxdf::laws::cases::roughness_name(model)?;
    let mut m = *model;
    m.set(name, Value::Number(roughness)).then_some(m)
}
