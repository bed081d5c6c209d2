//! The diffuse lobes: the rough base, the subsurface, and what diffuses through a sheet.

use crate::{
    bsdf::{Bsdf, Eval},
    diffuse::{Lambert, eon::Eon},
    openpbr::{OpenPbrParams, facet::Mix, index::unit},
    sampling::cosine_hemisphere,
};
use etendue_color::Spectrum;
use glam::Vec3A;

/// A diffuse lobe and its factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matte {
    pub lobe: MatteLobe,
    pub scale: Spectrum,
}

/// Without roughness EON is Lambert's lobe, at a tenth of the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MatteLobe {
    Even(Lambert),
    Rough(Eon),
}

impl MatteLobe {
    #[inline(always)]
    fn new(color: Spectrum, roughness: f32) -> Self {
        if roughness == 0.0 { Self::Even(Lambert { color }) } else { Self::Rough(Eon::new(color, roughness)) }
    }

    #[inline(always)]
    pub(super) fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> Eval {
        match self {
            Self::Even(l) => l.eval_pdf(wo, wi),
            Self::Rough(l) => l.eval_pdf(wo, wi),
        }
    }

    #[inline(always)]
    pub(super) fn sample(&self, wo: Vec3A, uc: f32, u: [f32; 2]) -> Option<Vec3A> {
        match self {
            Self::Even(_) => Some(cosine_hemisphere(u)),
            Self::Rough(l) => l.sample(wo, uc, u).map(|s| s.wi),
        }
    }

    #[inline(always)]
    pub(super) fn albedo(&self, wo: Vec3A) -> Spectrum {
        match self {
            Self::Even(l) => l.color,
            Self::Rough(l) => l.albedo(wo),
        }
    }
}

/// The diffuse lobes of what is opaque.
pub(super) fn mattes(p: &OpenPbrParams, shown: Mix) -> [Option<Matte>; 3] {
    let subsurface = unit(p.subsurface_weight);
    let sigma = unit(p.base_diffuse_roughness);
    let matte = |color: Spectrum, sigma: f32, scale: Spectrum| {
        (shown.opaque > 0.0 && !(scale * color).is_black())
            .then(|| Matte { lobe: MatteLobe::new(color, sigma), scale })
    };
    let diffuse =
        matte(p.base_color.map(unit), sigma, Spectrum::splat((1.0 - subsurface) * unit(p.base_weight)));
    let color = p.subsurface_color.map(unit);
    if !p.geometry_thin_walled {
        return [diffuse, matte(color, 0.0, Spectrum::splat(subsurface)), None];
    }
    // OpenPBR 1.1, equation "thin_wall_subsurface"; the lobes themselves are white.
    let forward = 0.5 * (1.0 + p.subsurface_scatter_anisotropy.max(-1.0).min(1.0));
    let part = |part: f32| matte(Spectrum::ONE, sigma, color * (subsurface * part));
    [diffuse, part(1.0 - forward), part(forward)]
}
