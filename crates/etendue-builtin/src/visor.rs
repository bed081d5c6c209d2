//! The visor: one smooth mirror, bulging out of the opening.

use crate::form::{angles, cranium, direction, visor_angles};
use crate::shape::Mesh;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

const RINGS: u32 = 17;
const AROUND: u32 = 88;

/// Radius of the visor's outer face. The bulge is a polynomial in the angles, so that reflections run without a break.
pub fn visor_radius(d: Vec3) -> f32 {
    let a = angles(d);
    let (x, y) = (a.x / 1.25, (a.y - 0.09) / 0.55);
    cranium(d) - 0.0015 + 0.009 * (1.0 - x * x) * (1.0 - y * y)
}

/// The visor's mesh: rings around its centre. Texture coordinates: the angles, spread over the picture.
pub fn visor_mesh() -> Mesh {
    let mut m = Mesh::default();
    for j in 0..=RINGS {
        // A little closer towards the edge, where the surface turns faster.
        let t = (j as f32 / RINGS as f32).powf(0.9) * 1.03;
        for i in 0..=AROUND {
            let phi = TAU * (i % AROUND) as f32 / AROUND as f32;
            let a = visor_angles(phi, t);
            let d = direction(a.x, a.y);
            let uv = Vec2::new(0.5 + a.x / 2.9, 0.5 - (a.y - 0.10) / 1.3);
            m.push(d * visor_radius(d), crate::form::normal(d, visor_radius), uv, Vec3::new(a.x, a.y, t));
        }
    }
    // Rings run outward and the angle counter-clockwise seen from outside: u × v points inward, so connect by hand.
    let row = AROUND + 1;
    for j in 0..RINGS {
        for i in 0..AROUND {
            let (a, b) = (j * row + i, j * row + i + 1);
            m.tri(a, a + row, b + row);
            m.tri(a, b + row, b);
        }
    }
    m
}
