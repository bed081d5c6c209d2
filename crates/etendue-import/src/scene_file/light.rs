//! The lights of a scene file.

use super::check::{Checker, Entry};
use super::error::SceneFileError;
use super::key::Kind;
use super::place::{Field, field};
use etendue_scene::{Light, LightKind};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use std::ops::Range;

/// A light as it is written.
pub(crate) struct Lamp {
    kind: String,
    name: String,
    color: Vec3,
    intensity: f32,
    position: Vec3,
    direction: Option<Vec3>,
    target: Option<Vec3>,
    inner: f32,
    outer: f32,
    range: Option<f32>,
}

impl Default for Lamp {
    fn default() -> Self {
        Self {
            kind: String::new(),
            name: String::new(),
            color: Vec3::ONE,
            intensity: 1.0,
            position: Vec3::ZERO,
            direction: None,
            target: None,
            inner: 0.0,
            outer: 45.0,
            range: None,
        }
    }
}

/// What a `[[light]]` may say.
pub(crate) fn keys() -> Vec<Field<Lamp>> {
    let field = field::<Lamp>;
    vec![
        field("kind", Kind::choice(&["directional", "point", "spot"]), "Its shape: parallel light from infinitely far, light from a point, or light from a point within a cone", |l, v| {
            l.kind = v.text().into();
        }),
        field("name", Kind::Text, "A name for people", |l, v| l.name = v.text().into()),
        field("intensity", Kind::POSITIVE, "How bright: lux of a directional light on a surface that faces it, candela of a point or spot; on the scale of emissive surfaces, without 683 lm/W, as glTF viewers take it", |l, v| l.intensity = v.f32()).or("1"),
        field("color", Kind::Color, "Multiplies the intensity", |l, v| l.color = v.numbers().into()).or("[1, 1, 1]"),
        field("position", Kind::Vector, "Where a point or spot stands, metres", |l, v| l.position = v.numbers().into()).or("[0, 0, 0]"),
        field("direction", Kind::Vector, "Along which a directional light or spot shines, of any length", |l, v| l.direction = Some(v.numbers().into())).or("[0, -1, 0]"),
        field("target", Kind::Vector, "Instead of direction: the point that a spot shines at, metres", |l, v| l.target = Some(v.numbers().into())),
        field("inner", Kind::Number([0.0, 90.0]), "Degrees from a spot's axis where its light begins to fall off", |l, v| l.inner = v.f32()).or("0"),
        field("outer", Kind::Number([0.0, 90.0]), "Degrees from a spot's axis where its light ends", |l, v| l.outer = v.f32()).or("45"),
        field("range", Kind::POSITIVE, "Distance at which the light of a point or spot ends smoothly, metres [default: unlimited]", |l, v| l.range = Some(v.f32())),
    ]
}

/// Which kinds a key is for; all if it is not here.
const ONLY: [(&str, &[&str]); 6] = [
    ("position", &["point", "spot"]),
    ("direction", &["directional", "spot"]),
    ("target", &["spot"]),
    ("inner", &["spot"]),
    ("outer", &["spot"]),
    ("range", &["point", "spot"]),
];

/// The light that `entries` of the table at `span` make.
pub(crate) fn light(
    entries: &[Entry],
    fields: &[Field<Lamp>],
    span: &Range<usize>,
    c: &Checker<'_>,
) -> Result<Light, SceneFileError> {
    let mut lamp = Lamp::default();
    entries.iter().for_each(|e| (fields[e.key].set)(&mut lamp, &e.value));
    let of = |name: &str| entries.iter().find(|e| fields[e.key].key.name == name);
    if lamp.kind.is_empty() {
        let help = Some("add kind = \"directional\", \"point\" or \"spot\"".into());
        return Err(c.text.wrong(span, "a light does not say its kind", help));
    }
    for (name, kinds) in ONLY {
        if let (Some(e), false) = (of(name), kinds.contains(&&lamp.kind[..])) {
            return Err(c.text.wrong(&e.span, format!("a {} light has no `{name}`", lamp.kind), None));
        }
    }
    if let (Some(_), Some(e)) = (of("direction"), of("target")) {
        return Err(c.text.wrong(&e.span, "a light has either `direction` or `target`", None));
    }
    let direction = match (lamp.direction, lamp.target) {
        (Some(d), _) => d,
        (_, Some(t)) => t - lamp.position,
        _ => Vec3::NEG_Y,
    };
    // Divided by its largest part first, so that squares neither overflow nor vanish.
    let direction = (direction / direction.abs().max_element()).try_normalize();
    let Some(direction) = direction.filter(|d| d.is_finite()) else {
        let place = of("direction").or(of("target")).map_or(span, |e| &e.span);
        return Err(c.text.wrong(place, "the light points nowhere", None));
    };
    let kind = match &lamp.kind[..] {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        _ => {
            // As the importer of glTF: the fall-off divides by the difference of the cosines.
            let outer = lamp.outer.to_radians().clamp(1e-3, FRAC_PI_2);
            if lamp.inner >= lamp.outer {
                let place = of("inner").or(of("outer")).map_or(span, |e| &e.span);
                let message =
                    format!("`inner` ({}) has to be less than `outer` ({})", lamp.inner, lamp.outer);
                return Err(c.text.wrong(place, message, None));
            }
            LightKind::Spot { inner: lamp.inner.to_radians().clamp(0.0, outer - 5e-4), outer }
        }
    };
    let intensity = lamp.color * lamp.intensity;
    if !intensity.is_finite() {
        let place = of("intensity").or(of("color")).map_or(span, |e| &e.span);
        return Err(c.text.wrong(place, "the light is brighter than numbers can say", None));
    }
    Ok(Light {
        name: lamp.name,
        kind,
        intensity,
        position: lamp.position,
        direction,
        range: lamp.range.filter(|r| *r > 0.0),
    })
}
