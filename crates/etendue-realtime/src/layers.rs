//! What lies over the base: lacquer (`KHR_materials_clearcoat`) and fibres (`KHR_materials_sheen`).
//!
//! What each lets through is as in [`etendue_bxdf::gltf`]: specular light from below is multiplied by the smaller of what both
//! directions are let through with, diffuse light by both over their mean.

use crate::choices::Masking;
use crate::gloss::Gloss;
use crate::surface::unit;
use etendue_bxdf::energy::Row;
use etendue_bxdf::fresnel::schlick_weight;
use etendue_bxdf::sampling::Frame;
use etendue_bxdf::sheen::{Sheen, SheenRow};
use etendue_bxdf::{Bsdf, GltfParams, MIN_COS};
use etendue_color::Spectrum;
use glam::Vec3A;

/// Reflectance of lacquer at normal incidence: index 1.5.
const COAT_F0: f32 = 0.04;

/// The lacquer's lobe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coat {
    coverage: f32,
    row: Row,
    /// Its frame within the base's, if its normal is not the base's.
    frame: Option<Frame>,
    /// Its lobe in its own frame; `None` if the viewer is behind its horizon.
    pub gloss: Option<Gloss>,
}

impl Coat {
    fn new(p: &GltfParams, wo: Vec3A, least: f32) -> Option<Self> {
        let coverage = unit(p.clearcoat);
        if !(coverage > 0.0) {
            return None;
        }
        let roughness = unit(p.clearcoat_roughness).max(least);
        let n = p.clearcoat_normal * (1.0 / p.clearcoat_normal.length_squared().sqrt());
        let own = n.is_finite() && n.z > 0.0 && n.z < 1.0 - 1e-6;
        let frame = own.then(|| Frame::from_normal(n));
        let o = frame.map_or(wo, |f| f.to_local(wo));
        let alpha = roughness * roughness;
        let gloss = (o.z > MIN_COS).then(|| Gloss::new(o, [alpha; 2]));
        Some(Self { coverage, row: Row::new(roughness), frame, gloss })
    }

    /// True if its normal is not the base's.
    pub fn is_tilted(&self) -> bool {
        self.frame.is_some()
    }

    #[inline]
    pub fn local(&self, w: Vec3A) -> Vec3A {
        self.frame.map_or(w, |f| f.to_local(w))
    }

    /// Its frame in the world, given the base's.
    #[inline]
    pub fn world_frame(&self, base: &Frame) -> Frame {
        let world = |w: Vec3A| base.x * w.x + base.y * w.y + base.z * w.z;
        self.frame.map_or(*base, |f| Frame { x: world(f.x), y: world(f.y), z: world(f.z) })
    }

    /// Reflectance at Schlick's weight `w`, with the coverage.
    #[inline]
    fn fresnel(&self, w: f32) -> f32 {
        self.coverage * (COAT_F0 + (1.0 - COAT_F0) * w)
    }

    /// Factors of A and B of the lobe's reflectance.
    #[inline]
    pub fn ends(&self) -> [f32; 2] {
        [self.coverage * COAT_F0, self.coverage]
    }

    /// What of the light from `w` gets below.
    #[inline]
    fn through(&self, w: Vec3A) -> f32 {
        let z = self.local(w).z.abs();
        let mirror = self.gloss.is_some_and(|g| g.mirror);
        1.0 - self.fresnel(if mirror { schlick_weight(z) } else { self.row.directional(z).w })
    }

    /// Value for light from `wi`, such that value × the base's cosine × irradiance is its light: it meets light by its own
    /// cosine.
    #[inline]
    pub fn eval(&self, wi: Vec3A, masking: Masking) -> f32 {
        let (Some(gloss), i) = (&self.gloss, self.local(wi)) else { return 0.0 };
        if !(i.z > MIN_COS) {
            return 0.0;
        }
        let (_, value) = gloss.lobe(i, masking);
        let f = self.fresnel(schlick_weight(0.5 * (gloss.wo + i).length()));
        let value = f * value * if self.frame.is_some() { i.z / wi.z } else { 1.0 };
        if value < f32::INFINITY { value } else { 0.0 }
    }
}

/// Fibres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fibres {
    pub lobe: Sheen,
    row: SheenRow,
    most: f32,
}

/// Lacquer over fibres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layers {
    pub coat: Option<Coat>,
    pub fibres: Option<Fibres>,
    /// What of the light from `wo` the coat lets through, and what both do.
    pub through: [f32; 2],
}

impl Layers {
    /// `None` if there are none.
    #[inline]
    pub fn new(p: &GltfParams, wo: Vec3A, least_roughness: f32) -> Option<Self> {
        let color = p.sheen_color.map(unit);
        let most = color.max_element();
        let coat = Coat::new(p, wo, least_roughness);
        let fibres = (most > 0.0).then(|| Fibres {
            lobe: Sheen::new(color, p.sheen_roughness),
            row: SheenRow::new(p.sheen_roughness),
            most,
        });
        if coat.is_none() && fibres.is_none() {
            return None;
        }
        let mut layers = Self { coat, fibres, through: [1.0; 2] };
        layers.through = layers.at(wo);
        Some(layers)
    }

    /// What of the light from `w` the coat lets through, and what both do.
    #[inline]
    pub fn at(&self, w: Vec3A) -> [f32; 2] {
        let coat = self.coat.as_ref().map_or(1.0, |c| c.through(w));
        let fibres = self.fibres.as_ref().map_or(1.0, |s| s.row.below_view(s.most, w.z.abs()));
        [coat, coat * fibres]
    }

    /// The fibres' value under the coat.
    #[inline]
    pub fn fibres_value(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        let Some(f) = &self.fibres else { return Spectrum::ZERO };
        let coat = self.coat.as_ref().map_or(1.0, |c| self.through[0].min(c.through(wi)));
        f.lobe.eval_pdf(wo, wi).diffuse * coat
    }
}
