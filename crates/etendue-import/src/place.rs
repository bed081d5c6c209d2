//! Cameras and lights where their nodes put them.

use crate::document::{self, LightShape};
use crate::nodes::without_scale;
use crate::warning::Warnings;
use etendue_scene::{Camera, Light, LightKind, Projection};
use glam::{Affine3A, DAffine3, DVec3, Mat3A, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// The object's name, or else its node's.
fn name(own: &str, node: &str) -> String {
    if own.is_empty() { node.to_owned() } else { own.to_owned() }
}

/// Camera `c` on a node that stands at `m`; `None`, with a warning, if it cannot take a picture.
pub(crate) fn camera(
    c: &document::Camera<'_>,
    pointer: &str,
    node: &str,
    m: &DAffine3,
    warnings: &mut Warnings,
) -> Option<Camera> {
    let mut skip = |why: &str| {
        warnings.add(pointer, format!("{why}; the camera is left out"));
        None
    };
    let translation = m.translation.as_vec3a();
    let Some(rotation) = without_scale(m).filter(|r| r.is_finite() && translation.is_finite()) else {
        return skip("stands nowhere: its transform is flat or not finite");
    };
    let (projection, aspect) = match c.projection {
        document::Projection::Perspective { yfov, aspect } => {
            let yfov = yfov as f32;
            if !(yfov > 1e-4 && yfov < PI - 1e-4) {
                return skip("yfov is not between 0 and π");
            }
            (Projection::Perspective { yfov }, aspect.map(|a| a as f32))
        }
        document::Projection::Orthographic { xmag, ymag } => {
            let (xmag, ymag) = (xmag.abs() as f32, ymag.abs() as f32);
            if !(ymag > 0.0 && ymag.is_finite()) {
                return skip("ymag is 0");
            }
            (Projection::Orthographic { ymag }, Some(xmag / ymag))
        }
    };
    Some(Camera {
        name: name(c.name, node),
        transform: Affine3A {
            matrix3: Mat3A::from_cols(
                rotation.x_axis.as_vec3a(),
                rotation.y_axis.as_vec3a(),
                rotation.z_axis.as_vec3a(),
            ),
            translation,
        },
        projection,
        aspect: aspect.filter(|a| *a > 1e-6 && *a < 1e6),
    })
}

/// Light `l` on a node that stands at `m`; `None`, with a warning, if it cannot shine.
pub(crate) fn light(
    l: &document::Light<'_>,
    pointer: &str,
    node: &str,
    m: &DAffine3,
    warnings: &mut Warnings,
) -> Option<Light> {
    let position = m.translation.as_vec3();
    // The scale of the node does not reach the light (KHR_lights_punctual), but its axes do.
    let direction = m.matrix3 * DVec3::NEG_Z;
    let direction = direction.try_normalize().map(|d| d.as_vec3());
    let intensity = Vec3::from_array(l.color.map(|c| (c * l.intensity) as f32));
    if intensity.min_element() < 0.0 {
        warnings.add(pointer, "negative intensity; taken as 0");
    }
    let kind = match l.shape {
        LightShape::Unknown => return None,
        LightShape::Directional => LightKind::Directional,
        LightShape::Point => LightKind::Point,
        LightShape::Spot { inner, outer } => {
            let (i, o) = (inner as f32, outer as f32);
            // The fall-off divides by the difference of the cosines.
            let outer = o.clamp(1e-3, FRAC_PI_2);
            let inner = i.clamp(0.0, outer - 5e-4);
            if (o - outer).abs() > 1e-5 || (i - inner).abs() > 1e-3 {
                warnings.add(pointer, "cone angles outside 0 ≤ inner < outer ≤ π/2; clamped");
            }
            LightKind::Spot { inner, outer }
        }
    };
    let direction = match (direction, kind) {
        (Some(d), _) => d,
        (None, LightKind::Point) => Vec3::NEG_Z,
        (None, _) => {
            warnings.add(pointer, "points nowhere: its node's transform is flat; the light is left out");
            return None;
        }
    };
    let range = l.range.map(|r| r as f32);
    if range.is_some_and(|r| r <= 0.0) {
        warnings.add(pointer, "range is not above 0; taken as unlimited");
    }
    let light = Light {
        name: name(l.name, node),
        kind,
        intensity: intensity.max(Vec3::ZERO),
        position,
        direction,
        range: range.filter(|r| *r > 0.0 && r.is_finite() && kind != LightKind::Directional),
    };
    if !light.is_finite() {
        warnings.add(pointer, "a value is not finite; the light is left out");
        return None;
    }
    Some(light)
}
