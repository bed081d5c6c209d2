//! Light from rectangles, disks and spheres.
//!
//! Specular light by linearly transformed cosines ([`crate::ltc`]), diffuse light by the form factor, with what the specular layer
//! lets in taken at the mean direction of what is seen. Circles are polygons of 24 corners and the same area, spheres the disk that
//! covers the same directions.

use crate::choices::{Area, Choices};
use crate::direct::{coupled, over_pi};
use crate::gloss::{Gloss, mirror};
use crate::inputs::Inputs;
use crate::light::{AreaLight, AreaShape};
use crate::ltc::LtcTable;
use crate::polygon::Polygon;
use crate::surface::{Surface, table};
use etendue_bxdf::fresnel::schlick_weight;
use etendue_bxdf::sampling::basis;
use etendue_color::Spectrum;
use glam::{Vec3A, vec3a};
use std::f32::consts::PI;

/// The reflected part of a light's radiance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub diffuse: Spectrum,
    pub specular: Spectrum,
    pub passing: Spectrum,
}

/// The light in the surface's frame, seen from the point; `None` if it shines away or the point lies within it.
fn polygon(light: &AreaLight, inputs: &Inputs) -> Option<Polygon> {
    let f = &inputs.frame;
    let center = Vec3A::from(light.center) - inputs.position;
    let local = |v: Vec3A| f.to_local(v);
    let faces = |x: Vec3A, y: Vec3A| light.two_sided || x.cross(y).dot(center) < 0.0;
    match light.shape {
        AreaShape::Rectangle { x, y } => {
            let (x, y) = (Vec3A::from(x), Vec3A::from(y));
            faces(x, y).then(|| Polygon::quad(local(center), local(x), local(y)))
        }
        AreaShape::Disk { x, y } => {
            let (x, y) = (Vec3A::from(x), Vec3A::from(y));
            faces(x, y).then(|| Polygon::ellipse(local(center), local(x), local(y)))
        }
        AreaShape::Sphere { radius } => {
            let d2 = center.length_squared();
            let part = 1.0 - radius * radius / d2;
            if !(part > 0.0 && radius > 0.0) {
                return None;
            }
            let (x, y) = basis(center * (1.0 / d2.sqrt()));
            let r = radius * part.sqrt();
            Some(Polygon::ellipse(local(center * part), local(x * r), local(y * r)))
        }
    }
}

/// The part of a lobe of F = 1 and albedo 1 that the polygon fills.
fn lobe_filled(gloss: &Gloss, p: &Polygon, ltc: &LtcTable) -> f32 {
    let wo = gloss.wo;
    let transform = ltc.at(gloss.roughness, wo.z);
    // The frame whose x points away from the viewer.
    let len = (wo.x * wo.x + wo.y * wo.y).sqrt();
    let (x, y) = if len > 1e-6 { (-wo.x / len, -wo.y / len) } else { (1.0, 0.0) };
    let above = p.above();
    let straight = above.map(|v| transform.straighten(vec3a(v.x * x + v.y * y, v.y * x - v.x * y, v.z)));
    straight.form_factor().z * transform.inv_above()
}

/// The part of the light's radiance that the surface sends to the viewer; `None` if none.
pub(crate) fn patch(
    s: &Surface,
    inputs: &Inputs,
    light: &AreaLight,
    ltc: &LtcTable,
    choices: &Choices,
) -> Option<Patch> {
    let p = polygon(light, inputs)?;
    let wo = s.gloss.wo;
    let mut out = Patch { diffuse: Spectrum::ZERO, specular: Spectrum::ZERO, passing: Spectrum::ZERO };
    let seen = p.form_factor();
    if seen.z > 0.0 {
        let middle = seen.normalize_or_zero();
        let cos = 0.5 * (wo + middle).length();
        let f = s.fresnel(cos, schlick_weight(cos));
        out.diffuse += s.matte[0] * coupled(s, middle, f, choices) * (seen.z * PI * over_pi(choices));
        if !s.bounces.wide.is_black() {
            let lost = s.bounces.lost * s.bounces.loss.directional(middle.z);
            out.specular += s.bounces.wide * (lost * seen.z * PI);
        }
        if let Some(layers) = &s.layers {
            out.diffuse += layers.fibres_value(wo, middle) * (seen.z * PI);
            out.diffuse *= layers.tint_at(wo, middle) * layers.over;
            out.diffuse += layers.top_value(wo, middle) * (seen.z * PI);
        }
        let [a, b] = s.bounces.scale;
        let d = table(&s.gloss);
        let reflectance = match &s.film {
            None => s.f0 * a * d.scale + b * (s.f90 * d.bias),
            Some(_) => s.fresnel(wo.z, s.gloss.directional(wo).w) * a * d.energy(),
        };
        let filled = match choices.area {
            Area::Ltc => lobe_filled(&s.gloss, &p, ltc),
            Area::Representative => representative(&s.gloss, inputs, light, choices),
        };
        out.specular += reflectance * filled;
        out.specular *= s.veil()[0] * s.below_layers();
        if let Some((coat, gloss)) =
            s.layers.as_ref().and_then(|l| l.coat.as_ref()).and_then(|c| c.gloss.as_ref().map(|g| (c, g)))
        {
            let d = table(gloss);
            let [f0, f90] = coat.ends();
            let own = p.map(|v| coat.local(v));
            let filled = lobe_filled(gloss, &own, ltc);
            let over = s.layers.as_ref().map_or(1.0, |l| l.over);
            out.specular += Spectrum::splat((f0 * d.scale + f90 * d.bias) * (filled * over));
        }
    }
    if !s.matte[1].is_black() || s.passing.is_some() {
        let turned = p.map(|v| vec3a(v.x, v.y, -v.z));
        let seen = turned.form_factor();
        if seen.z > 0.0 {
            let middle = seen.normalize_or_zero();
            let f = s.fresnel(wo.z, schlick_weight(wo.z));
            let [mirrored, scattered] = s.veil();
            let kd = coupled(s, middle, f, choices) * scattered;
            out.diffuse += s.matte[1] * kd * (seen.z * PI * over_pi(choices));
            if let Some(t) = s.passing.as_ref().filter(|t| !t.is_solid()) {
                let filled = lobe_filled(t.gloss(), &turned, ltc);
                out.passing += t.reflectance(s) * mirrored * (filled * s.below_layers());
            }
        }
    }
    Some(out)
}

/// The part of a lobe of F = 1 and albedo 1 that a light fills, by one point of it (Karis 2013, section "Area lights"): the one nearest
/// to the mirror direction, with the lobe widened by the light's size and its peak lowered for that.
fn representative(gloss: &Gloss, inputs: &Inputs, light: &AreaLight, choices: &Choices) -> f32 {
    let f = &inputs.frame;
    let to = f.to_local(Vec3A::from(light.center) - inputs.position);
    let r = mirror(gloss.wo);
    let distance = to.length();
    let (point, area, cos) = match light.shape {
        AreaShape::Sphere { radius } => {
            let across = r * to.dot(r) - to;
            let near = to + across * (radius / across.length().max(1e-9)).min(1.0);
            (near, PI * radius * radius, 1.0)
        }
        AreaShape::Rectangle { x, y } | AreaShape::Disk { x, y } => {
            let (x, y) = (f.to_local(x.into()), f.to_local(y.into()));
            let n = x.cross(y).normalize_or_zero();
            // Where the mirror direction meets the light's plane, or far along it where it does not.
            let t = to.dot(n) / r.dot(n);
            let hit = if t > 0.0 && t < 1e9 { r * t } else { to + r * 1e3 };
            let (u, v) = ((hit - to).dot(x) / x.length_squared(), (hit - to).dot(y) / y.length_squared());
            let round = matches!(light.shape, AreaShape::Disk { .. });
            let (u, v) = if round {
                let len = (u * u + v * v).sqrt().max(1.0);
                (u / len, v / len)
            } else {
                (u.max(-1.0).min(1.0), v.max(-1.0).min(1.0))
            };
            let area = x.length() * y.length() * if round { PI } else { 4.0 };
            (to + x * u + y * v, area, n.dot(to).abs() / distance)
        }
    };
    let wi = point.normalize_or_zero();
    if !(wi.z > 0.0) {
        return 0.0;
    }
    let alpha = gloss.roughness * gloss.roughness;
    let size = (area / PI).sqrt() / distance;
    let wider = (alpha + 0.5 * size).min(1.0);
    let lowered = (alpha / wider) * (alpha / wider);
    let solid_angle = (area * cos / (distance * distance)).min(2.0 * PI);
    let (_, value) = gloss.lobe(wi, choices.masking);
    let energy = table(gloss).energy().max(1e-6);
    let filled = value * wi.z * solid_angle * lowered / energy;
    if filled < f32::INFINITY { filled } else { 0.0 }
}
