//! What a path is inside of.

use crate::body::Body;
use etendue_bxdf::math::exp;
use etendue_bxdf::model::{Interior, Scatter};
use etendue_color::Spectrum;

/// The closed surfaces that a path has entered and not left, as their materials, in the order of entering.
///
/// Where they overlap the one with the highest priority fills the space, among equals the one entered last; the borders
/// of the others are not there (Schmidt, Budge 2002, "Simple Nested Dielectrics in Ray Traced Images").
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Media {
    materials: [u32; MOST],
    count: u8,
    /// The mottled body that was entered last, and how it scatters there (`None`: not at all).
    mottled: Option<(u32, Option<Scatter>)>,
}

/// Overlapping bodies that a path can be inside of; further ones are taken for empty.
const MOST: usize = 8;

impl Media {
    /// Position in the list of the medium that fills the space.
    #[inline]
    fn current(&self, bodies: &[Body]) -> Option<usize> {
        let priority =
            |i: &usize| bodies[self.materials[*i] as usize].interior.map_or(i32::MIN, |m| m.priority);
        // Of equals the last.
        (0..self.count as usize).max_by_key(priority)
    }

    #[inline]
    fn interior(&self, bodies: &[Body], at: usize) -> Option<Interior> {
        bodies[self.materials[at] as usize].interior
    }

    /// True if the border of a body is inside one that has precedence, so that light passes it as if it were not there.
    #[inline]
    pub fn hides(&self, bodies: &[Body], material: u32, front: bool) -> bool {
        let Some(current) = self.current(bodies) else { return false };
        if front {
            let own = bodies[material as usize].interior.map_or(i32::MIN, |m| m.priority);
            self.interior(bodies, current).is_some_and(|m| m.priority > own)
        } else {
            // A body that was never entered (the camera stands in it) is left visibly.
            self.materials[..self.count as usize].contains(&material) && self.materials[current] != material
        }
    }

    /// Index of refraction around a body whose border is met: of what is outside it.
    #[inline]
    pub fn exterior_ior(&self, bodies: &[Body], material: u32, front: bool) -> f32 {
        let mut outside = *self;
        if !front {
            outside.leave(material);
        }
        outside.current(bodies).and_then(|i| outside.interior(bodies, i)).map_or(1.0, |m| m.ior)
    }

    /// The path passes the border of a body.
    #[inline]
    pub fn cross(&mut self, material: u32, front: bool) {
        if !front {
            self.leave(material);
        } else if (self.count as usize) < MOST {
            self.materials[self.count as usize] = material;
            self.count += 1;
        }
    }

    #[inline]
    fn leave(&mut self, material: u32) {
        let count = self.count as usize;
        if let Some(i) = self.materials[..count].iter().rposition(|m| *m == material) {
            self.materials.copy_within(i + 1..count, i);
            self.count -= 1;
        }
    }

    /// Extinction and scattering of the medium that fills the space, if it scatters.
    #[inline]
    pub fn scatters(&self, bodies: &[Body]) -> Option<(Spectrum, Scatter)> {
        let at = self.current(bodies)?;
        let m = self.interior(bodies, at)?;
        let scatter = match self.mottled {
            Some((material, there)) if material == self.materials[at] => there,
            _ => m.scatter,
        };
        scatter.map(|s| (m.absorption, s))
    }

    /// The path has entered a mottled body where it scatters so.
    #[inline]
    pub fn enter_mottled(&mut self, material: u32, scatter: Option<Scatter>) {
        self.mottled = Some((material, scatter));
    }

    /// What is left of light that goes straight on after a distance.
    #[inline]
    pub fn transmittance(&self, bodies: &[Body], distance: f32) -> Spectrum {
        let Some(m) = self.current(bodies).and_then(|i| self.interior(bodies, i)) else {
            return Spectrum::ONE;
        };
        if m.absorption.is_black() {
            return Spectrum::ONE;
        }
        m.absorption.map(|a| exp(-a * distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bodies(priorities: &[i32]) -> Vec<Body> {
        let interior = |(i, &priority): (usize, &i32)| Interior {
            ior: 1.1 + i as f32 * 0.1,
            absorption: Spectrum::splat(i as f32),
            scatter: None,
            priority,
            dispersive: false,
        };
        priorities
            .iter()
            .enumerate()
            .map(|p| Body { interior: Some(interior(p)), ..Body::default() })
            .collect()
    }

    /// Water that reaches into the wall of its glass: the wall's inner border is the visible one if glass goes first.
    #[test]
    fn the_higher_priority_fills_the_overlap() {
        let b = bodies(&[0, 5]);
        let (water, glass) = (0, 1);
        let mut m = Media::default();
        assert!(!m.hides(&b, glass, true));
        assert_eq!(m.exterior_ior(&b, glass, true), 1.0);
        m.cross(glass, true);
        assert!(m.hides(&b, water, true), "water begins inside the glass");
        m.cross(water, true);
        assert!(!m.hides(&b, glass, false), "the glass ends");
        assert_eq!(m.exterior_ior(&b, glass, false), 1.1, "behind it is water");
        m.cross(glass, false);
        assert!(!m.hides(&b, water, false));
        assert_eq!(m.exterior_ior(&b, water, false), 1.0);
        m.cross(water, false);
        assert_eq!(m.current(&b), None);
    }

    #[test]
    fn among_equals_the_last_one_entered_fills_the_space() {
        let b = bodies(&[0, 0]);
        let mut m = Media::default();
        m.cross(0, true);
        assert!(!m.hides(&b, 1, true));
        m.cross(1, true);
        assert!(m.hides(&b, 0, false), "0 ends inside 1");
        m.cross(0, false);
        assert!((m.transmittance(&b, 2.0)[0] - (-2.0f32).exp()).abs() < 1e-6);
        assert!(!m.hides(&b, 1, false));
    }

    #[test]
    fn surfaces_that_do_not_close_break_nothing() {
        let b = bodies(&[0]);
        let mut m = Media::default();
        m.cross(0, false);
        assert_eq!(m.count, 0);
        for _ in 0..100 {
            m.cross(0, true);
        }
        assert_eq!(m.count as usize, MOST);
        assert_eq!(m.transmittance(&b, 1.0), Spectrum::ONE);
    }
}
