//! The contract that every scattering function keeps.

use etendue_color::Spectrum;
use glam::Vec3A;

/// Cosines to the shading normal at or below this count as "not above the surface".
///
/// It keeps every division in this crate within `f32`; the light lost is a fraction of 1e-12 of a diffuse lobe.
pub const MIN_COS: f32 = 1e-6;

/// Which part of a surface a sample came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LobeKind {
    /// Light that entered the surface and came out again, on either side, without a preferred direction.
    Diffuse,
    /// Light mirrored or refracted by the surface or its microfacets.
    Specular,
}

/// Value and density of one pair of directions, split by lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Eval {
    /// Diffuse part of the scattering function, 1/sr, without the cosine.
    pub diffuse: Spectrum,
    /// Specular part of the scattering function, 1/sr, without the cosine; without perfectly specular parts.
    pub specular: Spectrum,
    /// Density with which `sample` draws this `wi`, per steradian, over all lobes that are not perfectly specular.
    pub pdf: f32,
}

impl Eval {
    /// No light and no density.
    pub const ZERO: Self = Self { diffuse: Spectrum::ZERO, specular: Spectrum::ZERO, pdf: 0.0 };

    /// The whole scattering function, 1/sr, without the cosine.
    #[inline(always)]
    pub fn value(&self) -> Spectrum {
        self.diffuse + self.specular
    }
}

/// One drawn direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction, unit, local frame, pointing away from the surface.
    pub wi: Vec3A,
    /// `f(wo, wi) · |cos θi| / pdf`, over all lobes (one-sample estimate): what the path's throughput is multiplied by.
    pub weight: Spectrum,
    /// The part of `weight` that diffuse lobes brought.
    pub weight_diffuse: Spectrum,
    /// The part of `weight` that specular lobes brought; `weight = weight_diffuse + weight_specular`.
    pub weight_specular: Spectrum,
    /// Density of `wi`: per steradian, over all lobes, the same number that [`Bsdf::pdf`] returns for this pair; if
    /// `delta` is set, the discrete probability with which this direction was picked.
    pub pdf: f32,
    /// True if `wi` came from a perfectly specular part: no other strategy can draw it, so it takes no part in MIS.
    pub delta: bool,
    /// The lobe that drew it.
    pub lobe: LobeKind,
}

/// A perfectly specular part of a scattering function: one direction that takes a finite part of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaPart {
    /// The only direction.
    pub wi: Vec3A,
    /// The part of the light that goes there: the factor of δ(wi) in `f · |cos θi|`.
    pub reflectance: Spectrum,
    /// Probability that `sample` picks it.
    pub probability: f32,
}

/// A scattering function in its local frame.
///
/// What holds for each verb, so that it is said once:
///
/// - `wo` and `wi` are unit, point away from the surface, and +Z is the shading normal. `wo` is where the light goes
///   to (the camera's side of a path), `wi` where it comes from.
/// - `wo.z ≤` [`MIN_COS`] gives nothing (zero, or `None`): for surfaces seen from behind the caller flips the frame, and
///   makes the closure for that side ([`crate::model::Incidence`]).
/// - `wi.z > 0` is reflection, `wi.z < 0` transmission; `|wi.z| ≤` [`MIN_COS`] gives nothing. Most surfaces let nothing
///   through; those that do say so by [`Bsdf::refraction`]. Cosines in weights are absolute.
/// - Values are finite and not negative for every input. A NaN in a direction gives zero or `None`.
/// - Quantities "per steradian" are with respect to solid angle, never projected solid angle.
/// - Perfectly specular (delta) parts are seen by `sample`, `deltas` and `albedo`, and by nothing else.
pub trait Bsdf {
    /// Value by lobe and density of a pair of directions in one pass; see [`Eval`].
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval;

    /// Draws `wi`.
    ///
    /// `uc` picks the lobe and `u` the direction within it; all in 0..1. `None` means that the drawn direction takes
    /// no light (below the horizon, for instance): the sample counts, with weight zero.
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample>;

    /// The part of the light from `wo` that is scattered anywhere: directional-hemispherical reflectance, plus
    /// transmittance where light passes.
    ///
    /// Each type says whether it is exact or an estimate; [`crate::quadrature::directional_albedo`] is always exact.
    fn albedo(&self, wo: Vec3A) -> Spectrum;

    /// The scattering function, 1/sr, without the cosine; zero for perfectly specular parts.
    #[inline]
    fn eval(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        self.eval_pdf(wo, wi).value()
    }

    /// Density with which `sample` draws `wi`, per steradian; perfectly specular parts are not in it.
    ///
    /// It integrates to one minus the probability that `sample` returns `None` or a perfectly specular direction.
    #[inline]
    fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        self.eval_pdf(wo, wi).pdf
    }

    /// The perfectly specular parts: at most a reflection and a transmission.
    #[inline]
    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        let _ = wo;
        [None, None]
    }

    /// Width of the narrowest lobe that is not perfectly specular, as GGX α along x and y; `[1, 1]` if all are wide.
    ///
    /// Numerical integration puts its nodes where this says.
    #[inline]
    fn narrowest_alpha(&self) -> [f32; 2] {
        [1.0, 1.0]
    }

    /// Whether light passes through, and where its peak lies: the index of refraction of the far side over that of the
    /// near side (of `wo`'s). 1 for thin sheets and for light that passes without a preferred direction; `None` if
    /// nothing passes.
    ///
    /// Numerical integration over the far side is done if this is there, around the direction that it gives.
    #[inline]
    fn refraction(&self) -> Option<f32> {
        None
    }
}

/// A borrowed scattering function is one: how materials that own tables become closures.
impl<B: Bsdf + ?Sized> Bsdf for &B {
    #[inline]
    fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        (**self).eval_pdf(wo, wi)
    }
    #[inline]
    fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<BsdfSample> {
        (**self).sample(wo, uc, u)
    }
    #[inline]
    fn albedo(&self, wo: Vec3A) -> Spectrum {
        (**self).albedo(wo)
    }
    #[inline]
    fn eval(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        (**self).eval(wo, wi)
    }
    #[inline]
    fn pdf(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        (**self).pdf(wo, wi)
    }
    #[inline]
    fn deltas(&self, wo: Vec3A) -> [Option<DeltaPart>; 2] {
        (**self).deltas(wo)
    }
    #[inline]
    fn narrowest_alpha(&self) -> [f32; 2] {
        (**self).narrowest_alpha()
    }
    #[inline]
    fn refraction(&self) -> Option<f32> {
        (**self).refraction()
    }
}
