//! The lacquer of `KHR_materials_clearcoat`: a layer of index 1.5 with its own normal and roughness.

use crate::{
    bsdf::MIN_COS,
    energy::Row,
    fresnel::schlick_weight,
    ggx::{ALPHA_DELTA, Ggx, mirror},
    sampling::Frame,
};
use glam::Vec3A;

/// Reflectance of the lacquer at normal incidence: index 1.5.
const F0: f32 = 0.04;

/// The coat's lobe, grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coat {
    /// 0..1.
    coverage: f32,
    ggx: Ggx,
    mirror: bool,
    row: Row,
    /// Its frame if its normal is not the base's.
    frame: Option<Frame>,
}

impl Coat {
    /// Coverage and roughness in range; any normal: one that is not a number or points down counts as +Z.
    #[inline]
    pub fn new(coverage: f32, roughness: f32, normal: Vec3A) -> Self {
        let alpha = roughness * roughness;
        // A length whose square leaves f32 is as good as none.
        let len2 = normal.length_squared();
        let n = normal * (1.0 / len2.sqrt());
        let own = n.is_finite() && n.z > 0.0 && n.z < 1.0 - 1e-6;
        Self {
            coverage,
            ggx: Ggx::new(alpha, alpha),
            mirror: alpha < ALPHA_DELTA,
            row: Row::new(roughness),
            frame: own.then(|| Frame::from_normal(n)),
        }
    }

    /// The same as the narrowest lobe that is not perfectly specular.
    #[inline]
    pub fn blurred(mut self) -> Self {
        self.mirror = false;
        self
    }

    #[inline(always)]
    pub fn is_mirror(&self) -> bool {
        self.mirror
    }

    #[inline(always)]
    pub fn has_own_normal(&self) -> bool {
        self.frame.is_some()
    }

    /// α of the lobe.
    #[inline(always)]
    pub fn alpha(&self) -> [f32; 2] {
        self.ggx.alpha()
    }

    #[inline(always)]
    fn local(&self, w: Vec3A) -> Vec3A {
        match &self.frame {
            None => w,
            Some(f) => f.to_local(w),
        }
    }

    /// Reflectance of one microfacet with the coverage.
    #[inline(always)]
    fn fresnel(&self, weight: f32) -> f32 {
        self.coverage * (F0 + (1.0 - F0) * weight)
    }

    /// The part of the light from `w` that reaches what lies below, and the part that the lobe reflects.
    ///
    /// Like the extension takes |V · Nc|, so does this for directions behind the coat's own horizon.
    #[inline(always)]
    pub fn split(&self, w: Vec3A) -> (f32, f32) {
        let z = self.local(w).z;
        if self.mirror {
            let f = self.fresnel(schlick_weight(z.abs()));
            return (1.0 - f, if z > MIN_COS { f } else { 0.0 });
        }
        let albedo = self.row.directional(z.abs());
        let f = self.fresnel(albedo.w);
        (1.0 - f, if z > MIN_COS { f * albedo.e } else { 0.0 })
    }

    /// The part of the light from `w` that reaches what lies below.
    #[inline(always)]
    pub fn through(&self, w: Vec3A) -> f32 {
        self.split(w).0
    }

    /// Value (without the base's cosine) and density of a pair above the base.
    ///
    /// With a normal of its own the lobe meets light by the cosine to that normal, as the extension's renderers do: the base's
    /// cosine, which the caller multiplies by, is divided out.
    #[inline(always)]
    pub fn eval_pdf(&self, wo: Vec3A, wi: Vec3A) -> (f32, f32) {
        if self.mirror {
            return (0.0, 0.0);
        }
        let (o, i) = (self.local(wo), self.local(wi));
        if !(o.z > MIN_COS && i.z > MIN_COS) {
            return (0.0, 0.0);
        }
        let pair = self.ggx.pair(o, i);
        let value = self.fresnel(schlick_weight(pair.cos_half)) * pair.value;
        let value = if self.frame.is_some() { value * (i.z / wi.z) } else { value };
        if value < f32::INFINITY && pair.pdf < f32::INFINITY { (value, pair.pdf) } else { (0.0, 0.0) }
    }

    /// A direction from the lobe, or the mirror's; it may lie below the base. `None` if it lies below the coat, where
    /// another lobe's density must not stand in for this one's.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, u: [f32; 2]) -> Option<Vec3A> {
        let o = self.local(wo);
        if !(o.z > MIN_COS) {
            return None;
        }
        let i = if self.mirror { mirror(o) } else { self.ggx.sample_reflection(o, u) };
        (i.z > MIN_COS).then(|| match &self.frame {
            None => i,
            Some(f) => f.to_world(i),
        })
    }

    /// If it is a mirror that `wo` sees: the direction and the reflectance.
    #[inline(always)]
    pub fn delta(&self, wo: Vec3A) -> Option<(Vec3A, f32)> {
        if !self.mirror {
            return None;
        }
        let wi = self.sample(wo, [0.0; 2])?;
        (wi.z > MIN_COS).then(|| (wi, self.fresnel(schlick_weight(self.local(wo).z))))
    }
}
