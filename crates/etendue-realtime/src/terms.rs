//! What shading gives: the picture's terms, and the values on the way to them.

use etendue_color::Spectrum;
use glam::Vec3A;

/// The radiance towards the viewer by the way that it took, linear Rec.709.
///
/// Diffuse is what is scattered: matte light, sheen, diffuse transmission. Specular is what is mirrored, by the base and the coat.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// Lights, scattered.
    pub direct_diffuse: Spectrum,
    /// Lights, mirrored.
    pub direct_specular: Spectrum,
    /// The sky, scattered.
    pub indirect_diffuse: Spectrum,
    /// The sky, mirrored.
    pub indirect_specular: Spectrum,
    /// What is seen through the surface: scene, sky and lights.
    pub transmission: Spectrum,
    /// What the surface itself sends out.
    pub emission: Spectrum,
}

impl Terms {
    /// All together: the radiance towards the viewer.
    #[inline]
    pub fn sum(&self) -> Spectrum {
        (self.direct_diffuse + self.direct_specular)
            + (self.indirect_diffuse + self.indirect_specular)
            + (self.transmission + self.emission)
    }
}

/// Intermediate values, for pictures of them. Those of one light are of the brightest at the point (the first of equals).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// N: the shading normal.
    pub normal: Vec3A,
    /// T of the notes' TBN.
    pub tangent: Vec3A,
    /// B of the notes' TBN.
    pub bitangent: Vec3A,
    /// The interpolated normal of the TBN.
    pub vertex_normal: Vec3A,
    /// R: the mirror direction of V.
    pub reflection: Vec3A,
    /// N·V, 0..1.
    pub nv: f32,
    /// N·L of the brightest light, 0..1.
    pub nl: f32,
    /// V·H of the brightest light, 0..1 (the notes call it HV as well).
    pub hv: f32,
    /// D at the brightest light's half vector, 1/sr.
    pub d: f32,
    /// F at the brightest light's half vector.
    pub f: Spectrum,
    /// G = 4 NL NV × visibility for the brightest light, 0..1.
    pub g: f32,
    /// Ks: the part of the brightest light that is mirrored, F.
    pub ks: Spectrum,
    /// Kd: the factor of base colour / π for the brightest light.
    pub kd: Spectrum,
    /// Irradiance over π (a white sky gives 1), as the diffuse choice has it: what `ShadeSH9` returns.
    pub irradiance: Spectrum,
    /// Prefiltered radiance; for sampled light the mean over the lobe.
    pub prefiltered: Spectrum,
    /// Level of detail that was looked up; for sampled light the mean level of the samples.
    pub mip: f32,
    /// The reflectance's A and B: `env_brdf`.
    pub env_brdf: [f32; 2],
    /// Indirect diffuse reflectance: the factor of base colour for the sky's light.
    pub kd_indirect: Spectrum,
    /// Ambient occlusion of diffuse light.
    pub occlusion: f32,
    /// Occlusion of specular light.
    pub specular_occlusion: f32,
    /// Base colour.
    pub base_color: Spectrum,
    /// Metalness.
    pub metallic: f32,
    /// Perceptual roughness as used.
    pub roughness: f32,
    /// F0 of dielectric and metal together.
    pub f0: Spectrum,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            normal: Vec3A::ZERO,
            tangent: Vec3A::ZERO,
            bitangent: Vec3A::ZERO,
            vertex_normal: Vec3A::ZERO,
            reflection: Vec3A::ZERO,
            nv: 0.0,
            nl: 0.0,
            hv: 0.0,
            d: 0.0,
            f: Spectrum::ZERO,
            g: 0.0,
            ks: Spectrum::ZERO,
            kd: Spectrum::ZERO,
            irradiance: Spectrum::ZERO,
            prefiltered: Spectrum::ZERO,
            mip: 0.0,
            env_brdf: [0.0; 2],
            kd_indirect: Spectrum::ZERO,
            occlusion: 1.0,
            specular_occlusion: 1.0,
            base_color: Spectrum::ZERO,
            metallic: 0.0,
            roughness: 0.0,
            f0: Spectrum::ZERO,
        }
    }
}

/// A shaded point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaded {
    /// The radiance by the way that it took.
    pub terms: Terms,
    /// What was computed on the way.
    pub values: Values,
}
