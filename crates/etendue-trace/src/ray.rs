//! A ray as the caller gives it, a hit as the caller gets it, and the ray as traversal wants it.

use crate::instance::Placement;
use etendue_scene::Bounds;
use glam::Vec3A;

/// Half a unit in the last place of 1: the largest relative rounding error of one `f32` operation.
pub(crate) const UNIT: f32 = 1.0 / (1u32 << 24) as f32;

/// How far boxes are grown, in roundings of the largest coordinate in play; see the crate's documentation.
pub(crate) const BOX_ROUNDINGS: f32 = 32.0;

/// How many of those roundings a distance computed in `f32` may be off by before it is computed again in `f64`.
const DISTANCE_ROUNDINGS: f32 = 4.0;

/// A half-line or segment: the points `origin + t · direction` with `t_min < t ≤ t_max`.
///
/// The lower bound is open and the upper bound closed. The direction need not have unit length; `t` counts in its
/// lengths. A negative or NaN `t_min` counts as 0: nothing behind the origin is hit. `t_max` may be infinite.
///
/// A ray hits nothing if a component of its origin or direction is NaN or infinite, if its direction's largest
/// component is below 1e-18 or above 1e18 in size, if `t_max` is NaN or not above `t_min`, or if distances in the scene
/// along it overflow (which takes scenes or origins beyond 1e20 lengths of the direction).
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where `t` is 0, metres.
    pub origin: Vec3A,
    /// Where to; any length.
    pub direction: Vec3A,
    /// Open lower bound of `t`.
    pub t_min: f32,
    /// Closed upper bound of `t`.
    pub t_max: f32,
}

impl Ray {
    /// The ray from `origin` along `direction` with every `t > 0`.
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}

/// Where a ray meets a triangle: the point `(1 − u − v) · p0 + u · p1 + v · p2`.
///
/// `u`, `v` ≥ 0; `u + v` may exceed 1 by a rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Weight of the triangle's second vertex.
    pub u: f32,
    /// Weight of the triangle's third vertex.
    pub v: f32,
    /// Index into the scene's instances.
    pub instance: u32,
    /// Index into the instance's mesh's triangles.
    pub triangle: u32,
}

/// What a tree with instances asks of a ray's error bound.
///
/// On the way to a mesh's space and back errors grow by the transform's condition number. Instances' boxes are grown
/// for that at build, as far as coordinates up to `covered` go; rays that come from farther away add the rest.
#[derive(Clone, Copy)]
pub(crate) struct Slack {
    pub amplification: f32,
    pub covered: f32,
}

impl Slack {
    pub const NONE: Self = Self { amplification: 0.0, covered: 0.0 };

    /// For instances in a world whose largest coordinate is `reach`.
    pub fn new(placements: &[Placement], reach: f32) -> Self {
        let amplification = placements.iter().map(|p| p.amplification).fold(0.0, f32::max);
        Self { amplification, covered: 4.0 * reach }
    }
}

/// A ray made ready for one tree: reciprocals, shear and error bounds.
#[derive(Clone, Copy)]
pub(crate) struct Prepared {
    pub origin: [f32; 3],
    /// Per axis 1 if the direction is negative there: which of a box's two planes is entered first.
    pub sign: [usize; 3],
    /// Reciprocal direction, always finite.
    pub inverse: [f32; 3],
    /// The origin, moved forth (for entry planes) and back (for exit planes) by the error bound, times `inverse`.
    pub near: [f32; 3],
    pub far: [f32; 3],
    /// Axis of the direction's largest component, and the two others in the order that keeps the winding.
    pub kz: usize,
    pub kx: usize,
    pub ky: usize,
    /// Shear that takes the direction to +z (Woop, Benthin, Wald 2013, section 3.1).
    pub sx: f32,
    pub sy: f32,
    pub sz: f32,
    /// Largest error of a distance, as length along axis `kz`, that `f32` arithmetic is trusted with.
    pub tolerance: f32,
    pub t_min: f32,
}

impl Prepared {
    /// `None` if the ray hits nothing whatever the geometry.
    #[inline(always)]
    pub fn new(ray: &Ray, bounds: &Bounds, slack: &Slack) -> Option<Self> {
        let (o, d) = (ray.origin, ray.direction);
        let a = d.abs();
        let t_min = if ray.t_min > 0.0 { ray.t_min } else { 0.0 };
        let largest = a.max_element();
        let valid = o.is_finite() & d.is_finite() & (1e-18..=1e18).contains(&largest) & (ray.t_max > t_min);
        if !valid {
            return None;
        }
        // The largest coordinate that any subtraction below sees or makes.
        let reach = (bounds.min - o).abs().max((bounds.max - o).abs()).max(o.abs()).max_element();
        let pad = (reach + slack.amplification * (reach - slack.covered).max(0.0)) * (BOX_ROUNDINGS * UNIT);
        // A component that is (almost) zero is replaced by one that moves the ray by far less than `pad`.
        let tiny = largest * 1e-12;
        let nonzero = Vec3A::select(a.cmplt(Vec3A::splat(tiny)), Vec3A::splat(tiny).copysign(d), d);
        let inverse = nonzero.recip();
        let back = Vec3A::splat(pad).copysign(inverse);
        let (near, far) = ((o + back) * inverse, (o - back) * inverse);
        // Finite here, no box test below can make a NaN: at worst an infinity of the right sign.
        if !(near.is_finite() & far.is_finite()) {
            return None;
        }
        let kz = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ([1, 2, 0][kz], [2, 0, 1][kz]);
        let d = d.to_array();
        if d[kz] < 0.0 {
            (kx, ky) = (ky, kx);
        }
        Some(Self {
            origin: o.to_array(),
            sign: inverse.to_array().map(|x| (x < 0.0) as usize),
            inverse: inverse.to_array(),
            near: near.to_array(),
            far: far.to_array(),
            kz,
            kx,
            ky,
            sx: d[kx] / d[kz],
            sy: d[ky] / d[kz],
            sz: 1.0 / d[kz],
            tolerance: reach * (DISTANCE_ROUNDINGS * UNIT),
            t_min,
        })
    }
}
