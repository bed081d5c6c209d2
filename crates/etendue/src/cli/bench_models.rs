//! `etendue bench models`: nanoseconds of each model's verbs.

use crate::bxdf::laws::{Rng, cases, cases::Settings};
use crate::bxdf::model::{Incidence, Model};
use crate::bxdf::sampling::{cosine_hemisphere, uniform_sphere};
use crate::bxdf::{Bsdf, MetalRough};
use glam::Vec3A;
use std::hint::black_box;
use std::time::Instant;

/// What one model costs, in nanoseconds a call.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Cost {
    pub model: &'static str,
    /// Bytes of the closure; of the models' common type, which is as large as the largest, for all but the first.
    pub bytes: usize,
    pub closure: f64,
    pub eval_pdf: f64,
    pub sample: f64,
}

/// Directions and numbers of one measurement.
const N: usize = 1024;

/// Measures every model whose name contains `filter`, over random parameters: all of a model's features at once. The first
/// row is the common material as a path has it, without the type that holds any model.
pub(crate) fn measure(filter: &str, seconds: f64) -> Vec<Cost> {
    let mut out = Vec::new();
    if "metal-rough".contains(filter) {
        out.push(plain(seconds));
    }
    for name in Model::NAMES.iter().filter(|n| n.contains(filter)) {
        let Ok(model) = Model::by_name(name) else { continue };
        let settings = Settings { random: 16, ..Settings::quick() };
        let random: Vec<Model> = cases::cases(&model, &settings)
            .into_iter()
            .filter(|c| c.variant.starts_with("random") && c.front)
            .map(|c| c.model)
            .collect();
        let models: Vec<Model> =
            (0..N).map(|i| random.get(i % random.len().max(1)).copied().unwrap_or(model)).collect();
        let at = Incidence::default();
        let make = |i: usize| models[i].closure(&at);
        let bytes = size_of::<crate::bxdf::model::Closure>();
        out.push(verbs(model.name(), bytes, seconds, make));
    }
    out
}

fn plain(seconds: f64) -> Cost {
    let mut rng = Rng::new(1);
    let params: Vec<_> = (0..N)
        .map(|_| crate::bxdf::MetalRoughParams {
            base_color: crate::color::Spectrum::rgb(rng.uniform(), rng.uniform(), rng.uniform()),
            metallic: rng.uniform(),
            roughness: rng.uniform(),
            ..Default::default()
        })
        .collect();
    verbs("metal-rough, plain", size_of::<MetalRough>(), seconds, |i| MetalRough::new(&params[i]))
}

fn verbs<B: Bsdf>(model: &'static str, bytes: usize, seconds: f64, make: impl Fn(usize) -> B) -> Cost {
    let mut rng = Rng::new(7);
    let wo: Vec<Vec3A> = (0..N).map(|_| cosine_hemisphere(rng.square())).collect();
    let u: Vec<[f32; 3]> = (0..N).map(|_| [rng.uniform(), rng.uniform(), rng.uniform()]).collect();
    let closures: Vec<B> = (0..N).map(&make).collect();
    let wi: Vec<Vec3A> = (0..N)
        .map(|i| {
            let d = uniform_sphere([u[i][1], u[i][2]]);
            // Where nothing passes the far side costs nothing, and would make the mean too good.
            if closures[i].refraction().is_none() { Vec3A::new(d.x, d.y, d.z.abs()) } else { d }
        })
        .collect();
    let part = seconds / 3.0;
    Cost {
        model,
        bytes,
        closure: nanoseconds(part, |i| {
            black_box(make(i));
            0.0
        }),
        eval_pdf: nanoseconds(part, |i| {
            let e = closures[i].eval_pdf(wo[i], wi[i]);
            e.diffuse[0] + e.specular[1] + e.pdf
        }),
        sample: nanoseconds(part, |i| {
            let s = closures[i].sample(wo[i], u[i][0], [u[i][1], u[i][2]]);
            s.map_or(0.0, |s| s.weight[0] + s.pdf)
        }),
    }
}

/// The best of the runs over all inputs that fit into `seconds`: what the code costs when nothing else runs.
fn nanoseconds(seconds: f64, mut call: impl FnMut(usize) -> f32) -> f64 {
    let begun = Instant::now();
    let mut best = f64::INFINITY;
    while best.is_infinite() || begun.elapsed().as_secs_f64() < seconds {
        let start = Instant::now();
        black_box((0..N).map(&mut call).sum::<f32>());
        best = best.min(start.elapsed().as_secs_f64());
    }
    best / N as f64 * 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_has_a_cost() {
        let all = measure("", 1e-4);
        assert_eq!(all.len(), Model::NAMES.len() + 1);
        assert!(all.iter().all(|c| c.closure > 0.0 && c.eval_pdf > 0.0 && c.sample > 0.0));
        assert!(measure("no such model", 1e-4).is_empty());
    }
}
