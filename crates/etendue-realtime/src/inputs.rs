//! What a fragment shader has at a pixel after its texture lookups.

use etendue_bxdf::{GltfParams, sampling::Frame};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Which of the samples of glossy lobes a point takes, where several points stand for one pixel: each takes its own, and together
/// they are as fine as all. Choices without samples do not ask for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// This point's number among the pixel's, from 0.
    pub index: u32,
    /// How many points the pixel has, at least 1.
    pub of: u32,
}

impl Part {
    /// The pixel's only point.
    pub const WHOLE: Self = Self { index: 0, of: 1 };
}

/// Everything that [`crate::shade()`] needs to know of a point of a surface, in world space.
///
/// ```
/// use etendue_realtime::Inputs;
/// use glam::Vec3A;
/// let point = Inputs::new(Vec3A::ZERO, Vec3A::Y, Vec3A::Y);
/// assert_eq!(point.normal(), Vec3A::Y);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// Where it is, metres.
    pub position: Vec3A,
    /// Unit, towards the viewer: the notes' V. On the upper side of the shading normal.
    pub view: Vec3A,
    /// Normal of the triangle, unit, on the viewer's side.
    pub geometric: Vec3A,
    /// T, B and the interpolated normal before any normal map: the matrix that a normal map is multiplied with.
    pub tangent_frame: Frame,
    /// The shading frame, orthonormal: z is the shading normal (the notes' N), x the direction of anisotropy.
    pub frame: Frame,
    /// The surface after its textures. `clearcoat_normal` is in [`Inputs::frame`]. `thickness` counts in metres of world space.
    pub surface: GltfParams,
    /// The occlusion texture with its strength, 0 closed .. 1 open.
    pub occlusion: f32,
    /// Emitted radiance towards the viewer: factor × strength × texture, through any coat.
    pub emission: Spectrum,
    /// Opacity, 0..1, for blending; shading does not look at it.
    pub alpha: f32,
    /// The winding's front is seen; light that leaves a volume is seen from its back.
    pub front: bool,
    /// `KHR_materials_unlit`: the base colour is the radiance.
    pub unlit: bool,
    /// This point's share of the pixel's samples of glossy lobes.
    pub part: Part,
}

impl Inputs {
    /// A point of a flat, white, rough dielectric: `view` and `normal` unit.
    pub fn new(position: Vec3A, view: Vec3A, normal: Vec3A) -> Self {
        let frame = Frame::from_normal(normal);
        Self {
            position,
            view,
            geometric: normal,
            tangent_frame: frame,
            frame,
            surface: GltfParams::default(),
            occlusion: 1.0,
            emission: Spectrum::ZERO,
            alpha: 1.0,
            front: true,
            unlit: false,
            part: Part::WHOLE,
        }
    }

    /// The shading normal.
    #[inline(always)]
    pub fn normal(&self) -> Vec3A {
        self.frame.z
    }
}
