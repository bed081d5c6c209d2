//! Probes that stand in a room: reflections with parallax, and from two probes.

use etendue_color::Spectrum;
use glam::{Affine3A, Vec3A};

use crate::cube_lookup::CubeLookup;

/// The volume that a probe's picture is taken to lie on: a box.
///
/// A cube map alone is infinitely far away. Cutting the reflected ray with the box, and looking from the probe's place at the point that is
/// hit, makes walls stay where they are (Lagarde, Zanuttini 2012, "Local Image-based Lighting With Parallax-corrected Cubemap").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeBox {
    /// From the world into the box's own frame, in which it is −1..1 on each axis.
    to_unit: Affine3A,
    /// Where the probe's picture was taken, in the world.
    centre: Vec3A,
}

impl ProbeBox {
    /// A box by the transform that brings the cube −1..1 to it, and the place of the probe. `None` if the transform has no inverse.
    pub fn new(unit_to_world: Affine3A, centre: Vec3A) -> Option<Self> {
        let to_unit = unit_to_world.inverse();
        (to_unit.is_finite() && centre.is_finite()).then_some(Self { to_unit, centre })
    }

    /// A box along the world's axes between two corners.
    pub fn aligned(min: Vec3A, max: Vec3A, centre: Vec3A) -> Option<Self> {
        let (half, middle) = ((max - min) * 0.5, (max + min) * 0.5);
        if !(half.min_element() > 0.0) {
            return None;
        }
        Self::new(Affine3A::from_translation(middle.into()) * Affine3A::from_scale(half.into()), centre)
    }

    /// The direction, not normalised, in which the probe sees what a ray from `position` along `direction` meets on the box;
    /// `direction` itself if the position is outside, or the ray never leaves.
    pub fn project(&self, position: Vec3A, direction: Vec3A) -> Vec3A {
        self.hit(position, direction).map_or(direction, |t| position + direction * t - self.centre)
    }

    /// Where the ray leaves the box, in lengths of `direction`.
    fn hit(&self, position: Vec3A, direction: Vec3A) -> Option<f32> {
        let p = self.to_unit.transform_point3a(position);
        let d = self.to_unit.transform_vector3a(direction);
        // A little outside is inside: surfaces lie on the box.
        if !(p.abs().max_element() <= 1.0 + 1e-3) {
            return None;
        }
        // Where each axis reaches the face that the ray goes towards; an axis along which it does not move never does.
        let along = |p: f32, d: f32| if d == 0.0 { f32::INFINITY } else { (d.signum() - p) / d };
        let t = along(p.x, d.x).min(along(p.y, d.y)).min(along(p.z, d.z));
        (t.is_finite() && t > 0.0).then_some(t)
    }

    /// 1 deep inside the box, falling to 0 at its faces over `margin` (a fraction of its half size), 0 outside: a probe's weight
    /// where several overlap.
    pub fn weight(&self, position: Vec3A, margin: f32) -> f32 {
        let inside = 1.0 - self.to_unit.transform_point3a(position).abs().max_element();
        if margin > 0.0 {
            (inside / margin).max(0.0).min(1.0)
        } else if inside >= 0.0 {
            1.0
        } else {
            0.0
        }
    }
}

/// A prefiltered cube, in a box or infinitely far away.
#[derive(Clone, Copy, Debug)]
pub struct Probe<'a> {
    /// What it shows.
    pub cube: &'a CubeLookup,
    /// Where it stands; `None` for a sky.
    pub volume: Option<ProbeBox>,
}

impl Probe<'_> {
    /// The light along `reflection` from `position` at a level of detail.
    pub fn radiance(&self, position: Vec3A, reflection: Vec3A, lod: f32) -> Spectrum {
        let d = self.volume.as_ref().map_or(reflection, |v| v.project(position, reflection));
        self.cube.trilinear(d, lod)
    }

    /// The weight of this probe at a place: that of its box, 1 for a sky.
    pub fn weight(&self, position: Vec3A, margin: f32) -> f32 {
        self.volume.as_ref().map_or(1.0, |v| v.weight(position, margin))
    }
}

/// Two probes: the first by its weight at `position`, the second for the rest.
pub fn blend(
    first: &Probe,
    second: &Probe,
    position: Vec3A,
    reflection: Vec3A,
    lod: f32,
    margin: f32,
) -> Spectrum {
    let weight = first.weight(position, margin);
    if weight >= 1.0 {
        return first.radiance(position, reflection, lod);
    }
    let rest = second.radiance(position, reflection, lod);
    if weight <= 0.0 { rest } else { rest.lerp(first.radiance(position, reflection, lod), weight) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cube::CubeMap;
    use etendue_bxdf::laws::Rng;
    use glam::{Quat, Vec3, vec3a};

    /// A box room whose walls' light is their place: from anywhere inside, along any direction, the corrected lookup gives the light of
    /// the point that the ray meets.
    #[test]
    fn walls_stay_where_they_are() {
        let (half, centre) = (vec3a(2.0, 1.0, 3.0), vec3a(0.5, -0.2, 1.0));
        let leave = |o: Vec3A, d: Vec3A| {
            let t = ((half * d.signum() - o) / d).min_element();
            o + d * t
        };
        let light = |p: Vec3A| Spectrum::rgb(3.0 + p.x, 3.0 + p.y, 4.0 + p.z);
        let cube = CubeLookup::new(&CubeMap::from_fn(128, |d| light(leave(centre, d))));
        let probe = Probe { cube: &cube, volume: ProbeBox::aligned(-half, half, centre) };
        let mut rng = Rng::new(2);
        for _ in 0..500 {
            let mut v = || vec3a(rng.uniform(), rng.uniform(), rng.uniform()) * 2.0 - Vec3A::ONE;
            let (p, d) = (v() * half * 0.98, v().normalize());
            let got = probe.radiance(p, d, 0.0);
            let error = (got - light(leave(p, d))).map(f32::abs).max_element();
            assert!(error < 0.06, "{p} {d}: {got:?}");
        }
    }

    #[test]
    fn turned_boxes_and_places_outside() {
        let turn = Quat::from_rotation_y(0.7);
        let to_world = Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 2.0, 3.0), turn, Vec3::X);
        let b = ProbeBox::new(to_world, Vec3A::X).unwrap();
        let along = Vec3A::from(turn * Vec3::Z);
        // From the middle, where the probe is, nothing changes but the length.
        assert!((b.project(Vec3A::X, along).normalize() - along).length() < 1e-5);
        assert!((b.project(Vec3A::X, along).length() - 3.0).abs() < 1e-4);
        assert_eq!(b.project(vec3a(9.0, 0.0, 0.0), along), along);
        assert!(b.project(Vec3A::X, Vec3A::NAN).is_nan());
        assert!(ProbeBox::aligned(Vec3A::ZERO, Vec3A::ZERO, Vec3A::ZERO).is_none());
        assert_eq!((b.weight(Vec3A::X, 0.2), b.weight(vec3a(9.0, 0.0, 0.0), 0.2)), (1.0, 0.0));
        assert!((b.weight(Vec3A::X + along * 2.7, 0.2) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn blending_goes_from_one_to_the_other() {
        let of = |v: f32| CubeLookup::new(&CubeMap::from_fn(2, |_| Spectrum::splat(v)));
        let (a, b) = (of(1.0), of(3.0));
        let room = Probe { cube: &a, volume: ProbeBox::aligned(-Vec3A::ONE, Vec3A::ONE, Vec3A::ZERO) };
        let sky = Probe { cube: &b, volume: None };
        let at = |x: f32| blend(&room, &sky, vec3a(x, 0.0, 0.0), Vec3A::Y, 0.0, 0.5)[0];
        assert_eq!([at(0.0), at(0.5), at(2.0)], [1.0, 1.0, 3.0]);
        assert!((at(0.75) - 2.0).abs() < 1e-6);
    }
}
