//! What a closure must know of the place where light meets it.

use etendue_color::Spectrum;

/// What a path carries, which decides how a refracted value scales.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Transport {
    /// Radiance, along paths from the camera: compressed by the squared ratio of indices where a path is refracted (Veach
    /// 1997, "Robust Monte Carlo Methods for Light Transport Simulation", section 5.2).
    #[default]
    Radiance,
    /// Importance's adjoint, power, along paths from a light: not compressed.
    Importance,
}

/// The side from which a surface is seen, and what lies there.
///
/// A closure is always asked with `wo.z > 0`: a surface seen from behind has its frame turned over, and `front` false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incidence {
    /// True if `wo` lies outside: on the side that the surface's winding calls its front.
    pub front: bool,
    /// Index of refraction of what surrounds the object (not of what is inside it): 1 for air.
    pub exterior_ior: f32,
    /// What the path carries.
    pub transport: Transport,
    /// The only lane of light that the path still carries, if a dispersive medium split it; `None` before.
    pub lane: Option<u8>,
}

impl Default for Incidence {
    /// Seen from outside, in air, by the camera.
    fn default() -> Self {
        Self { front: true, exterior_ior: 1.0, transport: Transport::Radiance, lane: None }
    }
}

/// How a homogeneous medium scatters what does not go straight on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// The part of it that is scattered and not absorbed: single-scattering albedo, each lane 0..1.
    pub albedo: Spectrum,
    /// Mean cosine of the angle by which light is turned, −1 back .. 1 straight on (Henyey, Greenstein 1941).
    pub anisotropy: f32,
}

/// What fills the space behind a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    /// Index of refraction.
    pub ior: f32,
    /// What goes straight on, per metre: it is multiplied by exp(−absorption · distance) (Bouguer, Beer, Lambert). What is lost is
    /// absorbed, or scattered if `scatter` is there.
    pub absorption: Spectrum,
    /// How it scatters; `None` if it does not.
    pub scatter: Option<Scatter>,
    /// Where two media overlap the one with the larger priority fills the space (Schmidt, Budge 2002, "Simple Nested
    /// Dielectrics in Ray Traced Images").
    pub priority: i32,
    /// True if the index differs by lane: a path that enters must choose one ([`Incidence::lane`]).
    pub dispersive: bool,
}
