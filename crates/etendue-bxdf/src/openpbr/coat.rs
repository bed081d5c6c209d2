//! The coat: a layer of varnish that reflects, absorbs, and darkens what lies under it.

use super::{
    OpenPbrParams,
    index::{anisotropic_alpha, index, unit},
    lobe::{Lobe, Seen},
};
use crate::{
    bsdf::MIN_COS,
    fresnel::dielectric,
    ggx::ALPHA_DELTA,
    varnish::{Under, Varnish},
};
use etendue_color::Spectrum;
use glam::{Mat3A, Vec3A};

/// The coat's lobe and what it does to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coat {
    /// Coverage, above 0.
    pub weight: f32,
    pub lobe: Lobe,
    /// From the base's frame to the coat's; `None` if they are the same.
    frame: Option<Mat3A>,
    eta: f32,
    varnish: Varnish,
}

/// The coat from one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct CoatView {
    /// The direction in the coat's frame.
    pub wo: Vec3A,
    /// Factor of the lobe's value: coverage and compensation.
    pub scale: f32,
    /// The part of the light that the coat reflects, times its coverage.
    pub albedo: f32,
    /// 1 − albedo of the covered part.
    pub through: f32,
    /// 1/µ of the direction within the coat.
    pub longer: f32,
    /// Factor of the base by darkening.
    pub darkening: Spectrum,
}

/// The frame of a tilted coat: rows are its tangent, bitangent and normal. `None` if it is the base's own.
fn tilted(normal: Vec3A, tangent: Vec3A) -> Option<Mat3A> {
    let n = normal.try_normalize().filter(|n| n.z > MIN_COS).unwrap_or(Vec3A::Z);
    let t = tangent - n * n.dot(tangent);
    let t = t.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
    if n == Vec3A::Z && t == Vec3A::X {
        return None;
    }
    Some(Mat3A::from_cols(t, n.cross(t), n).transpose())
}

impl Coat {
    /// `None` if there is no coat. `outside` is the index of the surroundings.
    #[inline]
    pub fn new(p: &OpenPbrParams, outside: f32, under: Under) -> Option<Self> {
        let weight = unit(p.coat_weight);
        if weight == 0.0 {
            return None;
        }
        let eta = index(p.coat_ior) / outside;
        let frame = tilted(p.geometry_coat_normal, p.geometry_coat_tangent);
        let mut alpha = anisotropic_alpha(p.coat_roughness, p.coat_roughness_anisotropy);
        // A tilted mirror would be a second perfectly specular reflection beside the base's: it is the narrowest lobe
        // instead.
        if frame.is_some_and(|m| m.z_axis != Vec3A::Z) {
            alpha[0] = alpha[0].max(1.01 * ALPHA_DELTA);
        }
        let color = p.coat_color.map(unit);
        Some(Self {
            weight,
            lobe: Lobe::new(alpha),
            frame,
            eta,
            varnish: Varnish::new(eta, color, under, weight * unit(p.coat_darkening)),
        })
    }

    /// True if its frame is not the base's.
    #[inline(always)]
    pub fn has_frame(&self) -> bool {
        self.frame.is_some()
    }

    /// True if its normal is not the base's.
    #[inline(always)]
    pub fn is_tilted(&self) -> bool {
        self.frame.is_some_and(|m| m.z_axis != Vec3A::Z)
    }

    /// A direction in the coat's frame.
    #[inline(always)]
    pub fn local(&self, w: Vec3A) -> Vec3A {
        match &self.frame {
            None => w,
            Some(m) => *m * w,
        }
    }

    /// A direction of the coat's frame in the base's.
    #[inline(always)]
    pub fn base_direction(&self, w: Vec3A) -> Vec3A {
        match &self.frame {
            None => w,
            Some(m) => m.transpose() * w,
        }
    }

    #[inline(always)]
    pub fn fresnel(&self, cos: f32) -> f32 {
        dielectric(cos, self.eta)
    }

    /// 1/µ within the coat for a cosine outside.
    #[inline(always)]
    pub fn longer(&self, cos: f32) -> f32 {
        self.varnish.longer(cos)
    }

    /// What is left of light that crosses the coat over `crossings` times its thickness.
    #[inline(always)]
    pub fn transmittance(&self, crossings: f32) -> Spectrum {
        self.varnish.transmittance(crossings)
    }

    /// The coat seen from `wo` of the base's frame.
    #[inline(always)]
    pub fn view(&self, wo: Vec3A) -> CoatView {
        let local = self.local(wo);
        if !(local.z > MIN_COS) {
            // A tilted coat seen from behind: the base alone.
            return CoatView {
                wo: local,
                scale: 0.0,
                albedo: 0.0,
                through: 1.0,
                longer: self.longer(wo.z),
                darkening: self.varnish.darkened(self.fresnel(wo.z)),
            };
        }
        let seen: Seen = self.lobe.seen(local);
        let [mean] = seen.mean(|cos| [Spectrum::splat(self.fresnel(cos))]);
        let compensation = seen.compensation(mean)[0];
        let albedo = (seen.e * mean[0] * compensation).min(1.0);
        CoatView {
            wo: local,
            scale: self.weight * compensation,
            albedo: self.weight * albedo,
            through: (1.0 - albedo - seen.slack).max(0.0),
            longer: self.longer(local.z),
            darkening: self.varnish.darkened(self.fresnel(local.z)),
        }
    }

    /// Factor of what the base scatters from one direction to another, given 1/µ of both within the coat: uncovered and
    /// covered part, without the darkening.
    #[inline(always)]
    pub fn over(&self, view: &CoatView, crossings: f32) -> Spectrum {
        let covered = self.transmittance(crossings) * view.through;
        Spectrum::splat(1.0 - self.weight) + covered * self.weight
    }
}
