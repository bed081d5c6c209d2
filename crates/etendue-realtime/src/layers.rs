//! What lies over the base: lacquer (`KHR_materials_clearcoat`, `KHR_materials_coat`) over fibres (`KHR_materials_sheen`), and fuzz over
//! all (`KHR_materials_fuzz`; its normal is the base's).
//!
//! What each lets through is as in [`etendue_bxdf::gltf`]: specular light from below is multiplied by the smaller of what both
//! directions are let through with, diffuse light by both over their mean; all by what a coloured lacquer absorbs and darkens, and
//! by what the fuzz leaves. For lights the directions of both ends count; for the sky the far one is the mirror's, or a mean one.

use crate::choices::Masking;
use crate::gloss::Gloss;
use crate::surface::unit;
use etendue_bxdf::energy::Row;
use etendue_bxdf::fresnel::schlick_weight;
use etendue_bxdf::gltf::{Tint, coat_f0};
use etendue_bxdf::sampling::Frame;
use etendue_bxdf::sheen::{Fuzz, Sheen, SheenRow};
use etendue_bxdf::{Bsdf, GltfParams, MIN_COS};
use etendue_color::Spectrum;
use glam::Vec3A;

/// The lacquer's lobe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coat {
    coverage: f32,
    f0: f32,
    row: Row,
    tint: Option<Tint>,
    /// Its frame within the base's, if it is not the base's.
    frame: Option<Frame>,
    tilted: bool,
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
        let alpha = roughness * roughness;
        let strength = unit(p.coat_anisotropy_strength);
        let along = alpha + (1.0 - alpha) * (strength * strength);
        let frame = if along != alpha {
            Some(Frame::from_normal_tangent(if own { n } else { Vec3A::Z }, p.coat_tangent))
        } else {
            own.then(|| Frame::from_normal(n))
        };
        let o = frame.map_or(wo, |f| f.to_local(wo));
        let gloss = (o.z > MIN_COS).then(|| Gloss::new(o, [along, alpha]));
        let row = Row::new(if along != alpha { (along * alpha).sqrt().sqrt() } else { roughness });
        Some(Self { coverage, f0: coat_f0(p.coat_ior), row, tint: Tint::new(p), frame, tilted: own, gloss })
    }

    /// True if it looks different from different azimuths.
    pub fn has_azimuths(&self) -> bool {
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
        self.coverage * (self.f0 + (1.0 - self.f0) * w)
    }

    /// Factors of A and B of the lobe's reflectance.
    #[inline]
    pub fn ends(&self) -> [f32; 2] {
        [self.coverage * self.f0, self.coverage]
    }

    /// What of the light from `w` gets below.
    #[inline]
    fn through(&self, w: Vec3A) -> f32 {
        let local = self.local(w);
        let z = local.z.abs();
        if let Some(g) = self.gloss.as_ref().filter(|g| !g.is_isotropic() && !g.mirror) {
            return 1.0 - self.fresnel(g.directional(Vec3A::new(local.x, local.y, z.max(MIN_COS))).w);
        }
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
        let value = f * value * if self.tilted { i.z / wi.z } else { 1.0 };
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

/// Fuzz on top.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Top {
    pub lobe: Fuzz,
    pub weight: f32,
}

/// Fuzz over lacquer over fibres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layers {
    pub top: Option<Top>,
    pub coat: Option<Coat>,
    pub fibres: Option<Fibres>,
    /// What the fuzz leaves to all the others.
    pub over: f32,
    /// What the lacquer leaves of mirrored and of diffuse light by its colour and darkening, wherever it comes from.
    pub tint: [Spectrum; 2],
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
        let weight = unit(p.fuzz);
        let top = (weight > 0.0).then(|| Top { lobe: Fuzz::new(p.fuzz_color, p.fuzz_roughness), weight });
        if coat.is_none() && fibres.is_none() && top.is_none() {
            return None;
        }
        let over = top.as_ref().map_or(1.0, |t| 1.0 - t.weight * t.lobe.reflectance(wo.z));
        let tint = coat
            .as_ref()
            .and_then(|c| c.tint.as_ref().map(|t| t.over(c.local(wo).z.abs())))
            .unwrap_or([Spectrum::ONE; 2]);
        let mut layers = Self { top, coat, fibres, over, tint, through: [1.0; 2] };
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

    /// What the lacquer leaves by its colour and darkening of light from `wi`.
    #[inline]
    pub fn tint_at(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        let Some(c) = &self.coat else { return Spectrum::ONE };
        let Some(t) = &c.tint else { return Spectrum::ONE };
        t.pair(c.local(wo).z.abs(), Some(c.local(wi).z.abs()))
    }

    /// The fuzz's value.
    #[inline]
    pub fn top_value(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        self.top.as_ref().map_or(Spectrum::ZERO, |t| t.lobe.eval_pdf(wo, wi).diffuse * t.weight)
    }

    /// The fibres' value under the coat.
    #[inline]
    pub fn fibres_value(&self, wo: Vec3A, wi: Vec3A) -> Spectrum {
        let Some(f) = &self.fibres else { return Spectrum::ZERO };
        let coat = self.coat.as_ref().map_or(1.0, |c| self.through[0].min(c.through(wi)));
        f.lobe.eval_pdf(wo, wi).diffuse * coat
    }
}
