//! No input breaks a model: whatever its parameters and the directions are, what comes out is finite and not negative.

use super::Rng;
use crate::{
    bsdf::Bsdf,
    model::{Incidence, Model, Transport, Value},
};
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};

/// Numbers at which formulas tend to break.
const ODD: [f32; 14] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN_POSITIVE,
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-30,
    1e30,
    1e-7,
    0.01,
    0.999_999_94,
];

/// Asks `model` with random and degenerate parameters, directions and random numbers, `tries` times; the first answer that
/// is not finite or negative, in words. `None` if there is none.
pub fn finite(model: &Model, tries: usize, seed: u64) -> Option<String> {
    let mut rng = Rng::new(seed);
    (0..tries).find_map(|i| once(model, i, &mut rng))
}

/// A number of `range`, or an odd one.
fn number(rng: &mut Rng, range: [f32; 2], odd: f32) -> f32 {
    if rng.uniform() < odd {
        return ODD[(rng.bits() % ODD.len() as u64) as usize];
    }
    let [low, high] = range.map(|v| v.clamp(-1e6, 1e6));
    low + (high - low) * rng.uniform()
}

/// Any parameters: odd values in some tries, values of their ranges in others.
pub(super) fn shake(model: &Model, odd: f32, rng: &mut Rng) -> Model {
    let mut model = *model;
    for p in model.parameters() {
        let value = match p.default {
            Value::Number(_) => Value::Number(number(rng, p.range, odd)),
            Value::Color(_) => Value::Color(core::array::from_fn(|_| number(rng, p.range, odd))),
            Value::Vector(_) => Value::Vector(core::array::from_fn(|_| number(rng, [-1.0, 1.0], odd))),
            Value::Flag(_) => Value::Flag(rng.bits() & 1 == 1),
            Value::Choice(_) => Value::Choice(p.choices[(rng.bits() % p.choices.len() as u64) as usize]),
        };
        model.set(p.name, value);
    }
    model
}

fn once(model: &Model, i: usize, rng: &mut Rng) -> Option<String> {
    let model = shake(model, [0.0, 0.1, 0.4][i % 3], rng);
    let at = Incidence {
        front: rng.bits() & 1 == 1,
        exterior_ior: number(rng, [1.0, 2.0], 0.2),
        transport: if rng.bits() & 1 == 1 { Transport::Radiance } else { Transport::Importance },
        lane: [None, Some(0), Some(1), Some(2), Some(3), Some(200)][(rng.bits() % 6) as usize],
    };
    let direction = |rng: &mut Rng| {
        let v = vec3a(
            number(rng, [-1.0, 1.0], 0.2),
            number(rng, [-1.0, 1.0], 0.2),
            number(rng, [-1.0, 1.0], 0.2),
        );
        // Unit vectors, as the contract asks, grazing and upright ones among them; now and then what is left of one when
        // something before went wrong: not a number, or of another length.
        match rng.bits() % 8 {
            0 => v.clamp(Vec3A::NEG_ONE, Vec3A::ONE),
            1 => vec3a(v.x, v.y, v.z * 1e-4).normalize_or(Vec3A::X),
            2 => vec3a(v.x * 1e-4, v.y * 1e-4, 1.0).normalize_or(Vec3A::Z),
            _ => v.normalize_or(Vec3A::Z),
        }
    };
    let (wo, wi) = (direction(rng), direction(rng));
    // Random numbers of a caller lie in 0..1, 0 and the last number before 1 among them.
    let unit = |rng: &mut Rng| match rng.bits() % 8 {
        0 => 0.0,
        1 => 1.0f32.next_down(),
        _ => rng.uniform(),
    };
    let (uc, u) = (unit(rng), [unit(rng), unit(rng)]);

    let bsdf = model.closure(&at);
    let ok = |s: Spectrum| s.is_finite() && s.0.iter().all(|&v| v >= 0.0);
    let told = |what: &str, of: String| {
        Some(format!("{what} = {of} for {model:?}, {at:?}, wo {wo:?}, wi {wi:?}, random {uc} {u:?}"))
    };
    let e = bsdf.eval_pdf(wo, wi);
    if !(ok(e.diffuse) && ok(e.specular) && e.pdf.is_finite() && e.pdf >= 0.0) {
        return told("eval_pdf", format!("{e:?}"));
    }
    let below = !(wo.z > 0.0);
    if below && e != crate::Eval::ZERO {
        return told("eval_pdf from below", format!("{e:?}"));
    }
    if !ok(bsdf.albedo(wo)) {
        return told("albedo", format!("{:?}", bsdf.albedo(wo)));
    }
    for d in bsdf.deltas(wo).into_iter().flatten().filter(|_| wo.is_finite()) {
        if !(ok(d.reflectance) && (0.0..=1.0).contains(&d.probability) && d.wi.is_finite()) {
            return told("deltas", format!("{d:?}"));
        }
    }
    if let Some(eta) = bsdf.refraction().filter(|&eta| !(eta > 0.0 && eta.is_finite())) {
        return told("refraction", format!("{eta}"));
    }
    if let Some(s) = bsdf.sample(wo, uc, u) {
        let right = ok(s.weight) && ok(s.weight_diffuse) && ok(s.weight_specular);
        if below || !(right && s.pdf > 0.0 && s.pdf.is_finite() && s.wi.is_finite()) {
            return told("sample", format!("{s:?}"));
        }
    }
    None
}
